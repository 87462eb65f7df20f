"""Quantities that are results of another campaign: value and budget from its `results.json`, by the file's hash."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from hashlib import sha256
from math import inf, sqrt
from typing import TYPE_CHECKING, Any

from metrology.campaign import independent_parts, results_file
from metrology.campaign.causes import refuse_other_causes
from metrology.campaign.independent_parts import Part
from metrology.campaign.results_file import KEYS, Related, Result, Results, WrongError
from metrology.declaration.columns import SourceFile
from metrology.declaration.document import Place
from metrology.errors import Fault
from metrology.gum.inputs import NAMELESS
from metrology.gum.law import effective_dof

if TYPE_CHECKING:
    from metrology.declaration.document import Document

_APART = 1e-6
"""Correlation between two results that what they share by name does not explain, above which it is no rounding."""
CAMPAIGNS = (".yaml", ".yml")
"""Ends of the names of campaign files."""
RECONSTRUCTED = ", reconstructed"
"""What the source of a component says of readings that were not measured; a result made of it hands it on."""
_ENDLESS = 1e9
"""Degrees of freedom of what is taken as known, where a number is asked for."""


@dataclass(frozen=True)
class Imported:
    """A result of another campaign and what must be known of it here.

    Parameters
    ----------
    about : str
        Source that its components name, by which it is found among the inputs.
    result, report : str
        Its full name there, and the number of the report, or the campaign's name where it has none.
    reasons : tuple of str
        Why its own report does not judge it; empty where it does.
    accepted : tuple of str
        What its own report accepts on its way, each with reason and person.
    lost : str
        What of its distribution is not carried over; empty where all is.
    loose : bool
        Whether its budget lacks a part of its standard uncertainty, which may be correlated with that of other results.
    display_unit : str
        Unit in which its own report shows it.
    reconstructed : bool
        Whether it rests on readings that were not measured, there or in a campaign that it takes a result from.
    is_numbered : bool
        Whether its report has a number, which no other report has.
    sha256 : str
        Of the file that it was taken from.
    records : tuple of (str, str)
        Files that its campaign read, by name and SHA-256, but for campaign files.
    """

    about: str
    result: str
    report: str
    reasons: tuple[str, ...]
    accepted: tuple[str, ...]
    lost: str
    loose: bool = False
    display_unit: str = ""
    reconstructed: bool = False
    is_numbered: bool = False
    sha256: str = ""
    records: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Together:
    """Part of the uncertainty that results of one file have jointly: readings taken together, parameters of one fit.

    Parameters
    ----------
    name : str
        What it is.
    about : tuple of str
        Of each result the source that its components name.
    component : tuple of str
        Of each result the name of this component.
    covariance : tuple of tuple of float
        Of the results, in SI.
    dof : float
        Degrees of freedom, the fewest that any of them has.
    """

    name: str
    about: tuple[str, ...]
    component: tuple[str, ...]
    covariance: tuple[tuple[float, ...], ...]
    dof: float


def enter_results(document: Document) -> tuple[tuple[SourceFile, ...], tuple[Imported, ...], tuple[Together, ...]]:
    """Enter value and components of every quantity that names a result of another campaign under ``from``.

    A component keeps the cause that its campaign names where this one declares a cause of that name: it is the same
    unknown. What two results of one file have in common is a cause of both; what else correlates them there is one
    component of each, and these have their covariance.

    Files that are not there or not the ones meant, and results that they do not have, are faults of the document.

    Returns
    -------
    files : tuple
        The results that were read.
    imported : tuple of Imported
        What must be known of each result that was entered.
    together : tuple of Together
        Components of several results that have a covariance.
    """
    data = document.data if isinstance(document.data, dict) else {}
    files: dict[str, tuple[SourceFile, Results]] = {}
    entered: list[tuple[dict[str, Any], str, Result, list[Part]]] = []
    imported: dict[str, Imported] = {}
    together: list[Together] = []
    once: dict[str, list[Part]] = {}
    for place, entry in list(_entries(data, ())):
        try:
            source, findings = results_file.read(document, entry, files)
            result = results_file.result_named(findings, str(entry["result"]))
            report = findings.campaign.report_number or findings.campaign.id
            found = independent_parts.parts(result)
            refuse_other_causes(data.get("causes"), found, report)
        except WrongError as wrong:
            where = (*place, wrong.key)
            fault = Fault(document.at(*where), wrong.got, wrong.expected, wrong.fix)
            document.faults.append((document.order(where), fault))
            document.spoiled.add(place)
            continue
        about = f"{report}, {result.name}"
        if findings.campaign.reconstructed:
            about += RECONSTRUCTED
        about = f"{about}; SHA-256 {source.sha256[:12]}…"
        entered.append((entry, about, result, once.setdefault(about, found)))
        further = any(RECONSTRUCTED in row.source for row in result.budget)
        imported[about] = Imported(
            about, result.name, report, results_file.reasons(findings, result),
            results_file.accepted(findings, result), "", display_unit=result.display_unit,
            reconstructed=bool(findings.campaign.reconstructed) or further,
            is_numbered=bool(findings.campaign.report_number), sha256=source.sha256,
            records=tuple((file.path, file.sha256) for file in findings.inputs if not file.path.endswith(CAMPAIGNS)),
        )  # fmt: skip
    declared = _declared(data)
    for name, (_, findings) in files.items():
        of_file = {about: (result, found) for entry, about, result, found in entered if entry["from"] == name}
        together += _jointly(of_file, findings.correlations, declared)
    lost, rests = dict[str, str](), dict[str, str]()
    for entry, about, result, found in entered:
        if about in lost:
            continue
        lost[about] = independent_parts.lost(result, found)
        if lost[about] and (rest := independent_parts.rest(result, found)) is not None:
            found.append(rest)
            rests[about] = entry["from"]
            lost[about] = independent_parts.lost(result, found)
    loose = {about for about, name in rests.items() if Counter(rests.values())[name] > 1}
    _enter(data, entered, declared)
    known = tuple(replace(one, lost=lost[about], loose=about in loose) for about, one in imported.items())
    return tuple(source for source, _ in files.values()), known, tuple(together)


def _entries(data: Any, place: Place) -> Iterator[tuple[Place, dict[str, Any]]]:
    if isinstance(data, dict):
        if KEYS & data.keys() >= {"from", "result"} and isinstance(data["from"], str):
            yield place, data
        for key, value in data.items():
            yield from _entries(value, (*place, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _entries(value, (*place, index))


def _declared(data: dict[str, Any]) -> set[str]:
    causes = data.get("causes")
    return set(causes) if isinstance(causes, dict) else set()


def _jointly(
    of_file: dict[str, tuple[Result, list[Part]]], correlations: tuple[Related, ...], declared: set[str]
) -> Iterator[Together]:
    """Join what correlates results of one file beyond the parts that they share: one part of each, with a covariance.

    The covariance of two results there, less what parts of one name explain, is that of what is left of each.
    """
    import numpy as np

    about, results = list(of_file), [result for result, _ in of_file.values()]
    known = {frozenset((one.a, one.b)): one.coefficient for one in correlations}
    r = np.array([[1.0 if a is b else known.get(frozenset((a.name, b.name)), 0.0) for b in results] for a in results])
    u = np.array([sqrt(sum(part.contribution**2 for part in found)) for _, found in of_file.values()])
    uses = Counter(part.key for _, found in of_file.values() for part in found)
    joined = np.zeros(len(about), dtype=bool)
    while True:
        # A part without a cause is independent of what else its own result reads, not of what another one reads.
        kept = [
            {
                part.key: part.contribution for part in found
                if part.cause in declared or (uses[part.key] > 1 and (part.cause or not joined[at]))
            }
            for at, (_, found) in enumerate(of_file.values())
        ]  # fmt: skip
        shared = [[sum(size * b.get(key, 0.0) for key, size in a.items()) for b in kept] for a in kept]
        rest = r * np.outer(u, u) - np.array(shared).reshape(r.shape)
        apart = (np.abs(rest) > _APART * np.outer(u, u)) & ~np.eye(len(about), dtype=bool)
        if not (apart.any(axis=1) & ~joined).any():
            break
        joined |= apart.any(axis=1)
    for group in _groups(apart):
        own = [[part for part in of_file[about[at]][1] if part.key not in kept[at]] for at in group]
        names = {part.name for found in own for part in found}
        name = names.pop() if len(names) == 1 else "correlated inputs"
        dof = min(
            effective_dof((part.contribution**2, inf if part.dof is None else part.dof) for part in found)
            for found in own
        )
        for at, found in zip(group, own, strict=True):
            size, all_parts = sqrt(max(rest[at, at], 0.0)), of_file[about[at]][1]
            kind = "A" if any(part.kind == "A" for part in found) else "B"
            sources = {part.source for part in found}
            source = sources.pop() if len(sources) == 1 else ""
            key = f"{results[at].name}: {name}"
            one = Part(key, key, size, "normal", None if dof == inf else dof, kind, source, "")
            all_parts[:] = [*(part for part in all_parts if part.key in kept[at]), one]
        sizes, axes = np.linalg.eigh(rest[np.ix_(group, group)])
        block = (axes * np.maximum(sizes, 0.0)) @ axes.T  # without what rounding makes less than nothing
        rows = tuple(map(tuple, ((block + block.T) / 2).tolist()))
        components = tuple(f"{results[at].name}: {name}" for at in group)
        yield Together(name, tuple(about[at] for at in group), components, rows, min(dof, _ENDLESS))


def _groups(joined: Any) -> Iterator[list[int]]:
    """Groups of two or more that are joined with one another, directly or through others."""
    from scipy.sparse.csgraph import connected_components

    count, labels = connected_components(joined, directed=False)
    groups = ([at for at, label in enumerate(labels) if label == one] for one in range(count))
    return (group for group in groups if len(group) > 1)


def _enter(
    data: dict[str, Any], entered: list[tuple[dict[str, Any], str, Result, list[Part]]], declared: set[str]
) -> None:
    """Write value and components, each with the unknown that it is: its cause in whatever campaign imports it."""
    for entry, about, result, found in entered:
        components = []
        for part in found:
            cause = part.cause
            if cause not in declared and not cause.startswith(NAMELESS):
                cause = NAMELESS + sha256(f"{entry['sha256'].lower()} {part.key}".encode()).hexdigest()[:12]
            if cause not in declared:
                data.setdefault("causes", {})[cause] = {"description": f"{part.name}, of {entry['from']}"}
            components.append(_component(part, about, result.unit, cause, own=cause not in declared))
        value = {"value": _amount(result.value, result.unit), "source": about}
        kept = {"description": entry["description"]} if "description" in entry else {}
        entry.clear()
        entry |= value | kept | ({"uncertainty": components} if components else {})


def _component(part: Part, about: str, unit: str, cause: str, *, own: bool) -> dict[str, Any]:
    """A component as a campaign file states it; `own`: with its own distribution, not that of a declared cause."""
    stated: dict[str, Any] = {
        "name": part.name,
        "source": f"{part.source}; {about}" if part.source else about,
        "standard": _amount(abs(part.contribution), unit),
    }
    if own:
        stated["type"] = part.kind
        stated |= {"dof": repr(part.dof)} if part.dof is not None else {}
        stated |= {"distribution": part.distribution} if part.distribution != "normal" else {}
    return stated | {"cause": cause, "direction": "opposite" if part.contribution < 0 else "same"}


def _amount(value: float, unit: str) -> str:
    return repr(value) if unit == "1" else f"{value!r} {unit}"
