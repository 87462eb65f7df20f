from __future__ import annotations

import hashlib
import json
import re
from base64 import b64decode, b64encode
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import response_sample
from pypdf import PdfReader

from metrology.findings import Findings, from_json
from metrology.report import write


@pytest.fixture(scope="module")
def responses(findings: Findings) -> Findings:
    short = replace(findings, tests=(), results=findings.results[:1], correlations=(), fits=(), conformity=())
    return response_sample.add(replace(short, comparisons=(), audit=()))


@pytest.fixture(scope="module")
def folder(responses: Findings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reports") / "nylon"
    write(responses, folder)
    return folder


@pytest.fixture(scope="module")
def page(folder: Path) -> str:
    return (folder / "report.html").read_text("utf-8")


@pytest.mark.long
def test_law_response_chapter_has_estimates_inputs_correlation_verdict_and_metrics(folder: Path) -> None:
    reader = PdfReader(folder / "report.pdf")
    text = re.sub(r"\s+", " ", " ".join(part.extract_text() for part in reader.pages))
    for words in (
        *("170.01", "0.69", "167.61(77)", "open … 8.200", "The runs only bound c.", "mass (factor)", "1.00980(90)"),
        *("−0.40", "low-step-2 </script><b>", "No metric decides alone", "99.94", "2.5890(60)"),
    ):
        assert words.replace("99.94", "0.9994") in text, words
    first = re.sub(r"\s+", " ", reader.pages[0].extract_text())
    assert "the model as stated is not validated (0 of 1 held-out runs)" in first
    assert "standard uncertainty of one reading: x" not in text


def test_twice_response_findings_come_back_from_their_json(folder: Path, responses: Findings) -> None:
    assert from_json(folder / "results.json") == responses


def test_law_scripts_of_the_page_are_those_that_its_policy_names(page: str) -> None:
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)
    assert policy is not None
    scripts = re.findall(r"<script>(.*?)</script>", page, flags=re.DOTALL)
    assert len(scripts) == 3
    for script in scripts:
        digest = b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy[1].replace("&#39;", "'")
    assert "unsafe" not in policy[1]
    assert "default-src 'none'" in policy[1].replace("&#39;", "'")


def series(page: str) -> list[str]:
    return re.findall(r'<script type="application/json" data-series>(.*?)</script>', page, flags=re.DOTALL)


def test_law_residuals_of_a_fit_can_be_zoomed_in_units_of_the_noise_with_their_gaps(page: str) -> None:
    panels = json.loads(series(page)[-1])["panels"]
    assert [(panel["name"], panel["title"]) for panel in panels] == [
        ("low-step-1: x", "residual / u"),
        ("low-step-1: T", "residual / u"),
    ]
    residual, upper, lower = panels[0]["curves"]
    seen = np.frombuffer(b64decode(residual["y"]), "<f4")
    assert np.isnan(seen[0])
    assert np.allclose(seen[1:3], [-1.0, 1.0])
    assert (upper["y"], lower["y"]) == ([2, 2], [-2, -2])


def test_refusal_hostile_names_do_not_leave_the_data_of_a_plot(page: str) -> None:
    assert "<" not in "".join(series(page))
    data = next(one for one in series(page) if '"x / mm"' in one)
    panels = json.loads(data)["panels"]
    assert [panel["title"] for panel in panels] == ["x / mm", "E / mm", "T / mN", "E / mN"]
    measured, simulated = (np.frombuffer(b64decode(panels[0][key]), "<f4") for key in ("measured", "simulated"))
    assert np.isnan(measured[0])
    assert simulated[0] == 20.0


def test_law_a_page_without_script_still_shows_the_plot(page: str) -> None:
    figures = re.findall(r"<figure.*?</figure>", page, flags=re.DOTALL)
    assert all("<svg" in figure for figure in figures)
    assert any("data-series" in figure for figure in figures)
