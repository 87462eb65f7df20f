"""How much a command says, and what it opens."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from metrology.campaign.starter import create
from metrology.cli import main


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    return create("bolt", tmp_path, "elongation")


def test_quiet_says_nothing_but_what_is_wrong(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    run = ["run", "--quiet", "--no-coverage", "--output", str(tmp_path / "reports"), str(campaign)]
    assert main(run) == 0
    assert capsys.readouterr() == ("", "")
    campaign.write_text(campaign.read_text().replace("method: elongation", "method: elongaton"))
    assert main(["check", "--quiet", str(campaign)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "elongaton" in said.err


def test_verbose_tells_each_step_on_stderr(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    main(["run", "--verbose", "--no-coverage", "--output", str(tmp_path / "reports"), str(campaign)])
    said = capsys.readouterr()
    steps = [line.partition(f"{campaign}: ")[2] for line in said.err.splitlines()]
    assert steps[:2] == ["reading", "tests"]
    assert {"uncertainties", "verdicts"} <= set(steps)
    assert "bolt" in said.out


def test_quiet_and_json_exclude_each_other(campaign: Path):
    with pytest.raises(SystemExit) as ended:
        main(["run", "--quiet", "--json", str(campaign)])
    assert ended.value.code == 2


@pytest.mark.long
def test_open_shows_the_report_that_was_made(
    campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda url: bool(opened.append(url)))
    assert main(["report", "--open", "--no-coverage", "--output", str(tmp_path / "reports"), str(campaign)]) == 0
    report = tmp_path / "reports" / "bolt" / "report.html"
    assert report.is_file()
    assert opened == [report.as_uri()]
    assert "no browser was found" in capsys.readouterr().err
