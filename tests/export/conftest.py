from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import findings_sample
import pytest

from metrology.findings import Findings, to_json
from metrology.identification import Party


@pytest.fixture(scope="session")
def findings() -> Findings:
    made = findings_sample.build(2, records=1)
    laboratory = replace(made.campaign.laboratory, country="IT")
    return replace(made, campaign=replace(made.campaign, laboratory=laboratory, customer=Party("Customer", "Street 2")))


@pytest.fixture
def series(findings: Findings, tmp_path: Path):
    """Writes one results.json a value of k, a month apart, and returns their folder."""

    def write(values: list[float]) -> Path:
        for i, value in enumerate(values):
            day = f"{2020 + i // 12}-{i % 12 + 1:02d}-15"
            test = replace(findings.tests[0], date=day, elongation=None)
            result = replace(findings.results[0], value=value)
            campaign = replace(findings.campaign, report_number=f"TR-{i}", issued=day)
            made = replace(findings, campaign=campaign, tests=(test,), results=(result,))
            (tmp_path / "reports" / f"c{i}").mkdir(parents=True)
            (tmp_path / "reports" / f"c{i}" / "results.json").write_bytes(to_json(made))
        return tmp_path / "reports"

    return write
