"""A draft of an elongation test under dead loads."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress

from metrology import units
from metrology.draft.parts import Bound, Writer, quote, stretch
from metrology.draft.recognition import load_of
from metrology.draft.seen import Seen
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
    yield from writer.sample()
    yield "tests:"
    yield "  elongation:"
    yield "    method: elongation"
    yield "    sample: sample"
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
    raise MetrologyError(Fault(f"--set load.{name}", got, "a mass or a force, such as '2.0000(2) kg' or '20 N'"))


def _load(writer: Writer, load: Seen, word: str, name: str) -> str:
    """A load by its mass or force: as given, as the column has it, or as a column of masses or forces beside it."""
    writer.known[f"load.{name}"] = None
    if f"load.{name}" in writer.given:
        value = writer.given[f"load.{name}"]
        return f"{{{_kind(name, value)}: {quote(value)}}}"
    for column in (load, writer.surveys[0].first("mass"), writer.surveys[0].first("force")):
        if column is not None and column.unit and column.role in ("mass", "force"):
            value = column.words[load.words.index(word)]
            return f"{{{column.role}: {value} {column.unit}}}   # from the file; state its uncertainty"
    asked = writer.ask(f"load.{name}", f"mass or force of load {name}, such as '2.0000(2) kg'")
    return f"{{mass: {asked}}}"
