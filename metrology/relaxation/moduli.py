"""Storage and loss over frequency by what a record supports, and what a DMA sweep says of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.evidence import Supported, said
from metrology.relaxation.finding import Compared, Moduli
from metrology.relaxation.forms import Form, Scene
from metrology.relaxation.levels import Levels
from metrology.relaxation.test import Sweep

POINTS = 41
"""Frequencies of the curves."""
NORMAL = 1.959964
"""Two-sided 95 % of a normal distribution."""


@dataclass(frozen=True)
class Predicted:
    """Storage and loss at frequencies / Hz, with half the widths of their 95 % intervals; shape (2, f) each."""

    frequency: Array
    values: Array
    half: Array


def supported_range(found: Sequence[Levels]) -> tuple[float, float]:
    """Frequencies / Hz between 1/(2π·t) of the longest hold and of the longest ramp: what the records tell of."""
    longest = min(max((one.duration for one in each.held), default=0.0) for each in found)
    ramp = max(each.ramp for each in found)
    high = 1 / (2 * np.pi * ramp)
    return min(1 / (2 * np.pi * max(longest, ramp)), high / 1.01), high


def predicted(
    found: Supported, scenes: Sequence[Scene], factors: Sequence[float], frequency: Array, shared: float
) -> Predicted:
    """Mean over the specimens, all forms by their probability.

    The interval holds what the records leave, the scatter between the specimens and what all share.

    Parameters
    ----------
    found : Supported
        Forms and fits.
    scenes : sequence of Scene
        One a specimen.
    factors : sequence of float
        From force by stretch of each specimen to the quantity that is shown.
    frequency : ndarray, shape (f,)
        Hz.
    shared : float
        Relative standard uncertainty of scales, lengths and sections.
    """
    from scipy.special import stdtrit

    each = [said(found, at, _parts(scene, frequency)) for at, scene in enumerate(scenes)]
    rows = np.array([factor * one.values for factor, one in zip(factors, each, strict=True)])
    own = np.array([factor * one.u * float(stdtrit(one.dof, 0.975))
                    for factor, one in zip(factors, each, strict=True)])  # fmt: skip
    m, mean = len(rows), rows.mean(axis=0)
    half2 = (own**2).sum(axis=0) / m**2 + (NORMAL * shared * np.abs(mean)) ** 2
    if m > 1:
        half2 = half2 + rows.var(axis=0, ddof=1) / m * float(stdtrit(m - 1, 0.975)) ** 2
    return Predicted(frequency, mean.reshape(2, -1), np.sqrt(half2).reshape(2, -1))


def _parts(scene: Scene, frequency: Array) -> Callable[[Form, Array], Array]:
    def parts(form: Form, values: Array) -> Array:
        return scene.moduli(form, values, frequency).ravel()

    return parts


def shown(quantity: str, curve: Predicted) -> Moduli:
    """The curves for the report."""
    low, high = curve.values - curve.half, curve.values + curve.half
    return Moduli(
        quantity, tuple(curve.frequency.tolist()),
        *(tuple(row.tolist()) for part in (0, 1) for row in (curve.values[part], low[part], high[part])),
    )  # fmt: skip


def compared(sweep: Sweep, curve: Predicted, ends: tuple[float, float]) -> tuple[Compared, ...]:
    """E_n at every frequency of a sweep that the records support (ISO 13528:2022, 9.7)."""
    found = []
    for at, frequency in enumerate(sweep.frequency.tolist()):
        inside = ends[0] <= frequency <= ends[1]
        row: list[float | None] = []
        for part, (read, u) in enumerate(((sweep.storage, sweep.storage_u), (sweep.loss, sweep.loss_u))):
            expanded = 0.0 if u is None else 2 * float(u[at])
            off = float(read[at]) - float(curve.values[part, at])
            row.append(off / max(float(np.hypot(expanded, curve.half[part, at])), 1e-300) if inside else None)
        u_storage = None if sweep.storage_u is None else float(sweep.storage_u[at])
        u_loss = None if sweep.loss_u is None else float(sweep.loss_u[at])
        storage, loss = (float(curve.values[part, at]) if inside else None for part in (0, 1))
        found.append(Compared(frequency, float(sweep.storage[at]), u_storage, float(sweep.loss[at]), u_loss,
                              storage, loss, row[0], row[1]))  # fmt: skip
    return tuple(found)
