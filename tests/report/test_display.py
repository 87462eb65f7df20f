from __future__ import annotations

from math import nan
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from metrology.report import display, document, equations
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
    texts = display.aligned(["24730", "59.2", "0.4000"])
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
    apart = document._column(["24730", "1810.9", "0.08695"], units)
    assert apart == ["24730\N{PUNCTUATION SPACE}\N{FIGURE SPACE}", "1810.9", "0.08695"]
    together = document._column(["2473", "1810.9", "0.087"], units)
    assert together == display.aligned(["2473", "1810.9", "0.087"])
