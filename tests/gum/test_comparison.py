"""E_n: closed forms, correlation, exact values, refusals."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from uncertainties import correlated_values

from metrology.errors import MetrologyError
from metrology.gum.comparison import en


def test_closed_form_en_is_the_difference_over_the_expanded_uncertainty_of_both() -> None:
    found = en(10.5, 0.3, 10.0, 0.4)
    assert (found.difference, found.u_difference, found.en) == (0.5, 0.5, 0.5)
    assert found.agrees
    assert found.sentence == "The two agree within their expanded uncertainties: E_n = 0.50 (k = 2)."


def test_closed_form_each_result_can_have_its_own_coverage_factor() -> None:
    found = en(0.0, 1.0, 10.0, 2.0, k=(3.0, 2.0))
    assert found.en == pytest.approx(-2.0)
    assert found.agrees is False
    assert "differ by more than their expanded uncertainties: E_n = -2.00 (k = 3 and 2)" in found.sentence


@pytest.mark.parametrize(("b", "agrees"), [(11.0, True), (math.nextafter(11.0, 12.0), False)])
def test_limit_the_verdict_turns_just_above_one(b: float, agrees: bool) -> None:
    assert en(10.0, 0.5, b, 0.0).agrees is agrees


@settings(deadline=None)
@given(st.floats(0.01, 100), st.floats(0.01, 100), st.floats(-0.999, 0.999))
def test_twice_correlation_enters_as_the_law_of_propagation_has_it(u_a: float, u_b: float, r: float) -> None:
    covariance = [[u_a**2, r * u_a * u_b], [r * u_a * u_b, u_b**2]]
    a, b = correlated_values([3.0, 1.0], covariance)
    found = en(3.0, u_a, 1.0, u_b, correlation=r)
    assert found.u_difference == pytest.approx((a - b).s, rel=1e-6)
    assert found.en == pytest.approx(2.0 / (2 * (a - b).s), rel=1e-6)


def test_law_exchange_of_the_two_changes_the_sign_alone() -> None:
    assert en(1.0, 0.2, 2.0, 0.3, correlation=0.4).en == pytest.approx(
        -(en(2.0, 0.3, 1.0, 0.2, correlation=0.4).en or 0)
    )
    assert "correlation 0.40 taken into account" in en(1.0, 0.2, 2.0, 0.3, correlation=0.4).sentence


@pytest.mark.parametrize(("u", "r"), [(0.0, 0.0), (0.5, 1.0)])
def test_limit_without_uncertainty_of_the_difference_en_is_undefined_and_says_so(u: float, r: float) -> None:
    apart, equal = en(1.0, u, 1.25, u, correlation=r), en(1.0, u, 1.0, u, correlation=r)
    assert apart.en is equal.en is apart.agrees is None
    assert apart.sentence.endswith("the values are 0.25 apart.")
    assert equal.sentence.endswith("the values are equal.")


@pytest.mark.parametrize("scale", [1e-250, 1e-12, 1e12, 1e250])
def test_limit_scales_do_not_matter(scale: float) -> None:
    assert en(10.5 * scale, 0.3 * scale, 10.0 * scale, 0.4 * scale).en == pytest.approx(0.5, rel=1e-12)


def test_limit_nearly_full_correlation_keeps_its_digits() -> None:
    found = en(1.0, 1.0, 0.0, 1.0, correlation=1 - 1e-12)
    assert found.u_difference == pytest.approx(math.sqrt(2e-12), rel=1e-4)


def test_limit_full_correlation_of_either_sign_is_a_correlation() -> None:
    # u² of the difference: u_a² + u_b² − 2·r·u_a·u_b
    assert en(3.0, 1.0, 0.0, 2.0, correlation=-1.0).en == pytest.approx(3 / (2 * 3))
    assert en(3.0, 1.0, 0.0, 2.0, correlation=1.0).en == pytest.approx(3 / (2 * 1))


def test_refusal_names_every_fault_at_once() -> None:
    with pytest.raises(MetrologyError) as caught:
        en(math.nan, -1.0, math.inf, math.nan, correlation=1.1, k=(0.0, 2.0))
    assert [fault.where for fault in caught.value.faults] == ["value_a", "value_b", "u_a", "u_b", "correlation", "k"]
