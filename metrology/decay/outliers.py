"""Single readings that are no motion: lost fringes, spikes of a supply, wrong digits. Masked before any fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from metrology.timeseries import Channel, Floats
from metrology.timeseries.extrema import maxima
from metrology.timeseries.white_noise import against_neighbours, quantum

LIMIT = 5.5
"""Robust standard deviations beyond which a reading is no motion: white noise has such a one in 2 of 10 000 records of
4000 readings (4000·2·(1 − Φ(5.5)) = 1.5e-4)."""
_BLOCK = 100  # readings for a local scale: a motion that is coarsely sampled lies off its neighbours by more at first
_PASSES = 20


def masked(record: Channel) -> tuple[Channel, Floats]:
    """Return a record without its outliers, and their times / s.

    Hampel's identifier (J. Am. Stat. Assoc. 69 (1974) 383; Davies & Gather, ibid. 88 (1993) 782): a reading is an
    outlier where it lies off the cubic through its four neighbours by more than `LIMIT` × 1.4826 × the median of all
    such distances about it. Of neighbours beyond it the farthest is taken, and the others are looked at again.
    """
    kept, dropped = record, []
    floor = 0.5 * quantum(record)  # where most readings are alike, one step is no outlier
    for _ in range(_PASSES):
        apart = abs(against_neighbours(kept))
        found = maxima(apart / _scale(apart, floor), floor=LIMIT, gap=3)
        if not found.size:
            break
        # Which of the three at an end it is, the distances do not say: all of them go.
        last = len(kept) - 1
        ends = ([0, 1] if found[0] == 2 else []) + ([last - 1, last] if found[-1] == last - 2 else [])
        found = np.concatenate([found, np.array(ends, dtype=found.dtype)])
        dropped += kept.time[found].tolist()
        kept = replace(kept, time=np.delete(kept.time, found), value=np.delete(kept.value, found))
    return kept, np.sort(np.array(dropped))


def is_last_off(residual: Floats) -> bool:
    """Whether the last reading of a record alone is an outlier of a fit.

    Among its neighbours, all of them on one side of it, it has a sixth of the distance that it has from the motion:
    `masked` sees there what is six times as far off as elsewhere.
    """
    far = np.abs(residual)
    return bool(far[-1] > LIMIT * 1.4826 * float(np.median(far)) and far[-2] < 0.5 * far[-1])


def _scale(apart: Floats, floor: float) -> Floats:
    """Return 1.4826 × the median of the distances about every reading, over blocks and never below that of them all."""
    blocks = np.array_split(apart, max(apart.size // _BLOCK, 1))
    middle = np.cumsum([block.size for block in blocks]) - 0.5 * blocks[0].size
    whole = max(1.4826 * float(np.median(apart)), floor, 1e-300)
    scale: Floats = np.interp(np.arange(apart.size), middle, [1.4826 * float(np.median(block)) for block in blocks])
    return np.maximum(scale, whole)
