"""Steps of the position in a run, such as a marker that was lost and found: what no velocity has read."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky_banded, solveh_banded

from metrology.estimation.fit import Settings, fit
from metrology.estimation.measured import MeasuredRun
from metrology.estimation.noise import estimate
from metrology.estimation.priors import Prior
from metrology.estimation.problem import Array, Marks
from metrology.estimation.response import motion, values_of
from metrology.noise import colour, spikes
from metrology.rig import Rig
from metrology.timeseries import Channel
from metrology.timeseries.white_noise import quantum, rounding_bias

CLEAR = 5.0
"""Ln of the Bayes factor of all runs together from which on there are steps: 150 to 1, 'very strong' (Kass & Raftery,
J. Am. Stat. Assoc. 90 (1995) 773)."""
FEWEST = 6
"""Readings on either side of a step."""
LEAST = 50
"""Readings of a run below which none is sought."""
GAP = 3.0
"""Interval between readings of the velocity, over their median, in which the way was not read."""
WANDERS = (-8.0, 2.0)
"""Decimal logarithm of the variance of what wanders from reading to reading, over that of the noise: at least what the
noise of the velocity adds up to, if it is white."""


@dataclass(frozen=True)
class Step:
    """A step: time / s of the first reading after it, its size in the unit of x with u, its ln Bayes factor."""

    time: float
    size: float
    u: float
    log_bayes: float


def without(
    rig: Rig, runs: Sequence[MeasuredRun], free: Sequence[str], priors: Sequence[Prior]
) -> tuple[tuple[MeasuredRun, ...], Mapping[str, Step]]:
    """Return the runs without the positions after a step, and the first step of each run that has one.

    Where zero was before a run is stated; where it is after a step nobody knows. A sensor that is known to step is
    looked at in every run beside the fitted model, too, which shows what the noise of the velocity hides.

    Parameters
    ----------
    rig : Rig
        As stated.
    runs : sequence of MeasuredRun
        Read by the same sensors.
    free : sequence of str
        Parameters of which nothing is known.
    priors : sequence of Prior
        What is known within an uncertainty.

    Returns
    -------
    tuple of MeasuredRun and mapping of str to Step
        The same runs and nothing where there is no step.
    """
    found = {run.name: step for run in runs if (step := first(run)) is not None}
    if sum(step.log_bayes for step in found.values()) < CLEAR:
        return tuple(runs), {}
    cleaned = tuple(_until(run, found[run.name].time) if run.name in found else run for run in runs)
    while more := _beside_model(rig, cleaned, free, priors, found):
        found |= more
        cleaned = tuple(_until(run, more[run.name].time) if run.name in more else run for run in cleaned)
    return cleaned, found


def _beside_model(
    rig: Rig, runs: Sequence[MeasuredRun], free: Sequence[str], priors: Sequence[Prior], known: Container[str]
) -> dict[str, Step]:
    """Steps in the residuals of the position, with the fitted model, of the runs in which none is known."""
    if all(run.name in known for run in runs):
        return {}
    every = [replace(run, purpose="identification") for run in runs]
    fitted = fit(rig, every, free=free, priors=priors, settings=Settings(profile=False))
    if fitted.status != "ok":
        return {}
    found = {}
    for at, run in enumerate(every):
        if run.name in known or "x" not in run.channels:
            continue
        moved = motion(rig, run.run, values_of(fitted.layout, at, fitted.theta))
        step = None if moved is None or moved.x is None else _in_residuals(run, run.readings("x") - moved.x)
        if step is not None:
            found[run.name] = step
    return found


def _in_residuals(measured: MeasuredRun, residual: Array) -> Step | None:
    """Return the step with the most evidence in residuals of the position, beside noise of their colour."""
    used = measured.used("x")
    t, x, r = measured.stamps("x")[used], measured.readings("x")[used], residual[used]
    if len(r) < LEAST:
        return None
    fair = ~spikes(r)
    t, x, r = t[fair], x[fair], r[fair] - r[fair].mean()
    noise = colour([r])
    after, count = np.cumsum(r[::-1])[::-1], np.arange(len(r), 0.0, -1.0)
    left = count * (1.0 - count / len(r))
    open_ = (count > FEWEST) & (count < len(r) - FEWEST)
    gains = np.where(open_, after**2 / np.where(open_, left, 1.0), 0.0)
    at = int(np.argmax(gains))
    size, u = float(after[at] / left[at]), 1.0 / abs(float(noise.filter.sum())) / math.sqrt(float(left[at]))
    log_bayes = 0.5 * size**2 / (u**2 + _rounding(t, x, noise.deviation) ** 2) - 1.5 * math.log(len(r))
    return Step(float(t[at]), size, u, log_bayes) if log_bayes > CLEAR else None


def _rounding(t: Array, x: Array, noise: float) -> float:
    """What rounding may move the mean of the readings at rest by at most."""
    return math.sqrt(12.0) * rounding_bias(noise, quantum(Channel("x", t, x, "m")))


def _until(measured: MeasuredRun, time: float) -> MeasuredRun:
    before = measured.used("x") & (measured.stamps("x") < time)
    return replace(measured, use={**measured.use, "x": before})


def first(measured: MeasuredRun) -> Step | None:
    """Return the first step of the position beside the integral of the velocity; None where noise does as well.

    x − ∫v dt has what starts, zeros and clocks shift (1, t, v), and what scales of the two sensors are off, straight or
    curved (I, I², I³ with I = ∫v dt). What is left is white noise of x and the random walk to which that of v adds up:
    their differences have a tridiagonal covariance, and a step is a single one of them (Harvey, Forecasting, Structural
    Time Series Models and the Kalman Filter, 1989, 2.3 and 7.6). Every reading is a candidate (ln n), the size has the
    price of unit information (½·ln n).

    Parameters
    ----------
    measured : MeasuredRun
        A run; without a position and a velocity there is nothing to be seen.

    Returns
    -------
    Step or None
        With a Bayes factor of more than 1.
    """
    if not {"x", "v"} <= {*measured.channels}:
        return None
    beside = _beside(measured)
    found = None
    while beside is not None and (step := beside.step()) is not None:
        found, beside = step, beside.before(step.time)
    return found


@dataclass(frozen=True)
class _Beside:
    """A position beside the integral of the velocity."""

    time: Array
    way: Array
    """x − ∫v dt."""
    columns: Array
    """What shifts and scales make of it."""
    bias: Array
    """What the way from the reading before may be off at most, since it is read at instants and in divisions."""
    closed: Marks
    """Readings after a gap."""
    least: float
    """Decimal logarithm of the variance of the wander that the noise of the velocity makes, over that of the noise."""

    def before(self, time: float) -> _Beside | None:
        """Part before a time; None where it is short."""
        own = self.time < time
        parts = (self.time[own], self.way[own], self.columns[own], self.bias[own], self.closed[own])
        return _Beside(*parts, self.least) if own.sum() >= LEAST else None

    def step(self) -> Step | None:
        """Step with the most evidence, if there is more than for none."""
        y, X = np.diff(self.way), np.diff(self.columns, axis=0)
        scales = np.abs(X).max(axis=0)
        X, weights = X[:, scales > 0] / scales[scales > 0], self._weights()
        alone, sizes, u = _sizes(y, X, weights, self.least)
        places = np.arange(len(y))
        open_ = (places >= FEWEST) & (places < len(y) - FEWEST) & ~self.closed[1:]
        gains = np.where(open_, (sizes / u) ** 2, 0.0)
        at = int(np.argmax(gains))
        # Once more beside it: what is a step is no wander, and what is a wander is so without a step.
        beside, sizes, u = _sizes(y, X, weights, self.least, at)
        size, own, bias = float(sizes[at]), float(u[at]), float(self.bias[at + 1])
        gain = min(alone - beside, (size / own) ** 2) * own**2 / (own**2 + bias**2)
        log_bayes = 0.5 * gain - 1.5 * math.log(len(y))
        return Step(float(self.time[at + 1]), size, own, log_bayes) if log_bayes > 0 else None

    def _weights(self) -> Array:
        """Variance of the wander between readings, over that between most of them; any size across a gap."""
        weights: Array = np.diff(self.time) / float(np.median(np.diff(self.time)))
        weights[self.closed[1:]] = 1e12
        return weights


def _beside(measured: MeasuredRun) -> _Beside | None:
    """Position and integral of the velocity of a run; None where readings are too few."""
    x_used, v_used = measured.used("x"), measured.used("v")
    t_v, v = measured.stamps("v")[v_used], measured.readings("v")[v_used]
    if len(v) < LEAST:
        return None
    fair = ~spikes(v)
    t_v, v = t_v[fair], v[fair]
    way = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t_v))])
    t = measured.stamps("x")
    own = x_used & (t >= t_v[0]) & (t <= t_v[-1])
    t, x = t[own], measured.readings("x")[own]
    if len(x) < LEAST:
        return None
    at = np.clip(np.searchsorted(t_v, t, "right") - 1, 0, len(v) - 2)
    speed = np.interp(t, t_v, v)
    integral = way[at] + 0.5 * (v[at] + speed) * (t - t_v[at])
    fair = ~spikes(x - integral)
    wide = np.diff(t_v)
    gaps = np.concatenate([[0], np.cumsum(wide > GAP * np.median(wide))])
    turns = np.abs(np.convolve(np.pad(v, 1, mode="edge"), [1.0, -2.0, 1.0], mode="valid"))
    turns = (
        np.maximum(turns[at], turns[at + 1]) * wide[at] / 4.0
    )  # what the rule of trapezia errs by at a kink, at most
    t, x, integral, speed, turns, gaps = (one[fair] for one in (t, x, integral, speed, turns, gaps[at]))
    columns = np.column_stack([t, speed, integral, integral**2, integral**3])
    of_x, of_v = estimate(x), estimate(v)
    if of_x is None or of_v is None:
        return None
    bias = np.hypot(turns, _rounding(t, x, of_x.u))
    least = 2.0 * math.log10(max(of_v.u * float(np.median(np.diff(t))), 1e-300) / max(of_x.u, 1e-300))
    least = min(max(least, WANDERS[0]), 0.0)
    return _Beside(t, x - integral, columns, bias, np.diff(gaps, prepend=gaps[:1]) > 0, least)


def _sizes(y: Array, X: Array, weights: Array, least: float, at: int | None = None) -> tuple[float, Array, Array]:
    """−2·ln likelihood, size of a step in each difference, its u; `at`: with the noise that is left beside one there.

    The diagonal of the inverse of a tridiagonal matrix follows from its pivots from either end.
    """
    from scipy.optimize import minimize_scalar

    beside = X if at is None else np.column_stack([X, np.arange(len(y)) == at])
    found = minimize_scalar(
        lambda log: _likelihood(y, beside, weights, log)[0],
        bounds=(least, WANDERS[1]),
        method="bounded",
        options={"xatol": 0.05},
    )
    _, variance = _likelihood(y, beside, weights, found.x)
    bands = _bands(weights, found.x)
    forth, back = (cholesky_banded(one, lower=True)[0] ** 2 for one in (bands, _turned(bands)))
    solved = solveh_banded(bands, np.column_stack([y, X]), lower=True)
    of_X = solved[:, 1:]
    normal = np.linalg.pinv(X.T @ of_X)
    pull = solved[:, 0] - of_X @ (normal @ (X.T @ solved[:, 0]))
    left = 1.0 / (forth + back[::-1] - bands[0]) - np.einsum("ij,jk,ik->i", of_X, normal, of_X)
    left = np.maximum(left, 1e-12)
    return float(found.fun), pull / left, np.sqrt(variance / left)


def _likelihood(y: Array, X: Array, weights: Array, log: float) -> tuple[float, float]:
    """−2·ln of the profile likelihood of the differences, and the variance of the noise of the position."""
    bands = _bands(weights, log)
    determinant = 2.0 * float(np.log(cholesky_banded(bands, lower=True)[0]).sum())
    solved = solveh_banded(bands, np.column_stack([y, X]), lower=True)
    by = np.linalg.pinv(X.T @ solved[:, 1:]) @ (X.T @ solved[:, 0])
    left = float((y - X @ by) @ (solved[:, 0] - solved[:, 1:] @ by))
    variance = max(left / len(y), 1e-300)
    return len(y) * math.log(variance) + determinant, variance


def _bands(weights: Array, log: float) -> Array:
    """Covariance of the differences over the variance of the noise: diagonal, and what lies below it."""
    return np.vstack([2.0 + 10.0**log * weights, np.full(len(weights), -1.0)])


def _turned(bands: Array) -> Array:
    """Return the same matrix from its other end."""
    return np.vstack([bands[0, ::-1], bands[1]])
