"""Nothing stated is dropped: every uncertainty that a campaign file may state acts on a result, or a notice says no.

Each quantity that acts is stated once more, one of its u further: a result moves by what its budget says that it does.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import exp, pi, sin
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import BaseModel
from rig_folder import run, written
from undiagnosed import undiagnosed

from metrology import chain
from metrology.campaign.load import load
from metrology.campaign.schema import Campaign
from metrology.declaration.quantity import Stated, ValueOnly
from metrology.findings import Result

HEAD = """\
format: metrology-campaign/1
id: stated
title: One quantity after the other
diagnosis: {off: true}
monte_carlo: {digits: 1, max_trials: 10000}
"""
DIAL = """\
instruments:
  dial: {kind: dial indicator, resolution: 0.001 mm, correction: {value: 0.002(1) mm}}
"""
ELONGATION = """\
tests:
  pull:
    method: elongation
    sample: line
    instruments: {extension: dial}
    gravity: 9.806(2) m/s^2
    air_density: 1.19(20) kg/m^3
    weight_density: 8000(90) kg/m^3
    loads: {A: LOAD A, B: LOAD B, C: LOAD C}
    readings: pull.csv
"""
LOADS = {
    "mass": {"A": "{mass: 0.500 kg}", "B": "{mass: 1.000 kg}", "C": "{mass: 1.500(4) kg}"},
    "force": {"A": "{force: 5.0 N}", "B": "{force: 10.0 N}", "C": "{force: 15.00(4) N}"},
}
PULLED = """\
instruments:
  cell: {kind: load cell, class: "0.5"}
  machine: {kind: encoder, resolution: 0.1 um}
  clip: {kind: extensometer, class: "0.5"}
"""
TENSION = """\
tests:
  pull:
    method: tension
    sample: line
    density: 1.44(2) g/cm^3
    TENSION
    specimens: {one: {OWNreadings: pulled.csv}}
"""
BY_CLIP = "instruments: {force: cell, extension: clip}\n    gauge_length: 50.0(3) mm"
BY_CROSSHEAD = "instruments: {force: cell, crosshead: machine}\n    setup_compliance: 20(2) nm/N"
DECAY = """\
instruments:
  dial: {kind: vibrometer}
samples: {line: {}}
tests:
  free: {method: decay, sample: line, instruments: {displacement: dial}, INERT, readings: [d0.csv, d1.csv]}
"""


def section(text: str) -> str:
    return f"samples:\n  line: {{length: 1.500(3) m, section: {text}}}\n"


def elongation(shape: str, load: str = "mass") -> str:
    text = HEAD + DIAL + section(shape) + ELONGATION
    for name, stated in LOADS[load].items():
        text = text.replace(f"LOAD {name}", stated)
    return text


def tension(how: str, own: str = "") -> str:
    line = "samples:\n  line: {length: 100.0(4) mm, linear_density: 15.0(2) g/m}\n"
    return HEAD + PULLED + line + TENSION.replace("TENSION", how).replace("OWN", own)


def relaxation(how: str, own: str = "") -> str:
    text = tension(how.replace("machine", "dial"), own).replace("method: tension", "method: relaxation")
    known = PULLED + '  dial: {kind: encoder, class: "1"}\n'
    line = "length: 100.0(4) mm, section: {shape: area, area: 10.0(1) mm^2}"
    text = text.replace(PULLED, known).replace("    density: 1.44(2) g/cm^3\n", "")
    return text.replace("length: 100.0(4) mm, linear_density: 15.0(2) g/m", line)


TAPE, ROUND = "{shape: tape, width: 25.0(2) mm, thickness: 0.050(1) mm}", "{shape: round, diameter: 0.300(3) mm}"
ELLIPSE = "{shape: ellipse, width: 2.00(2) mm, height: 1.50(2) mm}"
RIG = """\
    rig: {mass: 2.00(2) kg, taut: 0 m, attachment: both ways}
    identification: {free: [k, c], start: {k: 40 N/m}}
"""
STIFFENING = RIG.replace("2.00(2) kg", "2 kg") + "    model: {cubic.stiffness: 300.0(2) N/m^3}\n"
ACTS = {
    ("Tape", "width"): (elongation(TAPE), "25.0(2) mm", "25.2(2) mm"),
    ("Tape", "thickness"): (elongation(TAPE), "0.050(1) mm", "0.051(1) mm"),
    ("Round", "diameter"): (elongation(ROUND), "0.300(3) mm", "0.303(3) mm"),
    ("Ellipse", "width"): (elongation(ELLIPSE), "2.00(2) mm", "2.02(2) mm"),
    ("Ellipse", "height"): (elongation(ELLIPSE), "1.50(2) mm", "1.52(2) mm"),
    ("GivenArea", "area"): (elongation("{shape: area, area: 1.250(9) mm^2}"), "1.250(9) mm^2", "1.259(9) mm^2"),
    ("Sample", "length"): (elongation(TAPE), "1.500(3) m", "1.503(3) m"),
    ("ElongationTest", "gravity"): (elongation(TAPE), "9.806(2) m/s^2", "9.808(2) m/s^2"),
    ("ElongationTest", "air_density"): (elongation(TAPE), "1.19(20) kg/m^3", "1.39(20) kg/m^3"),
    ("ElongationTest", "weight_density"): (elongation(TAPE), "8000(90) kg/m^3", "8090(90) kg/m^3"),
    ("Load", "mass"): (elongation(TAPE), "1.500(4) kg", "1.504(4) kg"),
    ("Load", "force"): (elongation(TAPE, "force"), "15.00(4) N", "15.04(4) N"),
    ("Sample", "linear_density"): (tension(BY_CLIP), "15.0(2) g/m", "15.2(2) g/m"),
    ("TensionTest", "density"): (tension(BY_CLIP), "1.44(2) g/cm^3", "1.46(2) g/cm^3"),
    ("TensionTest", "gauge_length"): (tension(BY_CLIP), "50.0(3) mm", "50.3(3) mm"),
    ("TensionTest", "setup_compliance"): (tension(BY_CROSSHEAD), "20(2) nm/N", "22(2) nm/N"),
    ("TensionSpecimen", "length"): (tension(BY_CROSSHEAD, "length: 100.0(5) mm, "), "100.0(5) mm", "100.5(5) mm"),
    ("RelaxationTest", "gauge_length"): (relaxation(BY_CLIP), "50.0(3) mm", "50.3(3) mm"),
    ("RelaxationTest", "setup_compliance"): (relaxation(BY_CROSSHEAD), "20(2) nm/N", "22(2) nm/N"),
    ("RelaxationSpecimen", "length"): (relaxation(BY_CROSSHEAD, "length: 100.0(5) mm, "), "100.0(5) mm", "100.5(5) mm"),
    ("DecayTest", "mass"): (HEAD + DECAY.replace("INERT", "mass: 1.196(4) kg"), "1.196(4) kg", "1.200(4) kg"),
    ("DecayTest", "inertia"): (
        HEAD + DECAY.replace("INERT", "inertia: 1.196(4) kg*m^2"), "1.196(4) kg*m^2", "1.200(4) kg*m^2",
    ),
    ("DecayTest", "clock_rate"): (
        HEAD + DECAY.replace("INERT", "mass: 1.2 kg, clock_rate: 0(3000) ppm"), "0(3000) ppm", "3000(3000) ppm",
    ),
    ("StatedRig", "mass"): (RIG, "2.00(2) kg", "2.02(2) kg"),
    ("ResponseTest", "model"): (STIFFENING, "300.0(2) N/m^3", "300.2(2) N/m^3"),
    ("Campaign", "quantities"): (
        HEAD + "quantities: {a: 2.0(1) m, b: 3.0(1) m}\nderived: [{quantity: area, expression: a*b, unit: m^2}]\n",
        "2.0(1) m", "2.1(1) m",
    ),
}  # fmt: skip
"""By class and field: a campaign in which it acts, and how it is stated, at its value and one u further."""
OTHERWISE = {
    ("Certificate", "expanded_uncertainty"): "an uncertainty itself, refused with another one",
    ("Correction", "value"): "alike for all readings of an elongation, it moves the zero and not k",
    ("Environment", "temperature"): "a record of the conditions, printed as stated",
    ("Environment", "humidity"): "a record of the conditions, printed as stated",
    ("Environment", "pressure"): "a record of the conditions, printed as stated",
    ("Sample", "references"): "a side of a comparison, in its E_n",
    ("Side", "value"): "a side of a comparison, in its E_n",
    ("Sample", "density"): "compared with section and linear density before any fit",
    ("Audit", "published"): "a figure that is compared digit by digit",
    ("Given", "value"): "an input of what follows: tests/test_response_door.py",
    ("Campaign", "masses"): "a summand of the mass of a load or a body: tests/campaign/test_masses.py",
    ("StatedRig", "inertia"): "the mass of a rig that turns",
    ("StatedRig", "taut"): "a parameter of the fit, with its u as prior: tests/estimation/test_fit.py",
    ("StatedRig", "gravity"): "with the linear density the weight of the line",
    ("Prediction", "x"): "where a prediction is made: tests/test_predicted_at.py",
    ("Prediction", "y"): "a new reading of an inverse prediction: tests/reference",
    ("Limits", "lower"): "refused: a limit is exact",
    ("Limits", "upper"): "refused: a limit is exact",
}


def fields(model: type[BaseModel], known: set[type]) -> Iterator[tuple[str, str, bool]]:
    """Class and name of every field of the language that holds a quantity, and whether its value alone acts."""
    if model in known:
        return
    known.add(model)
    for name, field in model.model_fields.items():
        for one in parts(field.annotation):
            if isinstance(one, type) and issubclass(one, Stated):
                yield model.__name__, name, any(isinstance(mark, ValueOnly) for mark in field.metadata)
            elif isinstance(one, type) and issubclass(one, BaseModel):
                yield from fields(one, known)


def parts(annotation: Any) -> Iterator[Any]:
    yield annotation
    for one in get_args(annotation):
        yield from parts(one)


def test_law_every_quantity_of_the_language_acts_or_says_that_it_does_not():
    found = {(owner, name): alone for owner, name, alone in fields(Campaign, set())}
    assert len(found) > 60
    acting = {one for one, alone in found.items() if not alone}
    assert acting == set(ACTS) | set(OTHERWISE)
    assert not set(ACTS) & set(OTHERWISE)


def put(folder: Path, text: str) -> Path:
    """A campaign with the readings that it names."""
    rng = np.random.default_rng(5)
    if text.startswith("    rig:"):
        return written(folder, text, swings())
    rows = [
        f"{load},{repeat},loading,{0.5 * size + 0.004 * rng.standard_normal():.3f}"
        for repeat in (1, 2, 3, 4) for load, size in zip("ABC", (1, 2, 3), strict=True)
    ]  # fmt: skip
    (folder / "pull.csv").write_text("\n".join(["load,repeat,direction,reading / mm", *rows]) + "\n", encoding="utf-8")
    force = np.linspace(10, 2000, 400)
    if "relaxation" in text:
        force = np.interp(np.arange(400), [0, 50, 100, 400], [0, 0, 2000, 2000])
    clip, crosshead = force / 4e7, force * (0.1 / 2e6 + 2e-8)
    seen = clip if "gauge_length" in text else crosshead
    lines = [f"time / s,force / N,{'extension' if seen is clip else 'crosshead'} / mm"]
    scatter = 0.01 if "relaxation" in text else 1.0
    for at, one in enumerate(force):
        lines.append(
            f"{0.05 * at:.2f},{one + scatter * rng.normal():.4f},{1e3 * seen[at] + 1e-4 * scatter * rng.normal():.8f}"
        )
    (folder / "pulled.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    heading = "time / s,angle / rad" if "inertia" in text else "time / s,displacement / mm"
    for release in range(2):
        t = np.arange(2000) / 1000
        z = 0.4 * np.array([exp(-2.0 * at) * sin(2 * pi * 20 * at + 1.5) for at in t]) + 1e-4 * rng.normal(size=t.size)
        values = [f"{at:.4f},{one:.7f}" for at, one in zip(t, z, strict=True)]
        (folder / f"d{release}.csv").write_text("\n".join([heading, *values]) + "\n", encoding="utf-8")
    (folder / "campaign.yaml").write_text(text, encoding="utf-8")
    return folder / "campaign.yaml"


def swings() -> list[Any]:
    rng, t = np.random.default_rng(1), np.arange(800) / 100
    found = []
    for number in range(3):
        x = 0.05 * np.exp(-0.2 * t) * (np.cos(5 * t) + 0.04 * np.sin(5 * t)) + 1e-4 * rng.standard_normal(t.size)
        found.append(run(number, [("time / s,x / m", [t, x])], "start: {position: 0.05 m}"))
    return found


def evaluated(folder: Path, text: str) -> dict[str, Result]:
    folder.mkdir()
    return {one.name: one for one in chain.evaluate(undiagnosed(put(folder, text))).results}


@pytest.mark.long
@pytest.mark.parametrize("field", ACTS, ids="-".join)
def test_law_a_result_moves_by_its_budget_when_a_quantity_moves_by_its_u(field: tuple[str, str], tmp_path: Path):
    text, stated, further = ACTS[field]
    assert text.count(stated) == 1
    before = evaluated(tmp_path / "before", text)
    after = evaluated(tmp_path / "after", text.replace(stated, further))
    response = text.startswith("    rig:")
    acted = False
    for name, one in before.items():
        moved = after[name].framework.value - one.framework.value
        inputs = {row.input for row in one.budget}
        changed = {
            row.input for row in after[name].budget for old in one.budget
            if row.input == old.input and row.component == old.component and row.value != old.value
            and not row.component.startswith("record of")  # numbers of a record that was evaluated again
        }  # fmt: skip
        if response:
            changed = {row.input for row in one.budget if PRIORS[field[1]] in row.input}
        assert changed <= inputs
        expected = sum(row.sensitivity * row.u for row in one.budget if row.input in changed)
        if abs(expected) < 1e-9 * abs(one.framework.value) or (response and one.quantity not in ("k", "c")):
            continue
        acted = True
        assert abs(moved) == pytest.approx(abs(expected), rel=0.08), (name, moved, expected)
    assert acted


PRIORS = {"mass": "mass.factor", "model": "cubic.stiffness"}


@pytest.mark.parametrize(
    ("text", "stated", "loose", "where"),
    [
        (elongation(TAPE), "0.001 mm", "0.0010(1) mm", "instruments.dial.resolution"),
        (tension(f"{BY_CLIP}\n    range: {{share: [0, 0.43]}}"), "0.43", "0.43(2)", "tests.pull.range.share[1]"),
        (RIG, "k: 40 N/m", "k: 40(1) N/m", "tests.pull.identification.start.k"),
    ],
)  # fmt: skip
def test_law_where_the_value_alone_is_used_a_notice_says_so(text, stated, loose, where, tmp_path):
    assert load(put(tmp_path, text)).notices == ()
    (notice,) = load(put(tmp_path, text.replace(stated, loose))).notices
    assert notice.startswith(f"{where}: of '{loose.removeprefix('k: ')}' the value alone is used")
