"""Readings in groups: printed digits of the GUM, sums by hand, and variances that were planted."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from metrology.errors import MetrologyError
from metrology.gum.anova import crossed, nested

H5_MEANS = (172, 116, 13, 144, 106, 31, 60, 125, 163, 41)  # µV above 10 V
H5_SCATTER = (60, 77, 111, 101, 67, 93, 80, 73, 88, 86)  # µV


def test_reference_gum_h5() -> None:
    pattern = np.array([-1.0, -1.0, 0.0, 1.0, 1.0])
    readings = np.concatenate([m + s * pattern for m, s in zip(H5_MEANS, H5_SCATTER, strict=True)])
    found = nested(readings, [[str(day) for day in range(10) for _ in range(5)]], ["day"])
    assert (round(sqrt(found["day"].mean_square)), found["day"].dof) == (128, 9)
    assert (round(sqrt(found["within"].mean_square)), found["within"].dof) == (85, 40)
    assert round(found.test("day")[0], 2) in (2.25, 2.26)
    assert 0.025 < found.test("day")[1] < 0.05  # above F_0.95(9, 40) = 2.12, below F_0.975(9, 40) = 2.45
    assert (round(found.mean, 1), round(found.u), found.dof) == (97.1, 18, 9)
    assert (round(found.s("day")), round(found.s("within"))) == (43, 85)


def test_sums_by_hand_crossed_with_repeats() -> None:
    """Two operators, two parts, read twice: cells (1, 3), (5, 7), (2, 4), (10, 12)."""
    readings = np.array([1.0, 3.0, 5.0, 7.0, 2.0, 4.0, 10.0, 12.0])
    groups = [["A"] * 4 + ["B"] * 4, ["p", "p", "q", "q"] * 2]
    found = crossed(readings, groups, ["operator", "part"])
    squares = {one.name: one.mean_square for one in found.strata}
    assert squares == pytest.approx({"operator": 18.0, "part": 72.0, "operator_part": 8.0, "within": 2.0})
    assert [one.dof for one in found.strata] == [1, 1, 1, 4]
    assert found.s("operator") == pytest.approx(sqrt((18 - 8) / 4))
    assert found.s("part") == pytest.approx(sqrt((72 - 8) / 4))
    assert found.s("operator_part") == pytest.approx(sqrt((8 - 2) / 2))
    assert found.u == pytest.approx(sqrt((18 + 72 - 8) / 8))
    assert found.dof == pytest.approx(82**2 / (18**2 + 72**2 + 8**2))


def test_planted_variances_of_a_gauge_come_back_on_average() -> None:
    generator = np.random.default_rng(1)
    operators, parts, repeats, studies = 4, 8, 3, 400
    sizes = {"operator": 2.0, "part": 5.0, "operator_part": 1.0, "within": 1.5}
    groups = [
        np.repeat(np.arange(operators), parts * repeats),
        np.tile(np.repeat(np.arange(parts), repeats), operators),
    ]
    labels = [group.astype(str).tolist() for group in groups]
    variances, held = dict.fromkeys(sizes, 0.0), 0.0
    for _ in range(studies):
        by_operator, by_part = 2.0 * generator.standard_normal(operators), 5.0 * generator.standard_normal(parts)
        both = generator.standard_normal((operators, parts))
        readings = by_operator[groups[0]] + by_part[groups[1]] + both[groups[0], groups[1]]
        found = crossed(readings + 1.5 * generator.standard_normal(readings.size), labels, ["operator", "part"])
        for one in found.strata:
            below = found[one.below].mean_square if one.below else 0.0
            variances[one.name] += (one.mean_square - below) / one.count / studies
        held += found.mean**2 / found.u**2 / studies
    for name, size in sizes.items():
        assert variances[name] == pytest.approx(size**2, rel=0.15), name
    assert 0.9 < held < 1.5  # mean of t² with about ten degrees of freedom: ν/(ν − 2)


def test_mean_of_mountings_within_days_has_the_scatter_of_the_days() -> None:
    readings = np.array([1.0, 2.0, 3.0, 4.0, 11.0, 12.0, 13.0, 14.0])
    days, mountings = ["1"] * 4 + ["2"] * 4, ["a", "a", "b", "b"] * 2
    found = nested(readings, [days, mountings], ["day", "mounting"])
    assert [one.name for one in found.strata] == ["day", "mounting", "within"]
    assert [one.mean_square for one in found.strata] == pytest.approx([200.0, 4.0, 0.5])
    assert (found.u, found.dof) == (pytest.approx(5.0), 1.0)


@pytest.mark.parametrize(
    ("way", "groups", "told"),
    [
        (nested, [["1", "1", "1", "2"]], "groups of 1 to 3 readings"),
        (nested, [["1"] * 4], "one group"),
        (nested, [["1", "2", "3", "4"]], "one reading in each group"),
        (crossed, [["a", "a", "b", "b"], ["p", "q", "r", "s"]], "4 of the 8 combinations"),
    ],
)
def test_refusal_of_what_no_sums_of_squares_part(way: object, groups: list[list[str]], told: str) -> None:
    with pytest.raises(MetrologyError, match=told):
        way(np.array([1.0, 2.0, 3.0, 5.0]), groups, ["f", "g"][: len(groups)])  # type: ignore[operator]
