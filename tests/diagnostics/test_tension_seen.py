"""What a record has to show before a cause is named: soft curves, hand-pulled springs, and breaks that are there."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from truth_soft import broken, by_hand, exponential, mooney

from metrology.diagnosis import Diagnosis
from metrology.diagnostics import tension
from metrology.effect import Pulled
from metrology.gum.inputs import Input
from metrology.tension.lines import lines
from metrology.tension.test import Mounting, Range, TensionTest

WHOLE = Range("share", 0.02, 0.95)


def pulled(read: dict[str, np.ndarray], chosen: Range) -> TensionTest:
    """One specimen of 100 mm that is read by the crosshead, with classes that allow 2 %."""
    length = Input("length", 0.1, (), "m")
    one = Mounting("a", read["force"], read["time"], read["crosshead"], (), length)
    return TensionTest("pull", (one,), chosen, tolerance=0.02)


def diagnosed(read: dict[str, np.ndarray], chosen: Range) -> Diagnosis:
    test = pulled(read, chosen)
    return tension(test, lines(test), rng=np.random.default_rng(0))


def sizes(found: Diagnosis) -> dict[str, tuple[float, float]]:
    return {one.name: (one.value, one.u) for cause in found.causes if cause.verdict == "supported"
            for one in cause.parameters}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("count", [63, 120, 600])
@pytest.mark.parametrize("curve", [mooney, exponential])
@pytest.mark.parametrize("chosen", [Range(), WHOLE], ids=["longest", "whole"])
def test_law_a_curve_that_softens_evenly_has_no_step(curve, count, chosen):
    found = diagnosed(curve(count, np.random.default_rng(count)), chosen)
    assert not {"lost section", "slip"} & set(found.named), found.sentence
    # What is named has a size that is known from none.
    assert all(u < abs(value) for value, u in sizes(found).values())


@pytest.mark.long
@pytest.mark.parametrize("count", [63, 120])
@pytest.mark.parametrize("seed", range(3))
def test_law_a_spring_that_is_pulled_by_hand_has_no_step_and_its_stiffness(count, seed):
    found = diagnosed(by_hand(count, np.random.default_rng(seed)), Range())
    assert not {"lost section", "slip", "yield"} & set(found.named), found.sentence
    if found.supported is not None:
        rows = zip(found.supported.names, found.supported.values, found.supported.u, strict=True)
        slope, u = next((value, u) for name, value, u in rows if name == "slope")
        # Strain by force, over 100 mm of 50 N/m.
        assert abs(slope - 1 / (50.0 * 0.1)) < 4 * u


@pytest.mark.parametrize(("count", "at"), [(120, 0.35), (600, 0.3), (600, 0.7)])
def test_planted_break_of_one_specimen_is_named_with_its_size(count, at):
    read = broken(count, np.random.default_rng(count), at=at)
    found = diagnosed(read, WHOLE)
    assert "lost section" in found.named, found.sentence
    # One twentieth lost makes the slope one nineteenth larger, here over that of the line through all readings.
    slope = lines(pulled(read, WHOLE))[0].main.value
    value, u = sizes(found)["section.lost"]
    assert abs(value - 5e-6 / 19 / slope) < 4 * u


def test_law_what_broke_in_the_first_half_is_broken_in_the_second():
    first = Pulled(np.arange(8.0), np.arange(8.0), np.ones(8), number=0, many=2, steps=4, halves=2)
    second = Pulled(np.arange(8.0), 8 + np.arange(8.0), np.ones(8), number=1, many=2, steps=4, halves=2)
    other = Pulled(np.arange(8.0), np.arange(8.0), np.ones(8), number=1, many=2, steps=4)
    assert first.after(1.0).tolist() == [0, 0, 0, 1, 1, 1, 1, 1]
    assert second.after(1.0).tolist() == [1] * 8
    assert second.after(5.0).tolist() == first.after(1.0).tolist()
    assert first.after(5.0).tolist() == other.after(1.0).tolist() == [0] * 8
