"""Causes of uncertainty that several quantities share: components take from them what they do not state themselves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from metrology.campaign.results_file import WrongError
from metrology.declaration.component import AMOUNTS, BOUNDED
from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, mean
from metrology.gum.inputs import NAMELESS
from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.independent_parts import Part
    from metrology.declaration.document import Document

_OF_A_SIZE = ("k", "p", "beta", "limit_half_width", "parameters")
"""Keys that mean something only beside the size that they stand with."""


def enter_causes(document: Document) -> list[Refusal]:
    """Enter into every component of a campaign file what its cause says of it.

    Returns
    -------
    refusals : list
        Components whose cause is not declared, and causes that no component names, and components of one cause
        whose distributions differ.
    """
    data = document.data if isinstance(document.data, dict) else {}
    causes = data.get("causes")
    causes = causes if isinstance(causes, dict) else {}
    unused = dict.fromkeys(causes)
    shapes: dict[str, str] = {}
    refusals = []
    for place, component in list(_components(data, ())):
        cause = component["cause"]
        if cause not in causes:
            known = mean(cause, list(causes)) or "declare it there, with 'source'"
            refusals.append(Refusal((*place, "cause"), f"'{cause}'", "a name under 'causes'", known))
            continue
        unused.pop(cause, None)
        if isinstance(causes[cause], dict) and place[-1] != "certificate":  # which states its own
            _take(component, causes[cause])
        shape = _shape(component)
        if shapes.setdefault(cause, shape) != shape:
            got = f"{shape}, where another component of '{cause}' is {shapes[cause]}"
            refusals.append(Refusal(place, got, "one distribution for all components of a cause"))
    for cause in unused:
        fix = f"write 'cause: {cause}' in the components that share it, or leave it out"
        got = f"'{cause}', which no component names"
        refusals.append(Refusal(("causes", cause), got, "a cause that components name", fix))
    return refusals


def alone(document: Document) -> Iterator[tuple[Place, str]]:
    """Place of every cause that one component alone names, and a sentence on it; one of an instrument is of many."""
    counts = Counter[str]()
    for place, component in _components(document.data, ()):
        counts[component["cause"]] += 2 if place[0] == "instruments" and "uncertainty" in place else 1
    for name in document.data.get("causes") or {}:
        if counts[name] == 1 and not name.startswith(NAMELESS):
            text = "one component alone names this cause, so it correlates nothing. Name it in all that it acts on."
            yield ("causes", name), said(text)


def refuse_other_causes(causes: Any, found: Iterable[Part], report: str) -> None:
    """Refuse an imported cause that bears the name of one of this campaign, and is distributed otherwise."""
    for part in found:
        own = causes.get(part.cause) if isinstance(causes, dict) else None
        if not isinstance(own, dict) or not own.keys() & {*AMOUNTS, "distribution", "dof"}:
            continue
        here, there = (
            # Student's is the normal one of few degrees of freedom.
            ("normal" if shape == "student" else str(shape), "infinite" if dof is None else _figure(dof))
            for shape, dof in ((own.get("distribution", "normal"), own.get("dof")), (part.distribution, part.dof))
        )
        if here != there:
            got = f"cause '{part.cause}', {there[0]} with {there[1]} degrees of freedom in {report}"
            expected = f"the same cause, which is {here[0]} with {here[1]} degrees of freedom here"
            raise WrongError("result", got, expected, "give one of the two another name, if they are two unknowns")


def _figure(stated: Any) -> str:
    """A number as one text, however it is written; what is none is refused elsewhere."""
    try:
        return f"{float(stated):g}"
    except (TypeError, ValueError):
        return str(stated)


def _take(component: dict[str, Any], cause: dict[str, Any]) -> None:
    own_size = any(key in component for key in AMOUNTS)
    for key, value in cause.items():
        if key == "description" or (own_size and key in (*AMOUNTS, *_OF_A_SIZE)):
            continue
        component.setdefault(key, value)


def _shape(component: dict[str, Any]) -> str:
    """Return what a component says of its distribution, but for its size."""
    name = component.get("distribution", "normal")
    more = [f"{key} {component[key]}" for key in (BOUNDED.get(name, ""), "dof") if key in component]
    return ", ".join([str(name), *more])


def _components(data: Any, place: Place) -> Iterator[tuple[Place, dict[str, Any]]]:
    """Every mapping with a text under `cause`, with its place."""
    if isinstance(data, dict):
        if isinstance(data.get("cause"), str):
            yield place, data
        for key, value in data.items():
            yield from _components(value, (*place, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _components(value, (*place, index))
