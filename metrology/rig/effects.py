"""What the rig can carry beyond the base model: a table of effects, each with a null at which it vanishes exactly."""

from __future__ import annotations

from dataclasses import dataclass

from metrology.rig.parameters import BASE, INF, Parameter


@dataclass(frozen=True)
class Effect:
    """One way in which a real rig departs from the base model.

    Parameters
    ----------
    name : str
        First half of the names of its parameters.
    title : str
        As a report prints it.
    equation : str
        Its term, in the symbols of ``docs/model.md``.
    parameters : tuple of Parameter
        The first one is its size: at its null the effect vanishes, whatever the others are. Where `sizes` is above 1,
        as many of the first parameters are sizes, each of which acts by itself.
    sign : str
        How one sees it in a measurement.
    source : str
        Where the equation stands.
    sizes : int
        Number of sizes.
    linear : bool
        True where the equation of motion stays linear between events, so that its solution is exact.
    """

    name: str
    title: str
    equation: str
    parameters: tuple[Parameter, ...]
    sign: str
    source: str
    sizes: int = 1
    linear: bool = True


P = Parameter

EFFECTS = (
    Effect(
        "mass",
        "Mass of the module off its stated value",
        "m → μ·m",
        (P("mass.factor", "μ", "1", 1.0, 1e-6, INF, (0.8, 1.25), 0.01, "true mass over stated mass"),),
        "acceleration under thrust, slack, off by one factor; frequency off by its root",
        "JCGM 100:2008, 3.2.3 (systematic effect)",
    ),
    Effect(
        "free_length",
        "Free length off its stated value",
        "x_t → x_t + δ",
        (P("free_length.shift", "δ", "m", 0.0, -INF, INF, (-0.05, 0.05), 1e-4, "true minus stated taut position"),),
        "first tension earlier or later than the position says",
        "JCGM 100:2008, 3.2.3 (systematic effect)",
    ),
    Effect(
        "friction",
        "Coulomb friction with stiction",
        "F = −F_c·sign(v) when sliding; v = 0 while |net force| ≤ σ·F_c",
        (
            P("friction.force", "F_c", "N", 0.0, 0.0, INF, (0.0, 0.5), 1e-3, "friction when sliding"),
            P(
                "friction.static_ratio",
                "σ",
                "1",
                1.0,
                1.0,
                INF,
                (1.0, 2.0),
                0.05,
                "largest sticking over sliding force",
            ),
        ),
        "amplitude falls by the same amount each half period, then the module sticks",
        "Den Hartog, Trans. ASME 53 (1931) 107",
    ),
    Effect(
        "drag",
        "Viscous and quadratic drag on the module",
        "F = −b·v − b₂·v·|v|",
        (
            P("drag.viscous", "b", "N·s/m", 0.0, 0.0, INF, (0.0, 5.0), 0.01, "viscous drag"),
            P("drag.quadratic", "b₂", "N·s²/m²", 0.0, 0.0, INF, (0.0, 100.0), 0.1, "quadratic drag"),
        ),
        "slack coast slows in proportion to v, or to v²; decay rate grows with amplitude for the latter",
        "Nayfeh & Mook, Nonlinear Oscillations (1979), 3.3",
        sizes=2,
        linear=False,
    ),
    Effect(
        "tilt",
        "Table out of level",
        "F = m·g·sin θ",
        (P("tilt.angle", "θ", "rad", 0.0, -1.5, 1.5, (-5e-3, 5e-3), 1e-5, "slope, downhill towards growing x"),),
        "a constant acceleration, thrust on or off",
        "Newton's second law on an inclined plane",
    ),
    Effect(
        "setup",
        "Compliance of the set-up in series, massless",
        "e = ε + C·T, so that k → k/(1 + C·k), c → c/(1 + C·k)²",
        (P("setup.compliance", "C", "m/N", 0.0, 0.0, INF, (0.0, 1e-3), 1e-7, "compliance of mount and load cell"),),
        "stiffness lower than the line's own, most for the stiffest line",
        "ASTM E111-17, 9 (compliance of the machine); springs in series",
    ),
    Effect(
        "frame",
        "Frame in series with a mode of its own",
        "u″ + 2·ζ_f·ω_f·u′ + ω_f²·u = ω_f²·C_f·T, e = x − x_t − u",
        (
            P("frame.compliance", "C_f", "m/N", 0.0, 0.0, INF, (0.0, 1e-3), 1e-7, "static compliance of the frame"),
            P(
                "frame.frequency",
                "ω_f",
                "rad/s",
                1190.0,
                1e-3,
                INF,
                (10.0, 1e4),
                10.0,
                "natural frequency of the frame",
            ),
            P("frame.damping", "ζ_f", "1", 0.02, 0.0, INF, (0.0, 0.5), 1e-3, "damping ratio of the frame"),
        ),
        "ringing in T after a snatch that x does not show",
        "Den Hartog, Mechanical Vibrations (1956), 3.1",
    ),
    Effect(
        "cubic",
        "Cubic hardening or softening",
        "T = k·ε + k₃·ε³",
        (P("cubic.stiffness", "k₃", "N/m³", 0.0, -INF, INF, (-1e12, 1e12), 1.0, "cubic stiffness"),),
        "frequency depends on amplitude; curved T against elongation",
        "Duffing; Nayfeh & Mook, Nonlinear Oscillations (1979), 4.1",
        linear=False,
    ),
    Effect(
        "toe",
        "Toe region: soft at first, then the full stiffness",
        "T = r·k·ε up to ε_t, T = k·(ε − (1 − r)·ε_t) beyond",
        (
            P("toe.extent", "ε_t", "m", 0.0, 0.0, INF, (0.0, 0.05), 1e-5, "elongation at which the toe ends"),
            P("toe.ratio", "r", "1", 0.5, 1e-3, 1e3, (0.05, 1.0), 0.01, "stiffness in the toe over full stiffness"),
        ),
        "two slopes in T against elongation with one knee",
        "ASTM D638-14, annex A1 (toe compensation)",
    ),
    Effect(
        "zener",
        "Zener relaxation",
        "T = k·ε + k₁·(ε − z), z′ = (ε − z)/τ",
        (
            P("zener.stiffness", "k₁", "N/m", 0.0, 0.0, INF, (0.0, 1e5), 0.1, "stiffness of the relaxing branch"),
            P("zener.time", "τ", "s", 1.0, 1e-6, INF, (1e-3, 1e3), 0.01, "relaxation time"),
        ),
        "tension falls at constant elongation; stiffer when fast",
        "Zener, Elasticity and Anelasticity of Metals (1948), V",
    ),
    Effect(
        "damping",
        "Line damping that grows with amplitude",
        "T = k·ε + (c + c₁·|ε|)·ε′",
        (P("damping.amplitude", "c₁", "N·s/m²", 0.0, 0.0, INF, (0.0, 1e6), 1.0, "damping per elongation"),),
        "decay rate grows with amplitude, in the line only",
        "Nayfeh & Mook, Nonlinear Oscillations (1979), 3.3",
        linear=False,
    ),
    Effect(
        "hysteresis",
        "Bouc–Wen hysteresis",
        "T = k·ε + k_h·h, h′ = ε′·(1 − ½·(1 + sign(ε′·h))·|h/h_y|)",
        (
            P("hysteresis.stiffness", "k_h", "N/m", 0.0, 0.0, INF, (0.0, 1e5), 0.1, "stiffness of the yielding branch"),
            P("hysteresis.yield", "h_y", "m", 1e-3, 1e-12, INF, (1e-6, 0.1), 1e-5, "elongation at which it yields"),
        ),
        "a loop in T against elongation that stays open however slow",
        "Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249",
        linear=False,
    ),
    Effect(
        "sag",
        "Sag of the line as an elastic catenary",
        "e = ε − s·(1 − asinh(w)/w), w = q·s/(2·T)",
        (P("sag.weight", "q_s", "N/m", 0.0, 0.0, INF, (0.0, 1.0), 1e-4, "weight per length of the sagging line"),),
        "soft at low tension: the tangent stiffness grows as T³",
        "Irvine, Cable Structures (1981), 2.3",
        linear=False,
    ),
    Effect(
        "thrust",
        "Thrust off its command: gain, lag, delay",
        "F = (G·F_cmd(t − t_d) − F_lagged)/τ_F filtered at first order",
        (
            P("thrust.gain", "G", "1", 1.0, -INF, INF, (0.8, 1.25), 0.01, "true over commanded force"),
            P("thrust.lag", "τ_F", "s", 0.0, 0.0, INF, (0.0, 1.0), 1e-3, "time constant of the rise"),
            P("thrust.delay", "t_d", "s", 0.0, -INF, INF, (-0.5, 0.5), 1e-3, "dead time of the thrusters"),
        ),
        "velocity in the slack phase off by a factor (gain), or late (lag, delay)",
        "first-order lag with dead time",
        sizes=3,
    ),
    Effect(
        "slip",
        "Clamp slip at the first peak",
        "x_t → x_t + Δ from the first turn of the taut line on",
        (P("slip.set", "Δ", "m", 0.0, 0.0, INF, (0.0, 0.02), 1e-5, "permanent set"),),
        "tension drops at the first peak; taut position moves once",
        "ISO 527-1:2019, 9.3 (slip in the grips)",
    ),
    Effect(
        "yaw",
        "Yaw of the module, the line being off its centre of mass",
        "J·φ″ + 2·ζ_y·ω_y·J·φ′ + ω_y²·J·φ = r·T, e = x − x_t − r·φ",
        (
            P("yaw.arm", "r", "m", 0.0, -INF, INF, (-0.3, 0.3), 1e-3, "distance of the line from the centre of mass"),
            P("yaw.inertia", "J", "kg·m²", 1.0, 1e-9, INF, (0.01, 100.0), 0.1, "moment of inertia about the vertical"),
            P("yaw.frequency", "ω_y", "rad/s", 0.5, 0.0, INF, (0.0, 100.0), 0.01, "natural frequency of the yaw"),
            P("yaw.damping", "ζ_y", "1", 0.02, 0.0, INF, (0.0, 1.0), 1e-3, "damping ratio of the yaw"),
        ),
        "a second, slower beat in T; the snatch is softer than k says",
        "two degrees of freedom; Den Hartog, Mechanical Vibrations (1956), 3.1",
    ),
    Effect(
        "cell",
        "Load cell: gain, zero, drift",
        "T_read = γ·T + T₀ + T₁·(t − t₀)",
        (
            P("cell.gain", "γ", "1", 1.0, -INF, INF, (0.8, 1.25), 0.01, "reading over force"),
            P("cell.zero", "T₀", "N", 0.0, -INF, INF, (-1.0, 1.0), 1e-3, "reading without force"),
            P("cell.drift", "T₁", "N/s", 0.0, -INF, INF, (-0.01, 0.01), 1e-5, "drift of the zero"),
        ),
        "T is not m times the change of acceleration; T is not zero when slack",
        "ISO 376:2011, 7 and 8",
        sizes=3,
    ),
    Effect(
        "motion",
        "Motion capture: scale",
        "x_read = κ·x, v_read = κ·v",
        (P("motion.scale", "κ", "1", 1.0, -INF, INF, (0.9, 1.1), 1e-3, "reading over length"),),
        "x and v off by one factor",
        "JCGM 100:2008, F.2.2",
    ),
    Effect(
        "clock",
        "Clocks of the channels apart",
        "a sample stamped t was taken at t − δt",
        (
            P("clock.x", "δt_x", "s", 0.0, -INF, INF, (-0.2, 0.2), 1e-4, "stamp minus true time, position"),
            P("clock.v", "δt_v", "s", 0.0, -INF, INF, (-0.2, 0.2), 1e-4, "stamp minus true time, velocity"),
            P("clock.T", "δt_T", "s", 0.0, -INF, INF, (-0.2, 0.2), 1e-4, "stamp minus true time, tension"),
        ),
        "residual of a channel looks like its time derivative",
        "JCGM 100:2008, F.2.3",
        sizes=3,
    ),
    Effect(
        "hum",
        "Mains or line vibration in a channel",
        "y_read = y + a·sin(2π·f·t + ψ)",
        (
            P("hum.x", "a_x", "m", 0.0, -INF, INF, (0.0, 0.01), 1e-5, "amplitude in position"),
            P("hum.v", "a_v", "m/s", 0.0, -INF, INF, (0.0, 0.1), 1e-5, "amplitude in velocity"),
            P("hum.T", "a_T", "N", 0.0, -INF, INF, (0.0, 1.0), 1e-4, "amplitude in tension"),
            P("hum.frequency", "f", "Hz", 50.0, 1e-6, INF, (0.1, 1e3), 0.01, "frequency"),
            P("hum.phase", "ψ", "rad", 0.0, -INF, INF, (-3.2, 3.2), 0.01, "phase at t = 0"),
        ),
        "a line in the spectrum of the residual",
        "JCGM 100:2008, F.2.4.2",
        sizes=3,
    ),
    Effect(
        "start",
        "Start state off its stated value",
        "x₀ → x₀ + δx, v₀ → v₀ + δv",
        (
            P("start.x", "δx", "m", 0.0, -INF, INF, (-0.05, 0.05), 1e-4, "true minus stated start position"),
            P("start.v", "δv", "m/s", 0.0, -INF, INF, (-0.05, 0.05), 1e-4, "true minus stated start velocity"),
        ),
        "the first slack phase is displaced as a whole",
        "JCGM 100:2008, 3.2.3 (systematic effect)",
        sizes=2,
    ),
)
"""Every effect that the equation of motion carries."""

PARAMETERS: dict[str, Parameter] = {
    entry.name: entry for entry in (*BASE, *(one for effect in EFFECTS for one in effect.parameters))
}
"""Every parameter by its name, in the order of the kernel's vector."""

NAMES: tuple[str, ...] = tuple(PARAMETERS)
INDEX: dict[str, int] = {name: at for at, name in enumerate(NAMES)}
READINGS = ("cell", "motion", "clock", "hum")
UNREAD: dict[str, float] = {
    one.name: one.null
    for effect in EFFECTS
    if effect.name in READINGS
    for one in effect.parameters
    if one.null is not None
}
"""Values at which the instruments read the motion itself, on which all forces act."""
