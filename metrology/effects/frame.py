"""A frame behind the line, with a mode of its own; under dead loads, its compliance alone."""

import math
from collections.abc import Container

from metrology.effect import INF, Cause, Effect, Parameter, Readings, Scales, Size

QUICK = 400.0
"""Angular frequency / (rad/s) from which on no second mode is tried: it follows the line then as one without mass."""
ABOVE = 1.3
"""Frequency over that of the rig from which on a second mode is tried as a frame, below it as a yaw."""
RINGS = 0.03
"""Damping ratio at which a second mode is tried."""


def modes(low: float, high: float, known: Scales) -> list[float]:
    """Angular frequencies of a second mode, so close that one of them leads to the right one.

    A quarter of a turn apart from one contact to the next, or as far as its resonance is wide.
    """
    found = [low]
    while found[-1] < min(high, QUICK):
        found.append(found[-1] + max(math.pi / (2 * known["gap"]), 2 * RINGS * found[-1]))
    return found[:-1]


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Modes above the frequency of the rig."""
    frequencies = modes(ABOVE * known["omega"], 30.0 * known["omega"], known)
    return [{"frame.frequency": one, "frame.damping": RINGS} for one in frequencies]


def limits(known: Scales) -> dict[str, tuple[float, float]]:
    """Softer than the line by three at most, faster than the rig."""
    omega = known["omega"]
    fastest = max(min(QUICK, 30 * omega), known["highest"], 1.2 * omega)
    return {
        "frame.compliance": (0.0, 3 / known["k"]),
        "frame.frequency": (1.1 * omega, fastest),
        "frame.damping": (0.0, 0.5),
    }


def as_yaw(values: Scales, known: Scales) -> dict[str, float]:
    """Yaw with the same equations: r²/J = ω²·C."""
    omega = values["frame.frequency"]
    arm = omega * math.sqrt(values["frame.compliance"] * known["inertia"])
    return {"yaw.arm": arm, "yaw.frequency": omega, "yaw.damping": values["frame.damping"]}


def reading(seen: Readings):
    """C·F."""
    return seen.force


EFFECT = Effect(
    name="frame",
    title="Frame in series with a mode of its own",
    equation="u″ + 2·ζ_f·ω_f·u′ + ω_f²·u = ω_f²·C_f·T, e = x − x_t − u",
    parameters=(
        Parameter("frame.compliance", "C_f", "m/N", 0.0, 0.0, INF, (0.0, 1e-3), 1e-7, "static compliance of the frame"),
        Parameter("frame.frequency", "ω_f", "rad/s", 1190.0, 1e-3, INF, (10.0, 1e4), 10.0,
                  "natural frequency of the frame"),
        Parameter("frame.damping", "ζ_f", "1", 0.02, 0.0, INF, (0.0, 0.5), 1e-3, "damping ratio of the frame"),
    ),
    sign="ringing in T after a snatch that x does not show",
    source="Den Hartog, Mechanical Vibrations (1956), 3.1",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "frame", ("frame.compliance", "frame.frequency", "frame.damping"),
            consequence="k comes out too small by the factor 1/(1 + C_f·k)",
            advice="stiffen the frame; measure elongation at the specimen",
            separate="a tap test of the mount with an accelerometer",
            pictures=("loop",), amount=lambda known: 0.02 / max(known["k"], 1.0), shapes=shapes, limits=limits,
            equivalent=("yaw", as_yaw),
        ),
        Cause(
            "elongation", "frame", (Size("frame.compliance", "m/N", 0.0, 0.0, INF, 1e-7),),
            title="Frame and clamps in series",
            equation="x = … + C·F",
            sign="none: it is exactly a lower k",
            consequence="k and E come out too small by 1/(1 + C·k)",
            advice="measure at the specimen, not at the frame",
            separate="an indicator on the mount under the same loads, or a specimen of another length: x/F against "
            "length has C as its intercept",
            pictures=("load",), amount=lambda seen: seen.u / seen.most, reading=reading,
            alone="it is exactly a lower k",
        ),
    ),
)  # fmt: skip
