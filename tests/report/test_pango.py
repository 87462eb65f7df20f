"""Without Pango the HTML still comes out, the message says how to get the PDF, and no PDF of an earlier run stays."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from metrology import report
from metrology.errors import MetrologyError

ROOT = Path(__file__).parents[2]
HIDDEN = """
import cffi
load = cffi.FFI.dlopen
def dlopen(self, name, flags=0):
    if "pango" in str(name):
        raise OSError(f"cannot load library {name!r}: cannot open shared object file: No such file or directory")
    return load(self, name, flags)
cffi.FFI.dlopen = dlopen
"""
"""A system without Pango, as Python sees it: the loader of libraries does not find it."""


def reported(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "metrology", "report", "wire", "--no-coverage"],
        cwd=folder, env={**os.environ, **environment}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip


@pytest.mark.long
def test_limit_without_pango_the_html_comes_out_and_no_old_pdf_stays(tmp_path: Path) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (tmp_path / "wire").mkdir()
    for kind, name in (("yaml", "campaign.yaml"), ("csv", "wire.csv")):
        (text,) = re.findall(rf"```{kind}\n(.*?)```", readme, re.DOTALL)
        (tmp_path / "wire" / name).write_text(text, encoding="utf-8")
    (tmp_path / "hidden").mkdir()
    (tmp_path / "hidden" / "sitecustomize.py").write_text(HIDDEN, encoding="utf-8")
    made = tmp_path / "reports" / "wire"

    assert reported(tmp_path).returncode == 0
    assert (made / "report.pdf").exists()
    (made / "report.html").unlink()

    done = reported(tmp_path, PYTHONPATH=str(tmp_path / "hidden"))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "report.pdf: got no library Pango on this system; expected Pango, which lays out report.pdf; report.html and "
        "the results need none. Fix: apt-get install libpangoft2-1.0-0 libharfbuzz-subset0 (Debian), or the pango of "
        "your distribution\n"
    )
    assert sorted(path.name for path in made.iterdir()) == [
        *("audit.jsonl", "report.html", "results.csv", "results.json", "ro-crate-metadata.json"),
    ]
    assert "Stiffness of a steel wire" in (made / "report.html").read_text(encoding="utf-8")


def test_refusal_a_signed_pdf_is_not_removed_by_a_report_without_one(tmp_path: Path) -> None:
    (tmp_path / "report.pdf").write_bytes(b"%PDF-1.7 /ByteRange [0 1 2 3]")
    with pytest.raises(MetrologyError, match="a signed report of other content"):
        report.place({"report.html": b"<p>", "results.json": b"{}"}, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["report.pdf"]
