"""Dimensions of quantities: seven exponents of the base quantities of the SI, with the names that a person uses."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from metrology.errors import Fault

_BASE = ("m", "kg", "s", "A", "K", "mol", "cd")


class TextError(ValueError):
    """A text that cannot be read: what was found, what would have been right, and how to fix it.

    Parameters
    ----------
    got : str
        What was found, quoted as the user wrote it.
    expected : str
        What would have been right, with an example.
    fix : str
        How to put it right, where that is not plain from `expected`.
    swap : (str, str), optional
        The part of the text that is wrong and what it has to be, where that is certain and no value changes by it.
    """

    def __init__(self, got: str, expected: str, fix: str = "", swap: tuple[str, str] | None = None) -> None:
        super().__init__(f"got {got}; expected {expected}" + (f". Fix: {fix}" if fix else ""))
        self.got, self.expected, self.fix, self.swap = got, expected, fix, swap

    def fault(self, where: str) -> Fault:
        """The same as a fault at a place in a file."""
        return Fault(where, self.got, self.expected, self.fix)


def quoted(text: object) -> str:
    """The text in quotes, cut where it is too long to print.

    Parameters
    ----------
    text : object
        Anything; what is no text is shown by its ``repr``.

    Returns
    -------
    str
        In quotes, some 60 characters at most.
    """
    written = text if isinstance(text, str) else repr(text)
    return repr(written if len(written) <= 60 else written[:57] + "...")


@dataclass(frozen=True)
class Dimension:
    """Product of powers of the base quantities, L^a M^b T^c I^d Θ^e N^f J^g (ISO 80000-1, 5).

    Parameters
    ----------
    exponents : tuple of 7 Fraction
        Of length, mass, time, electric current, temperature, amount of substance and luminous intensity.

    Examples
    --------
    >>> force = Dimension.of(m=1, kg=1, s=-2)
    >>> (force / Dimension.of(m=1)).name
    'a stiffness'
    """

    exponents: tuple[Fraction, ...] = (Fraction(0),) * 7

    @classmethod
    def of(cls, **powers: int | Fraction) -> Dimension:
        """Dimension by the powers of ``m, kg, s, A, K, mol, cd``."""
        return cls(tuple(Fraction(powers.get(unit, 0)) for unit in _BASE))

    @property
    def dimensionless(self) -> bool:
        """Whether all exponents are zero."""
        return not any(self.exponents)

    @property
    def powers(self) -> dict[str, Fraction]:
        """Base units with their exponents, without those that are zero."""
        return {unit: power for unit, power in zip(_BASE, self.exponents, strict=True) if power}

    @property
    def name(self) -> str:
        """The quantity in words, such as ``"a mass"``; else the product of base units."""
        return NAMES[self][0] if self in NAMES else f"a quantity in {product_text(self.powers)}"

    def __mul__(self, other: Dimension) -> Dimension:
        return Dimension(tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __truediv__(self, other: Dimension) -> Dimension:
        return Dimension(tuple(a - b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __pow__(self, power: int | Fraction) -> Dimension:
        return Dimension(tuple(a * power for a in self.exponents))


def product_text(powers: dict[str, Fraction]) -> str:
    """Product of units written out: ``N·s/m``, ``W/(m·K)``, ``1/K``, ``m^(1/2)``, ``1``."""
    above = [_power_text(unit, power) for unit, power in powers.items() if power > 0]
    below = [_power_text(unit, -power) for unit, power in powers.items() if power < 0]
    tail = f"/({'·'.join(below)})" if len(below) > 1 else f"/{below[0]}" if below else ""
    return ("·".join(above) or "1") + tail


def _power_text(unit: str, power: Fraction) -> str:
    if power == 1:
        return unit
    return f"{unit}^{power}" if power.denominator == 1 else f"{unit}^({power})"


_of = Dimension.of

#: Name in words, coherent SI unit, and an example of a dimension.
NAMES: dict[Dimension, tuple[str, str, str]] = {
    _of(): ("a number", "1", "0.14"),
    _of(m=1): ("a length", "m", "25.00 mm"),
    _of(m=2): ("an area", "m^2", "1.25 mm^2"),
    _of(m=3): ("a volume", "m^3", "10.0 mL"),
    _of(m=4): ("a second moment of area", "m^4", "52.1 mm^4"),
    _of(kg=1): ("a mass", "kg", "2.000 kg"),
    _of(s=1): ("a time", "s", "0.25 s"),
    _of(A=1): ("an electric current", "A", "19.6 mA"),
    _of(K=1): ("a temperature", "K", "21.3 degC"),
    _of(mol=1): ("an amount of substance", "mol", "0.10 mol"),
    _of(cd=1): ("a luminous intensity", "cd", "1.0 cd"),
    _of(m=1, s=-1): ("a speed", "m/s", "0.12 m/s"),
    _of(m=2, s=-2): ("a specific energy", "J/kg", "1.0 J/kg"),
    _of(m=-2, cd=1): ("an illuminance or a luminance", "cd/m^2", "500 lx"),
    _of(m=1, s=-2): ("an acceleration", "m/s^2", "9.806 m/s^2"),
    _of(s=-1): ("a frequency or a rate", "1/s", "12.5 Hz"),
    _of(s=-2): ("an angular acceleration", "1/s^2", "1.0 rad/s^2"),
    _of(kg=1, m=1, s=-2): ("a force", "N", "31.4 N"),
    _of(kg=1, m=1, s=-1): ("a momentum", "kg·m/s", "0.5 N·s"),
    _of(kg=1, s=-2): ("a stiffness", "N/m", "24.7 kN/m"),
    _of(kg=1, s=-1): ("a damping coefficient", "N·s/m", "0.37 N·s/m"),
    _of(kg=1, m=-1, s=-2): ("a pressure or a modulus", "Pa", "59.2 GPa"),
    _of(kg=1, m=-1, s=-1): ("a dynamic viscosity", "Pa·s", "1.0 mPa·s"),
    _of(m=2, s=-1): ("a diffusivity or a kinematic viscosity", "m^2/s", "13.6 mm^2/s"),
    _of(kg=1, m=-1): ("a linear density", "kg/m", "3.4 g/m"),
    _of(kg=1, m=-2): ("an area density", "kg/m^2", "0.14 kg/m^2"),
    _of(kg=1, m=-3): ("a density", "kg/m^3", "8000 kg/m^3"),
    _of(kg=1, m=2): ("a moment of inertia", "kg·m^2", "1.0 kg·m^2"),
    _of(kg=1, m=2, s=-2): ("an energy or a moment of force", "J", "1.5 N·m"),
    _of(kg=1, m=2, s=-3): ("a power", "W", "1.5 W"),
    _of(m=-1): ("a quantity per length", "1/m", "1.0 1/m"),
    _of(K=-1): ("a quantity per temperature", "1/K", "1.15e-5 1/K"),
    _of(A=1, s=1): ("an electric charge", "C", "1.0 C"),
    _of(kg=1, m=2, s=-3, A=-1): ("a voltage", "V", "4.999 V"),
    _of(kg=1, m=2, s=-3, A=-2): ("an electric resistance", "Ω", "127.7 ohm"),
    _of(kg=-1, m=-2, s=4, A=2): ("a capacitance", "F", "1.0 nF"),
    _of(kg=1, m=2, s=-2, A=-2): ("an inductance", "H", "1.0 mH"),
    _of(kg=-1, m=-2, s=3, A=2): ("an electric conductance", "S", "1.0 mS"),
    _of(kg=1, s=-2, A=-1): ("a magnetic flux density", "T", "1.0 mT"),
    _of(mol=1, m=-3): ("a concentration", "mol/m^3", "0.101 mol/L"),
    _of(kg=1, mol=-1): ("a molar mass", "kg/mol", "36.5 g/mol"),
    _of(m=1, kg=-1, s=2): ("a compliance per area", "1/Pa", "1.0 1/GPa"),
    _of(kg=-1, s=2): ("a compliance", "m/N", "0.04 mm/N"),
}
