"""A plot of few strokes, put down directly: a tenth of the time of a figure with axes, where there is one a result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import ceil, floor, log10

from metrology.report.figures.renderer import Pen, Shape, ShapeRenderer, Words, advance, operators, svg
from metrology.report.figures.style import INK, Plot

POINTS = 72 / 25.4
"""Points in a millimetre."""


class Sketch:
    """A sheet of `width` by `height` mm with a window onto x and y; methods take coordinates of the window."""

    def __init__(self, size: tuple[float, float], box: tuple[float, float, float, float], *, label: str = "") -> None:
        self._sheet = ShapeRenderer(size[0] * POINTS, size[1] * POINTS)
        self._x, self._y = (0.0, 1.0), (0.0, 1.0)
        self.panel(box)
        if label:
            self._words(label, 0.5 * POINTS, 0.8 * POINTS, 5.5, bold=True)

    def panel(self, box: tuple[float, float, float, float]) -> None:
        """Draw from now on within margins `box` = (left, bottom, right, top) in mm."""
        left, bottom, right, top = (edge * POINTS for edge in box)
        self._corner, self._span = (left, bottom), (self._sheet.width - left - right, self._sheet.height - bottom - top)

    def window(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        """Set what of x and y is seen; an empty range is widened."""
        self._x, self._y = _wide(x), _wide(y)

    def line(self, xs: Iterable[float], ys: Iterable[float | None], pen: Pen) -> None:
        """Stroke, or fill, through points; a gap (None, NaN) interrupts the stroke."""
        steps: list[tuple[str, tuple[float, ...]]] = []
        letter = "M"
        for x, y in zip(xs, ys, strict=True):
            if y is None or y != y:
                letter = "M"
                continue
            steps.append((letter, self._place(x, y)))
            letter = "L"
        self._sheet.shapes.append(Shape(pen, steps + [("Z", ())] * bool(pen.fill)))

    def band(self, xs: Sequence[float], low: Sequence[float], high: Sequence[float], colour: str) -> None:
        """Fill between two lines."""
        self.line([*xs, *reversed(xs)], [*low, *reversed(high)], Pen(fill=colour))

    def shade(self, start: float, stop: float, colour: str) -> None:
        """Fill the whole height of the window from `start` to `stop`."""
        start, stop = max(start, self._x[0]), min(stop, self._x[1])
        if stop > start:
            self.band((start, stop), (self._y[0],) * 2, (self._y[1],) * 2, colour)

    def note(self, text: str, x: float, *, rise: float = 2.0) -> None:
        """Small words above the window from `x` on."""
        self._words(text, self._place(x, 0.0)[0], self._corner[1] + self._span[1] + rise, 5.5)

    def interval(self, low: float, high: float, y: float, pen: Pen) -> None:
        """A horizontal stroke with an upright mark at both ends."""
        self.line((low, high), (y, y), pen)
        for end in (low, high):
            x, at = self._place(end, y)
            mark: list[tuple[str, tuple[float, ...]]] = [("M", (x, at - 2.5)), ("L", (x, at + 2.5))]
            self._sheet.shapes.append(Shape(Pen(stroke=pen.stroke, width=1.0), mark))

    def x_axis(self, title: str, count: int = 5) -> None:
        """The lower axis with ticks at round numbers, and its title; no words without a title."""
        left, low = self._corner
        self._stroke((left, low), (left + self._span[0], low))
        places, decimals = ticks(*self._x, count)
        for value in places:
            x, _ = self._place(value, 0.0)
            self._stroke((x, low), (x, low - 2.5))
            if not title:
                continue
            text = f"{value:.{decimals}f}".replace("-", "−")
            self._words(text, x - _width(text, 6.5) / 2, low - 9.5, 6.5)
        self._words(title, left + (self._span[0] - _width(title, 7.0)) / 2, low - 19.0, 7.0)

    def y_axis(self, title: str, count: int = 3) -> None:
        """The left axis with ticks at round numbers, and its title up the edge of the sheet."""
        left, low = self._corner
        self._stroke((left, low), (left, low + self._span[1]))
        places, decimals = ticks(*self._y, count)
        for value in places:
            _, y = self._place(0.0, value)
            self._stroke((left, y), (left - 2.5, y))
            text = f"{value:.{decimals}f}".replace("-", "−")
            self._words(text, left - 4.0 - _width(text, 6.0), y - 2.1, 6.0)
        self._words(title, left - 31.0, low + (self._span[1] - _width(title, 6.5)) / 2, 6.5, angle=90.0)

    def y_title(self, title: str) -> None:
        """A title up the left edge."""
        left, low = self._corner
        self._words(title, left - 5.0, low + (self._span[1] - _width(title, 7.0)) / 2, 7.0, angle=90.0)

    def legend(self, entries: Iterable[tuple[str, Pen]], columns: int = 2, width: float = 33.0) -> None:
        """Names with samples of their strokes above the window, `columns` a row, each `width` mm."""
        entries = list(entries)
        rows = -(-len(entries) // columns)
        for index, (name, pen) in enumerate(entries):
            column, row = divmod(index, rows)
            x = 1.0 * POINTS + column * width * POINTS
            y = self._corner[1] + self._span[1] + 4.0 + (rows - 1 - row) * 8.0
            steps: list[tuple[str, tuple[float, ...]]] = [("M", (x, y + 2.0)), ("L", (x + 11.0, y + 2.0))]
            sample = Pen(stroke=pen.fill, width=5.0) if pen.fill else pen
            self._sheet.shapes.append(Shape(sample, steps))
            self._words(name, x + 15.0, y, 6.0)

    def finish(self, alt: str, caption: str) -> Plot:
        """The sheet as a plot."""
        sheet = self._sheet
        return Plot(svg(sheet), operators(sheet), sheet.width, sheet.height, alt, caption)

    def _place(self, x: float, y: float) -> tuple[float, float]:
        across = (x - self._x[0]) / (self._x[1] - self._x[0])
        up = (y - self._y[0]) / (self._y[1] - self._y[0])
        return self._corner[0] + across * self._span[0], self._corner[1] + up * self._span[1]

    def _stroke(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self._sheet.shapes.append(Shape(Pen(stroke=INK, width=0.5), [("M", start), ("L", end)]))

    def _words(self, text: str, x: float, y: float, size: float, *, angle: float = 0.0, bold: bool = False) -> None:
        self._sheet.shapes.append(Words(text, x, y, angle, size, bold, INK))


def ticks(low: float, high: float, count: int) -> tuple[list[float], int]:
    """Round numbers from `low` to `high`, about `count` and two at least, and the decimals that they need.

    Examples
    --------
    >>> ticks(23710.0, 25890.0, 5)
    ([24000.0, 24500.0, 25000.0, 25500.0], 0)
    """
    raw = (high - low) / count
    power = 10.0 ** floor(log10(raw))
    step = next(round_step * power for round_step in (1, 2, 5, 10) if round_step * power >= raw * 0.999)
    decimals = max(0, -floor(log10(step) + 1e-9))
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return ([i * step for i in range(first, last + 1)], decimals) if last > first else ticks(low, high, count + 1)


def _wide(ends: tuple[float, float]) -> tuple[float, float]:
    low, high = ends
    return (low, high) if high > low else (low - (abs(low) or 1.0), low + (abs(low) or 1.0))


def _width(text: str, size: float) -> float:
    return size * sum(advance(character) for character in text)
