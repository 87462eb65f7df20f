"""What a file can be evaluated as, by what its columns look like."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np

from metrology.draft.seen import Seen
from metrology.draft.survey import Survey

MAX_LOADS = 40
FEWEST = 20
"""Readings of a testing machine's record: fewer are a line through points. A choice: machines sample at 10 Hz and more,
and points that are read by hand are rarely more than this."""
HELD, COMES_TO_REST, LEVELS = 0.2, 0.1, 32
"""Part of the time of a record in one of so many parts of a channel's range, from which on it was held there, or came
to rest: a ramp spends a thirty-second in each, thus a sixteenth in the two that are counted together. Three times that
is held, with some to spare for the slower end of a ramp; what creeps or relaxes rests for half as long at least."""
AT_REST = 0.1
"""Part of the scatter of the column that moves most, below which another in its unit is of a sensor at rest. A choice:
columns along and across a motion, or as read and as filtered, differ by less or are both worth a look."""
STRETCHES = ("displacement", "strain", "reading")


def method(one: Survey) -> str:
    """What a file can be evaluated as: a method, or ``line``; empty where nothing is known."""
    if one.beside:
        return "response"
    if _in_steps(one):
        return "elongation"
    timed = one.first("time") is not None or one.step > 0 or one.found.rate > 0 or one.found.doubtful != ""
    if timed and driven(one) and moved(one):
        return "response"
    if pull(one) and one.first(*STRETCHES, "angle"):
        return "relaxation" if held(one) else "tension" if _recorded(one) else "line"
    return "decay" if timed and moved(one) is not None else ""


def _in_steps(one: Survey) -> bool:
    """Whether a few loads come again and again, or each once in a short table without time."""
    load, reading = load_of(one), one.first("reading", "displacement")
    if load is None or reading is None:
        return False
    levels, rows = len(set(load.words)), len(load.words)
    if not 3 <= levels <= MAX_LOADS:
        return False
    marked = one.first("repeat") is not None and one.first("direction") is not None
    again = levels * 3 <= rows and marked
    return again or (one.first("time") is None and one.step == 0 and rows <= 3 * levels and load.role != "force")


def read_again(one: Survey) -> int:
    """How often a load was read at most, where no column numbers the repeats; 0 where each was read once, or is none.

    Nobody but the laboratory knows whether a load that comes again was put on anew, or taken off to.
    """
    load, reading, way = load_of(one), one.first("reading", "displacement"), one.first("direction")
    if load is None or reading is None or load.role == "force" or one.first("repeat", "time") or one.step:
        return 0
    if not 3 <= len(set(load.words)) <= MAX_LOADS:
        return 0
    times = Counter(zip(load.words, way.words if way else load.words, strict=True))
    return most if (most := max(times.values())) > 1 else 0


def _recorded(one: Survey) -> bool:
    column = pull(one)
    return column is not None and len(column.words) >= FEWEST and one.first("displacement", "strain") is not None


def load_of(one: Survey) -> Seen | None:
    """The column of the loads of an elongation test."""
    return one.first("load", "mass", "force")


def pull(one: Survey) -> Seen | None:
    """The column of the force of a continuous record; a load that takes many values is a force."""
    load = one.first("load")
    many = load is not None and load.values is not None and len(set(load.words)) > MAX_LOADS
    thrust = driven(one)
    force = next((each for each in one.columns if each.role == "force" and each is not thrust), None)
    return force or (load if many else None)


def driven(one: Survey) -> Seen | None:
    """The column of the thrust: by its heading, or `F` beside another force."""
    forces = [each for each in one.columns if each.role == "force"]
    return one.first("thrust") or next((each for each in forces if each.name == "F" and len(forces) > 1), None)


def moved(one: Survey) -> Seen | None:
    """The column that shows a motion: the first; where another in its unit moves far more, that one was let go."""
    found = one.first("displacement", "angle", "reading") or one.first("velocity", "acceleration")
    if found is None or found.values is None:
        return found
    alike = [each for each in one.columns if (each.role, each.unit) == (found.role, found.unit)]
    most = max(alike, key=_spread)
    return most if _spread(found) < AT_REST * _spread(most) else found


def _spread(column: Seen) -> float:
    return 0.0 if column.values is None else float(np.nanstd(column.values))


def clock(one: Survey, column: Seen) -> Seen | None:
    """The time stamps of a column: where there are several, those whose heading shares most words with its own.

    Two sensors that are read in turn have stamps of their own each: ``Time A, Pos A, Time B, Pos B``.
    """
    found = [each for each in one.columns if each.role == "time"]
    words = _words(column.name)
    return max(found, key=lambda each: len(_words(each.name) & words), default=None)


def _words(name: str) -> set[str]:
    """Words of a name in lower case, numbers by themselves."""
    return set(re.findall(r"\d+|[^\W\d_]+", name.casefold()))


def held(one: Survey) -> str:
    """What a record of time, force and stretch holds, but for its beginning: ``elongation``, ``load``, or nothing."""
    time, force, stretch = one.first("time"), pull(one), one.first(*STRETCHES)
    if time is None or force is None or stretch is None:
        return ""
    spans = {"elongation": _longest(time, stretch), "load": _longest(time, force)}
    # What creeps, or relaxes, comes to rest as well: what is held has done so for longer.
    most = max(spans, key=lambda kind: spans[kind])
    # The force of a metal that flows hardly changes either, while the stretch grows as it did before.
    return most if spans[most] > HELD and min(spans.values()) > COMES_TO_REST else ""


def _longest(time: Seen, column: Seen) -> float:
    """Largest part of the time that a channel spends at one level but that of the beginning."""
    if time.values is None or column.values is None:
        return 0.0
    seen = np.isfinite(time.values) & np.isfinite(column.values)
    t, u = time.values[seen], column.values[seen]
    if len(t) < LEVELS or not np.ptp(u) > 0:
        return 0.0
    part = np.minimum((u - u.min()) / np.ptp(u) * LEVELS, LEVELS - 1).astype(int)
    spent = np.bincount(part, weights=np.gradient(t), minlength=LEVELS) / np.ptp(t)
    spent[max(part[0] - 1, 0) : part[0] + 2] = 0.0
    # A level may lie on the edge of two parts.
    return float((spent[1:] + spent[:-1]).max())
