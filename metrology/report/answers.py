"""One page that a manager understands: what is wrong, why, how sure, what it is worth, what to do next."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import assert_never

from metrology.coordinate import QUANTITIES
from metrology.diagnosis import Cause, Detectable, Diagnosis, Discrepancy, Gain, Value
from metrology.report.display import chance, number, percent, rounded, unit_text
from metrology.report.wording import lowered, opening, prose

VAGUE = 100.0
"""Standard uncertainty over the value from which on a parameter is called not determined."""
MANY = 3
"""Effects that a sentence lists at most."""


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
    questions = ("What is wrong?", "Why?", "How sure is that?", "What is it worth?", "What to do next?")
    told = list(zip(questions, (wrong, why, sure, worth, then), strict=True))
    if finding.discrepancy is not None:
        told.append(("Why is it off its reference?", f"{finding.discrepancy.sentence} {decides(finding.discrepancy)}"))
    return tuple((question, prose(answer)) for question, answer in told if answer)


def parted(found: Discrepancy) -> str:
    """What page 1 says of a result off its reference."""
    allowed = [lowered(one.title) for one in found.explanations if one.judgement == "allowed"]
    side = "below" if found.ratio < 1 else "above"
    causes = " or ".join(allowed[:MANY]) + (f" or {len(allowed) - MANY} more" if len(allowed) > MANY else "")
    return (
        f"{found.quantity} is {percent(abs(1 - found.ratio))} {side} its reference; "
        f"{f'these data allow {causes}' if allowed else 'no single cause is allowed by what is stated'}."
    )


def decides(found: Discrepancy) -> str:
    """The measurements that decide: of the first causes that are allowed, each once."""
    allowed = [one for one in found.explanations if one.judgement == "allowed"]
    tests = list(dict.fromkeys(f"{lowered(one.title)}: {one.measurement}" for one in allowed))[:MANY]
    return f"What decides: {'; '.join(tests)}." if tests else ""


def _nothing(finding: Diagnosis) -> tuple[str, ...]:
    tested = [one for one in finding.causes if one.verdict != "not testable"]
    shown = [one for one in finding.detectable if one.size is not None][:MANY]
    open_ = [lowered(one.title) for one in finding.causes if one.verdict == "not testable"]
    return (
        f"Nothing that these data can show. The residuals are noise{_reduced(finding)}.",
        f"{len(tested)} known causes were considered; none is supported by the evidence.",
        " ".join(one.sentence for one in finding.tests)
        + (f" Would have shown: {'; '.join(map(_visible, shown))}." if shown else ""),
        "No extension is worth adding: the results stand as they are.",
        "Nothing has to be mended." + (f" These data cannot test: {_listed(open_)}; "
        "what would be needed stands below." if open_ else ""),
    )  # fmt: skip


def _named(finding: Diagnosis) -> tuple[str, ...]:
    supported = [one for one in finding.causes if one.verdict == "supported"]
    possible = [one for one in finding.causes if one.verdict in ("supported", "indistinguishable")]
    words = [one.title for one in supported]
    wrong = f"The model lacks: {'; '.join(words)}." if words else "The model lacks one of several effects."
    for group in finding.groups:
        titles = [one.title for name in group for one in finding.causes if one.effect == name]
        wrong += f" These data cannot tell apart: {'; '.join(titles)}."
    why = " ".join(f"{_sized(one)} Left out of the model: {_ended(one.consequence)}" for one in possible[:MANY])
    sure = " ".join(_certainty(one) for one in possible[:MANY])
    others = [one.probability for one in finding.causes if one.verdict == "not supported" and one.log_bayes is not None]
    sure += f" The best of the others that were tried has {chance(max(others))}." if others else ""
    then = " ".join(f"{one.title}: {_ended(one.advice)}" for one in possible[:MANY])
    telling = " ".join(_ended(one.measurement) for one in finding.discriminating_tests[:MANY])
    return wrong, why, sure, _value(finding), then + (f" To tell them apart: {telling}" if telling else "")


def _unknown(finding: Diagnosis) -> tuple[str, ...]:
    failed = [one for one in finding.tests if not one.passed]
    told = finding.missing.sentence if finding.missing else ""
    known = "k, E and c" if finding.coordinate == "position" else "k and c"
    return (
        f"Something is missing{_reduced(finding)}. {told}",
        finding.sentence,
        " ".join(opening(one.sentence) for one in failed),
        f"Until the cause is known, {known} of this test hold for the motion that was tested, not beyond it. "
        + _value(finding),
        "Look at the picture for what it depends on, then change one thing at a time (amplitude, load, speed, "
        "mounting) and repeat a run. A known effect of the laboratory's own can be added to the table.",
    )  # fmt: skip


def short(finding: Diagnosis) -> str:
    """What page 1 says."""
    gain = max(finding.gain.values(), key=lambda one: one.ratio, default=None)
    shift = max(finding.shifts, key=lambda one: abs(one.shift), default=None)
    words = f"the model lacks {_lacking(finding)}." if finding.possible else finding.sentence
    if finding.verdict != "unexplained" and gain is not None:
        words += f" Residuals of held-out data fall {number(gain.ratio)}-fold."
    if finding.verdict != "unexplained" and shift is not None and abs(shift.shift) >= 1:
        words += f" {shift.name} moves by {number(shift.shift, 2)} of its u."
    return words


def _lacking(finding: Diagnosis) -> str:
    """What is named for certain, then one of each group whose members these data cannot tell apart."""
    titles = {one.effect: lowered(one.title) for one in finding.causes}
    parts = [titles[name] for name in finding.named]
    grouped = finding.groups or ((finding.possible,) if finding.verdict == "ambiguous" else ())
    for group in grouped:
        names = [titles[name] for name in group if name in titles]
        beyond = f" or {len(names) - MANY} more" if len(names) > MANY else ""
        parts.append(f"one of the group {' / '.join(names[:MANY])}{beyond}")
    return " and ".join(parts)


def _certainty(cause: Cause) -> str:
    bayes = f", ln of the Bayes factor {evidence(cause)}" if cause.log_bayes is not None else ""
    return f"{cause.title}: probability {chance(cause.probability)}{bayes}."


def _value(finding: Diagnosis) -> str:
    """Gain on data that the fit has not seen, and what the results do."""
    if not finding.gain:
        return "No gain on held-out data was computed."
    channels = [f"{channel(finding, name)} {number(one.before)} → {number(one.after)} (ratio {ratio(one)})"
                for name, one in finding.gain.items()]  # fmt: skip
    told = f"Held-out residuals over noise, before → after: {'; '.join(channels)}."
    if finding.verdict == "unexplained":
        return f"What known effects take up of it: {told[0].lower()}{told[1:]}"
    moved = [
        f"{one.name} moves by {number(one.shift, 2)} of its u, from {rounded(one.before, one.u_before)[0]} to "
        f"{rounded(one.after, one.u_after)[0]} {unit_text(one.unit)}"
        for one in finding.shifts
    ]
    small = all(one.negligible for one in finding.causes if one.verdict == "supported")
    close = " Real, yet of no use: the base model serves as well." if small and finding.named else ""
    return told + (f" With the extension {'; '.join(moved)}." if moved else "") + close


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
    return f"{lowered(one.title)} {word} {number(one.size, 2)} {unit_text(one.unit)}".rstrip()


def _reduced(finding: Diagnosis) -> str:
    if finding.chi_squared is None:
        return ""
    return f" (χ² for each reading {number(finding.chi_squared[0], 3)}; 1 for noise alone)"


def _ended(text: str) -> str:
    return text if text.endswith(".") else f"{text}."


def _listed(names: Sequence[str]) -> str:
    head = ", ".join(names[:MANY])
    return head + (f" and {len(names) - MANY} more" if len(names) > MANY else "")


def evidence(cause: Cause) -> str:
    """Ln of the Bayes factor; a dash where the cause was not fitted."""
    if cause.log_bayes is None:
        return "–"
    return "> 10⁶" if cause.log_bayes > 1e6 else number(cause.log_bayes)


def parameter(one: Value) -> str:
    """Name, value ± u and the 95 % interval."""
    unit = unit_text(one.unit)
    if one.u > VAGUE * max(abs(one.value), 1e-300):
        return f"{one.name}: not determined"
    if not isfinite(one.u):
        return f"{one.name} = {number(one.value, 4)} {unit}".rstrip()
    value, u = rounded(one.value, one.u)
    low, high = ("open" if end is None else rounded(end, one.u)[0] for end in (one.low, one.high))
    return f"{one.name} = {value} ± {u} {unit}".rstrip() + f", 95 % {low} … {high}"


def ratio(one: Gain) -> str:
    """Ratio of residuals before and after with its interval."""
    return f"{number(one.ratio, 4)}, 95 % {number(one.low, 4)} … {number(one.high, 4)}"
