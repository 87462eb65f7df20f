"""What stands across every page of a draft: a word in the reader's language, as outlines, which need no font."""

from __future__ import annotations

from math import hypot
from urllib.parse import quote

from metrology.report.figures.shapes import advance, lettering

WIDTH, HEIGHT = 210.0, 297.0
"""Of a page, in mm."""
_COLOUR = "#eceef1"
_LENGTH, _TALLEST = 0.62, 62.0
"""Length of the word as a part of the diagonal, and the most that its letters may be high, in mm."""
_CAPITAL = 0.73
"""Height of a capital over the size of its font."""


def address(word: str) -> str:
    """A picture of the word along the diagonal of a page, as a ``data:`` address.

    Examples
    --------
    >>> address("DRAFT")[:20]
    'data:image/svg+xml,%'
    """
    long = sum(advance(letter, bold=True) for letter in word)
    size = min(_LENGTH * hypot(WIDTH, HEIGHT) / long, _TALLEST / _CAPITAL)
    glyphs, x = [], 0.0
    for letter in word:
        glyphs.append(f'<path transform="translate({x:.3f} 0)" d="{lettering(letter)}"/>')
        x += advance(letter, bold=True)
    middle = f"translate({WIDTH / 2:g} {HEIGHT / 2:g}) rotate(-54.7)"
    place = f"{middle} scale({size:.3f}) translate({-long / 2:.3f} {_CAPITAL / 2})"
    size_of_page = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}"'
    drawn = f'<g transform="{place}" fill="{_COLOUR}">{"".join(glyphs)}</g>'
    return "data:image/svg+xml," + quote(f'<svg xmlns="http://www.w3.org/2000/svg" {size_of_page}>{drawn}</svg>')
