"""Checks of the records: readings that stand still, gaps, the set-up by which they were read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from metrology import raw
from metrology.check import Check
from metrology.message import said
from metrology.relaxation.checks.done import Done
from metrology.relaxation.evidence import HALF
from metrology.relaxation.test import RelaxationTest
from metrology.timeseries import Channel

GAPS = "gaps"
SETUP = "set-up compliance"
STILL = 8
"""Readings at rest, or at a level, from which on their scatter is judged."""
EARLY = 0.05
"""Part of its rise by which an answer moves at most while its input rests: warmth and settling of the grips."""
SCATTERS = 6.0
"""Median steps from one reading to the next by which two readings differ by chance: 6·0.95 σ of one, 4 σ of a step."""
LEAST = 4
"""Steps of a ramp from which on its last one is compared with those before."""
GAP = 8.0
"""Time between two readings, over the largest of the times before and after, from which on it is a gap."""


def records(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Readings that are held, repeated or cut off at the end of a range: what answered, and what was imposed."""
    force = test.held == "elongation"
    unit = "N" if force else "1" if test.by_strain else "m"
    channels = {}
    for one in done:
        channels[one.mounting.name] = Channel(one.mounting.name, one.mounting.time, test.shown(one.mounting)[1], unit)
    found = raw.check(channels, test.force_division if force else test.stretch_division)
    looked = (_clipped, _cut_off, _coarse, _early, _short, _strained)
    still = [words for one in done for check in looked for words in check(test, one)]
    if not still:
        return found
    sentence = said("{found}. Read what was imposed as it was, and repeat the test.", found=tuple(still))
    if found.passed is False:
        sentence = said("{texts:space}", texts=(found.sentence, sentence))
    return Check(raw.NAME, (found.statistic or 0.0) + len(still), None, False, sentence, effects=())


def _strained(test: RelaxationTest, one: Done) -> Iterator[str]:
    """A strain that no tape has."""
    shown, length = one.mounting.shown, one.mounting.length
    if test.by_strain or length is not None:
        over = 1.0 if test.by_strain or length is None else length.value
        yield from raw.strained(one.mounting.name, shown / over)


def _coarse(test: RelaxationTest, one: Done) -> Iterator[str]:
    """Multiples of a step in which nothing was said to be read, from rest to where the input first stands still.

    A steady ramp goes in even steps too, but for its first and last one.
    """
    u, _ = test.shown(one.mounting)
    first, last = raw.stretches(np.diff(u) == 0.0)
    begun = int(last[0]) if len(first) and first[0] == 0 else 0
    still = first[(last - first >= STILL) & (first > begun)]
    u = u[begun : int(still[0]) + 1 if len(still) else len(u)]
    way = np.diff(u)[1:-1]
    division = test.stretch_division if test.held == "elongation" else test.force_division
    if len(way) and np.ptp(way) > raw.EVEN * np.abs(way).max() and (step := raw.coarse(u, division)):
        text = "{specimen}: the input stands in steps of {step:.3g}, {division:.3g} is stated"
        yield said(text, specimen=one.mounting.name, step=float(step), division=float(division))


def _early(test: RelaxationTest, one: Done) -> Iterator[str]:
    """An answer before its cause: it rises while the same is read of the input, until that is first taken back.

    It may fall again while that lasts, as a held strip relaxes.

    Next to a change of the input one reading is left out, as the two need not be read at one instant; of a held load
    what goes on after a change is creep, and before the first one it is not.
    """
    u, y = test.shown(one.mounting)
    most, way = float(np.ptp(y)), np.sign(u[np.argmax(np.abs(u - u[0]))] - u[0])
    ahead = way * (u - u[0])
    back = np.flatnonzero(ahead < np.maximum.accumulate(ahead) - EARLY * np.ptp(u))
    until = int(back[0]) if len(back) else len(u)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(u[:until])) + 1, [until]])
    pairs = list(pairwise(edges.tolist()))[: None if test.held == "elongation" else 1]
    starts = [(a + (a > 0), b - 1) for a, b in pairs if b - a > 3]
    rise = max((float(np.max(way * (y[a:b] - y[a]))) for a, b in starts), default=0.0)
    if rise > max(EARLY * most, SCATTERS * float(np.median(np.abs(np.diff(y))))):
        text = "{specimen}: the answer moves by {part:.2g} % of its rise while its input reads the same: it was held"
        yield said(text, specimen=one.mounting.name, part=100 * float(rise) / most)


def _short(test: RelaxationTest, one: Done) -> Iterator[str]:
    """An input that is read short at the end of its ramp, while the answer goes on as before: its range ended.

    Channels that are read one after the other differ at the end of a ramp too, by as much and the other way at its
    start; an answer that relaxes falls behind its input. Steps are over those next to them within the ramp.
    """
    u, y = test.shown(one.mounting)
    first, last = raw.stretches(np.diff(u) != 0.0)
    # A last digit that flickers at rest is no ramp.
    ramps = np.flatnonzero(np.abs(u[last] - u[first]) > EARLY * np.ptp(u))
    if not len(ramps) or (last - first)[ramps[0]] < LEAST:
        return
    du, dy = (np.diff(each)[first[ramps[0]] : last[ramps[0]]] for each in (u, y))
    if not dy.sum():
        # An answer that was held for the whole ramp, which other checks see.
        return
    ahead = [dy[end] * du[within] / dy[within] - du[end] if dy[within] else 0.0 for end, within in ((0, 1), (-1, -2))]
    start, stop = (float(each / du.sum()) for each in ahead)
    noise = SCATTERS * float(np.median(np.abs(np.diff(y)))) / abs(float(dy.sum()))
    if (short := stop + min(start, 0.0)) > max(EARLY, noise):
        text = (
            "{specimen}: the input falls behind the answer by {part:.2g} % at the end of the ramp: clipped, or not "
            "read while it moved"
        )
        yield said(text, specimen=one.mounting.name, part=100 * short)


def _clipped(test: RelaxationTest, one: Done) -> Iterator[str]:
    """Levels at which what was imposed stands still though it was read: at rest, before the ramp, it scattered.

    What was commanded, or rests below its last digit, is alike at rest too.
    """
    u, _ = test.shown(one.mounting)
    time = one.mounting.time - one.mounting.time[0]
    rest = u[time < one.levels.before]
    if len(rest) < STILL or float(np.median(np.abs(np.diff(rest)))) == 0:
        return
    for level in one.levels.held:
        held = u[(time > level.start) & (time < level.stop)]
        if len(held) >= STILL and float(np.mean(np.diff(held) == 0)) > HALF:
            yield said(
                "{specimen}: the input stands at {value:.4g} for {duration:.3g} s: clipped, where it scattered before "
                "the ramp",
                specimen=one.mounting.name,
                value=float(np.median(held)),
                duration=float(level.duration),
            )


def _cut_off(test: RelaxationTest, one: Done) -> Iterator[str]:
    """Readings of the answer that stand at its largest value to the end, though it scatters on its way."""
    _, y = test.shown(one.mounting)
    off = np.abs(y - y[0])
    at_end = len(y) - 1 - int(np.flatnonzero(off < off.max())[-1]) if off.any() else 0
    if at_end >= STILL and raw.noisy(Channel(one.mounting.name, one.mounting.time, y)):
        text = "{specimen}: the last {count} readings of the answer stand at {value:.4g}: clipped"
        yield said(text, specimen=one.mounting.name, count=at_end, value=float(y[-1]))


def gaps(done: Sequence[Done]) -> Check:
    """Times without readings, and whether the input was the same before and after."""
    seen, moved = [], []
    for one in done:
        time = one.mounting.time
        steps = np.diff(time)
        around = np.maximum(np.append(steps[1:], steps[-1]), np.append(steps[0], steps[:-1]))
        for at in np.flatnonzero(steps > GAP * around).tolist():
            text = "{specimen}: {duration:.3g} s from {start:.4g} s on"
            start = float(time[at] - time[0])
            words = said(text, specimen=one.mounting.name, duration=float(steps[at]), start=start)
            seen.append(words)
            if _moves(one, at):
                moved.append(words)
    if moved:
        text = "The input moved while nothing was read: {gaps}. The course between is not known."
        return Check(GAPS, float(len(seen)), None, False, said(text, gaps=tuple(moved)))
    text = "Without readings at a level that was held: {gaps}." if seen else "No gap in the stamps."
    sentence = said(text, gaps=tuple(seen))
    return Check(GAPS, float(len(seen)), None, True, sentence)


def _moves(one: Done, at: int) -> bool:
    of, time = one.scene.answer.of, one.mounting.time
    begin, end = (float(time[place] - time[0]) for place in (at, at + 1))
    return not any(each.start - 1e-9 <= begin and end <= each.stop + 1e-9 for each in one.levels.held) and not (
        end <= one.levels.before or begin >= float(of.time[-1])
    )


def setup(test: RelaxationTest) -> Check:
    """Whether the stretch was read apart from the compliance of grips, cell and frame."""
    if test.setup is not None:
        sentence = said("The compliance of the set-up is known by its calibration, and taken off.")
        return Check(SETUP, None, None, True, sentence)
    sentence = said(
        "The crosshead moves by the stretch of the specimen and of grips, cell and frame, and these relax too: k and E "
        "are too small by an unknown part. State 'setup_compliance' (0 um/N with its uncertainty where it is small), "
        "or use an extensometer."
    )
    return Check(SETUP, None, None, False, sentence)
