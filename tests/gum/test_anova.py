"""Readings in groups: printed digits of the GUM, sums by hand, and variances that were planted."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from scipy.stats import t as student

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
    assert 0.025 < found.test("day")[2] < 0.05  # above F_0.95(9, 40) = 2.12, below F_0.975(9, 40) = 2.45
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
            variances[one.name] += found.sum(one.variance)[0] / studies
        held += found.mean**2 / found.u**2 / studies
    for name, size in sizes.items():
        assert variances[name] == pytest.approx(size**2, rel=0.15), name
    assert 0.9 < held < 1.5  # mean of t² with about ten degrees of freedom: ν/(ν − 2)


def test_limit_a_small_interaction_keeps_its_digits_beside_large_factors() -> None:
    generator = np.random.default_rng(3)
    groups = [["A"] * 8 + ["B"] * 8, ["p", "p", "q", "q", "r", "r", "s", "s"] * 2]
    small = generator.normal(size=16)
    large = small + 1e6 * np.array([group == "B" for group in groups[0]])
    plain, beside = (crossed(readings, groups, ["day", "part"]) for readings in (small, large))
    assert beside["day_part"].mean_square == pytest.approx(plain["day_part"].mean_square, rel=1e-8)


def test_mean_of_mountings_within_days_has_the_scatter_of_the_days() -> None:
    readings = np.array([1.0, 2.0, 3.0, 4.0, 11.0, 12.0, 13.0, 14.0])
    days, mountings = ["1"] * 4 + ["2"] * 4, ["a", "a", "b", "b"] * 2
    found = nested(readings, [days, mountings], ["day", "mounting"])
    assert [one.name for one in found.strata] == ["day", "mounting", "within"]
    assert [one.mean_square for one in found.strata] == pytest.approx([200.0, 4.0, 0.5])
    assert (found.u, found.dof) == (pytest.approx(5.0), 1.0)


# Groups that differ in size

DAYS = ["1"] * 7 + ["2"] * 2 + ["3"] * 4 + ["4"] * 3
MOUNTINGS = [*"aaabbcd", *"aa", *"aaab", *"abb"]
PARTS = [*"ppqqrrs", *"pq", *"qqrs", *"pss"]
"""Crossed with the days: 5 of 16 combinations are missing, the others are read once or twice."""


def _projection(*factors: list[str]) -> np.ndarray:
    """Onto what the levels of factors span, by a pseudo-inverse of N rows."""
    columns = [
        np.array([[one == level for level in dict.fromkeys(factor)] for one in factor], float) for factor in factors
    ]
    whole = np.hstack(columns)
    return whole @ np.linalg.pinv(whole)


def _shared(factor: list[str]) -> np.ndarray:
    return np.array([[one == other for other in factor] for one in factor], dtype=float)


def test_twice_variances_against_projections_of_all_readings() -> None:
    """E(yᵀQy) = Σ σ²·tr(Q·ZZᵀ): the variances of the strata are their own where the expectations are put in."""
    none, rng = ["all"] * len(DAYS), np.random.default_rng(1)
    cells = [f"{day}{part}" for day, part in zip(DAYS, PARTS, strict=True)]
    inner = [f"{day}{mounting}" for day, mounting in zip(DAYS, MOUNTINGS, strict=True)]
    sides = {
        nested: ([none], [DAYS], [inner], None),
        crossed: ([PARTS], [DAYS, PARTS], [DAYS], [DAYS, PARTS], [DAYS, PARTS], [cells], [cells], None),
    }
    readings, eye = rng.normal(size=len(DAYS)), np.eye(len(DAYS))
    project = lambda side: eye if side is None else _projection(*side)  # noqa: E731
    for way, labels, sources in (
        (nested, (DAYS, MOUNTINGS), (DAYS, inner)),
        (crossed, (DAYS, PARTS), (DAYS, PARTS, cells)),
    ):
        pairs = list(zip(sides[way], sides[way][1:], strict=False))[:: 1 if way is nested else 2]
        forms = [project(more) - project(less) for less, more in pairs]
        found = way(readings, labels, ["day", "other"])
        for form, one in zip(forms, found.strata, strict=True):
            assert one.dof == round(np.trace(form))
            assert one.mean_square == pytest.approx(readings @ form @ readings / one.dof)
        shared = [*map(_shared, sources), eye]
        expected = {
            one.name: [np.trace(form @ part) / one.dof for part in shared]
            for form, one in zip(forms, found.strata, strict=True)
        }
        for at, one in enumerate(found.strata):
            told = sum(part * np.array(expected[name]) for name, part in one.variance.items())
            assert told == pytest.approx(np.eye(len(shared))[at], abs=1e-9), one.name


def test_closed_form_one_factor_of_groups_that_differ_in_size() -> None:
    readings = np.array([1.0, 3.0, 6.0, 5.0, 9.0, 10.0, 11.0])
    found = nested(readings, [["1", "1", "2", "3", "3", "3", "3"]], ["day"])
    means, sizes = np.array([2.0, 6.0, 8.75]), np.array([2, 1, 4])
    assert found["day"].count == pytest.approx((7 - (sizes**2).sum() / 7) / 2)
    assert found["day"].mean_square == pytest.approx((sizes * (means - readings.mean()) ** 2).sum() / 2)
    assert (found.mean, found.u) == pytest.approx((means.mean(), means.std(ddof=1) / sqrt(3)))
    assert (found.dof, found["within"].dof) == (2.0, 4)


@pytest.mark.long
@pytest.mark.parametrize("sizes", [(2.0, 1.0, 0.5), (0.0, 0.0, 1.0), (3.0, 0.0, 1.0)])
@pytest.mark.parametrize("way", [nested, crossed])
def test_planted_variances_and_mean_of_groups_that_differ_in_size(way, sizes) -> None:
    generator, studies = np.random.default_rng(2), 2000
    second = MOUNTINGS if way is nested else PARTS
    both = list(zip(DAYS, second, strict=True))
    keys = [DAYS, both if way is nested else PARTS] + [both] * (way is crossed)
    spread = [*sizes[:2], 0.7, sizes[2]] if way is crossed else list(sizes)
    index = [np.unique(np.array([str(one) for one in key]), return_inverse=True)[1] for key in keys]
    total, held = np.zeros(len(spread)), 0
    for _ in range(studies):
        readings = spread[-1] * generator.standard_normal(len(DAYS))
        for s, key in zip(spread, index, strict=False):
            readings = readings + s * generator.standard_normal(key.max() + 1)[key]
        found = way(readings, (DAYS, second), ["day", "other"])
        total += [found.sum(one.variance)[0] / studies for one in found.strata]
        held += abs(found.mean) < found.u * student.isf(0.025, found.dof)
    largest = max(spread) ** 2
    assert total == pytest.approx(np.square(spread), abs=0.12 * largest)
    assert 0.935 < held / studies < 0.995


@pytest.mark.parametrize(
    ("way", "groups", "told"),
    [
        (crossed, [["a", "a", "b", "c"], ["p", "q", "p", "r"]], "4 of the 9 combinations"),
        (nested, [["1"] * 4], "one group"),
        (nested, [["1", "2", "3", "4"]], "one reading in each group"),
        (crossed, [["a", "a", "b", "b"], ["p", "q", "r", "s"]], "4 of the 8 combinations"),
    ],
)
def test_refusal_of_what_no_sums_of_squares_part(way: object, groups: list[list[str]], told: str) -> None:
    with pytest.raises(MetrologyError, match=told):
        way(np.array([1.0, 2.0, 3.0, 5.0]), groups, ["f", "g"][: len(groups)])  # type: ignore[operator]
