"""What a campaign file says twice of a sample and not alike is a notice on page 1 and the terminal."""

from __future__ import annotations

from pathlib import Path

import pytest

from metrology import chain
from metrology.campaign.load import load

TEXT = """\
format: metrology-campaign/1
id: two
title: Two wires
diagnosis: {off: true}
instruments: {indicator: {kind: dial indicator, resolution: 0.01 mm}}
samples:
  a: {length: 2.000(1) m, section: {shape: round, diameter: 0.500(2) mm}, linear_density: LINEAR,
    density: 7850(10) kg/m^3}
  b: {length: 2.000(1) m, section: {shape: round, diameter: 0.500(2) mm}}
tests:
  pull: {method: elongation, sample: b, instruments: {extension: indicator}, gravity: 9.8065(3) m/s^2,
    loads: {A: {force: 10.0 N}, B: {force: 20.0 N}, C: {force: 30.0 N}}, readings: pull.csv}
  draw: {method: elongation, sample: a, instruments: {extension: indicator}, gravity: 9.8065(3) m/s^2,
    loads: {A: {force: 10.0 N}, B: {force: 20.0 N}, C: {force: 30.0 N}}, readings: draw.csv}
derived:
  - {quantity: y, sample: a, expression: EXPRESSION, where: {k: draw.k, j: pull.k, L: a.length}, unit: UNIT}
"""
READINGS = "load,repeat,reading / mm\n" + "".join(
    f"{load},{repeat},{size + 0.01 * ((repeat + at) % 2):.2f}\n"
    for repeat in (1, 2, 3) for at, (load, size) in enumerate((("A", 0.5), ("B", 1.0), ("C", 1.5)))
)  # fmt: skip


def notices(folder: Path, linear: str = "1.541(3) g/m", expression: str = "k*L", unit: str = "N") -> str:
    for name, readings in (("pull", READINGS), ("draw", READINGS.replace("0.50", "0.51"))):
        (folder / f"{name}.csv").write_text(readings)
    text = TEXT.replace("LINEAR", linear).replace("EXPRESSION", expression).replace("UNIT", unit)
    where = ("k: draw.k", "j: pull.k", "L: a.length")
    text = text.replace(", ".join(where), ", ".join(one for one in where if one[0] in expression))
    (folder / "campaign.yaml").write_text(text)
    found = chain.evaluate(load(folder / "campaign.yaml"), coverage=False)
    return " ".join(one.sentence for one in found.notices)


@pytest.mark.parametrize("linear", ["2.300(5) g/m", "1.100(5) g/m"])
def test_planted_a_density_that_linear_density_and_section_contradict(linear: str, tmp_path: Path) -> None:
    """Within the factor of two that is refused, and beyond the uncertainties."""
    told = "by linear density over section"
    assert told in notices(tmp_path, linear)
    assert told not in notices(tmp_path)


def test_planted_a_quantity_of_one_sample_that_is_made_of_results_of_another(tmp_path: Path) -> None:
    told = "a.y is stated as one of sample a, and every result in it is of another one: pull.k (b)."
    assert told in notices(tmp_path, expression="j*L")
    assert "is stated as one of sample" not in notices(tmp_path)
    assert "is stated as one of sample" not in notices(tmp_path, expression="k/j", unit="1")
