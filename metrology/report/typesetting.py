"""Symbols, words about equations and sentences set as HTML: italics, indices, and values that stay on one line."""

from __future__ import annotations

import re
from typing import Any

from metrology.language import display, wording
from metrology.report import equations
from metrology.report.fonts import visible


def symbol(quantity: str) -> Any:
    """Symbol of a quantity in italics, with its index: ω_n → <i>ω</i><sub>n</sub>."""
    from markupsafe import Markup, escape

    stem, _, index = visible(display.symbol(quantity)).partition("_")
    tail = Markup("<sub>{}</sub>").format(escape(index)) if index else Markup("")
    return Markup("<i>{}</i>{}").format(escape(stem), tail)


def worded(text: str) -> Any:
    """Words about an equation with its symbols set: e = x − x_t → <i>e</i> = <i>x</i> − <i>x</i><sub>t</sub>."""
    from markupsafe import Markup, escape

    text, pieces, last = visible(text), [], 0
    for found in equations.SYMBOL.finditer(text):
        pieces += [escape(text[last : found.start()]), _italic(found)]
        last = found.end()
    return Markup("").join([*pieces, escape(text[last:])])


def _italic(found: re.Match[str]) -> Any:
    """Markup of a symbol; two letters without an index may be a word, unless the first is a delta."""
    from markupsafe import Markup, escape

    stem, index = found["stem"], found["index"]
    if not stem or (stem.isalpha() and len(stem) > 1 and stem[0] not in "δΔ" and not index):
        return escape(found[0])
    tail = Markup("<sub>{}</sub>").format(index) if index else Markup("")
    return Markup("<i>{}</i>{}").format(stem, tail)


_NUMBER = r"\d+(?:[.,]\d+)*(?:×10[⁻⁰¹²³⁴-⁹]+)?"
_SHORT = r"[^\W\d_](?:[^\W\d_]|⁻){0,2}"
_UNIT = rf"(?:[%‰]|°C|[^\W\d_][\w·⁻]*/[^\W\d_][\w·]*|{_SHORT}(?:·{_SHORT})*(?!\w|[·.]\w))"
_SET = re.compile(
    r"(?<![\w.-])(?P<stem>u|E|F|R|ε|eps|ω|k|x|φ)_(?P<index>val|n|c|d|dyn|t|0|inf|∞|max|m|b)(?![\w.-]*\w)"
    rf"|(?P<whole>(?<![\d.,]){_NUMBER}(?: ± {_NUMBER})? {_UNIT})"
)
"""Symbols with an index that the sentences of methods and verdicts use, a name such as ``x_t.csv`` being none; a value,
with its u, and its unit: a line would break before it and after its stroke. So are a number and a short word."""


def sentence(text: str) -> Any:
    """A sentence with numbers as they are printed, and its symbols with an index set: u_val → <i>u</i><sub>val</sub>.

    A value stays on one line with its unit. For what is no part of an equation; `worded` sets more, and takes a word of
    two letters for a symbol.
    """
    from markupsafe import Markup, escape

    text, pieces, last = visible(wording.prose(text)), [], 0
    for found in _SET.finditer(text):
        piece = Markup('<span class="one">{}</span>').format(found["whole"]) if found["whole"] else symbol(found[0])
        pieces += [escape(text[last : found.start()]), piece]
        last = found.end()
    return Markup("").join([*pieces, escape(text[last:])])
