"""Reconstruct the records of the tension test of an aramid line: aramid.

Nobody measured them: they are what a testing machine with capstan grips would have read of five lengths of such a line.
What is planted: a braid whose crimp is pulled out first (a toe of the specimen), then EA = 11.9 kN with a scatter of
1 % between the specimens; grips and frame that give way by 2.1 µm/N, differing by 4 % from mounting to mounting, with
slack that is gone by about 120 N; noise of cell, extensometer and crosshead with a memory of some readings, each
rounded; a break at 175 cN/tex with a scatter of 2 %.

``python campaigns/reconstruct_tension.py`` writes the records; it is deterministic.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from math import sqrt
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "aramid" / "readings"
SEED, RATE = 20261122, 200.0
EA, LENGTH, TEX = 11.9e3, 0.500, 168.0
SPEED = 250e-3 / 60
"""Speed of the crosshead / (m/s)."""


def noise(rng: np.random.Generator, count: int, size: float, memory: float) -> np.ndarray:
    """Noise of which each reading keeps a part of the one before."""
    found, last = np.empty(count), 0.0
    for at, step in enumerate(rng.normal(size=count).tolist()):
        last = memory * last + sqrt(1 - memory**2) * step
        found[at] = size * last
    return found


def specimen(number: int) -> str:
    """Record of one specimen as text."""
    rng = np.random.default_rng([SEED, number])
    stiff, most = EA * (1 + 0.01 * rng.normal()), 1.75 * TEX * (1 + 0.02 * rng.normal())
    setup, slack = 2.1e-6 * (1 + 0.04 * rng.normal()), 3.0e-4 * (1 + 0.1 * rng.normal())
    force = np.linspace(2.0, most, 4001)
    strain = force / stiff + 1.2e-3 * (1 - np.exp(-force / 7.0))
    crosshead = LENGTH * strain + setup * force + slack * (1 - np.exp(-force / 25.0))
    # The machine moves evenly: what the cell and the extensometer read follows from where the crosshead is.
    t = np.arange(int((crosshead[-1] - crosshead[0]) / SPEED * RATE)) / RATE
    at = crosshead[0] + SPEED * t
    force, strain = np.interp(at, crosshead, force), np.interp(at, crosshead, strain)
    broken = np.arange(1, 9) / RATE
    t = np.concatenate([t, t[-1] + broken])
    force = np.concatenate([force, np.full(len(broken), 1.5)])
    strain = np.concatenate([strain, np.full(len(broken), np.nan)])
    at = np.concatenate([at, at[-1] + SPEED * broken]) - at[0]
    rows = zip(
        t, force + noise(rng, len(t), 0.05, 0.4), at + noise(rng, len(t), 2e-6, 0.6),
        strain + noise(rng, len(t), 4e-6, 0.7), strict=True,
    )  # fmt: skip
    lines = [
        f"{one:.3f},{newton:.2f},{1e3 * moved:.3f},{'' if part != part else f'{1e2 * part:.4f}'}"
        for one, newton, moved, part in rows
    ]
    return "time / s,force / N,crosshead / mm,strain / %\n" + "\n".join(lines) + "\n"


def files() -> Iterator[tuple[str, str]]:
    """Name and text of every file."""
    for number in range(1, 6):
        yield f"line-{number}.csv.gz", specimen(number)


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, text in files():
        (FOLDER / name).write_bytes(gzip.compress(text.encode(), 9, mtime=0))
