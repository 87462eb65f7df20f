"""Exports for simulations and estimators, read back by parsers of others and held against closed forms."""

from __future__ import annotations

import csv
import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from io import StringIO
from math import cos, exp, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
import yaml

import metrology
from metrology.cli import main
from metrology.errors import MetrologyError
from metrology.export.forms import FORMS
from metrology.findings import AsStated, Findings

SAMPLE = {
    "length": "2.000(1) m",
    "section": {"shape": "round", "diameter": "0.500(2) mm"},
    "linear_density": "1.54(1) g/m",
}
TIME = np.arange(0, 4, 1 / 500)


@pytest.fixture(scope="module")
def swung() -> metrology.Results:
    """One free decay: k = m·ω², c = 2·ζ·m·ω of a line of two metres."""
    motion = [1e-3 * exp(-2 * t) * cos(100 * t) for t in TIME]
    read = np.array(motion) + 1e-6 * np.random.default_rng(3).standard_normal(TIME.size)
    table = {"time / s": TIME, "displacement / m": read}
    stated = {"mass": "1.196(1) kg", "instruments": {"displacement": {"resolution": "1 um"}}, "sample": SAMPLE}
    return metrology.identify("decay", readings=[table], **stated)


@pytest.fixture(scope="module")
def swing(swung) -> Findings:
    return swung.findings


@pytest.fixture(scope="module")
def pull() -> Findings:
    read = {
        "load": [*"ABCABC"],
        "repeat": [1] * 3 + [2] * 3,
        "reading / mm": np.array([0.41, 0.79, 1.2, 0.4, 0.81, 1.19]),
    }
    loads = {name: {"force": f"{10 * at}.0(1) N"} for at, name in enumerate("ABC", 1)}
    gauge = {"extension": {"resolution": "0.01 mm"}}
    return metrology.identify("elongation", readings=read, loads=loads, instruments=gauge, sample=SAMPLE).findings


def of(findings: Findings, name: str):
    return next(one for one in findings.results if one.name == name)


def rows(content: bytes, separator: str = ",") -> list[dict[str, str]]:
    return list(csv.DictReader(StringIO(content.decode()), delimiter=separator))


@pytest.fixture(scope="module")
def greek() -> Findings:
    """Two samples, and two tests, whose names have no letter that other programs take; nor has a third's, in part."""
    rng = np.random.default_rng(3)
    tests = {}
    for name, mass in (("α", 1.0), ("β", 2.0), ("a-b", 3.0), ("A_b", 4.0)):
        read = 1e-3 * np.exp(-2 * TIME) * np.cos(100 * TIME) + 1e-6 * rng.standard_normal(TIME.size)
        table = {"time / s": TIME, "displacement / m": read}
        tests[name] = {"method": "decay", "sample": name, "instruments": {"displacement": "g"}, "mass": f"{mass} kg",
                       "readings": [table]}  # fmt: skip
    stated = {"format": "metrology-campaign/1", "id": "x", "title": "T", "diagnosis": {"off": True},
              "monte_carlo": {"max_trials": 1000, "digits": 1},
              "instruments": {"g": {"kind": "g", "resolution": "1 um"}},
              "samples": {name: {"material": "steel", "length": "1 m"} for name in tests}, "tests": tests}  # fmt: skip
    return metrology.run(stated, coverage=False).findings


# ---- MoorDyn ------------------------------------------------------------------------------------------------------
def line_types(content: bytes) -> list[dict[str, str]]:
    """Read the section as MoorDyn's documentation has it: a header, two lines of headings, a row a type."""
    lines = [line.partition("#")[0].strip() for line in content.decode().splitlines()]
    start = next(at for at, line in enumerate(lines) if line.startswith("---") and "LINE TYPES" in line)
    names = lines[start + 1].split()
    return [dict(zip(names, line.split(), strict=True)) for line in lines[start + 3 :] if line]


def test_closed_form_line_types_are_the_line_stretched_and_weighed(swing):
    """A series of n segments of MoorDyn, EA/(L/n) and BA/(L/n) each, is the k and c that were measured."""
    (line,) = line_types(FORMS["moordyn"](swing, ()))
    number = {name: float(text) for name, text in line.items() if name != "TypeName"}
    segments = 20
    assert number["EA"] / (2.0 / segments) / segments == pytest.approx(of(swing, "decay.k").value, rel=1e-15)
    assert number["BA/-zeta"] / (2.0 / segments) / segments == pytest.approx(of(swing, "decay.c").value, rel=1e-15)
    assert number["Mass/m"] * 2.0 == pytest.approx(3.08e-3, rel=1e-12)
    assert number["Diam"] == pytest.approx(0.5e-3, rel=1e-12)
    assert [number[name] for name in ("EI", "Cd", "Ca", "CdAx", "CaAx")] == [0] * 5


def test_law_no_comment_begins_a_section(swing):
    campaign = replace(swing.campaign, reconstructed="Made --- LINES --- up.")
    text = FORMS["moordyn"](replace(swing, campaign=campaign), ()).decode()
    assert [line for line in text.splitlines() if "---" in line] == [f"{' LINE TYPES ':-^80}"]
    assert "Reconstructed: Made - -- LINES - -- up." in text


def test_closed_form_u_of_the_axial_stiffness(swing):
    k, text = of(swing, "decay.k"), FORMS["moordyn"](swing, ()).decode()
    u = sqrt((2 * k.u) ** 2 + (k.value * 0.001) ** 2)
    assert f"u(EA) = {u:.2g}," in text
    assert f"u(Diam) = {2e-6:.2g}," in text


@pytest.mark.parametrize(("section", "area"), [
    ("tape, width 25.000 ± 0.029 mm, thickness 0.0500 ± 0.0027 mm", 25e-3 * 0.05e-3),
    ("ellipse, width 2.00 mm, height 1.50 mm", pi * 2e-3 * 1.5e-3 / 4),
    ("area, area 1.25 mm²", 1.25e-6),
])  # fmt: skip
def test_closed_form_the_diameter_has_the_area_of_the_section(swing, section, area):
    sample = replace(swing.samples[0], section=section)
    (line,) = line_types(FORMS["moordyn"](replace(swing, samples=(sample,)), ()))
    assert pi * float(line["Diam"]) ** 2 / 4 == pytest.approx(area, rel=1e-12)


# ---- MuJoCo -------------------------------------------------------------------------------------------------------
def test_law_tendons_carry_k_c_and_pull_only(swing):
    root = ET.fromstring(FORMS["mujoco"](swing, ()))
    (spatial,) = root.findall("tendon/spatial")
    assert float(spatial.get("stiffness")) == of(swing, "decay.k").value
    assert float(spatial.get("damping")) == of(swing, "decay.c").value
    assert [float(end) for end in spatial.get("springlength").split()] == [0.0, 2.0]
    assert [site.get("site") for site in spatial] == ["sample_1", "sample_2"]


def test_law_comments_hold_u_notices_and_the_model_as_stated(swing):
    """Also a text that no comment of XML may hold."""
    told = AsStated(11000.0, 12.0, "the model is extended -- by friction")
    k = replace(of(swing, "decay.k"), stated=told)
    results = tuple(k if one.name == k.name else one for one in swing.results)
    campaign = replace(swing.campaign, reconstructed="Made up --> for a test.")
    content = FORMS["mujoco"](replace(swing, results=results, campaign=campaign), ())
    parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))
    comments = [node.text for node in ET.fromstring(content, parser).iter(ET.Comment)]
    assert any("Reconstructed: Made up" in text for text in comments)
    assert any("Instrument: displacement: no certificate is declared." in text for text in comments)
    assert any(
        "± 10 N/m (± u), from decay.k; by the model as stated 11000 ± 12: the model" in text for text in comments
    )


# ---- tables -------------------------------------------------------------------------------------------------------
def test_law_tables_hold_every_number_of_the_results(swing):
    made = FORMS["table"](swing, ())
    for row, result in zip(rows(made["parameters.csv"]), swing.results, strict=True):
        assert row["parameter"] == result.name
        assert (float(row["value"]), float(row["u"]), row["unit"]) == (result.value, result.u, result.unit)
        assert row["distribution"] == (
            "monte carlo" if not result.monte_carlo.law_valid else "t" if result.dof else "normal"
        )
    told = json.loads(made["parameters.json"])
    matrix = np.array(told["correlations"]["matrix"])
    assert np.all(np.linalg.eigvalsh(matrix) > -1e-9)
    assert np.array_equal(matrix, matrix.T)
    names = told["correlations"]["names"]
    for pair in swing.correlations:
        assert matrix[names.index(pair.a), names.index(pair.b)] == pair.coefficient
    listed = {row[""]: row for row in rows(made["correlations.csv"])}
    assert float(listed["decay.k"]["decay.c"]) == matrix[names.index("decay.k"), names.index("decay.c")]


def test_law_tables_hold_the_motion_that_was_measured_and_simulated(swing):
    made = FORMS["table"](swing, ())
    (entry,) = json.loads(made["parameters.json"])["series"]
    series = rows(made[entry["file"]])
    assert (entry["unit"], entry["readings"], entry["kept"]) == ("m", 2000, len(series))
    at = [round(float(row["time"]) * 500) for row in series]
    measured, simulated = (np.array([float(row[name]) for row in series]) for name in ("measured", "simulated"))
    assert np.std(measured - simulated) == pytest.approx(entry["noise"], rel=0.1)
    assert len(at) == len(set(at))


def test_law_tables_of_chosen_results_alone(swing):
    told = json.loads(FORMS["table"](swing, ["decay.k", "decay.c"])["parameters.json"])
    assert told["correlations"]["names"] == [one["parameter"] for one in told["parameters"]] == ["decay.k", "decay.c"]


def test_law_held_out_runs_are_measured_simulated_and_banded(swing):
    """A gap is an empty cell, in the tables and of the numbers that the results hold."""
    run = {"channel": "T", "unit": "N", "time": [0.0, 0.1], "measured": [1.0, None], "simulated": [1.1, 1.2],
           "low": [1.0, 1.1], "high": [1.2, 1.3], "count": 2}  # fmt: skip
    told = {"verdict": "not validated", "sentence": "Not so."}
    check = {"test": "step", "basis": "extended", **told, "runs": [{"run": "one", **told, "series": [run]}]}
    made = FORMS["table"](replace(swing, verification=(check,)), ())
    assert rows(made["series/step-one-extended-T.csv"]) == [
        {"time": "0.0", "measured": "1.0", "simulated": "1.1", "low": "1.0", "high": "1.2"},
        {"time": "0.1", "measured": "", "simulated": "1.2", "low": "1.1", "high": "1.3"},
    ]


def test_planted_names_that_would_be_one_are_numbered(greek):
    """Masses of 1 kg to 4 kg at one frequency: stiffnesses as 1 to 4, each in its own tendon, parameter and table."""
    assert len([name for name in FORMS["table"](greek, ()) if name.startswith("series/")]) == 4
    tendons = list(ET.fromstring(FORMS["mujoco"](greek, ())).iter("spatial"))
    assert len({one.get("name").casefold() for one in tendons}) == 4
    assert [float(one.get("stiffness")) / 1e4 for one in tendons] == pytest.approx([1, 2, 3, 4], rel=1e-2)
    made = FORMS["petab"](greek, ())
    of_k = {row["parameterId"]: row for row in rows(made["parameters.tsv"], "\t") if row["parameterId"].startswith("k")}
    assert [float(row["nominalValue"]) / 1e4 for row in of_k.values()] == pytest.approx([1, 2, 3, 4], rel=1e-2)
    used = {(row["observableId"], row["simulationConditionId"]) for row in rows(made["measurements.tsv"], "\t")}
    assert len(used) == len({one for one, _ in used}) == len({one for _, one in used}) == 4


# ---- PEtab --------------------------------------------------------------------------------------------------------
def test_closed_form_an_elongation_is_a_whole_problem_whose_optimum_is_k(pull):
    """Least squares over the tables alone, by NumPy, ends at the nominal values."""
    made = FORMS["petab"](pull, ())
    problem = yaml.safe_load(made["problem.yaml"])
    assert problem["format_version"] == 1
    (files,) = problem["problems"]
    assert {problem["parameter_file"], *(name for names in files.values() for name in names)} == {*made} - {
        "problem.yaml"
    }
    parameters = {row["parameterId"]: row for row in rows(made["parameters.tsv"], "\t")}
    (observable,) = rows(made["observables.tsv"], "\t")
    assert observable["observableFormula"] == "x0_elongation + observableParameter1_x_elongation / k_elongation"
    measured = rows(made["measurements.tsv"], "\t")
    force, read = (np.array([float(row[name]) for row in measured]) for name in ("observableParameters", "measurement"))
    slope, zero = np.polyfit(force, read, 1)
    assert 1 / slope == pytest.approx(float(parameters["k_elongation"]["nominalValue"]), rel=1e-3)
    assert zero == pytest.approx(float(parameters["x0_elongation"]["nominalValue"]), abs=1e-9)
    residual = read - zero - slope * force
    assert float(measured[0]["noiseParameters"]) == pytest.approx(sqrt(residual @ residual / 4), rel=1e-3)
    for row in parameters.values():
        assert float(row["lowerBound"]) < float(row["nominalValue"]) < float(row["upperBound"])
    assert {row["simulationConditionId"] for row in measured} == {
        row["conditionId"] for row in rows(made["conditions.tsv"], "\t")
    }
    assert ET.fromstring(made["model.xml"]).get("level") == "3"


def test_law_parameters_are_those_that_are_named(swing):
    below = replace(of(swing, "decay.k"), name="decay.cubic", quantity="cubic", value=-3.0, u=0.1)
    made = FORMS["petab"](replace(swing, results=(*swing.results, below)), ["decay.c", "decay.cubic"])
    found = {row["parameterId"]: row for row in rows(made["parameters.tsv"], "\t")}
    assert set(found) == {"c_decay", "cubic_decay"}
    assert (float(found["cubic_decay"]["lowerBound"]), float(found["cubic_decay"]["upperBound"])) == (-4.0, -2.0)


def test_law_a_motion_needs_the_reader_s_own_model(swing):
    made = FORMS["petab"](swing, ())
    assert "model.xml" not in made
    assert {row["parameterId"] for row in rows(made["parameters.tsv"], "\t")} == {"k_decay", "c_decay"}
    (observable,) = rows(made["observables.tsv"], "\t")
    assert (observable["observableId"], observable["observableFormula"]) == ("x_decay", "x")
    assert f"{len(rows(made['measurements.tsv'], chr(9)))} of 2000 readings" in made["problem.yaml"].decode()


# ---- the command --------------------------------------------------------------------------------------------------
def test_twice_the_command_and_python_write_the_same(swung, tmp_path, capsysbinary):
    (tmp_path / "results.json").write_bytes(swung.to_json())
    for form in FORMS:
        assert main(["export", form, str(tmp_path / "results.json"), "--output", str(tmp_path / "a" / form)]) == 0
        swung.export(form, tmp_path / "b" / form)
    assert files_below(tmp_path / "a") == files_below(tmp_path / "b")
    assert {"moordyn", "mujoco", "table/parameters.json", "petab/problem.yaml"} < set(files_below(tmp_path / "a"))
    assert main(["export", "moordyn", str(tmp_path / "results.json")]) == 0
    assert capsysbinary.readouterr().out == (tmp_path / "a" / "moordyn").read_bytes()
    with pytest.raises(MetrologyError, match="form: got 'excel'; expected one of moordyn, mujoco, table, petab"):
        swung.export("excel", tmp_path / "c")


def files_below(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# ---- refusals -----------------------------------------------------------------------------------------------------
def refused(form: str, findings: Findings, *use: str) -> str:
    with pytest.raises(MetrologyError) as caught:
        FORMS[form](findings, use)
    return str(caught.value)


def test_refusal_of_a_sample_that_lacks_what_a_form_needs(swing, pull):
    bare = replace(swing, samples=(replace(swing.samples[0], length="", section="", linear_density=""),))
    assert "length of sample 'sample': got nothing; expected a quantity in m. Fix: state it" in refused("mujoco", bare)
    thin = replace(swing, samples=(replace(swing.samples[0], linear_density=""),))
    assert "linear_density of sample 'sample': got nothing; expected a quantity in kg/m" in refused("moordyn", thin)
    assert "section of sample 'sample': got nothing; expected {shape: round" in refused(
        "moordyn", replace(swing, samples=(replace(swing.samples[0], section=""),))
    )
    assert "c of sample 'sample': got no result; expected a test that gives it, in N·s/m" in refused("mujoco", pull)


def test_refusal_of_several_results_until_one_is_named(swing):
    again = replace(of(swing, "decay.k"), name="other.k", value=12000.0)
    both = replace(swing, results=(*swing.results, again))
    assert "k of sample 'sample': got 2 results; expected one of decay.k, other.k. Fix: say which" in refused(
        "mujoco", both
    )
    root = ET.fromstring(FORMS["mujoco"](both, ["other.k"]))
    assert root.find("tendon/spatial").get("stiffness") == "12000.0"
    assert "--use: got 'nobody.k'; expected one of " in refused("mujoco", both, "nobody.k")
    assert "--use: got 'nobody.k'; expected one of " in refused("table", both, "nobody.k")


def test_refusal_of_a_line_that_turns_and_of_no_line_at_all(swing):
    turned = tuple(replace(one, unit="N·m/rad") if one.quantity == "k" else one for one in swing.results)
    assert "'decay.k' in N·m/rad; expected N/m" in refused("mujoco", replace(swing, results=turned))
    assert "got no result k of a sample" in refused("moordyn", replace(swing, results=()))
    assert "got no readings for an estimate" in refused("petab", replace(swing, results=()))
