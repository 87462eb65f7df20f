"""The input that the rig guards, and the cache of the compiled kernel."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from metrology.errors import MetrologyError
from metrology.rig import Force, Rig, Run, engines, kernel, simulate_many, tangent

GOOD = {"m": 25.0, "k": 100.0}


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"m": 0.0}, "rig.m: got 0 kg; expected at least 1e-09 kg"),
        ({"k": -1.0}, "rig.k: got -1 N/m; expected at least 0 N/m"),
        ({"c": math.nan}, "rig.c: got nan N·s/m"),
        ({"effects": {"friction.force": -1.0}}, "rig.effects.friction.force: got -1 N"),
        ({"effects": {"friction": 1.0}}, "rig.effects.friction: got 'friction'; expected the name of an effect"),
        ({"attachment": "rope"}, "rig.attachment: got 'rope'; expected one of 'tether', 'both ways', 'none'"),
        ({"line_weight": "catenary"}, "rig.length: got 0 m; expected the free length of the line"),
    ],
)  # fmt: skip
def test_refusal_of_a_rig(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(MetrologyError) as refused:
        Rig(**{**GOOD, **wrong})
    assert said in str(refused.value)


def test_refusal_tells_all_faults_at_once() -> None:
    with pytest.raises(MetrologyError) as refused:
        Rig(m=-1.0, k=-1.0, c=-1.0)
    assert len(refused.value.faults) == 3


@pytest.mark.parametrize(
    ("run", "said"),
    [
        (lambda: Run.sampled([0.0, 1.0, 1.0], 0.0), "run.t_x[2]: got 1 s after 1 s; expected times that increase"),
        (lambda: Run.sampled([0.0, np.nan], 0.0), "run.t_x[1]: got nan; expected a finite number"),
        (lambda: Run.sampled([], 0.0), "run.t_x: got shape (0,); expected at least one value"),
        (lambda: Run(0.0), "run: got no channel"),
        (lambda: Run.sampled([0.0, 1.0], np.inf), "run.x0: got inf; expected a finite number for the start state"),
        (lambda: Run.sampled([0.0, 1.0], 0.0, 0.1, held_until=0.5), "run.v0: got 0.1 m/s; expected 0 m/s"),
        (lambda: Run.sampled([0.0, 1.0], 0.0, held_until=-1.0), "run.held_until: got -1.0 s; expected a time from t0"),
        (lambda: Force([1.0, 0.0], [1.0, 2.0]), "force.t[1]: got 0 s after 1 s; expected times that increase"),
        (lambda: Force([0.0, 1.0], [1.0]), "force.values: got 1 values; expected 2, one for each time"),
        (lambda: Run.sampled([0.0, 9.0], 0.0, force=Force([0.0, 5.0], [0.0, 1.0], "linear")),
         "run.force.t: got 0 s to 5 s; expected a column that covers 0 s to 9 s"),
    ],
)  # fmt: skip
def test_refusal_of_a_run(run: object, said: str) -> None:
    with pytest.raises(MetrologyError) as refused:
        run()
    assert said in str(refused.value)


def test_refusal_of_unknown_and_impossible_values_in_a_batch() -> None:
    rig, run = Rig(**GOOD), Run.sampled([0.0, 1.0], 0.0)
    with pytest.raises(MetrologyError, match=r"rig\.kk: got 'kk'"):
        simulate_many(rig, run, ["kk"], [[1.0]])
    with pytest.raises(MetrologyError, match=r"rig\.k: got -5 N/m"):
        simulate_many(rig, run, ["k"], [[1.0], [-5.0]])


def test_law_importing_the_rig_loads_neither_compiler_nor_scipy() -> None:
    code = "import sys, metrology.rig; assert not {'numba', 'scipy'} & set(sys.modules), 'loaded'"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_law_a_base_motion_compiles_nothing() -> None:
    code = (
        "import sys; from metrology.rig import *; m = simulate(Rig(1.0, 4.0), Run.sampled([0.0, 1.0], -0.1, 1.0));"
        "assert m.engine == 'numpy' and m.status == 'ok'; assert not {'numba', 'scipy'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.long
def test_law_without_a_compiler_every_effect_still_runs() -> None:
    code = (
        "import sys; sys.modules['numba'] = None; from metrology.rig import *;"
        "m = simulate(Rig(1.0, 4.0, effects={'drag.quadratic': 1.0}), Run.sampled([0.0, 1.0], -0.1, 1.0));"
        "assert m.engine == 'numpy' and m.status == 'ok', m"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert "numba cannot be used" in done.stderr


def test_law_a_folder_that_cannot_be_written_stops_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    monkeypatch.setenv("METROLOGY_CACHE", str(blocked))
    assert engines.cache_folder("0") is None


def test_law_the_cache_has_another_place_for_other_sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("METROLOGY_CACHE", str(tmp_path))
    copy = tmp_path / "equation.py"
    copy.write_bytes(Path(kernel.equation.__file__).read_bytes() + b"\n")
    before = engines.cache_folder("0")
    monkeypatch.setattr(kernel.equation, "__file__", str(copy))
    assert before != engines.cache_folder("0") != engines.cache_folder("1")


def test_law_one_process_at_a_time_compiles_into_a_folder(tmp_path: Path) -> None:
    # Each notes when it has the lock and when it gives it back: never two notes of entry in a row.
    code = (
        "import sys, time, pathlib; from metrology.rig.engines import alone\n"
        "folder = pathlib.Path(sys.argv[1])\n"
        "for _ in range(5):\n"
        "    with alone(folder), (folder / 'notes').open('a') as notes:\n"
        "        print('in', file=notes, flush=True); time.sleep(0.02); print('out', file=notes, flush=True)"
    )
    workers = [subprocess.Popen([sys.executable, "-c", code, str(tmp_path)]) for _ in range(2)]
    assert [worker.wait() for worker in workers] == [0, 0]
    assert (tmp_path / "notes").read_text(encoding="utf-8").split() == ["in", "out"] * 10


def test_law_a_killed_compilation_leaves_no_lock_behind(tmp_path: Path) -> None:
    code = (
        "import os, sys, pathlib; from metrology.rig.engines import alone\n"
        "with alone(pathlib.Path(sys.argv[1])): os._exit(1)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=False)
    with engines.alone(tmp_path):
        assert (tmp_path / "lock").exists()


@pytest.mark.long
def test_law_where_no_folder_can_be_written_the_compiled_rig_still_runs(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    code = (
        "from metrology.rig import *;"
        "m = simulate(Rig(1.0, 4.0), Run.sampled([0.0, 1.0], -0.1, 1.0), engine='compiled');"
        "assert (m.engine, m.status) == ('compiled', 'ok'), m"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True,
        env={**os.environ, "METROLOGY_CACHE": str(blocked)},
    )  # fmt: skip
    assert "no folder for the compiled rig can be written" in done.stderr


@pytest.mark.parametrize(
    ("added", "said"),
    [
        (Force([0.0, 0.5], [0.0, 1.0], "linear"), "run.added.t: got 0 s to 0.5 s; expected a column that covers"),
        (Force.step(1.0), "run.added.kind: got 'constant'; expected 'linear'"),
    ],
)
def test_refusal_of_an_added_force(added: Force, said: str) -> None:
    with pytest.raises(MetrologyError) as refused:
        Run.sampled([0.0, 1.0], 0.0, added=added)
    assert said in str(refused.value)


def test_law_modules_that_are_compiled_as_one_share_no_name_for_different_things():
    """A constant of the one would replace that of the other without a word."""
    for modules in (engines.BASE, kernel.MODULES + tangent.MODULES):
        things: dict[str, object] = {}
        for module in modules:
            for name, thing in vars(module).items():
                if not name.startswith("__"):
                    assert things.setdefault(name, thing) is thing, f"{name} of {module.__name__}"
