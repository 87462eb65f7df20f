"""Which campaigns a batch finds below a folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from metrology.batch import find
from metrology.cli import main


def test_planted_a_link_to_a_campaign_that_is_gone_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("b", "a/deep", ".hidden"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "campaign.yaml").symlink_to(tmp_path / "gone.yaml")
    assert find(tmp_path) == [tmp_path / "a" / "deep" / "campaign.yaml", tmp_path / "b" / "campaign.yaml"]
    assert main(["batch", str(tmp_path), "--output", str(tmp_path / "made"), "--workers", "1"]) == 1
    assert "2 campaigns: 0 made, 0 up to date, 2 not made" in capsys.readouterr().out
