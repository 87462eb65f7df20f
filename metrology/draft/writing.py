"""A draft campaign out of what files were found to hold: every guess is marked as one."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from metrology.draft.survey import Seen, Survey
from metrology.draft.vocabulary import direction
from metrology.errors import Fault, MetrologyError

OPEN = "?"
"""Stands where only the laboratory knows the value; a campaign with it is refused there."""
_GRAVITY = (
    "{value: 9.806 m/s^2, uncertainty: [{half_width: 0.027 m/s^2, distribution: rectangular, "
    "source: anywhere on Earth at sea level}]}"
)
STRAINS = ("%", "1", "‰")
"""Units of a strain."""
_UNLESS_STATED = {"time": "s", "reading": "", "displacement": "", "angle": "", "velocity": "", "acceleration": ""}
"""Columns that have a unit, and the unit that is taken where none is found."""
MAX_LOADS = 40
Bound = tuple[str, Seen, Mapping[str, str]]
"""Name of a column that is due, the column of the file, and what its words stand for."""
_PLAIN = re.compile(r"[\w/.()°%µ][\w /.()°%µ+-]*")


@dataclass
class Draft:
    """A campaign file as text, and what only the laboratory knows: its name, and what it is."""

    text: str = ""
    missing: dict[str, str] = field(default_factory=dict)


@dataclass
class _Writer:
    """Lines of the file; `given` are values that the user stated, by the names of `Draft.missing`."""

    surveys: Sequence[Survey]
    folder: Path
    given: Mapping[str, str]
    missing: dict[str, str] = field(default_factory=dict)

    def ask(self, name: str, what: str) -> str:
        """The value that was given under a name, or a mark that it is missing."""
        if name in self.given:
            return quote(self.given[name])
        self.missing[name] = what
        return f'"{OPEN}"'

    def take(self, name: str, guess: str, why: str) -> str:
        """The value that was given under a name, or a guess with its reason as a comment."""
        return quote(self.given[name]) if name in self.given else f"{guess}   # guess: {why}"


def write(surveys: Sequence[Survey], path: Path, given: Mapping[str, str]) -> Draft:
    """Return a draft of the campaign file `path` for files in its folder.

    Parameters
    ----------
    surveys : sequence of Survey
        What the files hold; of several files those of free decays only make one test.
    path : Path
        Where the campaign file will stand.
    given : mapping of str to str
        Values that the user states, by the names of `Draft.missing` and of the guesses.

    Raises
    ------
    MetrologyError
        Where no method was recognised, and for a value under a name that the draft does not have.
    """
    writer = _Writer(surveys, path.parent, given)
    body = list(_body(writer))
    used = {name for name in given if name in _names(surveys)}
    if unknown := sorted(set(given) - used):
        known = ", ".join(_names(surveys))
        raise MetrologyError(
            Fault(f"--set {unknown[0]}", f"'{unknown[0]}', which this draft does not have", f"one of {known}")
        )
    return Draft("\n".join([*_head(writer, path), *body]) + "\n", writer.missing)


def _names(surveys: Sequence[Survey]) -> tuple[str, ...]:
    common = ("id", "title", "sample", "resolution", *(f"unit.{name}" for name in _UNLESS_STATED))
    if method(surveys[0]) == "elongation":
        loads = _loads(surveys[0].first("load", "mass", "force"))
        return (*common, "gravity", *(f"load.{name}" for name in loads.values()))
    if method(surveys[0]) == "relaxation":
        return (*common, "resolution.stretch", "class.cell", "class.stretch")
    return (*common, "mass") if method(surveys[0]) == "decay" else common


def method(one: Survey) -> str:
    """What a file can be evaluated as: ``elongation``, ``decay``, ``relaxation`` or ``line``; empty where not known."""
    load, reading = one.first("load", "mass", "force"), one.first("reading", "displacement")
    steps = load is not None and 3 <= len(set(load.words)) <= MAX_LOADS and len(set(load.words)) * 3 <= len(load.words)
    if steps and reading is not None and one.first("repeat") and one.first("direction"):
        return "elongation"
    if one.first("force") and one.first("displacement", "angle", "reading"):
        return "relaxation" if held(one) else "line"
    timed = one.first("time") is not None or one.step > 0 or one.found.rate > 0
    return "decay" if timed and _moved(one) is not None else ""


def _moved(one: Survey) -> Seen | None:
    """Column that shows the motion of a free decay."""
    return one.first("displacement", "angle", "reading") or one.first("velocity", "acceleration")


HELD, LEVELS = 0.2, 32
"""Part of the time of a record in one of so many parts of a channel's range, from which on it was held there: a ramp
spends a thirty-second in each."""


def held(one: Survey) -> str:
    """What a record of time, force and stretch holds, but for its beginning: ``elongation``, ``load``, or nothing."""
    time, force, moved = one.first("time"), one.first("force"), one.first("displacement", "reading")
    if time is None or force is None or moved is None or any(c.values is None for c in (time, force, moved)):
        return ""
    longest: dict[str, float] = {}
    for name, column in (("elongation", moved), ("load", force)):
        assert time.values is not None
        assert column.values is not None
        seen = np.isfinite(time.values) & np.isfinite(column.values)
        t, u = time.values[seen], column.values[seen]
        if len(t) < LEVELS or not np.ptp(u) > 0:
            continue
        part = np.minimum((u - u.min()) / np.ptp(u) * LEVELS, LEVELS - 1).astype(int)
        spent = np.bincount(part, weights=np.gradient(t), minlength=LEVELS) / np.ptp(t)
        spent[max(part[0] - 1, 0) : part[0] + 2] = 0.0
        # A level may lie on the edge of two parts.
        longest[name] = float((spent[1:] + spent[:-1]).max())
    # What creeps, or relaxes, comes to rest as well: what is held has done so for longer.
    most = max(longest, key=lambda one: longest[one], default="")
    return most if longest.get(most, 0.0) > HELD else ""


def _head(writer: _Writer, path: Path) -> Iterator[str]:
    first = writer.surveys[0]
    yield "# A draft, made by `metrology import`. What is marked as a guess is to be confirmed or corrected."
    yield "# Every key is explained in docs/campaign.md."
    yield f"# Check it with:   metrology check {path}"
    yield f"# Its report:      metrology report {path}"
    for one in writer.surveys:
        maker = f" by {one.found.maker}" if one.found.maker else ""
        yield f"# {one.path.name}: {one.title}{maker}{''.join(f'; {text}' for text in one.notices)}"
    yield "format: metrology-campaign/1"
    stem = re.sub(r"[^\w-]+", "-", first.path.name.partition(".")[0]).strip("-_") or "campaign"
    stem = stem if stem[0].isalpha() else f"campaign-{stem}"
    yield f"id: {writer.take('id', stem[:64], 'the name of the file')}"
    yield f"title: {writer.take('title', quote(_title(first)), 'what the columns look like')}"
    yield ""


def _title(one: Survey) -> str:
    words = {"elongation": "Elongation under dead loads", "decay": "Free decay", "line": "Force against extension",
             "relaxation": "Creep" if held(one) == "load" else "Relaxation"}  # fmt: skip
    return f"{words[method(one)]}, {one.found.facts.get('sample', one.path.name.partition('.')[0])}"


def _body(writer: _Writer) -> Iterator[str]:
    kinds = {method(one) for one in writer.surveys}
    if kinds == {"decay"}:
        yield from _decay(writer)
    elif kinds == {"relaxation"} and len({held(one) for one in writer.surveys}) == 1:
        yield from _relaxation(writer)
    elif len(writer.surveys) == 1 and kinds == {"elongation"}:
        yield from _elongation(writer)
    elif len(writer.surveys) == 1 and kinds == {"line"}:
        yield from _line(writer)
    else:
        one = writer.surveys[0]
        had = "; ".join(
            f"'{column.heading}' looks like {column.role or 'nothing known'}" for column in one.columns[:12]
        )
        got = "files of several kinds" if len(kinds) > 1 or "" not in kinds else f"columns of no known test ({had})"
        expected = (
            "load, repeat, direction and reading; time and displacement, a file a release; force and extension; or "
            "time, force and extension of which one is held, a file a specimen"
        )
        raise MetrologyError(Fault(str(one.path), got, expected, "write 'readings:' by hand (docs/readings.md)"))


def _instrument(
    writer: _Writer, name: str, kind: str, column: Seen, *, first: bool = True, graded: str = ""
) -> Iterator[str]:
    """An instrument; the serial number of the file is that of the first. `graded`: standard of its class."""
    facts = writer.surveys[0].found.facts if first else {}
    yield from ["instruments:"] * first
    yield f"  {name}:"
    yield f"    kind: {kind}   # guess"
    if "serial" in facts:
        yield f"    serial: {quote(facts['serial'])}   # from the file"
    if graded:
        yield f"    class: {writer.ask(f'class.{name}', f'class of the {kind} to {graded}, such as 0.5')}"
    name = "resolution" if first else f"resolution.{name}"
    yield f"    resolution: {writer.take(name, _resolution(column), 'the last digit of the readings')}"
    yield "    # certificate: {number: …, date: …, due: …, expanded_uncertainty: …, k: 2}"
    yield ""


def _resolution(column: Seen) -> str:
    """Last digit of the readings; of numbers with all digits of a double, the smallest step between two of them."""
    size = column.resolution
    if not size and column.values is not None:
        steps = np.abs(np.diff(column.values[np.isfinite(column.values)]))
        size = float(steps[steps > 0].min()) if (steps > 0).any() else 1.0
    return f"{size:.3g} {column.unit or '1'}".replace("e-0", "e-")


def _sample(writer: _Writer) -> Iterator[str]:
    stated = writer.surveys[0].found.facts.get("sample", "")
    yield "samples:"
    yield "  sample:"
    known = f"{quote(stated)}   # from the file"
    guess = writer.take("sample", "sample", "no name was found")
    yield f"    name: {known if stated and 'sample' not in writer.given else guess}"
    yield "    # section: {shape: tape, width: …, thickness: …}   # with a length, gives the modulus E"
    yield "    # length: …"
    yield ""


def _conduct(one: Survey) -> Iterator[str]:
    facts = one.found.facts
    if date := one.date or facts.get("date", ""):
        yield f"    date: {date}   # from the file"
    if "operator" in facts:
        yield f"    operator: {quote(facts['operator'])}   # from the file"


# -- the three tests


def _elongation(writer: _Writer) -> Iterator[str]:
    one = writer.surveys[0]
    load, reading = one.first("load", "mass", "force"), one.first("reading", "displacement")
    assert load is not None
    assert reading is not None
    names = _loads(load)
    yield from _instrument(writer, "indicator", "dial indicator", reading)
    yield from _sample(writer)
    yield "tests:"
    yield "  elongation:"
    yield "    method: elongation"
    yield "    sample: sample"
    yield from _conduct(one)
    yield "    instruments: {extension: indicator}"
    loads = {name: _load(writer, load, word, name) for word, name in names.items()}
    if any("mass" in text for text in loads.values()):
        yield f"    gravity: {writer.take('gravity', _GRAVITY, 'state the local value')}"
    yield "    loads:"
    yield from (f"      {name}: {text}" for name, text in loads.items())
    yield "    readings:"
    words = {word: name for word, name in names.items() if word != name}
    ways = {word: direction(word) for word in dict.fromkeys(_column(one, "direction").words)}
    ways = {word: way for word, way in ways.items() if way not in ("", word)}
    columns: list[Bound] = [("load", load, words), ("repeat", _column(one, "repeat"), {})]
    columns += [("direction", _column(one, "direction"), ways), ("reading", reading, {})]
    yield from _readings(writer, one, columns, indent=6)


def _column(one: Survey, role: str) -> Seen:
    found = one.first(role)
    assert found is not None
    return found


def _loads(load: Seen | None) -> dict[str, str]:
    """Words of the column of loads, each with a name that a campaign can use, in the order of the file."""
    words = list(dict.fromkeys(load.words)) if load else []
    plain = all(re.fullmatch(r"[^\W\d_][\w-]*", word) for word in words)
    if load is not None and load.values is not None:
        words.sort(key=float)
    return {word: word if plain else f"L{index}" for index, word in enumerate(words, start=1)}


def _load(writer: _Writer, load: Seen, word: str, name: str) -> str:
    """A load by its mass or force: as given, as the column has it, or as a column of masses or forces beside it."""
    if f"load.{name}" in writer.given:
        value = writer.given[f"load.{name}"]
        return f"{{{'mass' if value.endswith('g') else 'force'}: {quote(value)}}}"
    for column in (load, writer.surveys[0].first("mass"), writer.surveys[0].first("force")):
        if column is not None and column.unit and column.role in ("mass", "force"):
            value = column.words[load.words.index(word)]
            return f"{{{column.role}: {value} {column.unit}}}   # from the file; state its uncertainty"
    asked = writer.ask(f"load.{name}", f"mass or force of load {name}, such as '2.0000(2) kg'")
    return f"{{mass: {asked}}}"


def _decay(writer: _Writer) -> Iterator[str]:
    one = writer.surveys[0]
    moved = _moved(one)
    assert moved is not None
    quantity = moved.role if moved.role in ("velocity", "acceleration") else "displacement"
    turns = moved.role == "angle" or moved.unit.startswith(("rad", "deg", "°"))
    yield from _instrument(writer, "sensor", f"{quantity} sensor", moved)
    yield from _sample(writer)
    yield "tests:"
    yield "  decay:"
    yield "    method: decay"
    yield "    sample: sample"
    yield from _conduct(one)
    yield f"    instruments: {{{quantity}: sensor}}"
    inert = "inertia" if turns else "mass"
    yield f"    {inert}: {writer.ask('mass', 'mass that swings (or moment of inertia), such as 1.196(1) kg')}"
    yield "    readings:"
    due = "angle" if moved.role == "angle" else quantity
    for each in writer.surveys:
        found = _moved(each)
        assert found is not None
        time = each.first("time")
        columns: list[Bound] = [("time", time, {})] if time else []
        lines = list(_readings(writer, each, [*columns, (due, found, {})], indent=8))
        yield "      - " + lines[0].strip()
        yield from lines[1:]
        if time is None and not each.step:
            yield f"        time: {{rate: {each.found.rate:g} Hz}}   # from the file"


def _relaxation(writer: _Writer) -> Iterator[str]:
    one = writer.surveys[0]
    force, moved = one.first("force"), one.first("displacement", "reading")
    assert force is not None
    assert moved is not None
    strain = moved.unit in STRAINS
    yield from _instrument(writer, "cell", "load cell", force, graded="ISO 7500-1")
    kind = "extensometer" if strain else "testing machine"
    yield from _instrument(writer, "stretch", kind, moved, first=False, graded="ISO 9513")
    yield from _sample(writer)
    yield "tests:"
    yield "  hold:"
    yield "    method: relaxation"
    yield "    sample: sample"
    yield from _conduct(one)
    yield f"    held: {held(one)}   # guess: what rests while the other changes"
    due = "strain" if strain else "crosshead"
    why = "" if strain else ": an extensometer is 'extension', with 'gauge_length'"
    yield f"    instruments: {{force: cell, {due}: stretch}}   # guess{why}"
    if not strain:
        yield "    # setup_compliance: …   # of grips, cell and frame; without it no verdict is given"
    yield "    # at: …                 # a time after a step, for k_t"
    yield "    specimens:"
    for number, each in enumerate(writer.surveys, start=1):
        columns: list[Bound] = [("time", _column(each, "time"), {}), ("force", _column(each, "force"), {})]
        found = each.first("displacement", "reading")
        assert found is not None
        yield f"      specimen-{number}:"
        yield "        readings:"
        yield from _readings(writer, each, [*columns, (due, found, {})], indent=10)


def _line(writer: _Writer) -> Iterator[str]:
    one = writer.surveys[0]
    force, moved = one.first("force"), one.first("displacement", "reading")
    assert force is not None
    assert moved is not None
    yield "# The slope of force against extension; 'rows: [first, last]' below 'readings' leaves the rest out."
    yield "fits:"
    yield "  force-extension:"
    yield "    readings:"
    names = [f"{column.name} / {column.unit}" if column.unit else column.name for column in (moved, force)]
    columns: list[Bound] = [(name, column, {}) for name, column in zip(names, (moved, force), strict=True)]
    yield from _readings(writer, one, columns, indent=6)
    yield f"    x: {quote(names[0])}"
    yield f"    y: {quote(names[1])}"
    yield ""
    yield "derived:"
    yield "  - quantity: k"
    yield "    description: slope of force against extension"
    yield "    expression: slope"
    yield "    where: {slope: force-extension.slope}"
    yield f"    unit: {force.unit}/{moved.unit}"


def _readings(writer: _Writer, one: Survey, columns: Sequence[Bound], *, indent: int) -> Iterator[str]:
    """The mapping under `readings:`."""
    space = " " * indent
    yield f"{space}file: {quote(one.path.resolve().relative_to(writer.folder.resolve()).as_posix())}"
    for key, value in one.stated.items():
        yield f"{space}{key}: {quote(value)}"
    yield f"{space}columns:"
    twice = [seen.heading for seen in one.columns]
    for name, seen, words in columns:
        named = seen.heading if seen.heading and twice.count(seen.heading) == 1 else str(seen.number)
        parts = [f"column: {quote(named)}"]
        in_file = seen.unit in seen.heading or one.title != "text"
        if not seen.unit and name in _UNLESS_STATED:
            guess = _UNLESS_STATED[name]
            parts += [f"unit: {guess or writer.ask(f'unit.{name}', f'unit of {seen.heading!r}, such as mm')}"]
        elif seen.unit and not in_file:
            parts += [f"unit: {quote(seen.unit)}"]
        parts += [f"words: {{{', '.join(f'{quote(word)}: {to}' for word, to in words.items())}}}"] if words else []
        yield f"{space}  {quote(name)}: {{{', '.join(parts)}}}   # guess{': by its heading' if seen.heading else ''}"


def quote(text: str) -> str:
    """A text as YAML has it: in quotes where it could be read as anything else."""
    if (
        _PLAIN.fullmatch(text)
        and text.strip() == text
        and text.casefold() not in ("null", "true", "false", "yes", "no")
    ):
        return text
    return json.dumps(text, ensure_ascii=False)
