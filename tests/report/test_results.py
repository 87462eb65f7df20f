from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from metrology.errors import MetrologyError
from metrology.findings import Findings, from_json
from metrology.report import write_results


def test_law_results_alone_are_two_files_and_a_line_in_the_trail(findings: Findings, tmp_path: Path) -> None:
    write_results(findings, tmp_path / "run")
    assert {path.name for path in (tmp_path / "run").iterdir()} == {"results.json", "results.csv", "audit.jsonl"}
    assert from_json(tmp_path / "run" / "results.json") == findings


def test_law_results_of_a_later_run_replace_earlier_ones(findings: Findings, tmp_path: Path) -> None:
    write_results(findings, tmp_path / "run")
    (tmp_path / "run" / "notes.txt").write_text("mine")
    write_results(replace(findings, seed=1), tmp_path / "run")
    assert from_json(tmp_path / "run" / "results.json").seed == 1
    assert (tmp_path / "run" / "notes.txt").read_text() == "mine"


def test_refusal_results_that_a_report_beside_them_would_not_fit(
    findings: Findings, report: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    shutil.copytree(report, folder)
    before = (folder / "results.json").read_bytes()
    write_results(findings, folder)
    with pytest.raises(MetrologyError) as caught:
        write_results(replace(findings, seed=1), folder)
    (fault,) = caught.value.faults
    assert fault.where == str(folder)
    assert fault.got == "report.pdf of other results"
    assert "metrology report" in fault.fix
    assert "--output" in fault.fix
    assert (folder / "results.json").read_bytes() == before


def test_refusal_results_beside_a_report_whose_own_are_gone(findings: Findings, tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "report.html").write_text("an older report")
    with pytest.raises(MetrologyError, match=r"report\.html of other results"):
        write_results(findings, tmp_path / "run")
