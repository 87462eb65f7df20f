"""A diagnosis that explains the readings by an input that is not as stated: the result is shown, and not judged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from laboratory import METHODS

from metrology import chain
from metrology.campaign.load import load


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
