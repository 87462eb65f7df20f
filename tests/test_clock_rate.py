"""Rate of the clock of a response test: its budget row is what stamps of another rate do to the results."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest
from laboratory import METHODS, Work

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError

RATE = 1e-3


def stated(**known: object) -> Work:
    work = METHODS["response"](np.random.default_rng(7))
    work.campaign["diagnosis"] = {"off": True}
    work.campaign["monte_carlo"] = {"digits": 1, "max_trials": 20_000}
    work.campaign["tests"]["ride"]["known"] = {**work.campaign["tests"]["ride"]["known"], **known}
    return work


def slower(work: Work) -> Work:
    """The same with stamps in true time, where a second of the clock lasts 1 + δ; so are speeds and thrust."""
    changed = copy.deepcopy(work)
    for table in changed.tables.values():
        table["time / s"] = [time * (1 + RATE) for time in table["time / s"]]
        if "v / m/s" in table:
            table["v / m/s"] = [speed / (1 + RATE) for speed in table["v / m/s"]]
    for run in changed.campaign["tests"]["ride"]["runs"].values():
        for part in run["thrust"]:
            part |= {key: f"{float(part[key].split()[0]) * (1 + RATE):.9g} s" for key in ("from", "to") if key in part}
    return changed


def results(work: Work, folder: Path) -> dict:
    found = chain.evaluate(load(work.write(folder)), coverage=False)
    return {one.name.removeprefix("ride."): one for one in found.results}


@pytest.mark.long
def test_twice_the_budget_row_of_the_rate_against_stamps_of_another_rate(tmp_path: Path) -> None:
    work = stated(clock_rate={"common": "0.1 %"})
    found, other = results(work, tmp_path), results(slower(work), tmp_path)
    plain = results(stated(), tmp_path)
    for name in ("k", "c", "omega_n"):
        budget = {row.input: row.contribution for row in found[name].budget}
        moved = other[name].framework.value - found[name].framework.value
        assert budget["ride.clock rate"] == pytest.approx(moved, rel=0.02), name
        assert found[name].framework.u > plain[name].framework.u
    assert abs(found["k"].framework.value - plain["k"].framework.value) < found["k"].framework.u
    assert found["omega_n"].framework.u / found["omega_n"].framework.value == pytest.approx(RATE, rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize(
    ("known", "free", "told"),
    [
        ({"clock_rate": {"common": "0.1 %", "per_run": "0.1 %"}}, ["k", "c"], "'common' alone"),
        ({"clock_rate": {"common": "1 ms"}}, ["k", "c"], "clock_rate"),
        ({"clock_rate": {"common": "0.1 %"}}, ["k", "c", "mass.factor"], "where the mass is sought"),
    ],
)
def test_refusal_of_a_rate_that_no_record_tells(known: dict, free: list[str], told: str, tmp_path: Path) -> None:
    work = stated(**known)
    work.campaign["tests"]["ride"]["identification"]["free"] = free
    with pytest.raises(MetrologyError, match=told):
        load(work.write(tmp_path))
