"""XML elements of a digital calibration certificate: the few shapes that its text, people and quantities have."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, nan
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, SubElement

from metrology.units import vocabularies

if TYPE_CHECKING:
    from metrology.consensus import Consensus
    from metrology.findings import Result
    from metrology.identification import Party

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
LARGEST_K = 1e6
"""Coverage factors are written without an exponent."""


def element(parent: Element, name: str, text: str = "", **attributes: str) -> Element:
    """Append an element of the certificate's namespace, and return it."""
    made = SubElement(parent, f"{{{DCC}}}{name}", attributes)
    if text:
        made.text = clean(text)
    return made


def clean(text: str) -> str:
    """Return a text as XML can hold it: one line, without blanks at its ends, control characters by their code."""
    line = " ".join(text.split())
    return "".join(c if c.isprintable() or c == " " else f"⟨U+{ord(c):04X}⟩" for c in line)


def words(parent: Element, name: str, *texts: str) -> Element:
    """Append an element that holds text in English: a name, a description, a declaration."""
    made = element(parent, name)
    for text in filter(None, texts):
        element(made, "content", text, lang="en")
    return made


def contact(parent: Element, name: str, party: Party) -> Element:
    """Append a laboratory or a customer, with its place."""
    made = element(parent, name)
    words(made, "name", party.name)
    location = element(made, "location")
    if party.country:
        element(location, "countryCode", party.country)
    words(location, "further", party.address or "address not stated", party.contact)
    return made


def identifications(parent: Element, issuer: str, value: str) -> None:
    """Append one identification."""
    entry = element(element(parent, "identifications"), "identification")
    element(entry, "issuer", issuer)
    element(entry, "value", value)


def software(parent: Element, name: str, versions: Iterable[tuple[str, str]]) -> None:
    """Append a list of programs with their versions."""
    made = element(parent, name)
    for program, version in versions:
        entry = element(made, "software")
        words(entry, "name", program)
        element(entry, "release", version)


def quantity(parent: Element, result: Result) -> None:
    """Append a result: value and unit in D-SI, with the interval that the report leads with.

    Where the law holds: expanded uncertainty and coverage factor; else standard uncertainty and the Monte Carlo
    interval. What has no finite value or no D-SI unit is text.
    """
    name = result.name if result.name == result.quantity else f"{result.quantity} ({result.name})"
    real = _real(parent, name, result.value, result.unit, clean(result.unit_dsi))
    if real is not None:
        _uncertainty(real, result)


def consensus(parent: Element, entry: Consensus) -> None:
    """Append the consensus of several tests, with its coverage interval."""
    value, u, low, high = (nan if one is None else one for one in (entry.value, entry.u, entry.low, entry.high))
    real = _real(parent, f"{entry.quantity} ({entry.sample}, consensus)", value, entry.unit)
    if real is not None and all(map(isfinite, (u, low, high))):
        _interval(real, u, (low, high), entry.p)


def _real(parent: Element, name: str, value: float, unit: str, dsi: str = "") -> Element | None:
    """A quantity with value and unit; what has no finite value or no D-SI unit is text."""
    made = element(parent, "quantity")
    words(made, "name", name)
    dsi = dsi or vocabularies.dsi(unit)
    if not (isfinite(value) and dsi):
        words(made, "noQuantity", f"{value!r} {unit}: no quantity that D-SI could hold")
        return None
    real = SubElement(made, f"{{{SI}}}real")
    _si(real, "value", value)
    SubElement(real, f"{{{SI}}}unit").text = dsi
    return real


def _uncertainty(real: Element, result: Result) -> None:
    k, (low, high) = result.coverage.k, result.interval
    if not isfinite(result.u):
        return
    if result.monte_carlo.law_valid and k is not None and 1 <= k < LARGEST_K:
        stated = SubElement(real, f"{{{SI}}}expandedUnc")
        _si(stated, "uncertainty", k * result.u)
        _si(stated, "coverageFactor", k)
        _si(stated, "coverageProbability", result.coverage.p)
    elif low is not None and high is not None and isfinite(low) and isfinite(high):
        _interval(real, result.u, (low, high), result.coverage.p)


def _interval(real: Element, u: float, ends: tuple[float, float], p: float) -> None:
    stated = SubElement(real, f"{{{SI}}}coverageInterval")
    _si(stated, "stdUncertainty", u)
    _si(stated, "intervalMin", ends[0])
    _si(stated, "intervalMax", ends[1])
    _si(stated, "coverageProbability", p)


def _si(parent: Element, name: str, value: float) -> None:
    SubElement(parent, f"{{{SI}}}{name}").text = repr(float(value))
