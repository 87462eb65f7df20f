"""What a watched campaign keeps from one save to the next, and what it computes again."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from rig_folder import run, written
from scipy.integrate import solve_ivp

from metrology import chain
from metrology.campaign.load import load

pytest.importorskip("cloudpickle")
from metrology.watch.kept import Kept

M, K, C = 20.0, 50.0, 1.0
STATED = """\
    rig: {mass: 20 kg, taut: 0 m, attachment: both ways}
    identification: {free: [k, c], start: {k: 52 N/m, c: 1.2 N*s/m}}
"""


@pytest.fixture(scope="module")
def swinging(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of four runs, m·x″ = F − k·x − c·x′ by SciPy."""
    rng, t, runs = np.random.default_rng(5), np.arange(300) / 15, []
    for number in range(4):
        force = 2.0 * np.sin((1.0 + 0.2 * number) * t)
        wave = 1.0 + 0.2 * number
        motion = solve_ivp(
            lambda s, y, wave=wave: [y[1], (2.0 * np.sin(wave * s) - K * y[0] - C * y[1]) / M],
            (0, t[-1]), [0.0, 0.0], "DOP853", t, rtol=1e-10, atol=1e-13,
        )  # fmt: skip
        read = motion.y[0] + 1e-3 * rng.standard_normal(t.size)
        runs.append(run(number, [("time / s,x / m,F / N", [t, read, force])], "start: {position: 0 m}"))
    return written(tmp_path_factory.mktemp("swinging"), STATED, runs)


def fits(path: Path, once: Kept) -> tuple[list[str], dict]:
    """Fits that an evaluation by the law made, and its results."""
    said: list[str] = []
    findings, _ = chain.by_law(load(path), progress=said.append, once=once)
    return [text for text in said if "fit to" in text], {one.name: asdict(one) for one in findings.results}


def test_law_what_did_not_change_is_not_computed_again(swinging: Path, tmp_path: Path):
    made, first = fits(swinging, Kept(tmp_path / "0"))
    assert len(made) == 1
    text = swinging.read_text()
    try:
        swinging.write_text(text.replace("title: A rig", "title: The same rig"))
        made, again = fits(swinging, Kept(tmp_path / "0"))
        assert made == []
        assert again == first
        swinging.write_text(text.replace("mass: 20 kg", "mass: 21 kg"))
        made, other = fits(swinging, Kept(tmp_path / "0"))
        assert len(made) == 1
        assert other["pull.k"]["value"] == pytest.approx(first["pull.k"]["value"] * 21 / 20, rel=0.02)
    finally:
        swinging.write_text(text)


def test_limit_what_is_not_used_any_more_is_removed(tmp_path: Path):
    before = Kept(tmp_path / "0")
    assert before(pow, 2, 3) == 8
    assert before(pow, 2, 4) == 16
    (tmp_path / "0" / "ended.half").write_bytes(b"of a process that was ended")
    now = Kept(tmp_path / "0")
    assert now(pow, 2, 4) == 16
    now.tidy()
    assert len(list((tmp_path / "0").iterdir())) == 1


def test_limit_inputs_that_no_file_can_hold_are_computed_each_time(tmp_path: Path):
    kept = Kept(tmp_path / "0")
    assert [kept(sum, (number for number in range(4))) for _ in range(2)] == [6, 6]
    assert not list((tmp_path / "0").iterdir())


def own(text: str):
    """A function of a laboratory's own file."""
    module = ModuleType("drag")
    exec(text, module.__dict__)
    return module.force


def test_law_another_text_of_an_own_file_is_another_input(tmp_path: Path):
    kept = Kept(tmp_path / "0")
    assert kept(apply, own("def force(v): return -2 * v"), 3) == -6
    assert kept(apply, own("def force(v): return -4 * v"), 3) == -12
    assert kept(apply, own("SIZE = 5\ndef force(v): return -SIZE * v"), 3) == -15
    assert kept(apply, own("SIZE = 6\ndef force(v): return -SIZE * v"), 3) == -18


def apply(function, value, progress=None):
    return function(value)
