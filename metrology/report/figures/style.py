"""One look for every plot: the bundled font, colours that survive grey printing and colour blindness, few shapes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.report import fonts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, BLUE, ORANGE, GREY, PALE, BAND = "#1b1f24", "#0b4f8a", "#d9822b", "#8b939c", "#b9c1c9", "#c6d9ec"
"""Their luminances differ: 0.01, 0.07, 0.31, 0.28 and lighter; what shares a plot also differs in shape or dash."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
FULL, HALF = 170.0, 83.0
"""Widths in mm: across the page, and two side by side."""
COLUMNS = 700
"""Columns of pixels that a full-width line is decimated to: 0.2 mm each."""

_RC: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 7.0,
    "axes.titlesize": 7.0,
    "axes.labelsize": 7.0,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.1,
    "legend.handletextpad": 0.5,
    "legend.borderaxespad": 0.0,
    "axes.linewidth": 0.5,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 6),
    "axes.formatter.use_mathtext": False,
    "lines.linewidth": 0.9,
    "lines.markersize": 3.0,
    "path.simplify": True,
    "axes.facecolor": "none",
    "figure.facecolor": "none",
    "figure.edgecolor": "none",
    "text.hinting": "none",
    "text.parse_math": False,
    "mathtext.fontset": "dejavusans",
}


@dataclass(frozen=True)
class Plot:
    """A finished picture as `svg` element and as PDF operators; what it shows in words; size in points.

    `series`: its data as JSON, where the HTML lets the reader zoom.
    """

    svg: str
    operators: bytes
    width: float
    height: float
    alt: str
    caption: str = ""
    series: str = ""

    @property
    def half(self) -> bool:
        """Whether two stand side by side."""
        return self.width < 100 * 72 / 25.4


@contextmanager
def drawing() -> Iterator[None]:
    """Draw in the house style whatever a user's matplotlibrc says."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_RC)  # type: ignore[arg-type]
        yield


def canvas(width: float, height: float, *, label: str = "") -> Figure:
    """Figure of `width` by `height` mm; `label` stands at its lower left: "reconstructed" must be on every plot."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width / 25.4, height / 25.4))
    if label:
        figure.text(0.5 / width, 0.8 / height, label, ha="left", va="bottom", fontsize=5.5, fontweight="bold")
    return figure


def place(figure: Figure, box: tuple[float, float, float, float], **options: Any) -> Axes:
    """Axes in `figure` with margins `box` = (left, bottom, right, top) in mm."""
    width, height = figure.get_size_inches() * 25.4
    left, bottom, right, top = box
    return figure.add_axes(
        (left / width, bottom / height, (width - left - right) / width, (height - bottom - top) / height), **options
    )


def legend(axes: Axes, columns: int = 4) -> None:
    """Legend above the axes, where it covers no data."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=columns)


def finish(figure: Figure, alt: str, caption: str) -> Plot:
    """The figure as shapes; its bytes depend on nothing but what is drawn."""
    from metrology.report.figures import renderer

    drawn = renderer.render(figure)
    return Plot(renderer.svg(drawn), renderer.operators(drawn), drawn.width, drawn.height, alt, caption)


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
