"""A draft of an elongation test under dead loads."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress

from metrology import units
from metrology.draft.parts import Bound, Writer, quote, stretch
from metrology.draft.recognition import load_of
from metrology.draft.seen import Seen
from metrology.draft.survey import Survey
from metrology.draft.vocabulary import direction
from metrology.errors import Fault, MetrologyError
from metrology.units.dimensions import TextError, quoted

_GRAVITY = (
    "{value: 9.806 m/s^2, uncertainty: [{half_width: 0.027 m/s^2, distribution: rectangular, "
    "source: anywhere on Earth at sea level}]}"
)


def write(writer: Writer) -> Iterator[str]:
    """Lines of the draft."""
    one = writer.surveys[0]
    load, reading = load_of(one), one.first("reading", "displacement")
    assert load is not None
    assert reading is not None
    names = _names(load)
    yield "instruments:"
    yield from writer.instrument("indicator", "dial indicator", stretch("reading", reading))
    abreast = side_by_side(one, reading)
    for number, seen in enumerate(abreast, start=1):
        yield from _sample(writer, seen, number) if len(abreast) > 1 else writer.sample()
    yield "tests:"
    for number, seen in enumerate(abreast, start=1):
        yield from _test(writer, load, names, seen, f"-{number}" if len(abreast) > 1 else "")
    if len(abreast) > 1:
        writer.remarks.append(
            f"{one.path.name}: {len(abreast)} columns of readings differ by a number alone, "
            f"{', '.join(quote(seen.heading) for seen in abreast)}: each is a test of a sample of its own"
        )


def side_by_side(one: Survey, reading: Seen) -> list[Seen]:
    """The columns of readings at the same loads: those that differ from the first by a number in the heading alone."""

    def bare(name: str) -> str:
        return re.sub(r"[\W\d_]+", "", name.casefold())

    found = [each for each in one.columns if (each.role, each.unit) == (reading.role, reading.unit)]
    alike = [each for each in found if each.values is not None and bare(each.name) == bare(reading.name)]
    several = len({each.name for each in alike}) == len(alike) and all(re.search(r"\d", each.name) for each in alike)
    return alike if several and reading in alike else [reading]


def _sample(writer: Writer, seen: Seen, number: int) -> Iterator[str]:
    """The sample of one of several columns: what the file says of all, named by its heading."""
    heading, key, name, *rest = writer.sample()
    if number == 1:
        yield heading
    yield f"{key.rstrip(':')}-{number}:"
    yield f"    name: {quote(seen.name)}   # guess: by the heading" if "# guess" in name else name
    yield from rest


def _test(writer: Writer, load: Seen, names: dict[str, str], reading: Seen, number: str) -> Iterator[str]:
    """The test of one column of readings; `number` ends its name where there are several."""
    one = writer.surveys[0]
    yield f"  elongation{number}:"
    yield "    method: elongation"
    yield f"    sample: sample{number}"
    yield from writer.conduct()
    yield "    instruments: {extension: indicator}"
    loads = {name: _load(writer, load, word, name) for word, name in names.items()}
    if any("mass" in text for text in loads.values()):
        yield f"    gravity: {writer.take('gravity', _GRAVITY, 'state the local value')}"
    yield "    loads:"
    yield from (f"      {name}: {text}" for name, text in loads.items())
    yield "    readings:"
    stands = {written: names[word] for written, word in zip(load.written, load.words, strict=True)}
    columns = [Bound("load", load, {word: name for word, name in stands.items() if word != name})]
    columns += [Bound("repeat", seen) for seen in [one.first("repeat")] if seen]
    columns += [Bound("direction", seen, _ways(seen)) for seen in [one.first("direction")] if seen]
    stated = [seen for seen in (one.first("mass"), one.first("force")) if seen is not None and seen.unit]
    why = {seen.number: f"{seen.number}: stands in the loads" for seen in stated}
    if number:
        why |= {seen.number: f"{seen.number}: a test of its own" for seen in side_by_side(one, reading)}
    yield from writer.readings(one, [*columns, stretch("reading", reading)], indent=6, why=why)


def _ways(column: Seen) -> dict[str, str]:
    ways = {word: direction(word) for word in dict.fromkeys(column.words)}
    return {word: way for word, way in ways.items() if way not in ("", word)}


def _names(load: Seen) -> dict[str, str]:
    """Words of the column of loads, each with a name that a campaign can use, in the order of the file."""
    words = list(dict.fromkeys(load.words))
    plain = all(re.fullmatch(r"[^\W\d_][\w-]*", word) for word in words)
    if load.values is not None:
        words.sort(key=float)
    return {word: word if plain else f"L{index}" for index, word in enumerate(words, start=1)}


def _kind(name: str, value: str) -> str:
    """Whether a value is a mass or a force, by its dimension.

    Raises
    ------
    MetrologyError
        For what is neither.
    """
    got = f"{quoted(value)}, which is neither"
    with suppress(TextError):
        dimension = units.parse(value).dimension
        for kind, unit in (("mass", "kg"), ("force", "N")):
            if dimension == units.dimension(unit):
                return kind
        got = f"{quoted(value)}, which is {units.unit(units.parse(value).unit).name}"
    raise MetrologyError(Fault(f"--set {name}", got, "a mass or a force, such as '2.0000(2) kg' or '20 N'"))


def _load(writer: Writer, load: Seen, word: str, name: str) -> str:
    """A load by its mass or force: as given, as the column has it, or as a column of masses or forces beside it."""
    writer.known[f"load.{name}"] = None
    if f"load.{name}" in writer.given:
        value = writer.given[f"load.{name}"]
        return f"{{{_kind(f'load.{name}', value)}: {quote(value)}}}"
    for column in (load, writer.surveys[0].first("mass"), writer.surveys[0].first("force")):
        if column is not None and column.unit and column.role in ("mass", "force"):
            value = column.words[load.words.index(word)]
            return f"{{{column.role}: {value} {column.unit}}}   # from the file; state its uncertainty"
    if _in_one_unit(load):
        what = f"unit of '{load.heading}', such as g or N: every load is its number in it"
        asked = writer.ask("unit.load", what)
        if "unit.load" in writer.given:
            value = f"{word} {writer.given['unit.load']}"
            return f"{{{_kind('unit.load', value)}: {quote(value)}}}   # from the file; state its uncertainty"
        return f"{{mass: {asked}}}"
    asked = writer.ask(f"load.{name}", f"mass or force of load {name}, such as '2.0000(2) kg'")
    return f"{{mass: {asked}}}"


def _in_one_unit(load: Seen) -> bool:
    """Whether a column without unit holds the loads themselves: its numbers are no count from 0 or 1."""
    if load.values is None or load.unit:
        return False
    levels = sorted(set(load.values.tolist()))
    return levels not in (list(range(len(levels))), list(range(1, len(levels) + 1)))
