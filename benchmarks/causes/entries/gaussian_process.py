"""Plain least squares and a Gaussian process over the residuals (Kennedy & O'Hagan 2001, in two steps), by
scikit-learn.

It names nothing: whether anything is missing is whether the process has more evidence than white noise alone.
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.causes.answers import Answer

from .base import fit, swinging
from .records import Campaign, load

MOST, NOTICED = 300, 5.0
"""Readings that a process is given; nats of evidence from which on it is believed."""


def inputs(campaign: Campaign, name: str, channel: str) -> np.ndarray:
    """What the missing force may depend on: position and velocity; load and order for an elongation."""
    record = next(one for one in campaign.records if one.name == name)
    read = record.columns
    if campaign.method == "elongation":
        return np.column_stack([read["F"], np.arange(len(read["F"]))])
    if campaign.method == "decay":
        t, x = swinging(record)
        return np.column_stack([x, np.gradient(x, t)])
    use = np.isfinite(read["x"]) & np.isfinite(read["v"])
    at = read["s"] if channel == "T" else read["t"]
    return np.column_stack([np.interp(at, read["t"][use], read[one][use]) for one in ("x", "v")])


def main(folder: str) -> int:
    """Print the answer."""
    try:
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
    except ImportError:
        print(
            "scikit-learn is not installed here: set up benchmarks/causes/baselines.lock, see docs/benchmark.md",
            file=sys.stderr,
        )
        return 3
    campaign, rng = load(folder), np.random.default_rng(1)
    done, gains = fit(campaign), []
    for channel in next(iter(done.residuals.values())):
        X = np.vstack([inputs(campaign, name, channel) for name in done.residuals])
        r = np.concatenate([parts[channel] for parts in done.residuals.values()])
        some = rng.choice(len(r), min(MOST, len(r)), replace=False)
        X = (X[some] - X[some].mean(axis=0)) / (X[some].std(axis=0) + 1e-12)
        kernel = ConstantKernel(1.0, (1e-4, 1e4)) * RBF([1.0] * X.shape[1], (0.05, 20)) + WhiteKernel(1.0, (0.1, 1e4))
        process = GaussianProcessRegressor(kernel, n_restarts_optimizer=1, random_state=1).fit(X, r[some])
        level = float(np.var(r[some]))
        white = -0.5 * len(some) * (np.log(2 * np.pi * level) + 1)
        gains.append(process.log_marginal_likelihood_value_ - white)
    verdict = "unexplained" if max(gains) > NOTICED else "nothing missing"
    print(Answer(verdict, k=done.k, c=done.c).text())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
