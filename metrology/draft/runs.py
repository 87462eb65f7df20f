"""Files to the runs that they hold: each stretch of time stamps, and each sheet or group that looks like one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from metrology.draft.instruments import size_of
from metrology.draft.recognition import FEWEST, method
from metrology.draft.seen import Seen
from metrology.draft.survey import Survey, survey
from metrology.errors import MetrologyError
from metrology.readings.sheet import SeveralPartsError

LEAST = 0.1
"""Part of the longest stretch of a file that another has at least, to be a run of its own. A choice: what a recorder
writes before it is started anew is shorter, and runs of one test are of about one length."""
MOST = 6
"""Stretches that are told by their lines."""
SEVERAL = ("decay", "response", "tension", "relaxation")
"""What may have several runs, releases or specimens."""


def found_in(path: Path, parts: Mapping[str, str]) -> list[Survey]:
    """Every run that a file holds; the file as a whole where it is none that has several.

    Raises
    ------
    MetrologyError
        For a file that cannot be read, in which no table was found, or of whose parts none, or several of a kind of
        which a test has one, look like a run.
    """
    try:
        whole = [survey(path, parts)]
    except SeveralPartsError as several:
        whole = list(_parts(path, parts, several))
        if not whole or any(method(one) not in SEVERAL for one in whole):
            raise
    return [run for one in whole for run in stretches(one)]


def _parts(path: Path, parts: Mapping[str, str], several: SeveralPartsError) -> Iterator[Survey]:
    """The parts of a file that look like a run; the first of them tells which others are left out."""
    found: list[Survey] = []
    lost: list[str] = []
    for name in several.names:
        with suppress(MetrologyError):
            one = survey(path, {**parts, several.kind: name})
            if method(one):
                found.append(one)
                continue
        lost.append(f"the {several.kind} '{name}' is left out, as it looks like no run")
    yield from (replace(one, lost=tuple(lost) if one is found[0] else ()) for one in found)


def stretches(one: Survey) -> list[Survey]:
    """The stretches of a file in which time stamps increase, as runs of their own where they start again further down.

    What is left out is among the `lost` of the first.
    """
    time = one.first("time")
    if time is None or time.values is None:
        return [one]
    ends = np.flatnonzero(~(np.diff(time.values) > 0)) + 1
    if not len(ends):
        return [one]
    edges = list(pairwise([0, *ends.tolist(), len(time.values)]))
    longest = max(edges, key=lambda edge: edge[1] - edge[0])
    runs = [longest]
    if method(one) in SEVERAL:
        least = max(FEWEST, LEAST * (longest[1] - longest[0]))
        runs = [
            edge for edge in edges if edge == longest or (edge[1] - edge[0] >= least and _again(time, edge, longest))
        ]
    left = [edge for edge in edges if edge not in runs]
    cut = [_cut(one, *edge) for edge in runs]
    if not left:
        return cut
    rows = ", ".join(f"{one.lines[first]} to {one.lines[after - 1]}" for first, after in left[:MOST])
    many = f" and {len(left) - MOST} more stretches" if len(left) > MOST else ""
    lost = f"rows {rows}{many} are left out, as time stamps do not increase there"
    return [replace(cut[0], lost=(*one.lost, lost)), *(replace(each, lost=()) for each in cut[1:])]


def _again(time: Seen, edge: tuple[int, int], longest: tuple[int, int]) -> bool:
    """Whether a stretch begins anew, and does not go on where the longest ends, or end where that begins."""
    assert time.values is not None
    first, last = (time.values[longest[0]], time.values[longest[1] - 1])
    return bool(time.values[edge[0]] < last and time.values[edge[1] - 1] > first)


def _cut(one: Survey, first: int, after: int) -> Survey:
    columns = tuple(
        # A size of the specimen may stand on the first row alone.
        seen
        if seen.constant and size_of(seen.name)
        else replace(
            seen,
            values=None if seen.values is None else seen.values[first:after],
            words=seen.words[first:after],
            written=seen.written[first:after],
        )
        for seen in one.columns
    )
    return replace(
        one, columns=columns, lines=one.lines[first:after], rows=(int(one.lines[first]), int(one.lines[after - 1]))
    )


def remarks(runs: Sequence[Survey]) -> Iterator[str]:
    """What of files is left out, a sentence each."""
    yield from (f"{one.path.name}: {sentence}" for one in runs for sentence in one.lost)
