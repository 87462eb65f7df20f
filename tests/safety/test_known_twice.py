"""What a campaign knows twice, and what nature does not allow: found where it is off, silent where it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from laboratory import METHODS, Work
from outcome import case

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError


@pytest.fixture
def folder(tmp_path):
    return tmp_path


def clean(method: str, *, bare: bool = False, seed: int = 3) -> Work:
    work = METHODS[method](np.random.default_rng(seed), bare=bare)
    work.campaign["diagnosis"] = {"off": True}
    return work


def evaluated(work: Work, folder):
    return chain.evaluate(load(work.write(folder)))


def refused(work: Work, folder) -> str:
    with pytest.raises(MetrologyError) as error:
        evaluated(work, folder)
    return " ".join(map(str, error.value.faults))


def reasons(findings) -> str:
    return " ".join(text for one in findings.withheld for text in one.reasons)


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_limit_what_agrees_is_judged(method, folder):
    findings = evaluated(clean(method), folder)
    assert [one.verdict for one in findings.conformity] == ["pass", "pass"]


@pytest.mark.long
def test_planted_masses_in_another_unit_contradict_the_modulus_of_reference(folder):
    work = clean("elongation")
    for load_ in work.campaign["tests"]["pull"]["loads"].values():
        load_["mass"] = load_["mass"].replace("kg", "g")
    findings = evaluated(work, folder)
    assert findings.conformity == ()
    assert "Likely: g for kg" in reasons(findings)


@pytest.mark.long
def test_limit_a_reference_that_is_off_as_handbooks_are_bars_nothing(folder):
    work = clean("elongation")
    reference = work.campaign["samples"]["tape"]["references"]["E"]
    value, _, rest = reference["value"].partition(" ")
    reference["value"] = f"{1.5 * float(value):.4g} ± 0.1 {rest.split()[-1]}"
    findings = evaluated(work, folder)
    assert [one.agrees for one in findings.comparisons] == [False]
    assert len(findings.conformity) == 2


@pytest.mark.long
def test_planted_a_relaxation_that_contradicts_the_modulus_of_reference(folder):
    """A handbook's E is what a pull of a minute gives: the instantaneous modulus is compared with it."""
    work = clean("relaxation")
    for name in work.raw:
        work.tables[name]["force / N"] = [1e-3 * force for force in work.tables[name]["force / N"]]
    findings = evaluated(work, folder)
    assert findings.conformity == ()
    assert any("E_0 against handbook" in one.title and not one.agrees for one in findings.comparisons)


@pytest.mark.long
def test_planted_static_and_dynamic_stiffness_that_contradict_are_not_judged(folder):
    work = clean("decay")
    mass = work.campaign["tests"]["swing"]["mass"]
    value = float(mass.split()[0])
    work.campaign["tests"]["swing"]["mass"] = f"{1.2 * value:.4f} ± 0.0001 kg"
    findings = evaluated(work, folder)
    assert findings.conformity == ()
    assert "pull.k and swing.k contradict each other" in reasons(findings)


def _stamps(work: Work, names, factor: float) -> Work:
    for name in names:
        work.tables[name]["time / s"] = [factor * t for t in work.tables[name]["time / s"]]
    return work


@pytest.mark.long
@pytest.mark.parametrize(("factor", "slip"), [(0.5, "a sampling rate off by two"), (1000.0, "ms for s")])
def test_refusal_a_frequency_far_off_the_static_one(factor, slip, folder):
    work = clean("decay")
    text = refused(_stamps(work, work.raw, factor), folder)
    assert f"look for {slip}" in text
    assert f"tests.swing.readings, {work.raw[0]}: got an oscillation" in text


@pytest.mark.long
@pytest.mark.parametrize("factor", [0.001, 1000.0])
def test_refusal_files_of_one_run_that_last_far_from_alike(factor, folder):
    text = refused(_stamps(clean("response"), ["step-cell.csv"], factor), folder)
    assert "step-motion.csv" in text if factor > 1 else "step-cell.csv" in text
    assert "check the unit of time" in text


def test_refusal_one_release_at_another_frequency_than_the_others(folder):
    work = clean("decay", bare=True)
    text = refused(_stamps(work, work.raw[:1], 2.0), folder)
    assert "release-1.csv" in text
    assert "as in the other releases" in text


@pytest.mark.long
def test_refusal_free_fall_that_is_nowhere_on_earth(folder):
    work = clean("elongation")
    work.campaign["tests"]["pull"]["gravity"] = "98.065 m/s^2"
    assert "9.76 m/s^2 to 9.84 m/s^2" in refused(work, folder)
    work.campaign["tests"]["pull"]["gravity"] = {"value": "9.65 m/s^2", "source": "centrifuge, see report 7"}
    assert evaluated(work, folder).results


@pytest.mark.parametrize("factor", [1e-3, 3.0])
def test_refusal_a_section_that_the_linear_density_contradicts(factor, folder):
    work = clean("elongation")
    sample = work.campaign["samples"]["tape"]
    value, unit = sample["linear_density"].split()
    sample["linear_density"] = f"{factor * float(value):.5g} {unit}"
    assert "check the section and the units" in refused(work, folder)


@pytest.mark.long
def test_refusal_a_density_of_no_material(folder):
    work = clean("elongation")
    sample = work.campaign["samples"]["tape"]
    del sample["density"]
    assert evaluated(work, folder).results
    sample["linear_density"] = sample["linear_density"].replace("g/m", "kg/m")
    assert "100 kg/m^3 to 2.26e+04 kg/m^3" in refused(work, folder)


def test_refusal_a_line_that_is_twice_as_long(folder):
    work = clean("elongation")
    table = work.tables["elongation.csv"]
    table["reading / m"] = [1e3 * value for value in table.pop("reading / mm")]
    assert "a strain below 100 %" in refused(work, folder)


@pytest.mark.long
@pytest.mark.parametrize("method", ["tension", "relaxation"])
def test_planted_a_specimen_that_is_twice_as_long_is_not_judged_unless_it_is_accepted(method, folder):
    """Stretch in um that stands as mm, where nothing is known twice; of an elastomer the laboratory says so."""
    work = clean(method, bare=True)
    for name in work.raw:
        table = work.tables[name]
        for heading in table.keys() & {"crosshead / mm", "extension / um"}:
            table[heading] = [1e3 * value for value in table[heading]]
    findings = evaluated(work, folder)
    assert findings.conformity == ()
    assert "failed the check 'raw records'" in reasons(findings)
    (test,) = work.campaign["tests"].values()
    test["accepted"] = [{"check": "raw records", "by": "A. Person", "reason": "a band of rubber"}]
    assert len(evaluated(work, folder).conformity) == 2


@pytest.mark.parametrize("way", ["shifted", "cut", "rounded"])
def test_refusal_a_copy_with_other_stamps_or_fewer_readings(way, folder):
    work = clean("decay")
    first, second = work.raw[:2]
    copied = {heading: list(values) for heading, values in work.tables[first].items()}
    if way == "shifted":
        copied["time / s"] = [t + 0.25 for t in copied["time / s"]]
    elif way == "rounded":
        copied["displacement / um"] = [float(f"{x + 1e-5:.8g}") for x in copied["displacement / um"]]
    else:
        copied = {heading: values[300:-200] for heading, values in copied.items()}
    work = replace(work, tables={**work.tables, second: copied})
    assert f"of '{first}' a second time" in refused(work, folder)


@pytest.mark.long
def test_planted_a_record_that_stopped_is_not_judged_and_not_diagnosed(folder):
    work = clean("decay")
    work.campaign["diagnosis"] = {"off": False}
    values = work.tables[work.raw[0]]["displacement / um"]
    values[700:1100] = [values[700]] * 400
    findings = evaluated(work, folder)
    assert findings.conformity == ()
    assert "failed the check 'raw records'" in reasons(findings)
    assert any("cannot explain what its recorder did" in text for text in findings.warnings)


@pytest.mark.long
def test_planted_a_fit_that_nothing_diagnosed_and_that_leaves_more_than_noise_is_not_judged(folder):
    work = clean("response")
    cell = work.tables["step-cell.csv"]
    cell["T / N"] = [1.3 * force for force in cell["T / N"]]
    findings = evaluated(work, folder)
    assert findings.conformity == ()
    assert "times the noise of its readings" in reasons(findings)


@pytest.mark.long
def test_planted_a_supported_model_without_a_result_ends_in_a_report():
    # Its diagnosis finds an oscillator that no longer swings.
    assert case("decay", "quantise", 2).outcome in ("flagged", "within 4 u")
