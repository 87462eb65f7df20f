"""Published worked examples, each a campaign folder that goes through the front door, to the printed digits."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from metrology import chain
from metrology.campaign.load import load
from metrology.units import convert

FOLDER = Path(__file__).parent
EXAMPLES = sorted(path.parent.name for path in FOLDER.glob("*/campaign.yaml"))


@pytest.fixture(scope="module")
def findings():
    known = {}

    def evaluate(name):
        if name not in known:
            known[name] = chain.evaluate(load(FOLDER / name / "campaign.yaml"))
        return known[name]

    return evaluate


def cases():
    for name in EXAMPLES:
        for number, check in enumerate(yaml.safe_load((FOLDER / name / "expected.yaml").read_text())["checks"]):
            yield pytest.param(name, check, id=f"{name}-{number}")


def by(entries, key, value):
    (entry,) = [entry for entry in entries if getattr(entry, key) == value]
    return entry


def field(entry, path):
    for part in path.split("."):
        entry = getattr(entry, part)
    return entry


def found(result, check):
    if "correlation" in check:
        a, b = check["correlation"]
        (pair,) = [entry for entry in result.correlations if {entry.a, entry.b} == {a, b}]
        return pair.coefficient
    if "fit" in check:
        return field(by(result.fits, "name", check["fit"]), check["field"])
    if "requirement" in check:
        value = field(by(result.conformity, "requirement", check["requirement"]), check["field"])
    else:
        # Examples print the framework's digits, and those of Monte Carlo by their own name.
        way = "framework." if check["field"] in ("value", "u") else ""
        value = field(by(result.results, "name", check["result"]), way + check["field"])
    return value if check["field"] == "dof" else convert(value, check.get("unit", "1"), difference=True)


def last_place(text):
    """Half a unit of the last printed digit."""
    mantissa, _, exponent = text.lower().partition("e")
    return 0.5 * 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


@pytest.mark.long
@pytest.mark.parametrize(("name", "check"), list(cases()))
def test_reference_printed_digits(findings, name, check):
    result = findings(name)
    tolerance = last_place(check["expected"]) * check.get("units", 1) * 1.001
    if check.get("field", "").startswith("monte_carlo"):
        # A Monte Carlo result is determined to the numerical tolerance of JCGM 101 7.9.2 and no further.
        monte_carlo = by(result.results, "name", check["result"]).monte_carlo
        tolerance = max(tolerance, convert(monte_carlo.tolerance, check["unit"], difference=True))
    assert abs(found(result, check) - float(check["expected"])) <= tolerance


def test_every_reference_is_there():
    assert len(EXAMPLES) == 34


@pytest.mark.parametrize(
    "name",
    [
        "jcgm101-9-2-4-one-dominant-rectangular",
        "jcgm101-9-4-comparison-loss-r0-x0",
        "jcgm101-9-4-comparison-loss-r0-x0-01",
        "jcgm101-9-3-mass-calibration",
    ],
)
def test_reference_law_refused_by_clause_8(findings, name):
    (result,) = findings(name).results
    assert not result.monte_carlo.law_valid


@pytest.mark.parametrize("name", ["jcgm101-9-2-2-additive-normal", "jcgm101-9-2-3-additive-rectangular"])
def test_reference_law_confirmed_by_clause_8(findings, name):
    (result,) = findings(name).results
    assert result.monte_carlo.law_valid
