"""One look for every plot: the bundled font, colours that survive grey printing and colour blindness, few shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from metrology.report import fonts

INK, BLUE, ORANGE, GREY, PALE, BAND = "#1b1f24", "#0b4f8a", "#d9822b", "#8b939c", "#b9c1c9", "#c6d9ec"
"""Their luminances differ: 0.01, 0.07, 0.31, 0.28 and lighter; what shares a plot also differs in shape or dash."""
MARKERS = ("o", "s", "^", "D", "v")
FULL, HALF = 170.0, 83.0
"""Widths in mm: across the page, and two side by side."""
NAMES = 38.0
"""Room for the names of curves at the right of a panel, in mm."""
COLUMNS = 700
"""Columns of pixels that a full-width line is decimated to: 0.2 mm each."""


@dataclass(frozen=True)
class Plot:
    """A finished picture as `svg` element and as PDF operators; what it shows in words; size in points.

    `series`: its data as JSON, where the HTML lets the reader zoom. `of`: the test that it shows in full, where that is
    said.
    """

    svg: str
    operators: bytes
    width: float
    height: float
    alt: str
    caption: str = ""
    series: str = ""
    of: str = ""

    @property
    def half(self) -> bool:
        """Whether two stand side by side."""
        return self.width < 100 * 72 / 25.4


def plain(text: str, limit: int = 60) -> str:
    """A user's text for a plot: one line, at most `limit` characters, only characters that the font has."""
    line = " ".join(text.split())
    line = "".join(
        character if ord(character) in fonts.characters() else "\N{REPLACEMENT CHARACTER}" for character in line
    )
    return line if len(line) <= limit else line[: limit - 1] + "…"


def decimate(
    x: Sequence[float] | np.ndarray[Any, Any], *lines: Sequence[float] | np.ndarray[Any, Any], columns: int = COLUMNS
) -> list[tuple[Any, Any]]:
    """Each line with the smallest and the largest value of each of `columns` columns: no spike is lost."""
    return [_extremes(np.asarray(x, float), np.asarray(line, float), columns) for line in lines]


def _extremes(x: Any, y: Any, columns: int) -> tuple[Any, Any]:
    keep = np.isfinite(x) & np.isfinite(y)
    x, y = x[keep], y[keep]
    if x.size <= 2 * columns:
        return x, y
    edges = np.linspace(0, x.size, columns + 1).astype(int)[:-1]
    picked = np.sort(np.concatenate([_arg(y, edges, np.argmin), _arg(y, edges, np.argmax)]))
    return x[picked], y[picked]


def _arg(y: Any, edges: Any, pick: Any) -> Any:
    ends = np.append(edges[1:], y.size)
    return np.array([start + pick(y[start:end]) for start, end in zip(edges, ends, strict=True)])
