"""The grammar of units: products of powers of symbols.

::

    unit   := term {("*" | "·" | "." | " " | "/") term}      no product after a solidus without parentheses
    term   := symbol [power] | "1" | "(" unit ")" [power]
    power  := ("^" | "**") integer | superscript digits       ``m^2``, ``m**2``, ``m²``, ``mm2``
"""

from __future__ import annotations

import re
from fractions import Fraction

from metrology.units.dimensions import NAMES, quoted
from metrology.units.symbols import CHARACTERS, UnitError, symbols

MAX_LENGTH = 100
MAX_POWER = 12

Powers = dict[str, Fraction]
_SUPERSCRIPTS = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")


_POWER = r"(?:\*\*|\^)\s*(?:\(\s*[+-]?[0-9]{1,3}(?:/[1-9][0-9]?)?\s*\)|[+-]?[0-9]{1,3})|[⁺⁻]?[⁰¹²³⁴-⁹]{1,3}"
_TOKEN = re.compile(
    rf"\s*(?:(?P<power>{_POWER})|(?P<sign>[*·⋅×./()])|(?P<symbol>°[CF]?|%|‰|[^\W\d_⁰¹²³⁴-⁹]+)(?P<bare>[2-9]?)|(?P<one>1)(?![0-9.]))"
)


class _UnitReader:
    """Recursive descent over the tokens of one unit text."""

    def __init__(self, text: str) -> None:
        self.text, self.position, self.depth = text, 0, 0

    def read(self) -> Powers:
        powers = self._product()
        if self.position < len(self.text.rstrip()):
            raise self._refusal()
        return powers

    def _refusal(self, fix: str = "") -> UnitError:
        return UnitError(f"the unit {quoted(self.text)}", "a unit such as 'mm', 'N·s/m' or 'kg/m^3'", fix)

    def _peek(self, group: str) -> re.Match[str] | None:
        match = _TOKEN.match(self.text, self.position)
        return match if match and match[group] else None

    def _product(self) -> Powers:
        powers, divided = self._term(), False
        while (times := self._operator()) is not None:
            if divided and times > 0:
                raise self._refusal("a product after a solidus is ambiguous; write 'W/(m·K)' or 'W·K/m'")
            divided = divided or times < 0
            for symbol, power in self._term().items():
                powers[symbol] = powers.get(symbol, Fraction(0)) + times * power
        return powers

    def _operator(self) -> int | None:
        """+1 for a product, −1 for a quotient, None at the end; a space between two terms is a product."""
        if sign := self._peek("sign"):
            if sign["sign"] == ")":
                return None
            if sign["sign"] != "(":
                self.position = sign.end()
                return -1 if sign["sign"] == "/" else 1
        ahead = _TOKEN.match(self.text, self.position)
        if ahead is None or ahead["power"]:
            return None
        return 1 if self.text[self.position].isspace() else None

    def _term(self) -> Powers:
        token = _TOKEN.match(self.text, self.position)
        if token is None or token["power"] or token["sign"] not in (None, "("):
            raise self._refusal()
        self.position = token.end()
        if token["one"]:
            return {}
        if token["sign"]:
            powers = self._parenthesis()
        else:
            powers = {_canonical(token["symbol"], self): Fraction(int(token["bare"] or 1))}
            if token["bare"]:
                return powers
        power = self._power()
        return {symbol: exponent * power for symbol, exponent in powers.items()}

    def _parenthesis(self) -> Powers:
        self.depth += 1
        if self.depth > 5:
            raise self._refusal("at most 5 parentheses within one another")
        powers = self._product()
        closing = self._peek("sign")
        if closing is None or closing["sign"] != ")":
            raise self._refusal("a parenthesis is not closed")
        self.position, self.depth = closing.end(), self.depth - 1
        return powers

    def _power(self) -> Fraction:
        token = self._peek("power")
        if token is None:
            return Fraction(1)
        self.position = token.end()
        numerator, _, denominator = re.sub(r"[\s*^()]", "", token["power"].translate(_SUPERSCRIPTS)).partition("/")
        power = Fraction(int(numerator), int(denominator or 1))
        if abs(power) > MAX_POWER:
            raise self._refusal(f"powers lie between -{MAX_POWER} and {MAX_POWER}")
        return power


def _canonical(symbol: str, reader: _UnitReader) -> str:
    table = symbols()
    if symbol in table:
        return table[symbol][0]
    near = sorted({other for other in table if other.casefold() == symbol.casefold()})
    case = "case counts; " if near else ""
    for at in range(1, len(symbol)):
        first, second = symbol[:at], symbol[at:]
        if {first, second} <= table.keys() and table[first][1][2] * table[second][1][2] in NAMES:
            near.append(f"{first}*{second}")
    fix = f"{case}did you mean {' or '.join(repr(other) for other in near)}?" if near else ""
    raise UnitError(
        f"{quoted(symbol)} in the unit {quoted(reader.text)}",
        "a symbol of a unit, such as 'mm' or 'kN'",
        fix,
        (symbol, near[0]) if len(near) == 1 else None,
    )


def powers(text: str) -> Powers:
    """Canonical symbols of a unit text with their exponents, in the order written; a unit that cancels is left out.

    Raises
    ------
    UnitError
        With the symbol that is not known, or the ambiguity.
    """
    written = text.translate(CHARACTERS).strip()
    if not 0 < len(written) <= MAX_LENGTH:
        raise UnitError(f"the unit {quoted(text)}", f"a unit such as 'mm', of at most {MAX_LENGTH} characters")
    found = {symbol: power for symbol, power in _UnitReader(written).read().items() if power}
    if any(abs(power) > MAX_POWER for power in found.values()):
        raise UnitError(f"the unit {quoted(text)}", f"powers between -{MAX_POWER} and {MAX_POWER}")
    return found
