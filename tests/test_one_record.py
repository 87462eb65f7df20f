"""One record that stands for two measurements in a quantity that is derived from them."""

from __future__ import annotations

import copy
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from laboratory import METHODS, Work

from metrology import chain
from metrology.campaign.load import load
from metrology.findings import to_json


def pulled(seed: int = 4) -> Work:
    """Dead loads on a tape, one requirement on k."""
    work = METHODS["elongation"](np.random.default_rng(seed))
    work.campaign.update(diagnosis={"off": True}, monte_carlo={"digits": 1, "max_trials": 20_000})
    return work


def mean_of(work: Work, folder: Path, a: str, b: str, **more: object) -> list[str]:
    """Why the mean of two results is not judged."""
    meaning = {"a": a, "b": b}
    derived = {"quantity": "K", "expression": "(a + b)/2", "where": meaning, "unit": "N/m"}
    limits = {"lower": f"{0.5 * work.truth['pull.k']} N/m"}
    rule = {"id": "M", "text": "mean", "quantity": "K", "limits": limits, "decision": {"rule": "guard band"}}
    work.campaign.update(derived=[derived], requirements=[rule], **more)
    found = chain.evaluate(load(work.write(folder)), coverage=False)
    assert bool(found.withheld) is not any(one.requirement == "M" and one.verdict == "pass" for one in found.conformity)
    return [reason for one in found.withheld for reason in one.reasons]


@pytest.mark.long
@pytest.mark.parametrize("again", [True, False])
def test_planted_two_tests_of_one_record_are_no_two_measurements(again: bool, tmp_path: Path) -> None:
    work = pulled()
    second = copy.deepcopy(work.campaign["tests"]["pull"])
    if not again:
        second["readings"] = "other.csv"
        table = work.tables["elongation.csv"]
        noise = np.random.default_rng(5).normal(0.0, 2e-3, len(table["load"]))
        work.tables["other.csv"] = {**table, "reading / mm": (np.array(table["reading / mm"]) + noise).tolist()}
    work.campaign["tests"]["again"] = second
    found = mean_of(work, tmp_path, "pull.k", "again.k")
    assert found == (["again, pull evaluate one record, which is taken for two."] if again else [])


@pytest.mark.long
@pytest.mark.parametrize("own", [True, False])
def test_planted_a_result_of_another_campaign_that_read_the_same_file(own: bool, tmp_path: Path) -> None:
    work, folder = pulled(), tmp_path / "mean"
    folder.mkdir()
    entries = {}
    for at, seed in enumerate((4, 4) if not own else (4,)):
        one = pulled(seed)
        one.campaign["id"] = f"A-{at}"
        (tmp_path / f"{at}").mkdir()
        raw = to_json(chain.evaluate(load(one.write(tmp_path / f"{at}")), coverage=False))
        (folder / f"k{at}.json").write_bytes(raw)
        entries[f"k{at}"] = {"from": f"k{at}.json", "result": "pull.k", "sha256": sha256(raw).hexdigest()}
    reasons = mean_of(work, folder, "k0", "pull.k" if own else "k1", quantities=entries)
    assert len(reasons) == 1
    assert "rests on the file elongation.csv, and so does" in reasons[0]
