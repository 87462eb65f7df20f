"""What the quantities of a rig are called, in which SI unit: on a straight path, and where x is an angle."""

from __future__ import annotations

from typing import Literal, NamedTuple

Coordinate = Literal["position", "angle"]


class Quantity(NamedTuple):
    """A word as it stands in a sentence, and an SI unit."""

    word: str
    unit: str


QUANTITIES: dict[Coordinate, dict[str, Quantity]] = {
    "position": {
        "x": Quantity("position", "m"), "v": Quantity("velocity", "m/s"), "T": Quantity("tension", "N"),
        "e": Quantity("elongation", "m"), "r": Quantity("rate of elongation", "m/s"), "F": Quantity("force", "N"),
        "t": Quantity("time", "s"),
    },
    "angle": {
        "x": Quantity("angle", "rad"), "v": Quantity("rate", "rad/s"), "T": Quantity("torque", "N·m"),
        "e": Quantity("twist", "rad"), "r": Quantity("rate of twist", "rad/s"), "F": Quantity("torque", "N·m"),
        "t": Quantity("time", "s"),
    },
}  # fmt: skip
"""What x is → symbol → quantity. x, v, T are channels, e is beyond taut, r its rate, F a force; a word has one unit."""


class Sensed(NamedTuple):
    """What a sensor of motion shows: of which coordinate, how often it is differentiated by time, and its name."""

    coordinate: Coordinate
    order: int
    word: str


SENSED = {
    "m": Sensed("position", 0, "displacement"), "m/s": Sensed("position", 1, "velocity"),
    "m/s²": Sensed("position", 2, "acceleration"),
    "rad": Sensed("angle", 0, "angle"), "rad/s": Sensed("angle", 1, "angular velocity"),
    "rad/s²": Sensed("angle", 2, "angular acceleration"),
}  # fmt: skip
"""SI unit of a record of motion → what its sensor shows."""

TURNED = {"N/m": "N·m/rad", "N·s/m": "N·m·s/rad"}
"""Units of the results of a body that turns, in place of those of one on a straight path."""
