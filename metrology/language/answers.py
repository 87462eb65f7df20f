"""A diagnosis in five short answers: what is wrong, why, how certain, what it changes, what to do next."""

from __future__ import annotations

from math import isfinite
from typing import assert_never

from metrology.coordinate import QUANTITIES
from metrology.diagnosis import Cause, Detectable, Diagnosis, Gain, Shift, Value
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import chance, number, rounded, scale, symbol, unit_text
from metrology.language.wording import opening, prose
from metrology.message import lowered

VAGUE = 100.0
"""Standard uncertainty over the value from which on a parameter is called not determined."""
MANY = 3
"""Effects that a sentence lists at most."""
SURE = 100.0
"""Ln of a Bayes factor beyond which a larger one says no more."""
FAR = 10.0
"""Standard uncertainties beyond which a number of them says no more than that the model was wrong."""


def answers(finding: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Question and answer, in short sentences."""
    match finding.verdict:
        case "nothing missing":
            wrong, why, sure, worth, then = _nothing(finding)
        case "explained" | "explained in the main" | "ambiguous":
            wrong, why, sure, worth, then = _named(finding)
        case "unexplained" | "not testable" | "not finished":
            wrong, why, sure, worth, then = _unknown(finding)
        case _:
            assert_never(finding.verdict)
    questions = ("What is wrong?", "Why?", "How certain is it?", "What does it change?", "What to do next?")
    given = list(zip(questions, (wrong, why, sure, worth, then), strict=True))
    if finding.discrepancy is not None:
        given.append(("Why does it differ from its reference?", finding.discrepancy.sentence))
    return tuple((question, prose(answer)) for question, answer in given if answer)


def _nothing(finding: Diagnosis) -> tuple[str, ...]:
    tested = [one for one in finding.causes if one.verdict != "not testable"]
    shown = [one for one in finding.detectable if one.size is not None][:MANY]
    passed = sum(one.passed for one in finding.tests)
    return (
        f"Nothing that these data can show. The residuals are noise{_reduced(finding)}.",
        f"{len(tested)} known effect{'s were' if len(tested) != 1 else ' was'} considered; the data support none.",
        f"{passed} of {len(finding.tests)} tests of the residuals are passed."
        + (f" Smallest detectable effects: {'; '.join(map(_visible, shown))}." if shown else ""),
        "Nothing: the results are those of the model as stated.",
        "No action is needed.",
    )


def _named(finding: Diagnosis) -> tuple[str, ...]:
    supported = [one for one in finding.causes if one.verdict == "supported"]
    possible = [one for one in finding.causes if one.verdict in ("supported", "indistinguishable")]
    words = [one.title for one in supported]
    wrong = f"Missing in the model: {'; '.join(map(lowered, words))}." if words else _undecided(finding)
    for group in finding.groups:
        titles = [lowered(one.title) for name in group for one in finding.causes if one.effect == name]
        wrong += f" {'These data cannot distinguish' if len(group) > 1 else 'Possible'}: {'; '.join(titles)}."
    why = " ".join(f"{_sized(one)} Without it: {_ended(one.consequence)}" for one in possible[:MANY])
    sure = " ".join(_certainty(one) for one in possible[:MANY])
    others = [one.probability for one in finding.causes if one.verdict == "not supported" and one.log_bayes is not None]
    sure += f" The most probable of the other effects has {chance(max(others))}." if others else ""
    then = " ".join(f"{one.title}: {_ended(one.advice)}" for one in possible[:MANY])
    return wrong, why, sure, _value(finding), then


def _unknown(finding: Diagnosis) -> tuple[str, ...]:
    failed = [one for one in finding.tests if not one.passed]
    missing = finding.missing.sentence if finding.missing else ""
    known = "k, E and c" if finding.coordinate == "position" else "k and c"
    return (
        f"Something is missing{_reduced(finding)}. {missing}",
        sentence(finding),
        " ".join(opening(one.sentence) for one in failed),
        f"Until the cause is known, {known} of this test hold for the motion that was tested, not beyond it. "
        + _value(finding),
        "See from the figures what it depends on; repeat a run with one condition changed (amplitude, load, speed, "
        "mounting). An effect that the laboratory knows can be added to the list.",
    )  # fmt: skip


def short(finding: Diagnosis, language: Language = ENGLISH) -> str:
    """One sentence for the certificate."""
    if not finding.possible:
        return _without_names(finding, language.quoted(finding.sentence))
    titles = {one.effect: one.title for one in finding.causes}
    lacking = _lacking(finding, language)
    undecided = tuple(titles[name] for name in finding.undecided)
    sentences = (
        lacking and language.say("Missing in the model: {what}.", what=lacking),
        undecided and language.say("Not decided by these data: {titles:lowered }.", titles=undecided),
    )
    return " ".join(one for one in sentences if one)


def _undecided(finding: Diagnosis) -> str:
    if finding.undecided:
        return "These data do not decide whether anything is missing."
    return "One of several effects is missing."


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


def _certainty(cause: Cause) -> str:
    bayes = f", ln of the Bayes factor {evidence(cause)}" if cause.log_bayes is not None else ""
    return f"{cause.title}: probability {chance(cause.probability)}{bayes}."


def _value(finding: Diagnosis) -> str:
    """Gain on data that the fit has not seen, and what the results do."""
    if not finding.gain:
        return "No prediction of held-out data was computed."
    channels = [
        f"{channel(finding, name)} {number(one.before)} → {number(one.after)}" for name, one in finding.gain.items()
    ]
    words = f"Held-out residuals over noise, as stated → extended: {'; '.join(channels)}."
    if finding.verdict == "unexplained":
        return words
    moved = [_moved(one) for one in finding.shifts if abs(one.shift) >= 1]
    small = all(one.negligible for one in finding.causes if one.verdict == "supported")
    close = " The effect is significant, and too small to matter." if small and finding.named else ""
    return words + (f" With the extension {'; '.join(moved)}." if moved else "") + close


def _moved(one: Shift) -> str:
    """Change of a parameter in standard uncertainties of its value before; beyond `FAR` of them by its values alone."""
    way = "decreases" if one.shift < 0 else "increases"
    size = f" by {number(abs(one.shift), 2)} u" if abs(one.shift) < FAR else ""
    before, after = rounded(one.before, one.u_before)[0], rounded(one.after, one.u_after)[0]
    return f"{symbol(one.name)} {way}{size} from {before} to {after} {unit_text(one.unit)}".rstrip()


def channel(finding: Diagnosis, name: str) -> str:
    """What a channel is called; one that is no symbol of a rig is a word by itself."""
    known = QUANTITIES[finding.coordinate]
    return known[name].word if name in known else name


def _sized(cause: Cause) -> str:
    """The effect and its size."""
    if not cause.parameters:
        return f"{cause.title}."
    return f"{cause.title}: {'; '.join(parameter(one) for one in cause.parameters)}."


def _visible(one: Detectable) -> str:
    word = "off by" if one.unit == "1" else "of"
    return f"{lowered(one.title)} {word} {smallest(one)}"


def smallest(one: Detectable) -> str:
    """Smallest detectable size on the scale that reads well; a dash where there is none."""
    if one.size is None:
        return "–"
    size, unit = scale(one.size, one.unit)
    return f"{number(one.size / size, 2)} {unit}".rstrip()


def sentence(finding: Diagnosis) -> str:
    """The verdict in words, without the names that effects have in campaign files."""
    return _without_names(finding, finding.sentence)


def _without_names(finding: Diagnosis, text: str) -> str:
    for one in finding.causes:
        text = text.replace(f" ({one.effect})", "")
    return text


def _reduced(finding: Diagnosis) -> str:
    if finding.chi_squared is None:
        return ""
    return f" (χ² for each reading {number(finding.chi_squared[0], 3)}; 1 for noise alone)"


def _ended(text: str) -> str:
    return text if text.endswith(".") else f"{text}."


def evidence(cause: Cause) -> str:
    """Ln of the Bayes factor; beyond `SURE` no more than that, and a dash where the cause was not fitted."""
    if cause.log_bayes is None:
        return "–"
    if abs(cause.log_bayes) > SURE:
        return f"> {SURE:.0f}" if cause.log_bayes > 0 else f"< −{SURE:.0f}"
    return number(cause.log_bayes, 2)


def parameter(one: Value) -> str:
    """Name, value ± u and the 95 % interval."""
    name = one.name.rpartition(".")[2]
    if one.u > VAGUE * max(abs(one.value), 1e-300):
        return f"{name}: not determined"
    size, unit = scale(one.value, one.unit)
    if not isfinite(one.u):
        return f"{name} = {number(one.value / size)} {unit}".rstrip()
    value, u = rounded(one.value / size, one.u / size)
    low, high = (None if end is None else rounded(end / size, one.u / size)[0] for end in (one.low, one.high))
    match low, high:
        case None, None:
            ends = "interval open at both ends"
        case None, _:
            ends = f"up to {high}"
        case _, None:
            ends = f"from {low}"
        case _:
            ends = f"{low} … {high}"
    return f"{name} = {value} ± {u} {unit}".rstrip() + f", 95 % {ends}"


def ratio(one: Gain) -> str:
    """Ratio of residuals before and after with its interval."""
    return f"{number(one.ratio, 4)}, 95 % {number(one.low, 4)} … {number(one.high, 4)}"
