from decimal import Decimal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from metrology.gum.rounding import readable, shorthand, significant, tolerance

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("value", "u", "texts"),
    [
        (100.021472, 0.000349, ("100.02147", "0.00035")),
        (24734.25, 335.52, ("24730", "340")),
        (59.16, 3.29, ("59.2", "3.3")),
        (0.125, 0.0996, ("0.12", "0.10")),
        (2.675, 0.05, ("2.675", "0.050")),
        (-0.0001, 0.02, ("0.000", "0.020")),
        (50000838.0, 31.66, ("50000838", "32")),
        (5.67037248e-8, 2.05e-13, ("5.670372e-8", "0.000020e-8")),
        (5.916e10, 3.29e9, ("5.92e10", "0.33e10")),
        (1e300, 1e299, ("1.00e300", "0.10e300")),
        (0.0, 0.15, ("0.00", "0.15")),
        (1.5, 0.0, ("1.5", "0")),
        (1e22, 0.0, ("1e22", "0")),
        (0.0, 0.0, ("0", "0")),
        (NAN, 1.0, ("undefined", "1.0")),
        (1.0, NAN, ("1.0", "undefined")),
        (1.0, INF, ("1.0", "infinite")),
    ],
)
def test_closed_form_two_digits_of_u(value, u, texts):
    assert significant(value, u) == texts


@pytest.mark.parametrize(
    ("value", "u", "digits", "text"),
    [
        (24734.25, 335.52, 5, "24734.25(335.52)"),
        (24734.25, 335.52, 2, "24730(340)"),
        (100.02147, 0.00035, 2, "100.02147(35)"),
        (59.16, 3.29, 2, "59.2(3.3)"),
        (25.0, 1.0, 2, "25.0(1.0)"),
        (25.0, 0.99, 2, "25.00(99)"),
        (5.67037248e-8, 2.05e-13, 2, "5.670372(20)e-8"),
        (1.5, 0.0, 2, "1.5(0)"),
        (2.0, INF, 2, "2.0(infinite)"),
    ],
)
def test_closed_form_shorthand(value, u, digits, text):
    assert shorthand(value, u, digits) == text


@given(st.floats(-1e12, 1e12), st.floats(1e-12, 1e12), st.integers(1, 4))
@settings(max_examples=300, deadline=None)
def test_law_rounding_moves_by_at_most_half_a_digit(value, u, digits):
    value_text, u_text = significant(value, u, digits)
    half = Decimal(repr(tolerance(u, digits)))
    assert abs(Decimal(value_text) - Decimal(repr(value))) <= half
    assert abs(Decimal(u_text) - Decimal(repr(u))) <= half


@given(st.floats(1e-300, 1e300), st.integers(1, 4))
@settings(max_examples=300, deadline=None)
def test_law_tolerance_is_half_a_unit_of_the_last_of_the_digits(u, digits):
    ratio = Decimal(repr(u)) / (2 * Decimal(repr(tolerance(u, digits))))
    assert Decimal(10) ** (digits - 1) - Decimal("0.5") <= ratio <= Decimal(10) ** digits


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (2.7e-6, "m", "2.7 µm"),
        (335.5, "N/m", "340 N/m"),
        (0.0, "m", "0 m"),
        (1.5e-8, "m^2", "1.5e-8 m²"),
        (9.96e-4, "s", "1.0 ms"),
        (0.05, "kg", "50 g"),
        (INF, "m", "inf m"),
        (1234.0, "mol", "1200 mol"),
    ],
)
def test_closed_form_numbers_in_sentences(value, unit, text):
    assert readable(value, unit) == text
