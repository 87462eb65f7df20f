"""Sparse regression by pysindy: bagged STLSQ (Fasel et al., Proc. R. Soc. A 478, 2022) on smoothed derivatives.

The probability of a name is the share of the bagged models that keep its term. k and c are those of plain least
squares.
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.causes.answers import Answer

from .base import fit
from .records import load
from .terms import Regression, regressions

THRESHOLD, MODELS = 5e-3, 40
"""Smallest coefficient, of terms about 1, that stays; number of bagged models."""


def shares(one: Regression, ensemble) -> dict[str, float]:
    """Share of the models in which a term stays."""
    ensemble.fit(one.A, one.y[:, None])
    kept = np.abs(np.array(ensemble.coef_list)[:, 0, :]) > 0
    return {name: float(share) for name, share in zip(one.names, kept.mean(axis=0), strict=True) if name}


def main(folder: str) -> int:
    """Print the answer."""
    try:
        import pysindy
    except ImportError:
        print(
            "pysindy is not installed here: set up benchmarks/causes/baselines.lock, see docs/benchmark.md",
            file=sys.stderr,
        )
        return 3
    np.random.seed(1)  # noqa: NPY002 - pysindy draws its bags from it
    campaign = load(folder)
    found: dict[str, float] = {}
    for one in regressions(campaign):
        found |= shares(
            one, pysindy.EnsembleOptimizer(pysindy.STLSQ(threshold=THRESHOLD), bagging=True, n_models=MODELS)
        )
    named = tuple(sorted((name for name, p in found.items() if p >= 0.5), key=lambda name: -found[name]))
    done = fit(campaign)
    verdict = "explained" if named else "nothing missing" if done.noise_only else "unexplained"
    print(Answer(verdict, named, (), found, done.k, done.c).text())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
