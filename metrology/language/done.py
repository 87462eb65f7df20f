"""What was done, in one sentence a test; tests and results by names that their reader knows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from metrology.coordinate import QUANTITIES
from metrology.language.display import number, symbol
from metrology.language.wording import lowered

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.tested import TestItem


LISTS = ("records", "readings", "runs", "specimens", "force")
"""Fields of a finding that say how much was evaluated."""


def called(findings: Findings) -> Mapping[str, str]:
    """Name in the campaign file of every test → item and method, with that name where two tests share them."""
    samples = {sample.id: sample.name for sample in findings.samples}
    found = {}
    for test in findings.tests:
        item = samples.get(test.sample, test.sample)
        method = lowered(test.title.removesuffix(f": {item}"))
        found[test.id] = f"{item}, {method}" if item else method
    twice = Counter(found.values())
    return {test: name if twice[name] == 1 else f"{name} ({test})" for test, name in found.items()}


def result_name(name: str, findings: Findings) -> str:
    """``al-1100-elongation.k`` → ``k of Al-1100 tape, elongation under dead loads``; other names as they are."""
    result = next((one for one in findings.results if one.name == name), None)
    if result is None:
        return name
    samples = {sample.id: sample.name for sample in findings.samples}
    owner = called(findings).get(result.test) or samples.get(result.sample, result.sample)
    return f"{symbol(result.quantity)} of {owner}" if owner else symbol(result.quantity)


def short_name(name: str, findings: Findings) -> str:
    """``al-1100-elongation.k`` → ``k, Al-1100 tape, elongation``, for a plot; other names as they are."""
    result = next((one for one in findings.results if one.name == name), None)
    if result is None:
        return name
    samples = {sample.id: sample.name for sample in findings.samples}
    parts = (symbol(result.quantity).replace("_n", "ₙ"), samples.get(result.sample, result.sample), result.method)
    return ", ".join(part for part in parts if part and part != "derived")


def sentences(findings: Findings) -> list[str]:
    """One sentence a test on what was done."""
    names = called(findings)
    return [f"{names[test.id]}: {_sentence(test)}{_kept(findings, test)}." for test in findings.tests]


def _kept(findings: Findings, test: TestItem) -> str:
    """How many runs were kept from the fit for the validation of the model."""
    runs = next((one["runs"] for one in findings.verification if one["test"] == test.id), ())
    return f"; {_count(len(runs), 'run')} {'was' if len(runs) == 1 else 'were'} kept for its validation" if runs else ""


def _sentence(test: TestItem) -> str:
    if test.finding is None:
        return "no evaluation was possible"
    spoken = {"elongation": _elongation, "decay": _decay, "response": _response, "relaxation": _relaxation}.get(
        test.by, _any
    )
    return spoken(test.finding)


def _elongation(finding: Any) -> str:
    forces = [level.force for level in finding.levels]
    span = f"from {number(min(forces))} N to {number(max(forces))} N" if forces else ""
    kept = sum(not reason for reason in finding.excluded)
    return (
        f"the extension was read {len(finding.force)} times under {len(forces)} dead loads {span}, "
        f"in {len(finding.repeats)} passes; a straight line through {kept} readings gives the stiffness"
    )


def _decay(finding: Any) -> str:
    angular = finding.unit == "rad"
    count = sum(sum(record.peak_used) for record in finding.records)
    carried = (
        f"a {'moment of inertia' if angular else 'mass'} of {number(finding.mass, 4)} {'kg·m²' if angular else 'kg'}"
    )
    return (
        f"{carried} was released {_times(len(finding.records))} and its free oscillation recorded; the decay of "
        f"{count} peaks gives the damping, their interval the frequency"
    )


def _response(finding: Any) -> str:
    channels = list(dict.fromkeys(one.channel for run in finding.runs for one in run.channels))
    words = [QUANTITIES[finding.coordinate][name].word for name in channels]
    read = f" of {', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else ""
    if finding.status == "given" or not finding.runs:
        return "the recorded runs were compared with a simulation with given values"
    return f"records{read} of {_count(len(finding.runs), 'run')} identify the model"


def _relaxation(finding: Any) -> str:
    levels = max(len(one.levels) for one in finding.specimens)
    longest = max((hold for one in finding.specimens for hold in one.holds), default=0.0)
    held = f"held at {_count(levels, 'level')} for up to {number(longest, 3)} s" if levels else "raised and not held"
    form = finding.forms[0]
    drift = " and a drift of the readings" if form.drift else ""
    return (
        f"the {finding.held} of {_count(len(finding.specimens), 'specimen')} was {held}; the readings support "
        f"{'an elastic specimen' if form.name == 'elastic' else form.name}{drift}"
        f"{'' if finding.at is None else f'; the stated time is {finding.at:g} s after a step'}"
    )


def _any(finding: Any) -> str:
    """What a method without words here has evaluated, from what its finding lists."""
    from dataclasses import fields

    lists = [(field.name, getattr(finding, field.name)) for field in fields(finding)]
    sizes = [f"{len(value)} {name.replace('_', ' ')}" for name, value in lists
             if isinstance(value, tuple) and value and name in LISTS]  # fmt: skip
    return f"evaluated from {sizes[0]}" if sizes else "evaluated by the method named in the annex"


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _count(count: int, word: str) -> str:
    return f"{count} {word}{'' if count == 1 else 's'}"
