"""The whole matrix of planted effects against the bars: minutes to hours, so only on request (`make study`)."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from metrology.batch import workers

sys.path.insert(0, str(Path(__file__).parents[2] / "studies"))


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    from diagnosis import study, tasks
    from judging import bars

    kept = tmp_path_factory.mktemp("study") / "rows.jsonl"
    return bars(study(list(tasks(10, 100)), workers.local(os.cpu_count() or 1), kept))


@pytest.mark.study
def test_planted_effects_of_every_kind_meet_the_bars(judged):
    """A bar is missed where a true share as required would give so low a count in under one study of a hundred."""
    missed = [f"{bar.name}: {bar.right} of {bar.of}, required {bar.at_least:.0%}" for bar in judged if not bar.possible]
    assert missed == []
