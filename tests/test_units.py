"""Quantities as text: published shorthand, every refusal, and properties of the grammar."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from metrology import units
from metrology.units import UnitError, convert, dimension, factor, parse, si_unit, unit
from metrology.units.symbols import symbols

PINT = {
    "%": "percent",
    "‰": "permille",
    "°C": "delta_degC",
    "°F": "delta_degF",
    "in": "inch",
    "ft": "foot",
    "lb": "pound",
    "lbf": "force_pound",
    "kgf": "kilogram_force",
    "gf": "gram_force",
    "gn": "standard_gravity",
    "rpm": "1/minute",
    "den": "denier",
    "Ω": "ohm",
    "t": "tonne",
    "deg": "degree",
    "hbar": "hectobar",
}


@pytest.mark.parametrize(
    ("text", "value", "u"),
    [
        ("25.00 mm", 0.025, None),
        ("25.00(5) mm", 0.025, 5e-5),
        ("25.00 ± 0.05 mm", 0.025, 5e-5),
        ("25.00 +/- 0.05 mm", 0.025, 5e-5),
        ("25.00 +- 0.05 mm", 0.025, 5e-5),
        ("25.00 mm ± 50 um", 0.025, 5e-5),
        ("(25.00 ± 0.05) mm", 0.025, 5e-5),
        ("14 %", 0.14, None),
        ("5 ppb", 5e-9, None),
        ("14.0(2) %", 0.14, 0.002),
        ("(14.0 ± 0.2) %", 0.14, 0.002),
        ("-1.2e-5 1/K", -1.2e-5, None),
        ("1.15(12)e-5 1/K", 1.15e-5, 1.2e-6),
        ("(1.15 ± 0.12)e-5 1/K", 1.15e-5, 1.2e-6),
        ("3", 3.0, None),
        ("-.5", -0.5, None),
        ("24734.25(335.52) N/m", 24734.25, 335.52),
        ("21.3(5) degC", 294.45, 0.5),
        ("20 °C", 293.15, None),
        ("2·10", None, None),
        ("8000(100) kg/m^3", 8000.0, 100.0),
        ("59.16 GPa", 59.16e9, None),
        ("\N{MINUS SIGN}40\N{NO-BREAK SPACE}µm", -40e-6, None),
    ],
)
def test_closed_form_quantities_are_read_as_a_person_means_them(
    text: str, value: float | None, u: float | None
) -> None:
    if value is None:
        with pytest.raises(UnitError):
            parse(text)
        return
    quantity = parse(text)
    assert quantity.value == value
    assert quantity.u == u


def test_reference_digits_in_parentheses_stand_for_the_last_places() -> None:
    # JCGM 100:2008 7.2.2: 100.021 47(35) g and 100.021 47(0.000 35) g say the same as 100.021 47 g with u = 0.35 mg
    first, second = parse("100.02147(35) g"), parse("100.02147(0.00035) g")
    assert first.value == second.value == 0.10002147
    assert first.u == second.u == 0.00035e-3
    assert (first.digits, first.u_digits) == (5, 5)


@pytest.mark.parametrize(
    ("text", "digits", "resolution"),
    [("25.00 mm", 2, 1e-5), ("1.2e-5", 6, 1e-6), ("1.2e3 N", -2, 100.0), ("14 %", 0, 0.01)],
)
def test_closed_form_the_last_written_place_is_known(text: str, digits: int, resolution: float) -> None:
    quantity = parse(text)
    assert quantity.digits == digits
    assert quantity.resolution == pytest.approx(resolution, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "canonical", "si"),
    [
        ("N*s/m", "N·s/m", "N·s/m"),
        ("N s/m", "N·s/m", "N·s/m"),
        ("N.s/m", "N·s/m", "N·s/m"),
        ("N·s·m^-1", "N·s/m", "N·s/m"),
        ("mm²", "mm^2", "m^2"),
        ("mm2", "mm^2", "m^2"),
        ("m**-2", "1/m^2", "1/m^2"),
        ("um", "µm", "m"),
        ("μm", "µm", "m"),
        ("kN/mm", "kN/mm", "N/m"),
        ("W/(m K)", "W/(m·K)", "W/(m·K)"),
        ("m/s/s", "m/s^2", "m/s^2"),
        ("deg/s", "deg/s", "rad/s"),
        ("mm/m", "mm/m", "1"),
        ("m/m", "1", "1"),
        ("L", "L", "m^3"),
        ("mg/L", "mg/L", "kg/m^3"),
        ("degC", "°C", "K"),
        ("1/K", "1/K", "1/K"),
        ("(N/m)^(1/2)", "N^(1/2)/m^(1/2)", "N^(1/2)/m^(1/2)"),
        ("ohm", "Ω", "Ω"),
    ],
)
def test_closed_form_units_have_a_canonical_text_and_an_si_unit(text: str, canonical: str, si: str) -> None:
    assert (unit(text).text, si_unit(text)) == (canonical, si)
    assert unit(canonical) == unit(text)


@pytest.mark.parametrize("symbol", sorted(set(symbols()) - {"ppb", "dB", "Np"}))
def test_twice_every_symbol_has_the_factor_and_dimension_of_pint(symbol: str, registry: pint.UnitRegistry) -> None:
    canonical = symbols()[symbol][0]
    theirs = registry.Quantity(1, PINT.get(canonical, canonical.replace("Ω", "ohm"))).to_base_units()
    assert factor(symbol) == pytest.approx(theirs.magnitude, rel=1e-14)
    exponents = {name.strip("[]"): power for name, power in theirs.dimensionality.items()}
    names = {"m": "length", "kg": "mass", "s": "time", "A": "current", "K": "temperature"}
    names |= {"mol": "substance", "cd": "luminosity"}
    assert {names[base]: float(power) for base, power in dimension(symbol).powers.items()} == exponents


@pytest.fixture(scope="module")
def registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


@pytest.mark.parametrize(
    ("text", "expected", "message"),
    [
        ("3.2 kg", "N", "got '3.2 kg', a mass; expected a force, such as '31.4 N'"),
        ("3", "mm", "got '3', a number without a unit; expected a length, such as '25.00 mm'"),
        ("3 mm", "kN/mm", "got '3 mm', a length; expected a stiffness, such as '24.7 kN/m'"),
        (
            "3 Hz",
            "rad/s",
            "got '3 Hz', a frequency; expected an angular frequency, such as '1.0 rad/s'. Fix: ω = 2π·f",
        ),
        (
            "3 rad/s",
            "Hz",
            "got '3 rad/s', an angular frequency; expected a frequency, such as '1.0 Hz'. Fix: ω = 2π·f",
        ),
        ("3 deg", "1", "got '3 deg', an angle; expected a number, such as '0.14'"),
        ("0.2", "rad", "got '0.2', a number without a unit; expected an angle, such as '1.0 rad'"),
        ("3 kg^7", "N", "got '3 kg^7', a quantity in kg^7; expected a force, such as '31.4 N'"),
    ],
)
def test_refusal_of_another_dimension_says_what_was_found_and_what_is_due(
    text: str, expected: str, message: str
) -> None:
    with pytest.raises(UnitError) as caught:
        parse(text, expected=expected)
    assert str(caught.value) == message
    assert str(caught.value.fault("a:1:2 b")) == f"a:1:2 b: {message}"


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("1,02 mm", "the decimal mark is a point"),
        ("nan mm", "only finite numbers"),
        ("-inf N", "only finite numbers"),
        ("1_0 mm", "without underscores"),
        ("+-5 mm", "one sign at most"),
        ("--5 mm", "one sign at most"),
        ("24 734.25 N/m", "without spaces"),
        ("25.00 (5) mm", "no space stands before the parenthesis"),
        ("1.5e3(2) N", "the power of ten stands behind the parenthesis"),
        ("1.2×10^-5 m", "write powers of ten as '1.2e-5'"),
        ("1 ± 2 ± 3 m", "one uncertainty at most"),
        ("1(1) ± 2 m", "one uncertainty at most"),
        ("(1 m ± 2) m", "the unit stands once"),
        ("25.00 ± 0.2 %", "may mean a relative uncertainty or one in percent"),
        ("25.00 mm ± 0.2 %", "may mean a relative uncertainty or one in percent"),
        ("2 m ± 3 s", "the two units do not match"),
        ("1 m ± 3", "the two units do not match"),
        ("25.00(0) mm", "leave it out for an exact value"),
        ("25.00 ± -1 mm", "leave it out for an exact value"),
        ("1e999 m", "beyond 1e75"),
        ("0e999 Tm^9", "beyond 1e75"),
        ("1e-999 m", "below 1e-75"),
        ("", "it is empty"),
        ("mm", "a number with a unit"),
        ("25 Kg", "case counts; did you mean 'kg'?"),
        ("5 furlong", "a symbol of a unit"),
        ("3 N/m*s", "a product after a solidus is ambiguous"),
        ("9**9**9**9 m", "a unit such as"),
        ("5 m^99", "powers lie between -12 and 12"),
        ("5 (m^9)^9", "powers between -12 and 12"),
        ("1 ((((((m))))))", "at most 5 parentheses"),
        ("1 (m", "a parenthesis is not closed"),
        ("1 m)", "a unit such as"),
        ("1 m^2kg", "a unit such as"),
        ("5 mm 3", "a unit such as"),
        ("3 /K", "a unit such as"),
        ("25. mm", "a unit such as"),
        ("1" * 101, "of at most 100 characters"),
    ],
)
def test_refusal_of_what_is_no_quantity_tells_how_to_mend_it(text: str, part: str) -> None:
    with pytest.raises(UnitError) as caught:
        parse(text)
    assert part in str(caught.value)
    assert "expected" in str(caught.value)


def test_refusal_of_what_is_not_even_text() -> None:
    with pytest.raises(UnitError, match="not a text"):
        parse(3.2)  # type: ignore[arg-type]
    with pytest.raises(UnitError, match="at most 100 characters"):
        unit(" ")


def test_closed_form_a_difference_of_temperatures_has_no_offset() -> None:
    assert parse("0.5 degC", expected="K", difference=True).value == 0.5
    assert parse("1.15e-5 1/degC", expected="1/K").value == 1.15e-5
    assert convert(293.15, "degC") == 20.0
    assert convert(0.5, "degC", difference=True) == 0.5
    assert math.isinf(convert(math.inf, "mm"))


def test_closed_form_units_of_other_systems() -> None:
    """NIST SP 811, B.8; a level of 20 dB is a factor of ten, ln 10 Np."""
    assert parse("212 degF").value == pytest.approx(373.15, abs=1e-12)
    assert parse("9 degF", difference=True).value == 5.0
    assert parse("1 psi", expected="Pa").value == pytest.approx(6894.757293168361, rel=1e-15)
    assert parse("1 in", expected="m").value == 0.0254
    assert parse("9 den", expected="kg/m").value == pytest.approx(1e-6)
    assert parse("20 dB").value == pytest.approx(math.log(10))
    assert parse("3000 rpm", expected="Hz").value == 50.0
    with pytest.raises(UnitError, match="got '3 dB', a level; expected a number"):
        parse("3 dB", expected="1")


LAB_UNITS = {
    "in": ("0.0254", "m", "NIST SP 811:2008, B.8"),
    "ft": ("0.3048", "m", "NIST SP 811:2008, B.8"),
    "thou": ("0.0000254", "m", "NIST SP 811:2008, B.8, mil"),
    "lb": ("0.45359237", "kg", "NIST SP 811:2008, B.8, note 22"),
    "lbf": ("4.4482216152605", "N", "NIST SP 811:2008, B.8: lb times standard gravity"),
    "kip": ("4448.2216152605", "N", "NIST SP 811:2008, B.8: 1000 lbf"),
    "klbf": ("4448.2216152605", "N", "NIST SP 811:2008, B.8, kip"),
    "dyn": ("0.00001", "N", "NIST SP 811:2008, B.8"),
    "kgf": ("9.80665", "N", "NIST SP 811:2008, B.8"),
    "gf": ("0.00980665", "N", "NIST SP 811:2008, B.8"),
    "psi": (Fraction("4.4482216152605") / Fraction("0.0254") ** 2, "Pa", "NIST SP 811:2008, B.8: lbf/in^2"),
    "ksi": (1000 * Fraction("4.4482216152605") / Fraction("0.0254") ** 2, "Pa", "NIST SP 811:2008, B.8"),
    "mmHg": (Fraction("13595.1") * Fraction("9.80665") / 1000, "Pa", "NIST SP 811:2008, B.8, conventional: ρ·g·1 mm"),
    "bar": ("100000", "Pa", "NIST SP 811:2008, B.8"),
    "atm": ("101325", "Pa", "NIST SP 811:2008, B.8"),
    "°F": (Fraction(5, 9), "K", "NIST SP 811:2008, B.8, temperature interval"),
    "eV": ("1.602176634e-19", "J", "SI brochure, 9th edition, table 8"),
    "gn": ("9.80665", "m/s^2", "NIST SP 811:2008, B.8, standard acceleration of free fall"),
    "rpm": (Fraction(1, 60), "1/s", "NIST SP 811:2008, B.8: one revolution in a minute, as a frequency"),
    "Bq": ("1", "1/s", "SI brochure, 9th edition, table 4"),
    "Gy": ("1", "m^2/s^2", "SI brochure, 9th edition, table 4: J/kg"),
    "lx": ("1", "cd/m^2", "SI brochure, 9th edition, table 4: lm/m^2, with lm = cd·sr and sr = 1"),
    "tex": ("0.000001", "kg/m", "NIST SP 811:2008, B.8"),
    "den": (Fraction(1, 9_000_000), "kg/m", "NIST SP 811:2008, B.8: 1 g in 9000 m"),
    "dB": (Fraction(math.log(10)) / 20, "1", "SI brochure, 9th edition, table 8: (ln 10)/20 Np"),
}
"""Unit → factor, SI unit, source; all but that of the decibel exact."""


@pytest.mark.parametrize("symbol", LAB_UNITS)
def test_reference_units_of_laboratories_have_their_exact_factor(symbol: str) -> None:
    expected, si, _ = LAB_UNITS[symbol]
    assert unit(symbol).factor == Fraction(expected)
    assert unit(symbol).dimension == dimension(si)


@pytest.mark.parametrize(
    ("text", "si"), [("32 °F", 273.15), ("212 °F", 373.15), ("-40 °F", 233.15), ("-40 °C", 233.15)]
)
def test_reference_a_temperature_in_fahrenheit_has_its_own_zero(text: str, si: float) -> None:
    """NIST SP 811:2008, B.8: T/K = (t/°F + 459.67)/1.8."""
    assert parse(text).value == pytest.approx(si, abs=1e-12)


def test_law_every_named_dimension_is_written_in_its_own_si_unit() -> None:
    from metrology.units.dimensions import NAMES

    for of, (name, si, example) in NAMES.items():
        assert dimension(si) == of, name
        assert factor(si) == 1, name
        assert parse(example, expected=si).dimension == of, name
    assert si_unit(units.Dimension.of(m=3, s=-5)) == "m^3/s^5"


canonical_symbols = st.sampled_from(sorted({canonical for canonical, _ in symbols().values()}))
# At most litres squared times litres squared, m^12: beyond, a unit is refused.
powers = st.dictionaries(canonical_symbols, st.integers(-2, 2).filter(bool), min_size=1, max_size=2)


@settings(deadline=None)
@given(powers)
def test_law_a_unit_written_out_reads_back_the_same(written: dict[str, int]) -> None:
    text = "·".join(f"{symbol}^{power}" for symbol, power in written.items())
    once = unit(text)
    assert unit(once.text) == once
    assert unit(once.si).dimension == once.dimension
    assert unit(once.si).factor == 1


@settings(deadline=None)
@given(
    st.decimals(-(10**12), 10**12, allow_nan=False, allow_infinity=False, places=6),
    st.integers(1, 999),
    canonical_symbols.filter(lambda symbol: symbol not in ("°C", "°F")),
)
def test_law_value_and_uncertainty_survive_the_way_there_and_back(number: Decimal, u: int, symbol: str) -> None:
    quantity = parse(f"{number:f}({u}) {symbol}")
    assert convert(quantity.value, symbol) == pytest.approx(float(number), rel=1e-14, abs=1e-300)
    assert convert(quantity.u or 0.0, symbol) == pytest.approx(u * 1e-6, rel=1e-14)


@pytest.mark.long
@settings(deadline=None)
@given(st.one_of(st.text(max_size=120), st.text(alphabet="0123456789.eE+-±()/*^·% mNkgs°C²⁻,_", max_size=110)))
def test_law_any_text_gives_a_quantity_or_the_one_error(text: str) -> None:
    try:
        quantity = parse(text)
    except UnitError:
        return
    assert math.isfinite(quantity.value)
    assert quantity.u is None or 0 < quantity.u < math.inf
    assert math.isfinite(quantity.resolution)


@pytest.mark.parametrize(("typed", "meant"), [("Nm", "'nm' or 'N*m'"), ("kNm", "'kN*m'"), ("Pas", "'Pa*s'")])
def test_refusal_of_a_product_without_its_sign_names_it(typed: str, meant: str) -> None:
    with pytest.raises(units.UnitError) as refused:
        units.unit(typed)
    assert meant in refused.value.fix
