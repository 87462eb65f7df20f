"""Decimal numbers with their uncertainty and the text of their unit, as a person writes them, read exactly.

Grammar, strict, everything else is refused with a sentence::

    quantity := number [unit] | number(digits)[e±n] [unit]     digits: those of the last places (JCGM 100 7.2.2)
              | number ± number unit | (number ± number)[e±n] [unit] | number unit ± number unit
    number   := [sign] digits [. digits] [e [sign] digits]     a point is the decimal mark, nothing groups digits

``±`` is written ``+/-`` and ``+-`` as well; what follows it is a *standard* uncertainty, greater than zero. The grammar
of units is in `metrology.units.grammar`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from fractions import Fraction

from metrology.units.dimensions import quoted
from metrology.units.grammar import MAX_LENGTH
from metrology.units.symbols import CHARACTERS, UnitError

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)"
_EXPONENT = r"(?:[eE](?P<exponent>[+-]?[0-9]{1,3})(?![0-9]))?"
_SHORTHAND = re.compile(rf"(?P<value>{_NUMBER})(?:\((?P<u>[0-9]+(?:\.[0-9]+)?)\))?{_EXPONENT}(?P<unit>.*)", re.DOTALL)
_JOINT = re.compile(rf"\((?P<inside>[^()]*)\)\s*{_EXPONENT}(?P<unit>.*)", re.DOTALL)
GOOD = "a number with a unit, such as '25.00 mm', '25.00(5) mm' or '25.00 ± 0.05 mm'"


@dataclass(frozen=True)
class Number:
    """Exact value of a decimal number, its decimal places and its unit text; `u_unit` is None unless written."""

    value: Fraction
    digits: int
    unit: str
    u: Fraction | None = None
    u_digits: int | None = None
    u_unit: str | None = None


def read(text: str) -> Number:
    """Number, uncertainty and unit texts of a quantity.

    Raises
    ------
    UnitError
        With what was found, what was expected, and how to fix it.
    """
    written = _checked(text)
    return _plus_minus(written) if "±" in written else _number(written)


def _checked(text: str) -> str:
    if not isinstance(text, str):
        raise UnitError(f"{quoted(text)}, not a text", GOOD)
    if len(text) > MAX_LENGTH:
        raise UnitError(f"{quoted(text)} of {len(text)} characters", f"a quantity of at most {MAX_LENGTH} characters")
    written = re.sub(r"(?<=.)\+/?-", "±", text.translate(CHARACTERS).strip())
    for pattern, fix in _TRAPS.items():
        if re.search(pattern, written):
            raise UnitError(quoted(text), GOOD, fix, pointed(text))
    return written


_COMMAS = re.compile(r"(?<![\d.,])(?:0,[0-9]+|[1-9][0-9]*,(?:[0-9]{1,2}|[0-9]{4,}))(?![\d.,])")
"""Numbers whose comma can only be the decimal mark: in '1,234' it may group the digits."""


def pointed(text: str) -> tuple[str, str] | None:
    """A quantity with decimal commas, and the same with points; None where a comma may group digits.

    Parameters
    ----------
    text : str
        As a campaign file states it.

    Returns
    -------
    tuple of str or None
        The quantity as stated, and with points.

    Examples
    --------
    >>> pointed("25,00(5) mm"), pointed("1,234 mm")
    (('25,00(5) mm', '25.00(5) mm'), None)
    """
    new = _COMMAS.sub(lambda found: found[0].replace(",", "."), text)
    return None if "," in new or new == text else (text, new)


_TRAPS = {
    r"^$": "it is empty",
    r",": "the decimal mark is a point, and nothing groups the digits",
    r"_": "digits are written without underscores",
    r"^[+-]\s*[+-]": "one sign at most",
    r"(?i)^[+-]?\s*(?:nan|inf)": "only finite numbers are quantities; leave a missing one out",
    r"^[+-]?(?:[0-9]+\.[0-9]*|[0-9]*\.?[0-9]+)\s+[0-9]+(?:\.[0-9]+)?(?:\s|$)": "digits are written without spaces",
    r"×\s*10": "write powers of ten as '1.2e-5'",
    r"(?s)±.*±": "one uncertainty at most",
    r"^[+-]?[0-9.]+\s+\([0-9.]+\)": "no space stands before the parenthesis",
    r"^[+-]?[0-9.]+[eE][+-]?[0-9]+\(": "the power of ten stands behind the parenthesis, '1.15(12)e-5 1/K'",
}


def _number(text: str) -> Number:
    match = _SHORTHAND.fullmatch(text)
    if match is None:
        raise UnitError(quoted(text), GOOD)
    digits = _places(match["value"]) - int(match["exponent"] or 0)
    scale = Fraction(10) ** int(match["exponent"] or 0)
    plain = Number(Fraction(match["value"]) * scale, digits, match["unit"].strip())
    if match["u"] is None:
        return plain
    in_place = "." not in match["u"]
    u_digits = digits if in_place else _places(match["u"]) - int(match["exponent"] or 0)
    u = Fraction(match["u"]) * (Fraction(10) ** -digits if in_place else scale)
    return Number(plain.value, digits, plain.unit, u, u_digits)


def _places(number: str) -> int:
    return len(number.partition(".")[2])


def _plus_minus(text: str) -> Number:
    joint = _JOINT.fullmatch(text)
    if joint and "±" not in joint["inside"]:
        raise UnitError(quoted(text), GOOD)
    value, u = (_number(part.strip()) for part in (joint["inside"] if joint else text).split("±"))
    if value.u is not None or u.u is not None:
        raise UnitError(quoted(text), GOOD, "one uncertainty at most")
    if joint is None:
        return _apart(value, u, text)
    if value.unit or u.unit:
        raise UnitError(quoted(text), "'(25.00 ± 0.05) mm'", "the unit stands once, after the parenthesis")
    exponent = int(joint["exponent"] or 0)
    scale = Fraction(10) ** exponent
    scaled = Number(value.value * scale, value.digits - exponent, joint["unit"].strip())
    return replace(scaled, u=u.value * scale, u_digits=u.digits - exponent)


def _apart(value: Number, u: Number, text: str) -> Number:
    """``25.00 ± 0.05 mm`` and ``25.00 mm ± 50 µm``; a percentage behind ± could be absolute or relative."""
    if "%" in u.unit and value.unit != u.unit:
        raise UnitError(
            f"{quoted(text)}, which may mean a relative uncertainty or one in percent",
            "'(14.0 ± 0.2) %' or '14.0(2) %' for both in percent, '25.00 ± 0.05 mm' for a length",
        )
    own = u.unit if value.unit else None
    return Number(value.value, value.digits, value.unit or u.unit, u.value, None if own else u.digits, own)
