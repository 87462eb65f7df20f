"""A diagnosis that explains the readings by an input that is not as stated: the result is shown, and not judged."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from laboratory import METHODS

from metrology import chain
from metrology.campaign.load import load
from metrology.diagnostics.refuted import refuted
from metrology.estimation import Prior


@pytest.mark.long
@pytest.mark.parametrize("accepted", [False, True])
def test_planted_a_wrong_mass_that_a_diagnosis_names_is_not_judged_unless_accepted(
    accepted: bool, tmp_path: Path
) -> None:
    """Of mass, thrust and gains only what is stated fixes the scale of k: one that is refuted fixes nothing."""
    work = METHODS["response"](np.random.default_rng(7))
    work.campaign["tests"]["ride"]["rig"]["mass"] = "27.5 kg"
    work.campaign["monte_carlo"] = {"digits": 1, "max_trials": 20_000}
    if accepted:
        why = {"check": "stated inputs", "reason": "the thrusters were calibrated anew", "by": "A. Smith"}
        work.campaign["tests"]["ride"]["accepted"] = [why]
    found = chain.evaluate(load(work.write(tmp_path)), coverage=False)
    (diagnosis,) = found.diagnosis
    reasons = " ".join(reason for one in found.withheld for reason in one.reasons)
    assert (diagnosis.verdict, diagnosis.refuted) == ("explained", ("mass.factor",))
    assert ("The extended model of ride moves mass.factor" in reasons) is not accepted
    assert any("The extended model of ride moves mass.factor" in one for one in found.warnings)
    assert accepted or not any(one.verdict == "pass" for one in found.conformity)


@pytest.mark.parametrize(("more", "told"), [(-1e6, []), (-2.0, ["mass.factor"]), (1.0, ["mass.factor"])])
def test_law_what_a_far_worse_model_moves_refutes_nothing(more: float, told: list[str]) -> None:
    """A model that was tried in the place of the best one, as a drag in that of a quadratic one, may end anywhere."""

    def fit(moved: float) -> SimpleNamespace:
        entry = SimpleNamespace(name="mass.factor", mean=1.0)
        return SimpleNamespace(problem=SimpleNamespace(unknowns=[entry]), values={"mass.factor": 1.0 + moved})

    judged = SimpleNamespace(last=fit(1e-4), exchanged={("quadratic drag", "drag"): (fit(0.3), more)})
    assert list(refuted(judged, [Prior("mass.factor", 1e-3)])) == told  # type: ignore[arg-type]
