"""The look of a laboratory on page 1 and at the foot of every page, and a PDF that conforms with it."""

from __future__ import annotations

import re
from base64 import b64encode
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image as Picture
from pypdf import PdfReader

from metrology import report
from metrology.findings import Findings
from metrology.identification import Brand, Image
from scripts import check_pdf

LOGO = (
    b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 1"><linearGradient id="a"><stop offset="0" '
    b'stop-color="#123456"/><stop offset="1" stop-color="#abcdef" stop-opacity=".5"/></linearGradient>'
    b'<rect width="4" height="1" fill="url(#a)"/></svg>'
)
FOOTER = 'Words "with" \\ and } signs'


@pytest.fixture(scope="module")
def made(findings: Findings) -> dict[str, bytes]:
    stream = BytesIO()
    Picture.new("RGBA", (20, 20), (10, 20, 30, 120)).save(stream, "PNG")
    logo, mark = (Image(name, b64encode(raw).decode()) for name, raw in (("a.svg", LOGO), ("b.png", stream.getvalue())))
    brand = Brand(logo, "#7a1f3d", "Letters <b>", mark, "Body", "L-1", FOOTER)
    return report.make(replace(findings, campaign=replace(findings.campaign, brand=brand, parts=("certificate",))))


def test_law_page_1_has_logo_and_mark_in_words_and_every_page_the_footer(made: dict[str, bytes]) -> None:
    pages = [page.extract_text() for page in PdfReader(BytesIO(made["report.pdf"])).pages]
    assert all(FOOTER in text for text in pages)
    assert "Letters <b>" in pages[0]
    assert "L-1" in pages[0]
    html = made["report.html"].decode()
    assert re.findall(r'<img class="logo" src="data:image/(svg\+xml|png);base64,[^"]*" alt="[^"]+">', html) == [
        "svg+xml", "png",
    ]  # fmt: skip
    assert "Letters &lt;b&gt;" in html


@pytest.mark.long
def test_law_a_branded_pdf_conforms(made: dict[str, bytes], tmp_path: Path) -> None:
    tool = check_pdf.jar()
    if isinstance(tool, str):
        pytest.skip(tool)
    path = tmp_path / "report.pdf"
    path.write_bytes(made["report.pdf"])
    for profile in check_pdf.PROFILES:
        assert check_pdf.faults(tool, profile, [path]) == {str(path): []}
