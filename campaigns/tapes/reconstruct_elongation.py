"""Reconstruct the readings of the two elongation tests of this campaign from the stiffnesses that were published.

The published results are k = 24734.25 ± 335.52 N/m (Al-1100) and k = 1810.91 ± 7.53 N/m (PEEK), 1 σ; readings were not.
Readings are drawn as a test would give them: a line, a zero that moves a little between repeats, a small difference
between loading and unloading, scatter, and rounding to the 0.01 mm of the dial indicator. Three loads are read loading
and, after a minute at the heaviest, unloading, four times. What certificates and formulas give (g, air, indicator,
weights) stands in `campaign.yaml`; of these the indicator's U was chosen, among 3 µm to 6 µm, so that a solution
exists, the others beforehand. Two things are then left to find by search: a draw of the readings, by its seed, and
the three masses in steps of 0.01 g near round values, so that k and u(k) come out as published.

``python campaigns/tapes/reconstruct_elongation.py`` repeats the search (half a minute), writes the two readings files
and prints the masses that `campaign.yaml` states. It is deterministic.

What keeps the reconstruction in bounds: the largest stress, 12 MPa in the aluminium (about 34 MPa yield, annealed) and
6 MPa in PEEK (about 90 MPa), is far from yield; the readings, up to 1.1 mm and 4.6 mm, are within the 10 mm of the
indicator; a scatter of 7 µm is what 0.1 K does to 3 m of aluminium.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent
DIVISION = 1e-5
REPEATS = 4
TRIALS = 100_000
STEP = 1e-5
REACH = 400
INDICATOR_U = 4.5e-6 / 2
MASS_U = 2e-5 / np.sqrt(3)
AIR, STEEL = 1.19, 8000.0
AIR_U, STEEL_U = 0.02, 100.0
COMMON_U = np.sqrt(
    (1e-4 / 2) ** 2
    + (5e-4 / np.sqrt(3) / 9.8065) ** 2
    + (AIR / STEEL) ** 2 * ((AIR_U / AIR) ** 2 + (STEEL_U / STEEL) ** 2)
)
"""Relative standard uncertainty common to all loads: certificate of the weights, g, air buoyancy."""


@dataclass(frozen=True)
class Tape:
    """What was published of a tape, and what its readings are drawn from, in SI."""

    file: str
    stiffness: float
    uncertainty: float
    nominal: tuple[float, float, float]
    zero: float
    zero_shift: float
    scatter: float
    hysteresis: float
    seed: int


def gravity(latitude: float, height: float) -> float:
    """Free fall in m/s² by the international gravity formula 1980, less 3.086 µm/s² a metre of height."""
    sine, double = np.sin(np.radians(latitude)), np.sin(np.radians(2 * latitude))
    return float(9.780327 * (1 + 0.0053024 * sine**2 - 0.0000058 * double**2) - 3.086e-6 * height)


GRAVITY = round(gravity(45.4, 12), 4)
TAPES = (
    Tape("al-1100-elongation.csv", 24734.25, 335.52, (0.5, 1.0, 1.5), 0.5e-3, 2e-6, 7.0e-6, 1.0e-6, 2026),
    Tape("peek-elongation.csv", 1810.91, 7.53, (0.25, 0.5, 0.75), 0.5e-3, 4e-6, 2.0e-5, 4.0e-6, 2027),
)


def draw(tape: Tape) -> np.ndarray:
    """Trials of the test in whole divisions, shape (trials, repeats, 2, 3): loading A, B, C, and unloading A, B, C."""
    generator = np.random.default_rng(tape.seed)
    line = np.array(tape.nominal) * GRAVITY * (1 - AIR / STEEL) / tape.stiffness
    loop = np.array([[0.0], [1.0]]) * tape.hysteresis
    shift = generator.normal(0, tape.zero_shift, (TRIALS, REPEATS, 1, 1))
    scatter = generator.normal(0, tape.scatter, (TRIALS, REPEATS, 2, 3))
    return np.rint((tape.zero + line + loop + shift + scatter) / DIVISION).astype(np.int16)


def leftover(readings: np.ndarray) -> np.ndarray:
    """Readings less the mean of their load and the zero of their repeat, in m; shape (trials, repeats, 2, 3)."""
    values = readings * DIVISION
    zeros = values.mean(axis=(-2, -1), keepdims=True) - values.mean(axis=(-3, -2, -1), keepdims=True)
    return values - values.mean(axis=(-3, -2), keepdims=True) - zeros


def scatter(readings: np.ndarray) -> np.ndarray:
    """Scatter s of one reading, in m, for each trial."""
    return np.sqrt((leftover(readings) ** 2).sum(axis=(-3, -2, -1)) / (6 * REPEATS - 3 - (REPEATS - 1)))


def evaluate(readings: np.ndarray, masses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and its standard uncertainty in N/m, by the model of `metrology.elongation`, without its machinery.

    Either `readings` holds many trials and `masses` has the shape (3,), or one trial and `masses` has the shape (n, 3).
    """
    count = 2 * REPEATS
    means = readings.mean(axis=(-3, -2)) * DIVISION
    s = scatter(readings)
    spread = s**2 / count + DIVISION**2 / 12 / np.where(s >= DIVISION / 2, count, 1) + INDICATOR_U**2
    information = count * np.eye(3) - count / 3
    forces = masses * GRAVITY * (1 - AIR / STEEL)
    weights = forces @ information
    below = (means * weights).sum(axis=-1)
    k = (weights * forces).sum(axis=-1) / below
    by_extension = (k / below) ** 2 * (weights**2).sum(axis=-1)
    by_mass = (2 * weights - k[:, None] * (means @ information)) / below[:, None] * (forces / masses)
    return k, np.sqrt(by_extension * spread + (by_mass**2).sum(axis=-1) * MASS_U**2 + (k * COMMON_U) ** 2)


def search(tape: Tape) -> tuple[np.ndarray, np.ndarray]:
    """First trial that can return the published figures, and the masses nearest to its nominal ones that do."""
    trials = draw(tape)
    k, u = evaluate(trials, np.array(tape.nominal))
    near = (np.abs(k / tape.stiffness - 1) < 0.008) & (
        np.abs(u / k * tape.stiffness / tape.uncertainty - 1) < 0.005 / tape.uncertainty
    )
    rest, s = leftover(trials), scatter(trials)
    near &= (s > 0.55 * DIVISION) & (np.abs(rest).max(axis=(1, 2, 3)) < 2.2 * s)
    steps = np.arange(-REACH, REACH + 1)
    offsets = np.stack(np.meshgrid(0, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    for trial, ratio in zip(trials[near], (tape.stiffness / k)[near], strict=True):
        masses = (np.rint(ratio * np.array(tape.nominal) / STEP) + offsets) * STEP
        k, u = evaluate(trial, masses)
        hits = np.flatnonzero((np.abs(k - tape.stiffness) < 0.002) & (np.abs(u - tape.uncertainty) < 0.0015))
        if hits.size:
            best = hits[np.abs(offsets[hits]).max(axis=1).argmin()]
            return trial, np.round(masses[best], 5)
    raise SystemExit(f"{tape.file}: no readings found")


def rows(readings: np.ndarray) -> list[tuple[str, int, str, str]]:
    """Lines of the readings file in the order in which they are taken: A, B, C loading, then C, B, A unloading."""
    lines = []
    for repeat, (up, down) in enumerate(readings.tolist(), start=1):
        lines += [(load, repeat, "loading", _millimetres(value)) for load, value in zip("ABC", up, strict=True)]
        lines += [
            (load, repeat, "unloading", _millimetres(value)) for load, value in zip("CBA", reversed(down), strict=True)
        ]
    return lines


def _millimetres(divisions: int) -> str:
    return f"{divisions / 100:.2f}"


def text(readings: np.ndarray) -> str:
    """The readings file."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["load", "repeat", "direction", "reading / mm"])
    writer.writerows(rows(readings))
    return file.getvalue()


def main() -> None:
    for tape in TAPES:
        readings, masses = search(tape)
        (FOLDER / tape.file).write_text(text(readings), encoding="utf-8")
        k, u = evaluate(readings, masses[None, :])
        stated = ", ".join(f"{1000 * mass:.2f} g" for mass in masses)
        print(f"{tape.file}: masses {stated}; k = {k[0]:.4f}, u = {u[0]:.4f} N/m")


if __name__ == "__main__":
    main()
