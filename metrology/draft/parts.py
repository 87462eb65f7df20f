"""Lines of a draft that every method has: instruments, sample, conduct, and the mapping under `readings:`."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np

from metrology.draft.instruments import size_of
from metrology.draft.recognition import clock
from metrology.draft.seen import Seen
from metrology.draft.survey import Survey
from metrology.errors import printable

OPEN = "?"
"""Stands where only the laboratory knows the value; a campaign with it is refused there."""
MOST = 12
"""Columns that are left out, by name."""
_NOTHING: Mapping[int, str] = MappingProxyType({})
SECTION = ("diameter", "width", "thickness")
"""What a header block says of a section."""
_PLAIN = re.compile(r"[\w/.(°µ][\w /.()°%µ+-]*")


@dataclass(frozen=True)
class Bound:
    """A column that is due, the column of the file, what its words stand for, and whether it has a unit.

    `usual`: the unit that is taken where the file has none; asked for where it is empty.
    """

    due: str
    seen: Seen
    words: Mapping[str, str] = field(default_factory=dict)
    usual: str | None = None


@dataclass
class Writer:
    """What the lines of a draft are made from; `given` are values that the user stated, by the names of `missing`.

    `remarks`: what is to be known of the draft before it is used.
    """

    surveys: Sequence[Survey]
    folder: Path
    given: Mapping[str, str]
    missing: dict[str, str] = field(default_factory=dict)
    known: dict[str, None] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def ask(self, name: str, what: str) -> str:
        """The value that was given under a name, or a mark that it is missing."""
        self.known[name] = None
        if name in self.given:
            return quote(self.given[name])
        self.missing[name] = what
        return f'"{OPEN}"'

    def take(self, name: str, guess: str, why: str) -> str:
        """The value that was given under a name, or a guess with its reason as a comment."""
        self.known[name] = None
        return quote(self.given[name]) if name in self.given else f"{guess}   # guess: {why}"

    def common(self, key: str) -> str:
        """What all files say, or those of them that say anything; nothing where they differ."""
        said = dict.fromkeys(text for one in self.surveys if (text := one.fact(key)))
        return next(iter(said)) if len(said) == 1 else ""

    def differs(self, *keys: str) -> bool:
        """Whether the files say different things of a key."""
        return any(len({text for one in self.surveys if (text := one.fact(key))}) > 1 for key in keys)

    def fact(self, name: str, key: str) -> str:
        """The value that was given under a name, or what the files say; nothing where they say nothing, or differ."""
        self.known[name] = None
        stated = self.common(key)
        if self.differs(key) and name not in self.given:
            said = "; ".join(f"{one.path.name}: {one.fact(key) or 'nothing'}" for one in self.surveys)
            self.remarks.append(f"the files differ in '{key}' ({said})")
        return quote(self.given[name]) if name in self.given else f"{quote(stated)}   # from the file" if stated else ""

    def instrument(self, name: str, kind: str, bound: Bound, *, first: bool = True, graded: str = "") -> Iterator[str]:
        """What reads a column; the serial number of the file is that of the first. `graded`: standard of its class."""
        serial = self.common("serial") if first else ""
        yield f"  {name}:"
        yield f"    kind: {kind}   # guess"
        if serial:
            yield f"    serial: {quote(serial)}   # from the file"
        if graded:
            yield f"    class: {self.ask(f'class.{name}', f'class of the {kind} to {graded}, such as 0.5')}"
        resolution = "resolution" if first else f"resolution.{name}"
        unit = bound.seen.unit or self.given.get(f"unit.{bound.due}", "")
        open_mark = any(one.doubtful for one in self.surveys)
        digit = f"{bound.seen.resolution:.3g} {unit}".replace("e-0", "e-")
        if resolution in self.given or (unit and bound.seen.resolution and not open_mark):
            why = (
                "the step of the readings"
                if bound.seen.resolution > bound.seen.digit
                else "the last digit of the readings"
            )
            yield f"    resolution: {self.take(resolution, digit, why)}"
        else:
            self.known[resolution] = None
            shared = bound.seen.resolution or open_mark
            yield f"    # resolution: …{'' if shared else '   # the readings share no last digit'}"
        yield "    # certificate: {number: …, date: …, due: …, expanded_uncertainty: …, k: 2}"
        yield ""

    def sample(self, *, length: str = "", each: bool = False) -> Iterator[str]:
        """The sample; `length` says why its length has to be known, where it has to.

        `each`: whether every file has a specimen of its own, which may have a section and a length of its own.
        """
        yield "samples:"
        yield "  sample:"
        why = "the files have different names" if self.differs("sample") else "no name was found"
        name = self.common("sample") if self.differs("sample") else self.fact("sample", "sample")
        yield f"    name: {name or self.take('sample', 'sample', why)}"
        if self.differs(*SECTION):
            yield f"    # section: …   # {'of each specimen, below' if each else 'the files differ'}"
            if not each:
                self._tell_sections()
        elif section := section_of(self.surveys):
            yield f"    section: {section}"
        else:
            yield "    # section: {shape: tape, width: …, thickness: …}   # with a length, gives the modulus E"
        if each and self.differs("length") and "length" not in self.given:
            yield "    # length: …   # of each specimen, below"
            self.known["length"] = None
        elif found := self.fact("length", "length"):
            yield f"    length: {found}"
        elif length:
            yield f"    length: {self.ask('length', length)}"
        else:
            yield "    # length: …"
        yield ""

    def _tell_sections(self) -> None:
        said = "; ".join(
            f"{one.path.name}: {section_of([one]).partition('   #')[0] or 'nothing'}" for one in self.surveys
        )
        self.remarks.append(f"the files differ in the section of the sample ({said})")

    def specimen(self, one: Survey, number: int, length: str = "") -> Iterator[str]:
        """What one specimen has of its own, where the files differ: name, section and length."""
        if self.differs("sample") and (name := one.fact("sample")):
            yield f"        remark: {quote(name)}   # from the file"
        if self.differs(*SECTION):
            section = section_of([one])
            yield f"        section: {section}" if section else "        # section: …   # the file does not say it"
        if self.differs("length") and "length" not in self.given:
            found = one.fact("length")
            asked = "" if found else self.ask(f"length.specimen-{number}", f"{length or 'length'}, of {one.path.name}")
            yield f"        length: {quote(found)}   # from the file" if found else f"        length: {asked}"

    def conduct(self) -> Iterator[str]:
        """Day and operator, where the file has them."""
        days = {day for one in self.surveys if (day := one.date or one.fact("date"))}
        if len(days) == 1:
            yield f"    date: {days.pop()}   # from the file"
        elif days:
            yield f"    # date: …   # the files say {' and '.join(sorted(days)[:6])}"
        if operator := self.common("operator"):
            yield f"    operator: {quote(operator)}   # from the file"

    def readings(
        self, one: Survey, columns: Sequence[Bound], *, indent: int, why: Mapping[int, str] = _NOTHING
    ) -> Iterator[str]:
        """The mapping under `readings:`, and which columns are left out; `why`, by the number of a column."""
        space = " " * indent
        yield f"{space}file: {quote(one.path.resolve().relative_to(self.folder.resolve()).as_posix())}"
        for key, value in one.stated.items():
            yield f"{space}{key}: {self._key(one, key, value)}"
        if one.first("time") is None and one.found.rate and not one.step:
            yield f"{space}time: {{rate: {one.found.rate:.15g} Hz}}   # from the file"
        elif one.first("time") is None and one.found.doubtful and not one.step:
            asked = f"samples in a second, such as 200 Hz; the file has '{one.found.doubtful}', which may be misread"
            yield f"{space}time: {{rate: {self.ask('rate', asked)}}}"
        if one.rows is not None:
            many = sum(each.path == one.path and each.stated == one.stated for each in self.surveys) > 1
            stretch = f"{'a' if many else 'the longest'} stretch of stamps that increase"
            yield f"{space}rows: [{one.rows[0]}, {one.rows[1]}]   # guess: {stretch}"
        yield f"{space}columns:"
        for bound in columns:
            yield f"{space}  {quote(bound.due)}: {self._column(one, bound)}"
        used = {bound.seen.number for bound in columns}
        rest = [seen for seen in one.columns if seen.number not in used and any(seen.words) and not size_of(seen.name)]
        if rest:
            listed = ", ".join(
                f"{quote(seen.heading) if seen.heading else 'a column'} ({why.get(seen.number, seen.number)})"
                for seen in rest[:MOST]
            )
            others = f" and {len(rest) - MOST} more" if len(rest) > MOST else ""
            yield printable(f"{space}# left out: {listed}{others}")

    def _key(self, one: Survey, key: str, value: str) -> str:
        """How a file is read; asked for where it may be misread, marked as a guess where the file leaves it open."""
        if key == "decimal":
            self.known[key] = None
            if one.doubtful and key not in self.given:
                asked = f"decimal mark, such as point or comma, of '{one.doubtful}'"
                return self.ask(key, f"{asked}; take the marks out of the file if they group the digits")
        why = one.unsettled.get(key)
        return f"{quote(value)}   # guess: {why}" if why and key not in self.given else quote(value)

    def _column(self, one: Survey, bound: Bound) -> str:
        """One column of the mapping, marked as a guess."""
        seen = bound.seen
        twice = [column.heading for column in one.columns].count(seen.heading) > 1
        parts = [f"column: {quote(seen.heading if seen.heading and not twice else str(seen.number))}"]
        if not seen.unit and bound.usual is not None:
            asked = f"unit of '{seen.heading or f'column {seen.number}'}', such as {_example(bound.due)}"
            parts += [f"unit: {bound.usual or self.ask(f'unit.{bound.due}', asked)}"]
        elif seen.unit and not seen.with_unit:
            parts += [f"unit: {quote(seen.unit)}"]
        if bound.words:
            parts += [f"words: {{{', '.join(f'{quote(word)}: {to}' for word, to in bound.words.items())}}}"]
        why = ": by its heading" if seen.heading else ""
        if seen.role == "time" and one.other_rate:
            self.remarks.append(f"{one.path.name}: {one.other_rate}: find out which is right")
            why = f": {one.other_rate}"
        return f"{{{', '.join(parts)}}}   # guess{why}"


def section_of(surveys: Sequence[Survey]) -> str:
    """The section as the first file that says it has it; a tape where it has a width."""
    by = {key: next((text for one in surveys if (text := one.fact(key))), "") for key in SECTION}
    if by["diameter"]:
        return f"{{shape: round, diameter: {by['diameter']}}}   # from the file; state its uncertainty"
    if by["width"] and by["thickness"]:
        dimensions = f"width: {by['width']}, thickness: {by['thickness']}"
        return f"{{shape: tape, {dimensions}}}   # from the file; state its uncertainty"
    return ""


def stretch(due: str, seen: Seen) -> Bound:
    """A column whose unit is asked for where the file has none; a strain below one is a plain number."""
    small = due == "strain" and seen.values is not None and float(np.nanmax(np.abs(seen.values))) < 1
    return Bound(due, seen, usual="1" if small else "")


def times(one: Survey, of: Seen | None = None) -> list[Bound]:
    """The column of time stamps, whose unit is asked for where the file has none; none where there is none.

    `of`: the column whose stamps they are, where a file has several.
    """
    seen = clock(one, of) if of else one.first("time")
    of_day = seen is not None and seen.values is None
    return [] if seen is None else [Bound("time", seen, usual=None if of_day else "")]


def _example(due: str) -> str:
    return {"time": "s", "force": "N", "T": "N", "F": "N", "angle": "deg", "velocity": "mm/s", "acceleration": "m/s^2",
            "v": "m/s", "strain": "%"}.get(due, "mm")  # fmt: skip


def quote(text: str) -> str:
    """A text as YAML has it: in quotes where it could be read as anything else."""
    if (
        _PLAIN.fullmatch(text)
        and text.strip() == text
        and text.casefold() not in ("null", "true", "false", "yes", "no")
    ):
        return text
    return json.dumps(text, ensure_ascii=False)
