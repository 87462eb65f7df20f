from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import diagnosis_sample
import pytest
from pypdf import PdfReader

from metrology.findings import Findings, from_json
from metrology.language.notices import brief
from metrology.report import html, write
from metrology.report.figures import draw

VERDICTS = ("nothing missing", "explained", "ambiguous", "unexplained")


@pytest.fixture(scope="module")
def diagnosed(findings: Findings) -> Findings:
    short = replace(findings, tests=(), results=findings.results[:1], correlations=(), fits=(), conformity=())
    told = tuple(
        getattr(diagnosis_sample, name)() for name in ("explained", "nothing", "ambiguous", "unexplained", "overlay")
    )
    return replace(short, comparisons=(), audit=(), diagnosis=told)


@pytest.fixture(scope="module")
def folder(diagnosed: Findings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reports") / "diagnosed"
    write(diagnosed, folder)
    return folder


@pytest.fixture(scope="module")
def paper(folder: Path) -> str:
    pages = PdfReader(folder / "report.pdf").pages
    return re.sub(r"\s+", " ", " ".join(page.extract_text() for page in pages))


@pytest.fixture(scope="module")
def screen(folder: Path) -> str:
    return (folder / "report.html").read_text("utf-8")


def test_law_every_verdict_has_its_mark_and_the_five_questions(paper: str) -> None:
    assert "Diagnosis of the models" in paper
    for mark, verdict in zip("✓●◐✗", VERDICTS, strict=True):
        assert f"{mark} {verdict}" in paper
    for question in ("What is wrong?", "Why?", "How certain is it?", "What does it change?", "What to do next?"):
        assert paper.count(question) == 5, question


def test_law_what_the_numbers_say_is_there(paper: str) -> None:
    for text in (
        *("probability > 99.9 %", "0.379 ± 0.025 mN", "95 % from", "3.197, 95 % 3.050 … 3.360", "1.73 → 1.00"),
        *("0.12 mN", "Compliance of the set-up", "coast run at twice the speed", "61.0 %", "37.0 %", "8.05069"),
        *("friction.force = 3.79000×10⁻⁴", "its fit did not converge", "frequency = 50.0 Hz"),
    ):
        assert text in paper, text


def test_law_the_certificate_has_a_sentence_for_each_test_that_lacks_something(diagnosed: Findings) -> None:
    lines = [sentence for kind, sentence in brief(diagnosed) if kind == "Diagnosis"]
    assert [line.partition(":")[0] for line in lines[:2]] == ["r-explained", "d-ambiguous"]
    assert len(lines) == 4
    assert "one of effect of friction / effect of drag" in lines[1].lower()
    assert "one of" not in lines[0].lower()
    assert not [line for line in lines if "r-nothing" in line]


def test_law_nothing_missing_is_said_with_its_evidence(paper: str) -> None:
    start = paper.index("Nothing that these data can show")
    told = paper[start : start + 900]
    for text in (
        "1.01",
        "1 known effect was considered",
        "smallest detectable effects",
        "those of the model as stated",
    ):
        assert text.casefold() in told.casefold(), text


def test_law_unexplained_gives_no_name(paper: str) -> None:
    start = paper.index("A force of −0.002 N")
    told = paper[start : paper.index("What to do next?", start)]
    assert "Something is missing" in told
    assert "Missing in the model" not in told


def test_refusal_hostile_names_stay_text(screen: str, folder: Path) -> None:
    assert "<b onload" not in screen
    assert "&lt;/script&gt;&lt;b onload=x&gt;" in screen
    for data in re.findall(r'<script type="application/json" data-series>(.*?)</script>', screen, flags=re.DOTALL):
        assert "<" not in data
        assert json.loads(data)["panels"]


@pytest.mark.long
def test_law_every_plot_of_a_diagnosis_stands_in_the_page_with_words(diagnosed: Findings, screen: str) -> None:
    plots = draw(diagnosed)
    keys = [key for key in plots if key.startswith("diagnosis/")]
    assert len(keys) == 4 + 4 + 1 + 2 + 4
    page = html.render(diagnosed, plots)
    drawn = {plot.alt for plot in page.pictures.values()}
    assert {plots[key].alt for key in keys} <= drawn
    assert "from −0.400 mN at 0.0200 m/s to 0.400 mN at 0.110 m/s" in screen


def test_law_history_can_be_zoomed(screen: str) -> None:
    data = re.findall(r'<script type="application/json" data-series>(.*?)</script>', screen, flags=re.DOTALL)
    panels = json.loads(data[0])["panels"]
    assert [panel["title"] for panel in panels] == ["Picture history-x", "Picture history-T"]
    assert [curve["role"] for curve in panels[0]["curves"]] == ["before", "after"]


@pytest.mark.long
def test_twice_results_json_alone_gives_the_same_chapter(folder: Path, tmp_path: Path) -> None:
    write(from_json(folder / "results.json"), tmp_path / "again")
    for name in ("report.html", "report.pdf"):
        assert (tmp_path / "again" / name).read_bytes() == (folder / name).read_bytes(), name
