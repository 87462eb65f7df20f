"""Names of the causes that a method of diagnosis may give, by kind of test, and the steps of the verdict."""

NAMES: dict[str, tuple[str, ...]] = {
    "response": (
        "cell drift", "cell gain", "cell zero", "clock T", "clock v", "clock x", "cubic", "damping", "drag",
        "even stiffness",
        "frame", "free length", "friction", "gain drift", "hum T", "hum v", "hum x", "hysteresis", "line damping",
        "mass",
        "motion scale", "pendulum", "quadratic drag", "sag", "setup", "slip", "thrust delay", "thrust gain",
        "thrust lag",
        "tilt", "toe", "yaw", "zener",
    ),
    "decay": (
        "cubic", "damping", "drift", "even stiffness", "friction", "line damping", "mains", "other", "pendulum",
        "quadratic drag", "setup",
    ),
    "elongation": (
        "backlash", "creep", "curvature", "drift", "exchange", "frame", "load", "misread", "mounting",
        "saturation", "slip", "toe",
    ),
}  # fmt: skip
LATER = {
    "decay": {"asymmetric damping", "cubic reading", "hop", "quadratic reading", "slack", "stop"},
    "elongation": {"hysteresis", "initial tension"},
    "response": {"appendage", "asymmetric damping", "cell lag", "hop", "hose", "second branch", "thrust fading"},
}
"""Names that this package has had since the table was frozen: they are unlisted here."""
STEPS = (
    "nothing missing",
    "explained",
    "explained in the main",
    "ambiguous",
    "unexplained",
    "not testable",
    "not finished",
)
"""What a method may say. *Not finished* is an answer, but never the right one."""
