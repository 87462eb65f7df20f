"""What plots of a run over time share: its span, phases, lines and bands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, decimate, plain

SYMBOLS = {"rad": "φ", "rad/s": "φ′"}
"""Unit of a channel → its symbol, where that is not the channel's own."""
SHADE = "#f0f1f3"
_COLUMNS = 350
"""Columns that a line is decimated to: 0.4 mm each."""


def shaded(plot: Sketch, phases: Sequence[tuple[str, float, float]], span: tuple[float, float], *, named: bool) -> None:
    """Every other phase, and their names where wanted."""
    taken = span[0]
    for index, (name, start, stop) in enumerate(phases):
        if index % 2:
            plot.shade(start, stop, SHADE)
        begins = max(start, taken)
        if named and begins < stop:  # A phase that ends within the name before it stands without its own.
            taken = plot.note(f"{plain(plot.language.word(name), 12)}  ", begins, rise=2.0)


def whole(times: Iterable[Sequence[float]]) -> tuple[float, float]:
    """First and last of all times: panels above each other share the axis of the lowest."""
    ends = [(float(time[0]), float(time[-1])) for time in times if time]
    return min((first for first, _ in ends), default=0.0), max((last for _, last in ends), default=1.0)


def symbol(channel: Mapping[str, Any]) -> str:
    """Symbol of a channel."""
    found: str = SYMBOLS.get(channel["unit"], channel["channel"])
    return found


def band(plot: Sketch, time: Sequence[float], channel: Mapping[str, Any], factor: float) -> None:
    """Band of a prediction."""
    ((x, low),) = decimate(time, np.array(channel["low"]) / factor, columns=_COLUMNS)
    high = np.interp(x, time, np.array(channel["high"]) / factor)
    plot.band(x.tolist(), low.tolist(), high.tolist(), BAND)


def stroke(plot: Sketch, time: Sequence[float], values: Sequence[float | None], factor: float, pen: Pen) -> None:
    """A line; a gap in the readings is one in the line."""
    if not len(values):
        return
    y = np.array([np.nan if value is None else value for value in values], float) / factor
    ((x, drawn),) = decimate(time, y, columns=_COLUMNS)
    begins = np.flatnonzero(np.isnan(y) & ~np.isnan(np.concatenate([[0.0], y[:-1]])))
    at = np.searchsorted(x, np.asarray(time, float)[begins])
    plot.line(np.insert(x, at, 0.0).tolist(), np.insert(drawn, at, np.nan).tolist(), pen)


def largest(*values: Iterable[float | None]) -> float:
    """Largest magnitude of all values."""
    return max((abs(value) for line in values for value in line if value is not None), default=0.0)


def spread(*values: Iterable[float | None], factor: float) -> tuple[float, float]:
    """Window of an axis that holds all values."""
    known = [value / factor for line in values for value in line if value is not None]
    low, high = min(known, default=0.0), max(known, default=1.0)
    margin = 0.05 * (high - low)
    return low - margin, high + margin
