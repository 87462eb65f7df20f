"""The test by scores, as the report prints it: statistic, limit and verdict belong together."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from metrology.diagnose import belief
from metrology.diagnose.engine import _score_test
from metrology.diagnose.linear import Score, Screen
from metrology.diagnose.selection import Rival
from metrology.diagnose.subject import Direction


def screened(z: float, p_value: float, limit: float) -> Screen:
    direction = Direction("transverse", {}, 1.0, (), looks=900.0)
    return Screen((Score(direction, 1.0, z, z, 1.0, p_value),), limit, 0.002, np.eye(1))


# z = 4.0 among 900 looks: p = 1 − (1 − 6.3e-5)^900; z = 1.4 one-sided; a score far beyond everything; none at all.
@pytest.mark.parametrize(("z", "p_value"), [(4.0, 0.055), (1.4, 0.081), (12.0, 1e-30), (-0.5, 1.0)])
def test_law_the_statistic_lies_beyond_its_limit_where_the_score_fails_and_nowhere_else(z: float, p_value: float):
    found = _score_test(screened(z, p_value, 5.5e-4), 0.002)
    assert found.passed == (found.statistic < found.limit)
    assert found.passed == (p_value > 5.5e-4)


def test_law_a_score_picked_among_many_says_how_rare_it_is():
    assert "4.0 standard deviations, as rare as 1.9 of a single two-sided look (p = 0.055" in (
        _score_test(screened(4.0, 0.055, 5.5e-4), 0.002).sentence
    )
    assert "4.0 standard deviations (p = 6.3e-05" in _score_test(screened(4.0, 6.334e-5, 5.5e-4), 0.002).sentence


def test_law_the_best_shape_is_the_largest_score_where_no_p_value_is_left_to_tell():
    shapes = [Score(Direction("toe", {"toe.extent": z}, 1.0, ()), 1.0, z, z, 1.0, 0.0) for z in (51.9, 57.0, 40.0)]
    assert Screen(tuple(shapes), 5e-4, 0.002, np.eye(3)).best("toe").z == 57.0


def test_law_a_score_beyond_the_smallest_p_value_is_told_as_it_is():
    found = _score_test(screened(192.1, 0.0, 5.5e-4), 0.002)
    assert found.statistic == 192.1
    assert "192.1 standard deviations (p < 1e-300" in found.sentence


def test_law_one_model_by_two_names_counts_once_among_those_that_do_equally_well():
    def rival(name: str, *residuals: float) -> Rival:
        fit = SimpleNamespace(full=(np.array(residuals),), used=(np.ones(len(residuals), dtype=bool),))
        return Rival(name, fit, 5.0)

    group = (rival("frame", 1.0, 9.0), rival("yaw", 1.0, 9.01), rival("zener", 8.0, 1.0), rival("hum x", -3.0, 4.0))
    assert belief.apart(group) == 3
    assert belief.apart(group[:2]) == 1
    assert not belief.alike(group)
