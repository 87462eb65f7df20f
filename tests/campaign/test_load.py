"""What a good campaign file becomes, and that a bad one never becomes anything but faults."""

from __future__ import annotations

import json
import math
import shutil
from datetime import date
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from good_campaign import CAMPAIGN
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

import metrology
from metrology.campaign.documentation import reference
from metrology.campaign.json_schema import schema, schema_json
from metrology.campaign.load import load
from metrology.campaign.starter import create
from metrology.declaration.quantity import Stated
from metrology.errors import Fault, MetrologyError

ROOT = Path(__file__).parents[2]


def test_reference_good_campaign(folder: Path) -> None:
    campaign = load("campaign.yaml")
    assert campaign.folder.resolve() == folder.resolve()
    assert campaign.instruments["indicator"].serial == "0123"
    assert campaign.instruments["vibrometer"].serial == "no"
    assert campaign.samples["al"].batch == "1e3"
    assert campaign.tests["al-elongation"].date == date(2026, 10, 5)
    assert campaign.tests["al-decay"].date is None
    assert campaign.at("tests", "al-elongation", "loads", "A") == "campaign.yaml:91:7 tests.al-elongation.loads.A"
    assert campaign.at("derived", 0, "where", "t") == "campaign.yaml:143:38 derived[0].where.t"
    assert [derived.name for derived in campaign.names.order] == ["al.E", "R", "x_max", "s", "al.half"]
    assert campaign.names.meanings["derived", 0] == {
        "k_1": "al-elongation.k",
        "length": "al.length",
        "t": "al.thickness",
        "width": "al.width",
    }
    assert [file.path for file in campaign.files] == [
        "campaign.yaml",
        "elongation.csv",
        "decay-1.csv",
        "decay-2.csv",
        "bridge.csv",
        "calibration.csv",
    ]


def test_reference_readings_are_in_si_and_read_only(folder: Path) -> None:
    (table,) = load("campaign.yaml").tables["tests", "al-elongation"]
    assert table.texts["load"][:4] == ("A", "B", "C", "A")
    assert table.numbers["reading"][:3] == pytest.approx([0.00041, 0.00081, 0.00121], rel=1e-15)
    assert table.lines[:3].tolist() == [2, 3, 4]
    with pytest.raises(ValueError, match="read-only"):
        table.numbers["reading"][0] = 1.0


def test_law_a_campaign_is_immutable(folder: Path) -> None:
    campaign = load("campaign.yaml")
    with pytest.raises(ValidationError, match="frozen"):
        campaign.samples["al"].name = "other"
    with pytest.raises(TypeError):
        campaign.samples["new"] = campaign.samples["al"]  # type: ignore[index]


@pytest.mark.parametrize(
    ("stated", "u"),
    [
        ("25.00(5) mm", 5e-5),
        ("25.00 ± 0.05 mm", 5e-5),
        ({"standard": "50 um"}, 5e-5),
        ({"standard": "2 %"}, 0.02 * 0.025),
        ({"half_width": "1 mm", "distribution": "rectangular"}, 1e-3 / math.sqrt(3)),
        ({"half_width": "1 mm", "distribution": "triangular"}, 1e-3 / math.sqrt(6)),
        ({"half_width": "1 mm", "distribution": "arcsine"}, 1e-3 / math.sqrt(2)),
        ({"half_width": "1 mm", "distribution": "trapezoidal", "beta": "0.5"}, 1e-3 * math.sqrt(1.25 / 6)),
        (
            {"half_width": "1 mm", "distribution": "curvilinear-trapezoid", "limit_half_width": "0.1 mm"},
            math.sqrt(1e-6 / 3 + 1e-8 / 9),
        ),
        ({"expanded": "0.2 mm", "k": "2"}, 1e-4),
        ({"expanded": "0.2 mm", "p": "0.95"}, 2e-4 / 1.959963984540054),
        ({"expanded": "0.2 mm", "p": "0.95", "dof": "4"}, 2e-4 / 2.7764451051977987),
        ({"scale": "0.2 mm", "distribution": "student", "dof": "4"}, 2e-4),
        ({"standard": "0.2 mm", "distribution": "student", "dof": "4"}, 2e-4),
    ],
)
def test_closed_form_standard_uncertainty(stated: str | dict[str, str], u: float) -> None:
    """JCGM 100 4.3 and JCGM 101 6.4: u of each way to state a component."""
    data = stated if isinstance(stated, str) else {"value": "25.00 mm", "uncertainty": [stated]}
    quantity = Stated.model_validate(data).input("w")
    assert quantity.value == 0.025
    assert quantity.unit == "m"
    assert quantity.u == pytest.approx(u, rel=1e-9)


def test_closed_form_student_stated_by_its_deviation_draws_with_that_deviation() -> None:
    stated = {"value": "1 m", "uncertainty": [{"standard": "0.2 mm", "distribution": "student", "dof": "4"}]}
    (component,) = Stated.model_validate(stated).components
    assert component.distribution.deviation == pytest.approx(2e-4)


def test_limit_uncertainty_of_a_celsius_temperature_is_a_difference() -> None:
    stated = {"value": "20.0 degC", "uncertainty": [{"standard": "0.5 degC"}, {"standard": "0.5 K"}]}
    quantity = Stated.model_validate(stated).input("T")
    assert (quantity.value, quantity.u) == (293.15, pytest.approx(math.sqrt(0.5)))


def test_twice_schema_and_documentation_are_those_in_docs() -> None:
    assert (ROOT / "docs" / "campaign.schema.json").read_text(encoding="utf-8") == schema_json()
    assert (ROOT / "docs" / "campaign.md").read_text(encoding="utf-8") == reference()


@pytest.mark.long
def test_twice_good_campaign_by_the_json_schema(folder: Path) -> None:
    jsonschema.Draft202012Validator.check_schema(schema())
    jsonschema.Draft202012Validator(schema()).validate(_as_editor(CAMPAIGN))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.Draft202012Validator(schema()).validate(_as_editor(CAMPAIGN.replace("seed:", "sead:")))


def _as_editor(text: str) -> object:
    """The file as an editor reads it, by YAML 1.2: no dates, and `no` is a text."""

    class Loader(yaml.SafeLoader):
        pass

    Loader.yaml_implicit_resolvers = {
        first: [(tag, pattern) for tag, pattern in resolvers if tag.endswith(("int", "float"))]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }
    return yaml.load(text, Loader)


def test_law_every_key_is_described_with_an_example() -> None:
    lacking = []
    for name, entry in [*schema()["$defs"].items(), ("Campaign", schema())]:
        for form in (entry, *entry.get("anyOf", ())):
            for key, value in form.get("properties", {}).items():
                if not (value.get("description") and value.get("examples")):
                    lacking.append(f"{name}.{key}")
    assert lacking == []


def test_reference_starter_runs_at_once(tmp_path: Path) -> None:
    campaign = load(create("first-try", tmp_path / "campaigns"))
    assert campaign.id == "first-try"
    assert list(campaign.tests) == ["elongation"]
    assert campaign.names.order[0].name == "x_max"
    assert campaign.requirements[0].quantity == "elongation.k"


@pytest.mark.parametrize("name", ["first", "a-" + "b" * 62])
def test_reference_starter_names_itself_as_it_lies(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = create(name, Path("campaigns"))
    named = [line.split()[-1] for line in path.read_text(encoding="utf-8").splitlines() if "   metrology " in line]
    assert named == [f"campaigns/{name}/campaign.yaml"] * 2
    assert load(named[0]).id == name


def test_refusal_starter_never_overwrites(tmp_path: Path) -> None:
    create("first", tmp_path)
    with pytest.raises(MetrologyError, match="got a folder that exists; expected a new one: nothing is overwritten"):
        create("first", tmp_path)
    with pytest.raises(MetrologyError, match=r"'\.\./x'; expected letters, digits and dashes"):
        create("../x", tmp_path)
    with pytest.raises(MetrologyError, match="at most 64"):
        create("a" * 65, tmp_path)


def test_reference_defaults_stand_in_the_documentation_as_a_user_writes_them() -> None:
    defaults = {
        cells[1].strip(): cells[4].strip()
        for line in reference().splitlines()
        if len(cells := line.replace("\\|", "").split("|")) == 7
    }
    assert defaults["`monte_carlo`"] == "`{digits: 2, max_trials: 1000000}`"
    assert defaults["`mains`"] == "`50 Hz`"
    assert defaults["`free`"] == "`[k, c]`"
    assert defaults["`binary`"] == "`false`"
    assert defaults["`environment`"] == ""


def test_reference_shortest_file_of_the_documentation(tmp_path: Path) -> None:
    text = reference().partition("```yaml\n")[2].partition("```")[0]
    (tmp_path / "campaign.yaml").write_text(text, encoding="utf-8")
    campaign = load(tmp_path / "campaign.yaml")
    assert campaign.names.order[0].name == "E"
    assert len(text.splitlines()) <= 15


LINES = CAMPAIGN.splitlines()
TEXTS = st.sampled_from(
    [
        "",
        "no",
        "0",
        "-1",
        "1e9999",
        "nan",
        "12:30:00",
        "[",
        "{}",
        "[]",
        "'",
        "a: b",
        "3 kg",
        "5 %",
        "*x",
        "é",
        "al",
        "1/0",
    ]
)


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """The good campaign with a few of its lines lost, doubled, moved in, cut, or given another value."""
    lines = list(LINES)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(lines) - 1))
        line = lines[at]
        match draw(st.sampled_from(["lose", "double", "indent", "cut", "value", "letter"])):
            case "lose":
                del lines[at]
            case "double":
                lines.insert(at, line)
            case "indent":
                lines[at] = "  " + line
            case "cut":
                lines[at] = line[: draw(st.integers(0, len(line)))]
            case "value":
                lines[at] = f"{line.partition(':')[0]}: {draw(TEXTS)}"
            case "letter" if line:
                place = draw(st.integers(0, len(line) - 1))
                lines[at] = line[:place] + draw(st.sampled_from("aZ9.,:-{}[]'\"#&*!|>%@ é")) + line[place + 1 :]
    return "\n".join(lines) + "\n"


@pytest.mark.long
@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(mutated())
def test_law_a_bad_file_gives_faults_and_nothing_else(folder: Path, text: str) -> None:
    (folder / "campaign.yaml").write_text(text, encoding="utf-8")
    for fault in _faults("campaign.yaml"):
        assert fault.where
        assert fault.got
        assert fault.expected
        assert len(str(fault)) < 1500


def _faults(path: str) -> tuple[Fault, ...]:
    """Faults of a file; none where the mutation did no harm. Any other exception fails the test."""
    try:
        load(path)
    except MetrologyError as error:
        return error.faults
    return ()


def test_law_json_of_the_schema_is_sorted_as_the_classes_are() -> None:
    assert list(json.loads(schema_json())["properties"])[:3] == ["format", "id", "title"]


def test_limit_a_campaign_can_be_moved(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    other = tmp_path_factory.mktemp("moved") / "campaign"
    shutil.copytree(folder, other)
    assert load(other / "campaign.yaml").files == load("campaign.yaml").files


def test_limit_a_reading_at_the_end_of_the_range_or_excluded_is_taken(folder: Path) -> None:
    readings = (folder / "elongation.csv").read_text(encoding="utf-8")
    (folder / "elongation.csv").write_text(readings.replace("C,1,loading,1.21", "C,1,loading,1.3", 1), encoding="utf-8")
    (folder / "campaign.yaml").write_text(
        CAMPAIGN.replace("range: [0 mm, 25 mm]", "range: [0.40 mm, 1.21 mm]"), encoding="utf-8"
    )
    assert "C,1,loading,1.3\n" in (folder / "elongation.csv").read_text(encoding="utf-8").splitlines(keepends=True)[3]
    assert load("campaign.yaml").tables["tests", "al-elongation"][0].numbers["reading"].max() == pytest.approx(1.3e-3)


@pytest.mark.parametrize("zero", ["{mass: 0 kg}", "{force: 0 N}"])
def test_closed_form_the_first_load_of_a_spring_may_be_zero(tmp_path: Path, zero: str) -> None:
    """As the method says: a pan that hangs at every load alike moves the line and not its slope."""
    readings = {"Z": (53, 53, 54), "A": (103, 102, 103), "B": (120, 120, 119), "C": (135, 136, 135)}
    rows = [f"{load},{at + 1},loading,{own[at]}" for at in range(3) for load, own in readings.items()]
    (tmp_path / "spring.csv").write_text("\n".join(["load,repeat,direction,reading / mm", *rows]), encoding="utf-8")
    masses = {"A": "{mass: 0.3 kg}", "B": "{mass: 0.4 kg}", "C": "{mass: 0.5 kg}"}
    (tmp_path / "campaign.yaml").write_text(
        "format: metrology-campaign/1\nid: spring\ntitle: Spring\n"
        "instruments: {ruler: {kind: ruler, resolution: 1 mm}}\n"
        "samples: {spring: {}}\ntests:\n  pull:\n    method: elongation\n    sample: spring\n"
        "    instruments: {extension: ruler}\n    gravity: 9.81 m/s^2\n    air_density: 1e-9 kg/m^3\n    loads:\n"
        + "".join(f"      {name}: {load}\n" for name, load in {"Z": zero, **masses}.items())
        + "    readings: spring.csv\ndiagnosis: {off: true}\n",
        encoding="utf-8",
    )
    forces = 9.81 * np.array([0.0, 0.3, 0.4, 0.5])
    slope = np.polyfit(forces, [1e-3 * sum(own) / 3 for own in readings.values()], 1)[0]
    # The mean of the draws lies above the plain value by (u/k)², which readings to a millimetre make visible.
    assert float(metrology.run(tmp_path / "campaign.yaml")["pull.k"]) == pytest.approx(1 / slope, rel=3e-4)
