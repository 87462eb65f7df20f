"""Quantities as a person writes them, ``25.00(5) mm``, to floats in SI and back: used at the edges only.

The grammar of numbers is in `metrology.units.decimals`, the one of units in `metrology.units.grammar`; both are our
own, since general readers take ``1,02 mm`` for 102 mm and hang on powers of powers.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from metrology.units import decimals
from metrology.units.conversion import Unit, convert, dimension, factor, si_unit, unit
from metrology.units.decimals import GOOD
from metrology.units.dimensions import NAMES, Dimension, quoted
from metrology.units.symbols import UnitError, raised, unit_text

LARGEST = 1e75
"""Largest value in SI, and the smallest is its inverse: a fourth power, as in fits of the square, is finite still."""

__all__ = [
    "Dimension", "Quantity", "Unit", "UnitError", "convert", "dimension", "factor", "parse", "raised", "si_unit",
    "unit", "unit_text",
]  # fmt: skip


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
