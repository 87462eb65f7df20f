"""Stacked weights: a mass of a test may be a sum of named masses, each of them one unknown value wherever it hangs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from math import fsum
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError

from metrology.declaration.component import AMOUNTS
from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, mean
from metrology.declaration.quantity import Mass, Stated

if TYPE_CHECKING:
    from metrology.declaration.document import Document

_NAME = r"[^\W\d][\w-]*"
_SUM = re.compile(rf"\s*{_NAME}(?:\s*\+\s*{_NAME})*\s*")
_SIZES = (*AMOUNTS, "limit_half_width")


def enter_masses(document: Document) -> list[Refusal]:
    """Put in place of every sum of named masses its value, with the components of the masses as shared causes.

    u of ``m1 + m2`` is √(u₁² + u₂²), and its covariance with ``m1 + m3`` is u₁² (JCGM 100:2008, F.1.2.3): a component
    of a mass is one cause for all loads in which the mass hangs. Components of several masses that name the same cause,
    such as one certificate of the set, act in the same direction, so that their sizes add up.

    Returns
    -------
    refusals : list
        Masses that are not declared, that stand twice in a sum, or whose shared cause is not stated alike.
    """
    data = document.data if isinstance(document.data, dict) else {}
    stated = data.get("masses")
    stated = stated if isinstance(stated, dict) else {}
    known = {name: one for name, entry in stated.items() if (one := _mass(entry)) is not None}
    refusals: list[Refusal] = []
    spare = 1000
    for place, entry in list(_masses(data.get("tests"), ("tests",))):
        text = entry["mass"]
        if not isinstance(text, str) or not (text in stated or ("+" in text and _SUM.fullmatch(text))):
            continue
        names = [part.strip() for part in text.split("+")]
        wrong = list(_faults(place, names, stated, known))
        refusals += wrong
        if wrong or any(name not in known for name in names):
            # The fault is reported where it is; some mass, unlike all others, keeps the checks of the test from adding.
            spare += 1
            entry["mass"] = f"{spare} kg"
            continue
        components = _together([one for name in names for one in _components(name, known[name], stated[name])])
        # The extended model is written out as a file with these causes.
        made = {one["cause"]: {"source": one.get("source", "")} for one in components}
        if isinstance(causes := data.get("causes", {}), dict):
            data["causes"] = made | causes
        entry["mass"] = {
            "value": f"{fsum(known[name].si for name in names)!r} kg",
            "uncertainty": components,
            "description": " + ".join(names),
        }
    return refusals


def _mass(entry: Any) -> Stated | None:
    """A mass as stated; None where it is at fault, which the check of the whole file says."""
    try:
        return TypeAdapter(Mass).validate_python(entry)
    except ValidationError:
        return None


def _masses(data: Any, place: Place) -> Iterator[tuple[Place, dict[str, Any]]]:
    """Every entry below the tests that has a mass, with the place of the mass."""
    if isinstance(data, dict):
        if "mass" in data:
            yield (*place, "mass"), data
        for key, value in data.items():
            yield from _masses(value, (*place, key))


def _faults(
    place: Place, names: list[str], stated: Mapping[str, Any], known: Mapping[str, Stated]
) -> Iterator[Refusal]:
    for name in dict.fromkeys(names):
        if name not in stated:
            fix = mean(name, list(stated)) or f"declare it there: 'masses: {{{name}: 1.0000(1) kg}}'"
            yield Refusal(place, f"'{name}'", "a name under 'masses'", fix, name)
        elif names.count(name) > 1:
            yield Refusal(place, f"'{name}' {names.count(name)} times", "every mass once: one weight hangs once")
    ways: dict[str, tuple[object, ...]] = {}
    for name in (one for one in names if one in known):
        for component in known[name].uncertainty:
            way = component.amount, component.k, component.p, component.dof, component.type
            if component.cause and ways.setdefault(component.cause, way) != way:
                expected = "a size by the same key, with the same 'k', 'p', 'dof' and 'type', in all of these masses"
                yield Refusal(place, f"'{component.cause}' stated in different ways", expected)


def _components(name: str, mass: Stated, entry: Any) -> Iterator[dict[str, Any]]:
    """Components of a mass as a file would state them: sizes in kg, each with its cause."""
    if not mass.uncertainty:
        if mass.u > 0:
            yield {"name": name, "standard": f"{mass.u!r} kg", "cause": f"mass-{name}", "source": mass.source}
        return
    listed = entry["uncertainty"] if isinstance(entry, dict) else []
    texts = [listed] if isinstance(listed, dict) else listed
    for at, (sized, text) in enumerate(zip(mass._sized, texts, strict=True), 1):
        own = sized.stated
        sizes = {own.amount: sized.amount, "limit_half_width": sized.limit}
        yield {
            **text,
            **{key: f"{sizes[key]!r} kg" for key in _SIZES if key in text},
            "name": own.name or own.cause or f"{name}, {own.source or f'component {at}'}",
            "cause": own.cause or f"mass-{name}-{at}",
        }


def _together(components: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Components, those of one cause as one: they are one unknown value, so that their sizes add up."""
    made: dict[str, dict[str, Any]] = {}
    for one in components:
        same = made.setdefault(one["cause"], one)
        if same is not one:
            for key in (key for key in _SIZES if key in same):
                total = sum(float(part[key].removesuffix(" kg")) for part in (same, one))
                same[key] = f"{total!r} kg"
    return list(made.values())
