"""Units by their text: factor, offset and dimension, the coherent SI unit, and values from SI into a unit."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import isfinite

from metrology.units.dimensions import NAMES, Dimension, product_text
from metrology.units.grammar import powers
from metrology.units.symbols import OFFSETS, symbols


@dataclass(frozen=True)
class Unit:
    """A unit: its canonical text, the coherent SI unit that stands for it, and the way between the two.

    ``SI value = factor · value + offset``; the offset belongs to a lone degree Celsius or Fahrenheit, and
    differences leave it out.
    """

    text: str
    si: str
    factor: Fraction
    dimension: Dimension
    offset: Fraction = Fraction(0)

    @property
    def name(self) -> str:
        """The quantity in words; angles are distinguished from numbers, and angular frequencies from frequencies."""
        return _KINDS.get(self.si) or self.dimension.name

    def in_si(self, value: float, *, difference: bool = False) -> float:
        """Return in SI a number that is written in this unit."""
        return float(value) * float(self.factor) + (0.0 if difference else float(self.offset))


_KINDS = {
    "Hz": "a frequency",
    "Bq": "an activity",
    "Np": "a level",
    "rad": "an angle",
    "rad/s": "an angular frequency",
    "rad/s^2": "an angular acceleration",
}


@lru_cache(maxsize=4096)
def unit(text: str) -> Unit:
    """Read the text of a unit.

    Parameters
    ----------
    text : str
        Such as ``"N/m"``, ``"N·s/m"``, ``"kg/m^3"``, ``"mm²"``, ``"1/K"``; ``"1"`` for a number.

    Returns
    -------
    Unit
        Factor and offset to SI, dimension, and the SI unit as text.

    Raises
    ------
    UnitError
        With the symbol that is not known, or the ambiguity.

    Examples
    --------
    >>> unit("kN/mm").si, float(unit("kN/mm").factor)
    ('N/m', 1000000.0)
    """
    factor, dimension, si = Fraction(1), Dimension(), dict[str, Fraction]()
    written = powers(text)
    # Numerator first, as the canonical text has it: the SI unit must not depend on which of the two is read.
    for symbol, power in sorted(written.items(), key=lambda item: item[1] < 0):
        parts, size, base = symbols()[symbol][1]
        factor *= size**power.numerator if power.denominator == 1 else Fraction(float(size) ** float(power))
        dimension *= base**power
        for part, exponent in parts.items():
            si[part] = si.get(part, Fraction(0)) + exponent * power
    canonical = product_text(written)
    offset = OFFSETS.get(canonical, Fraction(0))
    return Unit(canonical, product_text({part: p for part, p in si.items() if p}), factor, dimension, offset)


def dimension(text: str) -> Dimension:
    """Dimension of a unit.

    Parameters
    ----------
    text : str
        Such as ``"kN/mm"``.

    Returns
    -------
    Dimension
        Powers of the base units.

    Raises
    ------
    UnitError
        A unit that is not known.
    """
    return unit(text).dimension


def factor(text: str) -> float:
    """SI value of one unit (of a difference of one, for degrees Celsius and Fahrenheit).

    Parameters
    ----------
    text : str
        Such as ``"kN/mm"``.

    Returns
    -------
    float
        In coherent SI units.

    Raises
    ------
    UnitError
        A unit that is not known.
    """
    return float(unit(text).factor)


def si_unit(of: Dimension | str) -> str:
    """Coherent SI unit of a dimension, or of a unit whose symbols are kept.

    Parameters
    ----------
    of : Dimension or str
        A dimension, or a unit.

    Returns
    -------
    str
        Such as ``"N/m"``; ``"1"`` without a dimension.

    Examples
    --------
    >>> si_unit("kN/mm"), si_unit("deg/s"), si_unit("%"), si_unit(dimension("GPa"))
    ('N/m', 'rad/s', '1', 'Pa')
    """
    if isinstance(of, str):
        return unit(of).si
    return NAMES[of][1] if of in NAMES else product_text(of.powers)


def convert(value: float, text: str, *, difference: bool = False) -> float:
    """Value in SI expressed in a unit: ``(value − offset) / factor``; without offset for a difference.

    Parameters
    ----------
    value : float
        In SI.
    text : str
        The unit wanted.
    difference : bool
        Whether a temperature is a difference, which has no offset.

    Returns
    -------
    float
        In that unit.

    Raises
    ------
    UnitError
        A unit that is not known.

    Examples
    --------
    >>> convert(293.15, "degC"), convert(0.5, "degC", difference=True), convert(59.16e9, "GPa")
    (20.0, 0.5, 59.16)
    """
    to = unit(text)
    if not isfinite(value):
        return value
    return float((Fraction(repr(float(value))) - (0 if difference else to.offset)) / to.factor)
