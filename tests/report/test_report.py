from __future__ import annotations

import csv
import hashlib
import os
import re
import subprocess
import sys
import zipfile
from base64 import b64encode
from functools import cache
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import findings_sample
import pytest
from pypdf import PdfReader

from metrology.errors import MetrologyError
from metrology.findings import Findings, from_json
from metrology.method.discovery import templates
from metrology.report import html, write

NAMES = ("report.html", "report.pdf", "results.csv", "results.json", "ro-crate-metadata.json")
SECTIONS = (
    "Items tested",
    "Instruments and their calibration",
    "Dates, persons and conditions",
    "Methods",
    "Results of each test",
    "Calibration lines and curves",
    "Uncertainty of each result",
    "Correlations of the results",
    "Comparisons",
    "Conformity with requirements",
    "Audit of published and expected figures",
    "Purpose, place and sampling",
    "Opinions and interpretations",
    "Deviations, exclusions and anomalies",
    "Checklists of the report",
    "Inputs and their sources",
    "References",
    "Provenance",
    "End of report",
)


class Elements(HTMLParser):
    """Every start tag with its attributes, in order, and the text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def squeezed(text: str) -> str:
    return re.sub(r"\s+", " ", text)


@cache
def pdf_text(folder: Path) -> list[str]:
    return [squeezed(page.extract_text()) for page in PdfReader(folder / "report.pdf").pages]


@pytest.mark.long
def test_law_every_section_stands_in_pdf_and_html(report: Path) -> None:
    paper = " ".join(pdf_text(report))
    screen = squeezed(" ".join(Elements((report / "report.html").read_text("utf-8")).words))
    for title in SECTIONS:
        assert title in paper, title
        assert title in screen, title


@pytest.mark.long
def test_law_page_one_has_identification_results_and_flags(report: Path) -> None:
    first = pdf_text(report)[0]
    for text in (
        *("TR-2026-001", "Tether Programme Office", "Al-1100 tape", "2026-11-20", "J. Doe", "RECONSTRUCTED READINGS"),
        *("24730", "340", "N/m", "24000 … 25470", "natural angular frequency", "pass"),
        *("overdue by 35 days", "indicator knocked", "one figure differs from the published", "MC", "does not confirm"),
    ):
        assert text.casefold() in first.casefold(), text


def test_law_every_page_is_numbered_and_carries_the_report_number(report: Path) -> None:
    pages = pdf_text(report)
    for number, text in enumerate(pages, 1):
        assert f"Page {number} of {len(pages)}" in text
        assert "Test report TR-2026-001" in text
        assert "reconstructed readings" in text.casefold()
    assert "End of report" in pages[-1]


def test_law_monte_carlo_interval_leads_where_the_law_fails(report: Path, findings: Findings) -> None:
    modulus = next(result for result in findings.results if result.quantity == "E")
    assert not modulus.monte_carlo.law_valid
    low, high = (end / 1e9 for end in modulus.interval if end is not None)
    assert f"{low:.1f} … {high:.1f}" in pdf_text(report)[0]


@pytest.mark.long
def test_law_empty_campaign_makes_a_whole_report(tmp_path: Path) -> None:
    write(findings_sample.empty(), tmp_path / "empty")
    text = " ".join(pdf_text(tmp_path / "empty"))
    assert "None." in text
    assert "No requirement was stated" in text
    assert "every instrument was in calibration" not in text  # there is none
    assert "reconstructed" not in text.casefold()


@pytest.mark.long
def test_twice_same_findings_give_same_bytes_in_two_processes(report: Path, tmp_path: Path) -> None:
    code = "import sys, pathlib, findings_sample; from metrology.report import write; " + (
        "write(findings_sample.build(1, records=1), pathlib.Path(sys.argv[1]))"
    )
    environment = {
        **os.environ,
        "PYTHONPATH": str(Path(__file__).parent),
        "PYTHONHASHSEED": "7",
        "TZ": "Asia/Tokyo",
        "HOME": str(tmp_path),
        "LC_ALL": "POSIX",
        "LANG": "C",
    }
    subprocess.run([sys.executable, "-c", code, tmp_path / "again"], check=True, env=environment, cwd=tmp_path)
    for name in NAMES:
        assert (report / name).read_bytes() == (tmp_path / "again" / name).read_bytes(), name


def test_twice_results_json_gives_the_findings_back(report: Path, findings: Findings) -> None:
    assert from_json(report / "results.json") == findings


def test_twice_results_csv_at_full_precision(report: Path, findings: Findings) -> None:
    with (report / "results.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    agreed = [one.value for one in findings.consensus if one.consistent]
    assert [float(row["value"]) for row in rows] == [*(result.value for result in findings.results), *agreed]
    rows = rows[: len(findings.results)]
    assert [row["law_valid"] for row in rows] == ["yes" if r.monte_carlo.law_valid else "no" for r in findings.results]
    assert all(float(row["interval_low"]) == r.interval[0] for row, r in zip(rows, findings.results, strict=True))


def test_law_html_asks_nobody_for_anything(report: Path) -> None:
    text = (report / "report.html").read_text("utf-8")
    elements = Elements(text)
    assert not {tag for tag, _ in elements.tags} & {"link", "iframe", "object", "embed", "form", "base"}
    assert not any("src" in attributes for tag, attributes in elements.tags if tag == "script")
    for tag, attributes in elements.tags:
        for name in ("src", "href", "xlink:href", "srcset", "action", "data"):
            address = attributes.get(name) or "#"
            assert address.startswith("#"), (tag, address)
        assert "style" not in attributes
        assert not [name for name in attributes if name.startswith("on")]
    assert set(re.findall(r"url\((.{5})", text)) == {"data:"}


def test_law_html_styles_are_those_that_the_policy_names(report: Path) -> None:
    text = (report / "report.html").read_text("utf-8")
    policy = (
        next(a["content"] for tag, a in Elements(text).tags if a.get("http-equiv") == "Content-Security-Policy") or ""
    )
    styles = re.findall(r"<style[^>]*>(.*?)</style>", text, flags=re.DOTALL)
    assert len(styles) == 5
    for style in styles:
        digest = b64encode(hashlib.sha256(style.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy


def test_law_every_picture_says_what_it_shows(report: Path) -> None:
    elements = Elements((report / "report.html").read_text("utf-8"))
    pictures = [attributes.get("aria-label") or "" for tag, attributes in elements.tags if tag == "svg"]
    assert len(pictures) > 15
    assert all(pictures)
    assert any("k = 24730 ± 340 N/m" in words for words in pictures)


def test_law_headings_descend_one_level_at_a_time_and_headers_have_a_scope(report: Path) -> None:
    tags = Elements((report / "report.html").read_text("utf-8")).tags
    levels = [int(tag[1]) for tag, _ in tags if re.fullmatch(r"h\d", tag)]
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert all(attributes.get("scope") for tag, attributes in tags if tag == "th")
    assert ("html", {"lang": "en"}) in tags


def test_law_plots_of_reconstructed_readings_say_so(report: Path) -> None:
    text = (report / "report.html").read_text("utf-8")
    plots = re.findall(r"<figure.*?</figure>", text, flags=re.DOTALL)
    assert len(plots) > 10
    assert all("RECONSTRUCTED READINGS" in plot for plot in plots)


def test_law_ids_are_unique_and_links_lead_somewhere(report: Path) -> None:
    tags = Elements((report / "report.html").read_text("utf-8")).tags
    ids = [attributes["id"] for _, attributes in tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    assert {(a["href"] or "")[1:] for tag, a in tags if tag == "a"} <= set(ids)


def test_refusal_hostile_text_stays_text(hostile_report: Path) -> None:
    text = (hostile_report / "report.html").read_text("utf-8")
    elements = Elements(text)
    assert not {tag for tag, _ in elements.tags} & {"link", "img"}
    ours = [(templates() / name).read_text("utf-8") for name in html.SCRIPTS]
    assert re.findall(r"<script>(.*?)</script>", text, flags=re.DOTALL) == ours
    assert "<script>alert(1)</script>{{ 7*7 }}" in "".join(elements.words)
    assert "49" not in "".join(elements.words)[:200]
    assert not re.search("[\u202a-\u202e\u2066-\u2069\x00-\x08]", text)
    assert "⟨U+202E⟩" in text


def test_refusal_hostile_text_embeds_nothing_in_the_pdf(hostile_report: Path) -> None:
    reader = PdfReader(hostile_report / "report.pdf")
    ours = ["results.csv", "results.json", "ro-crate-metadata.json"]
    assert sorted(reader.attachments) == ours  # and nothing that a text asked for
    assert "alert(1)" in squeezed(reader.pages[0].extract_text())
    addresses = [
        str(annotation.get_object().get("/A")) for page in reader.pages for annotation in page.get("/Annots", []) or []
    ]
    assert not [address for address in addresses if "URI" in address]
    assert b"root:" not in (hostile_report / "report.pdf").read_bytes()


def test_law_pdf_is_tagged_and_names_language_and_title(report: Path) -> None:
    catalog = PdfReader(report / "report.pdf").trailer["/Root"]
    assert catalog["/MarkInfo"]["/Marked"]
    assert catalog["/Lang"] == "en"
    assert PdfReader(report / "report.pdf").metadata["/Title"].startswith("Test report TR-2026-001")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{{ ''.__class__.__mro__ }}", "access to attribute '__class__' of 'str' object is unsafe"),
        ("{{ ''|attr('__class__') }}", "'__class__' of 'str' object is unsafe"),
        ("{{ '{0.__class__}'.format('') }}", "'__class__' of 'str' object is unsafe"),
        ("{{ fig.__globals__ }}", "'__globals__' of 'method' object is unsafe"),
        ("{{ lipsum.__globals__ }}", "'__globals__' of 'function' object is unsafe"),
        ("{{ campaign.__init__.__globals__ }}", "'__init__' of 'CampaignItem' object is unsafe"),
        ("{% include '../../secret' %}", "no template ../../secret"),
        ("{{ range(10 ** 9) }}", "OverflowError: Range too big"),
        ("{{ 1 / 0 }}", "ZeroDivisionError"),
        ("{{ 'abc'.index('z') }}", "ValueError: substring not found"),
        ("{% include 'references.html' %}", "RecursionError"),
    ],
)
def test_refusal_template_that_reaches_out_of_the_sandbox_or_has_no_value(
    text: str, message: str, tmp_path: Path
) -> None:
    (tmp_path / "references.html").write_text(text, encoding="utf-8")
    with pytest.raises(MetrologyError, match=re.escape(message)):
        html.render(findings_sample.empty(), {}, templates=tmp_path)


def test_refusal_link_among_templates_unless_code_is_allowed(tmp_path: Path) -> None:
    secret, folder = tmp_path / "secret", tmp_path / "mine"
    secret.write_text("the key", encoding="utf-8")
    folder.mkdir()
    (folder / "references.html").symlink_to(secret)
    with pytest.raises(MetrologyError, match="a link that leads elsewhere"):
        html.render(findings_sample.empty(), {}, templates=folder)
    assert "the key" in html.render(findings_sample.empty(), {}, templates=folder, allow_code=True).text


@pytest.mark.long
def test_law_laboratory_replaces_one_template(findings: Findings, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "references.html").write_text(
        "<p>As agreed with {{ campaign.customer.name }}.</p>", encoding="utf-8"
    )
    page = html.render(findings, {}, templates=tmp_path / "mine")
    assert "As agreed with Tether Programme Office." in page.text
    assert "Random numbers start from the seed 20261120" in page.text


@pytest.mark.long
@pytest.mark.parametrize("drawn", [True, False])
def test_law_installed_wheel_carries_the_templates(tmp_path: Path, *, drawn: bool) -> None:
    root = Path(__file__).parents[2]
    if not drawn:
        assert templates() == root / "templates"
        return
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        check=True,
        cwd=root,
        capture_output=True,
    )
    wheel = next(tmp_path.glob("*.whl"))
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    names = {path.name for path in (tmp_path / "site" / "metrology" / "templates").iterdir()}
    assert {path.name for path in (root / "templates").iterdir()} <= names
    code = "from metrology.method.discovery import templates; print(templates())"
    result = subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "site")},
    )
    assert Path(result.stdout.strip()) == tmp_path / "site" / "metrology" / "templates"
