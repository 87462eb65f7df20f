"""Causes that a response test may hide: the effects of the rig, and what each means for the laboratory."""

from __future__ import annotations

import re
from dataclasses import replace

from metrology.coordinate import QUANTITIES
from metrology.diagnose.candidate import Candidate, Size
from metrology.rig import EFFECTS, PARAMETERS
from metrology.rig.model import STRAIGHT
from metrology.rig.parameters import turned

SLACK = "a coast run with the line slack"
WORDS: dict[str, tuple[tuple[str, ...], str, str, str, str]] = {
    "friction": (
        ("friction.force",),
        "c comes out too large, the more so the smaller the amplitude; k hardly changes",
        "level and clean the table, check the air supply; subtract F_c from the thrust",
        f"{SLACK}: the speed falls in proportion to time; or a tilt of a known angle",
        "physics",
    ),
    "drag": (
        ("drag.viscous",),
        "c comes out too large by about b",
        "measure b in a coast run and keep it in the model",
        f"{SLACK}: the speed falls exponentially",
        "physics",
    ),
    "quadratic drag": (
        ("drag.quadratic",),
        "c comes out too large, the more so the faster the module",
        "test at lower speed, or keep b₂ in the model",
        f"{SLACK} at twice the speed: the deceleration is four times as large",
        "physics",
    ),
    "tilt": (
        ("tilt.angle",),
        "thrust seems off by m·g·θ; k and c hardly change",
        "level the table, or turn it by 180° and repeat",
        "a run without thrust, from rest: the module drifts; repeated with the table turned by 180° it drifts back",
        "physics",
    ),
    "setup": (
        ("setup.compliance",),
        "k comes out too small by the factor 1/(1 + C·k), E with it, c by its square",
        "measure elongation at the specimen, or the compliance of mount and cell with a stiff bar",
        "an indicator on the mount under a dead load, or a second line of known, different stiffness",
        "physics",
    ),
    "frame": (
        ("frame.compliance", "frame.frequency", "frame.damping"),
        "k comes out too small by the factor 1/(1 + C_f·k)",
        "stiffen the frame; measure elongation at the specimen",
        "a tap test of the mount with an accelerometer",
        "physics",
    ),
    "cubic": (
        ("cubic.stiffness",),
        "k is a mean over the amplitude: it differs from the stiffness at small loads",
        "state k with its range of load, or give k and k₃",
        "static loading in steps over the same range",
        "physics",
    ),
    "toe": (
        ("toe.ratio", "toe.extent"),
        "k comes out too small, and E with it, as at the start of a tensile curve",
        "preload the line beyond ε_t, or fit the straight part only",
        "static loading in fine steps from zero load",
        "physics",
    ),
    "zener": (
        ("zener.stiffness", "zener.time"),
        "k lies between the slow and the fast stiffness; c depends on frequency",
        "state k with its time scale; keep the branch in the model",
        "hold a constant elongation and watch the tension fall",
        "physics",
    ),
    "damping": (
        ("damping.amplitude",),
        "c is a mean over the amplitude",
        "state c with its amplitude",
        "decays from several amplitudes",
        "physics",
    ),
    "hysteresis": (
        ("hysteresis.stiffness", "hysteresis.yield"),
        "k depends on amplitude, c stands for a loss that does not depend on frequency",
        "state k and the loss per cycle with the amplitude",
        "a slow loading loop between two tensions",
        "physics",
    ),
    "sag": (
        ("sag.weight",),
        "k comes out too small at low tension",
        "raise the tension, or use the elastic catenary with the weighed line",
        "weigh the line; repeat at twice the thrust: the softening falls with T³",
        "physics",
    ),
    "slip": (
        ("slip.set",),
        "free length wrong from the first peak on; k too small when it is fitted over both",
        "tighten the clamp, mark the line at it; discard the first pull",
        "measure the taut position again after the run",
        "physics",
    ),
    "yaw": (
        ("yaw.arm", "yaw.frequency", "yaw.damping"),
        "k comes out too small, with a second beat; only r²/J shows: r is that of the stated moment of inertia",
        "move the line to the centre of mass",
        "a marker on the side of the module shows the angle",
        "physics",
    ),
    "thrust lag": (
        ("thrust.lag",),
        "thrust acts late; k and c hardly change",
        "measure the rise of the thrusters on the cell, keep τ_F in the model",
        "clamp the module to the cell and fire",
        "physics",
    ),
    "thrust gain": (
        ("thrust.gain",),
        "k and c are off by the same factor where no tension is measured",
        "calibrate the thrusters again",
        "clamp the module to the cell and fire",
        "input",
    ),
    "thrust delay": (
        ("thrust.delay",),
        "thrust acts late; k and c hardly change",
        "record the valve command on the same clock",
        "clamp the module to the cell and fire",
        "input",
    ),
    "mass": (
        ("mass.factor",),
        "k and c are off by the same factor where no tension is measured",
        "weigh the module",
        "weigh the module",
        "input",
    ),
    "free length": (
        ("free_length.shift",),
        "the first contact is early or late; k hardly changes, E by the ratio of lengths",
        "measure the taut position again",
        "measure the taut position at a small dead load",
        "input",
    ),
    "cell gain": (
        ("cell.gain",),
        "k and c from the tension are off by the same factor",
        "calibrate the load cell",
        "dead weight on the load cell",
        "input",
    ),
    "cell zero": (
        ("cell.zero",),
        "tension offset; k hardly changes",
        "take the zero before every run",
        "a minute of readings with the line slack",
        "input",
    ),
    "cell drift": (
        ("cell.drift",),
        "tension drifts; k hardly changes",
        "let the cell warm up; take the zero before and after every run",
        "ten minutes of readings with the line slack",
        "physics",
    ),
    "motion scale": (
        ("motion.scale",),
        "k and c are off by the reciprocal factor",
        "calibrate the motion capture with a scale bar",
        "scale bar in the field of view",
        "input",
    ),
    "clock x": (
        ("clock.x",),
        "c is biased by k·δt where tension and position are compared",
        "synchronise the clocks",
        "one tap seen by all channels",
        "input",
    ),
    "clock v": (
        ("clock.v",),
        "velocity out of step with position",
        "synchronise the clocks, ask how velocity is filtered",
        "one tap seen by all channels",
        "input",
    ),
    "clock T": (
        ("clock.T",),
        "c is biased by k·δt",
        "synchronise the clocks",
        "one tap seen by all channels",
        "input",
    ),
    "hum x": (
        ("hum.x", "hum.frequency", "hum.phase"),
        "adds to the noise of position only",
        "find the source, or filter at its frequency",
        "a record at rest, with and without suspected sources",
        "physics",
    ),
    "hum v": (
        ("hum.v", "hum.frequency", "hum.phase"),
        "adds to the noise of velocity only",
        "find the source, or filter at its frequency",
        "a record at rest, with and without suspected sources",
        "physics",
    ),
    "hum T": (
        ("hum.T", "hum.frequency", "hum.phase"),
        "adds to the noise of tension only",
        "part the supply and earth of the cell, or filter at its frequency",
        "a record at rest, with and without suspected sources",
        "physics",
    ),
}
"""Name → parameters, consequence for k, E and c, advice, the measurement that separates it, kind."""

SHAPES = {"frame.frequency", "frame.damping", "toe.extent", "zener.time", "hysteresis.yield", "yaw.frequency",
          "yaw.damping", "hum.frequency", "hum.phase"}  # fmt: skip

RANGES = {"yaw.frequency": (0.1, 100.0), "yaw.damping": (0.0, 0.5)}
"""Ranges in which shapes are sought, where not the plausible ones: as wide as a frame's, so that both cost the same."""
POWER = {"yaw.arm": 2, "sag.weight": 2}
"""Power of a size with which its effect grows, where that is not 1."""


def _size(name: str) -> Size:
    entry = PARAMETERS[name]
    shape = name in SHAPES
    if name == "toe.ratio":
        # The size of a toe is what it lacks of the full stiffness; its extent is a shape, and means nothing at ratio 1.
        return Size(name, entry.unit, 1.0, 0.02, 1.0, entry.scale)
    low, high = RANGES.get(name, entry.plausible) if shape else (entry.low, entry.high)
    assert entry.null is not None
    if name == "yaw.arm":
        low = 0.0  # A line to the left of the centre of mass pulls like one to the right.
    return Size(name, entry.unit, entry.null, low, high, entry.scale, shape, power=POWER.get(name, 1))


def _candidate(name: str) -> Candidate:
    parameters, consequence, advice, separate, kind = WORDS[name]
    effect = next(one for one in EFFECTS if parameters[0] in [entry.name for entry in one.parameters])
    title = effect.title if effect.sizes == 1 else f"{effect.title.split(':')[0]}: {PARAMETERS[parameters[0]].meaning}"
    return Candidate(
        name, title, effect.equation, tuple(_size(one) for one in parameters), effect.sign, consequence, advice,
        separate,
        "input" if kind == "input" else "physics",
    )  # fmt: skip


TABLE: dict[str, Candidate] = {name: _candidate(name) for name in WORDS}
"""Every candidate of a response test."""


_TURNED = {
    **{one.word: QUANTITIES["angle"][symbol].word for symbol, one in QUANTITIES["position"].items()},
    "tensions": "torques", "module": "body", "mass": "moment of inertia", "Mass": "Moment of inertia",
    "weigh the module": "measure the moment of inertia", "load cell": "torque cell", "Load cell": "Torque cell",
    "free length": "angle of no torque", "Free length": "Angle of no torque",
    ", E with it": "", ", and E with it": "", ", E by the ratio of lengths": "",
}  # fmt: skip
"""What is said of a straight path → what is said of a rig that turns, of which no modulus follows."""
_STRAIGHT = re.compile(rf"(?:\b|(?=,))({'|'.join(sorted(_TURNED, key=len, reverse=True))})\b")


def turned_table() -> dict[str, Candidate]:
    """Candidates of a rig that turns: those of a straight path left out, in its words, sizes in its units."""
    return {name: _turned(one) for name, one in TABLE.items() if WORDS[name][0][0].split(".")[0] not in STRAIGHT}


def _turned(one: Candidate) -> Candidate:
    title, consequence, advice, separate = (
        _STRAIGHT.sub(lambda found: _TURNED[found[0]], text)
        for text in (one.title, one.consequence, one.advice, one.separate)
    )
    sizes = tuple(replace(size, unit=turned(PARAMETERS[size.name]).unit) for size in one.parameters)
    return replace(one, title=title, consequence=consequence, advice=advice, separate=separate, parameters=sizes)
