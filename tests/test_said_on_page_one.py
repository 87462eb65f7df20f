"""What a reader must know before he believes a verdict: what was accepted, what validates nothing, what cannot be."""

from __future__ import annotations

from dataclasses import asdict
from math import inf
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from laboratory import METHODS

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError
from metrology.gum.conformity import decide
from metrology.gum.guard_bands import Rule
from metrology.gum.output import Analytic
from metrology.gum.risk import Limits
from metrology.report.limits import acceptance

TILTED = """\
format: metrology-campaign/1
id: bowed
title: A line that is not straight
diagnosis: {off: true}
instruments: {dial: {kind: dial, resolution: 1 um}}
samples: {wire: {}}
tests:
  e:
    method: elongation
    sample: wire
    instruments: {extension: dial}
    gravity: 9.81 m/s^2
    loads: {a: {mass: 1 kg}, b: {mass: 2 kg}, c: {mass: 3 kg}, d: {mass: 4 kg}, e: {mass: 5 kg}}
    readings: r.csv
    accepted: [ACCEPTED]
requirements:
  - {id: R, quantity: e.k, limits: {lower: 1 N/m}, decision: {rule: simple acceptance}}
"""


def bowed(folder: Path, accepted: str) -> Path:
    """Readings of a line that bends far beyond their scatter."""
    rng = np.random.default_rng(2)
    rows = [f"{name},{repeat},{mass + 0.2 * mass**2 + 0.001 * rng.standard_normal():.3f}"
            for repeat in (1, 2, 3) for mass, name in enumerate("abcde", 1)]  # fmt: skip
    (folder / "r.csv").write_text("\n".join(["load,repeat,reading / mm", *rows]) + "\n", encoding="utf-8")
    path = folder / "campaign.yaml"
    path.write_text(TILTED.replace("ACCEPTED", accepted), encoding="utf-8")
    return path


def test_law_what_is_accepted_is_said_with_its_person_and_reason(tmp_path):
    plain = chain.evaluate(load(bowed(tmp_path, "")), coverage=False)
    (withheld,) = plain.withheld
    failed = [check.name for check in plain.tests[0].finding.checks if check.passed is False]
    given = ", ".join(f"{{check: {name}, reason: known of such wire, by: A. Smith}}" for name in failed)
    found = chain.evaluate(load(bowed(tmp_path, given)), coverage=False)
    assert withheld.reasons
    assert [one.verdict for one in found.conformity] == ["pass"]
    told = [
        notice.sentence for notice in found.notices if "Accepted by A. Smith: known of such wire" in notice.sentence
    ]
    assert len(told) == len(found.conformity[0].accepted) > 0
    twice = f"{given}, {{check: {failed[0]}, reason: another one, by: B. Jones}}"
    with pytest.raises(MetrologyError, match="a second time"):
        load(bowed(tmp_path, twice))


@pytest.mark.parametrize("held_out", [True, False])
def test_law_a_model_without_a_run_left_out_is_said_to_be_unvalidated(held_out, tmp_path):
    work = METHODS["response"](np.random.default_rng(7))
    work.campaign["diagnosis"] = {"off": True}
    runs = work.campaign["tests"]["ride"]["runs"]
    if not held_out:
        for run in runs.values():
            run["purpose"] = "identification"
    found = chain.evaluate(load(work.write(tmp_path)), coverage=False)
    assert any("was kept out of the fit" in one for one in found.warnings) is not held_out


@pytest.mark.parametrize("rule", [Rule("guard band"), Rule("guard band", binary=True)])
def test_limit_acceptance_limits_that_cross_are_none(rule):
    decision = decide(Analytic(0.0, 4.0, inf), limits=Limits(-1.0, 1.0), rule=rule)
    assert (decision.acceptance_lower, decision.acceptance_upper) == (None, None)
    stated = {"lower": -1.0, "upper": 1.0, "lower_stated": "", "upper_stated": "", "display_unit": "N"}
    entry = SimpleNamespace(**asdict(decision), **stated)
    assert acceptance(entry) == "–"


def test_refusal_a_correlation_that_no_distributions_have_names_its_line(tmp_path):
    path = tmp_path / "campaign.yaml"
    path.write_text(
        "format: metrology-campaign/1\nid: c\ntitle: Correlation\nquantities:\n"
        "  a: {value: 10 mm, uncertainty: [{half_width: 1 um, distribution: arcsine}]}\n"
        "  b: {value: 10 mm, uncertainty: [{half_width: 1 um, distribution: rectangular}]}\n"
        "correlations:\n  - {between: [a, b], coefficient: 0.999}\n"
        "derived:\n  - {quantity: s, expression: a + b, unit: mm}\n",
        encoding="utf-8",
    )
    with pytest.raises(MetrologyError, match=r"campaign\.yaml:7:1 correlations: got r = 0\.999"):
        chain.evaluate(load(path), coverage=False)
