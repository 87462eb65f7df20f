"""Printed numbers in a column: how they are padded to stand below each other, and how wide they are."""

from __future__ import annotations


def aligned(texts: list[str]) -> list[str]:
    """Texts of one column, padded on the right so that decimal points stand below each other when set flush right.

    A number with a power of ten stands as it is.
    """
    tails = [_tail(text) for text in texts]
    widest = max((len(tail) for text, tail in zip(texts, tails, strict=True) if "×" not in text), default=0)
    return [text if "×" in text else text + _blank(widest, tail) for text, tail in zip(texts, tails, strict=True)]


_EM = {".": 0.32, ",": 0.32, "\N{PUNCTUATION SPACE}": 0.32, " ": 0.32, "×": 0.84, "−": 0.84, "…": 1.0} | dict.fromkeys(
    "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", 0.43
)
"""Widths of characters in the font of the report; of a figure 0.64, as of most letters."""


def width(text: str) -> float:
    """Width of a printed number in em, to choose a column by."""
    return sum(_EM.get(character, 0.64) for character in text)


def _tail(text: str) -> str:
    return "." + text.partition(".")[2] if "." in text else ""


def _blank(widest: int, tail: str) -> str:
    if not widest:
        return ""
    figures = widest - max(len(tail), 1)
    return ("\N{PUNCTUATION SPACE}" if not tail else "") + "\N{FIGURE SPACE}" * figures
