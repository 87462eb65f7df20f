"""Modulus from a record of 10⁶ readings of a testing machine: ours, against a straight line through every reading.

``python benchmarks/tension.py`` prints CPU times; both look at one record with slow noise, in one run. The line of
`linregress` takes every reading as independent.
"""

from __future__ import annotations

import argparse
import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.stats import linregress

from metrology.tension.passage import passage
from metrology.tension.slope import slope
from metrology.tension.test import Mounting, Range

Array = NDArray[np.float64]
SAMPLES, SLOPE, MEMORY = 1_000_000, 5e-7, 0.999
"""Readings, strain for each newton, and the share of its noise that a reading hands on to the next."""


def record() -> tuple[Array, Array]:
    """Force and strain of a steady ramp."""
    rng = np.random.default_rng(3)
    force = np.linspace(0.0, 1000.0, SAMPLES)
    slow = lfilter([np.sqrt(1 - MEMORY**2)], [1, -MEMORY], rng.standard_normal(SAMPLES))
    return force + rng.standard_normal(SAMPLES), SLOPE * force + 1e-6 * slow


def ours(force: Array, strain: Array) -> tuple[float, float, float]:
    """CPU time, slope, and its standard uncertainty."""
    begun = time.process_time()
    one = Mounting("a", force, strains=(strain,))
    rows = passage("t", one, Range(), 0.01).rows
    found = slope(one.force[rows], one.strains[0][rows])
    return time.process_time() - begun, found.value, found.u


def other(force: Array, strain: Array) -> tuple[float, float, float]:
    """The same of `linregress`."""
    begun = time.process_time()
    found = linregress(force, strain)
    return time.process_time() - begun, found.slope, found.stderr


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peer-python", help="not needed here")
    parser.parse_args()
    force, strain = record()
    ours(force[::100], strain[::100])  # imports
    (own, value, u), (there, theirs, too_small) = ours(force, strain), other(force, strain)
    print(f"tension of {SAMPLES:,} readings, off the truth: ours {own:.2f} s, {(value - SLOPE) / SLOPE:+.1e} ± "
          f"{u / SLOPE:.1e}; linregress {there:.2f} s, {(theirs - SLOPE) / SLOPE:+.1e} ± {too_small / SLOPE:.1e}; "
          f"ratio {there / own:.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
