"""From what the engine found to verdict, causes and sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from metrology.diagnose import belief, heldout, intervals
from metrology.diagnose.candidate import Candidate
from metrology.diagnose.linear import INVISIBLE, Score
from metrology.diagnose.selection import Rival
from metrology.diagnose.subject import LOST, Array, Fit, Subject
from metrology.diagnosis import (
    Cause,
    Detectable,
    Diagnosis,
    Gain,
    Part,
    Separation,
    Shift,
    Support,
    Value,
    Verdict,
)
from metrology.effect import Size

if TYPE_CHECKING:
    from metrology.diagnose.engine import Outcome

SHOWS = 5.0
"""Distance in standard deviations at which an effect is found nine times in ten at the usual limits."""
LOOSE = 30.0
"""Standard uncertainty over the size of a parameter from which on it is not told of a cause that is not named."""
NAMES = ("Coulomb", "Zener", "Bouc–Wen", "Boltzmann")
"""Names with which a title may begin, and which stay as they are."""
USEFUL = 1.002
"""Ratio of held-out residuals below which a real effect is called negligible, if k and c hardly move."""


def failed(subject: Subject, test: str) -> Diagnosis:
    """Diagnosis of a base model that cannot be fitted."""
    sentence = "The base model could not be fitted to these data: look at them beside the stated model first."
    return Diagnosis(
        subject.sample, subject.method, test, "unexplained", sentence, (), (), {}, (), (), (), {}, failures=(sentence,)
    )


def worded(outcome: Outcome, rng: np.random.Generator, test: str) -> Diagnosis:
    """Put an outcome into a `Diagnosis`."""
    gain = _gain(outcome, rng)
    verdict = _verdict(outcome)
    causes = _causes(outcome, verdict, gain)
    groups = _groups(outcome, causes)
    missing = outcome.subject.missing(outcome.base) if verdict == "unexplained" else None
    before, after = (one.chi_squared / max(one.count, 1) for one in (outcome.base, outcome.last))
    extended = dict(outcome.subject.extended(outcome.last)) if outcome.last.effects and verdict != "unexplained" else {}
    told = _open(outcome) if _undecided(outcome) else _sentence(verdict, causes, missing.sentence if missing else "")
    sentence = told + _rest(outcome, verdict)
    return Diagnosis(
        sample=outcome.subject.sample, method=outcome.subject.method, test=test, verdict=verdict,
        sentence=sentence, tests=outcome.tests, causes=causes,
        gain=gain, residuals=_parts(outcome), groups=groups, discriminating_tests=_separations(outcome, groups),
        extended_model=extended, detectable=_detectable(outcome), shifts=_shifts(outcome), missing=missing,
        chi_squared=(before, after), failures=outcome.failures,
    )  # fmt: skip


def _verdict(outcome: Outcome) -> Verdict:
    if not outcome.last.effects:
        # A lone score without a fit that pays is no cause, yet structure in the residuals has to be told.
        return "nothing missing" if all(one.passed for one in outcome.tests[1:]) else "unexplained"
    if not (outcome.negligible or _passed_after(outcome)) or _undecided(outcome):
        return "unexplained"
    groups = [belief.equal(slot) for slot in outcome.slots.values()]
    return "ambiguous" if any(len(group) > 1 for group in groups) else "explained"


def _undecided(outcome: Outcome) -> bool:
    """Whether nothing is left, yet so many causes do equally well, each in its own way, that none can be meant."""
    if not (outcome.negligible or _passed_after(outcome)):
        return False
    groups = [belief.equal(slot) for slot in outcome.slots.values()]
    return any(belief.apart(group) >= belief.MANY and not belief.alike(group) for group in groups)


def _passed_after(outcome: Outcome) -> bool:
    return all(one.passed for one in outcome.tests if one.name.endswith("after extension"))


def _gain(outcome: Outcome, rng: np.random.Generator) -> dict[str, Gain]:
    if not outcome.last.effects:
        return {}
    return heldout.gains(outcome.last, outcome.held_base, outcome.held_last, rng)


# ---- causes -------------------------------------------------------------------------------------------------------
def _causes(outcome: Outcome, verdict: Verdict, gain: Mapping[str, Gain]) -> tuple[Cause, ...]:
    found: dict[str, Cause] = {}
    for slot in outcome.slots.values():
        weights = belief.probabilities(slot, belief.UNKNOWN if outcome.negligible else belief.unknown(outcome.tests))
        equal = {rival.effect for rival in belief.equal(slot)}
        for rival, probability in zip(slot, weights, strict=True):
            support: Support = "not supported"
            if verdict != "unexplained" and rival.effect in equal:
                support = "supported" if len(equal) == 1 else "indistinguishable"
            cause = _cause(outcome, rival, (support, probability, verdict), gain)
            if rival.effect not in found or found[rival.effect].probability < cause.probability:
                found[rival.effect] = cause
    causes = sorted(found.values(), key=lambda one: (one.verdict == "not supported", -one.probability))
    told = {cause.effect for cause in causes}
    return (*causes, *(one for one in _others(outcome) if one.effect not in told))


def _cause(outcome: Outcome, rival: Rival, judged: tuple[Support, float, Verdict], gain: Mapping[str, Gain]) -> Cause:
    support, probability, verdict = judged
    candidate = outcome.subject.candidates[rival.effect]
    score = outcome.screen.best(rival.effect)
    own = gain if rival.effect in outcome.last.effects else {}
    small = bool(own) and heldout.summary(own) < USEFUL and all(abs(one.shift) < 1 for one in _shifts(outcome))
    sentence = {
        "supported": "Named: no other candidate does as well, and left-out data are predicted better.",
        "indistinguishable": "Possible: these data cannot tell it from the others of its group.",
        "not supported": "Fits less well than what is named.",
        "not testable": "",
    }[support]
    if verdict == "unexplained" and _undecided(outcome):
        sentence = "Takes up what is missing about as well as others do that say something else of the readings."
        probability = min(probability, 0.5)
    elif verdict == "unexplained":
        sentence = "Takes up part of what is missing, but leaves structure: not the cause, or not the only one."
        probability = 0.1 * probability
    if support == "supported":
        sentence += _left_out(outcome, rival.effect)
    if support != "not supported" and outcome.kinds[rival.effect]:
        sentence += " Which of its kinds it is, these data do not tell: values after extension are means over them."
    if small and support == "supported":
        sentence = "Real but negligible: it shows in the data, yet changes neither the prediction nor k and c."
    return Cause(
        rival.effect, candidate.title, candidate.equation, support, probability,
        _values(outcome, rival, named=support == "supported"), own,
        min(rival.log_bayes, 1e300), score.z if score else None, small, candidate.consequence, candidate.advice,
        sentence,
    )  # fmt: skip


def _left_out(outcome: Outcome, effect: str) -> str:
    """What k and c come out as without one of the effects, the others being there."""
    without, told = outcome.without.get(effect), []
    if without is None or without.mean_cost > LOST:
        return ""
    spread = intervals.spread(outcome.last)
    for name in ("k", "c"):
        at, to = without.index(name), outcome.last.index(name)
        if at is None or to is None:
            continue
        value, unit = float(without.theta[at]), without.problem.unknowns[at].unit
        if abs(value - outcome.last.theta[to]) > spread[to]:
            told.append(f"{name} = {value:.4g} {unit} in place of {float(outcome.last.theta[to]):.4g} {unit}")
    return f" Left out, it gives {' and '.join(told)}." if told else ""


def _values(outcome: Outcome, rival: Rival, *, named: bool = False) -> tuple[Value, ...]:
    """Parameters of an effect; their intervals by profiles where it is named and has several, which bend its valley."""
    sought = [
        (size, at)
        for size in outcome.subject.candidates[rival.effect].parameters
        if (at := rival.fit.index(size.name)) is not None
    ]
    spread = intervals.spread(rival.fit)
    found = list(_amplitude(rival.fit, outcome.subject.candidates[rival.effect], spread))
    for size, at in sought:
        value, u = float(rival.fit.theta[at]), float(spread[at])
        if not named and u > LOOSE * max(abs(value - size.null), size.scale):
            # The data say nothing of it, such as the shape of an effect whose size has gone to zero.
            continue
        curved = named and (len(sought) > 1 or (not size.shape and abs(value - size.null) < 4 * u))
        found.append(Value(size.name, value, u, size.unit, *intervals.ends(rival.fit, at, u, curved=curved)))
    return tuple(found)


def _amplitude(fit: Fit, candidate: Candidate, spread: Array) -> Iterator[Value]:
    """Amplitude of a line that every block has in ways of its own, sine and cosine: the mean over the blocks."""
    names = [size.name for size in candidate.parameters if size.own]
    ways = [[at for name in names if (at := fit.index(f"{name}@{one.name}")) is not None] for one in fit.problem.blocks]
    if not names or not all(ways):
        return
    sizes = np.array([np.linalg.norm(fit.theta[own]) for own in ways])
    u = np.array([np.linalg.norm(fit.theta[own] * spread[own]) for own in ways]) / np.maximum(sizes, 1e-300)
    unit = next(size.unit for size in candidate.parameters if size.own)
    value, of_u = float(sizes.mean()), float(np.linalg.norm(u)) / len(u)
    low, high = max(value - intervals.NORMAL_95 * of_u, 0.0), value + intervals.NORMAL_95 * of_u
    yield Value(f"{candidate.name}.amplitude", value, of_u, unit, low, high)


def _others(outcome: Outcome) -> list[Cause]:
    """Candidates that were not fitted: their score says why, or that they cannot be tested."""
    untestable = outcome.subject.untestable()
    found = []
    for name, candidate in outcome.subject.candidates.items():
        score = outcome.screen.best(name)
        support: Support = "not supported"
        sentence = f"Score {score.z:.1f} standard deviations." if score else "Not tried."
        if name in untestable:
            support, sentence = "not testable", f"Not testable with these data: {untestable[name]}."
        elif score is None or (score.share < INVISIBLE and score.direction.stated is None):
            support = "not testable"
            sentence = f"Not testable with these data: other unknowns take it over. Needed: {candidate.separate}."
        found.append(
            Cause(
                name,
                candidate.title,
                candidate.equation,
                support,
                0.0,
                (),
                {},
                None,
                score.z if score else None,
                False,
                candidate.consequence,
                candidate.advice,
                sentence,
            )
        )
    return found


def _groups(outcome: Outcome, causes: tuple[Cause, ...]) -> tuple[tuple[str, ...], ...]:
    """Causes that these data cannot tell apart, each group with the most probable first."""
    if not any(cause.verdict == "indistinguishable" for cause in causes):
        return ()
    groups = [tuple(rival.effect for rival in belief.equal(slot)) for slot in outcome.slots.values()]
    return tuple(group for group in groups if len(group) > 1)


def _separations(outcome: Outcome, groups: tuple[tuple[str, ...], ...]) -> tuple[Separation, ...]:
    found = []
    for group in groups:
        for name in group:
            candidate = outcome.subject.candidates[name]
            rival = next((one for slot in outcome.slots.values() for one in slot if one.effect == name), None)
            values = _values(outcome, rival)[:1] if rival else ()
            expected = "".join(f"; it would have to show {one.name} = {one.value:.3g} {one.unit}" for one in values)
            found.append(Separation(group, f"{candidate.title}: {candidate.separate}", expected.removeprefix("; ")))
    return tuple(found)


# ---- tables -------------------------------------------------------------------------------------------------------
def _detectable(outcome: Outcome) -> tuple[Detectable, ...]:
    """Smallest size of every candidate that shows, by the Fisher information of these runs: needs no reading."""
    found = []
    for name, candidate in outcome.subject.candidates.items():
        own = [score for score in outcome.screen.scores if score.direction.effect == name]
        size = min((_smallest(score, candidate.size) for score in own), default=math.inf)
        unit = candidate.size.unit
        if not math.isfinite(size):
            found.append(
                Detectable(name, candidate.title, candidate.size.name, None, unit, "Would not show at any size.")
            )
            continue
        null = candidate.size.null
        amount = f"off {null:g} by {size:.2g}" if null else f"of {size:.2g}"
        told = f"{candidate.size.name} {amount}{'' if unit == '1' else f' {unit}'}"
        words = f"{told} would show ({SHOWS:g} standard deviations); less would not."
        found.append(Detectable(name, candidate.title, candidate.size.name, size, unit, words))
    return tuple(found)


def _smallest(score: Score, size: Size) -> float:
    if score.d <= 0 or (score.share < INVISIBLE and score.direction.stated is None):
        return math.inf
    return size.amount(abs(score.direction.amount), SHOWS / score.d)


def _shifts(outcome: Outcome) -> tuple[Shift, ...]:
    """What the extension does to the common unknowns that have no prior, and to k and c also where they are given."""
    if not outcome.last.effects:
        return ()
    spreads = [intervals.spread(one) for one in (outcome.base, outcome.last)]
    found = []
    for at, entry in enumerate(outcome.base.problem.unknowns):
        to = outcome.last.index(entry.name)
        if (entry.u is not None and entry.name not in ("k", "c")) or "@" in entry.name or to is None:
            continue
        before, u = float(outcome.base.theta[at]), float(spreads[0][at])
        after, u_after = _averaged(outcome, entry.name, (float(outcome.last.theta[to]), float(spreads[1][to])))
        if entry.mean is not None and entry.u is not None:
            # What was given is what the model as it stands works with, not where its fit was drawn to.
            before, u = entry.mean, entry.u
        found.append(Shift(entry.name, entry.unit, before, u, after, u_after, (after - before) / max(u, 1e-300)))
    return tuple(found)


def _averaged(outcome: Outcome, name: str, named: tuple[float, float]) -> tuple[float, float]:
    """Value and standard uncertainty of an unknown, over the causes and their kinds that these data do not tell apart.

    The mean over the models of a group, each as probable as its evidence says, and its variance with that between the
    models (Hoeting et al., Statist. Sci. 14 (1999) 382, eq. 3 and 4); what several groups do adds up.
    """
    after, u = named
    value, variance = after, u**2
    for slot in outcome.slots.values():
        members = []
        for rival in belief.equal(slot):
            less = 0.0 if rival is slot[0] else rival.log_bayes - slot[0].log_bayes
            members += [(rival.fit, less), *((fit, less + better) for fit, better in outcome.kinds[rival.effect])]
        group = [(fit, fit.index(name)) for fit, _ in members]
        if len(group) < 2 or any(at is None for _, at in group):
            continue
        weights = np.exp([less for _, less in members])
        weights = weights / weights.sum()
        values = np.array([float(fit.theta[at]) for fit, at in group if at is not None])
        spread = np.array([float(intervals.spread(fit)[at]) for fit, at in group if at is not None])
        mean = float(weights @ values)
        value += mean - after
        variance += max(float(weights @ (spread**2 - u**2 + (values - mean) ** 2)), 0.0)
    return value, math.sqrt(variance)


def _parts(outcome: Outcome) -> tuple[Part, ...]:
    """Residuals over noise by run, channel and phase."""
    spans = outcome.subject.parts(outcome.last)
    found = []
    for at, block in enumerate(outcome.base.problem.blocks):
        for segment in block.segments:
            own = slice(segment.first, segment.last)
            used = outcome.base.used[at][own] & outcome.last.used[at][own]
            for phase, marks in spans.get((block.name, segment.name), ()):
                chosen = used & marks
                if chosen.any():
                    sizes = [_rms(one, at, own, chosen) for one in (outcome.base, outcome.last)]
                    found.append(Part(block.name, segment.name, phase, int(chosen.sum()), *sizes))
    return tuple(found)


def _rms(fit: Fit, at: int, own: slice, chosen: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> float:
    return float(np.sqrt(np.mean(fit.full[at][own][chosen] ** 2)))


def _sentence(verdict: Verdict, causes: tuple[Cause, ...], missing: str) -> str:
    if verdict == "nothing missing":
        return "Nothing is missing: no candidate asks for a place, and the residuals are noise."
    if verdict == "unexplained":
        return f"Something is missing that none of the known effects explains. {missing}".strip()
    named = [f"{_lowered(one.title)} ({one.effect})" for one in causes if one.verdict == "supported"]
    groups = [one.effect for one in causes if one.verdict == "indistinguishable"]
    parts = [f"missing in the model: {' and '.join(named)}"] if named else []
    if groups:
        parts.append(f"these data cannot tell apart: {', '.join(groups)}")
    text = "; ".join(parts)
    return text[0].upper() + text[1:] + "."


def _open(outcome: Outcome) -> str:
    """What takes up all that is missing, in too many ways for any of them to be meant."""
    names = dict.fromkeys(rival.effect for slot in outcome.slots.values() for rival in belief.equal(slot))
    return f"Something is missing that several causes take up equally well, each in its own way: {', '.join(names)}."


def _rest(outcome: Outcome, verdict: Verdict) -> str:
    """What is left of a model that is explained for every practical purpose."""
    if not outcome.negligible or verdict == "unexplained" or _passed_after(outcome):
        return ""
    share = outcome.last.chi_squared / max(outcome.last.count, 1)
    return f" What is left shows in the data and is negligible beside that: χ² of {share:.3f} for each reading."


def _lowered(title: str) -> str:
    """The title within a sentence: its first letter small, unless a name or an abbreviation begins it."""
    first = title.split(" ")[0].removesuffix(":")
    return title if first in NAMES or first[1:] != first[1:].lower() else title[:1].lower() + title[1:]
