"""From a campaign file to findings: what tests share, what certificates say, and what a failure leaves standing."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError

HEAD = """\
format: metrology-campaign/1
id: small
title: Small
"""
SAMPLE = """\
samples:
  wire: {section: {shape: round, diameter: 0.500(2) mm}, length: 2.000(1) m}
"""
INDICATOR = """\
instruments:
  indicator: {kind: dial indicator, resolution: 0.01 mm}
"""
READINGS = """\
load,repeat,direction,reading / mm
A,1,loading,0.49
B,1,loading,0.97
C,1,loading,1.47
A,2,loading,0.48
B,2,loading,0.98
C,2,loading,1.46
A,3,loading,0.49
B,3,loading,0.98
C,3,loading,1.47
"""


def pull(name: str, *, gravity: str = "9.8065(3) m/s^2", indicator: str = "indicator") -> str:
    return f"""\
  {name}:
    method: elongation
    sample: wire
    instruments: {{extension: {indicator}}}
    gravity: {gravity}
    loads: {{A: {{mass: 1.0000(1) kg}}, B: {{mass: 2.0000(1) kg}}, C: {{mass: 3.0000(2) kg}}}}
    readings: wire.csv
"""


@pytest.fixture
def found(tmp_path):
    def evaluate(*parts: str):
        (tmp_path / "wire.csv").write_text(READINGS)
        (tmp_path / "campaign.yaml").write_text(HEAD + "".join(parts))
        return chain.evaluate(load(tmp_path / "campaign.yaml"))

    return evaluate


def results(findings):
    return {result.name: result for result in findings.results}


def correlation(findings, a, b):
    return next((entry.coefficient for entry in findings.correlations if {entry.a, entry.b} == {a, b}), 0.0)


@pytest.mark.long
def test_law_each_test_is_evaluated_with_the_gravity_that_it_states(found):
    tests = "tests:\n" + pull("here") + pull("there", gravity="{value: 4.90325(15) m/s^2, source: half of it}")
    k = results(found(INDICATOR, SAMPLE, tests))
    assert k["there.k"].framework.value == pytest.approx(k["here.k"].framework.value / 2, rel=1e-12)


@pytest.mark.long
def test_law_tests_that_state_the_same_gravity_share_it(found):
    loose = "9.81(10) m/s^2"
    tests = "tests:\n" + pull("first") + pull("second", gravity=loose) + pull("third", gravity=loose)
    findings = found(INDICATOR, SAMPLE, tests)
    assert correlation(findings, "second.k", "third.k") > 0.7
    assert correlation(findings, "first.k", "second.k") < 0.1


@pytest.mark.long
def test_closed_form_a_certificate_that_states_a_share_acts_on_all_extensions_alike(found):
    certificate = "{number: C, date: 2026-01-01, expanded_uncertainty: 10 %, k: 2}"
    rough = f"  rough: {{kind: dial indicator, resolution: 0.01 mm, certificate: {certificate}}}\n"
    k = results(found(INDICATOR, rough, SAMPLE, "tests:\n" + pull("fine") + pull("coarse", indicator="rough")))
    fine, coarse = k["fine.k"], k["coarse.k"]
    known = fine.framework
    assert coarse.framework.u**2 == pytest.approx(known.u**2 + (0.05 * known.value) ** 2, rel=1e-9)
    assert {row.input for row in coarse.budget} - {row.input.replace("fine", "coarse") for row in fine.budget} == {
        "rough.scale"
    }


QUANTITIES = "quantities: {p: -1.0(1), r: 2.0(1)}\nderived:\n  - {quantity: root, expression: sqrt(p)}\n"


def test_planted_failure_of_one_quantity_is_told_and_leaves_the_others_standing(found):
    findings = found(
        QUANTITIES,
        "  - {quantity: twice, expression: 2*r}\n",
        "requirements:\n",
        "  - {id: R1, quantity: root, limits: {lower: 0.5}, decision: {rule: guard band}}\n",
        "  - {id: R2, quantity: twice, limits: {lower: 0.5}, decision: {rule: guard band}}\n",
        "comparisons: [{title: root against r, between: [root, r]}]\n",
        "audit:\n",
        "  - {figure: the root, quantity: root, published: 1.0}\n",
        "  - {figure: a quotient, expression: r/(p - p), published: 1.0}\n",
    )
    assert results(findings)["twice"].value == 4.0
    assert [(entry.requirement, entry.verdict) for entry in findings.conformity] == [("R2", "pass")]
    assert (findings.comparisons, findings.audit) == ((), ())
    assert [sentence.split(".")[0] for sentence in findings.failures] == [
        "root has no value",
        "root against r cannot be made, for want of a result",
        "Requirement R1 cannot be judged, for want of root",
        "the root cannot be recomputed",
        "a quotient cannot be recomputed",
    ]
    assert "sqrt of -1" in findings.failures[0]


def test_limit_no_interval_where_the_equation_has_no_value_for_some_of_the_draws(found):
    """√(p² − r²) has a value and a u at the estimates, but none for two of five draws."""
    findings = found(
        "quantities: {p: 1.00(3), r: 0.99(3)}\nderived: [{quantity: root, expression: sqrt(p**2 - r**2)}]\n",
        "requirements: [{id: R1, quantity: root, limits: {upper: 1}, decision: {rule: simple acceptance}}]\n",
    )
    assert findings.conformity == ()
    (sentence,) = [one for one in findings.warnings if one.startswith("root ")]
    assert sentence.startswith("root has no interval, and no verdict rests on it.")
    assert not [one for one in findings.warnings if "the Monte Carlo interval is reported" in one]


def test_limit_no_verdict_where_the_law_has_no_derivative(found):
    findings = found(
        "quantities: {p: 0.0(1)}\nderived: [{quantity: root, expression: sqrt(p)}]\n",
        "requirements: [{id: R1, quantity: root, limits: {upper: 1}, decision: {rule: simple acceptance}}]\n",
    )
    assert findings.conformity == ()
    assert [sentence.split(".")[0] for sentence in findings.failures] == [
        "root has no uncertainty by the GUM uncertainty framework",
        "Requirement R1 cannot be judged, for want of root",
    ]


@pytest.mark.long
def test_twice_without_a_static_stiffness_c_takes_that_of_the_oscillation(found, tmp_path):
    files = [f"al-1100-decay-{number}.csv" for number in (1, 2, 3)]
    for file in files:
        shutil.copy(Path(__file__).parents[1] / "campaigns" / "tapes" / file, tmp_path)
    test = f"{{method: decay, sample: s, instruments: {{displacement: v}}, mass: 1.196(1) kg, readings: {files}}}"
    findings = found(f"instruments: {{v: {{kind: vibrometer}}}}\nsamples: {{s: {{}}}}\ntests:\n  free: {test}\n")
    x = {name: result.framework.value for name, result in results(findings).items()}
    assert x["free.c"] == pytest.approx(2 * x["free.zeta"] * 1.196 * x["free.omega_n"], rel=1e-12)
    assert findings.failures == ()


def test_refusal_a_correction_by_a_fit_that_failed(found):
    corrected = INDICATOR.replace("0.01 mm}", "0.01 mm, correction: {fit: cal}}")
    cal = """\
fits:
  cal:
    x: {values: [0, 1, 2, 3, 4], unit: mm}
    y: {values: [0, 0.001, 0.001, 0.002, 0.003], unit: mm}
    model: {expression: a + b + d*x, start: {a: 1 mm, b: 1 mm, d: "0.1"}}
"""
    with pytest.raises(MetrologyError) as refusal:
        found(corrected, SAMPLE, cal, "tests:\n" + pull("pull"))
    (fault,) = refusal.value.faults
    assert fault.where.endswith("instruments.indicator.correction.fit")
    assert fault.got == "fit 'cal', which failed"
    assert "do not distinguish the parameters" in fault.fix
