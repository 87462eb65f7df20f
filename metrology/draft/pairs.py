"""Motion and force of one run in two files: found by what their names share, and by overlapping times."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from metrology import units
from metrology.draft.recognition import driven, method, moved, pull
from metrology.draft.survey import Survey
from metrology.units.dimensions import TextError

OVERLAP = 0.5
"""Part of the shorter record that two of one run have in common at least. A choice: clocks that were started by hand
differ by seconds, and records of different runs on one clock do not overlap at all."""


def paired(surveys: Sequence[Survey]) -> list[Survey]:
    """Runs with the file of the force beside that of the motion; as they were where not each has one of its own."""
    cells = [one for one in surveys if _is_cell(one)]
    motions = [one for one in surveys if not _is_cell(one) and moved(one) is not None and pull(one) is None]
    if not cells or len(cells) != len(motions) or len(cells) + len(motions) != len(surveys):
        return list(surveys)
    found = [_partner(one, cells) for one in motions]
    if any(cell is None for cell in found) or len({id(cell) for cell in found}) < len(cells):
        return list(surveys)
    return [replace(one, beside=(cell,)) for one, cell in zip(motions, found, strict=True) if cell is not None]


def _is_cell(one: Survey) -> bool:
    """Whether a file has a force over time, and no motion."""
    force = pull(one) or driven(one)
    return not method(one) and force is not None and one.first("time") is not None and moved(one) is None


def _partner(one: Survey, cells: Sequence[Survey]) -> Survey | None:
    """The file over the same times whose name shares most words; None where several do."""
    near = [cell for cell in cells if _overlap(one, cell)]
    shared = [sum((_words(one) & _words(cell)).values()) for cell in near]
    best = [cell for cell, count in zip(near, shared, strict=True) if count == max(shared)]
    return best[0] if len(best) == 1 else None


def _words(one: Survey) -> Counter[str]:
    """Words of a name, digits by themselves, with the part of the file that is read."""
    name = " ".join((one.path.name.partition(".")[0], *one.stated.values(), *map(str, one.rows or ())))
    return Counter(re.findall(r"\d+|[^\W\d_]+", name.casefold()))


def _overlap(one: Survey, other: Survey) -> bool:
    """Whether two records are over the same times, as far as their units are known."""
    spans = [_span(each) for each in (one, other)]
    if any(span is None for span in spans):
        return True
    (first, last), (begin, end) = (span for span in spans if span is not None)
    return min(last, end) - max(first, begin) >= OVERLAP * min(last - first, end - begin)


def _span(one: Survey) -> tuple[float, float] | None:
    time = one.first("time")
    if time is None or time.values is None or not time.unit:
        return None
    try:
        second = float(units.unit(time.unit).factor)
    except TextError:
        return None
    return float(np.nanmin(time.values)) * second, float(np.nanmax(time.values)) * second
