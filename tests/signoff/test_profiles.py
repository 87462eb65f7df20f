"""PDF/A-3a and PDF/UA-1 by veraPDF, before and after signing; skipped where Java or veraPDF is missing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import findings_sample
import pytest

from metrology import report

SCRIPT = Path(__file__).parents[2] / "scripts" / "check_pdf.py"
SKIPPED = 77


@pytest.mark.long
def test_reference_reports_conform_before_and_after_signing(stages, tmp_path: Path):
    findings = findings_sample.build(2, records=1)
    files = {
        "every-section.pdf": report.make(findings)["report.pdf"],
        "hostile.pdf": report.make(findings_sample.hostile(findings_sample.build(1, records=1)))["report.pdf"],
        "unsigned.pdf": stages[0],
        "signed.pdf": stages[3],
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    # Relative names, as the Makefile gives them: veraPDF answers with absolute ones.
    outcome = subprocess.run(
        [sys.executable, SCRIPT, *files], check=False, capture_output=True, text=True, cwd=tmp_path
    )
    if outcome.returncode == SKIPPED:
        pytest.skip(outcome.stdout.strip())
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    assert outcome.stdout.count(" conforms ") == 2 * len(files)
