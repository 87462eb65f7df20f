"""The law judged by Monte Carlo: stability, certainty and verdict by their formulas, every sentence whole."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isnan, nan, sqrt

import numpy as np
import pytest

from metrology.gum.evaluation import Coverage, MonteCarlo
from metrology.gum.intervals import Intervals, intervals
from metrology.gum.monte_carlo import Plan, Trials
from metrology.gum.sufficiency import Claim, _delta, certainty, choice, chosen, shortfall, stability
from metrology.gum.verdict import _holds, _sentences, judge

CLAIM = Claim(10.0, 2.0, Coverage(0.95, 1.96, 6.08, 13.92), "", "", "m", inf)
FOUND = MonteCarlo(
    10.0, 2.0, 6.1, 13.9, 6.1, 13.9, 0.95, 40_000, True, True, "", 0.05, 0.02, 0.03, (0.0,), ()
)  # fmt: skip


def batches(mean: float = 10.0, deviation: float = 2.0, low: float = 6.08, high: float = 13.92, *, s: float = 0.0,
            wide: int = 3) -> np.ndarray:  # fmt: skip
    """Nine blocks with these averages; those of column `wide` have the standard deviation 3·s/2, so that 2s is `s`."""
    found = np.tile([mean, deviation, low, high], (9, 1))
    turn = np.array([1.0, -1, 1, -1, 0, 1, -1, 1, -1])  # Σ turn² = 8: standard deviation 1
    found[:, wide] += 1.5 * s * turn
    return found


# ---------------------------------------------------------------- trials enough


@pytest.mark.parametrize("column", range(4))
def test_closed_form_stability_is_the_square_of_2s_over_delta(column: int) -> None:
    """u = 2.0 to two digits: δ = 0.05; to one digit: 0.5 (JCGM 101, 7.9.2 and 7.9.4)."""
    found = batches(s=0.1, wide=column)
    assert stability(CLAIM, found, 2) == pytest.approx(4.0, rel=1e-9)
    assert stability(CLAIM, found, 1) == pytest.approx(0.04, rel=1e-9)
    # Moments that do not exist do not count.
    heavy = stability(replace(CLAIM, heavy=2.0), found, 2)
    assert heavy == pytest.approx(0.0 if column < 2 else 4.0, abs=1e-12)


def test_closed_form_delta_is_that_of_the_deviation_or_of_the_law_where_there_is_none() -> None:
    assert _delta(CLAIM, 30.0, 2) == 0.5
    assert _delta(replace(CLAIM, heavy=1.5), 30.0, 2) == 0.05
    assert isnan(_delta(replace(CLAIM, heavy=1.5, u=0.0), 30.0, 2))
    assert isnan(_delta(replace(CLAIM, value=1e16), 10.0, 2))  # nothing but rounding
    assert _delta(replace(CLAIM, value=1e16), 10.1, 2) == 0.5
    assert stability(replace(CLAIM, value=1e16), batches(deviation=0.0, s=1.0), 2) == 0.0


def test_closed_form_certainty_weighs_the_gap_between_difference_and_tolerance() -> None:
    """d = 0.02 and δ = 0.05 leave a gap of 0.03: sure at three standard deviations of the average, 1.5·(2s)."""
    apart = batches(low=6.10, s=0.04, wide=2)
    assert certainty(CLAIM, apart, 2) == pytest.approx((1.5 * 0.04 / 0.03) ** 2, rel=1e-6)
    beyond = batches(high=13.92 - 0.08, s=0.04, wide=3)
    assert certainty(CLAIM, beyond, 2) == pytest.approx((1.5 * 0.04 / 0.03) ** 2, rel=1e-6)
    # End points to δ/5 are always enough (8.2).
    close = batches(low=6.08 + 0.0499, s=0.04, wide=2)
    assert certainty(CLAIM, close, 2) == pytest.approx((5 * 0.04 / 0.05) ** 2, rel=1e-6)
    on = batches(low=6.08 + 0.05, s=0.04, wide=2)
    assert certainty(CLAIM, on, 2) == pytest.approx((5 * 0.04 / 0.05) ** 2, rel=1e-6)


def test_limit_certainty_of_a_difference_of_just_delta_asks_for_the_end_points() -> None:
    claim = replace(CLAIM, coverage=Coverage(0.95, 1.96, 0.0, 13.92))
    found = batches(low=0.05, s=0.0, wide=2)
    found[:, 2] += 0.0625 * np.array([1.0, -1, 1, -1, 0, 1, -1, 1, -1])
    found[:, 2] += 0.05 - found[:, 2].mean()
    twice = 2 * found[:, 2].std(ddof=1) / 3
    assert certainty(claim, found, 2) == pytest.approx((5 * twice / 0.05) ** 2, rel=1e-9)


def test_limit_certainty_of_one_end_surely_beyond_settles_it() -> None:
    found = batches(low=6.08 + 0.2, s=0.09, wide=2)
    found[:, 3] += 9 * (found[:, 2] - 6.28)  # the other end tells nothing
    assert certainty(CLAIM, found, 2) == 0.0
    unsure = batches(low=6.08 + 0.2, s=0.11, wide=2)
    assert certainty(CLAIM, unsure, 2) == pytest.approx((1.5 * 0.11 / 0.15) ** 2, rel=1e-6)


def test_limit_certainty_without_a_claim_or_without_numbers_asks_for_no_trials() -> None:
    found = batches(low=6.10, s=0.4, wide=2)
    assert certainty(replace(CLAIM, coverage=Coverage(0.95, None, None, None)), found, 2) == 0.0
    assert certainty(replace(CLAIM, u=0.0), found, 2) == 0.0
    assert certainty(replace(CLAIM, u=nan), found, 2) == 0.0
    assert certainty(CLAIM, np.full((9, 4), nan), 2) == 0.0


def test_closed_form_shortfall_is_the_largest_of_all_outputs() -> None:
    steady, shaky = batches(), batches(s=0.1, wide=0)
    assert shortfall((CLAIM, CLAIM), np.stack([steady, shaky], axis=1), 2) == pytest.approx(4.0, rel=1e-9)
    far = batches(low=6.10, s=0.04, wide=2)
    assert shortfall((CLAIM, CLAIM), np.stack([far, steady], axis=1), 2) == pytest.approx(4.0, rel=1e-6)


@pytest.mark.parametrize(("d_low", "d_high", "s", "holds"), [
    (0.05, 0.05, 0.0, True),
    (0.051, 0.0, 0.0, False),
    (0.0, 0.051, 0.0, False),
    (0.05 + 0.149, 0.0, 0.1, True),  # not surely beyond: three standard deviations are 0.15
    (0.05 + 0.151, 0.0, 0.1, False),
    (0.0, 0.05 + 0.149, 0.1, True),
    (0.0, 0.05 + 0.151, 0.1, False),
    (0.49, 0.0, 9.0, True),
    (0.51, 0.0, 9.0, False),  # beyond one digit of u, however shaky
])  # fmt: skip
def test_limit_the_law_holds_within_delta_or_where_trials_cannot_tell(
    d_low: float, d_high: float, s: float, holds: bool
) -> None:
    found = batches(s=s, wide=2 if d_low > d_high else 3)
    assert _holds(d_low, d_high, found, 0.05, 2.0) is holds
    assert _holds(d_low, d_high, found, 0.05, nan) is (max(d_low, d_high) <= 0.05)


def test_closed_form_result_of_trials_that_are_stated() -> None:
    """A thousand evenly spaced values in ten blocks: moments and intervals by their definitions."""
    values = np.random.default_rng(1).permutation(np.linspace(0.0, 20.0, 1000))
    blocks = values.reshape(10, 100)
    stated = np.column_stack([
        blocks.mean(axis=1), blocks.std(axis=1, ddof=1), *np.sort(blocks, axis=1)[:, [2, 97]].T
    ])[:, None]  # fmt: skip
    trials = Trials(values[None].copy(), stated, [0])
    plan = Plan(0.95, 1, max_trials=1000)
    found = judge(CLAIM, trials, 0, plan)
    assert (found.mean, found.u) == pytest.approx((values.mean(), values.std(ddof=1)), rel=1e-12)
    ordered = np.linspace(0.0, 20.0, 1000)
    assert (found.low, found.high) == (ordered[24], ordered[974])
    assert found.shortest_high - found.shortest_low == pytest.approx(found.high - found.low, rel=1e-9)
    assert (found.d_low, found.d_high) == (abs(6.08 - found.low), abs(13.92 - found.high))
    assert (found.trials, found.p, found.tolerance) == (1000, 0.95, 0.05)
    assert found.law_valid is found.converged is False
    assert found.verdict.endswith("After 1000 trials the Monte Carlo figures are not stable to the digits asked for.")
    for heavy, mean in ((2.0, found.mean), (1.0, nan)):
        again = judge(replace(CLAIM, heavy=heavy), Trials(values[None].copy(), stated, [0]), 0, plan)
        np.testing.assert_equal((again.mean, again.u), (mean, inf))
    coarse = judge(CLAIM, Trials(values[None].copy(), stated, [0]), 0, Plan(0.95, 1, digits=1, max_trials=1000))
    assert coarse.tolerance == 0.5
    blind = judge(replace(CLAIM, u=0.0), Trials(values[None].copy(), stated, [0]), 0, plan)
    assert blind.tolerance == 0.05  # of u = 5.8 by the draws


@pytest.mark.parametrize(("s", "steady"), [(0.049, True), (0.051, False)])
def test_limit_figures_are_stable_when_twice_their_scatter_is_within_delta(s: float, steady: bool) -> None:
    values = np.linspace(0.0, 20.0, 900)
    found = judge(
        CLAIM, Trials(values[None].copy(), batches(s=s, wide=0)[:, None], [0]), 0, Plan(0.95, 1, max_trials=900)
    )
    assert found.converged is steady


# ---------------------------------------------------------------- sentences

GUF = "The GUM uncertainty framework "
OPEN = " The scatter of 40000 trials makes this verdict inconclusive; more trials may decide it."
SENTENCES = {
    "confirmed": (CLAIM, FOUND, True,
        GUF + "is confirmed: its interval differs from the Monte Carlo one by 20 mm below and 30 mm"
        " above, within the tolerance δ = 50 mm (JCGM 101, clause 8)."),
    "open": (CLAIM, FOUND, False,
        GUF + "is confirmed: its interval differs from the Monte Carlo one by 20 mm below and 30 mm"
        " above, within the tolerance δ = 50 mm (JCGM 101, clause 8)." + OPEN),
    "not contradicted": (CLAIM, replace(FOUND, d_low=0.06), True,
        GUF + "is not contradicted: its interval differs from the Monte Carlo one by 60 mm below and"
        " 30 mm above, which 40000 trials cannot tell from the tolerance δ = 50 mm (JCGM 101, clause 8)."),
    "not confirmed": (CLAIM, replace(FOUND, d_high=0.11, law_valid=False), True,
        GUF + "is not confirmed: its interval differs from the Monte Carlo one by 20 mm below and"
        " 110 mm above, up to 2.2 times the tolerance δ = 50 mm (JCGM 101, clause 8). The Monte Carlo interval holds."),
    "not stable": (CLAIM, replace(FOUND, converged=False), True,
        GUF + "is confirmed: its interval differs from the Monte Carlo one by 20 mm below and 30 mm"
        " above, within the tolerance δ = 50 mm (JCGM 101, clause 8). After 40000 trials the Monte Carlo figures are"
        " not stable to the digits asked for."),
    "failure": (replace(CLAIM, failure="No derivative.", u=nan), FOUND, False,
        GUF + "fails: No derivative. The Monte Carlo result stands alone."),
    "certain": (replace(CLAIM, u=0.0), replace(FOUND, u=0.0), True,
        "The uncertainty is zero by the GUM uncertainty framework and by Monte Carlo."),
    "blind": (replace(CLAIM, u=2e-9), FOUND, True,
        GUF + "is not valid here: every sensitivity is zero at the estimates, so its first order gives"
        " u = 0, while the draws scatter. The Monte Carlo result holds."),
    "one digit": (CLAIM, replace(FOUND, tolerance=5.0), True,
        GUF + "is confirmed: its interval differs from the Monte Carlo one by 20 mm below and 30 mm"
        " above, within the tolerance δ = 5 m (JCGM 101, clause 8)."),
    "no interval": (replace(CLAIM, note="undefined: correlated"), replace(FOUND, d_low=None, d_high=None), False,
        GUF + "gives no interval to compare; degrees of freedom are undefined: correlated."),
    "heavy": (replace(CLAIM, heavy=1.5, failure="No.", u=nan), FOUND, True,
        GUF + "fails: No. The Monte Carlo result stands alone. Readings with ν = 1.5 enter, for which"
        " the standard deviation of the draws does not exist (JCGM 101, 6.4.9.4); the intervals do."),
}  # fmt: skip


@pytest.mark.parametrize("name", SENTENCES)
def test_law_verdict_is_a_sentence(name: str) -> None:
    claim, found, sure, sentence = SENTENCES[name]
    assert _sentences(claim, found, sure) == sentence


@pytest.mark.parametrize("failure", ["", "The law has no value."])
def test_refusal_of_draws_without_a_number_is_told(failure: str) -> None:
    trials = Trials(np.full((1, 500), nan), np.full((5, 1, 4), nan), [17])
    found = judge(replace(CLAIM, failure=failure), trials, 0, Plan(0.9, 1))
    assert found.verdict == (failure + " " if failure else "") + (
        "17 of 500 trials gave no finite number: the equation has no value over the whole range of its inputs. A"
        " distribution that leaves out impossible values, or a smaller uncertainty of the input in a denominator, root"
        " or logarithm, may fix it. There is no Monte Carlo result, and the law is not confirmed."
    )
    numbers = (found.mean, found.u, found.low, found.high, found.shortest_low, found.shortest_high, found.tolerance)
    assert all(map(isnan, numbers))
    assert (found.p, found.trials, found.converged, found.law_valid) == (0.9, 500, False, False)
    assert (found.d_low, found.d_high, found.density) == (None, None, ())
    assert isnan(found.edges[0])


def test_law_the_reference_is_an_u_that_can_serve() -> None:
    assert CLAIM.reference == 2.0
    assert all(isnan(replace(CLAIM, u=u).reference) for u in (0.0, nan, inf, -sqrt(2)))


# ---------------------------------------------------------------- which interval of the draws is reported


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(("draw", "kind"), [
    (lambda rng: rng.uniform(-4.0, 4.0, 100_000), "symmetric"),
    (lambda rng: np.sin(np.pi * (rng.random(100_000) - 0.5)), "symmetric"),
    (lambda rng: rng.standard_normal(100_000), "symmetric"),
    (lambda rng: rng.standard_t(3, 100_000), "symmetric"),
    (lambda rng: rng.uniform(-4.0, 4.0, 1_000), "symmetric"),
    (lambda rng: rng.exponential(size=100_000), "shortest"),
    (lambda rng: np.exp(0.3 * rng.standard_normal(100_000)), "shortest"),
    (lambda rng: np.sqrt(rng.random(100_000)), "shortest"),
])  # fmt: skip
def test_law_the_kind_of_interval_does_not_depend_on_the_seed(draw, kind: str, seed: int) -> None:
    assert intervals(draw(np.random.default_rng(seed)), 0.95).kind == kind


def test_closed_form_gain_of_the_shortest_interval_of_an_exponential_distribution() -> None:
    """ln 20 against ln(0.975/0.025): 18.2 % shorter."""
    values = -np.log1p(-(np.arange(200_000) + 0.5) / 200_000)
    found = intervals(values, 0.95)
    assert found.gain == pytest.approx(1 - np.log(20) / np.log(39), abs=2e-4)
    assert found.reported == (found.shortest_low, found.shortest_high)


@pytest.mark.parametrize(("gain", "steady"), [(0.0, True), (0.0099, False), (0.0101, False), (0.1, True)])
def test_limit_a_choice_between_the_intervals_within_their_scatter_is_not_stable(gain: float, steady: bool) -> None:
    """Blocks whose shortest intervals are shorter by `gain` with 2s = 1e-3: sure from 1e-3 off the least gain on."""
    width, number = 8.0, 16
    signs = np.where(np.arange(number) % 2, 1.0, -1.0)
    block_gain = gain + signs * 5e-4 * np.sqrt(number - 1)
    low, high = np.zeros(number), np.full(number, width)
    stated = np.column_stack([
        np.full(number, 4.0), np.full(number, 2.0), low, high, low, low + width * (1 - block_gain)
    ])  # fmt: skip
    found = Intervals(0.0, width, 0.0, width * (1 - gain))
    factor = choice(replace(CLAIM, u=2.0), stated, found, 1)
    assert (factor <= 1) is steady


def test_law_trials_go_on_until_the_ends_of_the_shortest_interval_are_stable() -> None:
    """Exponential draws: where clause 8 does not confirm the law, twice the scatter of those ends is within δ."""
    rng = np.random.default_rng(4)
    blocks = rng.exponential(size=(20, 1000))
    rows = [intervals(block.copy(), 0.95) for block in blocks]
    stated = np.column_stack([
        blocks.mean(axis=1), blocks.std(axis=1, ddof=1),
        [one.low for one in rows], [one.high for one in rows],
        [one.shortest_low for one in rows], [one.shortest_high for one in rows],
    ])[:, None]  # fmt: skip
    trials = Trials(blocks.reshape(1, -1).copy(), stated, [0])
    claim = replace(CLAIM, value=1.0, u=1.0, coverage=Coverage(0.95, 1.96, -0.96, 2.96))
    plan = Plan(0.95, 1, max_trials=20_000)
    doubled = 2 * stated[:, 0, 4:].std(axis=0, ddof=1) / np.sqrt(20)
    delta = _delta(claim, float(stated[:, 0, 1].mean()), 2)
    assert chosen((claim,), trials, plan) == pytest.approx((doubled.max() / delta) ** 2, rel=1e-9)
    confirmed = replace(claim, coverage=Coverage(0.95, 1.96, *stated[:, 0, 2:4].mean(axis=0).tolist()))
    assert chosen((confirmed,), trials, plan) == 0.0
