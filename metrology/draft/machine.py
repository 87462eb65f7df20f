"""Drafts of what a testing machine records: a pull, and an elongation or a load that is held; a file a specimen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from metrology.draft.parts import Writer, stretch, times
from metrology.draft.recognition import held, pull
from metrology.draft.seen import Seen
from metrology.draft.survey import Survey
from metrology.draft.vocabulary import reads_machine, reads_specimen
from metrology.tension.slope import LEAST

LENGTH = "free length between the grips, such as 60.0(2) mm"
STRAINS = ("%", "1", "‰", "mm/mm", "m/m", "in/in", "µm/m", "um/m")
"""Units of a strain."""
Stretch = Literal["crosshead", "extension", "strain"]
SAME = 1e-8
"""A strain whose correlation with the crosshead lacks less than this of 1 was computed from it: rounded to four digits
it lacks 5e-9, while noise of a thousandth of its range lacks 6e-6 (half the ratio of the variances)."""
MORE_STRETCH = 1.25
"""A record bends where the stretch up to 90 % of the force is this many times what 10 % to 40 % foretell: a choice, far
above the few per cent by which noise and seating change the ratio of a straight record."""
BENDS = "the record bends further up"
UPPER = (0.4, 0.5, 0.6, 0.7, 0.8, 0.0)
"""Parts of the largest force up to which a line may be drawn, the first with readings enough; none where none has."""
ANOTHER = 0.9
"""A second displacement is that of an extensometer where it moves by less than this part of what the crosshead moves:
what is the crosshead's own way, from another zero, moves by all of it. A choice."""
KINDS: dict[Stretch, str] = {"crosshead": "testing machine", "extension": "extensometer", "strain": "extensometer"}


def tension(writer: Writer) -> Iterator[str]:
    """Lines of a pull."""
    by = stretches(writer.surveys[0])
    alone = list(by) == ["crosshead"]
    yield from _instruments(writer, by, unclassed="crosshead")
    yield from writer.sample(length=LENGTH if alone else "", each=True)
    yield "tests:"
    yield "  tension:"
    yield "    method: tension"
    yield "    sample: sample"
    yield from writer.conduct()
    yield from _used(writer, by)
    if alone:
        yield "    # setup_compliance: …        # of grips, cell and frame; without it k holds theirs too"
    bends = any(_bends(writer.surveys[0], seen) for seen in by.values())
    if bends and (end := min(map(_end, writer.surveys), key=UPPER[::-1].index)):
        yield f"    range: {writer.take('range', f'{{share: [10 %, {100 * end:.0f} %]}}', BENDS)}"
    else:
        yield "    # range: {strain: [0.05 %, 0.25 %]}   # the longest straight part where nothing is said"
    yield "    # to_break: true             # where the specimens were pulled until they broke"
    yield from _specimens(writer, list(by))


def relaxation(writer: Writer) -> Iterator[str]:
    """Lines of a hold."""
    found = stretches(writer.surveys[0])
    # One channel answers, or is held: what reads the specimen, where it is there.
    due = next(key for key in reversed(KINDS) if key in found)
    by: dict[Stretch, Seen] = {due: found[due]}
    yield from _instruments(writer, by, unclassed="")
    yield from writer.sample(length=LENGTH if due != "crosshead" else "", each=True)
    yield "tests:"
    yield "  hold:"
    yield "    method: relaxation"
    yield "    sample: sample"
    yield from writer.conduct()
    yield f"    held: {held(writer.surveys[0])}   # guess: what rests while the other changes"
    yield from _used(writer, by)
    if due == "crosshead":
        yield "    # setup_compliance: …   # of grips, cell and frame; without it no verdict is given"
    yield "    # at: …                 # a time after a step, for k_t"
    yield from _specimens(writer, [due])


def stretches(one: Survey) -> dict[Stretch, Seen]:
    """Columns that read a stretch: crosshead, and an extensometer by its displacement or by its strain."""
    found: dict[Stretch, Seen] = {}
    strains: list[Seen] = []
    moved: list[Seen] = []
    for seen in one.columns:
        if seen.role not in ("displacement", "strain", "reading") or seen.values is None:
            continue
        if seen.role == "strain" or seen.unit in STRAINS:
            strains.append(seen)
        else:
            moved.append(seen)
    for seen in moved:
        found.setdefault("extension" if reads_specimen(seen.name) else "crosshead", seen)
    if "extension" not in found and (pair := _pair(moved)):
        found["crosshead"], found["extension"] = pair
    strains = [seen for seen in strains if "crosshead" not in found or not _follows(seen, found["crosshead"])]
    if strains:
        found.pop("extension", None)
        found["strain"] = max(strains, key=lambda seen: _with_force(one, seen))
    return {key: found[key] for key in KINDS if key in found}


def _pair(moved: Sequence[Seen]) -> tuple[Seen, Seen] | None:
    """Crosshead and extensometer of two displacements of which the heading of one alone says that it is the crosshead.

    testXpert calls the way that the strain is computed from ``Standardweg``, whatever reads it.
    """
    named = [seen for seen in moved if reads_machine(seen.name)]
    others = [seen for seen in moved if seen not in named]
    if len(named) != 1 or len(others) != 1 or named[0].unit != others[0].unit:
        return None
    if named[0].values is None or others[0].values is None:
        return None
    whole, part = (float(np.ptp(one[np.isfinite(one)])) for one in (named[0].values, others[0].values))
    return (named[0], others[0]) if 0 < part < ANOTHER * whole else None


def _with_force(one: Survey, seen: Seen) -> float:
    """How much a strain grows with the force: of several, those across the load shrink."""
    force = pull(one)
    if force is None or force.values is None or seen.values is None:
        return 0.0
    both = np.isfinite(force.values) & np.isfinite(seen.values)
    return float(np.cov(force.values[both], seen.values[both])[0, 1]) if np.count_nonzero(both) > 1 else 0.0


def _follows(seen: Seen, crosshead: Seen) -> bool:
    """Whether a strain is the crosshead's way over a length, as Bluehill computes it, and read by no extensometer."""
    if seen.values is None or crosshead.values is None:
        return False
    both = np.isfinite(seen.values) & np.isfinite(crosshead.values)
    return bool(np.corrcoef(seen.values[both], crosshead.values[both])[0, 1] > 1 - SAME)


def _bends(one: Survey, seen: Seen) -> bool:
    """Whether a record bends: to reach 90 % of the force takes more stretch than 10 % to 40 % tell."""
    force = pull(one)
    if force is None or force.values is None or seen.values is None:
        return False
    size = np.abs(force.values)  # compression may be below zero
    if not np.nanmax(size) > 0:
        return False
    low, middle, high = (seen.values[np.argmax(size >= share * np.nanmax(size))] for share in (0.1, 0.4, 0.9))
    straight = (0.9 - 0.1) / (0.4 - 0.1) * abs(middle - low)
    return bool(abs(high - low) > MORE_STRETCH * straight > 0)


def _end(one: Survey) -> float:
    """Part of the largest force up to which a line from 10 % of it has as many readings as it needs; 0 where none."""
    force = pull(one)
    if force is None or force.values is None:
        return 0.0
    size = np.abs(force.values)
    low, *ends = (int(np.argmax(size >= share * np.nanmax(size))) for share in (0.1, *UPPER[:-1]))
    return next((share for share, end in zip(UPPER, ends, strict=False) if end - low >= LEAST), 0.0)


def _instruments(writer: Writer, by: dict[Stretch, Seen], *, unclassed: str) -> Iterator[str]:
    force = pull(writer.surveys[0])
    assert force is not None
    yield "instruments:"
    yield from writer.instrument("cell", "load cell", stretch("force", force), graded="ISO 7500-1")
    for key, seen in by.items():
        graded = "" if key == unclassed else "ISO 9513"
        yield from writer.instrument(_name(key), KINDS[key], stretch(key, seen), first=False, graded=graded)


def _name(key: Stretch) -> str:
    return "crosshead" if key == "crosshead" else "extensometer"


def _used(writer: Writer, by: dict[Stretch, Seen]) -> Iterator[str]:
    """Which instrument reads what, and the gauge length where one is needed."""
    named = "".join(f", {key}: {_name(key)}" for key in by)
    yield f"    instruments: {{force: cell{named}}}   # guess: by the headings"
    if "extension" in by:
        found = writer.fact("gauge_length", "gauge_length")
        asked = "gauge length of the extensometer, such as 25.0(1) mm"
        yield f"    gauge_length: {found or writer.ask('gauge_length', asked)}"
    elif "crosshead" in by and (found := writer.fact("gauge_length", "gauge_length")):
        yield f"    gauge_length: {found}; k and C are by it, unless a free length is stated"


def _specimens(writer: Writer, keys: Sequence[Stretch]) -> Iterator[str]:
    yield "    specimens:"
    for number, one in enumerate(writer.surveys, start=1):
        force, by = pull(one), stretches(one)
        assert force is not None
        yield f"      specimen-{number}:"
        yield from writer.specimen(one, number, LENGTH)
        yield "        readings:"
        columns = [*times(one), stretch("force", force), *(stretch(key, by[key]) for key in keys if key in by)]
        crosshead = by.get("crosshead")
        why = {
            seen.number: f"{seen.number}: computed from the crosshead"
            for seen in one.columns
            if crosshead and seen.role == "strain" and _follows(seen, crosshead)
        }
        yield from writer.readings(one, columns, indent=10, why=why)
