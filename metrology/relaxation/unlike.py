"""A stiffness, or a relaxation, that changes with the level: against one for all levels, by a Bayes factor."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.fit import Fitted
from metrology.relaxation.forms import Scene
from metrology.relaxation.kernel import Answer
from metrology.relaxation.levels import WITHIN, Levels
from metrology.relaxation.noise import Colours

SIZE = 0.1
"""Standard deviation beforehand of the change over the range of the input, relative to what changes."""
SEEN = 1e-6
"""Part of a column that the others leave of it, below which it is one of them."""
STRAIGHT = 16
"""Straight pieces for each one of the course where its own curve counts: a parabola to 0.4 %."""


@dataclass(frozen=True)
class Unlike:
    """Change over the range of the input: ln of the odds of one against none, and by how much.

    Parameters
    ----------
    odds : float
        ln of the Bayes factor.
    whole, whole_u : float
        Relative change of the whole answer from rest to the highest level, and its standard uncertainty.
    part, part_u : float
        That of what relaxes, beyond the change of the whole; NaN where nothing does, or none of it is seen.
    """

    odds: float
    whole: float
    whole_u: float
    part: float
    part_u: float


def several(levels: Levels, u: Array) -> bool:
    """Whether levels of unlike height were held, apart from that of the beginning."""
    reach = WITHIN * float(np.ptp(u))
    held = [one.value for one in levels.held if abs(one.value - float(u[0])) > reach]
    return bool(held) and max(held) - min(held) > reach


def unlike(scene: Scene, best: Fitted, noise: Colours, time: Array, *, parts: bool = True) -> Unlike:
    """Weigh an answer that is not proportional to the level.

    Where the stiffness changes with the input as 1 + a·(u − u₀)/Δu, Δu its range, what acts is u + a·(u − u₀)²/(2Δu) in
    the place of u (Hammerstein's model; of a single integral, Schapery, Polym. Eng. Sci. 9 (1969) 295, with shift one).
    Two sizes are added: a of the whole, and of what relaxes alone. Each colour counts with the probability that the
    record gives it, times what it gains: slow noise takes the place of a misfit.

    Parameters
    ----------
    scene : Scene
        The record.
    best : Fitted
        The most probable form.
    noise : Colours
        In whose metric it was fitted.
    time : ndarray, shape (readings,)
        All stamps / s since the first.
    parts : bool
        Whether what relaxes may change by itself; a single ramp does not tell it from the whole.
    """
    from scipy.special import logsumexp

    added = _columns(scene, best, time, 1) if parts else _columns(scene, best, time, STRAIGHT)[:, :1]
    known = np.column_stack([best.columns, *(_instants(scene, best, time) if parts else ())])
    own = np.linalg.qr(np.column_stack([known, added[:, :1]]))[0]
    # Beside steps whose instants are not known nothing may be left of what relaxes alone.
    left = np.linalg.norm(added - own @ (own.T @ added), axis=0)
    added = added[:, np.append(True, left[1:] > SEEN * np.linalg.norm(added, axis=0)[1:])]
    white, n, q = noise.whitening, len(best.model), known.shape[1]
    Q = np.linalg.qr(white @ known)[0]
    rest, more = white @ (scene.answer.of.y - best.model)[:, None], white @ added
    rest, more = (one - Q @ (np.swapaxes(Q, 1, 2) @ one) for one in (rest, more))
    info = np.swapaxes(more, 1, 2) @ more + 1e-300 * np.eye(added.shape[1])
    sizes = np.linalg.solve(info, np.swapaxes(more, 1, 2) @ rest)
    squares, left = ((one**2).sum(axis=(1, 2)) for one in (rest, rest - more @ sizes))
    free = n - q
    left = np.maximum(left, 1e-12 * squares + 1e-300)
    occam = np.linalg.slogdet(np.eye(added.shape[1]) + info * (SIZE**2 * free / left)[:, None, None])[1]
    logs = 0.5 * free * np.log(squares / left) - 0.5 * occam + np.log(np.maximum(best.weights, 1e-300))
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    mean = weights @ sizes[..., 0]
    own = np.linalg.inv(info) * (left / free)[:, None, None]
    away = sizes[..., 0] - mean
    variance = weights @ (np.diagonal(own, axis1=1, axis2=2) + away**2)
    row = np.append(np.column_stack([mean, np.sqrt(variance)]).ravel(), [np.nan, np.nan])
    return Unlike(float(logsumexp(logs)), *row[:4].tolist())


def _columns(scene: Scene, best: Fitted, time: Array, straight: int) -> Array:
    """What the most probable form answers to (u − u₀)²/(2Δu); and what of it relaxes.

    Every piece of the course is taken as so many straight ones: between levels one does, along a ramp it does not.
    """
    answer, of, form = scene.answer, scene.answer.of, best.form
    span = float(np.ptp(of.u)) or 1.0
    corners, values = answer.course
    ends = np.arange(len(corners))
    corners, values = (np.interp(np.linspace(0, ends[-1], straight * ends[-1] + 1), ends, row)
                       for row in (corners, values))  # fmt: skip
    squared = (values - values[0]) ** 2 / (2 * span)
    columns = _answered(scene, best, time, corners, squared)
    whole = columns.sum(axis=1)
    return np.column_stack([whole, columns[:, 1:].sum(axis=1)]) if form.branches else whole[:, None]


def _instants(scene: Scene, best: Fitted, time: Array) -> list[Array]:
    """What the most probable form answers to a step half an interval earlier, for each step between two readings.

    Its instant within the interval no reading tells: a step that is modelled later than it was has relaxed more than
    the others, which is no answer that changes with the level.
    """
    corners, values = scene.answer.course
    span, found = float(np.ptp(values)) or 1.0, list[Array]()
    own = np.linalg.qr(best.columns)[0]
    for at in range(len(corners) - 1):
        (begin, end), slack = corners[at : at + 2], 1e-9 * time[-1]
        if abs(values[at + 1] - values[at]) < WITHIN * span or ((time > begin + slack) & (time < end - slack)).any():
            continue
        sooner = np.insert(corners, at + 1, (begin + end) / 2), np.insert(values, at + 1, values[at + 1])
        moved = (_answered(scene, best, time, *sooner) - _answered(scene, best, time, corners, values)).sum(axis=1)
        left = moved - own @ (own.T @ moved)
        # What the sizes of the form do as well is in its columns already.
        if np.linalg.norm(left) > SEEN * np.linalg.norm(moved):
            found.append(moved)
            own = np.column_stack([own, left / np.linalg.norm(left)])
    return found


def _answered(scene: Scene, best: Fitted, time: Array, corners: Array, values: Array) -> Array:
    """What the most probable form answers to another course, but for zero and drift: a column for each of its sizes."""
    of, form = scene.answer.of, best.form
    means = np.add.reduceat(np.interp(time, corners, values), of.start[:-1]) / of.count
    other = replace(scene, answer=Answer(replace(of, u=means), corners, values))
    first, shapes = 1 + form.drift, best.values[len(best.values) - form.shapes :]
    sizes = best.values[first : len(best.values) - form.shapes]
    return np.asarray(other.columns(form, shapes)[:, first:] * sizes)
