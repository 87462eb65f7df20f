"""The symbols of units that a mechanical laboratory writes, with their prefixes, and units for the eye."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from math import log, pi

from metrology.units.dimensions import Dimension, TextError


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
    "gf": _row(_FORCE, _FREE_FALL / 1000, N=1),
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
