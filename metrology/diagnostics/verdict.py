"""From what was judged to causes, tables and sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from metrology.diagnosis import (
    Cause,
    Detectable,
    Diagnosis,
    Gain,
    Part,
    Remainder,
    Separation,
    Shift,
    Support,
    Supported,
    Test,
    Value,
)
from metrology.diagnostics import intervals
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.judgement import FAR, LIKELY, Judged
from metrology.diagnostics.search import COARSE, EQUAL
from metrology.diagnostics.sets import NEGLIGIBLE
from metrology.diagnostics.subject import Array, Fit, Subject
from metrology.diagnostics.supported import noise_of, spread, supported
from metrology.message import Sentence, counted, said

SHOWS = 5.0
"""Distance in standard deviations at which an effect is found nine times in ten at the usual prices."""
LOOSE = 30.0
"""Standard uncertainty over the size of a parameter from which on it is not printed of a cause that is not named."""
ANYTHING = "These data do not decide whether anything is missing; possible: {possible}; a law that is not listed."
WHAT = "Something is missing, but these data do not decide what; possible: {possible}; a law that is not listed."
MORE = {
    ANYTHING: "These data do not decide whether more is missing; possible: {possible}; a law that is not listed.",
    WHAT: "More is missing, but these data do not decide what; possible: {possible}; a law that is not listed.",
}
"""What is said in place of a sentence after another that names what is missing."""
EITHER = "one of {titles:comma}, which these data cannot distinguish"
ROUNDING, PLACES = 1e-12, 9
"""Part of a probability below which a difference from it is rounding; places to which two are compared."""


def failed(subject: Subject, test: str) -> Diagnosis:
    """Diagnosis of a base model that cannot be fitted."""
    sentence = said("The base model could not be fitted to these data: compare them with the stated model first.")
    return Diagnosis(
        subject.sample, subject.method, test, "not finished", sentence, (), (), {}, (), (), (), {},
        failures=(sentence,),
    )  # fmt: skip


def worded(judged: Judged, subject: Subject, gain: Mapping[str, Gain], test: str) -> Diagnosis:
    """Put what was judged, and the gain of the extension on blocks left out, into a `Diagnosis`."""
    extended = judged.is_extended
    causes = tuple(_causes(judged, subject, gain))
    unexplained = judged.verdict in ("unexplained", "explained in the main")
    missing = subject.missing(judged.last) if unexplained else None
    before, after = (one.chi_squared / max(one.count, 1) for one in (judged.base, judged.last))
    joint = supported(judged, subject)
    groups = tuple(group for group in judged.groups if _named(judged, group[0]) or len(group) == 1)
    model = dict(subject.extended(judged.last)) if extended else {}
    return Diagnosis(
        sample=subject.sample, method=subject.method, test=test, verdict=judged.verdict,
        sentence=_sentence(judged, subject, causes), tests=_tests(judged), causes=causes, gain=gain,
        residuals=_parts(judged, subject), groups=groups, discriminating_tests=tuple(_separations(judged, subject)),
        extended_model=model,
        detectable=tuple(_detectable(judged, subject)), shifts=_shifts(judged, joint), missing=missing,
        remainder=_remainder(judged, subject), chi_squared=(before, after), failures=judged.failures,
        supported=joint, ranges=_ranges(judged.last, model),
    )  # fmt: skip


def _ranges(fit: Fit, model: Mapping[str, float]) -> dict[str, tuple[float | None, float | None]]:
    """Ranges of parameters of the extended model, where there is a limit."""
    ranges = {entry.name: (entry.low, entry.high) for entry in fit.problem.unknowns if entry.name in model}
    finite = {name: tuple(end if math.isfinite(end) else None for end in ends) for name, ends in ranges.items()}
    return {name: (low, high) for name, (low, high) in finite.items() if (low, high) != (None, None)}


# ---- causes -------------------------------------------------------------------------------------------------------
def _named(judged: Judged, name: str) -> bool:
    """Whether an effect of the model is given as a cause."""
    return (
        name in judged.last.effects
        and judged.verdict not in ("not finished", "unexplained")
        and name not in (*judged.replaced, *judged.doubtful, *judged.minor)
    )


def _causes(judged: Judged, subject: Subject, gain: Mapping[str, Gain]) -> Iterator[Cause]:
    table = subject.candidates
    grouped = {name: group for group in judged.groups for name in group}
    order = [*judged.last.effects, *(name for group in judged.groups for name in group)]
    # In the order of the table where rounding alone parts them.
    order += sorted(table, key=lambda name: -round(judged.probability.get(name, 0.0), PLACES))
    untestable, noise = subject.untestable(), noise_of(judged, subject)
    own = spread(judged.last, noise)
    for name in dict.fromkeys(order):
        group = grouped.get(name, ())
        named = _named(judged, name) or bool(group and (_named(judged, group[0]) or len(group) == 1))
        support: Support = "not supported"
        if named:
            support = "indistinguishable" if group else "supported"
        fit = _fit_with(judged, name)
        score = _score(judged, name)
        if name in untestable or (fit is None and score is None and table[name].is_sought):
            support = "not testable"
        values: tuple[Value, ...] = ()
        if fit is not None:
            u = own if fit is judged.last else spread(fit, noise)
            values = tuple(_values(fit, table[name], u, noise.misfit, named=named))
        minor = name in judged.last.effects and not named and name not in judged.replaced
        yield Cause(
            name, table[name].title, table[name].equation, support, judged.probability.get(name, 0.0), values,
            gain if name in judged.last.effects else {}, _log_bayes(judged, name), score, minor,
            table[name].consequence, table[name].advice, _of_cause(judged, subject, name, support, own),
        )  # fmt: skip


def _fit_with(judged: Judged, name: str) -> Fit | None:
    """Fit from which the values of an effect are taken."""
    if name in judged.last.effects:
        return judged.last
    return next((fit for (_, other), (fit, _) in judged.exchanged.items() if other == name), None)


def _log_bayes(judged: Judged, name: str) -> float | None:
    """Ln evidence of the sets with an effect over those without."""
    if name not in judged.probability:
        return None
    p = judged.probability[name]
    having, without = (
        math.fsum(w for one, w in judged.weights.items() if (name in one) is own) for own in (True, False)
    )
    # Not 1 − p, of which no digit is left where p is nearly one; but for what an unlisted law takes of it.
    taken = 1.0 - p / having if having > 0 else 0.0
    against = without + (having * taken if taken > ROUNDING else 0.0)
    return float(np.clip(math.log(max(p, 1e-300)) - math.log(max(against, 1e-300)), -690.0, 690.0))


def _score(judged: Judged, name: str) -> float | None:
    """Standard deviations of an effect alone, beside the stated model; None where it cannot be tested."""
    found = judged.first.scores.get(name)
    return None if found is None else found.z


def _of_cause(judged: Judged, subject: Subject, name: str, support: Support, u: Array) -> str:
    """What is said of an effect; `u` of the unknowns of the model."""
    if untried := _untried(judged, subject, name, support):
        return untried
    kinds = ""
    if any(one == name and name in fit.effects and more > -EQUAL for one, fit, more in judged.kinds):
        kinds = said("These data cannot distinguish its variants: k and c are means over them.")
    if name in judged.replaced:
        return said("Fits, but a law that is not listed fits as well: it is not named.")
    if support == "supported":
        text = "Named: it removes {share:.0f} % of the misfit that remains without it."
        removed = said(text, share=float(100 * judged.carries.get(name, 1.0)))
        return followed(removed, _left_out(judged, name, u), kinds, subject.where(judged.last, name, u))
    if support == "indistinguishable" and (name,) in judged.groups:
        text = (
            "Possible: something is missing, but these data do not decide whether it is this effect or another one, "
            "listed or not."
            if _certain(judged)
            else "Possible: these data do not decide whether it, a law that is not listed, or nothing is missing."
        )
        return followed(said(text), kinds)
    if support == "indistinguishable":
        text = "Possible: these data cannot distinguish it from the others of its group."
        return followed(said(text), kinds)
    if name in judged.last.effects:
        text = "Minor: it removes {share:.0f} % of the misfit that remains without it."
        return said(text, share=float(100 * judged.carries.get(name, 0.0)))
    if judged.probability.get(name, 0.0) > LIKELY:
        # By the straight line alone, where the search ended before a model with it was fitted.
        return said("More probable than not, but not in the fitted model that has the most evidence: not named.")
    score = judged.first.scores.get(name)
    if score is not None and not score.whole:
        return said("The evidence is against it in the forms that these data can show; there are others.")
    return said("The evidence is against it.")


def _untried(judged: Judged, subject: Subject, name: str, support: Support) -> str:
    """Why an effect was not tried; empty where it was."""
    candidate, untestable = subject.candidates[name], subject.untestable()
    if name in untestable:
        return said("Not testable with these data: {reason}.", reason=untestable[name])
    if support == "not testable":
        text = "Not testable with these data: other unknowns have the same effect. Needed: {needed}."
        return said(text, needed=candidate.separate)
    if candidate.instead and _fit_with(judged, name) is None:
        return said("Not in the model: it is tried only in the place of another effect of the same kind.")
    if candidate.cause.beside in ("", *judged.last.effects):
        return ""
    title = subject.candidates[candidate.cause.beside].title
    return said("Not in the model: it is tried together with {title:lowered} only.", title=title)


def _certain(judged: Judged) -> bool:
    """Whether something besides what is named is missing for certain, whatever it is."""
    undecided = {group[0] for group in judged.groups if len(group) == 1}
    named = {*judged.last.effects, *(name for group in judged.groups for name in group)} - undecided
    return math.fsum(w for one, w in judged.weights.items() if one <= named) < NEGLIGIBLE


def _left_out(judged: Judged, effect: str, u: Array) -> str:
    """What k and c come out as without one of the effects, the others being there."""
    without, found = judged.others.get(effect), []
    if without is None:
        return ""
    for name in ("k", "c"):
        at, to = without.index(name), judged.last.index(name)
        if at is None or to is None:
            continue
        value, unit = float(without.theta[at]), without.problem.unknowns[at].unit
        if abs(value - judged.last.theta[to]) > u[to]:
            text = "{name} = {value:.4g} {unit} instead of {whole:.4g} {unit}"
            found.append(said(text, name=name, value=value, unit=unit, whole=float(judged.last.theta[to])))
    if len(found) > 1:
        return said("Without it the fit gives {first} and {second}.", first=found[0], second=found[1])
    return said("Without it the fit gives {first}.", first=found[0]) if found else ""


def _values(fit: Fit, candidate: Candidate, u_of: Array, misfit: float, *, named: bool) -> Iterator[Value]:
    """Parameters of an effect with their 95 % intervals; `u_of` all unknowns of the fit."""
    yield from _amplitude(fit, candidate, u_of)
    for size in candidate.parameters:
        at = fit.index(size.name)
        if at is None:
            continue
        value, u = float(fit.theta[at]), float(u_of[at])
        if not named and u > LOOSE * max(abs(value - size.null), size.scale):
            # The data say nothing of it, such as the shape of an effect whose size has gone to zero.
            continue
        several = sum(one.shape for one in candidate.parameters) > 0
        near = not size.shape and abs(value - size.null) < 4 * u
        curved = named and (several or near) and misfit < COARSE
        yield Value(size.name, value, u, size.unit, *intervals.ends(fit, at, u, curved=curved))


def _amplitude(fit: Fit, candidate: Candidate, u_of: Array) -> Iterator[Value]:
    """What every block has for itself: mean amplitude of a line (sine, cosine), or standard deviation of one size."""
    names = [size.name for size in candidate.parameters if size.own and not size.shape]
    ways = [[at for name in names if (at := fit.index(f"{name}@{one.name}")) is not None] for one in fit.problem.blocks]
    if not names or not all(ways):
        return
    unit = next(size.unit for size in candidate.parameters if size.own)
    departs = all(fit.problem.unknowns[own[0]].u is not None for own in ways)
    if len(names) == 1 and departs:
        dof = len(ways) - 1
        value = float(np.linalg.norm(fit.theta[[own[0] for own in ways]])) / math.sqrt(dof)
        of_u = value / math.sqrt(2 * dof)
        ends = (max(value - intervals.NORMAL_95 * of_u, 0.0), value + intervals.NORMAL_95 * of_u)
        yield Value(f"{names[0]} (standard deviation)", value, of_u, unit, *ends)
        return
    sizes = np.array([np.linalg.norm(fit.theta[own]) for own in ways])
    u = np.array([np.linalg.norm(fit.theta[own] * u_of[own]) for own in ways]) / np.maximum(sizes, 1e-300)
    value, of_u = float(sizes.mean()), float(np.linalg.norm(u)) / len(u)
    low, high = max(value - intervals.NORMAL_95 * of_u, 0.0), value + intervals.NORMAL_95 * of_u
    yield Value(f"{candidate.name}.amplitude", value, of_u, unit, low, high)


def _separations(judged: Judged, subject: Subject) -> Iterator[Separation]:
    noise = noise_of(judged, subject)
    for group in judged.groups:
        if not _named(judged, group[0]):
            continue
        for name in group:
            candidate, fit = subject.candidates[name], _fit_with(judged, name)
            values: list[Value] = []
            if fit is not None:
                values = list(_values(fit, candidate, spread(fit, noise), noise.misfit, named=False))[:1]
            text, plain = (
                "it would have to show {name} = {value:.3g} {unit}",
                "it would have to show {name} = {value:.3g}",
            )
            expected = [said(plain if one.unit == "1" else text, name=one.name, value=one.value, unit=one.unit)
                        for one in values]  # fmt: skip
            measurement = said("{title}: {what}", title=candidate.title, what=candidate.separate)
            yield Separation(group, measurement, expected[0] if expected else "")


# ---- tables -------------------------------------------------------------------------------------------------------
def _tests(judged: Judged) -> tuple[Test, ...]:
    """What the two judgements rest on: whether a listed effect is missing, and whether something unlisted is."""
    none = judged.nothing
    nothing = not judged.last.effects
    text = (
        "The probability that no listed effect is missing is {p:figures}."
        if nothing
        else "The probability that a listed effect is missing is {p:figures}."
    )
    misfit = (
        "Where the unknowns act, the mean square of what no listed effect explains is {times:.3g} times that of the "
        "noise (limit {limit:g}); uncertainties are larger by the root of that."
    )
    unlisted = "The probability of an unlisted {law} in addition to the model is {p:figures}."
    found = [
        Test(
            said("listed effects"), 1.0 - none, LIKELY, none, LIKELY, nothing,
            said(text, p=_probability(none if nothing else 1 - none)),
        ),
        Test(
            said("misfit"), judged.misfit, COARSE, math.nan, math.nan, judged.misfit <= COARSE,
            said(misfit, times=float(judged.misfit), limit=COARSE),
        ),
    ]  # fmt: skip
    if judged.heavy > LIKELY:
        normal = said("The probability that the noise has heavy tails is {p:figures}.", p=_probability(judged.heavy))
        found.append(Test(said("normal noise"), judged.heavy, LIKELY, 1.0 - judged.heavy, LIKELY, False, normal))
    if judged.law is not None:
        found.append(
            Test(
                said("unlisted law"), judged.unlisted, LIKELY, 1.0 - judged.unlisted, LIKELY, judged.unlisted <= LIKELY,
                said(unlisted, law=_law(judged.law.family), p=_probability(judged.unlisted)),
            )
        )  # fmt: skip
    return tuple(found)


def _probability(p: float) -> str:
    if p < 1e-6:
        return "< 10⁻⁶"
    return f"{p:.3f}" if p <= 0.9995 else "> 0.999"


def _remainder(judged: Judged, subject: Subject) -> Remainder | None:
    """What no listed effect explains."""
    if judged.verdict not in ("unexplained", "explained in the main"):
        return None
    law = judged.law if judged.unlisted > LIKELY else None
    unit = "" if law is None else subject.unit_of(law.family)
    return Remainder(
        1.0 - judged.share, None if law is None else law.size, unit, "" if law is None else _law(law.family)
    )


def _detectable(judged: Judged, subject: Subject) -> Iterator[Detectable]:
    """Smallest size of every candidate that shows, by the Fisher information of these runs: needs no reading."""
    for name, candidate in subject.candidates.items():
        found = judged.first.scores.get(name)
        unit = candidate.size.unit
        if found is None and not candidate.is_sought:
            continue
        if found is None or not found.d > 0:
            words = said("Would not show at any size.")
            yield Detectable(name, candidate.title, candidate.size.name, None, unit, words)
            continue
        size = candidate.size.amount(abs(found.amount), SHOWS / found.d)
        null = candidate.size.null
        text = (
            "{name} that differs from {null:g} by {size:.2g}{unit} would show ({times:g} standard deviations); less "
            "would not."
            if null
            else "{name} of {size:.2g}{unit} would show ({times:g} standard deviations); less would not."
        )
        words = said(
            text, name=candidate.size.name, null=float(null), size=float(size),
            unit="" if unit == "1" else f" {unit}", times=SHOWS,
        )  # fmt: skip
        yield Detectable(name, candidate.title, candidate.size.name, size, unit, words)


def _shifts(judged: Judged, found: Supported | None) -> tuple[Shift, ...]:
    """What the extension does to the common unknowns that have no prior, and to k and c also where they are given."""
    if found is None:
        return ()
    rows = []
    for name, unit, after, u_after, before, u in zip(
        found.names, found.units, found.values, found.u, found.stated, found.stated_u, strict=True
    ):
        at = judged.base.index(name)
        entry = None if at is None else judged.base.problem.unknowns[at]
        if entry is None or (entry.u is not None and name not in ("k", "c")):
            continue
        if entry.mean is not None and entry.u is not None:
            # What was given is what the model as it stands works with, not where its fit was drawn to.
            before, u = entry.mean, entry.u
        rows.append(Shift(name, unit, before, u, after, u_after, (after - before) / max(u, 1e-300)))
    return tuple(rows)


def _parts(judged: Judged, subject: Subject) -> tuple[Part, ...]:
    """Residuals over noise by run, channel and phase."""
    spans = subject.parts(judged.last)
    found = []
    for at, block in enumerate(judged.base.problem.blocks):
        for segment in block.segments:
            own = slice(segment.first, segment.last)
            used = judged.base.used[at][own] & judged.last.used[at][own]
            for phase, marks in spans.get((block.name, segment.name), ()):
                chosen = used & marks
                if chosen.any():
                    sizes = [_rms(one, at, own, chosen) for one in (judged.base, judged.last)]
                    found.append(Part(block.name, segment.name, phase, int(chosen.sum()), *sizes))
    return tuple(found)


def _rms(fit: Fit, at: int, own: slice, chosen: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> float:
    return float(np.sqrt(np.mean(fit.full[at][own][chosen] ** 2)))


# ---- sentences ----------------------------------------------------------------------------------------------------
def _sentence(judged: Judged, subject: Subject, causes: tuple[Cause, ...]) -> str:
    match judged.verdict:
        case "nothing missing" if judged.heavy > LIKELY:
            return said(
                "No listed effect is supported, but the noise is not normal: more readings lie far off than chance "
                "explains. Each may be misread, or the readings scatter so."
            )
        case "nothing missing":
            return said("Nothing is missing: no listed effect is supported, and what remains is noise.")
        case "not finished":
            return said(
                "Not finished: no model that was tried follows the motion, so that nothing is said of causes. Look "
                "at the readings, the start and the stated model first."
            )
        case _:
            pass
    named = _names(causes, judged)
    remainder = _rest(judged, subject)
    if judged.verdict == "unexplained":
        fits = tuple(_with_name(subject.candidates[name].title, name) for name in judged.replaced)
        if fits and judged.law is not None and judged.law.log_bayes < FAR and judged.misfit <= COARSE:
            one = "Something is missing: {effects:comma} would explain it, but so does a law that is not listed."
            many = (
                "Something is missing: {effects:comma} together would explain it, but so does a law that is not listed."
            )
            return followed(counted(one, many, len(fits), effects=fits), remainder)
        return followed(said("Something is missing that no listed effect explains."), remainder)
    missing = followed(said("Missing in the model: {what}.", what=named), remainder, _tails(judged)) if named else ""
    undecided = [group[0] for group in judged.groups if len(group) == 1]
    if not undecided:
        return missing
    possible = tuple(_with_name(subject.candidates[name].title, name) for name in undecided)
    words = said(WHAT if _certain(judged) else ANYTHING, possible=possible)
    return followed(missing, words) if missing else words


def followed(*sentences: str) -> str:
    """Sentences one after another: after what is missing, a doubt is whether more is."""
    first, *others = (one for one in sentences if one)
    others = [_more(one) for one in others]
    return said("{first} {others:space}", first=first, others=tuple(others)) if others else first


def _more(sentence: str) -> str:
    if isinstance(sentence, Sentence) and sentence.message in MORE:
        return said(MORE[sentence.message], **sentence.values)
    return sentence


def _with_name(title: str, name: str) -> str:
    """A title within a sentence, with its name in campaign files."""
    return said("{title:lowered} ({name})", title=title, name=name)


def _names(causes: tuple[Cause, ...], judged: Judged) -> tuple[str, ...]:
    titles = {one.effect: _with_name(one.title, one.effect) for one in causes}
    supported: list[str] = [titles[one.effect] for one in causes if one.verdict == "supported"]
    alike = {one.effect for one in causes if one.verdict == "indistinguishable"}
    supported += [said(EITHER, titles=tuple(titles[name] for name in group))
                  for group in judged.groups if len(group) > 1 and alike.issuperset(group)]  # fmt: skip
    return tuple(supported)


def _tails(judged: Judged) -> str:
    """That more readings are far off than the model with its effects leaves to chance; empty where that is not so."""
    text = (
        "In addition, the noise is not normal: more readings lie far off than chance explains. Each may be misread, or "
        "the readings scatter so."
    )
    return said(text) if judged.heavy > LIKELY else ""


def _rest(judged: Judged, subject: Subject) -> str:
    """What the listed effects do not explain, in a sentence or two; empty where they explain all."""
    law = judged.law if judged.law is not None and judged.unlisted > LIKELY else None
    if law is None:
        return _explained(judged, subject)
    unit = subject.unit_of(law.family)
    text = "What remains is described best by an unlisted law, {law} (RMS {size:.2g}{unit})."
    described = said(text, law=_law(law.family), size=float(law.bent), unit="" if unit == "1" else f" {unit}")
    return followed(_explained(judged, subject), described)


def _law(family: str) -> str:
    """What a family of laws is, ``force of powers of velocity``, in words of the catalogue."""
    base, differing, _ = family.partition(" that differs between repeats")
    if differing:
        return said("{law} that differs between repeats", law=_law(base))
    what, of, rest = base.partition(" of ")
    if of:
        text = "powers of {of}" if what == "powers" else "{what} of {of}"
        return said(text, what=what, of=_law(rest))
    first, both, second = base.partition(" and ")
    return said("{first} and {second}", first=first, second=second) if both else base


def _explained(judged: Judged, subject: Subject) -> str:
    """How much of the misfit is explained, by what besides the effects that are named."""
    shares = {"share": float(100 * judged.share), "left": float(100 * (1.0 - judged.share))}
    others = tuple(
        _with_name(subject.candidates[name].title, name) for name in judged.replaced if judged.verdict != "unexplained"
    )
    mainly = judged.verdict == "explained in the main"
    if others and mainly:
        text = (
            "Together with {others:comma}, in whose place an unlisted law does as well, this explains {share:.3g} % of "
            "the misfit; {left:.2g} % remains."
        )
        return said(text, others=others, **shares)
    if others:
        text = (
            "Together with {others:comma}, in whose place an unlisted law does as well, this explains all of the "
            "misfit."
        )
        return said(text, others=others)
    return said("This explains {share:.3g} % of the misfit; {left:.2g} % remains.", **shares) if mainly else ""
