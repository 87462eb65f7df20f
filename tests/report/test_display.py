from __future__ import annotations

import re
from math import nan
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from metrology.language import columns, display, wording
from metrology.report import equations, lines
from metrology.report.figures import style


@pytest.mark.parametrize(
    ("value", "u", "unit", "shown"),
    [
        (24734.25, 335.52, "N/m", ("24730", "340", "N/m")),
        (59.16e9, 3.29e9, "GPa", ("59.2", "3.3", "GPa")),
        (0.14, 0.00154, "%", ("14.00", "0.15", "%")),
        (-0.0123, 0.0004, "m", ("−0.01230", "0.00040", "m")),
        (1.0, nan, "1", ("–", "–", "")),
    ],
)
def test_reference_two_digits_of_u_and_value_to_the_same_place(
    value: float, u: float, unit: str, shown: tuple[str, str, str]
) -> None:
    result = display.estimate(value, u, unit)
    assert (result.value, result.u, result.unit) == shown


def test_limit_zero_uncertainty_is_shown_as_such() -> None:
    assert display.prefixed(9.806, 0.0, "m/s^2") == display.Shown("9.806", "0", "m/s²")


def test_law_aligned_texts_have_their_points_at_the_same_place() -> None:
    texts = columns.aligned(["24730", "59.2", "0.4000"])
    assert {
        len(text) - 1 - (text.index(".") if "." in text else text.index("\N{PUNCTUATION SPACE}")) for text in texts
    } == {4}


def test_law_decimation_keeps_every_spike() -> None:
    time = np.linspace(0, 1, 100_000)
    record = np.sin(60 * time)
    record[[77_777, 12_345]] = 9.0, -7.0
    ((x, y),) = style.decimate(time, record)
    assert len(x) <= 2 * style.COLUMNS
    assert y.max() == 9.0
    assert y.min() == -7.0
    assert np.all(np.diff(x) >= 0)


@pytest.mark.parametrize(
    "text",
    [
        "zeta = delta / sqrt(4 pi^2 + delta^2)",
        "ζ = δ / √(4π² + δ²)",
        "E = k * L / (w * t)",
        "c = 2 zeta sqrt(k m)",
        "F = m g (1 - rho_a / rho_m)",
    ],
)
def test_law_equations_are_drawn(text: str) -> None:
    plot = equations.draw(text)
    assert plot is not None
    assert plot.alt == text
    assert ET.fromstring(plot.svg).find("{http://www.w3.org/2000/svg}path") is not None


@pytest.mark.parametrize(
    "text", ["", "an ordinary sentence; not an equation", "(" * 2000, "a =", "\\frac{1}{0}", "x" * 5000, "1 / (2"]
)
def test_refusal_what_is_no_equation_stays_text(text: str) -> None:
    assert equations.draw(text) is None


def test_law_plain_text_has_only_characters_of_the_font() -> None:
    assert style.plain("a\nb  c") == "a b c"
    assert style.plain("試") == "\N{REPLACEMENT CHARACTER}"
    assert len(style.plain("x" * 200, 30)) == 30


def test_law_a_greek_name_keeps_its_index() -> None:
    assert [display.symbol(name) for name in ("zeta", "zeta_al_1100", "omega_n", "k_x")] == [
        "ζ",
        "ζ_al_1100",
        "ω_n",
        "k_x",
    ]


def test_law_numbers_of_many_sizes_line_up_unit_by_unit_where_all_together_would_be_too_wide() -> None:
    units = ["N/m", "N/m", "%"]
    apart = lines._column(["24730", "1810.9", "0.08695"], units)
    assert apart == ["24730\N{PUNCTUATION SPACE}\N{FIGURE SPACE}", "1810.9", "0.08695"]
    together = lines._column(["2473", "1810.9", "0.087"], units)
    assert together == columns.aligned(["2473", "1810.9", "0.087"])


SIZES = st.floats(-12, 12).map(lambda power: 10.0**power)


def read(text: str) -> float:
    """The number that a text stands for, read without the package."""
    digits, _, power = text.replace("−", "-").partition("×10")
    return float(digits) * 10.0 ** int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 0)


@given(SIZES, SIZES, st.sampled_from((-1.0, 1.0)))
def test_law_value_and_u_are_printed_to_two_digits_of_u_and_nothing_beyond(value: float, u: float, sign: float) -> None:
    assume(1e-9 < u / value < 1e9)
    shown, shown_u = display.rounded(sign * value, u)
    assert read(shown_u) == pytest.approx(u, rel=0.051)
    assert abs(read(shown) - sign * value) <= 0.051 * u + 1e-12 * value
    for text in (shown, shown_u):
        assert "e" not in text
        assert not re.fullmatch(r"−0(\.0*)?", text) or abs(value) < 0.06 * u
    assert len(re.sub(r"\D", "", shown_u.partition("×")[0]).lstrip("0")) <= 2 + len(str(int(read(shown_u))))
    assert len(re.sub(r"\D", "", shown.partition("×")[0]).lstrip("0")) <= 12


@given(SIZES, st.floats(0, 0.99e-13))
def test_law_no_value_has_more_digits_than_a_measurement(value: float, part: float) -> None:
    shown, shown_u = display.rounded(value, part * value)
    assert shown_u == "0"
    assert len(re.sub(r"\D", "", shown.partition("×")[0]).lstrip("0")) <= 6


@given(st.floats(0, 1))
def test_law_a_probability_is_never_rounded_to_nothing_or_to_certainty(p: float) -> None:
    text = display.chance(p)
    assert (text == "< 10⁻⁶") == (p < 1e-6)
    assert text not in ("0 %", "0.0 %", "0.00 %", "100 %", "100.0 %")
    if text[0] not in "<>":
        assert read(text.removesuffix(" %")) == pytest.approx(100 * p, rel=0.06, abs=0.051)


@given(st.floats(allow_nan=False, allow_infinity=False, width=32), st.integers(0, 8))
def test_law_no_sentence_has_a_computer_number_or_a_negative_nothing(value: float, digits: int) -> None:
    text = wording.prose(f"it is {value:.{digits}g} N, {value!r} m, {value:+.2f} s and {0.1 + 0.2} kg.")
    assert not re.search(r"\de[-+]?\d", text)
    assert "0.30000000000000004" not in text
    assert not re.search(r"[-−+]0(\.0+)? ", text)


@example(1.0, 10.366)
@given(SIZES, SIZES)
def test_law_an_expanded_uncertainty_stands_at_the_place_of_its_u(value: float, u: float) -> None:
    _, shown_u = display.rounded(value, u)
    assume(shown_u != "0")
    shown = display.like(2.0 * u, shown_u)
    assert shown.partition("×")[2] == shown_u.partition("×")[2]
    assert read(shown) == pytest.approx(2.0 * u, abs=0.06 * u)
