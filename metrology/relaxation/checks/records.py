"""Checks of the records: readings that stand still, gaps, the set-up by which they were read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from metrology import raw
from metrology.check import Check
from metrology.relaxation.checks.done import Done
from metrology.relaxation.evidence import HALF
from metrology.relaxation.test import RelaxationTest
from metrology.timeseries import Channel

GAPS = "gaps"
SETUP = "set-up compliance"
STILL = 8
"""Readings at rest, or at a level, from which on their scatter is judged."""
GAP = 8.0
"""Time between two readings, over the largest of the times before and after, from which on it is a gap."""


def records(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Readings that are held, repeated or cut off at the end of a range: what answered, in every specimen."""
    force = test.held == "elongation"
    unit = "N" if force else "1" if test.by_strain else "m"
    channels = {}
    for one in done:
        value = one.mounting.force if force else one.mounting.stretch
        channels[one.mounting.name] = Channel(one.mounting.name, one.mounting.time, value, unit)
    found = raw.check(channels, test.force_division if force else test.stretch_division)
    still = [words for one in done for words in _clipped(test, one)]
    if not still:
        return found
    sentence = f"{'; '.join(still)}: clipped, where they scattered before the ramp. Repeat the test within the range."
    sentence = f"{found.sentence} {sentence}" if found.passed is False else sentence
    return Check(raw.NAME, (found.statistic or 0.0) + len(still), None, False, sentence)


def _clipped(test: RelaxationTest, one: Done) -> Iterator[str]:
    """Levels at which what was imposed stands still though it was read: at rest, before the ramp, it scattered.

    What was commanded, or rests below its last digit, is alike at rest too.
    """
    u = one.mounting.stretch if test.held == "elongation" else one.mounting.force
    time = one.mounting.time - one.mounting.time[0]
    rest = u[time < one.levels.before]
    if len(rest) < STILL or float(np.median(np.abs(np.diff(rest)))) == 0:
        return
    for level in one.levels.held:
        held = u[(time > level.start) & (time < level.stop)]
        if len(held) >= STILL and float(np.mean(np.diff(held) == 0)) > HALF:
            yield f"{one.mounting.name}: the input stands at {float(np.median(held)):.4g} for {level.duration:.3g} s"


def gaps(done: Sequence[Done]) -> Check:
    """Times without readings, and whether the input was the same before and after."""
    seen, moved = [], []
    for one in done:
        time = one.mounting.time
        steps = np.diff(time)
        around = np.maximum(np.append(steps[1:], steps[-1]), np.append(steps[0], steps[:-1]))
        for at in np.flatnonzero(steps > GAP * around).tolist():
            words = f"{one.mounting.name}: {steps[at]:.3g} s from {time[at] - time[0]:.4g} s on"
            seen.append(words)
            if _moves(one, at):
                moved.append(words)
    if moved:
        sentence = f"The input moved while nothing was read: {'; '.join(moved)}. The course between is not known."
        return Check(GAPS, float(len(seen)), None, False, sentence)
    sentence = f"Without readings at a level that was held: {'; '.join(seen)}." if seen else "No gap in the stamps."
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
        return Check(
            SETUP, None, None, True, "The compliance of the set-up is known by its calibration, and taken off."
        )
    sentence = (
        "The crosshead moves by the stretch of the specimen and of grips, cell and frame, and these relax too: k and E "
        "are too small by an unknown part. State 'setup_compliance' (0 um/N with its uncertainty where it is small), "
        "or use an extensometer."
    )
    return Check(SETUP, None, None, False, sentence)
