"""Pages of a report as a reader meets them: text, how far each is filled, what is numbered."""

from __future__ import annotations

import re
from dataclasses import replace
from io import BytesIO
from typing import Any

from pypdf import PdfReader

from metrology import report
from metrology.findings import Findings
from metrology.report import figures, html, pdf

MILLIMETRE = 72 / 25.4
TOP, BOTTOM = 297 - 18, 16
"""Upper and lower edge of what is printed, in mm from the lower edge of the sheet."""


def printed(findings: Findings, *parts: str) -> list[Any]:
    """Pages of the report with these parts."""
    released = replace(findings, campaign=replace(findings.campaign, parts=parts))
    return list(PdfReader(BytesIO(report.make(released)["report.pdf"])).pages)


def filled(page: Any) -> float:
    """Part of the height of a page down to its lowest text, footer aside."""
    heights: list[float] = []

    def visit(text: str, matrix: Any, place: Any, *_: Any) -> None:
        if text.strip():
            heights.append((matrix[1] * place[4] + matrix[3] * place[5] + matrix[5]) / MILLIMETRE)

    page.extract_text(visitor_text=visit)
    return (TOP - min((y for y in heights if BOTTOM < y < TOP), default=TOP)) / (TOP - BOTTOM)


def numbers(pages: list[Any], word: str) -> tuple[list[int], list[int]]:
    """Numbers of the captions of figures or tables in order, and those that the text cites elsewhere."""
    text = re.sub(r"\s+", " ", " ".join(page.extract_text() for page in pages))
    captions = [int(n) for n in re.findall(rf"\b{word} (\d+)\. ", text) if n]
    every = [int(n) for n in re.findall(rf"\b{word} (\d+)\b", text)]
    cited = [n for n in set(every) if every.count(n) > captions.count(n)]
    return list(dict.fromkeys(captions)), sorted(cited)


COLUMN = 30
"""Characters of prose for which a column has room at least."""
PROSE = 60
"""Characters from which on the text of a cell is prose, unless it has an internal name, such as ``tape.reading``."""


def assert_whole_rows_and_wide_columns(findings: Findings) -> None:
    """No row of a table is split between pages, but heads that are repeated; no prose stands in a narrow column.

    No word is wider than its cell, which would stand on its neighbour or be broken.
    """
    from weasyprint.formatting_structure import boxes

    released = replace(findings, campaign=replace(findings.campaign, parts=("certificate", "annex", "quality")))
    document = pdf.laid_out(html.render(released, figures.draw(released)))
    rows: dict[Any, set[int]] = {}
    narrow: list[tuple[int, str]] = []
    over: list[tuple[int, str]] = []
    for number, sheet in enumerate(document.pages, 1):
        all_boxes = list(sheet._page_box.descendants())
        heads = {row.element for box in all_boxes if getattr(box, "is_header", False) for row in box.children}
        for box in all_boxes:
            if isinstance(box, boxes.TableRowBox) and box.element_tag == "tr" and box.element not in heads:
                rows.setdefault(box.element, set()).add(number)
            elif isinstance(box, boxes.TableBox):
                edge = sheet._page_box.content_box_x() + sheet._page_box.width
                over += [(number, "a table beyond the margin")] if box.position_x + box.width > edge + 1.33 else []
            elif isinstance(box, boxes.TableCellBox):
                texts = _texts(box)
                text = "".join(one.text for one in texts)
                is_prose = box.element_tag == "td" and len(text) >= PROSE and not re.search(r"\w\.\w", text)
                if is_prose and box.width < COLUMN * sum(one.width for one in texts) / len(text):
                    narrow.append((number, text))
                over += [(number, text) for _ in _outside(box)]
    assert rows
    assert [numbers for numbers in rows.values() if len(numbers) > 1] == []
    assert narrow == []
    assert over == []


def _texts(cell: Any) -> list[Any]:
    """Boxes of the text of a cell."""
    from weasyprint.formatting_structure import boxes

    return [box for box in cell.descendants() if isinstance(box, boxes.TextBox) and box.text.strip()]


def _outside(cell: Any) -> list[str]:
    """Texts of a cell that begin before it or end behind it, by more than a point: three are between two columns."""
    left, right = cell.content_box_x() - 1.33, cell.content_box_x() + cell.width + 1.33
    return [one.text for one in _texts(cell) if one.position_x < left or one.position_x + one.width > right]


def assert_short(findings: Findings, most: int) -> None:
    """The certificate has two pages at most, with its annex so many; pages are full but for the last of a part."""
    both, certificate = printed(findings, "certificate", "annex"), len(printed(findings, "certificate"))
    assert certificate <= 2
    assert len(both) <= most
    assert all(filled(page) >= 0.6 for at, page in enumerate(both[:-1], 1) if at != certificate)
    for word in ("Figure", "Table"):
        captions, cited = numbers(both, word)
        assert captions == cited == list(range(1, len(captions) + 1))
    assert_whole_rows_and_wide_columns(findings)
