"""Units and notes that fit the size of what is measured: a soft specimen, and many loads."""

from __future__ import annotations

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.findings import Findings
from metrology.report.lines import main_results

SOFT = """
format: metrology-campaign/1
id: soft
title: A soft band under many weights
instruments: {{ruler: {{kind: ruler, resolution: 0.5 mm}}}}
samples:
  band:
    section: {{shape: tape, width: 20.0(1) mm, thickness: 5.0(1) mm}}
    length: 500(1) mm
tests:
  pull:
    method: elongation
    sample: band
    instruments: {{extension: ruler}}
    loads: {{{loads}}}
    readings: pull.csv
"""
LOADS = {f"n{at}": 0.11085 * at for at in range(1, 31)}


@pytest.fixture(scope="module")
def soft(tmp_path_factory: pytest.TempPathFactory) -> Findings:
    folder = tmp_path_factory.mktemp("soft")
    loads = ", ".join(f"{name}: {{force: {force:.5f} N}}" for name, force in LOADS.items())
    (folder / "campaign.yaml").write_text(SOFT.format(loads=loads), encoding="utf-8")
    rows = (
        f"{name},{repeat},loading,{0.5 * round(2e3 * force / 21 + shift)}"
        for repeat, shift in ((1, 0.3), (2, -0.2), (3, 0.6))
        for name, force in LOADS.items()
    )
    (folder / "pull.csv").write_text("load,repeat,direction,reading / mm\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return chain.evaluate(load(folder / "campaign.yaml"), coverage=False)


def test_law_a_modulus_is_shown_with_the_prefix_of_its_size(soft: Findings) -> None:
    shown = {line.result.quantity: (line.value, line.shown.unit) for line in main_results(soft)}
    assert shown["E"][1] == "MPa"
    assert float(shown["E"][0]) == pytest.approx(0.105, rel=0.05)
    assert shown["k"][1] == "N/m"


def test_law_many_loads_without_an_uncertainty_are_one_entry_of_a_note(soft: Findings) -> None:
    (note,) = [one for one in soft.warnings if one.startswith("pull: no uncertainty is stated")]
    assert note.count("load n") == 1
    assert "loads, of which load n" in note
    values = {one.name: one for one in soft.exact}
    loads = [one for name, one in values.items() if name.startswith("pull.load ")]
    assert len(loads) > 4
    assert all(one.u < 0.5 * one.value for one in loads)


def test_law_a_large_stiffness_is_shown_with_a_prefix(tmp_path) -> None:
    rows = [f"{0.1 * i:.1f},{50.0 * i},{1e-6 * i + 1e-8 * ((7 * i) % 5 - 2):.8f}" for i in range(60)]
    (tmp_path / "bar.csv").write_text("time / s,force / N,strain / 1\n" + "\n".join(rows) + "\n", encoding="utf-8")
    (tmp_path / "campaign.yaml").write_text(
        "format: metrology-campaign/1\nid: bar\ntitle: Stiffness of a bar\n"
        "instruments: {cell: {kind: load cell, class: 0.5}, ext: {kind: extensometer, class: 0.5}}\n"
        "samples: {bar: {length: 100.0(1) mm}}\ntests:\n  pull:\n    method: tension\n    sample: bar\n"
        "    instruments: {force: cell, strain: ext}\n    specimens: {one: {readings: bar.csv}}\n",
        encoding="utf-8",
    )
    found = chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False)
    shown = {line.result.quantity: line.shown for line in main_results(found)}
    assert shown["k"].unit == "MN/m"
    assert float(shown["k"].value) == pytest.approx(500, rel=0.01)
    assert next(one for one in found.results if one.name == "pull.k").value == pytest.approx(5e8, rel=0.01)


@pytest.mark.parametrize(
    ("typed", "printed"),
    [
        ("um", "µm"), ("us/m", "µs/m"), ("degC", "°C"), ("deg", "°"), ("°", "°"), ("kohm", "kΩ"), ("m^2", "m²"),
        ("N*s/m", "N·s/m"), ("m**-2", "m⁻²"), ("%", "%"), ("1", ""), ("deg/s^2", "°/s²"), ("W/(m*K)", "W/(m·K)"),
    ],
)  # fmt: skip
def test_law_a_unit_is_printed_alike_however_it_was_typed(typed: str, printed: str) -> None:
    from metrology.gum.rounding import readable
    from metrology.units import factor, unit_text

    assert unit_text(typed) == printed
    assert factor(printed or "1") == factor(typed)
    assert readable(2.0, typed, 1).partition(" ")[2] == printed
