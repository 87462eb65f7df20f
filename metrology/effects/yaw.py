"""The line is off the centre of mass: a second mode, slower than the rig."""

import math
from collections.abc import Container

from metrology.effect import INF, Cause, Effect, Parameter, Scales, Size
from metrology.effects.frame import ABOVE, RINGS, modes


def shapes(known: Scales, among: Container[str]) -> list[dict[str, float]]:
    """Modes below those that are tried as a frame, where that is a candidate too."""
    slowest, fastest = 0.25 * known["omega"], (ABOVE if "frame" in among else 5.0) * known["omega"]
    return [{"yaw.frequency": one, "yaw.damping": RINGS} for one in modes(slowest, fastest, known)]


def limits(known: Scales) -> dict[str, tuple[float, float]]:
    """Arms within three radii of gyration."""
    return {
        "yaw.arm": (0.0, 3 * math.sqrt(known["inertia"] / known["m"])),
        "yaw.frequency": (0.1 * known["omega"], 10 * known["omega"]),
        "yaw.damping": (0.0, 0.5),
    }


def as_frame(values: Scales, known: Scales) -> dict[str, float]:
    """Frame with the same equations: ω²·C = r²/J."""
    omega = values["yaw.frequency"]
    compliance = (values["yaw.arm"] / omega) ** 2 / known["inertia"]
    return {"frame.compliance": compliance, "frame.frequency": omega, "frame.damping": values["yaw.damping"]}


EFFECT = Effect(
    name="yaw",
    title="Yaw of the module, the line being off its centre of mass",
    equation="J·φ″ + 2·ζ_y·ω_y·J·φ′ + ω_y²·J·φ = r·T, e = x − x_t − r·φ",
    parameters=(
        Parameter("yaw.arm", "r", "m", 0.0, -INF, INF, (-0.3, 0.3), 1e-3,
                  "distance of the line from the centre of mass"),
        Parameter("yaw.inertia", "J", "kg·m²", 1.0, 1e-9, INF, (0.01, 100.0), 0.1,
                  "moment of inertia about the vertical"),
        Parameter("yaw.frequency", "ω_y", "rad/s", 0.5, 0.0, INF, (0.0, 100.0), 0.01, "natural frequency of the yaw"),
        Parameter("yaw.damping", "ζ_y", "1", 0.02, 0.0, INF, (0.0, 1.0), 1e-3, "damping ratio of the yaw"),
    ),
    sign="a second, slower beat in T; the snatch is softer than k says",
    source="two degrees of freedom; Den Hartog, Mechanical Vibrations (1956), 3.1",
    acts="line", straight=True, built_in=True,
    causes=(
        Cause(
            "response", "yaw",
            (  # A line to the left of the centre of mass pulls like one to the right. Ranges as wide as a frame's.
                Size("yaw.arm", "m", 0.0, 0.0, INF, 1e-3, power=2),
                Size("yaw.frequency", "rad/s", 0.5, 0.1, 100.0, 0.01, True),
                Size("yaw.damping", "1", 0.02, 0.0, 0.5, 1e-3, True),
            ),
            consequence="k comes out too small, with a second beat; only r²/J shows: r is that of the stated moment of "
            "inertia",
            advice="move the line to the centre of mass",
            separate="a marker on the side of the module shows the angle; where it shows none, a load that swings on "
            "the module acts much alike",
            pictures=("loop",), amount=lambda known: 0.1 * math.sqrt(known["inertia"] / known["m"]), shapes=shapes,
            limits=limits, equivalent=("frame", as_frame),
        ),
    ),
)  # fmt: skip
