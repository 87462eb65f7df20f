"""A sample under test: area of its section, mass per length, and modulus from stiffness.

Every function serves floats, arrays of draws and ``uncertainties`` variables alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi
from typing import Any

from metrology.errors import Fault, MetrologyError
from metrology.gum.evaluation import Measurand


def round_area(diameter: Any) -> Any:
    """Area of a round section in m²: A = π·d²/4; null at d = 0.

    Parameters
    ----------
    diameter : quantity
        In m. Source: geometry.

    Examples
    --------
    >>> f"{1e6 * round_area(0.3e-3):.4f} mm²"
    '0.0707 mm²'
    """
    return diameter * diameter * (pi / 4)


def ellipse_area(width: Any, height: Any) -> Any:
    """Area of an elliptical section in m²: A = π·w·h/4 with full axes w and h; null at either zero; round where w = h.

    Parameters
    ----------
    width, height : quantity
        Full axes in m. Source: geometry.

    Examples
    --------
    >>> f"{1e6 * ellipse_area(2e-3, 1.5e-3):.3f} mm²"
    '2.356 mm²'
    """
    return width * height * (pi / 4)


def tape_area(width: Any, thickness: Any) -> Any:
    """Area of a rectangular section in m²: A = w·t; null at either zero.

    Parameters
    ----------
    width, thickness : quantity
        In m. Source: geometry.

    Examples
    --------
    >>> f"{1e6 * tape_area(25e-3, 0.05e-3):.2f} mm²"
    '1.25 mm²'
    """
    return width * thickness


def stated_area(area: Any) -> Any:
    """Area of a section in m² as stated, where its shape is unknown: A; null at zero. Source: the laboratory."""
    return area


@dataclass(frozen=True)
class Section:
    """A shape of section: the properties of the sample that it needs, its area and the equation as printed."""

    dimensions: tuple[str, ...]
    area: Callable[..., Any]
    equation: str


SECTIONS: Mapping[str, Section] = {
    "round": Section(("diameter",), round_area, "A = pi d^2 / 4"),
    "ellipse": Section(("width", "height"), ellipse_area, "A = pi w h / 4"),
    "tape": Section(("width", "thickness"), tape_area, "A = w t"),
    "area": Section(("area",), stated_area, "A stated"),
}
"""Every shape of section by the word in the campaign file."""


def section(shape: str) -> Section:
    """Section of a shape.

    Parameters
    ----------
    shape : str
        A key of `SECTIONS`.

    Returns
    -------
    Section
        Its dimensions and area.

    Raises
    ------
    MetrologyError
        For a shape that is not in `SECTIONS`.
    """
    if shape not in SECTIONS:
        raise MetrologyError(Fault("sample.section.shape", repr(shape), f"one of {', '.join(SECTIONS)}"))
    return SECTIONS[shape]


def area(sample: str, shape: str) -> Measurand:
    """Area of the section of a sample, ``{sample}.A`` in m², from its properties ``{sample}.width`` and so on.

    Parameters
    ----------
    sample : str
        Id of the sample.
    shape : str
        A key of `SECTIONS`.

    Returns
    -------
    Measurand
        ``{sample}.A``.

    Raises
    ------
    MetrologyError
        For a shape that is not in `SECTIONS`.
    """
    kind = section(shape)
    names = tuple(f"{sample}.{dimension}" for dimension in kind.dimensions)
    return Measurand(
        f"{sample}.A", lambda namespace: kind.area(*(namespace[name] for name in names)), "m²", kind.equation
    )


def mass_per_length(density: Any, area: Any) -> Any:
    """Mass per length in kg/m: λ = ρ·A.

    Parameters
    ----------
    density : quantity
        Of the material, in kg/m³.
    area : quantity
        Of the section, in m².

    Examples
    --------
    The aluminium tape of the paper weighs 0.033 N/m.

    >>> f"{9.8 * mass_per_length(2710, tape_area(25e-3, 0.05e-3)):.3f} N/m"
    '0.033 N/m'
    """
    return density * area


def elastic_modulus(k: Any, length: Any, area: Any) -> Any:
    """Elastic modulus in Pa: E = k·L/A, for a sample of uniform section that stretches alike over its length.

    Parameters
    ----------
    k : quantity
        Stiffness in N/m.
    length : quantity
        Between the clamps, in m.
    area : quantity
        Of the section, in m².

    Examples
    --------
    >>> f"{elastic_modulus(24734.25, 2.990, tape_area(25e-3, 0.05e-3)) / 1e9:.2f} GPa"
    '59.16 GPa'
    """
    return k * length / area


def modulus(name: str, *, k: str, length: str, area: str) -> Measurand:
    """Elastic modulus as an output: E = k·L/A in Pa.

    Parameters
    ----------
    name : str
        Of the output, such as ``"al-1100-elongation.E"``.
    k, length, area : str
        Names of stiffness, length and area in the namespace.

    Returns
    -------
    Measurand
        E.
    """
    return Measurand(
        name, lambda namespace: elastic_modulus(namespace[k], namespace[length], namespace[area]), "Pa", "E = k L / A"
    )
