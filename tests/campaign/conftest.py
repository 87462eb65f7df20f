from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from good_campaign import CAMPAIGN, FILES

from metrology.campaign.load import load
from metrology.errors import MetrologyError


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a good campaign and its readings, which is the current one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "campaign.yaml").write_text(CAMPAIGN, encoding="utf-8")
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture
def faults(folder: Path) -> Callable[..., list[str]]:
    """Messages of the good campaign with one passage of its file, or of a file of readings, replaced by another."""

    def tell(old: str = "", new: str = "", file: str = "campaign.yaml") -> list[str]:
        path = folder / file
        text = path.read_text(encoding="utf-8")
        assert text.count(old) >= 1, old
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(MetrologyError) as caught:
            load("campaign.yaml")
        return [str(fault) for fault in caught.value.faults]

    return tell
