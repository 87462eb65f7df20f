"""Where the free motion of a record begins, a first guess of a heavily damped one, and records that are refused."""

from __future__ import annotations

from math import pi

import numpy as np

from metrology.decay.oscillation import Floats, Mode, baseline
from metrology.message import said
from metrology.raw import flat_top
from metrology.timeseries import Channel
from metrology.timeseries.white_noise import noise

_FEWEST_SAMPLES = 60
_SEEN = 5.0  # standard uncertainties of a mean, or of a mean square, from which on a block of readings is not at rest
_LARGER = (
    10.0  # times that the motion was larger than a rest: what still decays is no more than that in 3/2 of the time
)
_HEAVY = 0.25  # of an overshoot over the excursion before it, below which ζ is above 0.4 and little is left after it


class Unusable(Exception):  # noqa: N818  # not an error: the record is turned into a sentence of the report
    """A record from which no decay can be taken, with the sentence that says why."""


def free_motion(record: Channel, expected: float | None) -> tuple[Channel, bool]:
    """Return the record from the first time that it crosses its rest position after its largest excursion.

    Plateau before the release and the pull of the magnet while it dies away both lie before that. With an expected
    frequency, motion much slower and much faster is left out of account. Where nothing crosses, the record's own
    zero of time is taken for the release, or its first sample. A heavily damped motion has next to nothing left by
    then: it is taken from where it has fallen by a tenth of its largest excursion, and the second value is true.
    """
    rest = float(np.median(record.value[2 * record.value.size // 3 :]))
    away = record.value - rest
    if expected is not None:
        period = int(min(2 * pi / expected / record.step, record.value.size / 2))
        quick, slow = (np.convolve(away, np.ones(n) / n, mode="same") for n in (max(period // 4, 1), max(period, 1)))
        away = (quick - slow) * (abs(np.arange(away.size) - away.size / 2) < away.size / 2 - period)
    top = int(np.argmax(abs(away)))
    crossed = np.flatnonzero(away[top:] * np.sign(away[top]) < 0)
    start = record.time[top + crossed[0]] if crossed.size else np.inf
    if expected is None and _overshoot(away, top, noise(record)) < _HEAVY:
        fallen = top + np.flatnonzero(away[top:] * np.sign(away[top]) < 0.9 * abs(away[top]))[0]
        # A largest excursion near the end is no release, and no damping.
        if len(record) - fallen >= _FEWEST_SAMPLES:
            return record.part(float(record.time[fallen])), True
    if (record.time >= start).sum() < _FEWEST_SAMPLES:
        start = max(0.0, float(record.time[0]))
    if (record.time >= start).sum() < _FEWEST_SAMPLES:
        raise Unusable(
            said(
                "The record is too short: fewer than {count} samples after the release. Record three periods at least.",
                count=_FEWEST_SAMPLES,
            )
        )
    return record.part(float(start)), False


def until_rest(free: Channel, main: Mode) -> tuple[Channel, float | None]:
    """Return the record up to twice the time from which on nothing moves, and that time; all of it where it is shorter.

    What follows says nothing of the motion that a part as long as the motion does not: that tells its zero, and what
    holds the body beside it. The last third is at rest where the motion was ten times as large, in mean square a
    hundred times; with it every block of one period in which neither mean nor mean square differs from it by five
    standard uncertainties.
    """
    t, last = free.time - free.time[0], 2 * len(free) // 3
    number = (t * main.frequency).astype(int)
    count = np.bincount(number)
    full = np.maximum(count, 1)
    away = free.value - free.value[last:].mean()
    mean, square = np.bincount(number, away) / full, np.bincount(number, away**2) / full
    level, resting = float(np.mean(away[last:] ** 2)), np.arange(len(count)) > number[last]
    if square.max() < _LARGER**2 * level or not resting.any():
        return free, None
    # White noise moves means, and mean squares, by so much; coloured noise by more.
    by = resting & (count > 0)
    of_mean = np.maximum(level / full, float(np.mean(mean[by] ** 2)))
    of_square = np.maximum(2 * level**2 / full, float(np.mean((square[by] - level) ** 2)))
    moves = (abs(mean) > _SEEN * np.sqrt(of_mean)) | (square - level > _SEEN * np.sqrt(of_square))
    rest = float((np.flatnonzero(moves & (count > 0))[-1] + 1) / main.frequency)
    end = float(free.time[0]) + 2 * rest
    if 2 * rest >= t[-1] or (free.time <= end).sum() < _FEWEST_SAMPLES:
        return free, None
    return free.part(float(free.time[0]), end), float(free.time[0]) + rest


def refuse_short(record: Channel) -> None:
    """Refuse a record of too few samples, or of one value."""
    if len(record) < _FEWEST_SAMPLES:
        text = "The record is too short: {count} samples, where {least} are needed at least."
        raise Unusable(said(text, count=len(record), least=_FEWEST_SAMPLES))
    if not np.ptp(record.value) > 0:
        raise Unusable(said("The record stands still, but for single readings. Check the range of the sensor."))


def _overshoot(away: Floats, top: int, level: float) -> float:
    """Return the largest excursion to the other side after the largest of all, over it; 1 where noise is no smaller.

    It is e^{−πζ/√(1 − ζ²)} after a release from rest: 0.37 for ζ = 0.3, 0.15 for 0.5, 0.0015 for 0.9.
    """
    size = float(abs(away[top]))
    if size < 50 * level or (away[top:] * np.sign(away[top]) > 0.9 * size).all():
        return 1.0
    return float(np.max(-np.sign(away[top]) * away[top:])) / size


def heavy(free: Channel) -> Mode | None:
    """Return a first guess of a heavily damped mode: x″ + 2λ·x′ + ω_n²·(x − x₀) = 0, integrated twice and fitted.

    Integrals do not multiply noise as derivatives would, and stand at any stamps. None where that is no oscillation.
    """
    t = free.time - free.time[0]
    slow = baseline(t)
    if (free.value - slow @ (slow.T @ free.value)).std() < 1e-9 * abs(free.value).max():
        return None
    once = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (free.value[1:] + free.value[:-1]))])
    twice = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (once[1:] + once[:-1]))])
    columns = np.column_stack([-once, -twice, np.ones_like(t), t, t**2])
    size = np.linalg.norm(columns, axis=0)
    damping, stiffness = (np.linalg.lstsq(columns / size, free.value, rcond=None)[0] / size)[:2].tolist()
    if not (stiffness > 0 and damping > 0):
        return None
    # Noise lessens the estimates: near critical damping the difference may come out negative.
    return Mode(float(np.sqrt(max(stiffness - 0.25 * damping**2, 0.1 * stiffness))), 0.5 * damping)


def refuse_clipped(free: Channel) -> None:
    """Refuse a record whose extrema are flat for longer than rounding makes them."""
    for sign in (1, -1):
        value = sign * free.value
        if flat := flat_top(value):
            raise Unusable(
                said(
                    "The record is clipped: {count} samples in a row stand at {level:.4g} {unit}. The range of the "
                    "sensor was too small; repeat with a larger range or a smaller release.",
                    count=int(flat),
                    level=float(sign * value.max()),
                    unit=free.unit,
                )
            )
