"""What is known of a result goes wherever the result goes: acceptances, verdicts, its item, its unit."""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError
from metrology.export.collect import results as rows
from metrology.export.control import chart
from metrology.export.dcc import certificate
from metrology.findings import Findings, to_json
from metrology.gum.risk import Limits
from metrology.language.display import normalised
from metrology.language.notices import brief
from metrology.report import html
from metrology.report.lines import all_lines, whose
from metrology.report.quality import stated as state
from metrology.signoff.agreement import compare

X = np.arange(12.0)
BOW = np.round(1 + 2 * X + 0.05 * (X - 5.5) ** 2, 3)
ACCEPTED = "accepted: {reason: only to sort, by: A. Smith}"
HEAD = """\
format: metrology-campaign/1
id: {id}
title: Carried along
report: {{number: {number}, issued: 2026-11-20, authorised_by: "J. Doe, head"}}
laboratory: {{name: Lab, country: IT}}
customer: {{name: Customer}}
"""


def evaluated(folder: Path, text: str, identity: str = "c", number: str = "C-1") -> Findings:
    path = folder / f"{identity}.yaml"
    path.write_text(HEAD.format(id=identity, number=number) + text, encoding="utf-8")
    return chain.evaluate(load(path), coverage=False)


def bowed(folder: Path, accepted: str, further: str = "", **known: str) -> Findings:
    """A line through points on a bow, and a requirement on its slope."""
    fit = (
        f"fits:\n  bow:\n    x: {{values: {X.tolist()}, unit: mm}}\n    y: {{values: {BOW.tolist()}, unit: N}}\n"
        f"    model: line\n    {accepted}\n"
    )
    return evaluated(folder, fit + further, **known)


def stored(folder: Path, found: Findings, name: str = "s.json") -> str:
    (folder / name).write_bytes(to_json(found))
    return sha256((folder / name).read_bytes()).hexdigest()


TWICE = "derived:\n  - {quantity: s, expression: 2*bow.slope, unit: N/m}\n"
ON_SLOPE = "requirements:\n  - {id: R, quantity: QUANTITY, limits: {lower: 1 N/mm}, decision: {rule: guard band}}\n"


@pytest.mark.parametrize("forget", [False, True])
def test_law_an_acceptance_goes_with_the_result_into_other_campaigns(forget, tmp_path):
    found = bowed(tmp_path, ACCEPTED, TWICE + ON_SLOPE.replace("QUANTITY", "s"))
    (accepted,) = found.conformity[0].accepted
    content = json.loads(to_json(found))
    if forget:  # as versions wrote it that had it with the verdict alone
        for one in content["results"]:
            del one["accepted"]
    (tmp_path / "s.json").write_text(json.dumps(content), encoding="utf-8")
    sha = sha256((tmp_path / "s.json").read_bytes()).hexdigest()
    text = f"quantities:\n  b: {{from: s.json, result: s, sha256: {sha}}}\n" + ON_SLOPE.replace("QUANTITY", "b")
    taken = evaluated(tmp_path, text, identity="d", number="D-1")
    (judged,) = taken.conformity
    assert any(accepted in one for one in judged.accepted)
    shown = [sentence for kind, sentence in brief(taken) if kind == "Accepted"]
    assert len(shown) == 1
    assert "A. Smith: only to sort." in shown[0]


def test_law_an_acceptance_stands_whole_on_page_1_without_a_requirement_too(tmp_path):
    found = bowed(tmp_path, ACCEPTED, TWICE)
    shown = [sentence for kind, sentence in brief(found) if kind == "Accepted"]
    assert shown
    assert all(one.endswith("Accepted by A. Smith: only to sort.") for one in shown)
    told = [one for one in found.warnings if "bow" in one and "alike" in one]
    assert all("Accepted by" in one for one in told)  # once, with its acceptance
    page = html.render(found, {}).text.split("Contents")[0]
    assert "A. Smith" in page


def test_law_an_acceptance_of_what_did_not_fail_is_noted(tmp_path):
    text = (
        "ensembles:\n  e: {readings: r.csv, columns: {v: V / mV}, accepted: {reason: a trial, by: B. Jones}}\n"
        "quantities:\n  a: 1.00(1) N\n"
        "comparisons:\n"
        "  - {between: [a, {value: 1.01(1) N, source: other}], accepted: {reason: a trial, by: B. Jones}}\n"
    )
    values = 10 + 0.01 * np.random.default_rng(5).standard_normal(20)
    (tmp_path / "r.csv").write_text("V / mV\n" + "\n".join(f"{v:.4f}" for v in values) + "\n", encoding="utf-8")
    found = evaluated(tmp_path, text)
    assert sum("an acceptance is stated, but nothing of it failed" in one for one in found.warnings) == 2


VERDICTS = """\
quantities:
  m: 5.02(1) kg
  n: 1.00(1) kg
derived:
  - {quantity: whole, expression: m + n, unit: kg}
requirements:
  - {id: R1, quantity: m, limits: {upper: 5 kg}, decision: {rule: simple acceptance}}
  - {id: R2, quantity: whole, limits: {upper: 7 kg}, decision: {rule: simple acceptance}}
  - {id: R3, quantity: bow.p, limits: {upper: 1 N}, decision: {rule: simple acceptance}}
"""


def test_twice_verdicts_of_inputs_and_predictions_are_in_certificate_and_collection(tmp_path):
    accepted = f"{ACCEPTED}\n    predict: [{{name: p, x: 3.0(1) mm}}]"
    found = bowed(tmp_path, accepted, VERDICTS)
    text = certificate(found).decode()
    assert {one.requirement: one.verdict for one in found.conformity} == {"R1": "fail", "R2": "pass", "R3": "fail"}
    assert text.count("<dcc:conformity>fail</dcc:conformity>") == 2
    assert text.count("<dcc:conformity>pass</dcc:conformity>") == 1
    assert "Limits of m: ≤ 5 kg." in text
    assert "(bow.p)" in text
    assert "DRAFT: " in text
    told = "; ".join(row.verdicts for row in rows(found, "c/results.json"))
    assert told.count("fail") == 2
    assert told.count("pass") == 1
    points = chart(tuple(rows(found, "c/results.json")), "m")
    assert len(points.points) + len(points.left_out) == 1


@pytest.mark.parametrize(("numbers", "judged"), [(("S-1", "S-1"), False), (("S-1", "S-2"), True)])
def test_planted_one_result_of_one_report_in_two_files_is_no_two_measurements(numbers, judged, tmp_path):
    keys = []
    for at, number in enumerate(numbers):
        text = f"seed: {at + 1}\nquantities:\n  k: 10.0(1) N/m\n"
        text += "derived:\n  - {quantity: q, expression: 2*k, unit: N/m}\n"
        found = evaluated(tmp_path, text, identity=f"s{at}", number=number)
        keys.append(stored(tmp_path, found, f"s{at}.json"))
    text = "quantities:\n" + "".join(
        f"  q{at}: {{from: s{at}.json, result: q, sha256: {key}}}\n" for at, key in enumerate(keys)
    )
    text += "derived:\n  - {quantity: mean, expression: (q0 + q1)/2, unit: N/m}\n"
    found = evaluated(tmp_path, text + ON_SLOPE.replace("QUANTITY", "mean").replace("1 N/mm", "10 N/m"), identity="d")
    assert len(found.conformity) == judged
    if not judged:
        assert "one result of S-1, evaluated twice" in found.withheld[0].reasons[0]


def test_law_an_imported_temperature_is_limited_in_the_unit_of_its_report(tmp_path):
    text = "quantities:\n  a: 24.0(1) degC\n  b: 1.00(1) K\n"
    text += "derived:\n  - {quantity: T, expression: a + b, unit: degC}\n"
    sha = stored(tmp_path, evaluated(tmp_path, text, identity="s", number="S-1"))
    taken = (
        f"quantities:\n  T: {{from: s.json, result: T, sha256: {sha}}}\n"
        "requirements:\n  - {id: R, quantity: T, limits: {upper: 26 degC}, decision: {rule: guard band}}\n"
    )
    (judged,) = evaluated(tmp_path, taken, identity="d").conformity
    assert judged.verdict == "pass"
    assert judged.upper == pytest.approx(299.15)


def test_law_page_1_tells_items_of_one_symbol_apart(tmp_path):
    text = (
        "samples:\n  a: {name: Wire, section: {shape: round, diameter: 1.000(1) mm}}\n"
        "  b: {name: Wire, section: {shape: round, diameter: 2.000(1) mm}}\n"
        "quantities:\n  F: 100.0(1) N\nderived:\n"
        "  - {quantity: s, sample: a, expression: F/A, unit: MPa}\n"
        "  - {quantity: s, sample: b, expression: F/A, unit: MPa}\n"
        "requirements:\n  - {id: R1, quantity: a.s, limits: {upper: 100 MPa}, decision: {rule: guard band}}\n"
        "  - {id: R2, quantity: b.s, limits: {upper: 100 MPa}, decision: {rule: guard band}}\n"
    )
    found = evaluated(tmp_path, text)
    lines = all_lines(found)
    assert [whose(one, lines) for one in found.conformity] == ["Wire (a)", "Wire (b)"]
    page = html.render(found, {}).text.split("Contents")[0]
    assert page.count("Wire (a)") >= 3  # items tested, result, verdict


def test_limit_a_limit_that_equals_a_computed_value_is_met():
    assert Limits(None, 0.3e-3).holds(0.1e-3 + 0.2e-3)
    assert Limits(0.1e-3 + 0.2e-3, None).holds(0.3e-3)
    assert not Limits(None, 0.3e-3).holds(0.3e-3 * (1 + 1e-9))


def test_limit_u_of_zero_has_tolerances_of_agreement(tmp_path):
    text = "quantities:\n  a: 0.0(1) N\nderived:\n  - {quantity: zero, expression: (a - a)*2, unit: N}\n"
    found = evaluated(tmp_path, text)
    assert found.results[0].u == 0
    assert any("the uncertainties that it depends on cancel" in one for one in found.warnings)
    compare(to_json(found), to_json(found))  # without a division by it


@pytest.mark.parametrize(("en", "text"), [(1.0006, "1.001"), (0.99996, "0.99996"), (1.0, "1.00"), (1.02, "1.02")])
def test_limit_e_n_beside_its_limit_shows_on_which_side(en, text):
    assert normalised(en) == text


def test_law_a_certificate_alone_points_to_no_annex(tmp_path):
    text = "quantities:\n  m: 5.02(1) kg\nderived:\n  - {quantity: w, expression: 2*m, unit: kg}\n"
    found = evaluated(tmp_path, text)
    assert "see the annex" in state(found)
    alone = found.__class__(**{**vars(found), "campaign": found.campaign.__class__(**{
        **vars(found.campaign), "parts": ("certificate",)})})  # fmt: skip
    assert "annex" not in state(alone)


def test_refusal_what_a_fit_cannot_use_names_the_file(tmp_path):
    with pytest.raises(MetrologyError, match=r"c\.yaml:\d+:\d+ fits\.bow u_x: got uncertainties of x alone"):
        bowed(tmp_path, "u_x: {value: 0.01 mm}")
    lines = [f"{x},{2 * x},{0.0 if x == 3 else 0.1}" for x in range(1, 8)]
    (tmp_path / "r.csv").write_text("\n".join(["x / mm,y / N,u / N", *lines]) + "\n", encoding="utf-8")
    with pytest.raises(MetrologyError, match=r"c\.yaml:\d+:\d+ fits\.w u_y\[2\]: got 0"):
        evaluated(tmp_path, "fits:\n  w: {readings: r.csv, x: x / mm, y: y / N, u_y: u / N}\n")


def test_refusal_a_prior_that_excludes_the_result_names_its_requirement(tmp_path):
    text = (
        "quantities:\n  a: 25.0(5) N\nderived:\n  - {quantity: b, expression: -a, unit: N}\n"
        "requirements:\n  - {id: G, quantity: b, limits: {lower: -26 N}, decision: {rule: global risk, risk: 0.01}, "
        "prior: {distribution: gamma, shape: 4, scale: 1 N}}\n"
    )
    with pytest.raises(MetrologyError, match=r"c\.yaml:\d+:\d+ requirements\[0\] prior: got a result of -25"):
        evaluated(tmp_path, text)
