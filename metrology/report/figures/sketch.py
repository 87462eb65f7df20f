"""A plot of few strokes, put down directly: a tenth of the time of a figure with axes, where there is one a result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import log10

from metrology.language.catalogue import ENGLISH, Language
from metrology.message import Sentence
from metrology.report.figures.marks import Mark, Steps, mark_pen, marked
from metrology.report.figures.shapes import Pen, Shape, Sheet, Words, advance, operators, svg
from metrology.report.figures.style import INK, Plot
from metrology.report.figures.ticks import decades, ticks

POINTS = 72 / 25.4
"""Points in a millimetre."""
TEXT = 8.0
"""Size in points of all words in a plot: no smaller, for a print at full width has to be read."""
LEADING = 9.6
"""From one line of words to the next, in points."""
_SAMPLE = 15.0
"""Room for the sample of a stroke or mark before its name, in points."""


class Sketch:
    """A sheet of `width` by `height` mm with a window onto x and y; methods take coordinates of the window."""

    def __init__(
        self,
        size: tuple[float, float],
        box: tuple[float, float, float, float],
        *,
        label: str = "",
        language: Language = ENGLISH,
    ) -> None:
        self.language = language
        self._sheet = Sheet(size[0] * POINTS, size[1] * POINTS)
        self._x, self._y = (0.0, 1.0), (0.0, 1.0)
        self.panel(box)
        if label:
            self._words(language.spoken(label), 0.5 * POINTS, 0.8 * POINTS, bold=True)

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

    def dots(self, xs: Iterable[float], ys: Iterable[float], mark: Mark) -> None:
        """A mark at every point inside the window."""
        low, high = self._y
        steps: Steps = []
        for x, y in zip(xs, ys, strict=True):
            if low <= y <= high:
                steps += marked(mark, *self._place(x, y))
        if steps:
            self._sheet.shapes.append(Shape(mark_pen(mark), steps))

    def errors(self, xs: Iterable[float], ys: Iterable[float], halves: Iterable[float], pen: Pen) -> None:
        """Upright strokes of ±half about every point."""
        steps: Steps = []
        for x, y, half in zip(xs, ys, halves, strict=True):
            low, high = max(y - half, self._y[0]), min(y + half, self._y[1])
            if high > low:
                steps += [("M", self._place(x, low)), ("L", self._place(x, high))]
        if steps:
            self._sheet.shapes.append(Shape(pen, steps))

    def level(self, y: float, pen: Pen) -> None:
        """A line across the window at height y, where it is seen."""
        if self._y[0] <= y <= self._y[1]:
            self.line(self._x, (y, y), pen)

    def upright(self, x: float, pen: Pen) -> None:
        """A line up the window at x."""
        self.line((x, x), self._y, pen)

    def text(self, words: str, at: tuple[float, float], *, align: float = 0.0) -> None:
        """Words whose left end (`align` 0), middle (0.5) or right end (1) stands at a point in the window."""
        words = self.language.spoken(words)
        x, y = self._place(*at)
        self._words(words, x - align * _width(words), y - 0.36 * TEXT)

    def note(self, text: str, x: float, *, rise: float = 2.0) -> float:
        """Small words above the window from `x` on; where they end."""
        text = self.language.spoken(text)
        self._words(text, self._place(x, 0.0)[0], self._corner[1] + self._span[1] + rise)
        return x + _width(text) / self._span[0] * (self._x[1] - self._x[0])

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
            text = self._figures(value, decimals)
            self._words(text, x - _width(text) / 2, low - 10.5)
        self._below(title)

    def _figures(self, value: float, decimals: int) -> str:
        return self.language.figures(f"{value:.{decimals}f}".replace("-", "−"))

    def _below(self, title: str) -> None:
        """The title of the lower axis, flush right: what marks the whole plot stands at its left."""
        title = self.language.spoken(title)
        left, low = self._corner
        self._words(title, left + self._span[0] - _width(title), low - 20.5)

    def _beside(self, title: str) -> None:
        """The title of the left axis, up the edge of the sheet."""
        title = self.language.spoken(title)
        left, low = self._corner
        self._words(title, left - 33.0, low + (self._span[1] - _width(title)) / 2, angle=90.0)

    def y_axis(self, title: str, count: int = 3) -> None:
        """The left axis with ticks at round numbers, and its title up the edge of the sheet."""
        left, low = self._corner
        self._stroke((left, low), (left, low + self._span[1]))
        places, decimals = ticks(*self._y, count)
        for value in places:
            _, y = self._place(0.0, value)
            self._stroke((left, y), (left - 2.5, y))
            text = self._figures(value, decimals)
            self._words(text, left - 4.0 - _width(text), y - 2.9)
        self._beside(title)

    def x_decades(self, title: str) -> None:
        """The lower axis of a window onto logarithms to base ten, and its title."""
        left, low = self._corner
        self._stroke((left, low), (left + self._span[0], low))
        for value in decades(*self._x):
            x, _ = self._place(log10(value), 0.0)
            self._stroke((x, low), (x, low - 2.5))
            text = self.language.figures(f"{value:g}")
            self._words(text, x - _width(text) / 2, low - 10.5)
        self._below(title)

    def y_decades(self, title: str) -> None:
        """The left axis of a window onto logarithms to base ten."""
        left, low = self._corner
        self._stroke((left, low), (left, low + self._span[1]))
        for value in decades(*self._y):
            _, y = self._place(0.0, log10(value))
            self._stroke((left, y), (left - 2.5, y))
            text = self.language.figures(f"{value:g}")
            self._words(text, left - 4.0 - _width(text), y - 2.9)
        self._beside(title)

    def y_title(self, title: str) -> None:
        """A title up the left edge."""
        title = self.language.spoken(title)
        left, low = self._corner
        self._words(title, left - 5.0, low + (self._span[1] - _width(title)) / 2, angle=90.0)

    @staticmethod
    def legend_rows(names: Iterable[str], width: float) -> int:
        """Rows that a legend of these names takes on a sheet so wide / mm."""
        rows, x = 1, (left := 4.0 * POINTS)
        for name in names:
            if x > left and x + _SAMPLE + _width(name) > width * POINTS:
                rows, x = rows + 1, left
            x += _SAMPLE + _width(name) + 9.0
        return rows

    def legend(self, entries: Iterable[tuple[str, Pen | Mark]]) -> None:
        """Names with samples of their strokes or marks above the window, in as many rows as they need."""
        rows: list[list[tuple[str, Pen | Mark, float]]] = [[]]
        x = left = min(self._corner[0], 4.0 * POINTS)
        for name, sample in ((self.language.spoken(name), sample) for name, sample in entries):
            if rows[-1] and x + _SAMPLE + _width(name) > self._sheet.width:
                rows.append([])
                x = left
            rows[-1].append((name, sample, x))
            x += _SAMPLE + _width(name) + 9.0
        for row, placed in enumerate(reversed(rows)):
            y = self._corner[1] + self._span[1] + 4.0 + row * LEADING
            for name, sample, at in placed:
                self._sample(sample, at, y + 2.6)
                self._words(name, at + _SAMPLE, y)

    def labels(self, entries: Iterable[tuple[str, float, Pen | Mark]]) -> None:
        """Name curves at the right of the window, each at the height y where it ends, none on top of another."""
        low, high = self._corner[1], self._corner[1] + self._span[1]
        ordered = sorted(entries, key=lambda one: one[1])
        x = self._corner[0] + self._span[0] + 4.0
        beneath = low - LEADING
        for index, (words, y, sample) in enumerate(ordered):
            wanted = min(max(self._place(0.0, y)[1], low + 3.0), high) - 2.9
            # Those that are still to come need room up to the top.
            room = high - 2.9 - LEADING * (len(ordered) - 1 - index)
            at = beneath = max(min(wanted, room), beneath + LEADING)
            self._sample(sample, x, at + 2.6)
            self._words(self.language.spoken(words), x + _SAMPLE, at)

    def _sample(self, sample: Pen | Mark, x: float, y: float) -> None:
        if isinstance(sample, Mark):
            self._sheet.shapes.append(Shape(mark_pen(sample), marked(sample, x + 6.0, y)))
            return
        pen = Pen(stroke=sample.fill, width=5.0) if sample.fill else sample
        self._sheet.shapes.append(Shape(pen, [("M", (x, y)), ("L", (x + 11.0, y))]))

    def finish(self, alt: str, caption: str) -> Plot:
        """The sheet as a plot."""
        sheet, told = self._sheet, retold(caption, self.language)
        return Plot(svg(sheet), operators(sheet), sheet.width, sheet.height, self.language.spoken(alt), told)

    def _place(self, x: float, y: float) -> tuple[float, float]:
        across = (x - self._x[0]) / (self._x[1] - self._x[0])
        up = (y - self._y[0]) / (self._y[1] - self._y[0])
        return self._corner[0] + across * self._span[0], self._corner[1] + up * self._span[1]

    def _stroke(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self._sheet.shapes.append(Shape(Pen(stroke=INK, width=0.5), [("M", start), ("L", end)]))

    def _words(self, text: str, x: float, y: float, *, angle: float = 0.0, bold: bool = False) -> None:
        self._sheet.shapes.append(Words(text, x, y, angle, TEXT, bold, INK))


def retold(text: str, language: Language) -> str:
    """A sentence in a language, which can be said again in another one."""
    told = language.spoken(text)
    if not isinstance(text, Sentence):
        return told
    made = Sentence(told)
    made.message, made.plural, made.values = text.message, text.plural, text.values
    return made


def _wide(ends: tuple[float, float]) -> tuple[float, float]:
    low, high = ends
    return (low, high) if high > low else (low - (abs(low) or 1.0), low + (abs(low) or 1.0))


def _width(text: str) -> float:
    return TEXT * sum(advance(character) for character in text)
