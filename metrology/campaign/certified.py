"""Quantities of a digital calibration certificate: values, expanded uncertainties, and the errors that it states."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal

from metrology.message import said
from metrology.units.vocabularies import from_dsi

DCC, SI = "{https://ptb.de/dcc}", "{https://ptb.de/si}"
_READ, _TRUE = ("basic_indicatedValue", "basic_measuredValue"), "basic_referenceValue"
_POINTS = (*_READ, _TRUE, "basic_nominalValue", "basic_arithmeticMean")
"""`refType` of the quantity beside an uncertainty that says at which readings it was found (PTB, DCC good practice)."""
_ERROR = re.compile("error|correction|messabweichung|korrektion", re.IGNORECASE)
"""What the name of a quantity holds whose values are errors of indication, or corrections: `basic_measurementError`."""


@dataclass(frozen=True)
class Stated:
    """A quantity of a certificate: how it is called, its values, expanded uncertainties and factors, and its unit.

    `points`: the readings at which it was found; `errors`: what the instrument was found to be off there.
    """

    names: tuple[str, ...]
    values: tuple[str, ...]
    uncertainties: tuple[str, ...]
    factors: tuple[str, ...]
    unit: str
    points: tuple[str, ...] = ()
    errors: tuple[Decimal, ...] = ()
    probability: str = ""

    def off(self) -> str:
        """The largest error that is beyond its U, in words; empty where none is."""
        spread = [Decimal(one) for one in self.uncertainties] * (1 if len(self.uncertainties) > 1 else len(self.errors))
        beyond = [at for at, error in enumerate(self.errors) if abs(error) > spread[at]]
        if not beyond:
            return ""
        most = max(beyond, key=lambda at: abs(self.errors[at]))
        known = {"error": str(self.errors[most]), "most": str(spread[most]), "unit": self.unit}
        if not self.points:
            return said("an error of {error:figures} {unit}, beyond its U = {most:figures} {unit}", **known)
        text = "an error of {error:figures} {unit} at {point:figures} {unit}, beyond its U = {most:figures} {unit}"
        return said(text, point=self.points[most], **known)


def text_at(root: ET.Element, path: str) -> str:
    """Text of the element at a path, without line breaks; empty where there is none."""
    return " ".join((root.findtext(path) or "").split())


def quantities(root: ET.Element) -> Iterator[Stated]:
    """Every quantity of the results with an expanded uncertainty; in a list, with the points beside it."""
    for data in root.iterfind(f".//{DCC}measurementResults//{DCC}data"):
        for group in (data, *data.iter(f"{DCC}list")):
            members = group.findall(f"{DCC}quantity")
            for one in members:
                if (stated := _stated(one)) is not None:
                    yield _with_points(stated, one, members)


def _with_points(stated: Stated, one: ET.Element, members: Sequence[ET.Element]) -> Stated:
    """The quantity with the readings at which it was found, and the errors there: its own, or of one beside it."""
    beside: dict[str, tuple[str, ...]] = {}
    errors: tuple[str, ...] = ()
    for other in (one, *members):
        real = _real(other)
        values = _list(real, "value") if real is not None else ()
        if real is None or from_dsi(_unit(real)) != stated.unit or len(values) != len(stated.values):
            continue
        if any(map(_ERROR.search, _names(other))):
            errors = errors or values
        for name in other.get("refType", "").split():
            beside.setdefault(name, values)
    points = next((beside[name] for name in _POINTS if name in beside), ())
    read = next((beside[name] for name in _READ if name in beside), ())
    off = zip(read, beside.get(_TRUE, ()), strict=False)
    found = tuple(map(Decimal, errors)) or tuple(Decimal(one) - Decimal(true) for one, true in off)
    return replace(stated, points=points, errors=found)


def _names(one: ET.Element) -> tuple[str, ...]:
    """How a quantity is called: name, id and types."""
    names = (text_at(one, f"{DCC}name/{DCC}content"), one.get("id", ""), *one.get("refType", "").split())
    return tuple(filter(None, names))


def _real(one: ET.Element) -> ET.Element | None:
    return next((real for name in ("real", "realListXMLList") for real in one.iter(f"{SI}{name}")), None)


def _unit(real: ET.Element) -> str:
    return (text_at(real, f"{SI}unit") or text_at(real, f"{SI}unitXMLList")).partition(" ")[0]


def _list(real: ET.Element, *names: str) -> tuple[str, ...]:
    """Numbers of an element by one of its names, alone or as a list; all of them decimal numbers, else none."""
    for element in real.iter():
        if element.tag.removeprefix(SI).removesuffix("XMLList") in names:
            words = tuple((element.text or "").split())
            try:
                return words if all(abs(float(word)) < 1e75 for word in words) else ()
            except ValueError:
                return ()
    return ()


def _stated(one: ET.Element) -> Stated | None:
    real = _real(one)
    if real is None:
        return None
    values, factors = _list(real, "value"), _list(real, "coverageFactor")
    uncertainties = _list(real, "uncertainty", "valueExpandedMU")
    unit = from_dsi(_unit(real))
    if not (values and uncertainties and factors and unit) or len(uncertainties) not in (1, len(values)):
        return None
    probability = next(iter(_list(real, "coverageProbability")), "")
    return Stated(_names(one), values, uncertainties, factors, unit, probability=probability)
