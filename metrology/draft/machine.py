"""Drafts of what a testing machine records: a pull, and an elongation or a load that is held; a file a specimen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

from metrology.draft.recognition import held, pull
from metrology.draft.survey import Seen, Survey
from metrology.draft.vocabulary import reads_specimen
from metrology.draft.writer import Writer, stretch, times

STRAINS = ("%", "1", "‰", "mm/mm", "m/m", "in/in", "µm/m", "um/m")
"""Units of a strain."""
Stretch = Literal["crosshead", "extension", "strain"]
KINDS: dict[Stretch, str] = {"crosshead": "testing machine", "extension": "extensometer", "strain": "extensometer"}


def tension(writer: Writer) -> Iterator[str]:
    """Lines of a pull."""
    by = stretches(writer.surveys[0])
    alone = list(by) == ["crosshead"]
    yield from _instruments(writer, by, unclassed="crosshead")
    yield from writer.sample(length="free length between the grips, such as 60.0(2) mm" if alone else "")
    yield "tests:"
    yield "  tension:"
    yield "    method: tension"
    yield "    sample: sample"
    yield from writer.conduct()
    yield from _used(writer, by)
    if alone:
        yield "    # setup_compliance: …        # of grips, cell and frame; without it k holds theirs too"
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
    yield from writer.sample(length="free length between the grips, such as 60.0(2) mm" if due != "crosshead" else "")
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
    for seen in one.columns:
        if seen.role not in ("displacement", "strain", "reading") or seen.values is None:
            continue
        if seen.role == "strain" or seen.unit in STRAINS:
            found.setdefault("strain", one.first("strain") or seen)
        else:
            found.setdefault("extension" if reads_specimen(seen.name) else "crosshead", seen)
    if "strain" in found:
        found.pop("extension", None)
    return {key: found[key] for key in KINDS if key in found}


def _instruments(writer: Writer, by: dict[Stretch, Seen], *, unclassed: str) -> Iterator[str]:
    force = pull(writer.surveys[0])
    assert force is not None
    yield "instruments:"
    yield from writer.instrument("cell", "load cell", force, graded="ISO 7500-1")
    for key, seen in by.items():
        graded = "" if key == unclassed else "ISO 9513"
        yield from writer.instrument(_name(key), KINDS[key], seen, first=False, graded=graded)


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


def _specimens(writer: Writer, keys: Sequence[Stretch]) -> Iterator[str]:
    yield "    specimens:"
    for number, one in enumerate(writer.surveys, start=1):
        force, by = pull(one), stretches(one)
        assert force is not None
        yield f"      specimen-{number}:"
        yield "        readings:"
        columns = [*times(one), stretch("force", force), *(stretch(key, by[key]) for key in keys if key in by)]
        yield from writer.readings(one, columns, indent=10)
