"""Causes of a diagnosis: values, words, and what would tell them apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from metrology.diagnosis import Cause, Gain, Separation, Support, Value
from metrology.diagnostics import intervals
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.fits import COARSE
from metrology.diagnostics.judged import LIKELY, Judged
from metrology.diagnostics.search import EQUAL
from metrology.diagnostics.subject import Array, Fit, Subject
from metrology.diagnostics.supported import noise_of, spread
from metrology.diagnostics.verdict_sentences import followed
from metrology.gum.rounding import significant
from metrology.message import said

LOOSE = 30.0
"""Standard uncertainty over the size of a parameter from which on it is not printed of a cause that is not named."""
ROUNDING, PLACES = 1e-12, 9
"""Part of a probability below which a difference from it is rounding; places to which two are compared."""


def causes_of(judged: Judged, subject: Subject, gain: Mapping[str, Gain]) -> Iterator[Cause]:
    """Every cause that was looked at, the effects of the model first, then by probability."""
    table = subject.candidates
    grouped = {name: group for group in judged.groups for name in group}
    order = [*judged.last.effects, *(name for group in judged.groups for name in group)]
    # In the order of the table where rounding alone parts them.
    order += sorted(table, key=lambda name: -round(judged.probability.get(name, 0.0), PLACES))
    untestable, noise = subject.untestable(), noise_of(judged, subject)
    own = spread(judged.last, noise)
    for name in dict.fromkeys(order):
        group = grouped.get(name, ())
        named = judged.is_named(name) or bool(group and (judged.is_named(group[0]) or len(group) == 1))
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
            if judged.is_certain
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
            text = "{name} = {value:figures} {unit} instead of {whole:figures} {unit}"
            alone, whole = (significant(one, float(u[to]))[0] for one in (value, float(judged.last.theta[to])))
            found.append(said(text, name=name, value=alone, unit=unit, whole=whole))
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


def separations(judged: Judged, subject: Subject) -> Iterator[Separation]:
    """For each group and law of one thing, the measurement that would tell its effects apart."""
    noise = noise_of(judged, subject)
    for group in judged.groups:
        if not judged.is_named(group[0]):
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
