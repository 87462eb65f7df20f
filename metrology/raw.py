"""Checks of raw records before any model: readings that are held, repeated, or at the end of what can be shown.

Each finds by counting what a sound recorder gives by chance in fewer than one record of a million; a channel with less
noise than its last digit repeats by itself, and rests at its largest reading where the motion does: it is tested for
held readings alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import log, sqrt

import numpy as np

from metrology.check import Check
from metrology.message import said
from metrology.timeseries import Channel, Floats
from metrology.timeseries.white_noise import against_neighbours, quantum

Marks = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
Places = np.ndarray[tuple[int, ...], np.dtype[np.intp]]
NAME = "raw records"
FLAT = 5
"""Readings in a row at exactly the largest value from which on a peak may be clipped."""
CHANGES = 20
"""Changes of a reading that all fall on multiples of one number: by chance one in 2²⁰."""
EVEN = 0.01
"""Part of a step by which even stamps differ, for the digits of their file."""
STOPPED = 8
"""Readings in a row that are alike, from which on a record may have stopped, or ended where its range does."""
JUMP = 3.0
"""How much larger the step after a stop is than the usual largest one: one reading cannot catch up otherwise."""
WINDOW = 16
"""Readings in a row that stand twice in one record: where noise exceeds the last digit, one in 10⁹ by chance."""
COARSE = 1.5
"""Steps of the readings over the stated resolution: twice it in all readings is no chance, and rounding never less."""
FAR = 5.0
"""Standard deviations by which the count of repeated readings exceeds what rounding makes."""


CHANCE = 1e-3
"""Probability below which readings that are all multiples of a coarse step are no chance."""
TWICE = 1.0
"""Strain at which a specimen is twice as long: a unit or a length that is wrong makes one, and an elastomer, of which
the laboratory says so."""
SAME = 1e-6
"""Part of the largest step below which a difference of readings is rounding of their file."""


def check(channels: Mapping[str, Channel], resolution: float = 0.0) -> Check:
    """Whether all readings can have been taken as they stand: one check for all channels of a test, by their names.

    `resolution`: that of the instrument that read them all, as it is stated.
    """
    text = "{name}: {fault}"
    return check_of(
        [said(text, name=name, fault=one) for name, channel in channels.items() for one in faults(channel, resolution)]
    )


def check_of(found: Sequence[str]) -> Check:
    """Return the check of records in which this was found."""
    if not found:
        sentence = said("No reading is held, repeated or cut off at the end of a range.")
        return Check(NAME, None, None, True, sentence)
    sentence = said("{found}. Export the records again, or repeat the runs.", found=tuple(found))
    return Check(NAME, float(len(found)), None, False, sentence, effects=())


def faults(channel: Channel, resolution: float = 0.0) -> Iterator[str]:
    """What is wrong with one channel, in words."""
    value, even = channel.value, _counted(channel.value)
    if even and not _counted(channel.time):
        yield said("readings in steps that are all alike, at stamps that are not: time stands in its column")
    if not even and (step := quantum(channel)) > COARSE * resolution > 0:
        text = "readings are in steps of {step:.3g} {unit}; a resolution of {resolution:.3g} is stated"
        yield said(text, step=step, unit=channel.unit, resolution=resolution)
    held = updated(value)
    if held > 1:
        text = "each reading stands {count} times in a row, so that the rate is {count} times less than stated"
        yield said(text, count=held)
        return
    stopped = _stopped(channel)
    if stopped:
        yield said("{count} readings in a row are alike, and the next one jumps: the record stopped", count=stopped)
    is_noisy = noisy(channel)
    yield from _cut_off(channel, is_noisy=is_noisy)
    if not is_noisy:
        return
    if twice := _pairs(channel):
        yield said("{count} readings are those before them once more", count=twice)
    if count := again(value):
        yield said("{count} readings in a row stand in it twice", count=count)


def strained(name: str, strain: Floats) -> Iterator[str]:
    """What is wrong with the strain of a specimen while it is pulled, in words."""
    seen = strain[np.isfinite(strain)]
    span = float(np.ptp(seen)) if len(seen) else 0.0
    if span >= TWICE:
        text = "{name}: a strain of {part:.3g} %, so that the unit of a column or a length is wrong"
        yield said(text, name=name, part=100 * span)


def _cut_off(channel: Channel, *, is_noisy: bool) -> Iterator[str]:
    """Ends of the record, and peaks where noise exceeds the last digit, at the end of what can be shown."""
    value, unit = channel.value, channel.unit
    for sign in (1, -1):
        if flat := _flat_end(replace(channel, value=sign * value)):
            text = "the last {count} readings stand at {value:.4g} {unit}: cut off at the end of the range"
            yield said(text, count=flat, value=float(value[-1]), unit=unit)
        if is_noisy and (flat := flat_top(sign * value)):
            text = "{count} readings in a row stand at {value:.4g} {unit}: clipped"
            yield said(text, count=flat, value=float(sign * (sign * value).max()), unit=unit)


def coarse(value: Floats, resolution: float) -> float:
    """Step of a few readings that are multiples of more than the stated resolution; 0 where that may be chance."""
    steps = np.diff(np.unique(value))
    steps = steps[steps > SAME * steps.max(initial=0.0)]
    step = divisor(steps)
    times = step / resolution if resolution > 0 else 0.0
    return step if times > COARSE and (len(steps) - 1) * log(times) > -log(CHANCE) else 0.0


def divisor(steps: Floats) -> float:
    """Largest step of which all are multiples, to a hundredth of it, by Euclid's algorithm; 0 without any."""
    found = float(steps.min(initial=np.inf))
    while len(steps) and found > 0.0:
        rest = np.abs(steps - found * np.round(steps / found))
        wrong = rest[rest > 0.01 * found]
        if not len(wrong):
            return found
        found = float(wrong.min()) if wrong.min() > SAME * steps.max() else 0.0
    return 0.0


def _counted(value: Floats) -> bool:
    """Whether all steps are alike within the digits of a file, as stamps are and no reading is."""
    steps = np.diff(value)
    usual = float(np.median(steps)) if len(steps) > CHANGES else 0.0
    return usual != 0.0 and bool((abs(steps - usual) < EVEN * abs(usual)).all())


def updated(value: Floats) -> int:
    """How many readings in a row each value stands for, where that is one number throughout; else 1.

    A ramp that is rounded changes by its last digit in even steps too: there nearly every change is the smallest one.
    """
    steps = np.diff(value)
    changes = np.flatnonzero(steps)
    if len(changes) < CHANGES:
        return 1
    size = abs(steps[changes])
    return int(np.gcd.reduce(np.diff(changes))) if np.median(size) > (1 + EVEN) * size.min() else 1


def stretches(alike: Marks) -> tuple[Places, Places]:
    """First and last index + 1 of every stretch that is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], alike.astype(int), [0]])))
    return edges[::2], edges[1::2]


def _stopped(channel: Channel) -> int:
    """Length of the longest stretch of equal readings after which the next one jumps; 0 without any.

    At the lowest level of all, or at one where the readings rest more than once or have rested before, it may be a line
    that is slack, within the noise that it has there; a next one that jumps alone is a spike. Over a gap in the stamps
    the motion goes on, so that a step counts by its time.
    """
    value, apart = channel.value, np.diff(channel.time)
    steps = np.diff(value) / np.maximum(apart / np.median(apart), 1.0)
    usual = float(np.quantile(abs(steps), 0.995))
    first, last = stretches(steps == 0.0)
    long = last - first + 1 >= STOPPED
    first, last = first[long], last[long]
    near = max(JUMP * 1.4826 * float(np.median(abs(against_neighbours(channel)))), _digit(value)) if len(first) else 0.0
    level = np.sort(value[first])
    times = np.searchsorted(level, value[first] + near, "right") - np.searchsorted(level, value[first] - near)
    before = value[np.maximum(first[:, None] - np.arange(1, 2 * STOPPED + 1), 0)]
    # A single one of them may lie farther off.
    rested = (np.sort(abs(before - value[first, None]))[:, -2] <= near) & (first >= 2 * STOPPED)
    once = (times == 1) & ~rested & (value[first] > value.min() + near) & (last < len(steps))
    jumps = once & (abs(steps[np.minimum(last, len(steps) - 1)]) > JUMP * usual)
    next_, later = (value[np.minimum(last + more, len(value) - 1)] - value[first] for more in (1, 2))
    jumps &= abs(later) > 0.5 * abs(next_)
    return int((last - first + 1)[jumps].max(initial=0))


def flat_top(value: Floats) -> int:
    """Readings in a row at the largest value, where they are more than rounding makes of a peak; else 0."""
    first, last = stretches(value >= value.max() - 1e-9 * abs(value).max())
    inside = (first > 0) & (last < value.size)
    if not inside.any():
        return 0
    longest = int((last - first)[inside].max())
    at = int(first[inside & (last - first == longest)][0])
    # Of a swing of one step nothing lies between its extreme levels.
    step = _resolved(value) or float(np.diff(np.unique(value)).min(initial=np.inf))
    return longest if longest >= FLAT and _flatter(value, at, longest, step) else 0


def _flat_end(channel: Channel) -> int:
    """Readings at the largest value with which a record ends, where it had noise of some digits before; else 0."""
    value = channel.value
    off = np.flatnonzero(value < value.max() - 1e-9 * abs(value).max())
    count = value.size - 1 - int(off[-1]) if len(off) else 0
    if count < STOPPED or len(off) < CHANGES:
        return 0
    noise = 1.4826 * float(np.median(abs(against_neighbours(channel)[: off[-1]])))
    # What is read in steps as coarse as its noise may rest at the last one.
    steps = np.diff(np.unique(value))
    digit = divisor(steps[steps > SAME * steps.max()])
    return count if noise > JUMP * max(digit, SAME * float(np.ptp(value))) else 0


def _resolved(value: Floats) -> float:
    """Return the usual jump to or from two equal readings in a row, between the extreme levels; 0 without any.

    That is one step of an instrument that rounds, also where its steps are not multiples of one number.
    """
    jump = np.diff(value)
    inner = (value > value.min()) & (value < value.max())
    still = np.concatenate([[False], (jump == 0.0) & inner[1:], [False]])
    beside = (jump != 0.0) & inner[1:] & inner[:-1] & (still[:-2] | still[2:])
    return float(np.median(abs(jump[beside]))) if beside.any() else 0.0


def _flatter(value: Floats, first: int, longest: int, step: float) -> bool:
    """Tell whether a flat top is longer than a parabola through its flanks, rounded to `step`, would have it."""
    reach = min(longest, first, value.size - first - longest)
    if 2 * reach < longest:
        return False
    drop = value[first] - 0.5 * (value[first - reach] + value[first + longest - 1 + reach])
    # A parabola falls by so much of `drop` at half the flat length.
    return bool(drop * (longest / (longest + 2 * reach)) ** 2 > 2 * step)


def noisy(channel: Channel) -> bool:
    """Whether the noise exceeds the last digit, so that equal readings are chance."""
    off = abs(against_neighbours(channel))
    return bool((off > 0.0).any()) and 1.4826 * float(np.median(off[off > 0.0])) > _digit(channel.value)


MULTIPLES = 0.9
"""Part of the steps that are multiples of the smallest usual one where that is the last digit."""


def _digit(value: Floats) -> float:
    """Last digit of the readings: the smallest step that is usual among them, whatever a few stray ones are; or 0.

    An encoder whose steps are no multiples of one number reads in steps of the usual size.
    """
    steps = abs(np.diff(value))
    steps = np.sort(steps[steps > 0.0])
    if not len(steps):
        return 0.0
    levels, counts = np.unique(np.round(steps / np.median(steps), 6), return_counts=True)
    usual = levels[counts > max(3.0, 0.005 * len(steps))]
    if not len(usual) or usual[0] == 0.0:
        return 0.0
    found = float(usual[0] * np.median(steps))
    rest = abs(steps / found - np.round(steps / found))
    return found if (rest < 0.02 * np.maximum(1.0, steps / found)).mean() > MULTIPLES else float(np.median(steps))


def _pairs(channel: Channel) -> int:
    """Readings that are equal to the one before, and to no third, where they are more than rounding makes.

    With noise above the last digit q, steps of ±q are at least 1/0.7 times as many as equal pairs: for a normal
    distribution of the steps with standard deviation √2·q it is 2·exp(−1/4) = 1.56.
    """
    steps = np.diff(channel.value)
    first, last = stretches(steps == 0.0)
    pairs = int((last - first == 1).sum())
    q = _digit(channel.value)
    single = int((abs(abs(steps) - q) < 0.01 * q).sum()) if q else 0
    return pairs if pairs > 0.7 * single + FAR * sqrt(pairs + single) else 0


def again(value: Floats, window: int = WINDOW) -> int:
    """Length of the longest stretch of changing readings that stands twice in the record; 0 below `window`."""
    if len(value) < 2 * window:
        return 0
    sliding = np.lib.stride_tricks.sliding_window_view
    weights = np.random.default_rng(0).integers(1, 2**62, window, dtype=np.uint64)
    levels = np.unique(value, return_inverse=True)[1].astype(np.uint64)
    moving = sliding(np.diff(value) != 0.0, window - 1).sum(axis=1) > 0.8 * (window - 1)
    _, place, count = np.unique(sliding(levels, window) @ weights, return_inverse=True, return_counts=True)
    first, last = stretches(moving & (count[place] > 1))
    return int((last - first).max()) + window - 1 if len(first) else 0
