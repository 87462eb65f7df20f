from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import findings_sample
import pytest

from metrology.findings import Findings
from metrology.report import write


@pytest.fixture(scope="session")
def findings() -> Findings:
    return findings_sample.build(1, records=1)


@pytest.fixture(scope="session")
def report(findings: Findings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reports") / "tapes"
    write(findings, folder)
    return folder


@pytest.fixture(scope="session")
def hostile_report(findings: Findings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reports") / "hostile"
    short = replace(findings, results=findings.results[:1], correlations=())
    write(findings_sample.hostile(short), folder)
    return folder
