"""The tutorial of docs/extend.md, run as it stands."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from metrology import effects

PACKAGE = Path(effects.__file__).parents[1]
EXTEND = PACKAGE.parent / "docs" / "extend.md"
PLANTED = """
import sys
from dataclasses import replace
import numpy as np
from response_cases import PRIORS, SHORT, runs_of, stated, truth_of
import metrology
from metrology.diagnostics import Settings, response
from metrology.diagnostics.candidate import RESPONSE

assert metrology.__file__.startswith(sys.argv[1])
runs = runs_of(truth_of("nylon"), 5, tests=SHORT)
runs = [replace(run, T=run.T * (1 + 2e-3 * run.stamps("T"))) for run in runs]
quick = {"cell gain", "cell zero", "cell drift", "clock T", "motion scale", "mass", "thrust gain", "gain drift"}
settings = Settings("nylon", "r", without=tuple(set(RESPONSE) - quick))
found = response(stated("nylon"), runs, rng=np.random.default_rng(5), priors=PRIORS, settings=settings)
sizes = [(one.value, one.u) for cause in found.causes if cause.effect in found.named for one in cause.parameters]
print(found.verdict, found.named, *(abs(value - 2e-3) < 3.5 * u for value, u in sizes), sep="; ")
"""


@pytest.mark.long
def test_planted_drift_of_a_gain_is_found_with_the_file_of_the_tutorial_alone(tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "metrology", ignore=shutil.ignore_patterns("__pycache__", "gain_drift.py"))
    text = EXTEND.read_text(encoding="utf-8").partition("`metrology/effects/gain_drift.py`")[2]
    file = text.partition("```python\n")[2].partition("```")[0]
    assert file == Path(effects.__file__).with_name("gain_drift.py").read_text(encoding="utf-8")
    paths = f"{tmp_path}{os.pathsep}{Path(__file__).parent}"

    def found() -> str:
        done = subprocess.run(
            [sys.executable, "-c", PLANTED, str(tmp_path)], check=True, capture_output=True, text=True, cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": paths, "METROLOGY_CACHE": str(tmp_path)},
        )  # fmt: skip
        return done.stdout.strip()

    assert "gain drift" not in found()
    (tmp_path / "metrology" / "effects" / "gain_drift.py").write_text(file, encoding="utf-8")
    assert found() == "explained; ('gain drift',); True"


def test_refusal_a_file_of_the_package_that_is_not_whole_fails_at_import(tmp_path: Path) -> None:
    folder = tmp_path / "metrology"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    file = folder / "effects" / "gain_drift.py"
    text = file.read_text(encoding="utf-8").replace('"1/s", ', '"", ')
    file.write_text(text.replace('source="ISO 376:2011, 7.5 (creep)"', 'source=""'), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", "import metrology.rig"], check=False, capture_output=True, text=True, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert f"{file}: gain_drift.source: got nothing; expected where the equation stands" in done.stderr
    assert f"{file}: gain_drift: gain_drift.rate.unit: got nothing; expected an SI unit, such as 'N'" in done.stderr


PUSH = """
import numpy as np
from metrology.effect import Effect, Parameter

def force(t, x, push, rate, ground):
    return push * np.sin(rate * t) - ground * x

EFFECT = Effect(
    "push", "Push", "F = F_p·sin(ω·t) − k_g·x",
    (
        Parameter("push.push", "F_p", "N", 0.0, -9.0, 9.0, (0.0, 1.0), 0.1, "size of the push", linear=False),
        Parameter("push.ground", "k_g", "N/m", 0.0, 0.0, 9.0, (0.0, 1.0), 0.1, "spring to ground", linear=False),
        Parameter("push.rate", "ω", "rad/s", 3.0, 0.1, 9.0, (1.0, 5.0), 0.1, "angular frequency"),
    ),
    "a swing", "a toy", sizes=2, force=force, never="a toy",
)
"""
MOVED = """
import sys
sys.modules["numba"] = None
import numpy as np
from metrology.rig import Rig, Run, simulate

t = np.arange(0.0, 3.0, 0.05)
free = Rig(2.0, 0.0, attachment="none")
pushed = simulate(free.with_values({"push.push": 0.5}), Run.sampled(1.0 + t, 0.0, t0=1.0))
v = 0.5 / (2.0 * 3.0) * (np.cos(3.0) - np.cos(3.0 * (1.0 + t)))
swung = simulate(free.with_values({"push.ground": 8.0}), Run.sampled(t, 0.1))
print(np.abs(pushed.v - v).max() < 1e-9, np.abs(swung.x - 0.1 * np.cos(2.0 * t)).max() < 1e-9)
"""


@pytest.mark.long
def test_closed_form_a_force_by_time_and_place_from_a_file_alone(tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "metrology", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "metrology" / "effects" / "push.py").write_text(PUSH, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", MOVED], check=True, capture_output=True, text=True, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert done.stdout.split() == ["True", "True"]
