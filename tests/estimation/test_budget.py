import json
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
from response_cases import PRIORS, runs_of, stated, truth_of

from metrology import gum
from metrology.estimation import finding, fit, knowns, paper_way
from metrology.estimation.budget import shares
from metrology.gum.inputs import Knowledge


@pytest.fixture(scope="module")
def found():
    return fit(stated("nylon"), runs_of(truth_of("nylon"), 11), priors=PRIORS)


@pytest.fixture(scope="module")
def evaluated(found):
    model = knowns(found.joint, found.rig, "nylon-response")
    known = Knowledge({entry.name: entry for entry in model.inputs}, model.ensembles)
    return gum.evaluate(model.measurands, known, seed=1, max_trials=100_000)


def test_twice_fit_against_law_of_propagation(found, evaluated):
    for name in ("k", "c", "mass.factor", "thrust.gain"):
        estimate = evaluated.estimates[f"nylon-response.{name}"]
        assert estimate.value == pytest.approx(found.value(name), rel=1e-12)
        assert estimate.u == pytest.approx(found.u(name), rel=1e-9)


def test_twice_correlation_survives(found, evaluated):
    names = evaluated.names
    at = names.index("nylon-response.k"), names.index("nylon-response.c")
    assert evaluated.correlation[at[0]][at[1]] == pytest.approx(found.correlation("k", "c"), abs=1e-9)


def test_closed_form_damping_ratio_and_frequency(found, evaluated):
    mass = 25.0 * found.value("mass.factor")
    zeta, omega = (evaluated.estimates[f"nylon-response.{name}"] for name in ("zeta", "omega_n"))
    assert omega.value == pytest.approx(np.sqrt(found.value("k") / mass), rel=1e-12)
    assert zeta.value == pytest.approx(found.value("c") / (2 * np.sqrt(found.value("k") * mass)), rel=1e-12)
    assert 0.061 < zeta.value < 0.063


def test_law_budget_rows_add_up(evaluated):
    budget = evaluated.estimates["nylon-response.k"].budget
    assert sum(row.share for row in budget) == pytest.approx(1.0)
    assert {"nylon-response.mass.factor.stated", "nylon-response.thrust.gain.stated"} <= {row.input for row in budget}


def test_law_finding_is_plain_json(found):
    told = finding(found, ("nylon", "nylon-response"), paper_way(stated("nylon"), found.runs))
    again = json.loads(json.dumps(asdict(told), allow_nan=False))
    assert again["parameters"][0]["name"] == "k"
    assert again["paper"]["status"] == "ok"
    assert len(again["correlation"]) == len(again["names"])


def test_limit_an_estimate_that_a_bound_holds_has_no_shares() -> None:
    """No cause moves it, so none has a part of its variance."""
    sources = (SimpleNamespace(name="readings", kind="readings", columns=np.array([[2.0], [0.0]])),)
    found = SimpleNamespace(layout=SimpleNamespace(index=["k", "zener.time"].index), sources=sources)
    assert shares(found, "k") == {"readings": 1.0}
    assert shares(found, "zener.time") == {}
