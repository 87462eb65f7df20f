"""Results by several tests that differ by one planted effect: it is named, or the answer is that they cannot decide."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from metrology.diagnostics.across import explain
from metrology.diagnostics.single import OFF, SHARE, Rows

U = 0.003
"""Relative standard uncertainty of each planted result."""


def measured(rng, true, tests, *, days=None):
    """Results of `tests`: (sample, set-up, instrument, seconds, factor of what is planted); k by the sample."""
    k = np.array([true[sample] * factor for sample, *_, factor in tests])
    y = k * (1 + U * rng.standard_normal(len(k)))
    names = [f"t{at}" for at in range(len(tests))]
    return Rows(
        tests=tuple(names), samples=tuple(one[0] for one in tests), values=y, covariance=U**2 * np.eye(len(y)),
        seconds=np.array([one[3] for one in tests], float), rigs=tuple(one[1] for one in tests),
        instruments=tuple((one[2],) for one in tests), days=days or (0,) * len(y), stiffness=y,
    )  # fmt: skip


FIVE = (
    ("s", "A", "a", 60.0),
    ("s", "B", "b", 30.0),
    ("s", "", "c", 1000.0),
    ("s", "D", "d", 0.01),
    ("s", "E", "e", 0.2),
)
"""Dead loads, machine, relaxation, decay and response of one sample, each with its own set-up."""
LINES = {"stiff": 24000.0, "middle": 8000.0, "soft": 1800.0}


def five(rng, factor, **kwargs):
    return measured(rng, {"s": 9000.0}, [(*one, factor(at, one[3])) for at, one in enumerate(FIVE)], **kwargs)


def by_rig(rng, compliance, times=(60.0, 0.02), repeats=2):
    """Lines that hang from one frame under dead loads, which gives way, and from another one in free decays."""
    tests = [
        (line, rig, rig, times[rig == "table"], 1 / (1 + compliance * k) if rig == "frame" else 1.0)
        for line, k in LINES.items() for rig in ("frame", "table") for _ in range(repeats)
    ]  # fmt: skip
    return measured(rng, LINES, tests)


def kinds(made):
    return [(one.verdict, one.candidates[0].kind, one.candidates[0].title) for one in made]


@pytest.mark.long
def test_planted_rate_dependence_is_found_with_its_size():
    rng = np.random.default_rng(1)
    made = [explain(five(rng, lambda _, t: t**-0.02), "k") for _ in range(20)]
    assert sum(found[:2] == ("explained", "rate") for found in kinds(made)) >= 19
    sizes = [(one.candidates[0].value - 0.02) / one.candidates[0].u for one in made]
    assert np.abs(sizes).max() < 4


@pytest.mark.parametrize("at", range(5))
@pytest.mark.parametrize("factor", [0.93, 1.1])
def test_planted_wrong_test_is_named_as_outlying(at, factor):
    rng = np.random.default_rng(at)
    made = explain(five(rng, lambda i, _: factor if i == at else 1.0), "k")
    named = [one.title for one in made.candidates if one.probability > 0.05]
    assert f"t{at} alone is off" in named
    if made.verdict == "explained":
        assert named == [f"t{at} alone is off"]
    else:
        # What acts in 10 ms alone, or in 1000 s alone, may depend on time.
        assert at in (2, 3)


@pytest.mark.long
def test_planted_compliance_of_a_shared_set_up_is_found_with_its_size():
    rng = np.random.default_rng(2)
    made = [explain(by_rig(rng, 4e-6), "k") for _ in range(20)]
    assert sum(found[:2] == ("explained", "set-up") for found in kinds(made)) >= 19
    assert all("t0, t1, t4, t5, t8, t9 share" in title for verdict, _, title in kinds(made) if verdict == "explained")
    sizes = [(one.candidates[0].value - 4e-6) / one.candidates[0].u for one in made]
    assert np.abs(sizes).max() < 4


def test_planted_wrong_scale_of_an_instrument_is_no_compliance():
    rng = np.random.default_rng(3)
    made = [explain(by_rig(rng, 0.0), "k") for _ in range(3)]
    assert all(one.verdict != "explained" for one in made)
    tests = [
        (line, rig, rig, 1.0, 0.95 if rig == "frame" else 1.0) for line in LINES for rig in ("frame", "table", "x")
    ]
    made = explain(measured(rng, LINES, tests), "k")
    assert kinds([made])[0][:2] == ("explained", "instrument")


def test_planted_sample_that_was_damaged_half_way():
    rng = np.random.default_rng(4)
    tests = [("s", rig, rig, 1.0, factor) for rig, factor in zip("ABCDEF", [1, 1, 1, 0.94, 0.94, 0.94], strict=True)]
    made = explain(measured(rng, {"s": 9000.0}, tests, days=(1, 2, 3, 4, 5, 6)), "k")
    assert kinds([made]) == [("explained", "sample changed", "s changed before t3, t4, t5")]


def test_planted_scatter_of_no_single_cause_is_not_explained():
    rng = np.random.default_rng(5)
    made = [explain(five(rng, lambda *_: np.exp(0.05 * rng.standard_normal())), "k") for _ in range(20)]
    assert sum(one.verdict == "explained" for one in made) <= 2
    assert sum(one.verdict == "not explained" for one in made) >= 12


@pytest.mark.parametrize("factor", [0.9, 0.98, 1.05])
def test_limit_two_tests_cannot_decide(factor):
    rng = np.random.default_rng(6)
    tests = [("s", "A", "a", 60.0, 1.0), ("s", "B", "b", 0.01, factor)]
    made = explain(measured(rng, {"s": 9000.0}, tests), "k")
    assert made.verdict == "ambiguous"
    assert "cannot decide" in made.sentence
    assert ("grows with the rate" in made.sentence) is (factor > 1)


def test_limit_one_line_does_not_distinguish_compliance_from_a_wrong_scale():
    rng = np.random.default_rng(7)
    tests = [("s", rig, rig, 1.0, 0.94 if rig == "A" else 1.0) for rig in "AABC"]
    made = explain(measured(rng, {"s": 9000.0}, tests), "k")
    assert made.verdict == "ambiguous"
    assert "compliance of the set-up that t0, t1 share" in made.sentence
    assert "A off in t0, t1" in made.sentence


@pytest.mark.long
def test_twice_the_evidence_against_an_integral_of_scipy():
    """The same by the density of differences from the first result, which is blind to the value of the sample."""
    rows = five(np.random.default_rng(8), lambda i, _: 1.03 if i == 1 else 1.0)
    z = np.log(rows.values)
    differences = np.eye(5)[1:] - np.eye(5)[0]

    def density(shift, tau):
        covariance = differences @ ((U**2 + tau**2) * np.eye(5)) @ differences.T
        return stats.multivariate_normal(np.zeros(4), covariance).pdf(differences @ (z - shift))

    def mean(f, limits):
        ends = np.log(limits)
        cuts = np.linspace(*ends, 60)
        parts = [quad(lambda s: f(np.exp(s)), a, b)[0] for a, b in pairwise(cuts)]
        return sum(parts) / (ends[1] - ends[0])

    scatter = mean(lambda tau: density(0.0, tau), SHARE)
    alone = np.eye(5)[1]
    off = 0.5 * sum(mean(lambda size, sign=sign: density(sign * size * alone, 0.0), OFF) for sign in (-1, 1))
    made = {one.title: one for one in explain(rows, "k").candidates}
    assert made["t1 alone is off"].evidence == pytest.approx(np.log(off / scatter), abs=0.01)
    assert made["chance alone"].evidence == pytest.approx(np.log(density(0.0, 0.0) / scatter), abs=0.01)


def test_law_probabilities_add_up_to_one():
    made = explain(by_rig(np.random.default_rng(9), 1e-6), "k")
    assert sum(one.probability for one in made.candidates) == pytest.approx(1.0, rel=1e-12)


def test_law_kinds_are_as_probable_as_one_another_beforehand():
    """Five tests that could be off are together no more probable than one dependence on the rate."""
    made = explain(five(np.random.default_rng(9), lambda *_: 1.0), "k").candidates
    before = {}
    for one in made:
        before.setdefault(one.kind, []).append(one.probability / np.exp(one.evidence))
    totals = {kind: sum(each) for kind, each in before.items()}
    assert set(totals) == {"chance", "scatter", "rate", "one test"}
    assert list(totals.values()) == pytest.approx([next(iter(totals.values()))] * 4)


def test_planted_damping_of_hysteresis():
    """c ∝ 1/ω where the loss of a cycle does not depend on frequency."""
    rng = np.random.default_rng(10)
    times = (0.005, 0.02, 0.1, 0.4)
    rows = measured(rng, {"s": 5.0}, [("s", "", str(t), t, t) for t in times])
    made = explain(Rows(**{**vars(rows), "damping": True}), "c")
    assert kinds([made])[0][:2] == ("explained", "rate")
    assert made.candidates[0].value == pytest.approx(1.0, abs=0.02)
