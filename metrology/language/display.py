"""Numbers as the report prints them: two digits of u, value to the same place, units that read well."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import floor, isfinite, log10

from metrology.units import raised, unit_text

_NUMERAL = re.compile(r"[+\-−]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][+-]?\d+)?")
_PLAIN = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_PREFIXED = {
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "s": ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")),
    "kg/m": ((1.0, "kg/m"), (1e-3, "g/m")),
    "kg": ((1.0, "kg"), (1e-3, "g"), (1e-6, "mg")),
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "N": ((1e3, "kN"), (1.0, "N"), (1e-3, "mN")),
    "N/m": ((1e6, "MN/m"), (1.0, "N/m")),
    "m²": ((1.0, "m²"), (1e-6, "mm²")),
}
"""SI unit → the scales that a reader expects of it, largest first."""

SYMBOLS = {
    "zeta": "ζ", "omega_n": "ω_n", "omega_d": "ω_d", "delta": "δ", "eps_b": "ε_b", "k_inf": "k_∞",
    "E_inf": "E_∞", "relaxed": "R", "alpha": "α", "log_decrement": "δ",
}  # fmt: skip
"""Names of quantities in campaign files → the symbols of the equations."""


LEAST, TINY = 1e-6, "< 10⁻⁶"
"""Probability below which a test distinguishes no two values, and what is printed there."""
EXACT = 1e-13
"""Part of a value below which its u is the rounding of floating point; frequencies are known to some 10⁻¹²."""
_LEADING = 1e-5
"""Uncertainty below which zeros before its digits hide them."""


@dataclass(frozen=True)
class Shown:
    """A value and its standard uncertainty as text in one unit; `low` and `high` end its coverage interval."""

    value: str
    u: str
    unit: str
    low: str = ""
    high: str = ""


def scale(magnitude: float, unit: str) -> tuple[float, str]:
    """Factor and unit in which a magnitude of an SI unit reads well: ``(1e-06, "µm")`` for 2.7e-6 m.

    Examples
    --------
    >>> scale(2.7e-6, "m"), scale(59e9, "Pa"), scale(12.0, "N/m")
    ((1e-06, 'µm'), (1000000000.0, 'GPa'), (1.0, 'N/m'))
    """
    unit = unit_text(unit)
    steps = _PREFIXED.get(unit, ((1.0, unit),))
    size = abs(magnitude)
    if not size or not isfinite(size):
        return next(step for step in steps if step[0] == 1.0)
    return next((step for step in steps if size >= step[0] * 0.1), steps[-1])


def number(value: float | None, digits: int = 3) -> str:
    """Number to significant digits, as ``1.23×10⁻⁵`` where zeros would hide it; a dash for nothing.

    Examples
    --------
    >>> number(12.345), number(-4.04e-5), number(None), number(0.0), number(123456.0)
    ('12.3', '−4.04×10⁻⁵', '–', '0', '1.23×10⁵')
    """
    if value is None or not isfinite(value):
        return "–"
    if value == 0:
        return "0"
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    power = int(exponent)
    if -4 < power < max(digits, 5):
        return f"{float(f'{value:.{digits - 1}e}'):.{max(digits - 1 - power, 0)}f}".replace("-", "−")
    return f"{mantissa.replace('-', '−')}×10{raised(str(power))}"


def estimate(value: float, u: float, unit: str, interval: tuple[float | None, float | None] = (None, None)) -> Shown:
    """Value, u and interval in the display unit `unit`: u to two digits, all to the same place."""
    from metrology.units import convert, factor

    shown_u = u / factor(unit)
    value_text, u_text = rounded(convert(value, unit), shown_u)
    low, high = ("–" if end is None else rounded(convert(end, unit), shown_u)[0] for end in interval)
    return Shown(value_text, u_text, unit_text(unit), low, high)


def prefixed(value: float, u: float, unit: str) -> Shown:
    """Value and u of an SI unit on the scale that reads well."""
    factor, text = scale(value or u, unit)
    value_text, u_text = rounded(value / factor, u / factor)
    return Shown(value_text, u_text, text)


def rounded(value: float, u: float) -> tuple[str, str]:
    """Value and u, two significant digits of u; powers of ten where zeros would hide the digits.

    Examples
    --------
    >>> rounded(24734.2, 335.5), rounded(1.5e-30, 2e-31), rounded(10000000.0012, 0.001), rounded(1.23456789, 9.5e-7)
    (('24730', '340'), ('1.50×10⁻³⁰', '0.20×10⁻³⁰'), ('10000000.0012', '0.0010'), ('1.23456789', '9.5×10⁻⁷'))
    """
    from metrology.gum.rounding import significant

    if not (isfinite(value) and isfinite(u)):
        return "–", "–"
    size, exact = max(abs(value), abs(u)), u <= EXACT * abs(value)
    # Digits after the point of a large value are none of the zeros that a power of ten saves.
    if size and (size < 1e-4 or (size >= 1e7 and (exact or u >= 1))):
        power = floor(log10(size))
        times = f"×10{raised(str(power))}"
        value_text, u_text = _plain(value / 10.0**power, u / 10.0**power)
        shared = u_text if u_text == "0" else u_text + times
        return value_text + times, shared if exact or u >= _LEADING * 10.0**power else _typeset(significant(u, u)[1])
    value_text, u_text = _plain(value, u)
    return value_text, u_text if exact or u >= _LEADING else _typeset(significant(u, u)[1])


def _plain(value: float, u: float) -> tuple[str, str]:
    """Value and u to the same place; of an exact value six digits at most."""
    from metrology.gum.rounding import significant

    if u <= EXACT * abs(value):
        text = number(value, 6)
        return (text.rstrip("0").rstrip(".") if "." in text and "×" not in text else text), "0"
    return _typeset(significant(value, u)[0]), _typeset(significant(value, u)[1])


def as_stated(value: float, text: str, unit: str) -> str:
    """A limit with every digit with which it is stated, ``text``; without that text, with those that tell its value.

    `value` is in SI, `unit` that of display.

    Examples
    --------
    >>> as_stated(0.1, "100.0000 mm", "mm"), as_stated(1e-30, "1.0e-30 kg", "kg"), as_stated(12345.6, "", "N")
    ('100.0000 mm', '1.0×10⁻³⁰ kg', '12345.6 N')
    """
    from metrology.gum.rounding import significant
    from metrology.units import convert, parse

    written = _NUMERAL.match(text.strip())
    if written is None:
        return f"{_typeset(significant(convert(value, unit), 0.0)[0])} {unit_text(unit)}".rstrip()
    return f"{_typeset(written[0].lower().removeprefix('+'))} {unit_text(parse(text).unit)}".rstrip()


def _typeset(text: str) -> str:
    """``-1.2e-5`` → −1.2×10⁻⁵."""
    digits, mark, power = text.partition("e")
    return digits.replace("-", "−") + (f"×10{raised(str(int(power)))}" if mark else "")


def like(value: float, text: str) -> str:
    """A number to the place and the power of ten of another one: U as its u is printed.

    Examples
    --------
    >>> like(0.0000838, "0.000043"), like(671.2, "340"), like(20.7, "10"), like(3.2e-9, "1.6×10⁻⁹")
    ('0.000084', '670', '21', '3.2×10⁻⁹')
    """
    digits, times, power = text.partition("×10")
    size = 10.0 ** int(power.translate(_PLAIN)) if times else 1.0
    # A u has two significant digits, of which the second may be a zero.
    places = len(digits.partition(".")[2]) or min(2 - len(digits), 0)
    return f"{round(value / size, places):.{max(places, 0)}f}{times}{power}"


def concise(value: float, u: float) -> str:
    """Value with u in units of its last digits (JCGM 100, 7.2.2).

    Examples
    --------
    >>> concise(141.968, 0.10234), concise(24734.2, 335.5), concise(14.123, 1.234)
    ('141.97(10)', '24730(340)', '14.1(1.2)')
    >>> concise(1.23456789, 9.5e-7), concise(1.5e-30, 2e-31)
    ('1.23456789(95)', '1.50(20)×10⁻³⁰')
    """
    value_text, u_text = rounded(value, u)
    digits, times, power = value_text.partition("×")
    places, _, own = u_text.partition("×")
    if own != power and places != "0":
        places = places.replace(".", "")[:2]
    elif "." in places and places.startswith("0"):
        places = places.replace(".", "").lstrip("0") or "0"
    return f"{digits}({places}){times}{power}"


def symbol(quantity: str) -> str:
    """Symbol of a quantity: ``zeta`` → ζ, ``zeta_nylon`` → ζ_nylon; other names as they are."""
    stem, mark, index = quantity.partition("_")
    return SYMBOLS.get(quantity, f"{SYMBOLS.get(stem, stem)}{mark}{index}")


def signed(value: float, digits: int) -> str:
    """A number with its sign, to so many decimals; a zero has none.

    Examples
    --------
    >>> signed(0.123, 2), signed(-0.126, 2), signed(-0.0001, 2)
    ('+0.12', '−0.13', '0.00')
    """
    text = f"{value:+.{digits}f}"
    return text[1:] if not float(text) else text.replace("-", "−")


def percent(share: float, digits: int = 1) -> str:
    """Share as a percentage, with a true minus."""
    return f"{100 * share:.{digits}f} %".replace("-", "−")


def chance(probability: float, resolution: float = 0.0) -> str:
    """A probability; no rounding makes a certainty of it, and below `resolution` there is a bound.

    Examples
    --------
    >>> chance(0.97724), chance(0.0214), chance(3e-9), chance(1.0)
    ('97.7 %', '2.14 %', '< 10⁻⁶', '> 99.9 %')
    >>> chance(3e-6), chance(0.00082)
    ('3×10⁻⁶', '0.082 %')
    >>> chance(0.0, 3e-5), chance(0.99, 0.03)
    ('< 3×10⁻⁵', '> 97.0 %')
    """
    if resolution > 0.0005 and probability > 1 - resolution:
        return f"> {number(100 * (1 - resolution), 3)} %"
    if probability > 0.9995 - 1e-12:
        return "> 99.9 %"
    if probability < max(LEAST, resolution):
        from metrology.gum.printed_probability import probability as bounded

        return bounded(probability, resolution)
    if probability < 1e-4:
        # Of some 10⁶ draws, or of a tail: one digit is known of it.
        return number(probability, 1)
    if probability < 1e-3:
        return f"{number(100 * probability, 2)} %"
    return percent(probability, 2 if probability < 0.095 else 1)


def normalised(en: float | None) -> str:
    """E_n, the same wherever it stands: two decimals, none beyond ten, where it only says that two values differ.

    One beside the limit has as many decimals as tell on which side it lies.

    Examples
    --------
    >>> normalised(-1.4949), normalised(-0.001), normalised(129.34), normalised(1.0006), normalised(None)
    ('−1.49', '0.00', '129', '1.001', '–')
    """
    if en is None or not isfinite(en):
        return "–"
    digits = 2 if abs(en) < 10 else 0
    while abs(en) != 1 and abs(round(en, digits)) == 1 and digits < 15:
        digits += 1
    text = f"{en:.{digits}f}"
    return text.removeprefix("-") if not float(text) else text.replace("-", "−")


def p_value(p: float | None) -> str:
    """The p-value of a test; how far below a millionth it lies no test can tell.

    Examples
    --------
    >>> p_value(0.0213), p_value(9.9e-305), p_value(0.0), p_value(None)
    ('0.021', '< 10⁻⁶', '< 10⁻⁶', '–')
    """
    return "–" if p is None else TINY if p < LEAST else number(p, 2)


def grouped(count: int) -> str:
    """Count with thin spaces between thousands: ``1000000`` → 1 000 000."""
    return f"{count:,}".replace(",", "\N{NO-BREAK SPACE}")
