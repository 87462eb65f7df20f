"""A line that goes slack on one side of the motion, or one of several lines: a mass that hangs on it and swings far."""

from collections.abc import Container

from metrology.effect import INF, Cause, Effect, Parameter, Scales


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Either side, where a third of the swing is beyond."""
    return [{"slack.place": side * 0.7 * known["e"], "slack.damping": 0.5} for side in (1, -1)]


def limits(known: Scales) -> dict[str, tuple[float, float]]:
    """Within the largest motion on either side; of the damping all at most."""
    return {"slack.place": (-known["e"], known["e"]), "slack.damping": (0.0, 1.0)}


EFFECT = Effect(
    name="slack",
    title="Line that goes slack on one side",
    equation="T = k·e + c·e′ − s·(k·(e − e_s) + q·c·e′) beyond e_s",
    parameters=(
        Parameter("slack.share", "s", "1", 0.0, 0.0, 1.0, (0.0, 1.0), 1e-2, "part of the line that goes slack"),
        Parameter("slack.place", "e_s", "m", 1e-3, -INF, INF, (-1.0, 1.0), 1e-3,
                  "elongation from the rest position at which it does; under a hanging mass −m·g/k"),
        Parameter("slack.damping", "q", "1", 1.0, 0.0, INF, (0.0, 1.0), 1e-2,
                  "part of the damping that the line has; the air has the rest"),
    ),
    sign="frequency and decay rate rise as the amplitude falls, until the line no longer goes slack; the middle of the "
    "motion moves",
    source="Shaw & Holmes, J. Sound Vib. 90 (1983) 129 (a periodically forced piecewise linear oscillator)",
    acts="line", built_in=True,
    causes=(
        Cause(
            "decay", "slack", ("slack.share", "slack.place", "slack.damping"),
            consequence="k and c come out too small",
            advice="release it from less than m·g/k, or pull the line tighter",
            separate="a release from less than e_s: the frequency stays the same at every amplitude",
            pictures=("frequency",), amount=0.02, shapes=shapes, limits=limits,
        ),
    ),
)  # fmt: skip
