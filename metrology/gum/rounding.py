"""Rounding for a reader: u to two significant digits, the value to the same place (JCGM 100:2008, 7.2.6).

Ties go to the even digit, on the shortest decimal that stands for the float, so that 0.125 rounds as a person would.
"""

from __future__ import annotations

import re
from decimal import ROUND_HALF_EVEN, Decimal, localcontext
from math import isfinite

from metrology.units import unit_text

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 3: "k", 6: "M", 9: "G", 12: "T"}
_PREFIXABLE = re.compile(r"(m|g|s|A|V|W|N|J|Pa|Hz|Ω)(?![A-Za-zΩ^²³])")
_SMALLEST_PLAIN = -5
_ZEROS_PLAIN = 4


def significant(value: float, u: float, digits: int = 2) -> tuple[str, str]:
    """Texts of value and standard uncertainty, u to `digits` significant digits and the value to the same place.

    Numbers that would need many zeros share a power of ten: ``("5.67037e-8", "0.00002e-8")``. With u = 0 the value is
    given in full, up to fifteen digits; a number that is not finite is ``"undefined"``, an infinite u ``"infinite"``.

    Parameters
    ----------
    value, u : float
        In the same unit; u ≥ 0.
    digits : int
        Significant digits of u.

    Returns
    -------
    tuple of str
        Value and u, without unit.

    Notes
    -----
    JCGM 100:2008 7.2.6.

    Examples
    --------
    >>> significant(100.021472, 0.000349)
    ('100.02147', '0.00035')
    >>> significant(24734.25, 335.52)
    ('24730', '340')
    >>> significant(0.125, 0.0996)
    ('0.12', '0.10')
    """
    if not isfinite(value) or not isfinite(u):
        return (repr(value) if isfinite(value) else "undefined"), _unbounded(u)
    # Beyond fifteen digits a sum of decimal numbers shows the rounding of binary arithmetic.
    value_decimal, u_decimal = Decimal(repr(value) if u else f"{value:.15g}"), Decimal(repr(u))
    place = _place(u_decimal, digits) if u_decimal else _last_place(value_decimal)
    exponent = _common_exponent(value_decimal, u_decimal, place)
    value_text, u_text = (_text(number, place, exponent) for number in (value_decimal, u_decimal))
    return value_text, (u_text if u_decimal else "0")


def shorthand(value: float, u: float, digits: int = 2) -> str:
    """Value with its standard uncertainty in parentheses, in units of the last digit (JCGM 100:2008 7.2.2, way 2).

    An uncertainty that reaches across the decimal point is written out.

    Examples
    --------
    >>> shorthand(100.02147, 0.00035)
    '100.02147(35)'
    >>> shorthand(24734.25, 335.52, 5)
    '24734.25(335.52)'
    >>> shorthand(24734.25, 335.52)
    '24730(340)'
    """
    value_text, u_text = significant(value, u, digits)
    if not (isfinite(value) and isfinite(u)):
        return f"{value_text}({u_text})"
    mantissa, _, power = value_text.partition("e")
    u_mantissa = u_text.partition("e")[0]
    if "." in u_mantissa and float(u_mantissa) < 1:
        u_mantissa = u_mantissa.replace(".", "").lstrip("0")
    return f"{mantissa}({u_mantissa})" + (f"e{power}" if power else "")


def tolerance(u: float, digits: int = 2) -> float:
    """Numerical tolerance δ = 10ˡ/2 of u = c·10ˡ with c of `digits` digits: half of the last digit that is shown.

    Parameters
    ----------
    u : float
        Standard uncertainty, above 0.
    digits : int
        Significant digits of u that count.

    Returns
    -------
    float
        δ, in the unit of u.

    Notes
    -----
    JCGM 101:2008 7.9.2.

    Examples
    --------
    >>> tolerance(0.00035), tolerance(2.0)
    (5e-06, 0.05)
    """
    return float(Decimal("0.5").scaleb(_place(Decimal(repr(u)), digits)))


def readable(value: float, unit: str, digits: int = 2) -> str:
    """A number with its SI unit for a sentence, ``2.7 µm``: significant digits, and a prefix where it helps.

    Parameters
    ----------
    value : float
        In `unit`.
    unit : str
        SI unit, ``"1"`` for none.
    digits : int
        Significant digits.

    Returns
    -------
    str
        Number and unit, as it is printed.

    Examples
    --------
    >>> readable(2.7e-6, "m"), readable(335.5, "N/m"), readable(3.29e9, "Pa"), readable(0.0123, "1")
    ('2.7 µm', '340 N/m', '3.3 GPa', '0.012')
    >>> readable(1.5e-5, "kg"), readable(1.5e-8, "m^2")
    ('15 mg', '1.5e-8 m²')
    """
    if unit == "kg" and 0 < abs(value) < 1:
        value, unit = value * 1000, "g"
    symbol = "" if unit == "1" else f" {unit_text(unit)}"
    if not value or not isfinite(value):
        return f"{value:g}{symbol}"
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    power = int(exponent)
    prefix = _PREFIXES.get(power // 3 * 3, "") if _PREFIXABLE.match(unit) else ""
    if prefix:
        power, symbol = power % 3, f" {prefix}{unit_text(unit)}"
    if -4 <= power < 5:
        return f"{float(f'{mantissa}e{power}'):.{max(digits - 1 - power, 0)}f}{symbol}"
    return f"{mantissa}e{power}{symbol}"


def _unbounded(u: float) -> str:
    return repr(u) if isfinite(u) else "infinite" if u > 0 else "undefined"


def _place(u: Decimal, digits: int) -> int:
    """Exponent of the last digit kept, after a carry such as 0.0996 → 0.10."""
    place = u.adjusted() - digits + 1
    return place + (_quantised(u, place).adjusted() > u.adjusted())


def _last_place(value: Decimal) -> int:
    return int(value.normalize().as_tuple().exponent)


def _common_exponent(value: Decimal, u: Decimal, place: int) -> int:
    """Power of ten taken out of both numbers; 0 where they read well as they are."""
    size = max((number.adjusted() for number in (value, u) if number), default=0)
    return 0 if size >= _SMALLEST_PLAIN and place <= _ZEROS_PLAIN else size


def _quantised(number: Decimal, place: int) -> Decimal:
    with localcontext() as context:
        context.prec = 1000
        return number.quantize(Decimal(1).scaleb(place), rounding=ROUND_HALF_EVEN)


def _text(number: Decimal, place: int, exponent: int) -> str:
    """Fixed-point text of a number rounded to a place; a value that rounds to zero loses its sign."""
    rounded = _quantised(number, place)
    scaled = (rounded if rounded else abs(rounded)).scaleb(-exponent)
    return f"{scaled:f}" + (f"e{exponent}" if exponent else "")
