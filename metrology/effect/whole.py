"""What is missing in an effect, or does not fit together: an error at import that names file, field and fix."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator, Sequence

from metrology.effect import ARGUMENTS, BASE, METHODS, NEEDS, PICTURES, Cause, Effect, Parameter
from metrology.errors import Fault


def faults(effect: Effect, file: str = "") -> Iterator[Fault]:
    """Everything that is missing or does not fit together, with file, field and fix.

    Parameters
    ----------
    effect : Effect
        As its file declares it.
    file : str, optional
        Its file, for the messages.

    Yields
    ------
    Fault
        Empty for an effect that is whole.
    """
    where = f"{file}: {effect.name}" if file else effect.name or "effect"
    yield from _empty(where, effect, ("name", "title", "equation", "sign", "source"))
    if not effect.parameters and not effect.causes:
        yield Fault(f"{where}.parameters", "none", "at least one Parameter, the effect's size")
    for one in effect.parameters:
        yield from _parameter(f"{where}: {one.name or 'a parameter'}", effect, one)
    if effect.parameters and not 1 <= effect.sizes <= len(effect.parameters):
        yield Fault(f"{where}.sizes", f"{effect.sizes}", f"a number from 1 to {len(effect.parameters)}")
    yield from _terms(where, effect)
    if not effect.causes and not effect.never:
        expected = "a Cause for each method that tries it, or 'never': why none does"
        yield Fault(f"{where}.causes", "none", expected)
    for cause in effect.causes:
        yield from _cause(f"{where}: causes[{cause.name!r}]", effect, cause)


_EXAMPLES = {
    "unit": "an SI unit, such as 'N', '1' for a mere number",
    "source": "where the equation stands: author, year, page or clause",
    "sign": "how one sees it in a measurement, in one line",
    "consequence": "what leaving it out does to k, E and c",
    "advice": "what the laboratory should do about it",
    "separate": "the measurement that tells it from other causes",
}


def _empty(where: str, one: object, names: Sequence[str]) -> Iterator[Fault]:
    for name in names:
        if not getattr(one, name):
            yield Fault(f"{where}.{name}", "nothing", _EXAMPLES.get(name, "a text"))


def _parameter(where: str, effect: Effect, one: Parameter) -> Iterator[Fault]:
    yield from _empty(where, one, ("symbol", "unit", "meaning"))
    first, _, second = one.name.partition(".")
    if first != effect.name or not second.isidentifier():
        yield Fault(f"{where}.name", f"'{one.name}'", f"'{effect.name}.' and a name of letters")
    if one.null is None or not (math.isfinite(one.null) and one.low <= one.null <= one.high):
        yield Fault(f"{where}.null", f"{one.null}", f"a number from {one.low:g} to {one.high:g}, where it vanishes")
    if not one.low <= one.plausible[0] < one.plausible[1] <= one.high:
        expected = f"(low, high) within {one.low:g} to {one.high:g}: the range that is met in laboratories"
        yield Fault(f"{where}.plausible", f"{one.plausible}", expected)
    if not (math.isfinite(one.scale) and one.scale > 0):
        yield Fault(f"{where}.scale", f"{one.scale:g}", "a positive number, a change that is neither tiny nor huge")


def _terms(where: str, effect: Effect) -> Iterator[Fault]:
    if effect.parameters and not effect.terms and not effect.built_in:
        expected = "'force', 'tension' with 'slope', 'damping' or 'readings'"
        yield Fault(f"{where}: terms", "none", expected)
    if (effect.tension is None) != (effect.slope is None):
        yield Fault(f"{where}.slope", "one of 'tension' and 'slope'", "both: the slope is its derivative")
    for channel in effect.readings:
        if channel not in ("x", "v", "T"):
            yield Fault(f"{where}.readings", repr(channel), "'x', 'v' or 'T'")
    own = {one.short for one in effect.parameters}
    for name, term in effect.terms.items():
        known = ARGUMENTS[name.partition("[")[0]]
        for argument in inspect.signature(term).parameters:
            if argument not in {*known, *BASE, *own}:
                expected = f"one of {', '.join((*known, *BASE, *sorted(own)))}"
                yield Fault(f"{where}.{name}", f"argument '{argument}'", expected)
    yield from _nonlinear(where, effect)


def _nonlinear(where: str, effect: Effect) -> Iterator[Fault]:
    # Damping of one way is linear on either side of a turn, which is located.
    ways = effect.damping is not None and "way" in inspect.signature(effect.damping).parameters
    line = effect.tension or (effect.damping and not ways)
    if line and any(one.linear for one in effect.parameters[: effect.sizes]):
        yield Fault(f"{where}.parameters", "linear=True", "linear=False for what is added to the line's tension")
    if effect.force and any(one.linear for one in effect.parameters[: effect.sizes]):
        stiff = [name for name in inspect.signature(effect.force).parameters if name in ("t", "e", "T")]
        if stiff:
            expected = f"linear=False for a force by {', '.join(stiff)}: exact steps know forces by x and v alone"
            yield Fault(f"{where}.parameters", "linear=True", expected)


def _cause(where: str, effect: Effect, one: Cause) -> Iterator[Fault]:
    yield from _empty(where, one, ("name", "consequence", "advice", "separate"))
    if one.method not in METHODS:
        yield Fault(f"{where}.method", repr(one.method), "one of " + ", ".join(map(repr, METHODS)))
    for name, known in (("pictures", PICTURES), ("needs", NEEDS)):
        found = getattr(one, name)
        if any(entry not in known for entry in found) or (name == "pictures" and not found):
            yield Fault(f"{where}.{name}", f"{found}", "some of " + ", ".join(map(repr, known)))
    names = [entry.name for entry in effect.parameters]
    for size in one.sizes:
        if isinstance(size, str) and size not in names:
            yield Fault(f"{where}.sizes", repr(size), "a Size, or one of " + ", ".join(map(repr, names)))
    if not one.sizes:
        yield Fault(f"{where}.sizes", "none", "its parameters, the size first")
    if one.amount is None and not one.alone:
        yield Fault(f"{where}.amount", "nothing", "a function of the scales: the first size to be tried")
    if one.method in ("elongation", "tension") and one.reading is None and not one.alone:
        yield Fault(f"{where}.reading", "nothing", "a function of the readings: what one unit of the size adds")
