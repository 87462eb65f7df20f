"""Style sheets that a report adds to its own: words at the edges of a page, DRAFT across it, the laboratory's brand."""

from __future__ import annotations

from typing import TYPE_CHECKING

from metrology import checklist
from metrology.report import watermark
from metrology.report.fonts import visible

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.language.catalogue import Language


def running(language: Language) -> list[tuple[str, str]]:
    """Sheet with the words at the head and the foot of each page, where they are not English."""
    if language.code == "en":
        return []
    words = {
        "top-right": _content(language, "Test report {number}"),
        "bottom-left": _content(language, "The results relate only to the items tested."),
        "bottom-right": _content(language, "Page {page} of {pages}"),
    }
    boxes = " ".join(f"@{place} {{ content: {text} }}" for place, text in words.items())
    draft = _content(language, "DRAFT of test report {number}")
    return [(f"@page {{ {boxes} }}\n@page draft {{ @top-right {{ content: {draft} }} }}", "print")]


def across(findings: Findings, language: Language) -> list[tuple[str, str]]:
    """Sheet with the word across the pages of a draft."""
    if not checklist.lacking(findings):
        return []
    picture = watermark.address(language.say("DRAFT"))
    return [(f"@page draft {{ background: url({picture}) center / 100% 100% no-repeat }}", "print")]


_COUNTED = {"number": "string(number)", "page": "counter(page)", "pages": "counter(pages)"}


def _content(language: Language, message: str) -> str:
    """A message as the content of a box at the edge of a page."""
    marked = language.say(message, **{name: f"\0{name}\0" for name in _COUNTED})
    pieces = [_COUNTED[piece] if at % 2 else _quoted(piece) for at, piece in enumerate(marked.split("\0"))]
    return " ".join(pieces)


def _quoted(text: str) -> str:
    """A text as a string of a style sheet."""
    return '"' + "".join(f"\\{ord(letter):06x}" for letter in text) + '"'


def branded(findings: Findings) -> list[tuple[str, str]]:
    """Sheets with the laboratory's colour, on light pages and on paper, and with its words at the foot of a page."""
    brand, sheets = findings.campaign.brand, []
    if brand is not None and brand.colour:
        heads = f"h1, h2, h3, h4, h5, .laboratory strong {{ color: {brand.colour}; }}"
        text = f"{heads}\nh2, .conclusion {{ border-color: {brand.colour}; }}"
        sheets = [(text, "print"), (text, "screen and (prefers-color-scheme: light)")]
    if brand is not None and brand.footer:
        words = _quoted(visible(brand.footer))
        boxes = f"@bottom-center {{ content: {words}; width: 38%; {_FOOT} }} @bottom-left {{ width: 42%; }}"
        sheets.append((f"@page {{ {boxes} @bottom-right {{ width: 20%; }} }}", "print"))
    return sheets


_FOOT = "font: 6.8pt Report, 'DejaVu Sans'; color: #59616b; text-align: center"
