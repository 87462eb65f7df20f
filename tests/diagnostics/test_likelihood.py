"""One likelihood: colour of the noise, evidence of sets, what the full list leaves, unlisted laws."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import multivariate_normal

from metrology.diagnostics.block_trials import Trial
from metrology.diagnostics.blocks import Readings
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.families import Family, compressed, families
from metrology.diagnostics.laws import Kind, Law, estimates, of_families, together
from metrology.diagnostics.likelihood import Noise, common, noise, weighted
from metrology.diagnostics.line import Line, line
from metrology.diagnostics.misfit import misfit, narrow
from metrology.diagnostics.plain import Plain
from metrology.diagnostics.search import Search
from metrology.diagnostics.sets import NONE, Scarce, log_likelihood, log_prior, price
from metrology.diagnostics.span import spanned, triangle
from metrology.effect import Size
from metrology.estimation import Unknown
from metrology.estimation.problem import evaluate
from metrology.noise import Colour, colour, power_of

T = np.linspace(0.0, 1.0, 600)
SHAPES = {"a": np.sin(9 * T), "b": T**2, "c": np.cos(23 * T)}
U = 0.1


def subject_of(y: np.ndarray, *, low: float = -math.inf, scarce: bool = False) -> Plain:
    """Readings of a constant, and three candidates that add a column each."""
    half = len(y) // 2
    blocks = tuple(
        Readings(name, "x", part, np.full(len(part), U)) for name, part in (("first", y[:half]), ("second", y[half:]))
    )
    columns = [{name: shape[:half] for name, shape in SHAPES.items()}, {n: s[half : len(y)] for n, s in SHAPES.items()}]
    table = {
        name: Candidate(name, name, "", (Size(f"{name}.size", "m", 0.0, low, math.inf, 1.0),), "", "k", "a", "s")
        for name in SHAPES
    }
    return Plain(
        "s", "elongation", table, blocks, (Unknown("zero", 1.0, 0.1, unit="m"),), ((), ()),
        lambda at, values: values["zero"] + sum(
            values.get(f"{name}.size", 0.0) * shape for name, shape in columns[at].items()
        ) + 0.0 * columns[at]["a"],
        lambda _name, _fit: [Trial(0.01)], is_scarce=scarce,
    )  # fmt: skip


def readings(seed: int, sizes: dict[str, float]) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return 1.0 + sum(size * SHAPES[name] for name, size in sizes.items()) + U * rng.standard_normal(len(T))


def search_of(subject: Plain) -> Search:
    return Search(subject, 20, 1, lambda _text: None)


# ---- noise --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("phi", [0.0, 0.3, 0.6, 0.8])
def test_law_filtered_noise_is_white_and_of_unit_size(phi: float):
    rng = np.random.default_rng(round(10 * phi))
    parts = [lfilter([3.0], [1.0, -phi], rng.standard_normal(3000)) for _ in range(3)]
    found = colour(parts)
    white = np.concatenate([found.whitened(part)[50:] for part in parts])
    assert white.std() == pytest.approx(1.0, abs=0.06)
    lags = [float(np.mean(white[lag:] * white[:-lag])) for lag in (1, 2, 3)]
    assert np.abs(lags).max() < 0.09


def test_limit_the_level_of_noise_is_not_below_what_is_stated():
    rng = np.random.default_rng(1)
    parts = [0.5 * rng.standard_normal(4000)]
    assert colour(parts).level == pytest.approx(0.5, rel=0.06)
    assert colour(parts, floor=0.8).level == pytest.approx(0.8, rel=1e-9)


def test_law_single_outliers_do_not_colour_the_noise():
    rng = np.random.default_rng(2)
    part = rng.standard_normal(4000)
    part[rng.integers(0, 4000, 8)] += 300.0
    assert colour([part]).level == pytest.approx(1.0, rel=0.1)


# ---- evidence -----------------------------------------------------------------------------------------------------
def test_law_probabilities_beforehand_of_all_sets_sum_to_one():
    names = "abcdef"
    total = sum(math.exp(log_prior(size, 6)) for size in range(7) for _ in combinations(names, size))
    assert total == pytest.approx(1.0, abs=1e-12)


def test_closed_form_evidence_of_a_set_by_integration_over_its_sizes():
    """ln N(y; 1·m, I + Σ G·P·Gᵀ) with priors as wide as one reading determines a size: what ½·ln n stands for."""
    subject = subject_of(readings(3, {"a": 0.03, "c": 0.02}))
    search = search_of(subject)
    fit = subject.fit((), [{}])
    view = search.view(fit)
    by = view.noise
    y = by.whitened(fit, fit.residuals, fit.used)
    ones = by.whitened(fit, tuple(np.full(len(one), 1 / U) for one in fit.residuals), fit.used)
    at = (T[:300], T[300:])
    half = {name: (shape[:300] / U, shape[300:] / U) for name, shape in SHAPES.items()}
    assert len(at[0]) == len(fit.residuals[0])

    def exact(names: tuple[str, ...]) -> float:
        covariance = by.misfit * np.eye(len(y)) + 1e2 * np.outer(ones, ones)
        for name in names:
            G = by.whitened(fit, half[name], fit.used)
            G = G - ones * (ones @ G) / (ones @ ones)
            covariance += len(y) * by.misfit / (G @ G) * np.outer(G, G)
        return float(multivariate_normal(np.zeros(len(y)), covariance).logpdf(y))

    for names in (("a",), ("c",), ("a", "c")):
        ours = view.evidence[frozenset(names)] - view.evidence[frozenset()]
        ours -= log_prior(len(names), 3) - log_prior(0, 3)
        assert ours == pytest.approx(exact(names) - exact(()), abs=0.25)


def test_twice_evidence_by_the_straight_line_and_by_the_fit():
    subject = subject_of(readings(4, {"a": 0.05}))
    search = search_of(subject)
    base = subject.fit((), [{}])
    view = search.view(base)
    fit = subject.fit(("a",), [{}])
    ours = view.evidence[frozenset("a")] - view.evidence[frozenset()]
    assert search.over(view, fit) == pytest.approx(ours, abs=1e-3)


def test_law_a_size_of_the_wrong_sign_has_less_evidence_than_none():
    subject = subject_of(readings(5, {"a": -0.2}), low=0.0)
    view = search_of(subject).view(subject.fit((), [{}]))
    assert view.evidence[frozenset("a")] < view.evidence[frozenset()]
    free = subject_of(readings(5, {"a": -0.2}))
    view = search_of(free).view(free.fit((), [{}]))
    assert view.evidence[frozenset("a")] > view.evidence[frozenset()] + 10


def test_closed_form_likelihood_of_few_readings_does_not_depend_on_the_stated_noise():
    first, other = Scarce(20, 12.0), Scarce(20, 1.2)
    assert log_likelihood(16.0, first, 2) - log_likelihood(32.0, first, 2) == pytest.approx(10 * math.log(2.0))
    assert log_likelihood(8.0, first, 2) - log_likelihood(16.0, first, 0) == pytest.approx(
        log_likelihood(0.8, other, 2) - log_likelihood(1.6, other, 0)
    )
    assert log_likelihood(8.0, None, 0) - log_likelihood(16.0, None, 0) == pytest.approx(4.0)


@pytest.mark.parametrize("left", [10.0, 1.0, 1e-3, 1e-9, 0.0])
def test_limit_effects_with_as_many_parameters_as_readings_have_no_more_evidence_than_none(left):
    """They leave nothing, whatever is read: in the noise that they leave their evidence would have no end."""
    known, free, count = Scarce(4, 10.0), 4, 6
    price_ = 0.5 * free * math.log(count)
    assert log_likelihood(left, known, free) - price_ < log_likelihood(10.0, known, 0)


def test_closed_form_prices():
    def sized(*parameters: Size) -> Candidate:
        return Candidate("x", "", "", parameters, "", "", "", "")

    size, n = Size("x.size", "m", 0.0, -math.inf, math.inf, 1.0), 1000
    line_of = Size("x.frequency", "Hz", 1.0, 0.0, 100.0, 1.0, shape=True)
    place = Size("x.after", "1", 0.0, -0.5, 47.5, 0.0, shape=True)
    own = Size("x.sin", "m", 0.0, -math.inf, math.inf, 1.0, own=True)
    assert price(sized(size), n, 2) == pytest.approx(0.5 * math.log(n))
    assert price(sized(size, line_of), n, 2) == pytest.approx(2.0 * math.log(n))
    in_bands = replace(line_of, apart=27)
    assert price(sized(size, in_bands), n, 2) == pytest.approx(math.log(n) + math.log(27))
    assert price(sized(size, place), n, 2) == pytest.approx(0.5 * math.log(n) + math.log(48))
    assert price(sized(own), n, 2) == pytest.approx(math.log(n / 2))


# ---- search -------------------------------------------------------------------------------------------------------
def test_planted_sets_are_found_and_nothing_else():
    for seed, planted in enumerate(({}, {"a": 0.1}, {"b": 0.2}, {"a": 0.1, "b": -0.2}, {"a": 0.1, "b": 0.2, "c": 0.1})):
        subject = subject_of(readings(10 + seed, planted))
        search = search_of(subject)
        base = subject.fit((), [{}])
        assert search.run(base, search.view(base)).effects == set(planted)


def test_limit_a_search_ends_within_its_budget():
    subject = subject_of(readings(20, {"a": 0.3, "b": 0.3, "c": 0.3}))
    search = Search(subject, 1, 1, lambda _text: None)
    base = subject.fit((), [{}])
    search.run(base, search.view(base))
    assert search.spent <= 2


# ---- misfit -------------------------------------------------------------------------------------------------------
def misfit_of(extra: np.ndarray) -> float:
    y = readings(30, {}) + extra
    subject = subject_of(y)
    return search_of(subject).view(subject.fit((), [{}])).noise.misfit


def test_law_misfit_is_none_of_white_noise_and_large_where_something_slow_is_left():
    """Slow structure beside every column acts where the unknowns do; the same power far from them does not."""
    assert misfit_of(np.zeros(len(T))) < 1.5
    slow = misfit_of(0.2 * np.sin(2 * np.pi * 2.6 * T + 1.0))
    fast = misfit_of(0.2 * np.sin(2 * np.pi * 120.3 * T))
    assert slow > 5
    assert fast < 0.3 * slow


# ---- unlisted laws ------------------------------------------------------------------------------------------------
def test_closed_form_span_formed_for_some_rows_at_a_time_is_that_of_all_columns():
    """Longer than what is worked on at a time; one column is nearly the sum of two others, another exactly."""
    rng = np.random.default_rng(5)
    first, more = rng.normal(size=(9001, 5)), rng.normal(size=(9001, 3))
    more[:, 0] = first[:, 0] + first[:, 1] + 1e-3 * more[:, 0]
    more[:, 1] = first[:, 2] - 2 * first[:, 3]
    found, whole = spanned((first, more)), np.hstack([first, more])
    turned = found.rows(slice(None))
    assert found.width == 7
    assert turned.T @ turned == pytest.approx(np.eye(7), abs=1e-10)
    assert found.rows(slice(4000, 9000)) == pytest.approx(turned[4000:9000], abs=0)
    y = rng.normal(size=9001)
    assert found.part(y) == pytest.approx(whole @ np.linalg.lstsq(whole, y, rcond=1e-9)[0], abs=1e-9)


def test_closed_form_rows_of_a_block_are_turned_into_as_few_columns_as_are_not_zero_there():
    """Every block has two columns of its own beside one of all; sums over columns of squares are those of all."""
    rng = np.random.default_rng(6)
    own = np.zeros((600, 6))
    for block in range(3):
        own[200 * block : 200 * (block + 1), 2 * block : 2 * block + 2] = rng.normal(size=(200, 2))
    common = rng.normal(size=(600, 1))
    found, whole = spanned((common, own)), np.hstack([common, own])
    Q = np.linalg.qr(whole)[0]
    rows, part = found.rows(slice(200, 400)), Q[200:400]
    assert rows.shape == (200, 3)
    assert rows @ rows.T == pytest.approx(part @ part.T, abs=1e-12)
    y = rng.normal(size=600)
    left = triangle([whole, y[:, None]])
    assert left[-1, -1] ** 2 == pytest.approx(float(np.sum((y - Q @ (Q.T @ y)) ** 2)), rel=1e-12)


@pytest.mark.parametrize("count", [7, 64, 101])
@pytest.mark.parametrize("width", [1, 4, 5])
def test_twice_power_of_columns_by_pairs_and_one_by_one(count, width):
    columns = np.random.default_rng(count).normal(size=(count, width))
    alone = (np.abs(np.fft.rfft(columns, axis=0)) ** 2).sum(axis=1)
    assert power_of(columns) == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize("shape", [(5000, 40), (300000,), (10, 3)])
def test_twice_readings_whitened_some_rows_at_a_time_and_at_once(shape):
    rng = np.random.default_rng(2)
    rows, taps = rng.normal(size=shape), rng.normal(size=24)
    whole = taps[0] * rows
    for delay, tap in enumerate(taps[1 : len(rows)], start=1):
        whole[delay:] += tap * rows[:-delay]
    assert np.array_equal(Colour(1.0, taps).whitened(rows), whole)


def law(y: np.ndarray):
    subject = subject_of(y)
    fit = subject.fit((), [{}])
    knots = np.linspace(0.0, 1.0, 9)
    hats = np.array([np.interp(T, knots, hat) for hat in np.eye(9)]).T
    values = {f"t@{at}": float(knot) for at, knot in enumerate(knots)}
    direction = Direction("extension of time", values, U, (-hats[:300], -hats[300:]), ways=tuple(values))
    straight = line(fit, subject.candidates, (), noise(fit, fit.residuals), fit.used)
    found, _ = of_families(straight, families(straight, [direction], fit.used), frozenset())
    assert found
    return together(found)


def test_planted_smooth_law_is_found_with_its_form_and_nothing_in_noise():
    assert law(readings(40, {})).log_bayes < 0
    hump = 0.15 * np.exp(-0.5 * ((T - 0.4) / 0.12) ** 2)
    found = law(readings(41, {}) + hump)
    assert found.log_bayes > 10
    there = np.interp(found.at, T, hump)
    off = found.amounts - there
    assert np.abs(off - off.mean()).max() < 4 * found.u.max()


def test_law_cost_of_a_fit_is_least_in_the_metric_of_the_noise():
    """One step on the straight line: no other values of the unknowns cost less, whatever the colour."""
    rng = np.random.default_rng(50)
    y = 1.0 + U * lfilter([1.0], [1.0, -0.7], rng.standard_normal(len(T)))
    subject = subject_of(y)
    fit = subject.fit((), [{}])
    by = noise(fit, fit.residuals)
    least = weighted(fit, by, common([fit]))
    ones = by.whitened(fit, tuple(np.full(len(one), 1 / U) for one in fit.residuals), fit.used)
    r = by.whitened(fit, fit.residuals, fit.used)
    direct = min(float(np.sum((r - step * ones) ** 2)) for step in np.linspace(-0.05, 0.05, 2001))
    assert least == pytest.approx(direct, rel=1e-4)
    assert weighted(fit, Noise(by.channels, 4.0), common([fit])) == pytest.approx(least / 4)


def test_limit_a_search_that_has_not_ended_is_not_paid_for_the_steps_that_it_lacks():
    """Its evidence is that of where it is, not of the optimum that a straight line promises."""
    subject = subject_of(readings(51, {"a": 0.05}))
    fit = subject.fit(("a",), [{}])
    theta = fit.theta + np.array([0.0, 0.2])
    there = evaluate(fit.problem, theta)
    off = replace(fit, theta=theta, residuals=there.residuals, full=there.residuals, penalty=there.penalty)
    white = Noise({})
    assert fit.unfinished == pytest.approx(0.0, abs=1e-9 * fit.cost)
    assert weighted(fit, white, fit.used) == pytest.approx(fit.cost)
    assert weighted(off, white, fit.used) == pytest.approx(there.cost)
    assert there.cost > fit.cost + 100


def test_limit_misfit_needs_no_candidates():
    subject = subject_of(readings(60, {}))
    fit = subject.fit((), [{}])
    alone = line(fit, subject.candidates, (), noise(fit, fit.residuals), fit.used)
    assert 1.0 <= misfit(alone, alone.base) < 1.6


def test_law_noise_about_the_frequency_of_a_line_is_measured_beside_it():
    """White noise leaves a line as it is; a band of noise about it makes it weigh less in that record, by its power."""
    t = np.arange(2000.0)
    rng = np.random.default_rng(70215)
    pole = 0.97
    band = lfilter([1.0], [1.0, -2 * pole * np.cos(1.5), pole**2], rng.standard_normal(len(t) + 400))[400:]
    factors: list[list[float]] = []
    once = band * (t < len(T) // 2)
    for more in (0.0 * band, band, once):
        noisy = rng.standard_normal(len(t)) + more / band.std()
        subject = subject_of(1.0 + U * noisy[: len(T)])
        fit = subject.fit((), [{}])
        wave = np.column_stack([np.sin(1.5 * t[: len(T)]), np.cos(1.5 * t[: len(T)])]) / U * 0.01
        half, none = len(T) // 2, np.zeros((len(T) // 2, 2))
        common_phase = (wave[:half], wave[half:])
        own_phases = (np.hstack([wave[:half], none]), np.hstack([none, wave[half:]]))
        for rows in (common_phase, own_phases):
            tried = Direction("a", {}, 0.01, rows, ways=tuple("abcd"[: rows[0].shape[1]]))
            whole = line(fit, subject.candidates, [tried], noise(fit, fit.residuals), fit.used)
            raised = narrow(whole, [one.rows for one in whole.columns], 1.0)
            found = {record.start: factor for record, _, factor in raised}
            factors.append([found.get(start, 1.0) for start in (0, half)])
    white, both, first = factors[:2], factors[2:4], factors[4:]
    assert np.max(white) < 2 < 3 < np.min(both)
    assert all(one > 3 and other < 2 for one, other in first)
    # A phase of its own in every record takes no more from each than a common one: the noise is seen as near.
    assert both[1] == pytest.approx(both[0], rel=0.3)


def test_limit_a_law_that_the_rest_of_the_model_contains_has_no_size():
    """A line through three loads of which one is free: every law of load is in it, and none may move the slope."""
    load = np.repeat([1.0, 2.0, 3.0], 5)
    base = np.column_stack([load, np.ones(15), load == 2.0]).astype(float)
    at = {"extension of load 0@0": 1.0, "extension of load 0@1": 2.0, "extension of load 0@2": 3.0}
    hats = np.column_stack([load == place for place in at.values()]).astype(float)
    family = Family(Direction("extension of load", at, 1.0, (hats,)), hats, (np.eye(3),))
    line_ = SimpleNamespace(columns=(), base=base, residual=np.random.default_rng(1).standard_normal(15), count=15)
    ((law,), _) = of_families(line_, [family], frozenset())
    assert law.log_bayes == -np.inf
    assert law.size == 0.0
    open_ = SimpleNamespace(columns=(), base=base[:, :2], residual=line_.residual, count=15)
    ((law,), _) = of_families(open_, [family], frozenset())
    assert np.isfinite(law.log_bayes)


def test_limit_a_law_of_which_nothing_is_seen_hardly_makes_a_model_incomplete():
    """Of any size from what can just be seen on, it would have been seen: ten to one against it."""
    x = np.array([-1.0, 0.0, 1.0, 2.0])
    family = Family(Direction("force of position", {"x@0": 1.0}, 1.0, (x[:, None],)), x[:, None], (np.eye(1),))
    line_ = SimpleNamespace(columns=(), base=np.ones((4, 0)), residual=np.array([1.0, 1.0, 1.0, 0.0]), count=4)
    ((law,), _) = of_families(line_, [family], NONE)
    assert law.gone == 0.0
    assert np.exp(law.log_bayes) < 0.1


def test_closed_form_unknowns_beside_a_law_are_means_over_its_lengths():
    """Of two, one lets hardly any of a law be there and one any: k is as without it, or as with it free."""
    x = np.array([-1.0, 0.0, 1.0, 2.0])
    residual = -(3.0 * x + 0.5 * x**2 + np.array([0.1, -0.1, 0.05, 0.0]))
    line_ = SimpleNamespace(columns=(), base=x[:, None], residual=residual)
    kinds = tuple(Kind(0.5, np.array([[size]])) for size in (1e-9, 1e9))
    law = Law("force of position", 0.0, x, x, x, (x**2)[:, None], kinds)
    (mean,), (u,) = estimates(line_, frozenset(), law)
    without = x @ -residual / (x @ x)
    both = np.column_stack([x, x**2])
    free, C = np.linalg.lstsq(both, -residual, rcond=None)[0][0], np.linalg.inv(both.T @ both)
    assert mean == pytest.approx((without + free) / 2, rel=1e-6)
    spread = ((without - free) / 2) ** 2
    assert u**2 == pytest.approx((1 / (x @ x) + C[0, 0]) / 2 + spread, rel=1e-6)
    assert spread > 0.1 * u**2


def test_limit_turned_rows_say_the_same_of_every_law():
    rng = np.random.default_rng(5)
    base, hats, residual = rng.standard_normal((40, 3)), rng.standard_normal((40, 4)), rng.standard_normal(40)
    places = {f"force of time@{at}": float(at) for at in range(4)}
    family = Family(Direction("force of time", places, 1.0, (hats,)), hats, (np.eye(4),))
    whole = Line(None, Noise({}), base, residual, (), 40)
    turned, found = compressed(whole, [family])
    assert len(turned.residual) == 3 + 4 + 1
    ((one,), squares), ((other,), same) = of_families(whole, [family], NONE), of_families(turned, found, NONE)
    assert (other.log_bayes, same) == (pytest.approx(one.log_bayes), pytest.approx(squares))
    np.testing.assert_allclose(estimates(turned, NONE, other), estimates(whole, NONE, one), rtol=1e-9)
