"""The results.json of another campaign: what is taken of it, and which of its results its own report does not judge."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any

from metrology import jsontext
from metrology.campaign.calibration import folder_of
from metrology.campaign.readings import inside
from metrology.declaration.columns import SourceFile, source_file
from metrology.declaration.entry import mean
from metrology.gum.evaluation import BudgetRow
from metrology.message import said
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.declaration.document import Document

SUFFIX = ".json"
KEPT = 0.05
"""Part of u by which an end of an interval may move before it counts as another one."""
KEYS = {"from", "result", "sha256"}


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
class Coverage:
    """What is taken of the interval by the budget: its coverage factor."""

    k: float | None = None


@dataclass(frozen=True)
class Result:
    """What is taken of a result; `doubts` and `accepted` are None in files of versions that do not write them."""

    name: str
    value: float
    unit: str
    framework: Framework
    budget: tuple[BudgetRow, ...]
    test: str = ""
    monte_carlo: Drawn = Drawn()
    doubts: tuple[str, ...] | None = None
    accepted: tuple[str, ...] | None = None
    u: float = nan  # as reported: of the draws where these do not confirm the framework
    display_unit: str = ""
    coverage: Coverage = Coverage()

    @property
    def contradicts_itself(self) -> bool:
        """Whether there is a u without a budget, or the draws confirm another value or u than it has."""
        if self.framework.u > 0 and not any(row.contribution for row in self.budget):
            return True
        drawn, k = self.monte_carlo, self.coverage.k
        if k is None or not (drawn.law_valid and isfinite(drawn.tolerance)):
            return False
        half = k * self.framework.u
        off = max(abs(self.value - half - drawn.low), abs(self.value + half - drawn.high))
        return off > max(drawn.tolerance, KEPT * self.framework.u)


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
class Record:
    """What is taken of a file that was read."""

    path: str
    sha256: str


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
    inputs: tuple[Record, ...] = ()


@cache
def _validator() -> Any:
    from pydantic import TypeAdapter

    return jsontext.validator(TypeAdapter(Results).core_schema)


@dataclass
class WrongError(Exception):
    """What is wrong of an entry, under which of its keys."""

    key: str
    got: str
    expected: str
    fix: str = ""


def read(
    document: Document, entry: dict[str, Any], files: dict[str, tuple[SourceFile, Results]]
) -> tuple[SourceFile, Results]:
    """The results of a file and its hash, which has to be the one stated."""
    stray = sorted(entry.keys() - KEYS - {"description"})
    if stray:
        raise WrongError(
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
            raise WrongError("from", quoted(name), expected, str(error)) from None
    source, findings = files[name]
    stated = str(entry.get("sha256", ""))
    if stated.lower() != source.sha256:
        got = f"{quoted(stated)}, where the file has {source.sha256}" if stated else "no 'sha256'"
        fix = f"compare the file with the report that it belongs to, then write 'sha256: {source.sha256}'"
        raise WrongError("sha256", got, "the SHA-256 of the file", fix)
    return source, findings


def result_named(findings: Results, name: str) -> Result:
    """The result of a name, which has to have a value and an uncertainty."""
    known = {result.name: result for result in findings.results}
    if name not in known:
        near = mean(name, list(known)) or f"it has {', '.join(list(known)[:12])}"
        raise WrongError("result", quoted(name), f"a result of campaign '{findings.campaign.id}'", near)
    result = known[name]
    if not (isfinite(result.value) and isfinite(result.framework.u)):
        raise WrongError("result", f"'{name}', which has no value or no uncertainty", "a result with both")
    if result.contradicts_itself:
        got = f"'{name}', whose value, u, budget and interval in the file do not go together"
        raise WrongError("result", got, "the file as its campaign wrote it", "make the report of that campaign again")
    return result


def reasons(findings: Results, result: Result) -> tuple[str, ...]:
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


def accepted(findings: Results, result: Result) -> tuple[str, ...]:
    """What the report of a result accepts on its way; files of earlier versions have it with the verdicts on it."""
    if result.accepted is not None:
        return result.accepted
    return tuple(dict.fromkeys(why for one in findings.conformity if one.result == result.name for why in one.accepted))


def _failed(name: str, test: dict[str, Any]) -> Iterator[str]:
    """Checks that a test failed and that its uncertainty does not cover, in whatever its method showed."""
    for shown in (one for one in test.values() if isinstance(one, dict)):
        for check in (one for one in shown.get("checks", ()) if isinstance(one, dict)):
            if check.get("passed") is False and not check.get("covered"):
                yield said("{test} failed the check '{name}'.", test=name, name=str(check.get("name", "")))
