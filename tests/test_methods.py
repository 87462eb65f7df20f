"""A method is one record: each has all that belongs to one, a half-added one is refused, and a new one runs at once."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import MISSING, fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rig_folder

from metrology import chain, units
from metrology.campaign.documentation import reference
from metrology.campaign.json_schema import schema
from metrology.campaign.load import load
from metrology.errors import Fault, MetrologyError
from metrology.findings import TestItem
from metrology.findings import json_schema as results_schema
from metrology.method import discovery
from metrology.method.discovery import templates
from metrology.method.record import Method
from metrology.methods import METHODS

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"`([\w./-]+)`:\n\n```\w+\n(.*?)```", re.DOTALL)
TUTORIAL = "## Add a method: three-point bending"
NAMES = sorted(METHODS)
DOCS = {one.name: one.metadata["doc"] for one in fields(Method)}
FIELDS = list(DOCS)


def tutorial() -> dict[str, str]:
    """The files of the tutorial by their paths."""
    return dict(BLOCK.findall((ROOT / "docs" / "extend.md").read_text(encoding="utf-8").partition(TUTORIAL)[2]))


# ---- methods × duties -----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", NAMES)
def test_law_a_campaign_file_can_declare_a_test_by_every_method(name):
    tests = schema()["$defs"][METHODS[name].test.__name__]
    assert tests["properties"]["method"]["const"] == name
    assert f"## `tests`: method `{name}`" in reference()
    assert f"| `{name}` | {METHODS[name].columns} |" in reference()


@pytest.mark.parametrize("name", NAMES)
def test_law_results_json_has_what_every_method_shows(name):
    method, found = METHODS[name], results_schema()["$defs"]
    entry = found["TestItem"]["properties"][name]
    assert entry["description"] == method.shown
    assert {"$ref": f"#/$defs/{method.finding.__name__}"} in entry["anyOf"]
    assert "equations" in found[method.finding.__name__]["properties"]


@pytest.mark.parametrize("name", NAMES)
def test_law_every_result_has_units_of_one_dimension_and_words(name):
    for output in METHODS[name].outputs.values():
        assert units.dimension(output.unit) == units.dimension(output.shown)
        assert output.word


@pytest.mark.parametrize("name", NAMES)
def test_law_every_method_has_its_plots_its_template_and_its_description(name):
    assert callable(import_module(f"metrology.report.figures.{name}").jobs)
    assert f"test.{name}" in (templates() / f"{name}.html").read_text(encoding="utf-8")
    assert f"docs/methods/{name}.md" in METHODS[name].standard
    assert (ROOT / "docs" / "methods" / f"{name}.md").read_text(encoding="utf-8").startswith("# ")


def test_law_methods_stand_after_those_whose_results_they_take():
    order = list(METHODS)
    assert all(order.index(other) < order.index(name) for name in order for other in METHODS[name].takes)


def test_law_every_field_of_a_record_is_required_and_says_what_it_holds():
    assert [one.name for one in fields(Method) if one.default is not MISSING or not one.metadata.get("doc")] == []


def swinging(folder: Path) -> Path:
    """A response test of a mass on a spring, by its closed form with a little scatter."""
    t, rng, m, k, c = np.arange(0.0, 12.0, 0.05), np.random.default_rng(5), 2.0, 50.0, 0.8
    rate, omega = c / (2 * m), np.sqrt(k / m - (c / (2 * m)) ** 2)
    runs = []
    for number, size in enumerate((0.05, 0.04, 0.05, 0.04)):
        x = size * np.exp(-rate * t) * (np.cos(omega * t) + rate / omega * np.sin(omega * t))
        columns = [t, x + rng.normal(0.0, 1e-4, len(t))]
        runs.append(rig_folder.run(number, [("time / s,x / m", columns)], f"start: {{position: {size} m}}"))
    stated = (
        "    rig: {mass: 2.000 kg, taut: 0 m, attachment: both ways, line_weight: none}\n"
        "    known: {mass: {common: 1 g}}\n"
        "    identification: {free: [k, c], start: {k: 45 N/m}}\n"
    )
    return rig_folder.written(folder, stated, runs)


@pytest.mark.long
@pytest.mark.parametrize("name", ["tapes", "rig"])
def test_law_every_test_gives_the_results_that_its_method_yields(name, monkeypatch, tmp_path):
    monkeypatch.setattr("metrology.chain.diagnosis.add", lambda *_args, **_more: None)
    campaign = load(swinging(tmp_path) if name == "rig" else ROOT / "campaigns" / name / "campaign.yaml")
    plan = chain.build(campaign)
    given = {measurand.name: measurand for measurand in plan.measurands}
    for test in plan.tests:
        method = METHODS[test.method]
        assert isinstance(test.finding, method.finding)
        promised = method.yields(campaign, campaign.tests[test.id])
        assert promised.keys() == method.outputs.keys() - ({"E"} if name == "rig" else set())
        for quantity, unit in promised.items():
            full = f"{test.id}.{quantity}"
            identity = plan.identities[full]
            assert (identity.method, given[full].unit) == (test.method, unit)
            assert identity.display_unit == method.outputs[quantity].shown


def test_law_what_is_shown_is_by_a_method_that_there_is_whatever_the_file_says():
    item = TestItem("a", "../decay", "", "", "", "", "", (), (), (), (), elongation="found")
    assert (item.by, item.finding) == ("elongation", "found")
    assert TestItem("a", "id", "", "", "", "", "", (), (), (), ()).finding is None


# ---- a method that is half added ------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def overlay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with the files of the tutorial, and nothing else, added."""
    home = tmp_path_factory.mktemp("overlay")
    for part in ("metrology", "templates", "docs/methods"):
        shutil.copytree(ROOT / part, home / part, ignore=shutil.ignore_patterns("__pycache__"))
    for path, text in tutorial().items():
        target = home / path
        assert not target.exists(), f"{path} is there without the tutorial"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    return home


def ran(home: Path, command: str, *options: str) -> subprocess.CompletedProcess[str]:
    """A command of the copy, from its folder, on the campaign of the tutorial."""
    environment = {**os.environ, "PYTHONPATH": str(home)}
    full = [sys.executable, "-m", "metrology", command, *options, "campaigns/bar/campaign.yaml"]
    return subprocess.run(full, cwd=home, env=environment, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture
def discovered(overlay, tmp_path, monkeypatch):
    """What is found where the record of the tutorial is changed, or the copy of the package stands for ours."""
    monkeypatch.setattr(discovery, "PACKAGE", overlay / "metrology")
    monkeypatch.syspath_prepend(tmp_path)
    package = f"half_{tmp_path.name}"
    (tmp_path / package).mkdir()

    def find(old: str = "", new: str = "") -> dict[str, Method[Any, Any]]:
        text = tutorial()["metrology/methods/bending.py"]
        assert old in text
        (tmp_path / package / "bending.py").write_text(text.replace(old, new), encoding="utf-8")
        return discovery.discover([str(tmp_path / package)], package)

    return find


def refused(find, *change: str) -> list[Fault]:
    with pytest.raises(MetrologyError) as caught:
        find(*change)
    return list(caught.value.faults)


def record(name: str) -> str:
    """The line of the tutorial's record that states a field."""
    return re.search(rf"    {name}=.*\n", tutorial()["metrology/methods/bending.py"].partition("METHOD = ")[2])[0]


def test_law_the_method_of_the_tutorial_is_found(discovered):
    assert list(discovered()) == ["bending"]


@pytest.mark.parametrize("name", FIELDS)
def test_refusal_a_field_that_a_record_lacks(name, discovered):
    (fault,) = refused(discovered, record(name), "")
    assert fault.where.endswith(".bending")
    assert fault.got == f"a METHOD without {name}"
    assert DOCS[name][1:].rstrip(".") in fault.expected
    assert "docs/extend.md" in fault.fix


@pytest.mark.parametrize("name", [name for name in FIELDS if name not in discovery.OPTIONAL and name != "test"])
def test_refusal_a_field_that_is_empty(name, discovered):
    found = refused(discovered, record(name), f"    {name}=(),\n")
    assert found[0].got == f"a METHOD with an empty {name}"


@pytest.mark.parametrize(
    ("old", "new", "got", "expected"),
    [
        ("METHOD = Method(", "RECORD = Method(", "no METHOD", "METHOD = Method(…)"),
        ("    test=BendingTest", "    test=BendingFinding", "BendingFinding", "a class derived from"),
        ('Literal["bending"]', 'Literal["bend"]', "no 'method' of its own", 'Literal["bending"]'),
        (
            "    instruments: BendingInstruments",
            "    gauges: BendingInstruments",
            "no 'instruments'",
            "instruments used",
        ),
        ("    finding=BendingFinding", "    finding=BendingTest", "no 'equations'", "equations: tuple[str, ...]"),
        ("references=()", 'references=("bernoulli",)', "'bernoulli'", "metrology/references.py"),
        ("takes=()", 'takes=("torsion",)', "'torsion'", "a method, one of bending"),
        ("takes=()", 'takes=("bending",)', "results of one another: bending", "no circle"),
    ],
)
def test_refusal_what_a_record_must_hold(discovered, old, new, got, expected):
    fault = refused(discovered, old, new)[0]
    assert got in fault.got
    assert expected in fault.expected


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("metrology/report/figures/bending.py", "of method 'bending', how its plots are drawn"),
        ("templates/bending.html", "of method 'bending', its part of the report"),
        ("docs/methods/bending.md", "of method 'bending', its description"),
    ],
)
def test_refusal_a_file_that_is_not_there(path, expected, discovered, overlay):
    content = (overlay / path).read_bytes()
    (overlay / path).unlink()
    try:
        (fault,) = refused(discovered)
    finally:
        (overlay / path).write_bytes(content)
    assert fault.where == str(overlay / path)
    assert fault.got == "no such file"
    assert expected in fault.expected


def test_refusal_a_result_that_is_promised_and_not_given(monkeypatch):
    campaign = load(ROOT / "campaigns" / "tapes" / "campaign.yaml")
    method = METHODS["elongation"]
    promising = replace(method, yields=lambda *of: {**method.yields(*of), "G": "Pa"})
    monkeypatch.setattr("metrology.chain.methods.METHODS", {**METHODS, "elongation": promising})
    with pytest.raises(MetrologyError) as caught:
        chain.build(campaign)
    (fault,) = caught.value.faults
    assert fault.got == "no result G by method 'elongation', and no failure"
    assert "metrology.methods.elongation" in fault.fix


# ---- a new method: the tutorial, run --------------------------------------------------------------------------------
def test_refusal_the_program_tells_of_a_half_added_method(overlay):
    path = overlay / "metrology" / "methods" / "bending.py"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(record("check"), ""), encoding="utf-8")
    try:
        done = ran(overlay, "check")
    finally:
        path.write_text(text, encoding="utf-8")
    assert done.returncode == 2
    assert "a METHOD without check" in " ".join(done.stderr.split())


@pytest.mark.long
def test_law_the_method_of_the_tutorial_runs_from_its_campaign_to_its_report(overlay):
    checked = ran(overlay, "check")
    assert (checked.returncode, checked.stderr) == (0, "")
    run = ran(overlay, "run", "--json")
    assert run.returncode == 0, run.stderr
    k, E = (
        next(entry for entry in json.loads(run.stdout)[0]["results"] if entry["name"] == f"bend.{symbol}")
        for symbol in "kE"
    )
    # Closed form: the slope by the normal equations, over the readings of the tutorial.
    slope = np.polyfit(*readings(), 1)[0] * 1e-3
    stiffness, modulus = (entry["framework"]["value"] for entry in (k, E))
    assert stiffness == pytest.approx(1 / slope, rel=1e-12)
    assert modulus == pytest.approx(stiffness * 0.2**3 / (48 * 0.020 * 0.003**3 / 12), rel=1e-12)
    assert (E["unit"], E["display_unit"], E["method"]) == ("Pa", "GPa", "bending")
    assert {row["input"] for row in E["budget"]} == {"bend.line.b", "bend.span", "bar.width", "bar.thickness"}
    reported = ran(overlay, "report")
    assert reported.returncode == 0, reported.stderr
    page = (overlay / "reports" / "bar" / "report.html").read_text(encoding="utf-8")
    assert "Three-point bending" in page
    assert "stiffness" in page
    assert "Deflection in the middle of the bar against load" in page
    assert "deflection against load for 6 readings" in page
    assert f"{E['value'] / 1e9:.1f}" in page


def readings() -> tuple[list[float], list[float]]:
    rows = [line.split(",") for line in tutorial()["campaigns/bar/bar.csv"].splitlines()[1:]]
    return [float(row[0]) for row in rows], [float(row[1]) for row in rows]
