"""Reconstruct the records of the relaxation and creep tests of a polyester monofilament: polyester.

Nobody measured them: they are what a testing machine with a video extensometer would have read of such a line, and a
DMA of a piece of it. What is planted: E₀ = 13.0 GPa with a scatter of 1 % between the specimens, of which 5 % relax
with a time of 4 s, 6 % with 90 s and 7 % with 1500 s; three specimens held at 0.6 % and then 1.0 % of strain for an
hour each, one under 60 N for two hours; ramps of 0.5 s; noise of the cell and of the extensometer with a memory of
some tenths of a second, each rounded. The DMA sweep reads the moduli of the mean specimen with a scale that is 0.6 %
off and a scatter of 0.5 % (E′) and 2 % (E″).

``python campaigns/reconstruct_relaxation.py`` writes the records; it is deterministic.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from math import exp, pi, sqrt
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "polyester" / "readings"
SEED = 20261123
E_0, PARTS, TIMES = 13.0e9, (0.05, 0.06, 0.07), (4.0, 90.0, 1500.0)
AREA = pi / 4 * 0.800e-3**2
BEFORE, RAMP = 20.0, 0.5
FAST, SLOW, SWITCH = 20.0, 0.5, 60.0
"""Readings a second for a minute about a ramp, and afterwards."""


def stamps(holds: tuple[float, ...]) -> np.ndarray:
    """Times of the readings: dense about each ramp."""
    found, begin = [np.arange(0.0, BEFORE, 1 / FAST)], BEFORE
    for hold in holds:
        dense = begin + np.arange(0.0, SWITCH, 1 / FAST)
        found += [dense, np.arange(begin + SWITCH, begin + RAMP + hold, 1 / SLOW)]
        begin += RAMP + hold
    return np.concatenate(found)


def course(t: np.ndarray, levels: tuple[float, ...], holds: tuple[float, ...]) -> np.ndarray:
    """What is imposed: ramps to levels that are held."""
    corners, values, begin = [0.0, BEFORE], [0.0, 0.0], BEFORE
    for level, hold in zip(levels, holds, strict=True):
        corners += [begin + RAMP, begin + RAMP + hold]
        values += [level, level]
        begin += RAMP + hold
    return np.interp(t, corners, values)


def noise(rng: np.random.Generator, t: np.ndarray, size: float, memory: float) -> np.ndarray:
    """Noise with a memory in seconds, at stamps that need not be even."""
    found, last = np.empty(len(t)), rng.normal()
    for at, step in enumerate(np.diff(t, prepend=t[0]).tolist()):
        kept = exp(-step / memory)
        last = kept * last + sqrt(1 - kept**2) * rng.normal()
        found[at] = size * last
    return found


def held_strain(t: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Force over EA₀ at a strain that is linear between stamps: each branch τ·z' + z = ε, exactly."""
    force = strain.copy()
    for part, tau in zip(PARTS, TIMES, strict=True):
        z = 0.0
        for at in range(1, len(t)):
            step, kept = t[at] - t[at - 1], exp(-(t[at] - t[at - 1]) / tau)
            slope = (strain[at] - strain[at - 1]) / step
            z = strain[at] - slope * tau + (z - strain[at - 1] + slope * tau) * kept
            force[at] -= part * z
    return force


def held_load(t: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Strain times EA₀ under a force: the same branches, the strain taken as linear over each of many short steps."""
    fine = np.unique(
        np.concatenate([t, np.arange(BEFORE, BEFORE + RAMP, 2e-3), BEFORE + RAMP + np.geomspace(1e-3, t[-1], 20000)])
    )
    fine = fine[fine <= t[-1]]
    load, strain = np.interp(fine, t, force), np.zeros(len(fine))
    z = np.zeros(len(PARTS))
    parts, taus = np.array(PARTS), np.array(TIMES)
    for at in range(1, len(fine)):
        kept = np.exp(-(fine[at] - fine[at - 1]) / taus)
        lag = taus / (fine[at] - fine[at - 1]) * (1 - kept)
        # z = kept·z + (lag − kept)·ε_last + (1 − lag)·ε, and the force is ε − Σ part·z.
        known = kept * z + (lag - kept) * strain[at - 1]
        strain[at] = (load[at] + parts @ known) / (1 - parts @ (1 - lag))
        z = known + (1 - lag) * strain[at]
    return np.interp(t, fine, strain)


def table(t: np.ndarray, force: np.ndarray, strain: np.ndarray) -> str:
    """A record as text."""
    rows = (f"{one:.2f},{newton:.3f},{1e2 * part:.5f}" for one, newton, part in zip(t, force, strain, strict=True))
    return "time / s,force / N,strain / %\n" + "\n".join(rows) + "\n"


def hold(number: int) -> str:
    """Record of a specimen whose strain is held at two levels."""
    rng = np.random.default_rng([SEED, number])
    stiff, holds = E_0 * AREA * (1 + 0.01 * rng.normal()), (3600.0, 3600.0)
    t = stamps(holds)
    strain = course(t, (0.006, 0.010), holds)
    force = stiff * held_strain(t, strain)
    return table(t, 0.5 + force + noise(rng, t, 0.03, 0.2), strain + noise(rng, t, 1e-6, 0.2))


def creep(number: int) -> str:
    """Record of a specimen under a load that is held."""
    rng = np.random.default_rng([SEED, number])
    stiff, holds = E_0 * AREA * (1 + 0.01 * rng.normal()), (7200.0,)
    t = stamps(holds)
    force = course(t, (60.0,), holds)
    strain = held_load(t, force / stiff)
    return table(t, force + noise(rng, t, 0.005, 0.2), strain + noise(rng, t, 2e-6, 0.3))


def sweep() -> str:
    """DMA sweep: the moduli of the mean specimen."""
    rng = np.random.default_rng([SEED, 99])
    lines = ["frequency / Hz,storage / GPa,loss / MPa,u storage / MPa,u loss / MPa"]
    for frequency in (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0):
        w = 2j * pi * frequency
        modulus = 1.006 * E_0 * (1 - sum(part / (1 + w * tau) for part, tau in zip(PARTS, TIMES, strict=True)))
        storage, loss = modulus.real * (1 + 0.005 * rng.normal()), modulus.imag * (1 + 0.02 * rng.normal())
        lines.append(
            f"{frequency:g},{storage / 1e9:.3f},{loss / 1e6:.1f},{0.01 * storage / 1e6:.0f},{0.03 * loss / 1e6 + 2:.1f}"
        )
    return "\n".join(lines) + "\n"


def files() -> Iterator[tuple[str, str]]:
    """Name and text of every file."""
    for number in range(1, 4):
        yield f"hold-{number}.csv.gz", hold(number)
    yield "creep-1.csv.gz", creep(11)
    yield "dma.csv", sweep()


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, text in files():
        (FOLDER / name).write_bytes(gzip.compress(text.encode(), 9, mtime=0) if name.endswith(".gz") else text.encode())
