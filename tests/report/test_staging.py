from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import findings_sample
import pytest

from metrology.errors import MetrologyError
from metrology.findings import Findings
from metrology.report import html, pdf, staging, write

OLD = {"report.pdf": b"old", "results.json": b"old"}
NEW = {"report.pdf": b"new", "results.json": b"new"}


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_law_new_report_takes_the_place_of_the_old_and_keeps_what_lay_beside(tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "tapes"
    staging.replace_folder(folder, OLD)
    (folder / "notes.txt").write_bytes(b"mine")
    (folder / "signed").mkdir()
    (folder / "signed" / "report.pdf").write_bytes(b"signed")
    staging.replace_folder(folder, NEW)
    assert (folder / "report.pdf").read_bytes() == b"new"
    assert (folder / "notes.txt").read_bytes() == b"mine"
    assert (folder / "signed" / "report.pdf").read_bytes() == b"signed"
    assert [path.name for path in folder.parent.iterdir()] == ["tapes"]


def test_refusal_write_protected_folder_keeps_the_old_report(tmp_path: Path) -> None:
    folder = tmp_path / "tapes"
    staging.replace_folder(folder, OLD)
    folder.chmod(0o555)
    with pytest.raises(
        MetrologyError, match=r"write-protected folder.*expected a folder that can be written.*Fix: free space"
    ):
        staging.replace_folder(folder, NEW)
    folder.chmod(0o755)
    assert contents(folder) == OLD


def test_refusal_protected_reports_folder(tmp_path: Path) -> None:
    parent = tmp_path / "reports"
    staging.replace_folder(parent / "tapes", OLD)
    parent.chmod(0o555)
    with pytest.raises(MetrologyError, match="write-protected folder"):
        staging.replace_folder(parent / "tapes", NEW)
    parent.chmod(0o755)
    assert contents(parent / "tapes") == OLD


def test_refusal_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "tapes").write_text("a file")
    with pytest.raises(MetrologyError, match="a file is where the report's folder should be"):
        staging.replace_folder(tmp_path / "tapes", NEW)
    assert (tmp_path / "tapes").read_text() == "a file"


def test_refusal_full_disk_keeps_the_old_report(tmp_path: Path) -> None:
    """A limit on the size of files stands in for a full disk: the system refuses the write half way."""
    folder = tmp_path / "tapes"
    staging.replace_folder(folder, OLD)
    code = (
        "import resource, sys, pathlib; from metrology.errors import MetrologyError; from "
        "metrology.report import staging\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try: staging.replace_folder(pathlib.Path(sys.argv[1]), {'a': b'x', 'report.pdf': b'x' * 5000})\n"
        "except MetrologyError as error: print(error); sys.exit(2)"
    )
    result = subprocess.run([sys.executable, "-c", code, folder], capture_output=True, text=True, check=False)
    assert result.returncode == 2, result.stderr
    assert "got file too large" in result.stdout
    assert contents(folder) == OLD
    assert [path.name for path in tmp_path.iterdir()] == ["tapes"]


def test_law_killed_run_is_cleaned_up_by_the_next(tmp_path: Path) -> None:
    """A process that dies while it holds its staging folder."""
    folder = tmp_path / "tapes"
    staging.replace_folder(folder, OLD)
    code = (
        "import os, sys, pathlib; from metrology.report import staging\n"
        "class Bomb(dict):\n    def items(self):\n        yield 'report.pdf', b'half'\n        os._exit(9)\n"
        "staging.replace_folder(pathlib.Path(sys.argv[1]), Bomb())"
    )
    assert subprocess.run([sys.executable, "-c", code, folder], check=False).returncode == 9
    assert contents(folder) == OLD
    assert len(list(tmp_path.iterdir())) == 2
    staging.replace_folder(folder, NEW)
    assert contents(folder) == NEW
    assert [path.name for path in tmp_path.iterdir()] == ["tapes"]


def test_law_death_between_the_two_renamings_loses_nothing(tmp_path: Path) -> None:
    old = tmp_path / ".tapes.old-abc"
    old.mkdir()
    (old / "notes.txt").write_bytes(b"mine")
    staging.replace_folder(tmp_path / "tapes", NEW)
    assert contents(tmp_path / "tapes") == {**NEW, "notes.txt": b"mine"}
    assert [path.name for path in tmp_path.iterdir()] == ["tapes"]


def test_law_runs_at_once_do_not_mix(tmp_path: Path) -> None:
    folder = tmp_path / "tapes"

    def run(index: int) -> None:
        staging.replace_folder(folder, dict.fromkeys(("report.pdf", "report.html", "results.json"), b"%d" % index))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(run, range(40)))
    assert len(set(contents(folder).values())) == 1
    assert len(contents(folder)) == 3
    assert [path.name for path in tmp_path.iterdir()] == ["tapes"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("cover.html", "{{ campaign.nonsense }}", r"no attribute 'nonsense'"),
        ("cover.html", "{% if %}", r"cover.html:1"),
        ("cover.html", "{% include 'missing.html' %}", "no template missing.html"),
        ("cover.html", "<img src='file:///etc/passwd' alt='x'>", "disallowed protocol|Failed to load image"),
        ("cover.html", "<img src='https://example.invalid/x.png' alt='x'>", "disallowed protocol|Failed to load image"),
        ("report.css", "p { colour: red }", "unknown property"),
    ],
)
def test_refusal_wrong_template_keeps_the_old_report(
    findings: Findings, tmp_path: Path, name: str, text: str, message: str
) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / name).write_text(text, encoding="utf-8")
    with pytest.raises(MetrologyError, match=message):
        pdf.render(html.render(findings_sample.empty(), {}, templates=tmp_path / "mine"))


def test_refusal_failed_build_leaves_the_old_report(tmp_path: Path) -> None:
    folder = tmp_path / "tapes"
    staging.replace_folder(folder, OLD)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "provenance.html").write_text("{{ nothing_of_that_name }}", encoding="utf-8")
    with pytest.raises(MetrologyError, match="nothing_of_that_name"):
        write(findings_sample.empty(), folder, templates=tmp_path / "mine")
    assert contents(folder) == OLD


def test_refusal_templates_folder_missing(tmp_path: Path) -> None:
    with pytest.raises(MetrologyError, match="no such folder"):
        write(findings_sample.empty(), tmp_path / "tapes", templates=tmp_path / "nowhere")
    assert not list(tmp_path.iterdir())
