"""Relaxation of 10⁶ readings: ours, against a Prony series fitted to every reading by `curve_fit` as after a step.

``python benchmarks/relaxation.py`` prints CPU times; both look at the same record of two branches, in one run.
"""

from __future__ import annotations

import argparse
import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import curve_fit

from metrology import relaxation
from metrology.relaxation import Facts, Mounting, RelaxationTest

Array = NDArray[np.float64]
BEFORE, RAMP, STRETCH, SAMPLES = 5.0, 0.5, 5e-3, 1_000_000
K, SIZES, TIMES = 10_000.0, (800.0, 1200.0), (8.0, 150.0)
"""Equilibrium stiffness, and stiffness / (N/m) and time / s of each branch."""


def record() -> tuple[Array, Array, Array]:
    """Time, force and elongation of a ramp and a hold, the force with noise."""
    t = np.arange(SAMPLES) / 1000.0
    since = np.clip(t - BEFORE, 0.0, None)
    ramp = np.minimum(since, RAMP)
    rate = STRETCH / RAMP
    force = K * rate * ramp
    for size, tau in zip(SIZES, TIMES, strict=True):
        force = force + size * rate * tau * (1 - np.exp(-ramp / tau)) * np.exp(-(since - ramp) / tau)
    return t, force + 0.05 * np.random.default_rng(1).standard_normal(SAMPLES), rate * ramp


def ours(t: Array, force: Array, stretch: Array) -> tuple[float, str]:
    """CPU time of an analysis, with forms weighed, coloured noise and the ramp; k∞."""
    test = RelaxationTest("t", (Mounting("a", t, force, stretch),))
    begun = time.process_time()
    found = relaxation.analyse(test, Facts(by_strain=False, length=False, area=False, at=False), {}).finding
    (specimen,) = found.specimens
    return time.process_time() - begun, f"{found.verdict}, k∞ = {specimen.k_inf:.2f} N/m"


def other(t: Array, force: Array) -> tuple[float, str]:
    """CPU time of a fit of two exponentials after the ramp; k∞, with an uncertainty that takes all noise as white."""

    def model(since: Array, last: float, a: float, b: float, first: float, second: float) -> Array:
        return np.asarray(last + a * np.exp(-since / first) + b * np.exp(-since / second))

    begun = time.process_time()
    seen = t > BEFORE + RAMP
    values, covariance = curve_fit(model, t[seen] - BEFORE - RAMP, force[seen], (50.0, 5.0, 5.0, 5.0, 100.0))
    spent = time.process_time() - begun
    return spent, f"k∞ = {values[0] / STRETCH:.2f} ± {np.sqrt(covariance[0, 0]) / STRETCH:.2f} N/m"


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peer-python", help="not needed here")
    parser.parse_args()
    t, force, stretch = record()
    ours(t[::100], force[::100], stretch[::100])  # imports
    (own, said), (there, they) = ours(t, force, stretch), other(t, force)
    print(f"relaxation of {SAMPLES:,} readings: ours {own:.2f} s ({said}); curve_fit {there:.2f} s ({they}); "
          f"ratio {there / own:.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
