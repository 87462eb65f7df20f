"""How readings are marked in a plot: outlines of a mark, and the pen that draws it."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

from metrology.report.figures.shapes import Pen

Steps = list[tuple[str, tuple[float, ...]]]
_CIRCLE = tuple((0.5 * cos(pi * i / 8), 0.5 * sin(pi * i / 8)) for i in range(16))
_OUTLINES = {
    "o": _CIRCLE,
    "^": ((0.0, 0.6), (-0.52, -0.4), (0.52, -0.4)),
    "v": ((0.0, -0.6), (-0.52, 0.4), (0.52, 0.4)),
    "s": ((-0.45, -0.45), (0.45, -0.45), (0.45, 0.45), (-0.45, 0.45)),
    "D": ((0.0, 0.65), (0.5, 0.0), (0.0, -0.65), (-0.5, 0.0)),
}
"""Mark → its outline, one unit across; `x` is two strokes."""


@dataclass(frozen=True)
class Mark:
    """How a reading is marked: o, ^, v, s, D or x, `size` points across."""

    shape: str
    colour: str
    size: float = 3.2
    hollow: bool = False


def mark_pen(mark: Mark) -> Pen:
    """The pen that draws a mark."""
    if mark.shape == "o" and not mark.hollow:
        return Pen(stroke=mark.colour, width=mark.size, cap="round")
    if mark.shape == "x":
        return Pen(stroke=mark.colour, width=0.9)
    return Pen(stroke=mark.colour, width=0.6) if mark.hollow else Pen(fill=mark.colour)


def marked(mark: Mark, x: float, y: float) -> Steps:
    """The strokes of a mark about a point."""
    if mark.shape == "o" and not mark.hollow:
        return [("M", (x, y)), ("L", (x, y))]
    half = 0.5 * mark.size
    if mark.shape == "x":
        ends = ((-half, -half, half, half), (-half, half, half, -half))
        return [step for a, b, c, d in ends for step in (("M", (x + a, y + b)), ("L", (x + c, y + d)))]
    outline = [(x + mark.size * a, y + mark.size * b) for a, b in _OUTLINES[mark.shape]]
    return [("L" if i else "M", point) for i, point in enumerate(outline)] + [("Z", ())]
