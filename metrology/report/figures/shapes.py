"""Plots as few plain shapes, written as SVG for the page and as PDF operators for the print.

Text is text in the SVG, in the font of the page, and outlines in the PDF, which takes its operators ready-made: parsing
an SVG with an element for each glyph and mark would be three quarters of the time of a report.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from html import escape
from math import cos, radians, sin
from typing import Any, assert_never

from metrology.report import fonts

_LETTERS, _CLOSE = {1: "M", 2: "L", 3: "Q", 4: "C"}, 79
_EM = 1000
"""Units of a glyph's outline to its size: whole numbers are short."""
_CAPS, _JOINS = {"butt": 0, "round": 1, "projecting": 2}, {"miter": 0, "round": 1, "bevel": 2}


@dataclass(frozen=True)
class Pen:
    """How a shape is painted: colours as #rrggbb or "", lengths in points."""

    fill: str = ""
    stroke: str = ""
    width: float = 0.0
    dash: tuple[float, ...] = ()
    offset: float = 0.0
    cap: str = "butt"
    join: str = "round"


@dataclass
class Shape:
    """Steps of one path: (letter, coordinates in points, y upwards)."""

    pen: Pen
    steps: list[tuple[str, tuple[float, ...]]] = field(default_factory=list)


@dataclass(frozen=True)
class Words:
    """A line of text from (x, y) on, turned by `angle` degrees."""

    text: str
    x: float
    y: float
    angle: float
    size: float
    bold: bool
    colour: str


class Sheet:
    """Shapes and words on a sheet of so many points, y upwards."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self.shapes: list[Shape | Words] = []


def outline(vertices: Any, codes: Any) -> list[tuple[str, tuple[float, ...]]]:
    """Steps of an outline as matplotlib's fonts give it: a code for each point, Bézier codes once a point."""
    points = vertices.tolist()
    steps: list[tuple[str, tuple[float, ...]]] = []
    at = 0
    while at < len(points):
        code = int(codes[at])
        if code == _CLOSE:
            steps.append(("Z", ()))
        elif code in _LETTERS:
            count = max(code - 1, 1)
            steps.append((_LETTERS[code], tuple(c for point in points[at : at + count] for c in point)))
            at += count - 1
        at += 1
    return steps


def svg(drawn: Sheet) -> str:
    """The shapes as one `svg` element; text in the font of the page."""
    parts = [_svg(shape, drawn.height) for shape in drawn.shapes]
    size = f'viewBox="0 0 {drawn.width:.2f} {drawn.height:.2f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} fill="none" stroke-linejoin="round">{"".join(parts)}</svg>'


def operators(drawn: Sheet) -> bytes:
    """The shapes as operators of a PDF content stream, origin at the lower left, in points."""
    return "\n".join(_pdf(shape) for shape in drawn.shapes).encode("ascii")


def _svg(shape: Shape | Words, height: float) -> str:
    match shape:
        case Words():
            return _svg_words(shape, height)
        case Shape():
            return _svg_path(shape, height)
        case _:
            assert_never(shape)


def _pdf(shape: Shape | Words) -> str:
    match shape:
        case Words():
            return _pdf_words(shape)
        case Shape():
            return _pdf_path(shape)
        case _:
            assert_never(shape)


def _svg_path(shape: Shape, height: float) -> str:
    d = "".join(
        letter + " ".join(f"{height - c if i % 2 else c:.2f}" for i, c in enumerate(points))
        for letter, points in shape.steps
    )
    pen = shape.pen
    look = f' fill="{pen.fill}"' if pen.fill else ""
    if pen.stroke:
        look += f' stroke="{pen.stroke}" stroke-width="{pen.width:g}"'
        look += f' stroke-linecap="{"square" if pen.cap == "projecting" else pen.cap}"' if pen.cap != "butt" else ""
        look += f' stroke-dasharray="{" ".join(f"{d:g}" for d in pen.dash)}"' if pen.dash else ""
    return f'<path d="{d}"{look}/>'


def _svg_words(words: Words, height: float) -> str:
    x, y = words.x, height - words.y
    turn = f' transform="rotate({-words.angle:g} {x:.2f} {y:.2f})"' if words.angle else ""
    weight = ' font-weight="700"' if words.bold else ""
    place = f'x="{x:.2f}" y="{y:.2f}" font-size="{words.size:g}"'
    return f'<text {place}{weight} fill="{words.colour}"{turn}>{escape(words.text)}</text>'


def _rgb(colour: str) -> str:
    return " ".join(f"{int(colour[i : i + 2], 16) / 255:.3f}" for i in (1, 3, 5))


def _pdf_path(shape: Shape) -> str:
    pen = shape.pen
    look = f"{_rgb(pen.fill)} rg " if pen.fill else ""
    if pen.stroke:
        dash = " ".join(f"{d:g}" for d in pen.dash)
        look += (
            f"{_rgb(pen.stroke)} RG {pen.width:g} w {_CAPS[pen.cap]} J {_JOINS[pen.join]} j [{dash}] {pen.offset:g} d "
        )
    paint = {(True, True): "B", (True, False): "f", (False, True): "S"}[bool(pen.fill), bool(pen.stroke)]
    return look + pdf_steps(shape.steps, "%.2f") + paint


def pdf_steps(steps: list[tuple[str, tuple[float, ...]]], digits: str) -> str:
    """Path construction operators; quadratic curves become cubic ones, which alone PDF has."""
    out, x, y = [], 0.0, 0.0
    for letter, points in steps:
        if letter == "Z":
            out.append("h ")
            continue
        if letter == "Q":
            a, b, c, d = points
            points = (x + 2 / 3 * (a - x), y + 2 / 3 * (b - y), c + 2 / 3 * (a - c), d + 2 / 3 * (b - d), c, d)
        out.append(" ".join(digits % p for p in points) + {"M": " m ", "L": " l ", "C": " c ", "Q": " c "}[letter])
        x, y = points[-2:]
    return "".join(out)


def _pdf_words(words: Words) -> str:
    turn, size = radians(words.angle), words.size / _EM
    a, b = size * cos(turn), size * sin(turn)
    glyphs = "".join(
        drawn + f"1 0 0 1 {ahead:.0f} 0 cm " for drawn, ahead in (_glyph(c, words.bold) for c in words.text)
    )
    return f"q {_rgb(words.colour)} rg {a:.6f} {b:.6f} {-b:.6f} {a:.6f} {words.x:.2f} {words.y:.2f} cm {glyphs}Q"


@lru_cache(maxsize=2048)
def _glyph(character: str, bold: bool) -> tuple[str, float]:
    """Outline of a character and how far it advances, in thousandths of its size."""
    from matplotlib.ft2font import LoadFlags

    font = _font(bold)
    glyph = font.load_char(ord(character), flags=LoadFlags.NO_HINTING)
    vertices, codes = font.get_path()
    drawn = pdf_steps(outline(vertices * (_EM / 100.0), codes), "%.0f") if len(vertices) else ""
    return (drawn + "f " if drawn else ""), glyph.linearHoriAdvance / 65536 * (_EM / 100.0)


def advance(character: str, *, bold: bool = False) -> float:
    """How far a character advances, in units of its size."""
    return _glyph(character, bold)[1] / _EM


def lettering(character: str) -> str:
    """Outline of a bold character as the path of an SVG, in units of its size, y downwards."""
    from matplotlib.ft2font import LoadFlags

    font = _font(True)
    font.load_char(ord(character), flags=LoadFlags.NO_HINTING)
    vertices, codes = font.get_path()
    return "".join(
        letter + " ".join(f"{(-c if i % 2 else c) / 100.0:.3f}" for i, c in enumerate(points))
        for letter, points in outline(vertices, codes)
    )


@lru_cache(maxsize=2)
def _font(bold: bool) -> Any:
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(fonts.folder() / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")))
    font.set_size(100.0, 72)
    return font
