"""Readings that a coarse instrument rounds: what they say of a motion whose noise does not dither the rounding.

With noise much smaller than the step q of an encoder, the error of rounding is a function of the motion, the same at
every passage, and no average makes it smaller. What a reading says of the motion x is the likelihood of its cell,
P(y|x) = Φ((y + q/2 − x)/σ) − Φ((y − q/2 − x)/σ). With the mean μ(x) and the variance v(x) of the rounded reading, it
is near a motion that is about known as good as a reading x + (y − μ)/μ′ with the variance v/μ′² (iteratively
reweighted least squares; Wedderburn, Biometrika 61 (1974) 439): next to an edge of a cell it says much, between two
edges nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.polynomial.legendre import legvander

from metrology.decay.oscillation import DEGREE, Fit, Floats, Mode, baseline, tangent
from metrology.timeseries import Channel
from metrology.timeseries.white_noise import noise, quantum

DITHERED = 0.4
"""Noise over the step from which on rounding is noise: what is left of it that follows the motion, (q/π)·exp(−2(πσ/q)²)
at most (Widrow & Kollár, Quantization Noise (2008), 3.5), is a hundredth of the step."""
_NOISY = 0.6  # noise with that of rounding, over the step, beyond which the noise dithers for certain
_LEVELS = np.logspace(-2.0, 0.0, 31)  # noise over the step that is tried
_TERMS = 6  # in time, by which amplitude and phase of the motion may differ from an exponential decay (`hop.FORMS`)
_STEPS = 40  # of a fit
_CLOSE = 1e-4  # parts of a step of the instrument below which a fit moves no more
_HELD = 1e-2  # information over 1/q² by which what no reading tells stays as it is
_LEAST = 0.02  # variance over q² that every reading has at least: one that nobody expects is five of it off, no more


@dataclass(frozen=True, eq=False)
class Rounded:
    """What rounded readings say of a motion near one that follows them.

    Parameters
    ----------
    step, level : float
        Step q of the instrument, and standard deviation σ of the noise before it rounds.
    raw : ndarray, shape (n,)
        The readings.
    motion : ndarray, shape (n,)
        The motion that follows them: amplitude and phase change smoothly with time, whatever makes them change.
    log_likelihood : float
        Of it.
    """

    step: float
    level: float
    raw: Floats
    motion: Floats
    log_likelihood: float

    def part(self, count: int) -> Rounded:
        """Of the first readings only."""
        return replace(self, raw=self.raw[:count], motion=self.motion[:count])

    @property
    def value(self) -> Floats:
        """Readings less the error that rounding is expected to make, which leaves the noise of `noise`."""
        found: Floats = self.motion + self.raw - _moments(self.motion, self.step, self.level)[0]
        return found

    @property
    def noise(self) -> float:
        """Root mean square of what `value` lies off the motion."""
        return float(np.sqrt(np.mean(_moments(self.motion, self.step, self.level)[2])))

    @property
    def likely(self) -> tuple[Floats, Floats]:
        """Readings of the motion itself that say as much, and u of each; one that says nothing lies on the motion."""
        weight, pull = _score(self.raw, self.motion, self.step, self.level)
        seen = weight > 1.0 / self.step**2
        apart = np.where(seen, pull / np.where(seen, weight, 1.0), 0.0)
        return self.motion + apart, 1.0 / np.sqrt(np.where(seen, weight, _HELD / self.step**2))


def _moments(x: Floats, step: float, level: float) -> tuple[Floats, Floats, Floats]:
    """Mean of rounded readings of positions x, its derivative by x, and their variance."""
    from scipy.special import ndtr

    reach = int(np.ceil(6 * level / step)) + 1
    edges = np.round(x / step)[:, None] + np.arange(-reach - 1, reach + 1) + 0.5
    off = (step * edges - x[:, None]) / level
    cells, chance = step * (edges[:, 1:] - 0.5), np.diff(ndtr(off), axis=1)
    mean = np.sum(chance * cells, axis=1)
    slope = step / level * np.sum(np.exp(-0.5 * off**2), axis=1) / np.sqrt(2 * np.pi)
    return mean, slope, np.sum(chance * (cells - mean[:, None]) ** 2, axis=1)


def _score(y: Floats, x: Floats, step: float, level: float) -> tuple[Floats, Floats]:
    """Information of each rounded reading on its position x, and slope of its ln likelihood, nearly."""
    mean, slope, variance = _moments(x, step, level)
    variance = variance + _LEAST * step**2
    return slope**2 / variance, slope / variance * (y - mean)


def _log_likelihood(y: Floats, x: Floats, step: float, level: float) -> float:
    """Of rounded readings y of positions x; no reading is impossible."""
    from scipy.special import ndtr

    off = np.abs(y - x)
    chance = ndtr((0.5 * step - off) / level) - ndtr((-0.5 * step - off) / level)
    return float(np.log(np.maximum(chance, 1e-12)).sum())


def _level(y: Floats, x: Floats, step: float) -> float:
    """Most likely noise before rounding, with what x is off by in it."""
    found = [_log_likelihood(y, x, step, level * step) for level in _LEVELS]
    return step * float(_LEVELS[int(np.argmax(found))])


def rounded(free: Channel, raw: Floats, fitted: Fit, others: tuple[Mode, ...] = ()) -> Rounded | None:
    """Return what rounded readings say of a motion; None where noise dithers the rounding, or nothing follows them.

    The motion is the fitted mode with an amplitude and a phase that change smoothly with time, over a polynomial: that
    is whatever friction, drag or a bent spring make of it, so that none of them is taken for granted.

    Parameters
    ----------
    free : Channel
        Record from the release on, less its steps.
    raw : ndarray, shape (n,)
        The readings themselves.
    fitted : Fit
        Of the record, or of one that was corrected already.
    others : tuple of Mode
        Further modes that the record shows.
    """
    step = quantum(replace(free, value=raw))
    if step == 0.0 or noise(free) > _NOISY * step:
        return None
    t, hops = free.time - free.time[0], raw - free.value
    basis = _forms(t, fitted, others)
    x = basis @ (basis.T @ free.value) + hops
    level = _level(raw, x, step)
    before = _log_likelihood(raw, x, step, level)
    for _ in range(_STEPS):
        weight, pull = _score(raw, x, step, level)
        known = (basis * weight[:, None]).T @ basis + _HELD / step**2 * np.eye(basis.shape[1])
        way = basis @ np.linalg.solve(known, basis.T @ pull)
        length = 1.0
        while (after := _log_likelihood(raw, x + length * way, step, level)) < before and length > _CLOSE:
            length *= 0.5
        if after < before:
            break
        x = x + length * way
        last, level = level, _level(raw, x, step)
        before = _log_likelihood(raw, x, step, level)
        if level == last and length * float(np.sqrt(np.mean(way**2))) < _CLOSE * step:
            break
    return Rounded(step, level, raw, x, before) if level < DITHERED * step else None


def _forms(t: Floats, fitted: Fit, others: tuple[Mode, ...]) -> Floats:
    """Orthonormal columns of what is slow, and of modes whose amplitude and phase change smoothly with time."""
    found = [baseline(t, settling=fitted.settling)]
    for place, mode in enumerate((fitted.main, *others)):
        z = np.exp(np.clip(-mode.rate * t, -60.0, 6.0) + 1j * mode.omega * t)
        ways = z[:, None] * legvander(2 * t / t[-1] - 1, _TERMS - 1 if place == 0 else 0)
        found += [ways.real, ways.imag]
    return np.asarray(np.linalg.qr(np.hstack(found))[0])


def by_likelihood(t: Floats, value: Floats, fitted: Fit, of: Rounded) -> tuple[Fit, Rounded]:
    """Return a fit of a corrected record as the readings themselves make it most likely, where it follows them.

    The fit has fewer parameters than the smooth motion, and stands in its place where its likelihood times n^{½·p} is
    no less, p being as many as it has less (Schwarz, Ann. Statist. 6 (1978) 461): no reading tells the rest of what a
    smooth motion can do between the edges of the cells. Elsewhere both stay as they are.

    Parameters
    ----------
    t, value : ndarray, shape (n,)
        Times in s from the first sample fitted, and the corrected record, less its steps.
    fitted : Fit
        Of it, at its full rate.
    of : Rounded
        What the readings say.
    """
    base, hops = baseline(t, degree=fitted.degree, settling=fitted.settling), of.value - value
    now = fitted
    level = base.T @ (value - fitted.residual - _parts(t, fitted))
    x = base @ level + _parts(t, fitted) + hops
    noise = _level(of.raw, x, of.step)
    before = _log_likelihood(of.raw, x, of.step, noise)
    for _ in range(_STEPS):
        columns = tangent(t, now)
        size = np.linalg.norm(columns, axis=0)
        size[size == 0] = 1.0
        columns = columns / size
        weight, pull = _score(of.raw, x, of.step, noise)
        inverse = np.linalg.pinv((columns * weight[:, None]).T @ columns, rcond=1e-12, hermitian=True)
        way = inverse @ (columns.T @ pull) / size
        length, last = 1.0, x
        while True:
            moved, shift = _moved(now, length * way[len(level) :]), length * way[: len(level)]
            x = base @ (level + shift) + _parts(t, moved) + hops
            after = _log_likelihood(of.raw, x, of.step, noise)
            if after >= before or length < _CLOSE:
                break
            length *= 0.5
        if after < before:
            x = last
            break
        now, level = moved, level + shift
        was, noise = noise, _level(of.raw, x, of.step)
        before = _log_likelihood(of.raw, x, of.step, noise)
        if noise == was and float(np.sqrt(np.mean((x - last) ** 2))) < _CLOSE * of.step:
            break
    else:
        return fitted, of
    fewer = 2 * _TERMS + DEGREE - (4 + fitted.degree)
    if of.log_likelihood - before > 0.5 * fewer * log(len(t)) or not min(now.main.omega, now.main.rate) > 0:
        return fitted, of
    mean, _, variance = _moments(x, of.step, noise)
    more = max(1.0, float(np.sum((of.raw - mean) ** 2) / np.sum(variance)))
    places = len(level) + np.array([2, 3])
    covariance = more * inverse[np.ix_(places, places)] / np.outer(size[places], size[places])
    near = replace(of, level=noise, motion=x, log_likelihood=before)
    return replace(now, covariance=covariance, residual=near.value - x), near


def _parts(t: Floats, fitted: Fit) -> Floats:
    """Sum of all modes."""
    return np.asarray(sum((fitted.part(t, at) for at in range(len(fitted.modes))), np.zeros(len(t))))


def _moved(fitted: Fit, by: Floats) -> Fit:
    """Fit with little changes of coefficients, ω and λ of every mode, in the order of `oscillation.tangent`."""
    each = by.reshape(len(fitted.modes), 4)
    modes = tuple(
        replace(mode, omega=float(mode.omega + own[2]), rate=float(mode.rate + own[3]))
        for mode, own in zip(fitted.modes, each, strict=True)
    )
    return replace(fitted, modes=modes, coefficients=fitted.coefficients + each[:, :2])
