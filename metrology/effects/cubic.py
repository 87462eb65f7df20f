"""A line that hardens or softens either way alike."""

from metrology.effect import INF, Cause, Effect, Parameter, Size


def tension(e, stiffness):
    """k₃·ε³."""
    return stiffness * e * e * e


def slope(e, stiffness):
    """3·k₃·ε²."""
    return 3.0 * stiffness * e * e


EFFECT = Effect(
    name="cubic",
    title="Cubic hardening or softening",
    equation="T = k·ε + k₃·ε³",
    parameters=(
        Parameter("cubic.stiffness", "k₃", "N/m³", 0.0, -INF, INF, (-1e12, 1e12), 1.0, "cubic stiffness", linear=False),
    ),
    sign="frequency depends on amplitude; curved T against elongation",
    source="Duffing; Nayfeh & Mook, Nonlinear Oscillations (1979), 4.1",
    acts="line", tension=tension, slope=slope,
    causes=(
        Cause(
            "response", "cubic", ("cubic.stiffness",),
            consequence="k is a mean over the amplitude: it differs from the stiffness at small loads",
            advice="state k with its range of load, or give k and k₃",
            separate="static loading in steps over the same range",
            pictures=("force-elongation", "frequency"), amount=lambda known: 0.02 * known["k"] / known["e"] ** 2,
        ),
        Cause(
            "decay", "cubic", (Size("cubic.stiffness", "N/m³", 0.0, -INF, INF, 1e6),),
            title="Amplitude-dependent frequency (hardening or softening)",
            equation="m·x″ + c·x′ + k·x + k₃·x³ = 0",
            sign="the frequency moves with the square of the amplitude; a line at three times the frequency",
            consequence="ω_n and the dynamic k are those of a mean amplitude A, k off by 3·k₃·A²/4; "
            "c by half that share",
            advice="state k and c with their amplitude, or extrapolate to none",
            separate="elongation in steps over the same extension, or releases from several amplitudes",
            pictures=("frequency", "force-elongation"), amount=lambda known: 1e-3 * known["k"] / known["e"] ** 2,
            law="hardening or softening",
        ),
    ),
)  # fmt: skip
