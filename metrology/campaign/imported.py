"""Quantities that are results of another campaign: value and budget from its `results.json`, by the file's hash."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from math import ceil, inf, isfinite, log10, nan, sqrt
from typing import TYPE_CHECKING, Any

from metrology import jsontext
from metrology.campaign.calibration import folder_of
from metrology.campaign.readings import inside
from metrology.declaration.columns import SourceFile, source_file
from metrology.declaration.document import Place
from metrology.declaration.entry import mean
from metrology.errors import Fault
from metrology.gum.distributions import Arcsine, Distribution, Normal, Rectangular, Student, Triangular
from metrology.gum.evaluation import BudgetRow
from metrology.gum.inputs import NAMELESS
from metrology.gum.law import effective_dof
from metrology.gum.rounding import readable
from metrology.message import said
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.declaration.document import Document

SUFFIX = ".json"
KEYS = {"from", "result", "sha256"}
_SHAPES = ("rectangular", "triangular", "arcsine")
"""Distributions that their standard uncertainty describes; others enter as normal ones of the same u."""
_LEAST = 1e-9
"""Part of u² below which a difference is rounding."""
_KEPT = 0.05
"""Part of u by which an end of the interval may move before the distribution counts as lost."""
_APART = 1e-6
"""Correlation between two results that what they share by name does not explain, above which it is no rounding."""
_ENDLESS = 1e9
"""Degrees of freedom of what is taken as known, where a number is asked for."""
_DRAWS = 200_000
"""Draws by which that is seen: they place the end of a 95 % interval to a hundredth of u."""


@dataclass(frozen=True)
class Framework:
    """What the budget adds up to."""

    u: float


@dataclass(frozen=True)
class Drawn:
    """What Monte Carlo says: whether it confirms the framework, and its interval; infinite δ: it says nothing."""

    law_valid: bool = True
    low: float = 0.0
    high: float = 0.0
    p: float = 0.95
    tolerance: float = inf


@dataclass(frozen=True)
class Result:
    """What is taken of a result; `doubts` is None in files of versions that do not write it."""

    name: str
    value: float
    unit: str
    framework: Framework
    budget: tuple[BudgetRow, ...]
    test: str = ""
    monte_carlo: Drawn = Drawn()
    doubts: tuple[str, ...] | None = None
    u: float = nan  # as reported: of the draws where these do not confirm the framework
    display_unit: str = ""


@dataclass(frozen=True)
class Withheld:
    """What is taken of a requirement without a verdict."""

    result: str
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Judged:
    """What is taken of a verdict."""

    result: str
    accepted: tuple[str, ...] = ()


@dataclass(frozen=True)
class Diagnosed:
    """What is taken of a diagnosis."""

    test: str
    verdict: str


@dataclass(frozen=True)
class Origin:
    """What is taken of a campaign."""

    id: str
    report_number: str
    reconstructed: str


@dataclass(frozen=True)
class Related:
    """Correlation coefficient between two results."""

    a: str
    b: str
    coefficient: float


@dataclass(frozen=True)
class Results:
    """What is taken of a `results.json`; the rest is passed over."""

    campaign: Origin
    results: tuple[Result, ...]
    correlations: tuple[Related, ...] = ()
    withheld: tuple[Withheld, ...] = ()
    conformity: tuple[Judged, ...] = ()
    tests: tuple[dict[str, Any], ...] = ()
    diagnosis: tuple[Diagnosed, ...] = ()


@cache
def _validator() -> Any:
    from pydantic import TypeAdapter

    return jsontext.validator(TypeAdapter(Results).core_schema)


@dataclass(frozen=True)
class Part:
    """One cause of the uncertainty of an imported result: its contribution with its sign, and what it is.

    `key` says which unknown it is, so that two results of one file share what both depend on; `cause` is the name that
    the other campaign gives it.
    """

    key: str
    name: str
    contribution: float
    distribution: str
    dof: float | None
    kind: str
    source: str
    cause: str


@dataclass(frozen=True)
class Imported:
    """A result of another campaign and what must be known of it here.

    Parameters
    ----------
    about : str
        Source that its components name, by which it is found among the inputs.
    result, report : str
        Its full name there, and the number of the report.
    reasons : tuple of str
        Why its own report does not judge it; empty where it does.
    lost : str
        What of its distribution is not carried over; empty where all is.
    loose : bool
        Whether its budget lacks a part of its standard uncertainty, which may be correlated with that of other results.
    display_unit : str
        Unit in which its own report shows it.
    """

    about: str
    result: str
    report: str
    reasons: tuple[str, ...]
    lost: str
    loose: bool = False
    display_unit: str = ""


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
            source, findings = _read(document, entry, files)
            result = _result(findings, str(entry["result"]))
        except _WrongError as wrong:
            where = (*place, wrong.key)
            fault = Fault(document.at(*where), wrong.got, wrong.expected, wrong.fix)
            document.faults.append((document.order(where), fault))
            document.spoiled.add(place)
            continue
        report = findings.campaign.report_number or findings.campaign.id
        about = f"{report}, {result.name}"
        if findings.campaign.reconstructed:
            about += ", reconstructed"
        about = f"{about}; SHA-256 {source.sha256[:12]}…"
        found = once.setdefault(about, parts(result))
        entered.append((entry, about, result, found))
        imported[about] = Imported(
            about, result.name, report, _reasons(findings, result), "", display_unit=result.display_unit
        )
    declared = _declared(data)
    for name, (_, findings) in files.items():
        of_file = {about: (result, found) for entry, about, result, found in entered if entry["from"] == name}
        together += _jointly(of_file, findings.correlations, declared)
    lost, rests = dict[str, str](), dict[str, str]()
    for entry, about, result, found in entered:
        if about in lost:
            continue
        lost[about] = _lost(result, found)
        if lost[about] and (rest := _rest(result, found)) is not None:
            found.append(rest)
            rests[about] = entry["from"]
            lost[about] = _lost(result, found)
    loose = {about for about, name in rests.items() if Counter(rests.values())[name] > 1}
    _enter(data, entered, declared)
    known = tuple(replace(one, lost=lost[about], loose=about in loose) for about, one in imported.items())
    return tuple(source for source, _ in files.values()), known, tuple(together)


@dataclass
class _WrongError(Exception):
    key: str
    got: str
    expected: str
    fix: str = ""


def _entries(data: Any, place: Place) -> Iterator[tuple[Place, dict[str, Any]]]:
    if isinstance(data, dict):
        if KEYS & data.keys() >= {"from", "result"} and isinstance(data["from"], str):
            yield place, data
        for key, value in data.items():
            yield from _entries(value, (*place, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _entries(value, (*place, index))


def _read(
    document: Document, entry: dict[str, Any], files: dict[str, tuple[SourceFile, Results]]
) -> tuple[SourceFile, Results]:
    """The results of a file and its hash, which has to be the one stated."""
    stray = sorted(entry.keys() - KEYS - {"description"})
    if stray:
        raise _WrongError(
            stray[0], f"'{stray[0]}' together with 'from'", "value and uncertainty from the file alone", "leave it out"
        )
    name = str(entry["from"])
    if name not in files:
        try:
            path = inside(folder_of(document), name, (SUFFIX,))
            if not path.is_file():
                raise ValueError("there is no such file")
            raw = jsontext.read(path)
            files[name] = source_file(name, raw), jsontext.validated(raw, _validator())
        except (ValueError, OSError) as error:
            expected = "the results.json of a campaign, in this campaign's folder"
            raise _WrongError("from", quoted(name), expected, str(error)) from None
    source, findings = files[name]
    stated = str(entry.get("sha256", ""))
    if stated.lower() != source.sha256:
        got = f"{quoted(stated)}, where the file has {source.sha256}" if stated else "no 'sha256'"
        fix = f"compare the file with the report that it belongs to, then write 'sha256: {source.sha256}'"
        raise _WrongError("sha256", got, "the SHA-256 of the file", fix)
    return source, findings


def _result(findings: Results, name: str) -> Result:
    known = {result.name: result for result in findings.results}
    if name not in known:
        near = mean(name, list(known)) or f"it has {', '.join(list(known)[:12])}"
        raise _WrongError("result", quoted(name), f"a result of campaign '{findings.campaign.id}'", near)
    result = known[name]
    if not (isfinite(result.value) and isfinite(result.framework.u)):
        raise _WrongError("result", f"'{name}', which has no value or no uncertainty", "a result with both")
    return result


def _reasons(findings: Results, result: Result) -> tuple[str, ...]:
    """Why the report of a result does not judge it.

    A file of a version that does not write it with the result has it in the verdicts withheld on what its tests give,
    in their failed checks and in their diagnoses.
    """
    if result.doubts is not None:
        return result.doubts
    tests = {
        name: test for test in findings.tests if (name := str(test.get("id", ""))) and (
            result.test == name or any(row.input.startswith(f"{name}.") for row in result.budget)
        )
    }  # fmt: skip
    own = {one.name for one in findings.results if one.name == result.name or (one.test and one.test in tests)}
    found = [why for one in findings.withheld if one.result in own for why in one.reasons]
    if not any(one.accepted for one in findings.conformity if one.result in own):
        found += [why for name, test in tests.items() for why in _failed(name, test)]
        text = "The diagnosis of {test} is: {verdict}."
        found += [
            said(text, test=one.test, verdict=one.verdict) for one in findings.diagnosis
            if one.test in tests and one.verdict in ("unexplained", "explained in the main", "not finished")
        ]  # fmt: skip
    return tuple(dict.fromkeys(found))


def _failed(name: str, test: dict[str, Any]) -> Iterator[str]:
    """Checks that a test failed and that its uncertainty does not cover, in whatever its method showed."""
    for shown in (one for one in test.values() if isinstance(one, dict)):
        for check in (one for one in shown.get("checks", ()) if isinstance(one, dict)):
            if check.get("passed") is False and not check.get("covered"):
                yield said("{test} failed the check '{name}'.", test=name, name=str(check.get("name", "")))


def _lost(result: Result, found: list[Part]) -> str:
    """What an interval says that the parts, each as it is entered, do not: of a skewed distribution or equation."""
    import numpy as np

    known, u = result.monte_carlo, result.framework.u
    if known.law_valid or not all(map(isfinite, (known.low, known.high, known.tolerance))):
        return ""
    u = u or (known.high - known.low) / 2
    if not u > 0:
        return ""
    low, high = result.value + np.quantile(_drawn(found), _tails(known))
    if max(abs(low - known.low), abs(high - known.high)) <= max(known.tolerance, _KEPT * u):
        return ""
    text = (
        "its symmetric {percent:g} % interval there is {low:figures} to {high:figures}, here {here_low:figures} to "
        "{here_high:figures}: its distribution is not carried over"
    )
    ends = {"low": known.low, "high": known.high, "here_low": float(low), "here_high": float(high)}
    digits = 2 + max(1, ceil(log10(max(map(abs, ends.values())) / u)))
    sizes = {name: readable(end, result.unit, digits) for name, end in ends.items()}
    return said(text, percent=100 * known.p, **sizes)


def _rest(result: Result, found: list[Part]) -> Part | None:
    """What the reported u has beyond the parts: of an equation whose first order says less than its draws.

    The rows of a square at zero all have a sensitivity of zero; its u would be lost.
    """
    import numpy as np

    if not isfinite(result.u):
        return None
    variance = sum(_distribution(part).deviation ** 2 for part in found)
    if variance == inf:
        low, high = np.quantile(_drawn(found), _tails(result.monte_carlo))
        variance = float((high - low) / (2 * Normal(1.0).quantile(_tails(result.monte_carlo)[1]))) ** 2
    if result.u <= (1 + _KEPT) * sqrt(variance):
        return None
    name = "what its budget does not show"
    return Part(f"{result.name}: {name}", name, sqrt(result.u**2 - variance), "normal", None, "B", "", "")


def _drawn(found: list[Part]) -> Any:
    """Draws of the parts together, each as it is entered."""
    import numpy as np

    generator = np.random.default_rng(1)
    return sum((_distribution(part).draw(generator, _DRAWS) for part in found), np.zeros(1))


def _tails(known: Drawn) -> tuple[float, float]:
    """Probabilities below the two ends of a symmetric interval."""
    tail = (1 - known.p) / 2
    return tail, 1 - tail


def _distribution(part: Part) -> Distribution:
    """Distribution of a part as it is entered."""
    size = abs(part.contribution)
    match part.distribution:
        case "rectangular":
            return Rectangular(sqrt(3) * size)
        case "triangular":
            return Triangular(sqrt(6) * size)
        case "arcsine":
            return Arcsine(sqrt(2) * size)
    return Normal(size) if part.dof is None else Student(size, part.dof)


def parts(result: Result) -> list[Part]:
    """Budget of a result in independent parts, whose squares add up to u² by the GUM uncertainty framework.

    Rows of one cause are one part; rows that are correlated otherwise (readings taken together, parameters of one fit)
    are one part too, with what their covariance leaves of u². Draws of the parts, each by its distribution and its
    degrees of freedom, have what Monte Carlo made of them there.
    """
    u = result.framework.u
    if not u > 0:
        return []
    found, joined = list[Part](), list[Any]()
    alike: dict[Any, list[Any]] = {}
    for at, row in enumerate(result.budget):
        alike.setdefault(row.cause or at, []).append(row)
    for rows in alike.values():
        size = sum(row.moved for row in rows)
        # A file of a version that does not write the direction of a cause has what the rows make together all the same.
        if abs(u**2 * sum(row.share for row in rows) - size**2) > _LEAST * u**2:
            joined += rows
        else:
            found.append(_part(rows[0], size))
    sets: dict[str, list[Any]] = {}
    for row in joined:
        sets.setdefault(row.component, []).append(row)
    variances = {name: u**2 * sum(row.share for row in rows) for name, rows in sets.items()}
    if any(variance < 0 for variance in variances.values()):
        sets, variances = {"correlated inputs": joined}, {"correlated inputs": sum(variances.values())}
    for name, rows in sets.items():
        size = sqrt(max(variances[name], 0.0))
        dof = rows[0].dof if len({row.dof for row in rows}) == 1 else None
        # Its own of this result: its size does not say what it does to another one.
        key = f"{result.name}: {name}"
        found.append(Part(key, name, size, "normal", dof, rows[0].kind, rows[0].source, ""))
    return [part for part in found if part.contribution]


def _part(row: Any, contribution: float) -> Part:
    name = f"{row.input}, {row.component}" if row.component else row.input
    shape = row.distribution if row.distribution in _SHAPES else "normal"
    return Part(row.cause or name, name, contribution, shape, row.dof, row.kind, row.source, row.cause)


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
