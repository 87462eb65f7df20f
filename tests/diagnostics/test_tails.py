"""Heavy tails of few readings: their likelihood by another way, and what they leave of a misread reading."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import truth_elongation
from plain_cases import stretched
from scipy import stats
from scipy.optimize import minimize

from metrology.diagnostics import elongation
from metrology.diagnostics.tails import TAILS, _likelihood
from metrology.language.answers import short


def drawn(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Columns of a line, and readings about it with heavy tails."""
    rng = np.random.default_rng(seed)
    rows = np.column_stack([np.ones(40), np.linspace(-1.0, 1.0, 40)])
    return rows, rows @ [0.3, -2.0] + 0.1 * rng.standard_t(3, 40)


@pytest.mark.parametrize("dof", [*TAILS, math.inf])
def test_twice_likelihood_is_that_of_a_search(dof: float) -> None:
    rows, sought = drawn(1)
    law = stats.norm if math.isinf(dof) else stats.t(dof)

    def cost(p: np.ndarray) -> float:
        return -float(np.sum(law.logpdf((sought + rows @ p[:2]) / np.exp(p[2])) - p[2]))

    best = minimize(cost, [-0.3, 2.0, -2.0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-9}).fun
    assert _likelihood(rows, sought, (40, 0.0), dof) == pytest.approx(-best, abs=1e-5)


def test_limit_tails_of_many_degrees_of_freedom_are_normal() -> None:
    rows, sought = drawn(2)
    assert _likelihood(rows, sought, (40, 0.0), 1e7) == pytest.approx(
        _likelihood(rows, sought, (40, 0.0), math.inf), abs=1e-4
    )


@pytest.mark.long
@pytest.mark.parametrize("material", ["al-1100", "peek"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_planted_reading_that_noise_may_have_is_not_called_misread(material: str, seed: int) -> None:
    """One reading 5.5 standard deviations off, as one set in ten has with a t of three degrees of freedom."""
    scatter = truth_elongation.MATERIALS[material].scatter
    near, far = (
        elongation(stretched(material, seed, {"misread": times * scatter}), rng=np.random.default_rng(seed))
        for times in (5.5, 30.0)
    )
    assert near.named == ()
    assert set(near.possible) <= {"misread"}
    assert far.named == ("misread",)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_planted_reading_far_off_a_coarse_division_is_misread(seed: int) -> None:
    """Readings that rounding makes agree are no noise without a body, of which a t has tails as long as it takes."""
    division = 5 * truth_elongation.MATERIALS["al-1100"].scatter
    far = elongation(
        stretched("al-1100", seed, {"division": division, "misread": 10 * division}), rng=np.random.default_rng(seed)
    )
    assert far.named == ("misread",)


@pytest.mark.parametrize("seed", [31, 32])
def test_planted_readings_far_off_are_no_normal_noise(seed: int) -> None:
    """Eight of 48 that are off by twenty times the scatter: the check of outliers fails, and so does a test here."""
    test, rng = stretched("al-1100", seed, {}), np.random.default_rng(seed)
    off_by = dict(zip(rng.choice(48, 8, replace=False).tolist(), rng.choice([-6e-5, 6e-5], 8).tolist(), strict=True))
    readings = tuple(replace(one, value=one.value + off_by.get(at, 0.0)) for at, one in enumerate(test.readings))
    found = elongation(replace(test, readings=readings), rng=rng)
    assert {one.name: one.passed for one in found.tests}["normal noise"] is False
    assert found.verdict != "nothing missing" or "the noise is not normal" in found.sentence
    assert "normal noise" not in {one.name for one in elongation(test, rng=rng).tests}


def test_planted_second_misread_reading_is_told_beside_the_first() -> None:
    """Two that are off by 40 and 60 times the scatter: one has the name, and the other does not go unsaid."""
    test = stretched("al-1100", 33, {})
    scatter = truth_elongation.MATERIALS["al-1100"].scatter
    off_by = {9: 40 * scatter, 30: -60 * scatter}
    readings = tuple(replace(one, value=one.value + off_by.get(at, 0.0)) for at, one in enumerate(test.readings))
    found = elongation(replace(test, readings=readings), rng=np.random.default_rng(33))
    alone = tuple(replace(one, value=one.value + (at == 9) * off_by[9]) for at, one in enumerate(test.readings))
    single = elongation(replace(test, readings=alone), rng=np.random.default_rng(33))
    assert found.named == single.named == ("misread",)
    assert "the noise is not normal" in found.sentence
    assert "the noise is not normal" in short(found)
    assert "not normal" not in single.sentence
    assert "not normal" not in short(single)
