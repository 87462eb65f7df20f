"""Channels of a held-out run over time: all samples for the screen, few for paper and for `results.json`."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrology.timeseries import Trace
from metrology.verify.finding import Series, VerificationFinding

Array = NDArray[np.float64]
POINTS = 2000
"""Points that are kept of a series for drawing on paper."""


def thinned(finding: VerificationFinding) -> VerificationFinding:
    """Return the verification with series of about `POINTS`, minimum and maximum kept.

    Parameters
    ----------
    finding : VerificationFinding
        With the series of every reading.

    Returns
    -------
    VerificationFinding
        The same but for its series.
    """
    runs = (replace(run, series=tuple(map(_thinned, run.series))) for run in finding.runs)
    return replace(finding, runs=tuple(runs))


def trace(series: Series) -> Trace:
    """Return a series as arrays; a gap is NaN.

    Parameters
    ----------
    series : Series
        Columns as tuples, None where there is no value.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        By name of the column, in SI.
    """
    return {name: np.array(getattr(series, name), float) for name in _COLUMNS}


_COLUMNS = tuple(entry.name for entry in fields(Series) if entry.name not in ("channel", "unit", "count"))


def _thinned(series: Series) -> Series:
    columns = trace(series)
    own = columns["closed"] if series.closed else columns["simulated"]
    kept = decimated(columns["measured"], columns["measured"] - columns["simulated"], own)
    if len(kept) == len(series.time):
        return series
    rows = {name: getattr(series, name) for name in _COLUMNS}
    short: dict[str, Any] = {name: tuple(row[at] for at in kept) for name, row in rows.items() if row}
    return replace(series, **short)


def decimated(*columns: Array, points: int = POINTS) -> NDArray[np.intp]:
    """Indices that keep minimum and maximum of every column in each of equal bins, about `points` in all, in order.

    Parameters
    ----------
    *columns : ndarray, shape (n,)
        Of one length, in any units.
    points : int
        Indices to keep, about.

    Returns
    -------
    ndarray of int, shape (m,)
        In order, with both ends.
    """
    count = len(columns[0])
    if count <= points:
        return np.arange(count)
    bins = max(1, points // (2 * len(columns)))
    parts = np.array_split(np.arange(count), bins)
    # A part that is one shorter than the first shows its first sample twice.
    rows = np.array([np.resize(part, len(parts[0])) for part in parts])
    kept = [np.array([0, count - 1])]
    for column in columns:
        values = column[rows]
        known = np.isfinite(values)
        ends = np.where(known, values, np.inf).argmin(axis=1), np.where(known, values, -np.inf).argmax(axis=1)
        kept += [rows[np.arange(bins), end][known.any(axis=1)] for end in ends]
    return np.unique(np.concatenate(kept)).astype(np.intp)
