"""What is said of blocks: sizes that each has for itself, and residuals in bins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from metrology.diagnosis import Missing
from metrology.diagnostics.subject import Array, Fit
from metrology.effect import Size
from metrology.message import said


def sizes_of_blocks(fit: Fit, size: Size, blocks: Sequence[str], spread: Array) -> str:
    """Size that each block has for itself, with its standard uncertainty, in words.

    Parameters
    ----------
    fit : Fit
        With these sizes.
    size : Size
        Of which the unknowns are named ``'size@block'``.
    blocks : sequence of str
        Names, in the order of the words.
    spread : array, shape (p,)
        Standard uncertainty of every unknown of the fit.

    Returns
    -------
    str
    """
    found = [(one, fit.index(f"{size.name}@{one}")) for one in blocks]
    rows = [f"{text} {_signed(fit.theta[at])} ± {_signed(spread[at])}" for text, at in found if at is not None]
    return said("{name} / ({unit}): {sizes:figures}.", name=size.name, unit=size.unit, sizes=", ".join(rows))


def _signed(value: float) -> str:
    return f"{value:.2g}".replace("-", "−")


def binned(
    quantity: str, unit: str, columns: Mapping[tuple[str, str], Array], residual: Array, u: Array
) -> Missing | None:
    """Residuals in bins of whatever they depend on most."""
    best: tuple[float, tuple[str, str], list[NDArray[np.intp]]] | None = None
    share: dict[str, float] = {}
    for key, by in columns.items():
        parts = [part for part in np.array_split(np.argsort(by, kind="stable"), min(12, len(by) // 3)) if len(part)]
        if len(parts) < 3:
            continue
        total = float(residual.var() * len(residual))
        between = sum(len(part) * (residual[part].mean() - residual.mean()) ** 2 for part in parts)
        share[key[0]] = float(np.clip(between / max(total, 1e-300), 0.0, 1.0))
        if best is None or share[key[0]] > best[0]:
            best = (share[key[0]], key, parts)
    if best is None:
        return None
    _, (against, against_unit), parts = best
    by = columns[against, against_unit]
    at = tuple(float(by[part].mean()) for part in parts)
    value = tuple(float(residual[part].mean()) for part in parts)
    spread = tuple(float(math.sqrt(np.mean(u[part] ** 2) / len(part))) for part in parts)
    worst = int(np.argmax(np.abs(value)))
    text = (
        "Up to {size:.2g} {unit} (u = {u:.1g} {unit}) are missing at a {against} of {at:.3g} {against_unit}; it "
        "depends most on {against}."
    )
    sentence = said(
        text, size=value[worst], unit=unit, u=spread[worst], against=against, at=at[worst], against_unit=against_unit
    )
    return Missing(quantity, unit, against, against_unit, at, value, spread, share, sentence)
