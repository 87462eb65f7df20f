"""No requirement passes on what a fit, its own report, a reference or a prior has refuted; and all of it is said."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import date
from hashlib import sha256
from math import erf, sqrt
from pathlib import Path

import numpy as np
import pytest

from metrology import chain
from metrology.campaign import days
from metrology.campaign.load import load
from metrology.findings import Assumption, from_json, to_json
from metrology.language import done, wording
from metrology.language.attention import attention
from metrology.language.catalogue import ENGLISH
from metrology.language.notices import _first, brief, said_anyway
from metrology.language.wording import by_name

HEAD = "format: metrology-campaign/1\nid: W\ntitle: What is refuted\n"


def evaluated(folder: Path, text: str, name: str = "campaign.yaml"):
    (folder / name).write_text(HEAD + text)
    return chain.evaluate(load(folder / name), coverage=False)


def told(findings) -> str:
    """The warnings, each of which page 1 has too; its table marks what Monte Carlo does not confirm."""
    page, called = {sentence for _, sentence in brief(findings)}, done.called(findings, ENGLISH)
    for one in findings.warnings:
        assert said_anyway(one, findings) or _first(by_name(wording.prose(one), called)) in page, one
    return " ".join(findings.warnings)


def judged(findings) -> dict[str, str]:
    return {one.requirement: one.verdict for one in findings.conformity}


def why(findings, requirement: str) -> str:
    (found,) = [one for one in findings.withheld if one.requirement == requirement]
    return " ".join(found.reasons)


# Results of another campaign.

SOURCE = """\
quantities: {x: 24.0(1) N, y: 1.00(1) mm}
derived: [{quantity: k, expression: x/y, unit: kN/m}, {quantity: other, expression: 2*y, unit: mm}]
comparisons: [{between: [k, {value: 20.0(1) kN/m, source: handbook}]}]
"""
USE = """\
quantities:
  k: {{from: r.json, result: {result}, sha256: {sha}}}
  one: 1.0000(1)
derived: [{{quantity: F, expression: k*one, unit: {unit}}}]
requirements: [{{id: R, quantity: F, limits: {{{limits}}}, decision: {{rule: {rule}}}}}]
"""


def used(folder: Path, findings, *, result="k", unit="kN/m", limits="lower: 1 kN/m", rule="guard band"):
    raw = to_json(findings)
    (folder / "r.json").write_bytes(raw)
    text = USE.format(result=result, unit=unit, sha=sha256(raw).hexdigest(), limits=limits, rule=rule)
    return evaluated(folder, text)


def test_planted_an_imported_result_that_its_report_does_not_judge_is_not_judged_here(tmp_path):
    source = evaluated(tmp_path, SOURCE, "source.yaml")
    assert [bool(one.doubts) for one in source.results] == [True, False]
    findings = used(tmp_path, source)
    assert judged(findings) == {}
    assert "k of W is not judged in its own report: k and handbook contradict each other" in why(findings, "R")
    assert "k of W is not judged in its own report" in told(findings)
    # What follows from it is not judged either, however many reports lie between.
    again = used(tmp_path, findings, result="F")
    assert "F of W is not judged in its own report" in why(again, "R")


def test_limit_an_imported_result_that_its_report_judges_passes(tmp_path):
    source = evaluated(tmp_path, SOURCE, "source.yaml")
    findings = used(tmp_path, source, result="other", unit="mm", limits="lower: 1 mm")
    assert judged(findings) == {"R": "pass"}
    assert "own report" not in told(findings)


def test_law_of_an_older_file_the_withheld_verdicts_are_read(tmp_path):
    source = evaluated(
        tmp_path,
        SOURCE + "requirements: [{id: Q, quantity: k, limits: {lower: 1 kN/m}, decision: {rule: guard band}}]\n",
        "source.yaml",
    )
    document = json.loads(to_json(source))
    for one in document["results"]:
        del one["doubts"]
    (tmp_path / "r.json").write_text(json.dumps(document))
    sha = sha256((tmp_path / "r.json").read_bytes()).hexdigest()
    text = USE.format(result="k", unit="kN/m", sha=sha, limits="lower: 1 kN/m", rule="guard band")
    assert "contradict each other" in why(evaluated(tmp_path, text), "R")


SKEWED = """\
quantities: {x: {value: 1.00 mm, uncertainty: [{standard: 0.50 mm, distribution: exponential, source: wear}]}}
derived: [{quantity: X, expression: 1*x, unit: mm}]
"""


@pytest.mark.parametrize(("limit", "verdict"), [("2.4 mm", None), ("9 mm", "pass"), ("0.2 mm", "conditional fail")])
def test_closed_form_a_skewed_result_passes_only_where_no_distribution_could_fail(limit, verdict, tmp_path):
    """Beyond 2.4 mm lies e^-3.8 = 2.2 % of it, and 0.26 % of the normal one; beyond 16 u no more than 1/16² of any."""
    assert 0.5 * (1 - erf(2.8 / sqrt(2))) < 0.01 < np.exp(-3.8)
    source = evaluated(tmp_path, SKEWED, "source.yaml")
    options = {"result": "X", "unit": "mm", "limits": f"upper: {limit}", "rule": "specific risk, risk: 0.01"}
    findings = used(tmp_path, source, **options)
    assert judged(findings).get("R") == verdict
    assert "its distribution is not carried over" in told(findings)
    if verdict is None:
        assert "513 µm to 2.35 mm" in why(findings, "R")


def test_limit_shapes_that_are_carried_over_are_no_loss(tmp_path):
    text = SKEWED.replace("exponential", "rectangular")
    source = evaluated(tmp_path, text, "source.yaml")
    assert not source.results[0].monte_carlo.law_valid
    findings = used(tmp_path, source, result="X", unit="mm", limits="upper: 2.4 mm")
    assert judged(findings) == {"R": "pass"}
    assert "carried over" not in told(findings)


# Fits.

FIT = """\
fits:
  bad:
    x: {{values: [1, 2, 3, 4, 5, 6, 7, 8], unit: mm}}
    y: {{values: [0.52, 0.98, 1.53, 1.97, 2.52, 2.98, 3.53, {last}], unit: N}}
    u_y: {{value: 0.001 N}}
    scatter: {scatter}
{more}derived: [{{quantity: S, expression: s*2, where: {{s: bad.slope}}, unit: N/mm}}]
requirements:
  - {{id: R1, quantity: bad.slope, limits: {{upper: 0.6 N/mm}}, decision: {{rule: guard band}}}}
  - {{id: R2, quantity: S, limits: {{upper: 1.2 N/mm}}, decision: {{rule: guard band}}}}
"""


def test_planted_what_follows_from_a_refuted_fit_is_not_judged(tmp_path):
    findings = evaluated(tmp_path, FIT.format(last=3.97, scatter="stated", more=""))
    assert judged(findings) == {}
    assert "refute its stated uncertainties (p < 10⁻⁶)" in why(findings, "R1")
    assert "refute its stated uncertainties" in why(findings, "R2")
    assert "the data scatter more than stated" in told(findings)


def test_law_a_refuted_fit_is_accepted_by_a_person_with_a_reason(tmp_path):
    more = "    accepted: {reason: far from the limit, by: A. Smith}\n"
    findings = evaluated(tmp_path, FIT.format(last=3.97, scatter="stated", more=more))
    assert judged(findings) == {"R1": "pass", "R2": "pass"}
    assert all("Accepted by A. Smith: far from the limit." in one.accepted[0] for one in findings.conformity)


def test_limit_a_fit_whose_uncertainties_are_scaled_is_judged(tmp_path):
    findings = evaluated(tmp_path, FIT.format(last=3.97, scatter="scaled", more=""))
    assert judged(findings) == {"R1": "pass", "R2": "pass"}


PREDICT = """\
fits:
  cal:
    x: {values: [1, 2, 3, 4, 5, 6, 7, 8], unit: mm}
    y: {values: [0.52, 0.98, 1.53, 1.97, 2.52, 2.98, 3.53, 3.97], unit: N}
    predict: [{name: far, x: 100 mm}, {name: near, x: 8 mm}, {name: back, y: 6.0(1) N}, {name: inside, y: 2.0(1) N}]
"""


def test_planted_extrapolation_is_said_with_the_range_of_the_data(tmp_path):
    text = told(evaluated(tmp_path, PREDICT))
    assert "cal.far is an extrapolation: the fit is used at 100.0 mm, and its data reach from 1.000 mm to 8.000" in text
    assert "cal.back is an extrapolation" in text
    assert "cal.near is an" not in text
    assert "cal.inside is an" not in text


# References.

KNOWN = """\
quantities: {{a: 10.00(5) N, b: 2.00(1) mm}}
derived:
  - {{quantity: {name}, expression: a/b, unit: N/mm}}
  - {{quantity: after, expression: 3*{name}, unit: N/mm}}
comparisons: [{{between: [{name}, {{value: {known} N/mm, source: certificate}}]{more}}}]
requirements:
  - {{id: R1, quantity: {name}, limits: {{lower: 4 N/mm}}, decision: {{rule: guard band}}}}
  - {{id: R2, quantity: after, limits: {{lower: 12 N/mm}}, decision: {{rule: guard band}}}}
  - {{id: R3, quantity: {name}, limits: {{lower: 6 N/mm}}, decision: {{rule: guard band}}}}
"""


@pytest.mark.parametrize(
    ("name", "known", "withheld"),
    [("S", "5.02(3)", set()), ("S", "5.5(1)", {"R1", "R2"}), ("S", "5000(1)", {"R1", "R2", "R3"})],
)
def test_planted_a_derived_quantity_does_not_pass_against_its_own_reference(name, known, withheld, tmp_path):
    """Beyond |E_n| = 1 a fail stands; a value of another order is no basis of either verdict."""
    findings = evaluated(tmp_path, KNOWN.format(name=name, known=known, more=""))
    assert {one.requirement for one in findings.withheld} == withheld
    assert all("and certificate contradict each other" in why(findings, one) for one in withheld)
    if "R3" not in withheld:
        assert judged(findings)["R3"] == "fail"


def test_limit_a_handbook_value_of_the_material_is_of_another_specimen(tmp_path):
    findings = evaluated(tmp_path, KNOWN.format(name="E", known="5.5(1)", more=""))
    assert judged(findings) == {"R1": "pass", "R2": "pass", "R3": "fail"}
    assert "they differ" in told(findings)
    findings = evaluated(tmp_path, KNOWN.format(name="E", known="12.0(1)", more=""))
    assert judged(findings) == {}


def test_law_a_contradiction_is_accepted_by_a_person_with_a_reason(tmp_path):
    more = ", accepted: {reason: another batch, by: A. Smith}"
    findings = evaluated(tmp_path, KNOWN.format(name="S", known="5.5(1)", more=more))
    assert judged(findings) == {"R1": "pass", "R2": "pass", "R3": "fail"}
    assert "Accepted by A. Smith: another batch." in findings.conformity[0].accepted[0]


SAMPLES = """\
instruments: {{ind: {{kind: indicator, resolution: 0.01 mm}}}}
samples:
  a: {{section: {{shape: round, diameter: 0.500(2) mm}}, length: 2.000(1) m{of_a}}}
  b: {{section: {{shape: round, diameter: 0.500(2) mm}}, length: 2.000(1) m{of_b}}}
tests:
  ea: {{method: elongation, sample: a, instruments: {{extension: ind}}, gravity: 9.8060(5) m/s^2, loads: {loads}, readings: a.csv}}
  eb: {{method: elongation, sample: b, instruments: {{extension: ind}}, gravity: 9.8060(5) m/s^2, loads: {loads}, readings: b.csv}}
requirements: [{{id: R, quantity: ea.k, limits: {{lower: 22 kN/m}}, decision: {{rule: guard band}}}}]
"""  # noqa: E501 - a line of a campaign file
LOADS = "{A: {mass: 1.0000(2) kg}, B: {mass: 2.0000(2) kg}, C: {mass: 3.0000(2) kg}, D: {mass: 4.0000(2) kg}}"


def pulled(folder: Path, of_a: str, of_b: str):
    """Two samples, of 25 and 20 kN/m, pulled three times each."""
    for name, k, seed in (("a", 25e3, 1), ("b", 20e3, 2)):
        rng = np.random.default_rng(seed)
        rows = ["load,repeat,direction,reading / mm"]
        for repeat in (1, 2, 3):
            # Zero moves between repeats: a check that fails, and that the uncertainty covers.
            for way, loads in (("loading", "ABCD"), ("unloading", "CBA")):
                for mass in loads:
                    shown = 9.806e3 * (1 + "ABCD".index(mass)) / k + rng.normal(0, 2e-3) + 0.02 * repeat
                    rows.append(f"{mass},{repeat},{way},{shown:.4f}")
        (folder / f"{name}.csv").write_text("\n".join([*rows, ""]))
    return evaluated(folder, SAMPLES.format(of_a=of_a, of_b=of_b, loads=LOADS))


def reference(**known: str) -> str:
    return ", references: {" + ", ".join(f"{key}: {{value: {v}, source: spec}}" for key, v in known.items()) + "}"


@pytest.fixture(scope="module")
def exchanged(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exchanged")
    return pulled(folder, reference(k="20.0(1) kN/m"), reference(k="25.0(1) kN/m"))


def test_planted_exchanged_samples_do_not_pass_and_are_named(exchanged):
    assert judged(exchanged) == {}
    assert "ea.k fits the reference of b and eb.k that of a" in why(exchanged, "R")
    assert "the samples may be exchanged" in told(exchanged)


def test_planted_a_stiffness_off_its_reference_is_no_modulus_off_its_own(exchanged):
    for one, beside in zip(exchanged.diagnosis, (set(), {"damage"}), strict=True):
        # No damage makes a sample stiffer.
        assert one.discrepancy.quantity == "k"
        assert one.discrepancy.sentence.startswith("k is ")
        named = {each.cause.partition(".")[0] for each in one.discrepancy.explanations}
        assert named == beside | {"frame", "clamp", "force", "indicator", "reference"}
        assert one.discrepancy.reference in (20e3, 25e3)


# Comparisons of inputs.

PAIRS = """\
causes: {mic: {standard: 0.1 mm, source: m}}
quantities:
  p: 10.00(10) N
  q: 10.15(10) N
  a: {value: 10.00 mm, uncertainty: [{cause: mic}]}
  b: {value: 10.10 mm, uncertainty: [{cause: mic}, {standard: 0.01 mm, source: r}]}
  c: {value: 10.00 N, uncertainty: [{standard: 0.10 N, dof: 2, type: A, source: r}]}
correlations: [{between: [p, q], coefficient: 0.95}]
derived:
  - {quantity: P, expression: 1*p, unit: N}
  - {quantity: Q, expression: 1*q, unit: N}
  - {quantity: C, expression: 1*c, unit: N}
comparisons:
  - between: [p, q]
  - between: [P, Q]
  - between: [a, b]
  - between: [c, {value: 10.35 N, source: exact}]
  - between: [C, {value: 10.35 N, source: exact}]
  - between: [p, Q]
"""


def test_closed_form_inputs_are_compared_as_quantities_are(tmp_path):
    """U = 1.96·0.1 N: E_n = −0.15/√(2·0.05)/U; one cause in both drops out: E_n = −0.1/(1.96·0.01)."""
    found = [one.en for one in evaluated(tmp_path, PAIRS).comparisons]
    assert found[0] == pytest.approx(found[1], rel=1e-6)
    assert found[0] == pytest.approx(found[5], rel=1e-6)
    assert found[0] == pytest.approx(-0.15 / (1.95996 * 0.1 * sqrt(0.1)), rel=1e-3)
    assert found[2] == pytest.approx(-0.1 / (1.95996 * 0.01), rel=0.02)
    assert found[3] == pytest.approx(found[4], rel=1e-6)
    assert found[3] == pytest.approx(-0.35 / (4.3027 * 0.1), rel=1e-3)


# What is said.

AUDIT = """\
quantities: {p: {value: 10 N, uncertainty: [{expanded: 0.4 N, p: 0.95, dof: 4, source: cert}]}, q: 10.3(1) N}
derived: [{quantity: D, expression: q - p, unit: N}]
audit: [{figure: D published, quantity: D, published: 0.30(18) N, source: t}]
"""


def test_twice_the_audit_says_by_which_way_it_is_recomputed(tmp_path):
    """Four degrees of freedom: √2 times the u of p by Monte Carlo, which the table of results has."""
    findings = evaluated(tmp_path, AUDIT)
    (row,) = findings.audit
    (result,) = findings.results
    assert f"{result.u:.2f}" not in row.recomputed
    assert f"by the GUM framework, Monte Carlo 0.30 ± {result.u:.2f} N" in row.sentence


def test_planted_a_prior_that_the_result_contradicts_is_said_and_bounds_no_risk(tmp_path):
    text = """\
quantities: {p: 10.00(14) N}
requirements:
  - {id: R1, quantity: p, limits: {lower: 9.5 N}, decision: {rule: simple acceptance}, prior: {PRIOR}}
  - {id: R2, quantity: p, limits: {lower: 9.5 N}, decision: {rule: global risk, risk: 0.01}, prior: {PRIOR}}
"""
    far = evaluated(tmp_path, text.replace("{PRIOR}", "{distribution: rectangular, low: 11.5 N, high: 12 N}"))
    assert judged(far) == {"R1": "pass"}
    assert "p contradicts the prior" in why(far, "R2")
    assert "R1: p contradicts the prior, rectangular (11.5 N, 12 N)" in told(far)
    near = evaluated(tmp_path, text.replace("{PRIOR}", "{distribution: rectangular, low: 9.8 N, high: 10.5 N}"))
    assert set(judged(near)) == {"R1", "R2"}
    assert "prior" not in told(near)


def test_closed_form_surprise_of_a_normal_prior():
    from metrology.chain.conformity import surprise
    from metrology.gum.output import Analytic
    from metrology.gum.risk import Prior

    found = surprise(Analytic(10.0, 0.3), Prior.normal(11.0, 0.4))
    assert found == pytest.approx(1 - erf(1.0 / 0.5 / sqrt(2)), rel=1e-3)


def test_planted_days_in_the_future_are_said(tmp_path, monkeypatch):
    monkeypatch.setattr(days, "today", lambda: date(2026, 11, 1))
    (tmp_path / "campaign.yaml").write_text(
        HEAD + "report: {number: X, issued: 2026-11-02}\nquantities: {p: 10.00(14) N}\n"
    )
    campaign = load(tmp_path / "campaign.yaml")
    (sentence,) = days.ahead(campaign)
    assert sentence.startswith("Dated in the future: issue of the report, 2026-11-02.")
    before = to_json(chain.evaluate(campaign, coverage=False))
    monkeypatch.setattr(days, "today", lambda: date(2026, 11, 2))
    assert not list(days.ahead(campaign))
    # What is checked on another day has the same results.
    assert to_json(chain.evaluate(campaign, coverage=False)) == before


def test_law_every_notice_that_warns_is_a_warning_and_stands_once_on_page_1(exchanged):
    kinds = {"Withheld", "Check", "Diagnosis", "Comparison"}
    assert kinds <= {one.kind for one in exchanged.notices}
    assert all(one.sentence in exchanged.warnings for one in exchanged.notices if one.kind in kinds)
    back = from_json(to_json(exchanged))
    assert [tuple(one) for one in brief(back)] == [(one.kind, one.sentence) for one in exchanged.notices]
    notes = [sentence for kind, sentence in attention(back) if kind == "Note"]
    assert not {one.sentence for one in exchanged.notices if one.kind in kinds} & set(notes)


def test_planted_a_refuted_assumption_stands_on_page_1(exchanged):
    struck = Assumption("The line is straight.", "line that is not straight, probability 0.96, in ea")
    campaign = replace(exchanged.campaign, assumptions=(struck, Assumption("The frame is stiff.", "")))
    found = [text for kind, text in brief(replace(exchanged, campaign=campaign)) if "assumption" in text]
    assert found == [
        "The assumption “The line is straight” is refuted: line that is not straight, probability 0.96, in "
        "a, elongation under dead loads."
    ]


@pytest.mark.long
def test_law_an_acceptance_of_a_failed_check_that_forbids_nothing_does_not_deny_that_it_failed(tmp_path, exchanged):
    failed = [one.name for one in exchanged.tests[0].finding.checks if one.passed is False]
    assert failed == ["zero shift between repeats"]  # what the uncertainty covers
    stated = (tmp_path / "a.csv", tmp_path / "b.csv")
    pulled(tmp_path, "", "")
    assert all(path.is_file() for path in stated)
    text = (tmp_path / "campaign.yaml").read_text()
    accepted = "readings: a.csv, accepted: [{check: zero shift between repeats, reason: small, by: A. Smith}]"
    (tmp_path / "campaign.yaml").write_text(text.replace("readings: a.csv", accepted))
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False)
    assert "'zero shift between repeats' is accepted; the check failed, but forbids no verdict" in told(findings)
    assert "no check of that name failed" not in told(findings)


# A modulus that no material has.

PULLED = """\
instruments: {dial: {kind: dial indicator, resolution: 0.001 mm}}
samples: {wire: {section: {shape: round, diameter: 0.500(1) mm}, length: LENGTH}}
tests:
  pull:
    method: elongation
    sample: wire
    instruments: {extension: dial}
    loads: {A: {force: 10.00(1) N}, B: {force: 20.00(1) N}, C: {force: 30.00(1) N}}
    readings: r.csv
diagnosis: {off: true}
requirements: [{id: R, quantity: pull.k, limits: {lower: 10 kN/m}, decision: {rule: guard band}}]
"""


@pytest.mark.parametrize(("length", "passes"), [("2.000(1) m", True), ("2.000(1) km", False)])
def test_planted_a_modulus_above_that_of_diamond_is_of_wrong_inputs(length: str, passes: bool, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    rows = [f"{load},{r},{1e3 * f / 2e4 + rng.normal(0, 0.003):.3f}" for r in (1, 2, 3) for load, f in
            (("A", 10), ("B", 20), ("C", 30))]  # fmt: skip
    (tmp_path / "r.csv").write_text("load,repeat,reading / mm\n" + "\n".join(rows) + "\n")
    found = evaluated(tmp_path, PULLED.replace("LENGTH", length))
    assert judged(found) == ({"R": "pass"} if passes else {})
    assert ("above the modulus of diamond, 1.21 TPa" in told(found)) is not passes


def test_law_advice_names_what_two_imported_results_share_as_their_report_does(tmp_path: Path) -> None:
    shared = "quantities: {a: 10.00(1) mm, b: {value: 20.00 mm, uncertainty: [{standard: 1 mm, name: steel tape}]}}\n"
    first = shared + "derived: [{quantity: p, expression: a+b, unit: mm}, {quantity: q, expression: a+2*b, unit: mm}]\n"
    found = evaluated(tmp_path, first, "first.yaml")
    (tmp_path / "r.json").write_bytes(to_json(found))
    key = sha256((tmp_path / "r.json").read_bytes()).hexdigest()
    given = "".join(f"  {name}: {{from: r.json, result: {name}, sha256: {key}}}\n" for name in "pq")
    (advice,) = (
        one.advice
        for one in evaluated(
            tmp_path, f"quantities:\n{given}derived: [{{quantity: s, expression: p+q, unit: mm}}]\n"
        ).results
        if one.name == "s"
    )
    assert "steel tape" in advice
    assert "imported-" not in advice


@pytest.mark.parametrize("side", ["{value: 10.5(1) mm, source: s}", "{value: {value: 10.5(1) mm, source: s}}"])
def test_law_a_value_from_elsewhere_may_be_written_under_its_key(side: str, tmp_path: Path) -> None:
    text = f"quantities: {{a: 10.00(1) mm}}\ncomparisons: [{{between: [a, {side}]}}]\n"
    (found,) = evaluated(tmp_path, text).comparisons
    assert found.en == pytest.approx(-2.49, abs=0.01)
