"""Two campaigns of one id do not replace each other's report, whatever command makes it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from metrology.cli import main

TEXT = """\
format: metrology-campaign/1
id: same
title: One of two
quantities: {a: 10.00(1) mm}
derived: [{quantity: d, expression: a*2, unit: mm}]
"""


@pytest.fixture
def two(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    monkeypatch.chdir(tmp_path)
    homes = tmp_path / "a", tmp_path / "b"
    for home in homes:
        home.mkdir()
        (home / "campaign.yaml").write_text(TEXT)
    return homes


def made(command: str, home: Path) -> int:
    return main([command, str(home), "--output", "reports", *(["--quiet"] if command != "batch" else [])])


@pytest.mark.long
@pytest.mark.parametrize("command", ["run", "report", "batch"])
def test_planted_another_campaign_of_one_id_is_refused(command: str, two, capsys) -> None:
    first, second = two
    assert made("run", first) == 0
    results = Path("reports/same/results.json").read_bytes()
    assert made(command, second) != 0
    said = "".join(capsys.readouterr())
    assert f"results of {first.resolve() / 'campaign.yaml'}, which has the same id 'same'" in said
    assert "give one of the two campaigns another id, or write elsewhere with --output" in said
    assert Path("reports/same/results.json").read_bytes() == results


@pytest.mark.parametrize("change", ["edited", "moved", "renamed"])
def test_law_a_campaign_that_was_edited_moved_or_whose_namesake_was_renamed_is_made_again(change: str, two) -> None:
    first, second = two
    assert made("run", first) == 0
    if change == "edited":
        (first / "campaign.yaml").write_text(TEXT.replace("10.00(1)", "11.00(1)"))
        assert made("run", first) == 0
    elif change == "moved":
        (first / "campaign.yaml").unlink()
        assert made("run", second) == 0
    else:
        (first / "campaign.yaml").write_text(TEXT.replace("id: same", "id: other"))
        assert made("run", second) == 0
    lines = Path("reports/same/audit.jsonl").read_text().splitlines()
    home = first if change == "edited" else second
    assert json.loads(lines[-1])["campaign"] == str(home.resolve() / "campaign.yaml")


def test_law_what_cannot_be_written_is_refused_before_it_is_evaluated(two, monkeypatch, capsys) -> None:
    first, second = two
    assert made("run", first) == 0
    monkeypatch.setattr("metrology.chain.traced", lambda *_, **__: pytest.fail("it takes minutes"))
    assert made("run", second) == 2
    assert "which has the same id 'same'" in capsys.readouterr().err
