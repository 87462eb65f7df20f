"""Distributions that are not symmetric, or cut off: by closed forms and SciPy, and their use."""

from __future__ import annotations

from math import exp, sqrt
from pathlib import Path

import numpy as np
import pytest
from gum_models import knowledge, model, quantity
from scipy import integrate, stats

from metrology import chain, gum
from metrology.campaign.load import load
from metrology.errors import MetrologyError
from metrology.gum.copula import latent
from metrology.gum.skewed import Asymmetric, Beta, Exponential, Gamma, Lognormal, TruncatedNormal

S = 0.4
CASES = [
    (Exponential(2.0), stats.expon(-2.0, 2.0), 2.0),
    (Gamma(3.0, 4.0), stats.gamma(4.0, -6.0, 1.5), 3.0),
    (Lognormal(1.0, S), stats.lognorm(S, -1 / sqrt(exp(S**2) - 1), 1 / sqrt((exp(S**2) - 1) * exp(S**2))), 1.0),
    (TruncatedNormal(2.0, 1.5), stats.truncnorm(-1.5, 1.5, 0.0, 2.0), 2.0 * sqrt(1 - 3 * 0.12951760 / 0.86638560)),
    (Beta(1.5, 2.0, 5.0), stats.beta(2.0, 5.0, -6 / 7, 3.0), 3 * sqrt(10 / 8) / 7),
    (Beta(2.0, 1.0, 1.0), stats.uniform(-2.0, 4.0), 2 / sqrt(3)),
    (Asymmetric(2.0, 1.0), stats.uniform(-2.0, 4.0), 2 / sqrt(3)),
]
IDS = [f"{case[0].name} {index}" for index, case in enumerate(CASES)]


@pytest.mark.parametrize(("ours", "independent", "u"), CASES, ids=IDS)
def test_twice_moments_quantiles_and_draws(ours, independent, u) -> None:
    assert ours.u == pytest.approx(u, rel=1e-7)
    assert independent.mean() == pytest.approx(0.0, abs=1e-12)
    p = np.array([1e-9, 0.001, 0.2, 0.4999, 0.5, 0.5001, 0.8, 0.999])
    np.testing.assert_allclose(ours.quantile(p), independent.ppf(p), rtol=1e-8, atol=1e-9)
    draws = ours.draw(np.random.default_rng(5), 40_000)
    assert stats.kstest(draws, independent.cdf).pvalue > 1e-3


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.999, 1.001, 3.0, 40.0])
def test_closed_form_limits_of_a_value_that_is_not_in_their_middle(ratio: float) -> None:
    # JCGM 100:2008 4.3.8: u² = b₊·b₋ − (b₊ − b₋)/λ for the density A·exp(−λ·x); its mean is the value.
    ours = Asymmetric(1.0, ratio)
    above, below = 2 * ratio / (1 + ratio), 2 / (1 + ratio)
    assert float(ours.quantile(0.0)) == pytest.approx(-below, rel=1e-9)
    assert float(ours.quantile(1.0)) == pytest.approx(above, rel=1e-9)
    assert integrate.quad(ours.quantile, 0, 1, epsabs=1e-11)[0] == pytest.approx(0.0, abs=1e-8)
    spread = integrate.quad(lambda p: float(ours.quantile(p)) ** 2, 0, 1, epsabs=1e-11)[0]
    assert ours.u**2 == pytest.approx(spread, rel=1e-6)
    if abs(ratio - 1) > 0.01:
        lam = (above - below) / (above * below - ours.u**2)
        ends = [1 / (float(ours.quantile(p + 1e-7)) - float(ours.quantile(p - 1e-7))) for p in (0.01, 0.99)]
        distance = float(ours.quantile(0.99) - ours.quantile(0.01))
        assert np.log(ends[0] / ends[1]) / distance == pytest.approx(lam, rel=1e-3)


def test_closed_form_the_sum_of_two_exponentials_is_gamma() -> None:
    inputs = knowledge(quantity("a", 1.0, Exponential(1.0)), quantity("b", 1.0, Exponential(1.0)))
    found = gum.evaluate([model("a + b", "s")], inputs, seed=3).estimates["s"]
    exact = stats.gamma(2.0)
    assert found.u == pytest.approx(sqrt(2))
    assert found.monte_carlo.low == pytest.approx(exact.ppf(0.025), abs=0.02)
    assert found.monte_carlo.high == pytest.approx(exact.ppf(0.975), abs=0.06)
    assert not found.monte_carlo.law_valid


@pytest.mark.parametrize("r", [0.6, -0.5])
def test_twice_correlated_exponentials_have_the_stated_coefficient(r: float) -> None:
    inputs = knowledge(
        quantity("a", 1.0, Exponential(1.0)), quantity("b", 5.0, Exponential(2.0)), correlations={("a", "b"): r}
    )
    found = gum.evaluate([model("a + b", "s")], inputs, seed=3, digits=2).estimates["s"]
    assert found.monte_carlo.u == pytest.approx(sqrt(1 + 4 + 4 * r), rel=0.02)


def test_refusal_of_a_negative_coefficient_that_exponentials_cannot_have() -> None:
    # Fréchet's lower bound of two exponentials is 1 − π²/6 = −0.645.
    assert latent(Exponential(1.0), Exponential(1.0), -0.63) is not None
    assert latent(Exponential(1.0), Exponential(1.0), -0.66) is None


@pytest.mark.parametrize(
    "make",
    [
        lambda: Gamma(1.0, 0.0),
        lambda: Lognormal(1.0, -0.1),
        lambda: TruncatedNormal(1.0, float("inf")),
        lambda: Beta(1.0, 0.0, 2.0),
        lambda: Asymmetric(1.0, 60.0),
        lambda: Exponential(-1.0),
    ],
)
def test_refusal_of_impossible_parameters(make) -> None:
    with pytest.raises(MetrologyError):
        make()


def stated(folder: Path, component: str):
    (folder / "campaign.yaml").write_text(
        f"""\
format: metrology-campaign/1
id: stated
title: A quantity
quantities:
  x: {{value: 10 mm, uncertainty: [{{{component}}}]}}
derived: [{{quantity: y, expression: 2*x, unit: mm}}]
""",
        encoding="utf-8",
    )
    (found,) = (one for one in chain.evaluate(load(folder / "campaign.yaml")).results if one.quantity == "y")
    return found


@pytest.mark.parametrize(
    ("component", "independent"),
    [
        ("standard: 1 mm, distribution: exponential", stats.expon(9.0, 1.0)),
        ("standard: 1 mm, distribution: gamma, parameters: [4]", stats.gamma(4.0, 8.0, 0.5)),
        ("standard: 1 mm, distribution: rectangular", stats.uniform(10 - sqrt(3), 2 * sqrt(3))),
        ("standard: 1 mm, distribution: triangular", stats.triang(0.5, 10 - sqrt(6), 2 * sqrt(6))),
        ("standard: 1 mm, distribution: arcsine", stats.arcsine(10 - sqrt(2), 2 * sqrt(2))),
        ("half_width: 2 mm, distribution: beta, parameters: [2, 5]", stats.beta(2, 5, 10 - 8 / 7, 4)),
        ("standard: 1 mm, distribution: truncated-normal, parameters: [1.5]", stats.truncnorm(-1.5, 1.5, 10, 1)),
        (
            "standard: 1 mm, distribution: lognormal, parameters: [0.4]",
            stats.lognorm(S, 10 - 1 / sqrt(exp(S**2) - 1), 1 / sqrt((exp(S**2) - 1) * exp(S**2))),
        ),
        ("half_width: 2 mm, distribution: asymmetric, parameters: [1]", stats.uniform(8, 4)),
    ],
)
def test_twice_a_quantity_of_a_campaign(tmp_path: Path, component: str, independent) -> None:
    found = stated(tmp_path, component)
    assert found.framework.u == pytest.approx(2e-3 * independent.std(), rel=1e-6)
    for end, p in ((found.monte_carlo.low, 0.025), (found.monte_carlo.high, 0.975)):
        assert end == pytest.approx(2e-3 * independent.ppf(p), abs=2e-3 * 0.03 * independent.std())


@pytest.mark.parametrize(
    ("component", "message"),
    [
        ("standard: 1 mm, distribution: gamma", "0 parameters"),
        ("half_width: 1 mm, distribution: beta, parameters: [2]", "1 parameters"),
        ("half_width: 1 mm, distribution: rectangular, parameters: [2]", "none with this"),
        ("half_width: 1 mm, distribution: asymmetric, parameters: [80]", "0.02 to 50"),
        ("half_width: 1 mm, distribution: exponential", "exponential"),
        ("expanded: 1 mm, k: 2, distribution: exponential", "'standard' with it"),
        ("standard: 1 mm, distribution: trapezoidal", "without 'beta'"),
        ("standard: 1 mm, distribution: curvilinear-trapezoid", "curvilinear"),
        ("standard: 1 mm, distribution: lognormal, parameters: [-1]", "greater than zero"),
    ],
)
def test_refusal_of_components_that_contradict_themselves(tmp_path: Path, component: str, message: str) -> None:
    with pytest.raises(MetrologyError, match=message):
        stated(tmp_path, component)
