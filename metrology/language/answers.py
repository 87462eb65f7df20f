"""A diagnosis in five short answers: what is wrong, why, how certain, what it changes, what to do next."""

from __future__ import annotations

from typing import assert_never

from metrology.coordinate import QUANTITIES
from metrology.diagnosis import Cause, Detectable, Diagnosis, Shift
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.diagnosis_figures import evidence, parameter, smallest
from metrology.language.display import chance, number, rounded, symbol
from metrology.language.wording import opening, prose
from metrology.units import unit_text

MANY = 3
"""Effects that a sentence lists at most."""
FAR = 10.0
"""Standard uncertainties beyond which a number of them says no more than that the model was wrong."""


def answers(finding: Diagnosis, language: Language = ENGLISH) -> tuple[tuple[str, str], ...]:
    """Question and answer, in short sentences."""
    match finding.verdict:
        case "nothing missing":
            wrong, why, sure, worth, then = _nothing(finding, language)
        case "explained" | "explained in the main" | "ambiguous":
            wrong, why, sure, worth, then = _named(finding, language)
        case "unexplained" | "not testable" | "not finished":
            wrong, why, sure, worth, then = _unknown(finding, language)
        case _:
            assert_never(finding.verdict)
    questions = (
        language.say("What is wrong?"), language.say("Why?"), language.say("How certain is it?"),
        language.say("What does it change?"), language.say("What to do next?"),
    )  # fmt: skip
    given = list(zip(questions, (wrong, why, sure, worth, then), strict=True))
    if finding.discrepancy is not None:
        question = language.say("Why does it differ from its reference?")
        given.append((question, _printed(finding.discrepancy.sentence, language)))
    return tuple((question, answer if language.comma else prose(answer)) for question, answer in given if answer)


def _printed(text: str, language: Language) -> str:
    """A sentence of the findings with its numbers as they are printed."""
    if language.code == "en":
        return language.figures(prose(text))
    spoken = language.spoken(text)
    return prose(text) if spoken == text else spoken


def _nothing(finding: Diagnosis, language: Language) -> tuple[str, ...]:
    tested = sum(one.verdict != "not testable" for one in finding.causes)
    shown = tuple(_visible(one, language) for one in finding.detectable if one.size is not None)[:MANY]
    noise = language.say("Nothing that these data can show. The residuals are noise.")
    if finding.chi_squared is not None:
        text = (
            "Nothing that these data can show. The residuals are noise (χ² for each reading {chi:figures}; 1 for noise "
            "alone)."
        )
        noise = language.say(text, chi=number(finding.chi_squared[0], 3))
    one = "{count} known effect was considered; the data support none."
    many = "{count} known effects were considered; the data support none."
    passed = language.say(
        "{passed} of {tests} tests of the residuals are passed.",
        passed=sum(one.passed for one in finding.tests),
        tests=len(finding.tests),
    )
    smallest = language.say("Smallest detectable effects: {effects}.", effects=shown) if shown else ""
    return (
        noise,
        language.count(one, many, tested),
        _joined(passed, smallest),
        language.say("Nothing: the results are those of the model as stated."),
        language.say("No action is needed."),
    )


def _joined(*sentences: str) -> str:
    return " ".join(one for one in sentences if one)


def _named(finding: Diagnosis, language: Language) -> tuple[str, ...]:
    supported = tuple(language.lowered(one.title) for one in finding.causes if one.verdict == "supported")
    possible = [one for one in finding.causes if one.verdict in ("supported", "indistinguishable")]
    missing = language.say("Missing in the model: {what}.", what=supported) if supported else ""
    wrong = [missing or _undecided(finding, language)]
    for group in finding.groups:
        titles = tuple(
            language.lowered(one.title) for name in group for one in finding.causes if one.effect == name
        )  # fmt: skip
        alike, alone = "These data cannot distinguish: {titles}.", "Possible: {titles}."
        wrong.append(language.say(alike if len(group) > 1 else alone, titles=titles))
    why = [text for one in possible[:MANY] for text in (_sized(one, language), _without(one, language))]
    sure = [_certainty(one, language) for one in possible[:MANY]]
    others = [one.probability for one in finding.causes if one.verdict == "not supported" and one.log_bayes is not None]
    if others:
        text = "The most probable of the other effects has {chance:figures}."
        sure.append(language.say(text, chance=chance(max(others))))
    then = [
        language.say("{title}: {advice}", title=one.title, advice=_ended(language.spoken(one.advice)))
        for one in possible[:MANY]
    ]
    return _joined(*wrong), _joined(*why), _joined(*sure), _value(finding, language), _joined(*then)


def _unknown(finding: Diagnosis, language: Language) -> tuple[str, ...]:
    failed = [one for one in finding.tests if not one.passed]
    missing = _printed(finding.missing.sentence, language) if finding.missing else ""
    wrong = language.say("Something is missing.")
    if finding.chi_squared is not None:
        text = "Something is missing (χ² for each reading {chi:figures}; 1 for noise alone)."
        wrong = language.say(text, chi=number(finding.chi_squared[0], 3))
    modulus = "Until the cause is known, k, E and c of this test hold for the motion that was tested, not beyond it."
    turning = "Until the cause is known, k and c of this test hold for the motion that was tested, not beyond it."
    return (
        f"{wrong} {missing}",
        sentence(finding, language),
        " ".join(opening(_printed(one.sentence, language)) for one in failed),
        _joined(language.say(modulus if finding.coordinate == "position" else turning), _value(finding, language)),
        language.say(
            "See from the figures what it depends on; repeat a run with one condition changed (amplitude, load, speed, "
            "mounting). An effect that the laboratory knows can be added to the list."
        ),
    )


def short(finding: Diagnosis, language: Language = ENGLISH) -> str:
    """One sentence for the certificate."""
    if not finding.possible:
        return _without_names(finding, language.quoted(finding.sentence))
    titles = {one.effect: one.title for one in finding.causes}
    lacking = _lacking(finding, language)
    undecided = tuple(titles[name] for name in finding.undecided)
    sentences = (
        finding.verdict == "unexplained" and language.say("Something is missing that no listed effect explains."),
        lacking and language.say("Missing in the model: {what}.", what=lacking),
        undecided and language.say("Not decided by these data: {titles:lowered }.", titles=undecided),
        lacking and _far_off(finding, language),
    )
    return " ".join(one for one in sentences if one)


def _far_off(finding: Diagnosis, language: Language) -> str:
    """That readings lie far off beside what is named."""
    if all(one.passed for one in finding.tests if one.name == "normal noise"):
        return ""
    text = (
        "In addition, the noise is not normal: more readings lie far off than chance explains. Each may be misread, or "
        "the readings scatter so."
    )
    return language.say(text)


def _undecided(finding: Diagnosis, language: Language) -> str:
    if finding.undecided:
        return language.say("These data do not decide what is missing, if anything is.")
    return language.say("One of several effects is missing.")


def _lacking(finding: Diagnosis, language: Language) -> tuple[str, ...]:
    """What is named for certain, then one of each group whose members these data cannot tell apart."""
    titles = {one.effect: language.lowered(one.title) for one in finding.causes}
    parts = [titles[name] for name in finding.named]
    grouped = finding.groups or ((finding.possible,) if finding.verdict == "ambiguous" else ())
    for group in (one for one in grouped if len(one) > 1):
        names = tuple(titles[name] for name in group if name in titles)
        more = len(names) - MANY
        text = "one of {titles:stroke} or {more} more" if more > 0 else "one of {titles:stroke}"
        parts.append(language.say(text, titles=names[:MANY], more=more))
    return tuple(parts)


def _certainty(cause: Cause, language: Language) -> str:
    known = {"title": cause.title, "chance": chance(cause.probability)}
    if cause.log_bayes is None:
        return language.say("{title}: probability {chance:figures}.", **known)
    text = "{title}: probability {chance:figures}, ln of the Bayes factor {bayes:figures}."
    return language.say(text, bayes=evidence(cause), **known)


def _value(finding: Diagnosis, language: Language) -> str:
    """Gain on data that the fit has not seen, and what the results do."""
    if not finding.gain:
        return language.say("No prediction of held-out data was computed.")
    text = "{channel} {before:figures} → {after:figures}"
    channels = tuple(
        language.say(
            text, channel=channel(finding, name, language), before=number(one.before), after=number(one.after)
        )
        for name, one in finding.gain.items()
    )  # fmt: skip
    gain = language.say("Held-out residuals over noise, as stated → extended: {channels}.", channels=channels)
    if finding.verdict == "unexplained":
        return gain
    moved = tuple(_moved(one, language) for one in finding.shifts if abs(one.shift) >= 1)
    small = all(one.negligible for one in finding.causes if one.verdict == "supported")
    return _joined(
        gain,
        language.say("With the extension {changes}.", changes=moved) if moved else "",
        language.say("The effect is significant, and too small to matter.") if small and finding.named else "",
    )


def _moved(one: Shift, language: Language) -> str:
    """Change of a parameter in standard uncertainties of its value before; beyond `FAR` of them by its values alone."""
    before, after = rounded(one.before, one.u_before)[0], rounded(one.after, one.u_after)[0]
    known = {"symbol": symbol(one.name), "before": before, "after": f"{after} {unit_text(one.unit)}".rstrip()}
    if abs(one.shift) < FAR:
        less = "{symbol} decreases by {size:figures} u from {before:figures} to {after:figures}"
        more = "{symbol} increases by {size:figures} u from {before:figures} to {after:figures}"
        return language.say(less if one.shift < 0 else more, size=number(abs(one.shift), 2), **known)
    less = "{symbol} decreases from {before:figures} to {after:figures}"
    more = "{symbol} increases from {before:figures} to {after:figures}"
    return language.say(less if one.shift < 0 else more, **known)


def channel(finding: Diagnosis, name: str, language: Language = ENGLISH) -> str:
    """What a channel is called; one that is no symbol of a rig is a word by itself."""
    known = QUANTITIES[finding.coordinate]
    return language.word(known[name].word if name in known else name)


def _sized(cause: Cause, language: Language) -> str:
    """The effect and its size."""
    if not cause.parameters:
        return language.say("{title}.", title=cause.title)
    sizes = tuple(parameter(one, language) for one in cause.parameters)
    return language.say("{title}: {sizes}.", title=cause.title, sizes=sizes)


def _without(cause: Cause, language: Language) -> str:
    """What leaving it out does."""
    return language.say("Without it: {consequence}", consequence=_ended(language.spoken(cause.consequence)))


def _visible(one: Detectable, language: Language) -> str:
    text = "{title:lowered} off by {size:figures}" if one.unit == "1" else "{title:lowered} of {size:figures}"
    return language.say(text, title=one.title, size=smallest(one))


def sentence(finding: Diagnosis, language: Language = ENGLISH) -> str:
    """The verdict in words, without the names that effects have in campaign files."""
    return _without_names(finding, finding.sentence if language == ENGLISH else _printed(finding.sentence, language))


def _without_names(finding: Diagnosis, text: str) -> str:
    for one in finding.causes:
        text = text.replace(f" ({one.effect})", "")
    return text


def _ended(text: str) -> str:
    return text if text.endswith(".") else f"{text}."
