"""Hertz and radians per second are both 1/s: one stated for the other is refused, by a factor of 2π."""

from __future__ import annotations

from pathlib import Path

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError

HEAD = """\
format: metrology-campaign/1
id: turning
title: Frequencies
quantities: {f: 21.46(1) Hz, w: 134.84(5) rad/s, m: 1.1(1) kg}
derived:
"""


def written(folder: Path, derived: str, rest: str = "") -> Path:
    path = folder / "campaign.yaml"
    path.write_text(HEAD + f"  - {{quantity: y, {derived}}}\n" + rest, encoding="utf-8")
    return path


def limit(quantity: str, text: str) -> str:
    entry = f"{{id: R, quantity: {quantity}, limits: {{lower: {text}}}, decision: {{rule: guard band}}}}"
    return f"requirements: [{entry}]\n"


GOOD = "expression: w / (2*pi), unit: Hz"


@pytest.mark.parametrize(
    ("derived", "rest", "place"),
    [
        # 21.46 Hz passed a limit of 100 Hz as 134.84 rad/s.
        (GOOD, limit("w", "100 Hz"), "requirements[0].limits.lower"),
        (GOOD, limit("y", "130 rad/s"), "requirements[0].limits.lower"),
        (GOOD, limit("w", "1000 rpm"), "requirements[0].limits.lower"),
        ("expression: w, unit: Hz", "", "derived[0].unit"),
        ("expression: (w + sqrt(w**2 + w*w)) / 2, unit: rpm", "", "derived[0].unit"),
        ("expression: f, unit: rad/s", "", "derived[0].unit"),
        (GOOD, "comparisons: [{between: [f, w]}]\n", "comparisons[0].between"),
        (GOOD, "comparisons: [{between: [w, {value: 21 Hz, source: s}]}]\n", "comparisons[0].between"),
        (GOOD, "audit: [{figure: f, quantity: w, published: 21.46 Hz}]\n", "audit[0].published"),
    ],
)
def test_refusal_one_for_the_other(derived, rest, place, tmp_path):
    with pytest.raises(MetrologyError) as caught:
        load(written(tmp_path, derived, rest))
    (fault,) = caught.value.faults
    assert place in fault.where
    assert fault.fix == "ω = 2π·f"


@pytest.mark.parametrize(
    ("derived", "found"),
    [(GOOD, 21.46), ("expression: m * w**2, unit: N/m", 2e4),
     ("expression: f * w / w, unit: Hz", 21.46), ("expression: w, unit: 1/s", 134.84)],
)  # fmt: skip
def test_law_what_is_of_its_kind_is_judged(derived, found, tmp_path):
    findings = chain.evaluate(load(written(tmp_path, derived, limit("w", "100 rad/s"))), coverage=False)
    (y,) = (one for one in findings.results if one.name == "y")
    assert y.value == pytest.approx(found, rel=1e-4)
    assert findings.conformity[0].verdict == "pass"


def test_refusal_a_reference_of_a_natural_frequency_in_hertz(tmp_path):
    (tmp_path / "r.csv").write_text("time / s,displacement / um\n0,1\n1,2\n", encoding="utf-8")
    text = (
        "format: metrology-campaign/1\nid: t\ntitle: T\ninstruments: {v: {kind: vibrometer}}\n"
        "samples: {a: {references: {omega_n: {value: 21.46(1) Hz, source: model}}}}\ntests:\n"
        + "".join(
            f"  {name}: {{method: decay, sample: a, instruments: {{displacement: v}}, mass: 1 kg, readings: [r.csv]}}\n"
            for name in "de"
        )
    )
    (tmp_path / "campaign.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(MetrologyError) as caught:
        load(tmp_path / "campaign.yaml")
    (fault,) = [one for one in caught.value.faults if "references" in one.where]
    assert "samples.a.references.omega_n" in fault.where
