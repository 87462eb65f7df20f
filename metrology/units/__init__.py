"""Quantities as a person writes them, ``25.00(5) mm``, to floats in SI and back: used at the edges only.

The grammar of numbers is in `metrology.units.decimals`, the one of units in `metrology.units.grammar`; both are our
own, since general readers take ``1,02 mm`` for 102 mm and hang on powers of powers.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import isfinite

from metrology.units import decimals
from metrology.units.decimals import GOOD
from metrology.units.dimensions import NAMES, Dimension, product_text, quoted
from metrology.units.grammar import powers
from metrology.units.symbols import OFFSETS, UnitError, raised, symbols, unit_text

LARGEST = 1e75
"""Largest value in SI, and the smallest is its inverse: a fourth power, as in fits of the square, is finite still."""

__all__ = [
    "Dimension", "Quantity", "Unit", "UnitError", "convert", "dimension", "factor", "parse", "raised", "si_unit",
    "unit", "unit_text",
]  # fmt: skip


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
        """The quantity in words; angles are told from numbers, and angular frequencies from frequencies."""
        return _KINDS.get(self.si) or self.dimension.name

    def in_si(self, value: float, *, difference: bool = False) -> float:
        """Return in SI a number that is written in this unit."""
        return float(value) * float(self.factor) + (0.0 if difference else float(self.offset))


@dataclass(frozen=True)
class Quantity:
    """A quantity read from text.

    Parameters
    ----------
    value, u : float
        Value and standard uncertainty in SI; `u` is None where none is written.
    unit : str
        Unit as written, in canonical form: ``"N·s/m"``; ``"1"`` for a number.
    dimension : Dimension
    factor : float
        SI value of one unit.
    digits : int
        Decimal places of the value as written, in `unit`: 2 for ``25.00 mm``, 6 for ``1.2e-5``, −2 for ``1.2e3``.
    u_digits : int
        Likewise of the uncertainty.
    text : str
        As the user wrote it.
    """

    value: float
    u: float | None
    unit: str
    dimension: Dimension
    factor: float
    digits: int
    u_digits: int | None = None
    text: str = ""

    @property
    def resolution(self) -> float:
        """SI value of one unit in the last written place of the value."""
        return float(Fraction(10) ** -self.digits * Fraction(self.factor))


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


def parse(text: str, *, expected: str | None = None, difference: bool = False) -> Quantity:
    """Read a quantity: value, standard uncertainty where written, and unit, in SI.

    Parameters
    ----------
    text : str
        Such as ``"25.00(5) mm"``; digits in parentheses stand for the last places (JCGM 100:2008 7.2.2).
    expected : str
        A unit of the dimension that is due, such as ``"N"``; any dimension where None.
    difference : bool
        Whether a temperature in degrees Celsius is a difference (an uncertainty, a half-width): 0.5 °C is then 0.5 K.

    Returns
    -------
    Quantity
        Value and u in SI, with the unit as written.

    Raises
    ------
    UnitError
        A ValueError with what was found, what was expected, and how to fix it.

    Examples
    --------
    >>> length = parse("25.00(5) mm", expected="m")
    >>> length.value, length.u, length.unit, length.digits
    (0.025, 5e-05, 'mm', 2)
    >>> parse("3.2 kg", expected="N")
    Traceback (most recent call last):
    metrology.units.symbols.UnitError: got '3.2 kg', a mass; expected a force, such as '31.4 N'
    """
    number = decimals.read(text)
    quantity = _quantity(number, text, difference=difference)
    if expected is not None:
        _compare(unit(quantity.unit), unit(expected), text)
    return quantity


def _quantity(number: decimals.Number, text: str, *, difference: bool) -> Quantity:
    of = unit(number.unit or "1")
    if number.u is not None and number.u <= 0:
        raise UnitError(
            f"{quoted(text)}, with a standard uncertainty of zero or less",
            "one greater than zero",
            "leave it out for an exact value",
        )
    value = number.value * of.factor + (0 if difference else of.offset)
    u = None if number.u is None else number.u * _u_unit(number, of, text).factor
    sizes = [size for size in (abs(value), u, of.factor) if size]
    if max(*sizes, of.factor / Fraction(10) ** number.digits) > LARGEST:
        raise UnitError(f"{quoted(text)}, beyond 1e75 in SI", GOOD)
    if min(sizes) < 1 / LARGEST:
        raise UnitError(f"{quoted(text)}, below 1e-75 in SI", GOOD)
    scale = float(of.factor)
    return Quantity(
        float(value),
        None if u is None else float(u),
        of.text,
        of.dimension,
        scale,
        number.digits,
        number.u_digits,
        text,
    )


def _u_unit(number: decimals.Number, of: Unit, text: str) -> Unit:
    """Unit of the uncertainty, ``25.00 mm ± 50 µm``."""
    own = of if number.u_unit is None else unit(number.u_unit or "1")
    if own.dimension != of.dimension:
        raise UnitError(quoted(text), "'25.00 ± 0.05 mm' or '25.00 mm ± 0.05 mm'", "the two units do not match")
    return own


def _compare(got: Unit, due: Unit, text: str) -> None:
    """Refuse another dimension, an angle for a number, and cycles for radians per second."""
    pair = {got.si, due.si}
    mixed = pair in ({"Hz", "rad/s"}, {"1", "rad"}, {"1", "Np"}, {"Hz", "Bq"})
    if got.dimension == due.dimension and not mixed:
        return
    plain = due.name == due.dimension.name and due.dimension in NAMES
    example = NAMES[due.dimension][2] if plain else f"1.0 {due.text}"
    fix = "ω = 2π·f" if "Hz" in pair and mixed else ""
    kind = "a number without a unit" if got.text == "1" else got.name
    raise UnitError(f"{quoted(text)}, {kind}", f"{due.name}, such as '{example}'", fix)
