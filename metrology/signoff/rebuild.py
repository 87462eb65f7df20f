"""A report made again from its own attachments: whether inputs give the results, and results the pages."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import isfinite
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from metrology.errors import MetrologyError
from metrology.signoff import agreement
from metrology.signoff.opened import RESULTS, Opened
from metrology.signoff.verdict import Check, failed, good

if TYPE_CHECKING:
    from metrology.findings import Findings, Result

TOLERANCE = 0.01
"""Of the standard uncertainty: how far a result by other versions may lie off and still be the same result."""


def checks(opened: Opened, templates: Path | None, progress: Callable[[str], None]) -> Iterator[Check]:
    """Evaluate the attached inputs, and lay out the report, and compare with what the file holds."""
    from metrology.findings import from_json

    sources = opened.sources()
    if len(sources) < len(opened.inputs):
        reason = "the inputs are not attached" if not sources else "attached inputs are missing"
        yield Check("results", "not checked", f"{reason}, so nothing can be computed from them")
        sources = {}
    try:
        printed = from_json(opened.attachments[RESULTS])
    except ValueError:
        sentence = "another version of this software made the report, and this one does not read its results"
        yield Check("results", "not checked", sentence)
        return
    if sources:
        yield _results(opened, printed, sources, progress)
    progress("laying out the report")
    yield _pages(opened, printed, sources or None, templates)


def _results(opened: Opened, printed: Findings, sources: Mapping[str, bytes], progress: Callable[[str], None]) -> Check:
    from metrology.findings import to_json

    try:
        again = _evaluated(opened, sources, progress)
    except MetrologyError as error:
        return failed("results", f"the attached inputs cannot be evaluated: {error.faults[0]}")
    if _versions(again, printed):
        return _compared(again, printed)
    found = agreement.compare(to_json(again), opened.attachments[RESULTS])
    if found.agrees:
        sentence = f"the attached inputs give all {len(again.results)} results of {RESULTS}, {found.sentence}"
        return good("results", sentence)
    where = next(iter(differences(again, printed)), found.sentence)
    return failed("results", f"the attached {RESULTS} does not hold what the attached inputs give: {where}")


def _evaluated(opened: Opened, sources: Mapping[str, bytes], progress: Callable[[str], None]) -> Findings:
    from metrology import chain
    from metrology.campaign.load import load

    with TemporaryDirectory(prefix="metrology-") as home:
        for path, content in sources.items():
            place = Path(home).joinpath(*_inside(path))
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        return chain.evaluate(load(Path(home).joinpath(*_inside(opened.inputs[0].path))), progress=progress)


def _inside(path: str) -> tuple[str, ...]:
    """Parts of an attached file's path; whoever wrote the PDF chose it, so it must not lead anywhere else."""
    from metrology.errors import Fault

    parts = PurePosixPath(path).parts
    if not parts or ".." in parts or PurePosixPath(path).is_absolute() or "\\" in path or "\0" in path:
        raise MetrologyError(Fault(path, "a path that leaves the campaign's folder", "a path within it"))
    return parts


def _compared(again: Findings, printed: Findings) -> Check:
    """Judge results by other versions, for which a tolerance holds."""
    differing = differences(again, printed)
    versions = _versions(again, printed)
    if differing:
        sentence = f"the attached {RESULTS} does not hold what the attached inputs give: {differing[0]} ({versions})"
        return failed("results", sentence)
    sentence = f"the attached inputs give the results of {RESULTS}, within {TOLERANCE:g} u ({versions})"
    return good("results", sentence)


def differences(again: Findings, printed: Findings) -> list[str]:
    """Every result, verdict or failure that two evaluations do not share, in words; numbers within `TOLERANCE`."""
    olds, news = ({result.name: result for result in findings.results} for findings in (printed, again))
    found = [f"{name} is in one of them only" for name in olds.keys() ^ news.keys()]
    found += [words for name in olds.keys() & news.keys() if (words := _difference(news[name], olds[name]))]
    old, new = ({entry.requirement: entry.verdict for entry in findings.conformity} for findings in (printed, again))
    found += [
        f"verdict on {name}: {new.get(name)} for {old.get(name)}"
        for name in old | new
        if old.get(name) != new.get(name)
    ]
    return sorted(found)


def _difference(again: Result, printed: Result) -> str:
    pairs = {
        "value": (again.value, printed.value),
        "u": (again.u, printed.u),
        "lower end": (again.interval[0], printed.interval[0]),
        "upper end": (again.interval[1], printed.interval[1]),
    }
    for name, (new, old) in pairs.items():
        if not _alike(new, old, TOLERANCE * printed.u):
            return f"{printed.name}, {name}: {new} for {old} {printed.unit}"
    return ""


def _alike(new: float | None, old: float | None, within: float) -> bool:
    if new is None or old is None or not (isfinite(new) and isfinite(old)):
        return new is old or str(new) == str(old)
    return abs(new - old) <= max(within, 1e-12 * abs(old))


def _versions(again: Findings, printed: Findings) -> str:
    """Versions that differ, as a remark; empty where all are the same."""
    other = [
        f"{name} {again.software.get(name, 'missing')} for {printed.software.get(name, 'none')}"
        for name in sorted({*again.software, *printed.software})
        if again.software.get(name) != printed.software.get(name)
    ]
    return f"other versions here: {', '.join(other)}" if other else ""


def _pages(opened: Opened, printed: Findings, sources: Mapping[str, bytes] | None, templates: Path | None) -> Check:
    from metrology import chain, report

    here = chain.software()
    other = [name for name, version in printed.software.items() if here.get(name) != version]
    if other:
        sentence = f"other versions are installed here than made the report ({', '.join(sorted(other))})"
        return Check("pages", "not checked", sentence)
    made = report.make(printed, sources=sources, templates=templates)["report.pdf"]
    if made == opened.unsigned:
        return good("pages", "made again from the attachments, the unsigned part is the same, byte for byte")
    return failed(
        "pages",
        f"what is printed is not what the attached {RESULTS} gives, laid out again; the report was changed before it"
        " was signed, or made with templates of the laboratory's own (--templates), or with other native libraries"
        " (Pango, HarfBuzz)",
    )
