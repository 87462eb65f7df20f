"""What was done, in one sentence a test; tests and results by names that their reader knows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from metrology.coordinate import QUANTITIES
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import symbol
from metrology.message import Sentence, counted, said

if TYPE_CHECKING:
    from metrology.findings import Findings, Result
    from metrology.tested import TestItem


def called(findings: Findings, language: Language = ENGLISH) -> Mapping[str, str]:
    """Name in the campaign file of every test → item and method, with that name where two tests share them."""
    samples = {sample.id: sample.name for sample in findings.samples}
    found = {}
    for test in findings.tests:
        item = samples.get(test.sample, test.sample)
        method = language.lowered(test.title.removesuffix(f": {item}"))
        found[test.id] = f"{item}, {method}" if item else method
    twice = Counter(found.values())
    return {test: name if twice[name] == 1 else f"{name} ({test})" for test, name in found.items()}


def title(test: TestItem, findings: Findings, language: Language = ENGLISH) -> str:
    """Title of a test, which names its item where the campaign gives it no other one."""
    item = next((sample.name for sample in findings.samples if sample.id == test.sample), test.sample)
    method = test.title.removesuffix(f": {item}")
    if method == test.title:
        return language.spoken(test.title)
    return f"{language.word(method)}{language.word(': ')}{item}"


def result_name(name: str, findings: Findings, language: Language = ENGLISH) -> str:
    """``al-1100-elongation.k`` → ``k of Al-1100 tape, elongation under dead loads``; other names as they are."""
    result = next((one for one in findings.results if one.name == name), None)
    if result is None:
        return name
    samples = {sample.id: sample.name for sample in findings.samples}
    owner = called(findings, language).get(result.test) or samples.get(result.sample, result.sample)
    text = symbol(result.quantity)
    return language.say("{symbol} of {owner}", symbol=text, owner=owner) if owner else text


def by_method(result: Result, language: Language = ENGLISH) -> str:
    """Word for the method of a result; nothing for a derived quantity."""
    return "" if result.method == "derived" else language.word(result.method, "method")


def short_name(name: str, findings: Findings, language: Language = ENGLISH) -> str:
    """``al-1100-elongation.k`` → ``k, Al-1100 tape, elongation``, for a plot; other names as they are."""
    result = next((one for one in findings.results if one.name == name), None)
    if result is None:
        return name
    samples = {sample.id: sample.name for sample in findings.samples}
    item = samples.get(result.sample, result.sample)
    parts = (symbol(result.quantity).replace("_n", "ₙ"), item, by_method(result, language))
    return ", ".join(part for part in parts if part)


def sentences(findings: Findings, language: Language = ENGLISH) -> list[str]:
    """One sentence a test on what was done."""
    names = called(findings, language)
    return [
        language.say("{name}: {what}.", name=names[test.id], what=_kept(findings, test, language))
        for test in findings.tests
    ]


def _kept(findings: Findings, test: TestItem, language: Language) -> str:
    """What was done, and how many runs were kept from the fit for the validation of the model."""
    what = _sentence(test, language)
    runs = next((one["runs"] for one in findings.verification if one["test"] == test.id), ())
    if not runs:
        return what
    one, many = "{count} run was kept for its validation", "{count} runs were kept for its validation"
    return f"{what}{language.word('; ')}{language.count(one, many, len(runs))}"


def _sentence(test: TestItem, language: Language) -> str:
    if test.finding is None:
        return language.say("no evaluation was possible")
    spoken = {"elongation": _elongation, "decay": _decay, "response": _response, "relaxation": _relaxation}.get(
        test.by, _any
    )
    return spoken(test.finding, language)


def _elongation(finding: Any, language: Language) -> str:
    forces = [level.force for level in finding.levels]
    if not forces:
        return language.say("no evaluation was possible")
    return language.say(
        "the extension was read {readings} times under {loads} dead loads from {low:number} N to {high:number} N, "
        "in {passes} passes; a straight line through {kept} readings gives the stiffness",
        readings=len(finding.force),
        loads=len(forces),
        low=min(forces),
        high=max(forces),
        passes=len(finding.repeats),
        kept=sum(not reason for reason in finding.excluded),
    )


def _decay(finding: Any, language: Language) -> str:
    what = (
        language.say("a moment of inertia of {size:number 4} kg·m²", size=finding.mass)
        if finding.unit == "rad"
        else language.say("a mass of {size:number 4} kg", size=finding.mass)
    )
    return language.say(
        "{what} was released {times} and its free oscillation recorded; the decay of {peaks} peaks gives the damping, "
        "their interval the frequency",
        what=what,
        times=_times(len(finding.records), language),
        peaks=sum(sum(record.peak_used) for record in finding.records),
    )


def _response(finding: Any, language: Language) -> str:
    channels = list(dict.fromkeys(one.channel for run in finding.runs for one in run.channels))
    words = [language.word(QUANTITIES[finding.coordinate][name].word) for name in channels]
    if finding.status == "given" or not finding.runs:
        return language.say("the recorded runs were compared with a simulation with given values")
    if len(words) < 2:
        one, many = "records of {count} run identify the model", "records of {count} runs identify the model"
        return language.count(one, many, len(finding.runs))
    return language.count(
        "records of {first} and {last} of {count} run identify the model",
        "records of {first} and {last} of {count} runs identify the model",
        len(finding.runs),
        first=", ".join(words[:-1]),
        last=words[-1],
    )


def _relaxation(finding: Any, language: Language) -> str:
    parts = [_held(finding, language), _supported(finding, language)]
    if finding.at is not None:
        parts.append(language.say("the stated time is {time:g} s after a step", time=finding.at))
    return language.word("; ").join(parts)


def _held(finding: Any, language: Language) -> str:
    levels = max(len(one.levels) for one in finding.specimens)
    holds = [hold for one in finding.specimens for hold in one.holds]
    specimens = language.count("{count} specimen", "{count} specimens", len(finding.specimens))
    if not levels and finding.held == "load":
        return language.say("the load of {specimens} was raised and not held", specimens=specimens)
    if not levels:
        return language.say("the elongation of {specimens} was raised and not held", specimens=specimens)
    known: dict[str, Any] = {
        "specimens": specimens,
        "levels": language.count("{count} level", "{count} levels", levels),
        "time": max(holds, default=0.0),
    }
    if finding.held == "load":
        return language.say("the load of {specimens} was held at {levels} for up to {time:number} s", **known)
    return language.say("the elongation of {specimens} was held at {levels} for up to {time:number} s", **known)


def _supported(finding: Any, language: Language) -> str:
    form = finding.forms[0]
    name = language.say("an elastic specimen") if form.name == "elastic" else language.spoken(in_words(form.name))
    if form.drift:
        return language.say("the readings support {form} and a drift of the readings", form=name)
    return language.say("the readings support {form}", form=name)


def in_words(form: str) -> Sentence:
    """A form of relaxation: so many branches, a power law, elastic."""
    branches, _, word = form.partition(" ")
    return counted("{count} branch", "{count} branches", int(branches)) if word.startswith("branch") else said(form)


_SIZES = {
    "records": ("evaluated from {count} record", "evaluated from {count} records"),
    "readings": ("evaluated from {count} reading", "evaluated from {count} readings"),
    "runs": ("evaluated from {count} run", "evaluated from {count} runs"),
    "specimens": ("evaluated from {count} specimen", "evaluated from {count} specimens"),
    "force": ("evaluated from {count} reading of the force", "evaluated from {count} readings of the force"),
}
"""Fields of a finding that say how much was evaluated."""


def _any(finding: Any, language: Language) -> str:
    """What a method without words here has evaluated, from what its finding lists."""
    from dataclasses import fields

    for name in (field.name for field in fields(finding) if field.name in _SIZES):
        if isinstance(listed := getattr(finding, name), tuple) and listed:
            return language.count(*_SIZES[name], len(listed))
    return language.say("evaluated by the method named in the annex")


def _times(count: int, language: Language) -> str:
    if count < 3:
        return language.say("once") if count == 1 else language.say("twice")
    return language.say("{count} times", count=count)
