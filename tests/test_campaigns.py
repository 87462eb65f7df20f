"""The campaigns that are shipped: they load, say what they are, agree with one another, and give Table IV."""

from __future__ import annotations

import gzip
import sys
from importlib import import_module
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from undiagnosed import undiagnosed

from metrology import chain
from metrology.campaign.load import load
from metrology.chain.plan import Plan
from metrology.findings import Moments
from metrology.methods.response.preparation import prepared

FOLDER = Path(__file__).parents[1] / "campaigns"
NAMES = sorted(path.parent.name for path in FOLDER.glob("*/campaign.yaml"))
LINES = {"nylon": (167.64, 8.0), "spectra": (753.33, 35.0)}
"""Table IV: k / (N/m) and c / (N·s/m)."""
LIMIT = 10_000_000


@pytest.fixture(scope="module")
def reconstruct():
    sys.path.insert(0, str(FOLDER))
    yield import_module("reconstruct_response")
    sys.path.remove(str(FOLDER))


@pytest.fixture(scope="module")
def tapes():
    return {result.name: result for result in chain.evaluate(undiagnosed(FOLDER / "tapes" / "campaign.yaml")).results}


@pytest.fixture(scope="module")
def summary():
    return load(FOLDER / "summary" / "campaign.yaml")


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_reference_every_campaign_loads_and_says_that_it_is_reconstructed(name):
    campaign = load(FOLDER / name / "campaign.yaml")
    assert campaign.id == name
    assert "reconstructed" in campaign.reconstructed
    assert (FOLDER / name / "campaign.yaml").read_text(encoding="utf-8").startswith("# yaml-language-server: $schema=")


@pytest.mark.long
def test_reference_report_numbers_are_unique():
    numbers = [load(FOLDER / name / "campaign.yaml").report.number for name in NAMES]
    assert len(set(numbers)) == len(NAMES)


def test_limit_shipped_data_are_small():
    assert sum(path.stat().st_size for path in FOLDER.rglob("*.csv*")) < LIMIT


@pytest.mark.long
@pytest.mark.parametrize("name", ["nylon", "al-1100"])
def test_twice_the_script_gives_the_shipped_readings(name, reconstruct):
    for file, text in reconstruct.campaign(name, reconstruct.LINES[name]):
        shipped = gzip.decompress((FOLDER / name / "readings" / file).read_bytes()).decode()
        heading, rows = shipped.split("\n", 1)
        assert heading == text.split("\n", 1)[0]
        # Another libm may round a reading the other way: one step of the last digit.
        first, second = (np.genfromtxt(StringIO(part), delimiter=",") for part in (rows, text.split("\n", 1)[1]))
        step = np.array([0.0, 1e-5, 1e-4] if "x / m" in heading else [0.0, 1e-3])
        assert np.array_equal(np.isnan(first), np.isnan(second))
        assert (np.abs(np.nan_to_num(first - second)) <= 1.001 * step).all()


def test_twice_the_script_of_the_static_tests_gives_the_shipped_readings():
    sys.path.insert(0, str(FOLDER / "lines"))
    made = import_module("reconstruct_lines")
    sys.path.remove(str(FOLDER / "lines"))
    for line in made.LINES:
        assert made.text(line) == (FOLDER / "lines" / line.file).read_text(encoding="utf-8")


def test_twice_the_static_tests_are_compared_with_what_the_summary_holds(summary):
    own = load(FOLDER / "lines" / "campaign.yaml").quantities
    assert {name: one.value for name, one in own.items()} == {name: summary.quantities[name].value for name in own}


@pytest.mark.long
def test_planted_static_and_dynamic_stiffness_of_the_lines_agree():
    """The braid stiffens: its line alone gives 2 % more than the table does, the supported model the same."""
    findings = chain.evaluate(load(FOLDER / "lines" / "campaign.yaml"), coverage=False)
    assert [one.agrees for one in findings.comparisons if "on the table" in one.title] == [True, True]
    stated = next(one.stated for one in findings.results if one.name == "spectra-elongation.k")
    assert stated.value == pytest.approx(1.015 * 736.588, rel=0.003)
    assert "not straight" in stated.why


@pytest.mark.parametrize("name", ["peek", "al-1100"])
def test_twice_given_values_are_the_results_of_the_tapes_campaign(name, tapes):
    test = load(FOLDER / name / "campaign.yaml").tests[f"{name}-response"]
    for given, full in ((test.stiffness, f"{name}-elongation.k"), (test.damping, f"{name}-decay.c")):
        agree(given.value.quantity, tapes[full].framework)
        assert full in given.value.source


@pytest.mark.parametrize(
    ("quantity", "full"),
    [
        ("al_k", "al-1100-elongation.k"),
        ("al_c", "al-1100-decay.c"),
        ("al_E", "al-1100-elongation.E"),
        ("peek_k", "peek-elongation.k"),
        ("peek_c", "peek-decay.c"),
        ("peek_E", "peek-elongation.E"),
    ],
)
def test_twice_the_summary_holds_the_results_of_the_tapes_campaign(quantity, full, summary, tapes):
    agree(summary.quantities[quantity].quantity, tapes[full].framework)


def agree(stated, found: Moments) -> None:
    """Value and uncertainty are those of the result, to the digits in which they are stated."""
    place = stated.factor * 10.0**-stated.digits
    assert abs(stated.value - found.value) <= 0.501 * place
    assert abs(stated.u - found.u) <= 0.501 * stated.factor * 10.0**-stated.u_digits


@pytest.mark.long
@pytest.mark.parametrize("name", LINES)
def test_reference_the_papers_way_gives_table_iv(name, summary):
    from metrology.estimation import paper_way

    campaign = load(FOLDER / name / "campaign.yaml")
    ready = prepared(Plan(), campaign, f"{name}-response", campaign.tests[f"{name}-response"])
    found = paper_way(ready.rig, ready.of("identification"))
    k, c = (summary.quantities[f"{name}_{symbol}"].quantity for symbol in "kc")
    assert abs(found.k - k.value) <= 0.6 * 10.0**-k.digits
    assert abs(found.c - c.value) <= 0.6 * 10.0**-c.digits
    assert abs(found.k - LINES[name][0]) < k.u
    assert abs(found.c - LINES[name][1]) < c.u


@pytest.mark.study
@pytest.mark.parametrize("name", LINES)
def test_twice_the_summary_holds_what_the_campaigns_give(name, summary):
    findings = chain.evaluate(undiagnosed(FOLDER / name / "campaign.yaml"))
    results = {result.name: result for result in findings.results}
    (test,) = findings.tests
    for symbol in "kc":
        result = results[f"{name}-response.{symbol}"]
        agree(summary.quantities[f"{name}_{symbol}_weighted"].quantity, result.framework)
        paper = test.response.paper
        agree(
            summary.quantities[f"{name}_{symbol}"].quantity,
            Moments(getattr(paper, symbol), getattr(paper, f"{symbol}_u")),
        )
    assert findings.failures == ()


@pytest.mark.study
@pytest.mark.parametrize("name", LINES)
def test_twice_the_summary_holds_the_validated_values(name, summary):
    results = {result.name: result for result in chain.evaluate(load(FOLDER / name / "campaign.yaml")).results}
    for symbol in "kc":
        result = results[f"{name}-response.{symbol}"]
        agree(summary.quantities[f"{name}_{symbol}_validated"].quantity, Moments(result.value, result.u))


@pytest.mark.study
@pytest.mark.parametrize("name", ["peek", "al-1100"])
def test_planted_the_tape_that_the_model_misses_is_the_aluminium_one(name):
    findings = chain.evaluate(undiagnosed(FOLDER / name / "campaign.yaml"))
    assert findings.failures == ()
    shares = [run["share"] for run in findings.verification[0]["runs"]]
    assert (min(shares) > 0.9) if name == "peek" else (max(shares) < 0.9)


@pytest.mark.study
def test_planted_sag_and_set_up_of_the_aluminium_tape_are_named_and_nothing_else():
    """The base model loses the motion; what is left beside the two is how far our series compliance is quasi-static."""
    (found,) = chain.evaluate(load(FOLDER / "al-1100" / "campaign.yaml")).diagnosis
    assert sorted(found.named) == ["sag", "setup"]
    sizes = {one.name: one.value for cause in found.causes if cause.effect in found.named for one in cause.parameters}
    assert sizes["setup.compliance"] == pytest.approx(1 / 40e3, rel=0.01)
    assert sizes["sag.weight"] == pytest.approx(3.39e-3 * 9.8, rel=0.01)
