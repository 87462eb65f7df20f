"""Jumps of the oscillation itself: a hand still on it, a knock, samples that are missing behind evenly numbered stamps.

What comes before such a moment and what comes after it are two decays, and no law of the motion joins them.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.polynomial.legendre import legvander

from metrology.decay.hop import CLEAR, SEEN, SHARP, after, forms, level, only
from metrology.decay.oscillation import Fit, Floats, baseline, tangent
from metrology.timeseries import Channel

NEAR = 2.0
"""Periods on either side of a jump within which it has to be seen by itself."""
ALIKE = 2.0
"""Times the noise, in variance, that may be left near a jump: there a misfit adds as much as the noise does."""
MULTIPLES = (2, 3, 4, 5)
"""Multiples of the decay's frequency that a bent spring makes."""


@dataclass(frozen=True)
class Jump:
    """A jump of the oscillation: time / s of the first reading after it.

    `keeps_later`: whether the later part of the record tells more of the decay, and is kept.
    """

    time: float
    keeps_later: bool


def jumped(free: Channel, fitted: Fit, noise: float) -> Jump | None:
    """Return the jump of the phase that explains most of a record; None where noise alone may do as much.

    From a moment on the oscillation has another amplitude and another phase, beside whatever a smooth law makes of
    both. Each place is a candidate (ln n), the phase has the price of unit information (½·ln n). A jump of the
    amplitude alone is one of the gain, and none. The phase has to be seen to jump within a few periods as well.

    Parameters
    ----------
    free : Channel
        Record from the release on.
    fitted : Fit
        Of it, at its full rate.
    noise : float
        Standard deviation of the readings.
    """
    t, main = free.time - free.time[0], fitted.main
    # A jump makes lines beside the decay: they are no modes here.
    kept = [at for at, mode in enumerate(fitted.modes) if not at or abs(mode.omega / main.omega - 1.0) > 0.5]
    fast = only(fitted, kept)
    ways = _ways(t, fitted)
    beside = [baseline(t, settling=fast.settling), tangent(t, fast)[:, fast.slow :], forms(t, fast)]
    Q = np.linalg.qr(np.hstack(beside))[0]
    residual = free.value - Q @ (Q.T @ free.value)
    along = [after(Q * way[:, None]) for way in ways.T]
    pull = after(residual[:, None] * ways)
    whole, pairs = after(ways[:, [0, 0, 1]] * ways[:, [0, 1, 1]]), ((0, 0), (0, 1), (1, 1))
    aa, ab, bb = (whole[:, at] - np.sum(along[i] * along[j], axis=1) for at, (i, j) in enumerate(pairs))
    phase = bb - ab**2 / np.where(aa > 0.0, aa, np.inf)  # of the phase, beside the amplitude and all that is fitted
    seen = (aa > SEEN * np.minimum(whole[:, 0], whole[0, 0] - whole[:, 0])) & (
        phase > SEEN * np.minimum(whole[:, 2], whole[0, 2] - whole[:, 2])
    )
    if not seen.any():
        return None
    turned = np.where(seen, (pull[:, 1] - ab / np.where(seen, aa, 1.0) * pull[:, 0]) / np.where(seen, phase, 1.0), 0.0)
    grown = np.where(seen, (pull[:, 0] - ab * turned) / np.where(seen, aa, 1.0), 0.0)
    at = int(np.argmax(np.where(seen, turned * pull[:, 1] + grown * pull[:, 0], 0.0)))
    later = np.arange(len(t)) >= at
    shapes = ways * later[:, None] - Q @ np.column_stack([one[at] for one in along])
    rest = residual - shapes @ np.array([grown[at], turned[at]])
    alone = shapes[:, 1] - ab[at] / aa[at] * shapes[:, 0]
    variance = level(t, alone, rest, (Q, fast), noise) / phase[at]
    evidence = 0.5 * float(turned[at]) ** 2 / variance - 1.5 * log(len(t))
    if evidence < CLEAR or (time := _sharpest(free, fitted, float(free.time[at]), noise)) is None:
        return None
    known = [_information(t[part], ways[part]) for part in (free.time < time, free.time >= time)]
    return Jump(time, known[1] > known[0])


def _ways(t: Floats, fitted: Fit) -> Floats:
    """The fitted decay, and the same a quarter of a turn later, shape (n, 2): its changes by amplitude and by phase."""
    main, (a, b) = fitted.main, fitted.coefficients[0]
    z = complex(a, -b) * np.exp(np.clip(-main.rate * t, -60.0, 6.0) + 1j * main.omega * t)
    return np.column_stack([z.real, -z.imag])


def _information(t: Floats, ways: Floats) -> float:
    """What a part of the decay tells of its frequency and rate."""
    weight = np.sum(ways**2, axis=1)
    total = float(weight.sum())
    return float(weight @ (t - weight @ t / total) ** 2) if total > 0 else 0.0


def _sharpest(free: Channel, fitted: Fit, time: float, noise: float) -> float | None:
    """Time at which the phase is seen to jump within a few periods; None where it turns there in another way.

    Among the readings next to the place found in the whole record it is the one at which the jump explains most. The
    residual there is noise: no more than twice that of the readings, or of the periods beside it. A stop that is
    touched no longer turns the phase faster from then on, and is touched before. Next to the ends nothing can be
    said.
    """
    width = NEAR / fitted.main.frequency
    inside = (free.time >= free.time[0] + width) & (free.time <= free.time[-1] - width)
    places = free.time[(np.abs(free.time - time) <= 0.25 * width / NEAR) & inside]
    tried = [(found[1], float(place), found[0]) for place in places
             if (found := _near(free, fitted, float(place), width)) is not None]  # fmt: skip
    if not tried:
        return None
    left, place, phase = min(tried)
    others = [one for by in (-2 * width, 2 * width) if (one := _near(free, fitted, place + by, width)) is not None]
    usual = max(noise**2, min((one[1] for one in others), default=0.0))
    # What a misfit alone makes of the phase, as where a line goes slack for a part of each period, it makes there too.
    clear = abs(phase) - max((abs(one[0]) for one in others), default=0.0)
    return place if left < ALIKE * usual and clear > SHARP * max(usual, left) ** 0.5 else None


def _near(free: Channel, fitted: Fit, time: float, width: float) -> tuple[float, float] | None:
    """Share of a jump of the phase in the readings near a time, of unit variance for noise of 1, and variance left.

    Beside it stand a smooth change of zero, amplitude and phase, rates of these two that are others from then on, and
    multiples of the decay. None where there are too few readings.
    """
    near = np.abs(free.time - time) <= width
    t, scaled, later = free.time[near] - free.time[0], (free.time[near] - time) / width, free.time[near] >= time
    ways = _ways(t, fitted)
    z = ways[:, 0] - 1j * ways[:, 1]
    smooth = [way[:, None] * legvander(scaled, 2) for way in ways.T]
    multiples = [part[:, None] for order in MULTIPLES for part in ((z**order).real, (z**order).imag)]
    after_it = ways * later[:, None]
    columns = np.hstack([legvander(scaled, 2), *smooth, *multiples, after_it * scaled[:, None], after_it])
    if min(later.sum(), (~later).sum()) < columns.shape[1]:
        return None
    # Without what else is fitted, which may change within these periods.
    value = fitted.residual[near] + ways[:, 0]
    Q = np.linalg.qr(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))[0]
    along = Q.T @ value
    # The phase is the last of the columns: its share is what all others leave.
    return float(along[-1]), max(float(value @ value - along @ along), 0.0) / (len(t) - len(along))
