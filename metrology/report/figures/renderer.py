"""matplotlib figures as few plain shapes, written as SVG for the page and as PDF operators for the print.

matplotlib's own SVG has an element for each glyph and marker, and WeasyPrint parses every one: three quarters
of the time of a report. Here marks of a line are one path, text is text in the SVG (in the page's font) and outlines
in the PDF, and the PDF takes its operators ready-made.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from html import escape
from math import cos, radians, sin
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backend_bases import RendererBase
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from metrology.report import fonts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_CIRCLE = np.shape(Path.unit_circle().vertices)[0]
_LARGEST_MARK = 20.0
"""In points; what is larger is an area that matplotlib draws as a mark, such as the band of `fill_between`."""
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


class ShapeRenderer(RendererBase):
    """Collects what matplotlib draws; neighbours that are painted alike become one shape."""

    def __init__(self, width: float, height: float) -> None:
        super().__init__()
        self.width, self.height = width, height
        self.shapes: list[Shape | Words] = []

    def get_canvas_width_height(self) -> tuple[float, float]:
        """Size in points."""
        return self.width, self.height

    def flipy(self) -> bool:
        """Y runs upwards."""
        return False

    def points_to_pixels(self, points: Any) -> Any:
        """One pixel a point."""
        return points

    def draw_path(self, gc: Any, path: Any, transform: Any, rgbFace: Any = None) -> None:
        """Take a path, cut to its clip rectangle."""
        pen = _pen(gc, rgbFace)
        if pen.fill or pen.stroke:
            self._shape(pen).steps += _steps(_clipped(path, transform, gc.get_clip_rectangle(), filled=bool(pen.fill)))

    def draw_markers(
        self, gc: Any, marker_path: Any, marker_trans: Any, path: Any, trans: Any, rgbFace: Any = None
    ) -> None:
        """Take all marks of a line as one shape; filled circles as dots of a round pen."""
        pen = _pen(gc, rgbFace)
        mark = marker_trans.transform_path(marker_path)
        if np.ptp(mark.vertices, axis=0).max(initial=0.0) > _LARGEST_MARK:
            for x, y in trans.transform(path.vertices):
                self.draw_path(gc, marker_path, marker_trans + Affine2D().translate(x, y), rgbFace)
            return
        places = _inside(trans.transform(path.vertices), gc.get_clip_rectangle())
        if pen.fill and len(mark.vertices) == _CIRCLE:
            dot = Pen(stroke=pen.fill, width=float(np.ptp(mark.vertices[:, 0])) + pen.width, cap="round")
            self._shape(dot).steps += [(letter, (x, y)) for x, y in places for letter in "ML"]
            return
        steps = _steps(mark)
        for x, y in places:
            self._shape(pen).steps += [(letter, _moved(points, x, y)) for letter, points in steps]

    def draw_text(
        self,
        gc: Any,
        x: float,
        y: float,
        s: str,
        prop: Any,
        angle: float,
        ismath: Any = False,  # noqa: ARG002
        mtext: Any = None,  # noqa: ARG002
    ) -> None:
        """Take a line of text."""
        bold = prop.get_weight() in {"bold", 700}
        self.shapes.append(Words(s, x, y, angle, prop.get_size_in_points(), bold, _colour(gc.get_rgb())))

    def fill(self, path: Any, transform: Any, colour: str) -> None:
        """Take a path filled with one colour."""
        self._shape(Pen(fill=colour)).steps += _steps(transform.transform_path(path))

    def _shape(self, pen: Pen) -> Shape:
        last = self.shapes[-1] if self.shapes else None
        if isinstance(last, Shape) and last.pen == pen:
            return last
        shape = Shape(pen)
        self.shapes.append(shape)
        return shape


def render(figure: Figure) -> ShapeRenderer:
    """Everything that a figure draws."""
    figure.set_dpi(72)
    width, height = figure.get_size_inches() * 72
    renderer = ShapeRenderer(float(width), float(height))
    figure.draw(renderer)
    return renderer


def svg(drawn: ShapeRenderer) -> str:
    """The shapes as one `svg` element; text in the font of the page."""
    parts = [_svg_words(s, drawn.height) if isinstance(s, Words) else _svg_path(s, drawn.height) for s in drawn.shapes]
    size = f'viewBox="0 0 {drawn.width:.2f} {drawn.height:.2f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} fill="none" stroke-linejoin="round">{"".join(parts)}</svg>'


def operators(drawn: ShapeRenderer) -> bytes:
    """The shapes as operators of a PDF content stream, origin at the lower left, in points."""
    return "\n".join(_pdf_words(s) if isinstance(s, Words) else _pdf_path(s) for s in drawn.shapes).encode("ascii")


def _pen(gc: Any, face: Any) -> Pen:
    filled = face is not None and (len(face) < 4 or face[3] > 0)
    width = float(gc.get_linewidth())
    if not width or gc.get_rgb()[3] == 0:
        return Pen(fill=_colour(face) if filled else "")
    offset, dash = gc.get_dashes()
    return Pen(
        _colour(face) if filled else "",
        _colour(gc.get_rgb()),
        round(width, 2),
        tuple(round(float(d), 2) for d in dash or ()),
        float(offset or 0.0),
        gc.get_capstyle(),
        gc.get_joinstyle(),
    )


def _colour(rgb: Any) -> str:
    return "#" + "".join(f"{round(255 * float(part)):02x}" for part in rgb[:3])


def _clipped(path: Any, transform: Any, clip: Any, *, filled: bool) -> Any:
    if clip is None:
        return transform.transform_path(path)
    if not filled:
        return path.cleaned(
            transform, clip=(clip.x0 - 1, clip.y0 - 1, clip.x1 + 1, clip.y1 + 1), simplify=None, curves=True
        )
    moved = transform.transform_path(path)
    box = moved.get_extents()
    inside = box.x0 >= clip.x0 - 1 and box.x1 <= clip.x1 + 1 and box.y0 >= clip.y0 - 1 and box.y1 <= clip.y1 + 1
    return moved if inside else moved.clip_to_bbox(clip)


def _inside(places: Any, clip: Any) -> Any:
    places = places[np.isfinite(places).all(axis=1)]
    if clip is None:
        return places.tolist()
    x, y = places[:, 0], places[:, 1]
    return places[(x >= clip.x0 - 1) & (x <= clip.x1 + 1) & (y >= clip.y0 - 1) & (y <= clip.y1 + 1)].tolist()


_LETTERS = {1: "M", 2: "L", 3: "Q", 4: "C"}


def _steps(path: Any) -> list[tuple[str, tuple[float, ...]]]:
    """Steps of a path; matplotlib gives Bézier codes once a point."""
    vertices, codes = path.vertices.tolist(), path.codes
    if codes is None:
        return [("L" if i else "M", (x, y)) for i, (x, y) in enumerate(vertices)]
    steps: list[tuple[str, tuple[float, ...]]] = []
    at = 0
    while at < len(vertices):
        code = int(codes[at])
        if code == Path.CLOSEPOLY:
            steps.append(("Z", ()))
        elif code in _LETTERS:
            count = max(code - 1, 1)
            steps.append((_LETTERS[code], tuple(c for point in vertices[at : at + count] for c in point)))
            at += count - 1
        at += 1
    return steps


def _moved(points: tuple[float, ...], x: float, y: float) -> tuple[float, ...]:
    return tuple(c + (y if i % 2 else x) for i, c in enumerate(points))


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
    turn, size = radians(words.angle), words.size
    a, b = size * cos(turn), size * sin(turn)
    glyphs = "".join(
        outline + f"1 0 0 1 {advance:.4f} 0 cm " for outline, advance in (_glyph(c, words.bold) for c in words.text)
    )
    return f"q {_rgb(words.colour)} rg {a:.4f} {b:.4f} {-b:.4f} {a:.4f} {words.x:.2f} {words.y:.2f} cm {glyphs}Q"


@lru_cache(maxsize=2048)
def _glyph(character: str, bold: bool) -> tuple[str, float]:
    """Outline of a character in units of its size, and how far it advances."""
    from matplotlib.ft2font import LoadFlags

    font = _font(bold)
    glyph = font.load_char(ord(character), flags=LoadFlags.NO_HINTING)
    vertices, codes = font.get_path()
    outline = pdf_steps(_steps(Path(vertices / 100.0, codes)), "%.3f") if len(vertices) else ""
    return (outline + "f " if outline else ""), glyph.linearHoriAdvance / 65536 / 100.0


def advance(character: str, *, bold: bool = False) -> float:
    """How far a character advances, in units of its size."""
    return _glyph(character, bold)[1]


@lru_cache(maxsize=2)
def _font(bold: bool) -> Any:
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(fonts.folder() / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")))
    font.set_size(100.0, 72)
    return font
