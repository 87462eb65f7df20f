"""Rate of the clock of a response and a decay: what is said of it is what stamps of another rate do to the results."""

from __future__ import annotations

import copy
from math import sqrt
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
    both = {**work.campaign["tests"]["ride"]["known"], **known}
    work.campaign["tests"]["ride"]["known"] = {key: spread for key, spread in both.items() if spread}
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
@pytest.mark.parametrize("mass", [None, {"common": "0.1 %"}])
def test_twice_a_rate_of_which_nothing_is_stated_is_listed_with_the_u_that_matters(
    mass: dict | None, tmp_path: Path
) -> None:
    """Also where the mass, of which the rate is a share in the time of the clock, is not known exactly itself."""
    work = stated(mass=mass)
    found = chain.evaluate(load(work.write(tmp_path)), coverage=False)
    other, plain = results(slower(work), tmp_path), {one.name: one for one in found.results}
    (rate,) = [one for one in found.exact if one.name == "ride.clock rate"]
    before = plain[rate.result]
    slope = (other[rate.result.removeprefix("ride.")].framework.value - before.framework.value) / RATE
    assert rate.u == pytest.approx(sqrt(0.21) * before.u / abs(slope), rel=0.05)
    assert any("error of the rate of the clock" in one and "omega_n" not in one for one in found.warnings)
    known = chain.evaluate(load(stated(clock_rate={"common": "0.1 %"}).write(tmp_path)), coverage=False)
    assert "ride.clock rate" not in {one.name for one in known.exact}


def swing(folder: Path, *, slower: float = 0.0, own: bool = True, **stated: object):
    work = METHODS["decay"](np.random.default_rng(3))
    work.campaign.update(diagnosis={"off": True}, monte_carlo={"digits": 1, "max_trials": 20_000})
    work.campaign["tests"]["swing"] |= stated
    if own:
        del work.campaign["tests"]["swing"]["stiffness"]
    for name in work.raw:
        work.tables[name]["time / s"] = [time * (1 + slower) for time in work.tables[name]["time / s"]]
    return chain.evaluate(load(work.write(folder)), coverage=False)


def of_swing(found) -> dict:
    return {one.name.removeprefix("swing."): one for one in found.results if one.name.startswith("swing.")}


@pytest.mark.long
@pytest.mark.parametrize("own", [True, False])
def test_closed_form_the_rate_of_a_decay_corrects_its_stamps_and_is_a_row_of_its_budget(
    own: bool, tmp_path: Path
) -> None:
    """A clock of which each second lasts 1 + δ: k = m·ω² falls by 2δ, with c where that is its k."""
    found = of_swing(swing(tmp_path, own=own, clock_rate="0.1(1) %"))
    true = of_swing(swing(tmp_path, own=own, slower=1e-3))
    for name, power in {"omega_n": 1, "k": 2, "zeta": 0, "c": 1 if own else 0}.items():
        assert found[name].framework.value == pytest.approx(true[name].framework.value, rel=1e-6), name
        budget = {row.input: abs(row.contribution) for row in found[name].budget}
        expected = power * 1e-3 / 1.001 * found[name].framework.value
        assert budget.get("swing.clock rate", 0.0) == pytest.approx(expected, rel=1e-6), name


@pytest.mark.long
def test_closed_form_the_rate_of_a_decay_of_which_nothing_is_stated_is_listed(tmp_path: Path) -> None:
    found = swing(tmp_path)
    (rate,) = [one for one in found.exact if one.name == "swing.clock rate"]
    most = {name: abs(one.u / one.framework.value) / power
            for name, power in {"omega_n": 1, "k": 2, "c": 1}.items() for one in [of_swing(found)[name]]}  # fmt: skip
    assert rate.u == pytest.approx(sqrt(0.21) * min(most.values()), rel=1e-6)
    (sentence,) = [one for one in found.warnings if "taken as exact" in one and one.startswith("swing")]
    assert sentence.endswith("State it with an uncertainty: clock_rate: 0(50) ppm.")
    assert not [one for one in swing(tmp_path, clock_rate="0(50) ppm").exact if one.name == "swing.clock rate"]


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
