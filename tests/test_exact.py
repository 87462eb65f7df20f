"""What is taken as exact is listed with the uncertainty that would matter, and that uncertainty does what is said."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from rig_folder import run, written
from undiagnosed import undiagnosed

from metrology import chain

PULL = """\
format: metrology-campaign/1
id: exact
title: Exact inputs
instruments:
  indicator: {{kind: dial indicator, resolution: 0.001 mm{certificate}}}
samples:
  line: {{length: {length}}}
tests:
  pull:
    method: elongation
    sample: line
    instruments: {{extension: indicator}}
    loads: {{A: {{force: 5.00(1) N}}, B: {{force: 10.00(1) N}}, C: {{force: 15.00000{u_load} N}}}}
    readings: pull.csv
diagnosis: {{off: true}}
"""
STATED = {"certificate": ", uncertainty: [{standard: 0.02 um}]", "length": "1.000(1) m", "u_load": "(1000)"}


def elongation(folder: Path, *, cycles: bool = True, drift: float = 0.0, **changes: str):
    """Three loads in four repeats, up and down by turns or up alone; `drift`: mm from each reading to the next."""
    rng = np.random.default_rng(5)
    rows = []
    for repeat in (1, 2, 3, 4):
        at_load = {load: 0.5 * size + 0.004 * rng.standard_normal() for size, load in enumerate("ABC", 1)}
        way, order = ("unloading", "CBA") if cycles and repeat % 2 == 0 else ("loading", "ABC")
        rows += [f"{load},{repeat},{way},{at_load[load] + drift * at:.3f}" for at, load in enumerate(order)]
    (folder / "pull.csv").write_text("\n".join(["load,repeat,direction,reading / mm", *rows]) + "\n", encoding="utf-8")
    (folder / "campaign.yaml").write_text(PULL.format(**(STATED | changes)), encoding="utf-8")
    return chain.evaluate(undiagnosed(folder / "campaign.yaml"))


def k_of(findings):
    """k as it is reported: its u is what the advice is about."""
    return next(one for one in findings.results if one.quantity == "k")


def test_planted_nothing_is_exact_where_all_is_stated(tmp_path: Path):
    findings = elongation(tmp_path)
    assert findings.exact == ()
    assert not [one for one in findings.warnings if "taken as exact" in one]


def test_closed_form_an_indicator_without_a_word_on_its_uncertainty(tmp_path: Path):
    """k goes as one over the scale of the extension: u(scale) = √(1.1² − 1)·u(k)/k makes u(k) a tenth larger."""
    findings = elongation(tmp_path, certificate="")
    (scale,) = findings.exact
    k = k_of(findings)
    assert (scale.name, scale.result) == ("indicator.scale", "pull.k")
    assert scale.u == pytest.approx(sqrt(0.21) * k.u / k.framework.value, rel=1e-6)
    (sentence,) = [one for one in findings.warnings if "taken as exact" in one]
    assert sentence.startswith("indicator: no uncertainty is stated of what follows")


def test_closed_form_a_drift_that_loads_in_one_order_cannot_show(tmp_path: Path):
    """x = F/k + a·j with F = 5 N·(1 + j): 1/k grows by a/(5 N), and no residual of the line with it."""
    plain = elongation(tmp_path, cycles=False)
    (drift,) = plain.exact
    k = k_of(plain)
    assert (drift.name, drift.result) == ("pull.drift", "pull.k")
    assert drift.u == pytest.approx(sqrt(0.21) * k.u * 5.0 / k.framework.value**2, rel=1e-4)
    (sentence,) = [one for one in plain.warnings if "taken as exact" in one]
    assert sentence.startswith("pull: ")
    assert sentence.endswith("read them on the way back as well.")
    drifting = k_of(elongation(tmp_path, cycles=False, drift=0.01))
    assert 1 / drifting.framework.value - 1 / k.framework.value == pytest.approx(1e-5 / 5.0, rel=1e-3)


def test_planted_drift_in_cycles_up_and_down_leaves_k(tmp_path: Path):
    plain, drifting = (k_of(elongation(tmp_path, drift=drift)) for drift in (0.0, 0.01))
    assert drifting.framework.value == pytest.approx(plain.framework.value, rel=1e-4)


@pytest.mark.long
@pytest.mark.parametrize(
    ("without", "with_"),
    [
        ({"certificate": ""}, "certificate: , uncertainty: [{{standard: {percent} %}}]"),
        ({"u_load": ""}, "u_load:({digits})"),
    ],
)
def test_twice_the_uncertainty_that_is_named_does_what_is_said(without, with_, tmp_path: Path):
    before = elongation(tmp_path, **without)
    (exact,) = before.exact
    key, _, text = with_.partition(":")
    stated = text.format(percent=f"{100 * exact.u:.6g}", digits=f"{1e5 * exact.u:.0f}")
    after = elongation(tmp_path, **(without | {key: stated}))
    assert k_of(after).u / k_of(before).u == pytest.approx(1.1, rel=0.02)


def let_go(folder: Path, known: str):
    rng, t = np.random.default_rng(1), np.arange(1200) / 100
    m, k, c = 2.0, 50.0, 0.8
    delta = c / (2 * m)
    omega = sqrt(k / m - delta**2)
    runs = []
    for number in range(3):
        x = 0.05 * np.exp(-delta * t) * (np.cos(omega * t) + delta / omega * np.sin(omega * t))
        runs.append(
            run(number, [("time / s,x / m", [t, x + 1e-4 * rng.standard_normal(t.size)])], "start: {position: 0.05 m}")
        )
    stated = f"""\
    rig: {{mass: 2 kg, taut: 0 m, attachment: both ways}}
{known}    identification: {{free: [k, c], start: {{k: 40 N/m}}}}
"""
    return chain.evaluate(undiagnosed(written(folder, stated, runs)))


@pytest.mark.long
def test_twice_the_mass_of_a_response_test(tmp_path: Path):
    """k/m and c/m are what the motion shows: k follows the mass one to one."""
    before = let_go(tmp_path, "")
    exact = {one.name: one for one in before.exact}
    mass, k = exact["pull.mass.factor"], k_of(before)
    most = min(one.u / abs(one.value) for one in before.results if one.quantity in "kc")
    assert mass.u == pytest.approx(sqrt(0.21) * most, rel=0.02)
    after = let_go(tmp_path, f"    known: {{mass: {{common: {100 * mass.u:.6g} %}}}}\n")
    assert "pull.mass.factor" not in {one.name for one in after.exact}
    moved = k_of(after).u / k.u
    assert moved == pytest.approx(sqrt(1 + 0.21 * (most / (k.u / k.value)) ** 2), rel=0.01)


@pytest.mark.long
def test_closed_form_the_set_up_is_in_series_with_the_line(tmp_path: Path):
    """1/k_seen = 1/k + C, so that ∂k/∂C = k²: the motion tells no set-up that gives way from a softer line."""
    before = let_go(tmp_path, "")
    series, k = next(one for one in before.exact if one.name == "pull.setup.compliance"), k_of(before)
    assert series.result == "pull.k"
    assert series.u == pytest.approx(sqrt(0.21) * k.u / k.value**2, rel=0.02)
    after = let_go(tmp_path, f"    model: {{setup.compliance: 1e-5 ± {series.u:.6g} m/N}}\n")
    assert "pull.setup.compliance" not in {one.name for one in after.exact}
    assert k_of(after).value == pytest.approx(k.value / (1 - 1e-5 * k.value), rel=1e-6)
    assert k_of(after).u == pytest.approx(1.1 * k.u, rel=0.01)
