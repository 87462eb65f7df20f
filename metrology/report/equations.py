"""Equations as campaigns and methods write them, ``c = 2 zeta sqrt(k m)``, drawn as outlines (MathML fails in PDF)."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from metrology.report.figures.style import Plot

_RAISED, _LOWERED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "₀₁₂₃₄₅₆₇₈₉"
_ACCENTS = {"\N{COMBINING MACRON}": "bar", "\N{COMBINING CIRCUMFLEX ACCENT}": "hat"}
_LETTER, _REST = rf"[^\W\d{_RAISED}{_LOWERED}]", rf"[^\W{_RAISED}{_LOWERED}]|[{''.join(_ACCENTS)}]"
_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)|(?P<sum>[Σ∑](?:_\w)?)"
    rf"|(?P<name>{_LETTER}[\w.]*(?:-\w+)*\.\w+|{_LETTER}(?:{_REST})*[{_LOWERED}]*[′″]*)|(?P<power>[{_RAISED}]+)"
    r"|(?P<mark>\*\*|<=|>=|[-+−*·×/^(),=≈<>≤≥√∞|±]))"
)
_REMARK = re.compile(r",\s+(?=(?:over|for|with|where|at|from|while|when|if)\b)")
"""Where an equation ends and words about it begin."""
_WORDS = re.compile(r"(?<![\w.])([a-z]{2,}) (?=([a-z]{2,})(?![\w.(]))")
"""Two words in a row: no product of symbols."""
SYMBOL = re.compile(
    rf"\d[\d.e+−-]* [^\s,;]+|½|\b[aA] (?=[^\W\d_]{{2}})"
    rf"|(?<![^\W{_RAISED}])(?P<stem>[^\W\d_{_RAISED}{_LOWERED}]{{1,2}}[{_LOWERED}]*)"
    rf"(?:_(?P<index>[^\W_{_RAISED}]+))?(?![^\W{_RAISED}])"
)
"""A symbol among words, with its index; a number with its unit, a half and an article match without a `stem`."""
_GREEK = set(
    "alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau phi chi psi omega "  # noqa: SIM905
    "Gamma Delta Theta Lambda Sigma Phi Psi Omega".split()
)
_FUNCTIONS = {"sin", "cos", "tan", "exp", "ln", "log", "min", "max", "log10", "asin", "acos", "atan", "abs", "mean"}
_DIGITS = str.maketrans(_RAISED + _LOWERED, "-01234567890123456789")
_RELATIONS = {"=": "=", "≈": r"\approx", "<": "<", ">": ">", "≤": r"\leq", "≥": r"\geq", "<=": r"\leq", ">=": r"\geq"}
_LONGEST, _DEEPEST = 400, 30


@lru_cache(maxsize=512)
def draw(text: str, size: float = 9.0) -> Plot | None:
    """The equation as one outline; None for what is not an equation, or is put in words, and stays text."""
    if in_words(text):
        return None
    try:
        return _outline(text, mathtext(text), size)
    except ValueError:
        return None


def in_words(text: str) -> bool:
    """Whether an equation is put in words: what it holds is no product of symbols."""
    return any(not {first, second} & (_GREEK | _FUNCTIONS) for first, second in _WORDS.findall(text))


def parted(text: str) -> tuple[str, str]:
    """The equation itself, and the words that follow it: ``("x = a_i", "for i = 0, 1, …")``."""
    equation, *words = _REMARK.split(text, maxsplit=1)
    return equation, words[0] if words else ""


def mathtext(text: str) -> str:
    r"""TeX (matplotlib's subset) of an equation written plainly.

    Examples
    --------
    >>> mathtext("E = k * L / (w * t)")
    'E=\\dfrac{k\\,L}{w\\,t}'
    >>> mathtext("m = Σ w_i x_i / Σ w_i")
    'm=\\dfrac{\\sum w_{i}\\,x_{i}}{\\sum w_{i}}'

    Raises
    ------
    ValueError
        Where the text is not an equation.
    """
    if len(text) > _LONGEST:
        raise ValueError("too long for an equation")
    reader = _Reader(_pieces(text))
    tex = reader.relation()
    if reader.at < len(reader.pieces):
        raise ValueError(f"not an equation from {reader.pieces[reader.at][1]!r} on")
    return tex


def _outline(text: str, tex: str, size: float) -> Plot:
    import matplotlib as mpl
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    from metrology.report.figures.shapes import Pen, Shape, Sheet, operators, outline, svg
    from metrology.report.figures.style import INK, Plot

    with mpl.rc_context({"mathtext.fontset": "dejavusans", "text.hinting": "none", "text.parse_math": True}):
        path = TextPath((0, 0), f"${tex}$", size=size, prop=FontProperties(family="DejaVu Sans"))
    low, high = path.vertices.min(axis=0), path.vertices.max(axis=0)
    width, height = (high - low + 1.0).tolist()
    drawn = Sheet(width, height)
    drawn.shapes.append(Shape(Pen(fill=INK), outline(path.vertices - low + 0.5, path.codes)))
    return Plot(svg(drawn), operators(drawn), drawn.width, drawn.height, alt=text)


def _pieces(text: str) -> list[tuple[str, str]]:
    pieces, at = [], 0
    text = text.strip()
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None or match.end() == at:
            raise ValueError(f"not an equation from {text[at : at + 10]!r} on")
        pieces.append((str(match.lastgroup), match[str(match.lastgroup)]))
        at = match.end()
    if not pieces:
        raise ValueError("nothing to draw")
    return pieces


class _Reader:
    """Precedence: relation, sum, product (also by mere juxtaposition), power, atom; each method returns TeX."""

    def __init__(self, pieces: list[tuple[str, str]]) -> None:
        self.pieces, self.at, self.depth = pieces, 0, 0

    def peek(self) -> tuple[str, str]:
        return self.pieces[self.at] if self.at < len(self.pieces) else ("end", "")

    def take(self, *marks: str) -> str:
        kind, piece = self.peek()
        if kind == "mark" and piece in marks:
            self.at += 1
            return piece
        return ""

    def relation(self) -> str:
        tex = self.sum()
        while mark := self.take(*_RELATIONS):
            tex += _RELATIONS[mark] + self.sum()
        return tex

    def sum(self) -> str:
        tex = ""
        mark = self.take("+", "-", "−", "±")
        while True:
            tex += {"−": "-", "±": r"\pm "}.get(mark, mark) + self.product()
            mark = self.take("+", "-", "−", "±")
            if not mark:
                return tex

    def product(self, *, summed: bool = False) -> str:
        """A product; one under a sum sign ends at a fraction bar, which divides the whole sum."""
        tex = self.power()[0]
        while True:
            if self.take("*", "·", "×"):
                tex += r"\," + self.power()[0]
            elif not summed and self.take("/"):
                tex = rf"\dfrac{{{_bare(tex)}}}{{{_bare(self.power()[0])}}}"
            elif self.peek()[0] in {"number", "name", "sum"} or self.peek()[1] in {"(", "√"}:
                tex += r"\," + self.power()[0]
            else:
                return tex

    def power(self) -> tuple[str, bool]:
        base = self.atom()
        kind, piece = self.peek()
        if kind == "power":
            self.at += 1
            return f"{{{base}}}^{{{piece.translate(_DIGITS)}}}", True
        if self.take("^", "**"):
            sign = "-" if self.take("-", "−") else ""
            return f"{{{base}}}^{{{sign}{_bare(self.power()[0])}}}", True
        return base, False

    def atom(self) -> str:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise ValueError("too deep for an equation")
        tex = self._atom()
        self.depth -= 1
        return tex

    def _atom(self) -> str:
        kind, piece = self.peek()
        self.at += 1
        if kind == "number":
            return piece
        if kind == "sum" or (kind == "name" and piece == "sum" and self.peek()[1] == "("):
            return self._summation(piece)
        if piece == "√" or (kind == "name" and piece == "sqrt" and self.peek()[1] == "("):
            return rf"\sqrt{{{_bare(self.atom())}}}"
        if kind == "name" and piece in _FUNCTIONS and self.peek()[1] == "(":
            return rf"\mathrm{{{piece}}}{self.atom()}"
        if kind == "name":
            return _name(piece)
        if piece == "(":
            inner = self._list()
            return rf"\left({inner}\right)"
        if piece == "∞":
            return r"\infty"
        raise ValueError(f"{piece!r} where a name or a number is due")

    def _summation(self, piece: str) -> str:
        index = piece.partition("_")[2]
        sign = r"\sum" + (f"_{{{index}}}" if index and piece[0] in "Σ∑" else "")
        if piece != "sum":
            return f"{sign} {self.product(summed=True)}"
        self.at += 1
        start, inner = self.at, self.product()
        if self.take(")"):
            return f"{sign} {inner}"
        self.at = start
        return rf"{sign} \left({self._list()}\right)"

    def _list(self) -> str:
        parts = [self.sum()]
        while self.take(","):
            parts.append(self.sum())
        if not self.take(")"):
            raise ValueError("a parenthesis is not closed")
        return r",\,".join(parts)


def _bare(tex: str) -> str:
    """Without the parentheses that a fraction bar or a root makes needless."""
    if not (tex.startswith(r"\left(") and tex.endswith(r"\right)")):
        return tex
    inner, depth = tex[len(r"\left(") : -len(r"\right)")], 0
    for part in re.findall(r"\\left\(|\\right\)", inner):
        depth += 1 if part == r"\left(" else -1
        if depth < 0:
            return tex
    return inner


def _name(name: str) -> str:
    stem, *indices = name.rstrip("′″").split("_")
    bare = stem.rstrip(_LOWERED)
    indices = [stem[len(bare) :].translate(_DIGITS), *indices]
    primes = "".join("'" if mark == "′" else "''" for mark in name[len(name.rstrip("′″")) :])
    tex = _word("".join(letter for letter in bare if letter not in _ACCENTS))
    for accent in filter(None, map(_ACCENTS.get, bare)):
        tex = rf"\{accent}{{{tex}}}"
    index = ",".join(_word(i) for i in indices if i)
    return tex + (f"_{{{index}}}" if index else "") + primes + (" " if tex.startswith("\\") and not index else "")


def _word(text: str) -> str:
    if text in _GREEK:
        return rf"\{text}"
    return text if len(text) == 1 else rf"\mathrm{{{text}}}"
