"""A report made again from its own attachments: whether inputs give the results, and results the pages."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from math import isfinite
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from metrology.errors import MetrologyError
from metrology.signoff import agreement, printed
from metrology.signoff.opened import RESULTS, Opened
from metrology.signoff.verdict import Check, failed, good, unchecked

if TYPE_CHECKING:
    from metrology.findings import Findings

TOLERANCE = 0.01
"""Of the standard uncertainty: how far a result by other versions may lie off and still be the same result."""
CODE = "the campaign names Python code of its own: read what is attached, then give --allow-code"


def checks(
    opened: Opened, templates: Path | None, progress: Callable[[str], None], *, allow_code: bool = False
) -> Iterator[Check]:
    """Evaluate the attached inputs, read the pages back, lay the report out, and compare with what the file holds."""
    sources = opened.sources()
    if len(sources) < len(opened.inputs):
        hashed = all(file.path in sources for file in opened.inputs if file.attached)
        reason = "the inputs are not attached" if not sources else "attached inputs are missing"
        reason = "of some inputs the hash alone is there" if sources and hashed else reason
        yield unchecked("results", f"{reason}, so nothing can be computed from them")
        sources = sources if hashed else {}
    else:
        yield _results(opened, sources, progress, allow_code=allow_code)
    progress("reading the pages back")
    yield _numbers(opened)
    progress("laying out the report")
    yield _pages(opened, sources or None, templates, allow_code=allow_code)


def _results(
    opened: Opened, sources: Mapping[str, bytes], progress: Callable[[str], None], *, allow_code: bool
) -> Check:
    from metrology.findings import to_json

    if not allow_code and any(path.endswith(".py") for path in sources):
        return unchecked("results", CODE)
    try:
        again = to_json(_released(_evaluated(opened, sources, progress, allow_code=allow_code), opened.stated))
    except MetrologyError as error:
        return failed("results", f"the attached inputs cannot be evaluated: {error.faults[0]}")
    there, here = opened.stated, json.loads(again)
    found = agreement.compare(again, opened.attachments[RESULTS])
    versions = _versions(here, there)
    if versions:
        return _by_another(here, there, found, versions)
    if found.agrees:
        sentence = f"the attached inputs give all {len(here['results'])} results of {RESULTS}, {found.sentence}"
        return good("results", sentence)
    where = next(iter(differences(here, there)), found.sentence)
    return failed("results", f"the attached {RESULTS} does not hold what the attached inputs give: {where}")


def _released(findings: Findings, stated: Mapping[str, Any]) -> Findings:
    """Findings with the parts that the report has: they may be others than the campaign asks for (`report --part`)."""
    try:
        parts = tuple(str(part) for part in stated["campaign"]["parts"])
    except (KeyError, TypeError):
        return findings
    return replace(findings, campaign=replace(findings.campaign, parts=parts))  # type: ignore[arg-type]


def _by_another(here: Mapping[str, Any], there: Mapping[str, Any], found: agreement.Agreement, versions: str) -> Check:
    """What can be said of results by versions that are not installed here: whether these give others."""
    try:
        differing = differences(here, there)
    except ValueError as error:
        return unchecked("results", f"{error} ({versions})")
    if differing:
        sentence = f"the attached {RESULTS} does not hold what the attached inputs give: {differing[0]} ({versions})"
        return failed("results", sentence)
    rest = f"all of {RESULTS} the same" if found.agrees else f"but {found.sentence}"
    sentence = f"the versions here give the results of {RESULTS} within {TOLERANCE:g} u, {rest}; not the same program"
    return unchecked("results", f"{sentence} ({versions})")


def _evaluated(
    opened: Opened, sources: Mapping[str, bytes], progress: Callable[[str], None], *, allow_code: bool
) -> Findings:
    from metrology import chain
    from metrology.campaign.load import load

    with TemporaryDirectory(prefix="metrology-") as home:
        for path, content in sources.items():
            place = Path(home).joinpath(*_inside(path))
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        campaign = load(Path(home).joinpath(*_inside(opened.inputs[0].path)), allow_code=allow_code)
        # A report by `--no-coverage` has none to compare.
        coverage = any(isinstance(one, dict) and one.get("attained") for one in opened.stated.get("results", ()))
        return chain.evaluate(campaign, progress=progress, coverage=coverage)


def _inside(path: str) -> tuple[str, ...]:
    """Parts of an attached file's path; whoever wrote the PDF chose it, so it must not lead anywhere else."""
    from metrology.errors import Fault

    parts = PurePosixPath(path).parts
    if not parts or ".." in parts or PurePosixPath(path).is_absolute() or "\\" in path or "\0" in path:
        raise MetrologyError(Fault(path, "a path that leaves the campaign's folder", "a path within it"))
    return parts


def differences(again: Mapping[str, Any], there: Mapping[str, Any]) -> list[str]:
    """Every result or verdict that two `results.json`, of whatever versions, do not share; numbers within `TOLERANCE`.

    Raises
    ------
    ValueError
        Where one of them does not hold results as this version does.
    """
    try:
        olds, news = ({str(result["name"]): result for result in one["results"]} for one in (there, again))
        found = [f"{name} is in one of them only" for name in olds.keys() ^ news.keys()]
        found += [words for name in olds.keys() & news.keys() if (words := _difference(name, news[name], olds[name]))]
        old, new = ({e["requirement"]: e["verdict"] for e in one.get("conformity", ())} for one in (there, again))
        pairs = ((name, new.get(name), old.get(name)) for name in old | new)
        found += [f"verdict on {name}: {now} for {then}" for name, now, then in pairs if now != then]
    except (KeyError, TypeError, AttributeError):
        raise ValueError(f"{RESULTS} holds no results as this version reads them") from None
    return sorted(found)


def _difference(name: str, again: Mapping[str, Any], there: Mapping[str, Any]) -> str:
    pairs = {
        "value": (again["value"], there["value"]),
        "u": (again["u"], there["u"]),
        "lower end": (again["coverage"]["low"], there["coverage"]["low"]),
        "upper end": (again["coverage"]["high"], there["coverage"]["high"]),
    }
    if again["unit"] != there["unit"]:
        return f"{name}, unit: {again['unit']} for {there['unit']}"
    for part, (new, old) in pairs.items():
        if not _alike(new, old, TOLERANCE * again["u"]):
            return f"{name}, {part}: {new} for {old} {there['unit']}"
    return ""


def _alike(new: float | None, old: float | None, within: float) -> bool:
    if new is None or old is None or not (isfinite(new) and isfinite(old)):
        return new is old or str(new) == str(old)
    return abs(new - old) <= max(within, 1e-12 * abs(old))


def _versions(here: Mapping[str, Any], there: Mapping[str, Any]) -> str:
    """Versions that differ, as a remark; empty where all are the same."""
    mine, theirs = ({"schema": one.get("schema"), **_software(one)} for one in (here, there))
    other = [
        f"{name} {mine.get(name, 'missing')} for {theirs.get(name, 'none')}"
        for name in sorted({*mine, *theirs})
        if mine.get(name) != theirs.get(name)
    ]
    return f"other versions here: {', '.join(other)}" if other else ""


def _software(one: Mapping[str, Any]) -> Mapping[str, Any]:
    software = one.get("software")
    return software if isinstance(software, Mapping) else {}


def _numbers(opened: Opened) -> Check:
    """Whether the pages print the results that `results.json` holds, whichever version wrote them."""
    try:
        found = printed.absent(_expected(opened.stated), printed.numbers(opened.content))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        return unchecked("numbers", f"what is printed cannot be read back ({error})")
    if found:
        rest = f" and {len(found) - 1} more" if len(found) > 1 else ""
        return failed(
            "numbers", f"no page prints value and u as {RESULTS} holds them (page 1: the main ones): {found[0]}{rest}"
        )
    return good("numbers", f"read back from the pages, values and u are those of {RESULTS}")


def _expected(stated: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Results that the parts of the report print: the certificate the main ones, the quality records the others too."""
    parts = stated["campaign"].get("parts", ("quality",))
    return [one for one in stated["results"] if one.get("headline", True) or "quality" in parts]


def _pages(opened: Opened, sources: Mapping[str, bytes] | None, templates: Path | None, *, allow_code: bool) -> Check:
    from metrology import chain, report
    from metrology.findings import SCHEMA, from_json
    from metrology.report.pango import UnprintedError, how

    here = chain.software()
    there = _software(opened.stated)
    other = sorted(name for name in {*here, *there} if there.get(name) != here.get(name))
    if other:
        return unchecked("pages", f"other versions are installed here than made the report ({', '.join(other)})")
    unread = unchecked("pages", f"this version does not read {RESULTS}, which another one made")
    if opened.stated.get("schema") != SCHEMA:
        return unread
    try:
        findings = from_json(opened.attachments[RESULTS])
    except ValueError:
        return unread
    try:
        made = report.make(findings, sources=sources, templates=templates, allow_code=allow_code)[report.PDF]
    except UnprintedError:
        return unchecked("pages", f"they cannot be laid out again: Pango is missing ({how()})")
    if made == opened.unsigned:
        return good("pages", "made again from the attachments, the unsigned part is the same, byte for byte")
    return _other_bytes(made, opened)


def _other_bytes(made: bytes, opened: Opened) -> Check:
    """Pages that are not the same bytes: other words or drawings, or the same ones by other native libraries."""
    try:
        where = printed.difference(made, opened.unsigned)
    except ValueError as error:
        where = f"pages that cannot be read back ({error})"
    if not where:
        sentence = f"laid out again from {RESULTS}, the pages show the same words and as many drawings, by other bytes"
        return unchecked("pages", f"{sentence}: other native libraries (Pango, HarfBuzz), or other fonts")
    return failed(
        "pages",
        f"what is printed is not what the attached {RESULTS} gives, laid out again ({where}); the report was changed"
        " before it was signed, or made with templates of the laboratory's own (--templates)",
    )
