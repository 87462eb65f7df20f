"""Reconstruct the readings of the two elongation tests of this campaign: static tests that the paper only plans.

Of the line the stiffness is taken that `../reconstruct_response.py` gives it on the table, F = k·e + cubic·e³, so that
static and dynamic results are of one line; the braid's cubic part is what the paper calls differential elongation.
Readings are drawn as a test would give them: a zero that moves between repeats, an error of the indicator within its
certificate that is the same at every visit, buoyancy of the weights, a small difference between loading and unloading,
a room that warms up, scatter, and rounding to the 0.01 mm of the dial indicator.

``python campaigns/lines/reconstruct_lines.py`` writes the two readings files. It is deterministic.

What keeps it in bounds: the largest stress is 21 MPa in the nylon (about 70 MPa at break) and 3 MPa in the braid; the
readings, up to 9.2 mm and 8.9 mm, are within the 10 mm of the indicator.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

FOLDER = Path(__file__).parent
GRAVITY, AIR, STEEL = 9.8065, 1.19, 8000.0
DIVISION = 1e-5
NAMES = "ABCDEFGH"
REPEATS = 4
ZERO, ZERO_SHIFT, SCATTER, LOOP = 5e-4, 2e-6, 6e-6, 5e-7
"""Zero, what it moves between repeats, scatter of a reading, and what it is more on the way back; m."""
WARMING = 2e-8
"""What a reading grows from one to the next / m: 0.1 K over the test, by the expansion of the frame."""
INDICATOR = 2e-6
"""Amplitude / m of the error of the indicator over its travel; its certificate allows 4.5 µm."""


@dataclass(frozen=True)
class Line:
    """A line, SI: F = k·e + cubic·e³; masses that hang on it."""

    file: str
    k: float
    cubic: float
    masses: tuple[float, ...]
    seed: int


LINES = (
    Line("nylon.csv", 168.884, 0.0, (0.030, 0.060, 0.090, 0.120, 0.150), 20261124),
    Line("spectra.csv", 736.588, 1.5e5, (0.080, 0.160, 0.240, 0.320, 0.400, 0.480, 0.560, 0.640), 20261125),
)


def elongation(line: Line, mass: float) -> float:
    """Elongation / m under a mass in air."""
    force = mass * GRAVITY * (1 - AIR / STEEL)
    return float(brentq(lambda e: line.k * e + line.cubic * e**3 - force, 0.0, 1.0, xtol=1e-15))


def rows(line: Line) -> list[tuple[str, int, str, str]]:
    """Lines of the readings file in the order in which they are taken: up and down, four times."""
    rng, found = np.random.default_rng(line.seed), []
    phase = rng.uniform(0, 2 * np.pi)
    count = len(line.masses)
    for repeat in range(1, REPEATS + 1):
        zero = ZERO + ZERO_SHIFT * rng.standard_normal()
        for direction, order in (("loading", range(count)), ("unloading", reversed(range(count)))):
            for at in order:
                true = zero + elongation(line, line.masses[at]) + WARMING * len(found)
                true += LOOP * (direction == "unloading")
                shown = true + INDICATOR * np.sin(2 * np.pi * true / 1e-3 + phase) + SCATTER * rng.standard_normal()
                found.append((NAMES[at], repeat, direction, f"{1e3 * DIVISION * round(shown / DIVISION):.2f}"))
    return found


def text(line: Line) -> str:
    """The readings file."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["load", "repeat", "direction", "reading / mm"])
    writer.writerows(rows(line))
    return file.getvalue()


def main() -> None:
    for line in LINES:
        (FOLDER / line.file).write_text(text(line), encoding="utf-8")
        print(f"{line.file}: {len(rows(line))} readings")


if __name__ == "__main__":
    main()
