"""Results of another campaign as quantities of this one: value, budget and shared causes, by the hash of the file."""

from __future__ import annotations

import json
from hashlib import sha256
from math import hypot, sqrt
from pathlib import Path
from typing import Any

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.errors import MetrologyError
from metrology.findings import from_json, to_json
from metrology.language.wording import opening, own_names

HEAD = "format: metrology-campaign/1\ntitle: A calibration and its use\n"
CALIBRATION = """\
id: calibration
causes:
  balance: {standard: 0.02 g, source: certificate B-1}
quantities:
  left: {value: 5.00 g, uncertainty: [{cause: balance}, {half_width: 0.05 g, distribution: rectangular, source: drift}]}
  right: {value: 2.00 g, uncertainty: [{cause: balance}]}
  rest: {value: 1.00 g, uncertainty: [{standard: 0.04 g, dof: 6, type: A, source: readings}]}
derived:
  - {quantity: total, expression: left + right + rest, unit: g}
  - {quantity: lack, expression: 9.00*rest - left, unit: g}
"""
USE = """\
id: use
quantities:
  m: {{from: cal.json, result: total, sha256: {sha}, description: mass of the plate}}
  n: {{from: cal.json, result: lack, sha256: {sha}}}
derived:
  - {{quantity: both, expression: m + n, unit: g}}
"""


@pytest.fixture
def made(tmp_path: Path):
    (tmp_path / "calibration.yaml").write_text(HEAD + CALIBRATION)
    findings = chain.evaluate(load(tmp_path / "calibration.yaml"), coverage=False)
    raw = to_json(findings)
    (tmp_path / "cal.json").write_bytes(raw)
    return tmp_path, sha256(raw).hexdigest(), {one.name: one for one in findings.results}


def used(folder: Path, text: str):
    (folder / "campaign.yaml").write_text(HEAD + text)
    campaign = load(folder / "campaign.yaml")
    return campaign, {one.name: one for one in chain.evaluate(campaign, coverage=False).results}


def test_closed_form_what_two_imported_results_share_is_counted_once(made):
    """m + n = right + 10·rest: left is in both with opposite signs and drops out."""
    folder, sha, source = made
    campaign, found = used(folder, USE.format(sha=sha))
    assert source["total"].framework.u == pytest.approx(1e-3 * sqrt(0.04**2 + 0.05**2 / 3 + 0.04**2))
    assert found["both"].value == pytest.approx(12e-3, rel=1e-4)  # means of draws
    assert found["both"].framework.u == pytest.approx(1e-3 * hypot(0.02, 0.4))
    assert found["both"].dof == pytest.approx(6.0 * (1 + (0.02 / 0.4) ** 2) ** 2)
    assert found["both"].monte_carlo.u == pytest.approx(found["both"].framework.u * sqrt(6 / 4), rel=0.03)
    assert next(row.description for row in found["both"].budget if row.input == "m") == "mass of the plate"
    assert campaign.quantities["m"].u == pytest.approx(source["total"].framework.u)
    assert [file.path for file in campaign.files] == ["campaign.yaml", "cal.json"]
    assert read_sources(campaign)["cal.json"] == (folder / "cal.json").read_bytes()


def test_a_cause_of_the_same_name_is_the_same_unknown(made):
    """total has the balance twice; the tare of this campaign has it once: 2·0.02 − 0.02 in the difference."""
    folder, sha, _ = made
    text = """\
id: use
causes: {{balance: {{standard: 0.02 g, source: certificate B-1}}}}
quantities:
  m: {{from: cal.json, result: total, sha256: {sha}}}
  tare: {{value: 1.00 g, uncertainty: [{{cause: balance}}]}}
derived:
  - {{quantity: net, expression: m - tare, unit: g}}
"""
    _, found = used(folder, text.format(sha=sha))
    assert found["net"].framework.u == pytest.approx(1e-3 * sqrt(0.02**2 + 0.05**2 / 3 + 0.04**2))
    drawn = 1e-3 * sqrt(0.02**2 + 0.05**2 / 3 + 0.04**2 * 6 / 4)  # six degrees of freedom: a scaled t
    assert found["net"].monte_carlo.u == pytest.approx(drawn, rel=0.02)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("sha256: {sha}, description", "sha256: 00ff, description", "where the file has [0-9a-f]{64}"),
        (", sha256: {sha}, description", ", description", "no 'sha256'"),
        ("from: cal.json, result: lack", "from: other.json, result: lack", "there is no such file"),
        ("from: cal.json, result: lack", "from: ../cal.json, result: lack", "leaves the campaign's folder"),
        ("result: lack", "result: lac", "a result of campaign 'calibration'.*lack"),
        ("result: lack,", "result: lack, value: 3 g,", "'value' together with 'from'"),
    ],
)
def test_refusal_names_the_place_and_what_to_do(made, old, new, told):
    folder, sha, _ = made
    changed = USE.replace(old, new)
    assert changed != USE
    with pytest.raises(MetrologyError, match=told) as raised:
        used(folder, changed.format(sha=sha))
    (fault,) = raised.value.faults
    assert "campaign.yaml:" in fault.where
    assert "quantities." in fault.where


def test_readings_that_are_correlated_enter_with_their_variance(tmp_path: Path):
    """The result of a line: its parameters are correlated, and their budget rows do not add up by squares."""
    text = """\
id: cal
fits:
  line: {x: {values: [1, 2, 3, 4, 5]}, y: {values: [1.1, 1.9, 3.2, 3.8, 5.1]}, predict: [{name: y9, x: 9}]}
"""
    (tmp_path / "cal.yaml").write_text(HEAD + text)
    findings = chain.evaluate(load(tmp_path / "cal.yaml"), coverage=False)
    raw = to_json(findings)
    (tmp_path / "cal.json").write_bytes(raw)
    sha = sha256(raw).hexdigest()
    stated = f"id: use\nquantities:\n  a: {{from: cal.json, result: line.y9, sha256: {sha}}}\n"
    _, found = used(tmp_path, stated + "derived: [{quantity: b, expression: 2*a, unit: '1'}]\n")
    (source,) = [one for one in findings.results if one.name == "line.y9"]
    assert found["b"].framework.u == pytest.approx(2 * source.u)
    assert found["b"].dof == pytest.approx(3.0)


def test_closed_form_a_cause_that_acts_the_other_way_keeps_its_sign(tmp_path: Path):
    """far has the standard with the sign reversed: near + far leaves what is far's own, far - here has 2u of it."""
    source = """\
id: source
causes: {standard: {standard: 0.04 mm, source: certificate S-1}}
quantities:
  a: {value: 100 mm, uncertainty: [{cause: standard}]}
  b: {value: 200 mm, uncertainty: [{cause: standard, direction: opposite}, {standard: 0.01 mm, source: scale}]}
derived:
  - {quantity: near, expression: 1*a, unit: mm}
  - {quantity: far, expression: 1*b, unit: mm}
  - {quantity: apart, expression: b - a, unit: mm}
"""
    use = """\
id: use
causes: {{standard: {{standard: 0.04 mm, source: certificate S-1}}}}
quantities:
  near: {{from: source.json, result: near, sha256: {sha}}}
  far: {{from: source.json, result: far, sha256: {sha}}}
  apart: {{from: source.json, result: apart, sha256: {sha}}}
  here: {{value: 50 mm, uncertainty: [{{cause: standard}}]}}
derived:
  - {{quantity: total, expression: near + far, unit: mm}}
  - {{quantity: rest, expression: far - here, unit: mm}}
  - {{quantity: same, expression: apart + here, unit: mm}}
"""
    found = _from_source(tmp_path, source, use)
    assert found["total"].framework.u == pytest.approx(0.01e-3)
    assert found["rest"].framework.u == pytest.approx(1e-3 * hypot(0.08, 0.01))
    assert found["same"].framework.u == pytest.approx(1e-3 * hypot(0.04, 0.01))
    assert found["rest"].monte_carlo.u == pytest.approx(found["rest"].framework.u, rel=0.01)


def _from_source(folder: Path, source: str, use: str):
    """Results of a campaign that imports those of another one."""
    (folder / "source.yaml").write_text(HEAD + source)
    raw = to_json(chain.evaluate(load(folder / "source.yaml"), coverage=False))
    (folder / "source.json").write_bytes(raw)
    return used(folder, use.format(sha=sha256(raw).hexdigest()))[1]


def test_twice_an_imported_result_is_shown_in_the_unit_of_its_own_report(tmp_path: Path):
    source = "id: source\nquantities: {w: 25.000(5) mm, t: 0.500(1) mm}\n"
    source += "derived: [{quantity: S, expression: w * t, unit: mm^2}]\n"
    use = "id: use\nquantities: {{S: {{from: source.json, result: S, sha256: {sha}}}}}\nrequirements:\n"
    use += "  - {{id: R1, quantity: S, limits: {{upper: 13 mm^2}}, decision: {{rule: guard band}}}}\n"
    (shown,) = (one for one in _from_source(tmp_path, source, use).values() if one.quantity == "S")
    assert (shown.unit, shown.display_unit) == ("m^2", "mm^2")
    assert shown.value == pytest.approx(12.5e-6, rel=1e-12)


def test_closed_form_results_of_readings_taken_together_keep_their_correlation(tmp_path: Path):
    """From resistance and reactance of JCGM 100, H.2, follows the impedance that the readings give, with its u and ν.

    Likewise the line at a point from its parameters, and what has a parameter in common with another result.
    """
    readings = "5.007,19.663e-3,1.0456\n4.994,19.639e-3,1.0438\n5.005,19.640e-3,1.0468\n4.990,19.685e-3,1.0428\n"
    (tmp_path / "h2.csv").write_text(f"V / V,I / A,phi / rad\n{readings}4.999,19.678e-3,1.0433\n")
    source = """\
id: source
ensembles: {h2: {readings: h2.csv, columns: {V: "V / V", I: "I / A", phi: "phi / rad"}}}
fits:
  line: {x: {values: [1, 2, 3, 4, 5]}, y: {values: [1.1, 1.9, 3.2, 3.8, 5.1]}, predict: [{name: y9, x: 9}]}
derived:
  - {quantity: R, expression: V/I*cos(phi), unit: ohm}
  - {quantity: X, expression: V/I*sin(phi), unit: ohm}
  - {quantity: Z, expression: V/I, unit: ohm}
  - {quantity: twice, expression: 2*a, where: {a: line.intercept}, unit: '1'}
"""
    use = """\
id: use
quantities:
  R: {{from: source.json, result: R, sha256: {sha}}}
  R2: {{from: source.json, result: R, sha256: {sha}}}
  X: {{from: source.json, result: X, sha256: {sha}}}
  a: {{from: source.json, result: line.result.intercept, sha256: {sha}}}
  b: {{from: source.json, result: line.result.slope, sha256: {sha}}}
  c: {{from: source.json, result: twice, sha256: {sha}}}
derived:
  - {{quantity: Z, expression: 'sqrt(R*R2 + X**2)', unit: ohm}}
  - {{quantity: y9, expression: a + 9*b, unit: '1'}}
  - {{quantity: z9, expression: c/2 + 9*b, unit: '1'}}
  - {{quantity: none, expression: 2*a - c, unit: '1'}}
  - {{quantity: nought, expression: R - R2, unit: ohm}}
"""
    found = _from_source(tmp_path, source, use)
    for name, own in (("Z", "Z"), ("y9", "line.y9"), ("z9", "line.y9")):
        (expected,) = [one for one in _of(tmp_path) if one.name == own]
        assert found[name].framework.u == pytest.approx(expected.framework.u, rel=1e-6), name
        assert found[name].dof == pytest.approx(expected.dof), name
        assert found[name].interval == pytest.approx(expected.interval, rel=1e-3), name
    assert found["none"].framework.u == pytest.approx(0.0, abs=1e-6)
    # Nothing but rounding: the root of a few last digits of u²(R).
    assert found["nought"].framework.u < 1e-7 * found["Z"].framework.u


def test_the_notice_of_a_lost_distribution_tells_its_ends_apart_and_keeps_names(tmp_path: Path):
    source = """\
id: source
quantities: {x: {value: 300 mm, uncertainty: [{standard: 0.05 mm, distribution: exponential, source: wear}]}}
derived: [{quantity: X, expression: 1*x, unit: mm}]
"""
    use = """\
id: use
quantities: {{length: {{from: source.json, result: X, sha256: {sha}}}}}
derived: [{{quantity: L, expression: 1*length, unit: mm}}]
"""
    _from_source(tmp_path, source, use)
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False)
    (notice,) = [text for text in findings.warnings if "not carried over" in text]
    assert "there is 299.951 mm to 300.135 mm, here 299.902 mm to 300.098 mm" in notice
    assert opening(notice, own_names(findings)).startswith("length: X of source")


def test_of_uncertainties_that_cancel_it_is_said_that_they_do(tmp_path: Path):
    text = """\
id: use
causes: {bath: {standard: 0.2 K, source: thermometer}}
quantities: {a: {value: 293 K, uncertainty: [{cause: bath}]}, b: {value: 303 K, uncertainty: [{cause: bath}]}, c: 2 K}
derived: [{quantity: rise, expression: b - a, unit: K}, {quantity: twice, expression: 2*c, unit: K}]
"""
    (tmp_path / "campaign.yaml").write_text(HEAD + text)
    found = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False).warnings
    assert any(one.startswith("rise has u = 0") and "cancel" in one for one in found)
    assert any(one.startswith("twice has u = 0: nothing that it depends on") for one in found)


def test_twice_a_comparison_by_a_stated_side_takes_its_degrees_of_freedom_as_by_a_quantity(tmp_path: Path):
    """20.0 N with u = 0.2 N of three readings against 20.9 N: U is 0.86 N, whichever way the value is written."""
    text = """\
id: use
quantities:
  theirs: {value: 20.0 N, uncertainty: [{standard: 0.2 N, dof: 2, type: A, source: readings}]}
  mine: {value: 20.9 N, uncertainty: [{standard: 0.1 N, source: certificate}]}
derived: [{quantity: force, expression: 1*mine, unit: N}, {quantity: other, expression: 1*theirs, unit: N}]
comparisons:
  - {between: [force, other]}
  - between:
      - force
      - {value: 20.0 N, uncertainty: [{standard: 0.2 N, dof: 2, type: A, source: readings}], source: other laboratory}
"""
    (tmp_path / "campaign.yaml").write_text(HEAD + text)
    by_name, as_stated = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False).comparisons
    assert by_name.en == pytest.approx(0.9 / hypot(4.3027 * 0.2, 1.96 * 0.1), rel=1e-3)
    assert as_stated.en == pytest.approx(by_name.en, rel=1e-3)


def test_closed_form_what_is_imported_twice_on_different_ways_is_one_unknown(tmp_path: Path):
    """A mass by its own campaign, and half of it by one that imports it: M + M/2 has u = 1.5·u(M), their ratio none."""
    standard = """\
id: standard
quantities: {std: {value: 1 kg, uncertainty: [{standard: 0.1 g, source: certificate}]}}
derived: [{quantity: M, expression: 1*std, unit: kg}, {quantity: below, expression: -1*std, unit: kg}]
"""
    _from_source(tmp_path, standard, "id: none")
    first = (tmp_path / "source.json").read_bytes()
    balance = """\
id: balance
quantities: {{below: {{from: source.json, result: below, sha256: {sha}}}}}
derived: [{{quantity: half, expression: -0.5*below, unit: kg}}]
"""
    used(tmp_path, balance.format(sha=sha256(first).hexdigest()))
    second = to_json(chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False))
    (tmp_path / "balance.json").write_bytes(second)
    use = f"""\
id: use
quantities:
  M: {{from: source.json, result: M, sha256: {sha256(first).hexdigest()}}}
  half: {{from: balance.json, result: half, sha256: {sha256(second).hexdigest()}}}
derived:
  - {{quantity: total, expression: M + half, unit: kg}}
  - {{quantity: ratio, expression: half/M, unit: '1'}}
"""
    found = used(tmp_path, use)[1]
    assert found["total"].framework.u == pytest.approx(0.15e-3)
    assert found["ratio"].framework.u == pytest.approx(0.0, abs=1e-12)


def test_twice_a_comparison_by_a_stated_side_knows_the_cause_that_both_share(tmp_path: Path):
    """Both by one force standard: the difference has only the readings, whichever way the other value is written."""
    text = """\
id: use
causes: {standard: {standard: 0.2 N, source: force standard}}
quantities:
  mine: {value: 20.0 N, uncertainty: [{cause: standard}, {standard: 0.02 N, source: readings}]}
  theirs: {value: 20.2 N, uncertainty: [{cause: standard}, {standard: 0.02 N, source: readings}]}
  turned: {value: 20.2 N, uncertainty: [{cause: standard, direction: opposite}]}
derived: [{quantity: force, expression: 1*mine, unit: N}]
comparisons:
  - {between: [force, theirs]}
  - between: [force, {value: 20.2 N, uncertainty: [{cause: standard}, {standard: 0.02 N, source: readings}], source: B}]
  - {between: [force, turned]}
  - between: [{value: 20.2 N, uncertainty: [{cause: standard, direction: opposite}], source: C}, force]
"""
    (tmp_path / "campaign.yaml").write_text(HEAD + text)
    same, stated, turned, other = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False).comparisons
    assert same.en == pytest.approx(-0.2 / (1.96 * hypot(0.02, 0.02)), rel=1e-3)
    assert stated.en == pytest.approx(same.en, rel=0.15)  # k = 2, where that of a result is 1.96
    assert not stated.agrees
    assert other.en == pytest.approx(-turned.en, rel=0.02)


def test_twice_a_sum_of_imported_masses_has_the_u_that_their_own_campaign_gives_it(tmp_path: Path):
    """Three masses weighed together: a + b + c of their own campaign, and as a dead load of another one."""
    (tmp_path / "w.csv").write_text(
        "a / kg,b / kg,c / kg\n1.00,1.02,0.99\n1.01,1.00,1.00\n1.03,1.01,0.98\n1.02,1.03,0.9\n"
    )
    source = """\
id: source
ensembles: {w: {readings: w.csv, columns: {a: "a / kg", b: "b / kg", c: "c / kg"}}}
derived:
  - {quantity: A, expression: 1*a, unit: kg}
  - {quantity: B, expression: 1*b, unit: kg}
  - {quantity: C, expression: 1*c, unit: kg}
  - {quantity: all, expression: a + b + c, unit: kg}
"""
    use = """\
id: use
masses:
  a: {{from: source.json, result: A, sha256: {sha}}}
  b: {{from: source.json, result: B, sha256: {sha}}}
  c: {{from: source.json, result: C, sha256: {sha}}}
instruments: {{indicator: {{kind: dial indicator, resolution: 0.001 mm}}}}
samples: {{wire: {{material: steel}}}}
tests:
  pull:
    method: elongation
    sample: wire
    instruments: {{extension: indicator}}
    gravity: 9.8065 m/s^2
    loads: {{A: {{mass: a}}, B: {{mass: a + b}}, C: {{mass: a + b + c}}}}
    readings: pull.csv
"""
    rows = [f"{load},{at},{at + 0.01 * n:.3f}" for at, load in enumerate("ABC", 1) for n in range(3)]
    text = "load,repeat,reading / mm\n" + "\n".join(f"{row[0]},{n % 3 + 1},{row[4:]}" for n, row in enumerate(rows))
    (tmp_path / "pull.csv").write_text(text + "\n")
    _from_source(tmp_path, source, "id: none")
    sha = sha256((tmp_path / "source.json").read_bytes()).hexdigest()
    (tmp_path / "campaign.yaml").write_text(HEAD + use.format(sha=sha))
    (joint,) = [one for one in chain.build(load(tmp_path / "campaign.yaml")).ensembles if "pull.load C" in one.members]
    (whole,) = [one for one in _of(tmp_path) if one.name == "all"]
    at = joint.members.index("pull.load C")
    assert joint.covariance[at][at] == pytest.approx(whole.framework.u**2)
    assert joint.dof == pytest.approx(3.0)


def _of(folder: Path):
    return from_json(folder / "source.json").results


SQUARE = """\
id: source
quantities: {{s: '{s} mm'}}
derived: [{{quantity: w, expression: s**2, unit: mm^2}}, {{quantity: v, expression: 3*s**2, unit: mm^2}}]
"""
SQUARE_USE = """\
id: use
quantities: {{w: {{from: source.json, result: w, sha256: {sha}}}}}
derived: [{{quantity: y, expression: 2*w, unit: mm^2}}]
requirements:
  - {{id: R, quantity: y, limits: {{upper: 12 mm^2}}, decision: {{rule: specific risk}}}}
"""


@pytest.mark.parametrize("s", ["0.0(10)", "0.05(100)"])
def test_a_result_of_which_the_first_order_says_little_enters_with_its_reported_u(tmp_path: Path, s: str):
    # u of the draws is 1.4 mm²; by the sensitivities it is none, or 0.1 mm².
    found = _from_source(tmp_path, SQUARE.format(s=s), SQUARE_USE)
    assert found["y"].u == pytest.approx(2 * sqrt(2) * 1e-6, rel=0.02)
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False)
    (row,) = [row for row in findings.results[0].budget if row.component.endswith("what its budget does not show")]
    assert row.contribution == pytest.approx(2 * sqrt(2) * 1e-6, rel=0.02)
    assert not findings.conformity
    assert [one.requirement for one in findings.withheld] == ["R"]


def test_parts_that_no_budget_has_of_two_results_of_one_report_are_not_judged(tmp_path: Path):
    use = SQUARE_USE.replace("12 mm^2", "200 mm^2").replace("quantities: {{w:", """quantities: {{
  v: {{from: source.json, result: v, sha256: {sha}}}, w:""").replace("2*w", "w + v")  # fmt: skip
    _from_source(tmp_path, SQUARE.format(s="0.0(10)"), use)
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False)
    assert not findings.conformity
    assert any("how the two are correlated is not known" in text for text in findings.warnings)


@pytest.mark.parametrize(
    "edited",
    [
        pytest.param({"value": 9e-3}, id="value"),
        pytest.param({"u": 1e-6, "framework": {"value": 8e-3, "u": 1e-6}}, id="u"),
        pytest.param({"budget": []}, id="no budget"),
    ],
)
def test_refusal_a_result_that_was_edited_in_its_file(tmp_path: Path, edited: dict[str, Any]):
    """Its SHA-256 is stated anew; the interval of the draws still tells value and u."""
    (tmp_path / "calibration.yaml").write_text(HEAD + CALIBRATION.replace("dof: 6, ", ""))
    source = json.loads(to_json(chain.evaluate(load(tmp_path / "calibration.yaml"), coverage=False)))
    (row,) = [one for one in source["results"] if one["name"] == "total"]
    assert row["monte_carlo"]["law_valid"]

    def enter() -> None:
        raw = json.dumps(source).encode()
        (tmp_path / "cal.json").write_bytes(raw)
        used(tmp_path, USE.format(sha=sha256(raw).hexdigest()))

    enter()
    row |= edited
    with pytest.raises(MetrologyError, match="do not go together"):
        enter()


def test_law_results_of_reconstructed_readings_say_so_in_every_campaign_that_takes_them(tmp_path: Path):
    (tmp_path / "source.yaml").write_text(HEAD + "reconstructed: made up\n" + CALIBRATION)
    name, result = "source", "total"
    for step in ("first", "second"):
        raw = to_json(chain.evaluate(load(tmp_path / f"{name}.yaml"), coverage=False))
        (tmp_path / f"{name}.json").write_bytes(raw)
        entry = f"{{from: {name}.json, result: {result}, sha256: {sha256(raw).hexdigest()}}}"
        text = f"id: {step}\nquantities: {{m: {entry}}}\nderived: [{{quantity: y, expression: 2*m, unit: g}}]\n"
        (tmp_path / f"{step}.yaml").write_text(HEAD + text)
        found = chain.evaluate(load(tmp_path / f"{step}.yaml"), coverage=False)
        told = "rests on readings that were reconstructed, not measured"
        assert any(told in one for one in found.warnings), step
        assert any(told in one.sentence for one in found.notices), step
        name, result = step, "y"
