"""Effects of the laboratory's own through the front door: a file beside the campaign, run only where that is asked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import test_diagnosis as door
from truth_response import Test

from metrology import chain
from metrology.campaign.load import load
from metrology.chain.plan import Plan
from metrology.cli import main
from metrology.diagnostics import elongation
from metrology.elongation import ElongationTest, Load, Reading
from metrology.errors import MetrologyError
from metrology.estimation import fit
from metrology.findings import from_json
from metrology.gum.bounded import Rectangular
from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component, Input
from metrology.methods.response.preparation import prepared
from metrology.response.presentation import equations
from metrology.rig.own import OwnEffect, OwnParameter

MAGNET = '''\
"""A magnet under the table, whose pull has an end on either side."""

import numpy as np

from metrology.rig.own import OwnEffect, OwnParameter


def force(t, x, v, e, T, *, strength):
    away = (x - 0.05) / 0.008
    return -strength * away * np.exp(0.5 - 0.5 * away**2)


magnet = OwnEffect(
    name="magnet",
    title="Magnet under the table",
    equation="F = −F_m·u·exp((1 − u²)/2), u = (x − x_m)/8 mm",
    parameters=(
        OwnParameter("strength", "N", null=0.0, low=-0.2, high=0.2, scale=5e-3, meaning="largest pull"),
    ),
    sign="pulls towards one place of the table",
    consequence="k and c hardly change",
    advice="take the magnet away",
    separate="a slow coast over the place",
    force=force,
)
'''
RUNS = (Test("step", ((0.5, 0.62),), 6.0), Test("impulse", ((0.5, 0.62), (3.0, 0.0)), 7.0))
EFFECTS = "diagnosis: {effects: [magnet.py]}\n"


def planted(folder: Path, further: str = EFFECTS, text: str = MAGNET) -> Path:
    (folder / "magnet.py").write_text(text, encoding="utf-8")
    return door.response_campaign(folder, 7, tests=RUNS, magnet=0.04, further=further)


@pytest.mark.study
def test_planted_magnet_is_named_with_the_file_alone_and_its_campaign_runs(tmp_path: Path) -> None:
    path, out = planted(tmp_path), tmp_path / "out"
    assert main(["run", str(path), "--output", str(out), "--allow-code"]) == 0
    findings = from_json(out / "pulls" / "results.json")
    (found,) = findings.diagnosis
    assert (found.verdict, found.named) == ("explained", ("magnet",))
    (size,) = found.causes[0].parameters
    assert size.name == "magnet.strength"
    assert size.low < 0.04 < size.high
    assert size.u < 0.01
    assert [file.path for file in findings.inputs][-1] == "magnet.py"

    # The extended campaign carries it: read again, and fitted with it, k is the planted one.
    extended = load(out / "pulls" / "extended.yaml", allow_code=True)
    ready = prepared(Plan(), extended, "pull", extended.tests["pull"])
    assert ready.rig.value("magnet.strength") == pytest.approx(size.value, rel=1e-6)
    assert equations(ready.rig)[-1].startswith("F = −F_m·u·exp")
    fitted = fit(ready.rig, ready.runs, free=ready.free, priors=ready.priors)
    assert abs(fitted.value("k") - door.MATERIALS["nylon"][0]) < 3.5 * fitted.parameter("k").u


@pytest.mark.long
def test_planted_magnet_has_no_confident_name_without_the_file(tmp_path: Path) -> None:
    path, out = planted(tmp_path, further=""), tmp_path / "out"
    main(["run", str(path), "--output", str(out)])
    (found,) = from_json(out / "pulls" / "results.json").diagnosis
    assert found.verdict != "explained"
    assert found.named == ()


def told(path: Path, **options: bool) -> str:
    with pytest.raises(MetrologyError) as caught:
        chain.evaluate(load(path, **options))
    (fault,) = caught.value.faults
    return str(fault)


def test_refusal_code_is_run_only_where_that_is_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = planted(tmp_path, text=f"import pathlib\npathlib.Path({str(tmp_path / 'ran')!r}).touch()\n" + MAGNET)
    assert main(["check", str(path)]) == 0
    for command in ("run", "report", "diagnose"):
        assert main([command, str(path), "--output", str(tmp_path / "out")]) == 2
        message = capsys.readouterr().err
        assert "diagnosis.effects: got Python code of the campaign's own (magnet.py)" in message
        assert "--allow-code" in message
    assert not (tmp_path / "ran").exists()
    load(path, allow_code=True)
    assert (tmp_path / "ran").exists()


BAD = {
    "syntax": ("def force(t, x", "def force((t, x", "magnet.py:8: got invalid syntax"),
    "import": ("import numpy as np", "import nothing_of_that_name", "magnet.py:3: got ModuleNotFoundError"),
    "exception": ("away = (x - 0.05) / 0.008", "away = x[10**9]", "magnet.py:9 own.magnet.force: got IndexError"),
    "shape": ("return -strength", "return np.ones(3)  #", "magnet.py:8 own.magnet.force: got shape (3,)"),
    "nan": ("return -strength", "return np.nan  #", "magnet.py:8 own.magnet.force: got nan where its arguments are 0,"),
    "name": ('name="magnet"', 'name="friction"', "own.name: got 'friction'; expected a name that no effect"),
    "candidate": ('name="magnet"', 'name="creep"', "magnet.py:14: got effect 'creep', a name that is taken"),
    "unit": ('"strength", "N"', '"strength", ""', "own.magnet.strength.unit: got no unit; expected an SI unit"),
    "prefix": ('"strength", "N"', '"strength", "mN"', "own.magnet.strength.unit: got 'mN'; expected an SI unit"),
    "nothing": ("magnet = OwnEffect(", "dict(", "magnet.py:1: got no effect"),
    "null": ("null=0.0, low", "null=9.0, low", "own.magnet.strength.null: got 9.0; expected a number from -0.2"),
    "call": ("    title=", "    titel=", "magnet.py:13: got TypeError"),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return planted(tmp_path_factory.mktemp("bad"), EFFECTS.replace("}", ", off: true}"))


@pytest.mark.parametrize("name", BAD)
def test_refusal_a_bad_file_gives_one_error_with_file_and_line(name: str, whole: Path) -> None:
    good, bad, expected = BAD[name]
    assert good in MAGNET
    file = whole.parent / "magnet.py"
    file.write_text(MAGNET.replace(good, bad), encoding="utf-8")
    message = told(whole, allow_code=True)
    assert expected in message
    assert message.startswith(f"{file}:")


@pytest.mark.parametrize(
    ("effects", "expected"),
    [
        ("[../magnet.py]", "'../magnet.py'; expected a .py file in the campaign's folder"),
        ("[magnet.txt]", "the name ends in .py"),
        ("[none.py]", "there is no such file"),
        ("[magnet.py, magnet.py]", "named twice"),
    ],
)
def test_refusal_of_what_is_no_file_of_the_campaign(effects: str, expected: str, tmp_path: Path) -> None:
    path = planted(tmp_path, f"diagnosis: {{effects: {effects}}}\n")
    assert expected in told(path)


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ("magnet.strength: 0.1 kg", "model.magnet.strength: got '0.1 kg'"),
        ("magnet.pull: 1 N", "'magnet.pull', an unknown"),
    ],
)
def test_refusal_a_model_with_a_wrong_parameter_of_our_own(entry: str, expected: str, tmp_path: Path) -> None:
    path = planted(tmp_path)
    model = f"    model: {{{entry}}}\n    identification"
    path.write_text(path.read_text("utf-8").replace("    identification", model), encoding="utf-8")
    load(path)
    assert expected in told(path, allow_code=True)


# ---- elongation -----------------------------------------------------------------------------------------------------
def sticking(F: np.ndarray, order: np.ndarray, back: np.ndarray, *, at: float) -> np.ndarray:
    """A pointer that jumps where a load is passed."""
    return (at < F).astype(float)


JUMP = OwnEffect(
    "pointer", "Pointer that jumps", "x = … + a where F > F₀",
    (
        OwnParameter("jump", "m", 0.0, -1e-3, 1e-3, 1e-5, "size of the jump"),
        OwnParameter("at", "N", 10.0, 0.0, 100.0, 1.0, "load where it jumps", tried=(17.0, 27.0, 37.0)),
    ),
    "one step at a load, both ways", "k too small", "clean the rack", "gauge blocks", reading=sticking,
)  # fmt: skip


@pytest.mark.long
def test_planted_effect_of_our_own_in_readings_under_dead_loads() -> None:
    rng, readings = np.random.default_rng(3), []
    loads = {name: float(10 * at) for at, name in enumerate("ABCDEF", 1)}
    for repeat in "12345":
        for direction, names in (("loading", "ABCDEF"), ("unloading", "FEDCBA")):
            for name in names:
                x = loads[name] / 1e4 + 1e-4 * (loads[name] > 27) + 5e-6 * rng.standard_normal()
                readings.append(Reading(name, repeat, direction, x))
    test = ElongationTest(
        "pulls",
        tuple(Load(name, Input(f"load {name}", F, (Component("b", Normal(1e-3)),), "N")) for name, F in loads.items()),
        tuple(readings), Component("resolution", Rectangular(5e-7)),
        *(Input(name, 1.0, (), unit) for name, unit in (("g", "m/s²"), ("air", "kg/m³"), ("weights", "kg/m³"))),
    )  # fmt: skip
    found = elongation(test, rng=np.random.default_rng(1), own=(JUMP,))
    assert found.named == ("pointer",)
    size = found.causes[0].parameters[0]
    assert abs(size.value - 1e-4) < 3.5 * size.u
    assert "pointer" not in elongation(test, rng=np.random.default_rng(1)).possible
