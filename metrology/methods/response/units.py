"""Units of a response test: those of a straight path, or of a rig that turns, throughout; its columns of readings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from metrology import units
from metrology.declaration.columns import Column, Table
from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, from_text
from metrology.methods.response.known import INERT, KNOWN, TURNED, amount
from metrology.units.dimensions import TextError

if TYPE_CHECKING:
    from metrology.declaration.quantity import Stated
    from metrology.methods.response.schema import ResponseTest
    from metrology.rig import Parameter

STIFFNESS = {"N/m": "N*m/rad", "N*s/m": "N*m*s/rad"}
WORDS = {
    "position": {"x": "x", "v": "v", "T": "T", "F": "F"},
    "angle": {"x": "angle", "v": "rate", "T": "torque", "F": "drive"},
}
"""Channel → its column, by what x is; F is the thrust."""
UNITS = {"x": "m", "v": "m/s", "T": "N"}
_STRAIGHT = ("mass", "tilt")


def due(unit: str, test: ResponseTest) -> str:
    """Unit that is due where one of a straight path is named."""
    return {**TURNED, **STIFFNESS}.get(unit, unit) if test.rig.coordinate == "angle" else unit


def parameter_unit(name: str, test: ResponseTest, known: Mapping[str, Parameter]) -> str:
    """Unit of a parameter of the equation of motion in this test; one of the laboratory's own keeps its unit."""
    from metrology.rig import PARAMETERS
    from metrology.rig.parameters import turned

    turns = test.rig.coordinate == "angle" and name in PARAMETERS
    return turned(known[name]).unit if turns else known[name].unit


def columns(test: ResponseTest) -> tuple[Column, ...]:
    """Columns that the readings of a test may have."""
    words = WORDS[test.rig.coordinate]
    channels = tuple(
        Column(words[name], due(unit, test), required=False, gaps=True, varies=True) for name, unit in UNITS.items()
    )
    return (Column("time", "s", increasing=True), *channels, Column(words["F"], due("N", test), required=False))


def by_channel(table: Table, test: ResponseTest) -> Table:
    """Return the table with its columns called by their channels."""
    channels = {word: name for name, word in WORDS[test.rig.coordinate].items()}
    return replace(table, numbers={channels.get(word, word): column for word, column in table.numbers.items()})


def check_units(test: ResponseTest, place: Place) -> Iterator[Refusal]:
    """Whatever is in units of a straight path on a rig that turns, and the other way round."""
    turns = test.rig.coordinate == "angle"
    fix = "a rig with 'inertia' has angles and torques throughout, one with 'mass' lengths and forces"
    for where, stated, unit in _stated(test):
        try:
            units.parse(stated.value, expected=due(unit, test))
        except TextError as error:
            yield replace(from_text(error, *place, *where), fix=fix)
    for where, stated in _drives(test):
        if (where[-1] == "torque") is not turns:
            expected = "a torque, such as 'torque: 0.02 N*m'" if turns else "a force, such as 'force: 0.38 N'"
            yield Refusal((*place, *where), f"'{stated.value}'", expected, fix)
    yield from _known(test, place, fix)
    if turns and test.rig.line_weight != "none":
        got = f"'{test.rig.line_weight}' with 'inertia'"
        yield Refusal((*place, "rig", "line_weight"), got, "'none' for a rig that turns")


def _stated(test: ResponseTest) -> Iterator[tuple[Place, Stated, str]]:
    yield ("rig", "taut"), test.rig.taut, "m"
    if test.identification:
        start = test.identification.start
        for name, unit in (("k", "N/m"), ("c", "N*s/m")):
            if (stated := getattr(start, name)) is not None:
                yield ("identification", "start", name), stated, unit
    for name, unit in UNITS.items():
        if (stated := getattr(test.noise, name)) is not None:
            yield ("noise", name), stated, unit
    for name, run in test.runs.items():
        yield ("runs", name, "start", "position"), run.start.position, "m"
        if run.start.velocity.si != 0:
            yield ("runs", name, "start", "velocity"), run.start.velocity, "m/s"


def _drives(test: ResponseTest) -> Iterator[tuple[Place, Stated]]:
    for name, run in test.runs.items():
        for index, part in enumerate(run.thrust or ()):
            yield ("runs", name, "thrust", index, "torque" if part.torque else "force"), part.size


def _known(test: ResponseTest, place: Place, fix: str) -> Iterator[Refusal]:
    turns = test.rig.coordinate == "angle"
    for key, (_, unit) in KNOWN.items():
        spread = getattr(test.known, key)
        if spread is None:
            continue
        if key in (_STRAIGHT if turns else ("inertia",)):
            yield Refusal((*place, "known", key), f"'{key}' with '{'inertia' if turns else 'mass'}'", "none", fix)
            continue
        for part, text in spread.amounts().items():
            try:
                amount(text, due(unit, test), 1.0 if key in INERT else None)
            except TextError as error:
                yield replace(from_text(error, *place, "known", key, part), fix=fix)
