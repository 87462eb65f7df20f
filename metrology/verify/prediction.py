"""What the fitted model predicts for a run that it has not seen, with the uncertainty of the prediction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from metrology.errors import MetrologyError
from metrology.estimation import Identification, MeasuredRun, Prior, beside_contact, fit_own, slopes
from metrology.estimation.covariance import inverse
from metrology.gum.matrix import root
from metrology.rig import Motion, Rig, Run, simulate, simulate_many

Array = NDArray[np.float64]
DRAWS = 300
"""Monte Carlo draws for a band: the ends of a 95 % band are then known to about a tenth of u."""
ROUNDING = 1e-11
"""Part of the largest value by which two exact integrations differ by rounding alone."""


@dataclass(frozen=True)
class Prediction:
    """Motion predicted for one run.

    Parameters
    ----------
    kind : {'open loop', 'own inputs re-estimated'}
        Whether anything of the run itself was used.
    rig : Rig
        With which it was simulated.
    motion : Motion
        The prediction at the best values.
    u_input : mapping of str to ndarray
        Standard uncertainty of each channel at its stamps, from the parameters and all known inputs.
    low, high : mapping of str to ndarray
        95 % band for the readings: prediction and noise together.
    own : mapping of str to (float, float)
        Inputs of the run that were re-estimated: distance from what is stated, in its u, and in its unit.
    lost : int
        Draws that could not be followed.
    """

    kind: str
    rig: Rig
    motion: Motion
    u_input: Mapping[str, Array]
    low: Mapping[str, Array]
    high: Mapping[str, Array]
    own: Mapping[str, tuple[float, float]]
    lost: int


def open_loop(found: Identification, measured: MeasuredRun, rng: np.random.Generator) -> Prediction | None:
    """Prediction from what is known before the run: fitted common parameters, stated inputs of the run.

    Draws: the common parameters jointly from the fit, the run's own parts from their priors. None where the motion with
    the best values cannot be followed.
    """
    common = found.layout.common
    drawn = found.draws(rng, DRAWS)[:, :common]
    names, values = _columns(found, drawn, rng)
    return _predict("prediction", (found.fitted, measured), names, values, {})


def closed_loop(found: Identification, measured: MeasuredRun, rng: np.random.Generator) -> Prediction | None:
    """Prediction with the run's own inputs re-estimated within their priors, everything common held at the fit.

    Where no fit has seen any run, nothing common is known better than stated: it is then re-estimated as well. The
    covariance is that of all parameters given the fit and this run, linearised: H = JᵀJ + C⁻¹ + P_own.
    """
    stated = [prior for prior in found.priors if prior.per_run > 0]
    wanted = stated if found.runs else found.priors
    if not wanted:
        return None
    # The common part is held, so its uncertainty is room for the run's own part.
    own = [
        replace(prior, common=0.0, mean=_mean(found, prior), per_run=math.hypot(prior.per_run, _common_u(found, prior)))
        for prior in wanted
    ]
    again = fit_own(found.fitted, measured, own)
    if again.status != "ok":
        return None
    rig = again.rig_of(measured.name)
    names = [entry.name for entry in found.layout.unknowns[: found.layout.common]]
    moving = [*names, *(prior.name for prior in stated)]
    slopes = _weighted_slopes(rig, measured, moving)
    if slopes is None:
        return None
    count = len(names)
    information = slopes.T @ slopes
    information[:count, :count] += inverse(found.total[:count, :count])
    information[count:, count:] += np.diag([prior.per_run**-2 for prior in stated])
    spread = rng.standard_normal((DRAWS, len(information))) @ root(inverse(information)).T
    targets = list(dict.fromkeys(moving))
    moved = np.tile([rig.value(name) for name in targets], (DRAWS, 1))
    for at, name in enumerate(moving):
        moved[:, targets.index(name)] += spread[:, at]
    own_inputs = {
        prior.name: (estimate.value / prior.per_run, estimate.value)
        for prior, estimate in zip(own, again.parameters, strict=True)
    }
    return _predict("own inputs re-estimated", (rig, measured), targets, moved, own_inputs)


def _mean(found: Identification, prior: Prior) -> float:
    values = found.common_values
    if prior.name in values:
        return values[prior.name]
    return found.rig.value(prior.name) if prior.mean is None else prior.mean


def _common_u(found: Identification, prior: Prior) -> float:
    return found.u(prior.name) if prior.name in found.common_values else 0.0


def _columns(found: Identification, common: Array, rng: np.random.Generator) -> tuple[list[str], Array]:
    """Rig parameters and their draws for a run of which nothing is known but the priors."""
    names = [entry.name for entry in found.layout.unknowns[: found.layout.common]]
    columns = {name: common[:, at].copy() for at, name in enumerate(names)}
    for prior in found.priors:
        if prior.per_run > 0:
            base = columns.get(prior.name, np.full(len(common), _mean(found, prior)))
            columns[prior.name] = base + prior.per_run * rng.standard_normal(len(common))
    # By reshaping, since stacking refuses the case in which everything is exact and nothing varies.
    return list(columns), np.array(list(columns.values())).reshape(len(columns), len(common)).T


def _weighted_slopes(rig: Rig, measured: MeasuredRun, names: list[str]) -> Array | None:
    distinct = list(dict.fromkeys(names))
    found = slopes(rig, measured.run, distinct, {})
    moved = simulate(rig, measured.run)
    if found is None or moved.status != "ok":
        return None
    rows = []
    for channel in measured.channels:
        part = getattr(found, channel)[:, [distinct.index(name) for name in names]]
        fine = measured.used(channel)
        if channel == "T":
            # A derivative across a jump of contact is none.
            fine = fine & ~beside_contact(measured, moved, clock=rig.value("clock.T"))
        rows.append(np.where(fine[:, None], part / measured.noise[channel], 0.0))
    return np.concatenate(rows)


def _predict(
    kind: str,
    case: tuple[Rig, MeasuredRun],
    names: list[str],
    values: Array,
    own: Mapping[str, tuple[float, float]],
) -> Prediction | None:
    rig, measured = case
    motion = simulate(rig, measured.run)
    if motion.status != "ok":
        return None
    try:
        draws = simulate_many(rig, measured.run, names, values)
    except MetrologyError:
        return None
    valid = draws.valid
    u_input, low, high = {}, {}, {}
    for channel in measured.channels:
        rows = getattr(draws, channel)[valid]
        best = getattr(motion, channel)
        u_input[channel] = np.sqrt(np.mean((rows - best) ** 2, axis=0))
        ends = np.quantile(rows, (0.025, 0.975), axis=0)
        noise = 1.959963984540054 * measured.noise[channel]
        low[channel] = best - np.hypot(np.maximum(best - ends[0], 0.0), noise)
        high[channel] = best + np.hypot(np.maximum(ends[1] - best, 0.0), noise)
    return Prediction(kind, rig, motion, u_input, low, high, own, int((~valid).sum()))


def numerical(rig: Rig, run: Run, motion: Motion, channels: tuple[str, ...]) -> dict[str, float]:
    """Numerical uncertainty u_num by channel: the largest difference between two integrations of the same motion.

    The exact segments in NumPy against the compiled kernel where both serve the rig, at least what rounding makes;
    where only one does, 1e-6 of the largest value, the tolerance to which the kernel is tested.
    """
    try:
        other = simulate(rig, run, engine="numpy" if motion.engine != "numpy" else "compiled")
    except (MetrologyError, NotImplementedError):
        other = motion
    found = {}
    for channel in channels:
        best = getattr(motion, channel)
        scale = float(np.abs(best).max())
        if other is motion or other.engine == motion.engine or other.status != "ok":
            found[channel] = 1e-6 * scale
            continue
        apart = np.sort(np.abs(getattr(other, channel) - best))
        # One reading on the other side of a contact is an event, not an error of the motion.
        found[channel] = max(float(apart[math.ceil(0.998 * len(apart)) - 1]), ROUNDING * scale)
    return found
