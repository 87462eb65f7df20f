"""What a shell offers after TAB, asked of the shell itself."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from metrology.cli import main

pytest.importorskip("shtab")


def script(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["completion", shell]) == 0
    return capsys.readouterr().out


def offered(written: str, folder: Path, *words: str) -> set[str]:
    """What bash offers for the last of the words."""
    (folder / "completion").write_text(written)
    asked = " ".join(f"'{word}'" for word in words)
    lines = "source completion; "
    lines += f"COMP_WORDS=({asked}); COMP_CWORD={len(words) - 1}; _shtab_metrology; "
    lines += "printf '%s\\n' \"${COMPREPLY[@]}\""
    done = subprocess.run(["bash", "-c", lines], cwd=folder, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_bash_completes_commands_options_and_files_of_their_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    written = script("bash", capsys)
    (tmp_path / "wire").mkdir()
    for name in ("campaign.yaml", "wire.csv", "report.pdf"):
        (tmp_path / "wire" / name).touch()
    assert offered(written, tmp_path, "metrology", "ch") == {"check"}
    assert {"--open", "--quiet", "--verbose"} <= offered(written, tmp_path, "metrology", "report", "--")
    assert offered(written, tmp_path, "metrology", "report", "wire/") == {"wire/campaign.yaml"}
    assert offered(written, tmp_path, "metrology", "verify", "wire/") == {"wire/report.pdf"}
    assert "wire/wire.csv" in offered(written, tmp_path, "metrology", "import", "wire/")
    assert offered(written, tmp_path, "metrology", "check", "--for", "") == {"17025", "ecss"}


@pytest.mark.parametrize(("shell", "names"), [("zsh", "_files -g '*.yaml'"), ("fish", "__fish_complete_suffix .yaml")])
def test_the_other_shells_get_commands_options_and_campaigns(
    shell: str, names: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    written = script(shell, capsys)
    assert names in written
    assert all(word in written for word in ("diagnose", "verbose", "17025"))
    if shutil.which(shell):
        (tmp_path / "completion").write_text(written)
        subprocess.run([shell, "-n", str(tmp_path / "completion")], check=True)
