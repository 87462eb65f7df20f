"""What a diagnosis tries: the causes that the effects' files declare, whatever the method."""

from __future__ import annotations

import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from metrology.coordinate import QUANTITIES
from metrology.effect import Cause, Effect, Parameter, Size
from metrology.effects import causes
from metrology.message import said
from metrology.rig.parameters import turned_unit


@dataclass(frozen=True)
class Candidate:
    """One cause that may be missing in a model.

    Parameters
    ----------
    name, title : str
        Key, and what a report prints.
    equation : str
        Its term.
    parameters : tuple of Size
        The first is its size.
    sign : str
        How one sees it.
    consequence : str
        What leaving it out does to k, E and c.
    advice : str
        What the laboratory should do.
    separate : str
        The extra measurement that tells it from others.
    kind : {'physics', 'input'}
        'input': something that the laboratory states with an uncertainty, and that would be wrong beyond it.
    cause : Cause
        How a search begins with it, and what it needs.
    acts : str
        On what, as `Effect` has it.
    instead : bool
        Whether it is tried only in the place of another effect of the same law.
    """

    name: str
    title: str
    equation: str
    parameters: tuple[Size, ...]
    sign: str
    consequence: str
    advice: str
    separate: str
    kind: Literal["physics", "input"] = "physics"
    cause: Cause = field(default_factory=Cause, repr=False, compare=False)
    acts: str = "module"
    instead: bool = False

    @property
    def size(self) -> Size:
        """The parameter that says how much of it there is."""
        return self.parameters[0]

    @property
    def sought(self) -> tuple[Size, ...]:
        """Parameters that are common to all blocks and sought between their places."""
        return tuple(size for size in self.parameters if not (size.held or size.own))

    @property
    def is_sought(self) -> bool:
        """Whether it is tried by itself, and not only together with another effect or in the place of one."""
        return not (self.instead or self.cause.beside)

    @property
    def signed(self) -> bool:
        """Whether it may act either way."""
        return self.size.low < self.size.null < self.size.high

    @property
    def is_line(self) -> bool:
        """Whether it is an oscillation of one frequency in the readings."""
        return any(size.unit == "Hz" for size in self.parameters)

    def amount(self, known: Any) -> float:
        """First size to be tried, from the scales of a motion or from readings."""
        amount = self.cause.amount
        return float(amount(known)) if callable(amount) else amount or 0.0

    def limits(self, known: Any) -> Mapping[str, tuple[float, float]]:
        """Parameter → range that makes sense for these scales or readings."""
        return self.cause.limits(known) if self.cause.limits else {}

    def shapes(self, known: Any, among: Container[str] = ()) -> Sequence[Mapping[str, float]]:
        """Values of its shapes to be tried, one set after the other; `among`: names of all candidates."""
        if self.cause.shapes is not None:
            return self.cause.shapes(known, among)
        held = next((size for size in self.parameters if size.held), None)
        return [{held.name: float(place)} for place in held.places] if held else [{}]


def candidate(effect: Effect, cause: Cause) -> Candidate:
    """One effect as a method tries it, in the words of the effect where the cause has none of its own."""
    entries = {one.name: one for one in effect.parameters}
    parameters = tuple(
        size if isinstance(size, Size) else _sized(entries[size], shape=at > 0) for at, size in enumerate(cause.sizes)
    )
    title = effect.title
    if effect.sizes > 1:
        title = f"{title.split(':')[0]}: {entries[parameters[0].name].meaning}" if not cause.title else title
    return Candidate(
        cause.name, cause.title or title, cause.equation or effect.equation, parameters, cause.sign or effect.sign,
        cause.consequence, cause.advice, cause.separate, cause.kind, cause, effect.acts,
    )  # fmt: skip


def _sized(one: Parameter, *, shape: bool) -> Size:
    """A parameter as it is sought: a shape within its plausible range, a size wherever the equation allows it."""
    low, high = one.plausible if shape else (one.low, one.high)
    assert one.null is not None
    return Size(one.name, one.unit, one.null, low, high, one.scale, shape)


def table(method: str) -> dict[str, Candidate]:
    """Every candidate of a method by its name."""
    return {cause.name: candidate(effect, cause) for effect, cause in causes(method)}


RESPONSE, ELONGATION, DECAY = table("response"), table("elongation"), table("decay")
TENSION = table("tension")


def untested(candidates: Mapping[str, Candidate]) -> dict[str, str]:
    """Causes that the readings of their method cannot test, by name: why, and what would."""
    return {
        name: said("{why}. Needed: {needed}", why=one.cause.alone, needed=one.separate)
        for name, one in candidates.items()
        if one.cause.alone
    }


# ---- where x is an angle --------------------------------------------------------------------------------------------
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
    turning = [cause.name for effect, cause in causes("response") if not effect.straight]
    return {name: _turned(RESPONSE[name]) for name in turning}


def _turned(one: Candidate) -> Candidate:
    title, consequence, advice, separate = (
        _STRAIGHT.sub(lambda found: _TURNED[found[0]], text)
        for text in (one.title, one.consequence, one.advice, one.separate)
    )
    sizes = tuple(replace(size, unit=turned_unit(size.unit)) for size in one.parameters)
    return replace(one, title=title, consequence=consequence, advice=advice, separate=separate, parameters=sizes)
