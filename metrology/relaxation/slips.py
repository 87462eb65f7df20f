"""A step of what answered within a hold, as a grip leaves that slips: against none, by a Bayes factor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.fit import Fitted
from metrology.relaxation.levels import Levels
from metrology.relaxation.noise import Colours

SIZE = 0.1
"""Standard deviation of a step beforehand, as part of the range of the answer: as of a drift."""


@dataclass(frozen=True)
class Slip:
    """The most probable step: ln of the odds of one anywhere against none, when / s, and by how much."""

    odds: float
    time: float
    size: float


def slip(best: Fitted, noise: Colours, levels: Levels, y: Array, begin: Array) -> Slip | None:
    """Weigh a step at the beginning of each block within a hold, every place as probable as every other.

    Not within the time that the ramp took after its end: what relaxes as fast as that makes a step there, too.

    The mean over the places of the Bayes factors is that of a step at an unknown one: its price is ln of their number
    (MacKay 2003, ch. 28). Each colour counts with the probability that the record gives it, times what it gains:
    without a step slow noise takes its place.

    Parameters
    ----------
    best : Fitted
        The most probable form.
    noise : Colours
        In whose metric it was fitted.
    levels : Levels
        The holds.
    y, begin : ndarray, shape (n,)
        Means of what answered over the blocks, and the first stamp of each / s.

    Returns
    -------
    Slip or None
        None where no block begins within a hold.
    """
    from scipy.special import logsumexp

    # Of a record without a level the ramp is known all the same.
    after = zip(levels.held, levels.ramps, strict=False)
    inside = [(one.start + ramp < begin) & (begin < one.stop) for one, ramp in after]
    places = np.flatnonzero(np.any(inside, axis=0)) if inside else np.empty(0, dtype=int)
    if not len(places):
        return None
    white = noise.whitening
    # A step from a block on is the sum of all columns from there.
    steps = np.cumsum(white[:, :, ::-1], axis=2)[:, :, ::-1][:, :, places]
    Q = np.linalg.qr(white @ best.columns)[0]
    rest = (white @ (y - best.model))[..., None]
    rest, steps = (one - Q @ (np.swapaxes(Q, 1, 2) @ one) for one in (rest, steps))
    rest, free = rest[..., 0], len(y) - best.columns.shape[1]
    own = np.maximum((steps**2).sum(axis=1), 1e-300)
    along = np.einsum("gnp,gn->gp", steps, rest)
    squares = (rest**2).sum(axis=1)[:, None]
    left = np.maximum(squares - along**2 / own, 1e-12 * squares + 1e-300)
    information = own * (SIZE * float(np.ptp(y))) ** 2 * free / left
    logs = 0.5 * free * np.log(squares / left) - 0.5 * np.log1p(information)
    logs = logs + np.log(np.maximum(best.weights, 1e-300))[:, None]
    colour, at = np.unravel_index(int(np.argmax(logs)), logs.shape)
    odds = float(logsumexp(logs) - np.log(len(places)))
    return Slip(odds, float(begin[places[at]]), float(along[colour, at] / own[colour, at]))
