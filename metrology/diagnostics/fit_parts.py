"""Values of named unknowns by one fit, and their covariance by cause."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from metrology.diagnostics.bounds import within
from metrology.diagnostics.likelihood import Noise, spread_out
from metrology.diagnostics.subject import Array, Fit
from metrology.noise import WHITE

Shared = Literal["common", "per run"]
"""Whether all blocks share what is known of an input, or each block has its own."""


@dataclass(frozen=True)
class Parts:
    """Values of named unknowns by one fit, and their covariance by cause; rows in the order of the names.

    `priors`: by the name of an input, and whether all blocks share it, a column for its prior, or for that of each
    block; `law`: what an unlisted law beside the effects adds to each variance.
    """

    values: Array
    readings: Array
    priors: dict[tuple[str, Shared], Array]
    law: Array | float = 0.0

    def first(self, count: int) -> Parts:
        """Return those of the first unknowns."""
        priors = {key: columns[:count] for key, columns in self.priors.items()}
        return Parts(self.values[:count], self.readings[:count, :count], priors)

    @property
    def total(self) -> Array:
        """Covariance, misfit not included."""
        parts = (columns @ columns.T for columns in self.priors.values())
        return np.asarray(self.readings + self.law + sum(parts, np.zeros_like(self.readings)))


def parts_of(fit: Fit, names: Sequence[str], start: Array, noise: Noise) -> Parts:
    """Values and covariance of named unknowns between their bounds; `start` where the fit does not seek one."""
    unknowns = fit.problem.unknowns
    # What effects of this fit are bounded to counts for the others, named or not.
    every = dict.fromkeys((*names, *(entry.name for entry in unknowns if "@" not in entry.name)))
    places = [fit.index(name) for name in every]
    pick = np.array([[float(at == place) for at in range(len(unknowns))] for place in places])
    known = [*start.tolist(), *(math.nan for _ in places[len(names) :])]
    values = np.array([value if at is None else fit.theta[at] for at, value in zip(places, known, strict=True)])
    whole = by_cause(fit, pick, values, noise)
    low, high = (np.array([free if at is None else getattr(unknowns[at], side) for at in places])
                 for side, free in (("low", -math.inf), ("high", math.inf)))  # fmt: skip
    # Where what is no size of an effect is known worse than by its bounds, such as k to less than itself, these count.
    stated = [at for at, value in enumerate(start) if math.isnan(value)]
    u, room = np.sqrt(np.diag(whole.total)), np.minimum(values - low, high - values)
    return (_bounded(whole, low, high) if (u > room)[stated].any() else whole).first(len(names))


def _bounded(model: Parts, low: Array, high: Array) -> Parts:
    """Parts of a model whose unknowns lie between bounds: a size at its null leaves the rest of the model as it is.

    What the bounds leave open is counted with the readings.
    """
    total = model.total
    sites = within(model.values, total, low, high)
    if not sites.precision.any():
        return model
    gain = sites.gain(total)
    inside = gain @ total
    own = inside * np.sqrt(sites.precision)
    moved = np.where(sites.precision > 0, sites.shift - sites.precision * model.values, 0.0)
    priors = {key: gain @ columns for key, columns in model.priors.items()}
    return Parts(model.values + inside @ moved, gain @ model.readings @ gain.T + own @ own.T, priors)


def by_cause(fit: Fit, pick: Array, values: Array, noise: Noise) -> Parts:
    """Values, and the covariance by cause of what each row of `pick` takes of the unknowns of a fit."""
    bread = fit.covariance
    priors: dict[tuple[str, Shared], list[Array]] = {}
    for at, entry in enumerate(fit.problem.unknowns):
        if entry.u is not None and entry.u > 0:
            name, own, _ = entry.name.partition("@")
            priors.setdefault((name, "per run" if own else "common"), []).append(pick @ bread[:, at] / entry.u)
    columns = {key: np.column_stack(own) for key, own in priors.items()}
    return Parts(values, _by_readings(fit, noise, bread @ pick.T), columns)


def _by_readings(fit: Fit, noise: Noise, weights: Array) -> Array:
    """(J·B)ᵀ·C·(J·B) with weights B, C the covariance of coloured noise with the whitening filter W: C = (WᵀW)⁻¹."""
    from scipy.linalg.lapack import dtbtrs

    found = np.zeros((weights.shape[1], weights.shape[1]))
    for block, part, used in zip(fit.problem.blocks, spread_out(fit), fit.used, strict=True):
        kept = part @ weights * used[:, None]
        for segment in block.segments:
            taps = noise.channels.get(segment.name, WHITE).filter
            # W is banded and triangular, and Wᵀ is W with the readings in the other order.
            band = np.repeat(taps[:, None], segment.last - segment.first, axis=1)
            rows, _ = dtbtrs(band, kept[segment.first : segment.last][::-1], uplo="L")
            found += rows.T @ rows
    return found
