"""What the tutorial shows is what happens: its files are written, its commands run, and they print what it prints."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from doctest import ELLIPSIS, OutputChecker
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]*)")?\n(.*?)^```', re.DOTALL | re.MULTILINE)


def steps() -> list[tuple[str, str, str]]:
    """Kind, title and body of every block, in order."""
    return [match.groups() for match in BLOCK.finditer((ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8"))]


def ran(command: str, folder: Path) -> str:
    program, *arguments = command.split()
    assert program == "metrology"
    done = subprocess.run(
        [sys.executable, "-m", "metrology", *arguments],
        cwd=folder,
        env={**os.environ, "COLUMNS": "100"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert "Traceback" not in done.stderr
    return done.stdout + done.stderr


@pytest.mark.long
def test_reference_every_command_of_the_tutorial_prints_what_it_shows(tmp_path: Path) -> None:
    for kind, title, body in steps():
        if title:
            (tmp_path / title).parent.mkdir(exist_ok=True)
            (tmp_path / title).write_text(body, encoding="utf-8")
            continue
        assert kind == "console", f"a block that is neither a file nor commands: {body}"
        for command, shown in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", body, re.MULTILINE):
            printed = ran(command, tmp_path)
            assert OutputChecker().check_output(shown, printed, ELLIPSIS), f"$ {command}\n{printed}"
    assert (tmp_path / "reports" / "wire" / "report.html").stat().st_size > 50_000


def test_law_the_tutorial_goes_from_readings_to_a_verified_report() -> None:
    commands = [line.split()[2] for _, _, body in steps() for line in body.splitlines() if line.startswith("$ ")]
    assert commands == [
        *("check", "check", "report", "check", "check", "report"),
        "authority",
        *(3 * ["sign"]),
        "verify",
    ]
    assert [title for _, title, _ in steps() if title] == ["wire/wire.csv", *(3 * ["wire/campaign.yaml"])]
