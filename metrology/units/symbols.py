"""The symbols of units that a mechanical laboratory writes, and the grammar of products of their powers.

::

    unit   := term {("*" | "·" | "." | " " | "/") term}      no product after a solidus without parentheses
    term   := symbol [power] | "1" | "(" unit ")" [power]
    power  := ("^" | "**") integer | superscript digits       ``m^2``, ``m**2``, ``m²``, ``mm2``
"""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from math import log, pi

from metrology.units.dimensions import NAMES, Dimension, TextError, quoted

MAX_LENGTH = 100
MAX_POWER = 12

Powers = dict[str, Fraction]


class UnitError(TextError):
    """A quantity or a unit that cannot be read, or one of the wrong dimension."""


_of = Dimension.of
Row = tuple[dict[str, int], Fraction, Dimension]

_PREFIXES = {"f": -15, "p": -12, "n": -9, "u": -6, "µ": -6, "m": -3, "c": -2, "d": -1, "": 0}
_PREFIXES |= {"da": 1, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12}


def _row(dimension: Dimension, factor: str | Fraction = "1", **si: int) -> Row:
    return si, Fraction(factor), dimension


_FORCE, _PRESSURE, _ENERGY = _of(kg=1, m=1, s=-2), _of(kg=1, m=-1, s=-2), _of(kg=1, m=2, s=-2)

#: Symbols that take a prefix: coherent SI unit, factor, dimension.
PREFIXED: dict[str, Row] = {
    "m": _row(_of(m=1), m=1),
    "g": _row(_of(kg=1), "0.001", kg=1),
    "s": _row(_of(s=1), s=1),
    "A": _row(_of(A=1), A=1),
    "K": _row(_of(K=1), K=1),
    "mol": _row(_of(mol=1), mol=1),
    "rad": _row(_of(), rad=1),
    "Hz": _row(_of(s=-1), Hz=1),
    "N": _row(_FORCE, N=1),
    "Pa": _row(_PRESSURE, Pa=1),
    "bar": _row(_PRESSURE, "100000", Pa=1),
    "J": _row(_ENERGY, J=1),
    "W": _row(_of(kg=1, m=2, s=-3), W=1),
    "C": _row(_of(A=1, s=1), C=1),
    "V": _row(_of(kg=1, m=2, s=-3, A=-1), V=1),
    "Ω": _row(_of(kg=1, m=2, s=-3, A=-2), Ω=1),
    "F": _row(_of(kg=-1, m=-2, s=4, A=2), F=1),
    "H": _row(_of(kg=1, m=2, s=-2, A=-2), H=1),
    "S": _row(_of(kg=-1, m=-2, s=3, A=2), S=1),
    "T": _row(_of(kg=1, s=-2, A=-1), T=1),
    "L": _row(_of(m=3), "0.001", m=3),
    "eV": _row(_ENERGY, "1.602176634e-19", J=1),
    "Bq": _row(_of(s=-1), Bq=1),
    "Gy": _row(_of(m=2, s=-2), Gy=1),
    "lx": _row(_of(cd=1, m=-2), lx=1),
    "tex": _row(_of(kg=1, m=-1), "1e-6", kg=1, m=-1),
}
_POUND, _FREE_FALL, _INCH = Fraction("0.45359237"), Fraction("9.80665"), Fraction("0.0254")
_PSI = _POUND * _FREE_FALL / _INCH**2
_ALONE: dict[str, Row] = {
    "cd": _row(_of(cd=1), cd=1),
    "t": _row(_of(kg=1), "1000", kg=1),
    "min": _row(_of(s=1), "60", s=1),
    "h": _row(_of(s=1), "3600", s=1),
    "d": _row(_of(s=1), "86400", s=1),
    "deg": _row(_of(), Fraction(pi) / 180, rad=1),
    "°C": _row(_of(K=1), K=1),
    "%": _row(_of(), "0.01"),
    "‰": _row(_of(), "0.001"),
    "ppm": _row(_of(), "1e-6"),
    "ppb": _row(_of(), "1e-9"),
    "in": _row(_of(m=1), _INCH, m=1),
    "ft": _row(_of(m=1), "0.3048", m=1),
    "thou": _row(_of(m=1), _INCH / 1000, m=1),
    "lb": _row(_of(kg=1), _POUND, kg=1),
    "lbf": _row(_FORCE, _POUND * _FREE_FALL, N=1),
    "kip": _row(_FORCE, 1000 * _POUND * _FREE_FALL, N=1),
    "kgf": _row(_FORCE, _FREE_FALL, N=1),
    "dyn": _row(_FORCE, "1e-5", N=1),
    "gn": _row(_of(m=1, s=-2), _FREE_FALL, m=1, s=-2),
    "psi": _row(_PRESSURE, _PSI, Pa=1),
    "ksi": _row(_PRESSURE, 1000 * _PSI, Pa=1),
    "mmHg": _row(_PRESSURE, "133.322387415", Pa=1),
    "atm": _row(_PRESSURE, "101325", Pa=1),
    "°F": _row(_of(K=1), Fraction(5, 9), K=1),
    "rpm": _row(_of(s=-1), Fraction(1, 60), Hz=1),
    "den": _row(_of(kg=1, m=-1), Fraction(1, 9_000_000), kg=1, m=-1),
    "Np": _row(_of(), Np=1),
    "dB": _row(_of(), Fraction(log(10)) / 20, Np=1),
}
"""`gn`: standard acceleration of free fall, as `g` is the gram; `rpm`: revolutions, not radians; `dB`: level of a field
quantity, (ln 10)/20 Np (SI brochure, table 8)."""
OFFSETS = {"°C": Fraction("273.15"), "°F": Fraction("459.67") * 5 / 9}
"""Zero of a scale of temperature / K."""
_SPELLINGS = {
    "ohm": "Ω",
    "l": "L",
    "°": "deg",
    "degC": "°C",
    "degF": "°F",
    "mil": "thou",
    "denier": "den",
    "klbf": "kip",
}
CHARACTERS = str.maketrans(
    {
        "−": "-",
        "μ": "µ",
        "Ω": "Ω",
        "℃": "°C",
        "℉": "°F",
        "\N{NO-BREAK SPACE}": " ",
        "\N{THIN SPACE}": " ",
        "\u202f": " ",
    }
)
_SUPERSCRIPTS = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")


@cache
def symbols() -> dict[str, tuple[str, Row]]:
    """Every symbol that may be written, with its canonical spelling and its row."""
    table = {symbol: (symbol, row) for symbol, row in _ALONE.items()}
    for stem, (si, factor, dimension) in PREFIXED.items():
        for prefix, exponent in _PREFIXES.items():
            canonical = prefix.replace("u", "µ") + stem
            table.setdefault(prefix + stem, (canonical, (si, factor * Fraction(10) ** exponent, dimension)))
    for spelling, symbol in _SPELLINGS.items():
        prefixes = _PREFIXES if symbol in PREFIXED else ("",)
        table |= {prefix + spelling: table[prefix + symbol] for prefix in prefixes}
    return table


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


_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_WORD = re.compile(r"[^\W\d_]+|°\w?")
_POWERS = re.compile(r"\^(-?\d+)")


def unit_text(unit: str) -> str:
    """Unit for the eye, however it was typed; nothing for a number.

    Parameters
    ----------
    unit : str
        As typed: ``'um'``, ``'m^2'``, ``'degC'``.

    Returns
    -------
    str
        With Greek letters, raised powers and dots; empty for ``'1'``.

    Examples
    --------
    >>> [unit_text(one) for one in ("kg/m^3", "um", "degC", "deg", "N*s/m", "1")]
    ['kg/m³', 'µm', '°C', '°', 'N·s/m', '']
    """
    if unit == "1":
        return ""
    text = unit.replace("**", "^").replace("*", "·")
    text = _WORD.sub(lambda found: {"deg": "°"}.get(one := _symbol(found[0]), one), text)
    return _POWERS.sub(lambda found: raised(found[1]), text)


def raised(number: str) -> str:
    """A whole number as an exponent.

    Parameters
    ----------
    number : str
        Its digits: ``'-3'``.

    Returns
    -------
    str
        Raised: ``'⁻³'``.
    """
    return number.translate(_SUPERSCRIPT)


def _symbol(text: str) -> str:
    return symbols().get(text, (text,))[0]


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
