"""What makes a missing effect visible: the pictures of a diagnosis, two side by side or three of a kind in a row."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import partial
from math import isfinite, log10, nan
from typing import TYPE_CHECKING, Any

from metrology.diagnosis import Curve, Diagnosis, Missing, Picture
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import number, scale
from metrology.message import said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BLUE, FULL, GREY, HALF, INK, MARKERS, ORANGE, Plot, plain

if TYPE_CHECKING:
    from metrology.report.figures import Job

COLOURS = {"measured": GREY, "before": ORANGE, "after": BLUE, "limit": INK}
PENS = {
    "measured": Pen(stroke=GREY, width=1.3),
    "before": Pen(stroke=ORANGE, width=0.7),
    "after": Pen(stroke=BLUE, width=0.7, dash=(3.0, 1.0)),
    "limit": Pen(stroke=INK, width=0.6, dash=(1.0, 1.2)),
}
"""Role → line; luminances differ, and what was extended is dashed."""
_ZERO = Pen(stroke=GREY, width=0.5)
_ROWS = ("spectrum", "history")
"""Kinds of picture of which there is one for each channel."""


def jobs(finding: Diagnosis, label: str, language: Language = ENGLISH) -> Iterator[Job]:
    """Every plot of one diagnosed test: key and what draws it."""
    known: dict[str, Any] = {"label": label, "language": language}
    head = f"diagnosis/{finding.test}"
    named = plain(finding.test)
    for name, pictures in rows(finding).items():
        if len(pictures) == 1:
            yield f"{head}/{name}", partial(draw, pictures[0], named, **known)
        else:
            yield f"{head}/{name}", partial(draw_row, pictures, named, **known)
    if finding.missing is not None:
        yield f"{head}/missing", partial(draw, of_missing(finding.missing), named, **known)


def rows(finding: Diagnosis) -> dict[str, tuple[Picture, ...]]:
    """Pictures by the name of their plot: those of one kind for each channel stand in one."""
    found: dict[str, tuple[Picture, ...]] = {}
    for picture in finding.pictures:
        kind = picture.key.partition("-")[0]
        name = kind if kind in _ROWS else picture.key
        found[name] = (*found.get(name, ()), picture)
    return found


def of_missing(missing: Missing) -> Picture:
    """What is missing without a model, as a picture of one curve."""
    curve = Curve(said("estimate without a model"), "before", missing.at, missing.value, missing.u)
    title = said("Missing {what} against {against}", what=missing.what, against=missing.against)
    return Picture(
        "missing", title, missing.against, missing.against_unit, missing.quantity, missing.unit, (curve,),
        missing.sentence,
    )  # fmt: skip


def draw(picture: Picture, test: str, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """One picture, half the width of a page."""
    deep = Sketch.legend_rows([name for name, _ in _legend(picture, language)], HALF)
    size, box = (HALF, 47.0 + 3.0 * deep), (15.0, 11.0, 2.0, 3.0 + 3.0 * deep)
    plot = Sketch(size, box, label=label, language=language)
    _panel(plot, picture)
    plot.legend(_legend(picture, language))
    return plot.finish(_alt(picture, test), _caption(picture))


def draw_row(pictures: Sequence[Picture], test: str, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Pictures of one kind side by side, across the page."""
    across = len(pictures)
    width = FULL / across
    # What all titles begin with stands in the caption.
    titles = [language.spoken(picture.title) for picture in pictures]
    begun = titles[0].rpartition(", ")[0] + ", "
    shared = len(begun) if across > 1 and all(title.startswith(begun) for title in titles) else 0
    plot = Sketch((FULL, 52.0), (0.0, 0.0, 0.0, 0.0), label=label, language=language)
    for index, picture in enumerate(pictures):
        left = width * index
        plot.panel((left + 14.0, 11.0, FULL - left - width + 1.5, 8.5))
        low, _ = _panel(plot, picture)
        plot.note(plain(titles[index][shared:], 44 if across < 3 else 24), low, rise=3.0)
    plot.panel((14.0, 11.0, 1.5, 4.5))
    plot.legend(_legend(pictures[0], language))
    alt = said("{pictures:space}", pictures=tuple(_alt(picture, test) for picture in pictures))
    named = tuple(picture.title for picture in pictures)
    made = plot.finish(alt, said("{titles}. {sentence}", titles=named, sentence=pictures[0].sentence))
    series = _zoom(pictures, language) if pictures[0].key.startswith("history") else ""
    return Plot(made.svg, made.operators, made.width, made.height, made.alt, made.caption, series)


def _legend(picture: Picture, language: Language) -> list[tuple[str, Pen | Mark]]:
    names = [plain(language.spoken(curve.name), 34) for curve in picture.curves]
    return list(zip(names, _looks(picture), strict=True))


def _looks(picture: Picture) -> list[Pen | Mark]:
    """How each curve is drawn: a line, or marks that differ among curves of one role."""
    found: list[Pen | Mark] = []
    seen: dict[str, int] = {}
    for curve in picture.curves:
        place = seen[curve.role] = seen.get(curve.role, -1) + 1
        if _stroked(picture, curve):
            found.append(PENS[curve.role])
        else:
            shape = MARKERS[place % len(MARKERS)]
            found.append(Mark(shape, COLOURS[curve.role], 2.8, hollow=curve.role == "before"))
    return found


def _stroked(picture: Picture, curve: Curve) -> bool:
    """Whether a curve is a line: a limit, or what a model gives beside measured points."""
    measured = any(one.role == "measured" for one in picture.curves)
    return picture.joined or curve.role == "limit" or (measured and curve.role != "measured")


def _panel(plot: Sketch, picture: Picture) -> tuple[float, float]:
    """Axes and curves; what of x is seen."""
    x_factor, x_unit = scale(_largest(c.x for c in picture.curves), picture.x_unit)
    y_factor, y_unit = scale(_largest(c.y for c in picture.curves), picture.y_unit)
    logs = (picture.logarithmic != "no", picture.logarithmic == "both")
    xs = [[_placed(x / x_factor, log=logs[0]) for x in c.x] for c in picture.curves]
    ys = [[_placed(y / y_factor, log=logs[1]) for y in c.y] for c in picture.curves]
    halves = [[u / y_factor for u in c.u] for c in picture.curves]
    tops = [y + sign * u for y_row, u_row in zip(ys, halves, strict=True)
            for y, u in zip(y_row, u_row, strict=False) for sign in (1, -1)]  # fmt: skip
    seen = _range([x for row in xs for x in row])
    plot.window(seen, _range([*tops, *(y for row in ys for y in row)]))
    if not logs[1]:
        plot.level(0.0, _ZERO)
    if picture.key.startswith("history"):
        for level in (-2.0, 2.0):
            plot.level(level, PENS["limit"])
    for curve, look, x, y, half in zip(picture.curves, _looks(picture), xs, ys, halves, strict=True):
        if isinstance(look, Mark):
            if picture.key.startswith(("force", "missing")):
                plot.line(x, y, Pen(stroke=look.colour, width=0.5, dash=(2.0, 1.5) if curve.role == "after" else ()))
            if curve.u:
                plot.errors(x, y, half, Pen(stroke=look.colour, width=0.5))
            plot.dots(x, y, look)
        else:
            plot.line(x, y, look)
    _axes(plot, picture, (x_unit, y_unit), logs)
    return seen


def _axes(plot: Sketch, picture: Picture, units: tuple[str, str], logs: tuple[bool, bool]) -> None:
    x, y = (said("{quantity} / {unit}", quantity=name, unit=unit) if unit and unit != "1" else name
            for name, unit in zip((picture.x, picture.y), units, strict=True))  # fmt: skip
    if logs[0]:
        plot.x_decades(x)
    else:
        runs = max((len(c.x) for c in picture.curves), default=1)
        plot.x_axis(x, runs if picture.key == "delay" else 5)
    if logs[1]:
        plot.y_decades(y)
    else:
        plot.y_axis(y, 5)


def _placed(value: float, *, log: bool) -> float:
    return (log10(value) if value > 0 else nan) if log else value


def _range(values: Sequence[float]) -> tuple[float, float]:
    known = [value for value in values if isfinite(value)]
    low, high = min(known, default=0.0), max(known, default=1.0)
    margin = 0.06 * (high - low) or 0.5 * (abs(high) or 1.0)
    return low - margin, high + margin


def _largest(rows: Iterator[Sequence[float]] | Sequence[Sequence[float]]) -> float:
    return max((abs(value) for row in rows for value in row if isfinite(value)), default=0.0)


def _caption(picture: Picture) -> str:
    plainly, barred = "{title}. {sentence}", "{title}. {sentence} Bars: one standard uncertainty."
    bars = any(curve.u for curve in picture.curves)
    return said(barred if bars else plainly, title=picture.title, sentence=picture.sentence)


def _alt(picture: Picture, test: str) -> str:
    curves = tuple(_described(curve, picture) for curve in picture.curves if curve.role != "limit" and curve.y)
    text = "{test}. {title}: {curves}. {sentence}"
    return said(text, test=test, title=picture.title, curves=curves, sentence=picture.sentence)


def _described(curve: Curve, picture: Picture) -> str:
    """Smallest and largest value of a curve, and where."""
    factor, unit = scale(_largest([curve.y]), picture.y_unit)
    x_factor, x_unit = scale(_largest([curve.x]), picture.x_unit)
    ends = []
    for pick in (min, max):
        y, x = pick(zip(curve.y, curve.x, strict=True))
        ends.append((f"{number(y / factor)} {unit}".rstrip(), f"{number(x / x_factor)} {x_unit}".rstrip()))
    (low, at_low), (high, at_high) = ends
    return said(
        "{curve} from {low:figures} at {at_low:figures} to {high:figures} at {at_high:figures}", curve=curve.name,
        low=low, at_low=at_low, high=high, at_high=at_high,
    )  # fmt: skip


def _zoom(pictures: Sequence[Picture], language: Language) -> str:
    """Residuals over time for the zoomable plot."""
    panels = [
        {"title": title.partition(", ")[2] or title,
         "curves": [{"name": language.spoken(c.name), "role": c.role, "x": list(c.x), "y": list(c.y)}
                    for c in picture.curves]}
        for picture, title in ((one, language.spoken(one.title)) for one in pictures)
    ]  # fmt: skip
    return json.dumps({"phases": [], "panels": panels}, ensure_ascii=False)
