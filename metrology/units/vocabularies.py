r"""Units in the words of other programs: D-SI strings (``\newton\per\metre``) and identifiers of QUDT."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction

from metrology.units.grammar import powers
from metrology.units.symbols import PREFIXED

QUDT = "http://qudt.org/vocab/unit/"

#: Symbol without prefix → its word in D-SI (D-SI 2.2, the names of the SI brochure).
_WORDS = {
    "m": "metre",
    "g": "gram",
    "s": "second",
    "A": "ampere",
    "K": "kelvin",
    "mol": "mole",
    "cd": "candela",
    "rad": "radian",
    "Hz": "hertz",
    "N": "newton",
    "Pa": "pascal",
    "bar": "bar",
    "J": "joule",
    "W": "watt",
    "C": "coulomb",
    "V": "volt",
    "Ω": "ohm",
    "F": "farad",
    "H": "henry",
    "S": "siemens",
    "T": "tesla",
    "L": "litre",
    "kg": "kilogram",
    "t": "tonne",
    "min": "minute",
    "h": "hour",
    "d": "day",
    "deg": "degree",
    "°C": "degreecelsius",
    "%": "percent",
    "ppm": "ppm",
    "eV": "electronvolt",
    "Bq": "becquerel",
    "Gy": "gray",
    "lx": "lux",
    "Np": "neper",
    "dB": "decibel",
}
_PREFIXES = {"f": "femto", "p": "pico", "n": "nano", "µ": "micro", "m": "milli", "c": "centi", "d": "deci"}
_PREFIXES |= {"da": "deca", "h": "hecto", "k": "kilo", "M": "mega", "G": "giga", "T": "tera"}

#: SI unit as `units.si_unit` writes it → local name in QUDT.
_QUDT = {
    "1": "UNITLESS",
    "m": "M",
    "m^2": "M2",
    "m^3": "M3",
    "m^4": "M4",
    "kg": "KiloGM",
    "s": "SEC",
    "A": "A",
    "K": "K",
    "mol": "MOL",
    "cd": "CD",
    "rad": "RAD",
    "Hz": "HZ",
    "1/s": "PER-SEC",
    "1/m": "PER-M",
    "1/K": "PER-K",
    "rad/s": "RAD-PER-SEC",
    "m/s": "M-PER-SEC",
    "m/s^2": "M-PER-SEC2",
    "m^2/s": "M2-PER-SEC",
    "N": "N",
    "N·m": "N-M",
    "N/m": "N-PER-M",
    "N·s/m": "N-SEC-PER-M",
    "Pa": "PA",
    "Pa·s": "PA-SEC",
    "J": "J",
    "W": "W",
    "kg/m": "KiloGM-PER-M",
    "kg/m^2": "KiloGM-PER-M2",
    "kg/m^3": "KiloGM-PER-M3",
    "kg·m^2": "KiloGM-M2",
    "kg/mol": "KiloGM-PER-MOL",
    "mol/m^3": "MOL-PER-M3",
    "C": "C",
    "V": "V",
    "Ω": "OHM",
    "F": "FARAD",
    "H": "H",
    "S": "S",
    "T": "T",
}


def dsi(unit: str) -> str:
    r"""Return the D-SI string of a unit; nothing for a symbol that D-SI has no word for.

    One unit below the line is written with ``\per``, several as negative powers: readers differ on how far a ``\per``
    reaches.

    Parameters
    ----------
    unit : str
        As `metrology.units` reads it.

    Returns
    -------
    str
        Such as ``\newton\per\metre``.

    Examples
    --------
    >>> print(dsi("N/m"), dsi("N·s/m"), dsi("mm^2"), dsi("W/(m·K)"), dsi("1"))
    \newton\per\metre \newton\second\per\metre \milli\metre\tothe{2} \watt\metre\tothe{-1}\kelvin\tothe{-1} \one
    """
    written = powers(unit)
    below = [symbol for symbol, power in written.items() if power < 0]
    slash = len(below) == 1 and len(written) > 1
    parts = [_factor(symbol, power) for symbol, power in written.items() if not (slash and power < 0)]
    if slash:
        parts.append(_factor(below[0], -written[below[0]], before=r"\per"))
    return "".join(parts) if parts and all(parts) else "" if parts else r"\one"


def _factor(symbol: str, power: Fraction, before: str = "") -> str:
    word = _word(symbol)
    if not word:
        return ""
    exponent = "" if power == 1 else rf"\tothe{{{power if power.denominator == 1 else float(power)}}}"
    return f"{before}{word}{exponent}"


def _word(symbol: str) -> str:
    if symbol in _WORDS:
        return f"\\{_WORDS[symbol]}"
    found = [p for p in _PREFIXES if symbol.startswith(p) and symbol.removeprefix(p) in _WORDS.keys() & PREFIXED]
    return f"\\{_PREFIXES[found[0]]}\\{_WORDS[symbol.removeprefix(found[0])]}" if found else ""


def from_dsi(text: str) -> str:
    r"""Return the unit of a D-SI string as `metrology.units` reads it; nothing for a word that is not known.

    A ``\per`` puts the one unit after it below the line (D-SI 2.2).

    Parameters
    ----------
    text : str
        A D-SI string.

    Returns
    -------
    str
        Such as ``"N/m"``.

    Examples
    --------
    >>> print(from_dsi(r"\milli\metre"), from_dsi(r"\newton\per\metre\tothe{2}"), from_dsi(r"\one"))
    mm N/m^2 1
    """
    symbols = {word: symbol for symbol, word in _WORDS.items()}
    prefixes = {word: prefix for prefix, word in _PREFIXES.items()}
    parts, prefix, sign = list[tuple[str, int]](), "", 1
    if re.sub(r"\\[a-z]+(?:\{[^{}]*\})?", "", text.strip()):
        return ""
    for word, power in re.findall(r"\\([a-z]+)(?:\{([^{}]*)\})?", text):
        if word == "per":
            sign = -1
        elif word == "tothe" and parts and re.fullmatch(r"-?\d{1,2}", power):
            parts[-1] = (parts[-1][0], parts[-1][1] * int(power))
        elif word in prefixes and not prefix:
            prefix = prefixes[word]
        elif word in symbols:
            parts.append((prefix + symbols[word], sign))
            prefix, sign = "", 1
        elif word != "one":
            return ""
    return _product(parts) if not prefix and sign == 1 else ""


def _product(parts: Sequence[tuple[str, int]]) -> str:
    above = [_power(symbol, power) for symbol, power in parts if power > 0]
    below = [_power(symbol, -power) for symbol, power in parts if power < 0]
    under = f"({'·'.join(below)})" if len(below) > 1 else "".join(below)
    return f"{'·'.join(above) or '1'}{f'/{under}' if below else ''}"


def _power(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}^{power}"


def qudt(unit: str) -> str:
    """Return the QUDT identifier of a coherent SI unit; nothing for one that is not in the table.

    Parameters
    ----------
    unit : str
        Such as ``"N/m"``.

    Returns
    -------
    str
        An IRI.

    Examples
    --------
    >>> qudt("N/m")
    'http://qudt.org/vocab/unit/N-PER-M'
    """
    return QUDT + _QUDT[unit] if unit in _QUDT else ""
