"""Numbers as the report prints them: two digits of u, value to the same place, units that read well."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, isfinite, log10

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXED = {
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "s": ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")),
    "kg": ((1.0, "kg"), (1e-3, "g"), (1e-6, "mg")),
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "N": ((1e3, "kN"), (1.0, "N"), (1e-3, "mN")),
    "m²": ((1.0, "m²"), (1e-6, "mm²")),
}
"""SI unit → the scales that a reader expects of it, largest first."""

SYMBOLS = {"zeta": "ζ", "omega_n": "ω_n", "omega_d": "ω_d", "delta": "δ", "eps_b": "ε_b"}
"""Names of quantities in campaign files → the symbols of the equations."""


LEAST = 1e-6
"""Probability below which a test tells no two apart."""


@dataclass(frozen=True)
class Shown:
    """A value and its standard uncertainty as text in one unit; `low` and `high` end its coverage interval."""

    value: str
    u: str
    unit: str
    low: str = ""
    high: str = ""


def unit_text(unit: str) -> str:
    """Unit for the eye: ``kg/m^3`` → ``kg/m³``, ``1`` → nothing."""
    if unit == "1":
        return ""
    text = unit.replace("**", "^").replace("*", "·").replace("um", "µm") if unit != "um" else "µm"
    stem, *powers = text.split("^")
    for power in powers:
        digits = len(power) - len(power.lstrip("-0123456789"))
        stem += power[:digits].translate(_SUPERSCRIPT) + power[digits:]
    return stem


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
    return f"{mantissa.replace('-', '−')}×10{str(power).translate(_SUPERSCRIPT)}"


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
    """Value and u, two significant digits of u; powers of ten where zeros would hide the digits."""
    from metrology.gum.rounding import significant

    if not (isfinite(value) and isfinite(u)):
        return "–", "–"
    size = max(abs(value), abs(u))
    if size and not 1e-4 <= size < 1e7:
        power = floor(log10(size))
        times = f"×10{str(power).translate(_SUPERSCRIPT)}"
        value_text, u_text = rounded(value / 10.0**power, u / 10.0**power)
        return value_text + times, u_text + times
    if u <= 0:
        text = number(value, 6)
        return (text.rstrip("0").rstrip(".") if "." in text and "×" not in text else text), "0"
    value_text, u_text = significant(value, u)
    return value_text.replace("-", "−"), u_text


def concise(value: float, u: float) -> str:
    """Value with u in units of its last digits (JCGM 100, 7.2.2).

    Examples
    --------
    >>> concise(141.968, 0.10234), concise(24734.2, 335.5), concise(14.123, 1.234)
    ('141.97(10)', '24730(340)', '14.1(1.2)')
    """
    value_text, u_text = rounded(value, u)
    if "." in u_text and u_text.startswith("0"):
        u_text = u_text.replace(".", "").lstrip("0") or "0"
    return f"{value_text}({u_text})"


def aligned(texts: list[str]) -> list[str]:
    """Texts of one column, padded on the right so that decimal points stand below each other when set flush right."""
    tails = [_tail(text) for text in texts]
    widest = max((len(tail) for tail in tails), default=0)
    return [text + _blank(widest, tail) for text, tail in zip(texts, tails, strict=True)]


def _tail(text: str) -> str:
    return "." + text.partition(".")[2] if "." in text else ""


def _blank(widest: int, tail: str) -> str:
    if not widest:
        return ""
    figures = widest - max(len(tail), 1)
    return ("\N{PUNCTUATION SPACE}" if not tail else "") + "\N{FIGURE SPACE}" * figures


def symbol(quantity: str) -> str:
    """Symbol of a quantity: ``zeta`` → ζ, ``zeta_nylon`` → ζ_nylon; other names as they are."""
    stem, mark, index = quantity.partition("_")
    return SYMBOLS.get(quantity, f"{SYMBOLS.get(stem, stem)}{mark}{index}")


def percent(share: float, digits: int = 1) -> str:
    """Share as a percentage, with a true minus."""
    return f"{100 * share:.{digits}f} %".replace("-", "−")


def chance(probability: float) -> str:
    """A probability; no rounding makes a certainty of it.

    Examples
    --------
    >>> chance(0.97724), chance(0.0214), chance(3e-9), chance(1.0)
    ('97.7 %', '2.14 %', '< 0.01 %', '> 99.9 %')
    """
    if probability > 0.9995 - 1e-12:
        return "> 99.9 %"
    return "< 0.01 %" if probability < 5e-5 else percent(probability, 2 if probability < 0.095 else 1)


def p_value(p: float | None) -> str:
    """The p-value of a test; how far below a millionth it lies no test can tell.

    Examples
    --------
    >>> p_value(0.0213), p_value(9.9e-305), p_value(0.0), p_value(None)
    ('0.021', '< 1×10⁻⁶', '< 1×10⁻⁶', '–')
    """
    return "–" if p is None else "< 1×10⁻⁶" if p < LEAST else number(p, 2)


def grouped(count: int) -> str:
    """Count with thin spaces between thousands: ``1000000`` → 1 000 000."""
    return f"{count:,}".replace(",", "\N{NO-BREAK SPACE}")
