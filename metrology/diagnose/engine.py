"""The engine: fit the base model inside its priors, ask whether anything is missing, name it, measure the gain."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from metrology.diagnose import belief, flexible, heldout, residuals, verdict
from metrology.diagnose.heldout import HeldOut
from metrology.diagnose.linear import Screen
from metrology.diagnose.selection import PAYS, Rival, Search, Step
from metrology.diagnose.subject import Fit, Flexible, Subject
from metrology.diagnosis import Diagnosis, Test

FALSE_ALARM = 0.002
"""False-alarm rate of each of the tests whether anything is wrong: together 0.6 % at most."""

SMALLEST = 1e-300
"""Smallest p-value that is told as a number."""

CAUGHT = 10.0
"""Fall of χ² of the base model, begun from an extended optimum, from which on its first optimum was a local one."""


@dataclass(frozen=True)
class Outcome:
    """Everything that the engine found, before it is put into words.

    Parameters
    ----------
    subject : Subject
        What was diagnosed.
    base, last : Fit
        The model as it stands, and with all effects that pay.
    steps : tuple of Step
        Rounds of the selection; the first has the screen of the base model.
    slots : mapping of str to tuple of Rival
        For each effect that was taken: all that were tried in its place, itself included, by evidence.
    tests : tuple of Test
        Score test and tests of the residuals of the base model, then those of the extended one.
    held_base, held_last : HeldOut
        Predictions of left-out blocks.
    failures : tuple of str
        Fits that failed.
    negligible : bool
        Whether what the extension leaves is nothing beside what it took, even if it is real.
    without : mapping of str to Fit
        For each effect that was taken: the model with the others alone.
    """

    subject: Subject
    base: Fit
    last: Fit
    steps: tuple[Step, ...]
    slots: dict[str, tuple[Rival, ...]]
    tests: tuple[Test, ...]
    held_base: HeldOut
    held_last: HeldOut
    failures: tuple[str, ...]
    negligible: bool = False
    without: Mapping[str, Fit] = field(default_factory=dict)

    @property
    def screen(self) -> Screen:
        """Scores at the base model."""
        return self.steps[0].screen

    @cached_property
    def kinds(self) -> dict[str, list[tuple[Fit, float]]]:
        """Other kinds of each effect that may be meant which these data do not rule out (`belief.open_kinds`)."""
        equal = {rival.effect: rival for slot in self.slots.values() for rival in belief.equal(slot)}
        return {name: belief.open_kinds(self.subject, rival) for name, rival in equal.items()}


def rank(
    subject: Subject, *, rng: np.random.Generator, test: str = "", false_alarm: float = FALSE_ALARM, workers: int = 2,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:  # fmt: skip
    """Diagnosis of a model: whether anything is missing, what, how sure, and what it is worth.

    1. The base model is fitted inside the priors of all known inputs.
    2. Tests ask whether anything is wrong: the largest score of all candidates, the residuals over blocks of several
       lengths, and for runs on the rig what a force of any form would take up, all with limits simulated on these very
       runs (`linear.screen`, `residuals.test`, `flexible.test`).
    3. If so, the promising candidates are fitted jointly over all blocks; the one with the most evidence is taken if it
       gains at least 3 in ln Z and predicts left-out blocks better; and so on until nothing pays. Where structure is
       left by one at most, two are sought together.
    4. What else could stand in the place of each effect taken decides between *explained* and *ambiguous*; structure
       that is left at the end means *unexplained*.

    Parameters
    ----------
    subject : Subject
        A model, its candidate effects, some data.
    rng : Generator
        For simulated limits and bootstrap intervals.
    test : str
        Id of the test, for the result.
    false_alarm : float
        Rate at which each of the tests may fail where nothing is missing.
    workers : int
        Fits at a time.
    progress : callable, optional
        Takes one line of text now and then.

    Returns
    -------
    Diagnosis
        Also where a fit fails: the verdict and `failures` say so.
    """
    say = progress or (lambda _text: None)
    say("fitting the base model")
    base = subject.fit((), [{}])
    if base is None:
        return verdict.failed(subject, test)
    search = Search(subject, rng, false_alarm, workers, say)
    whole = _whole(search, base)
    last, steps = search.forward(base)
    for _ in range(2):
        # An extended model may have led out of a local optimum in which the base model was caught.
        again = subject.fit((), [last.values]) if last.effects else None
        if again is None or again.mean_cost > base.mean_cost - CAUGHT / base.count:
            break
        base = again
        search.failures.clear()
        search.beyond.clear()
        whole = _whole(search, base)
        last, steps = search.forward(base)
    scores = _score_test(steps[0].screen, false_alarm)
    if not last.effects and not steps[0].rivals and not all(one.passed for one in whole):
        # Something is wrong that no score shows: try every candidate from plain starts.
        last, steps = _desperate(search, base, steps)
    outcome = _held(search, base, last, steps, (scores, *whole))
    pictures = subject.pictures(outcome.base, outcome.last if outcome.last.effects else None)
    return replace(verdict.worded(outcome, rng, test), pictures=pictures)


def _whole(search: Search, fit: Fit) -> tuple[Test, ...]:
    """Tests whether anything at all is left in the residuals of a fit."""
    found: list[Test | None] = [residuals.test(fit, search.rng, search.false_alarm)]
    if isinstance(search.subject, Flexible):
        found.append(flexible.test(fit, search.subject.families(fit), search.rng, search.false_alarm))
    found.append(_other_line(search, fit))
    return tuple(one for one in found if one is not None)


def _score_test(screen: Screen, false_alarm: float) -> Test:
    found = screen.found
    if not found:
        return Test("score", 0.0, 0.0, 1.0, false_alarm, True, "No candidate can be tested with these data.")
    best = found[0]
    passed = best.p_value > screen.limit
    words = "no candidate asks for a place" if passed else f"{best.direction.effect} asks for a place"
    # Statistic and limit on one scale: p counts the looks among which the score was picked, z does not.
    beyond = best.p_value < SMALLEST
    rare = best.z if beyond else _equivalent(best.p_value)
    among = "" if abs(rare - best.z) < 0.1 else f", as rare as {rare:.1f} of a single two-sided look"
    p = f"< {SMALLEST:g}" if beyond else f"= {best.p_value:.2g}"
    sentence = f"{words}: its score is {best.z:.1f} standard deviations{among} (p {p}, limit {screen.limit:.2g})."
    return Test("score", rare, _equivalent(screen.limit), best.p_value, false_alarm, passed, sentence)


def _equivalent(p: float) -> float:
    """Two-sided standard deviations of a p-value."""
    from scipy.special import ndtri

    return max(0.0, float(-ndtri(min(max(p, SMALLEST), 1.0) / 2)))


def _desperate(search: Search, base: Fit, steps: list[Step]) -> tuple[Fit, list[Step]]:
    screen = steps[0].screen
    scores = [score for score in screen.found if score.share > 0 and score.z > 1.0][:8]
    rivals = search.rivals(base, scores) if scores else ()
    steps = [replace(steps[0], rivals=rivals), *steps[1:]]
    if rivals and rivals[0].log_bayes >= PAYS:
        return rivals[0].fit, steps
    return base, steps


def _held(search: Search, base: Fit, last: Fit, steps: list[Step], tests: tuple[Test, ...]) -> Outcome:
    """Judge on left-out blocks; an effect that predicts worse is refused."""
    held_base = heldout.predict(base) if last.effects else HeldOut(())
    held_last = heldout.predict(last) if last.effects else held_base
    wanted = _wanted(search, last)
    if last.effects and heldout.pays(held_base, held_last) <= wanted:
        held_last = heldout.predict(last, thorough=True)
    if (
        last.effects
        and heldout.pays(held_base, held_last) <= wanted
        and heldout.density(last) - heldout.density(base) <= wanted
    ):
        search.failures.append(f"{', '.join(last.effects)}: fits better and predicts left-out data worse; refused")
        last, held_last = base, held_base
    left = _whole(search, last) if last.effects else ()
    negligible = search.negligible(base, last)
    if not negligible and not all(one.passed for one in left):
        last, left = _polished(search, last, left)
    explained = negligible or all(one.passed for one in left)
    slots = {name: _slot(search, last, name, steps) for name in last.effects if explained or len(last.effects) == 1}
    told = (*tests, *(replace(one, name=f"{one.name} after extension") for one in left))
    without = {last.effects[0]: base} if len(last.effects) == 1 else search.without(last)
    return Outcome(
        search.subject, base, last, tuple(steps), slots, told, held_base, held_last, tuple(search.failures),
        negligible, without,
    )  # fmt: skip


def _polished(search: Search, last: Fit, left: tuple[Test, ...]) -> tuple[Fit, tuple[Test, ...]]:
    """Search once more from where an extended fit ended, before structure is taken for something unknown."""
    again = search.subject.fit(last.effects, [last.values])
    if again is None or again.mean_cost > (last.cost - 1.0) / last.count:
        return last, left
    return again, _whole(search, again)


def _other_line(search: Search, fit: Fit) -> Test | None:
    """Test of a line that is left beside one that the model carries: all its lines have one frequency and one phase."""
    spectral = {name for name, one in search.subject.candidates.items() if one.cause.spectral}
    if not spectral & set(fit.effects):
        return None
    screen = search.screens[id(fit)][1] if id(fit) in search.screens else search.screened(fit)
    lines = [score for score in screen.found if score.direction.effect in spectral]
    if not lines or lines[0].p_value > screen.limit:
        return None
    words = f"Another line is left ({lines[0].direction.effect}, {lines[0].z:.1f} standard deviations)"
    sentence = f"{words}: a model has one frequency and one phase for all of its lines."
    limit = _equivalent(screen.limit)
    return Test("line", float(lines[0].z), limit, lines[0].p_value, search.false_alarm, False, sentence)


def _wanted(search: Search, last: Fit) -> float:
    """Gain in ln of the prediction of left-out data below which an extension is refused.

    As much to the worse as evidence has to be to the better: what predicts as well as before is real, if negligible. An
    input that is wrong beyond what is stated of it changes what has to be believed, not what is predicted.
    """
    kinds = {search.subject.candidates[name].kind for name in last.effects}
    return -2 * PAYS if kinds == {"input"} else -PAYS


def _slot(search: Search, last: Fit, name: str, steps: list[Step]) -> tuple[Rival, ...]:
    """What could stand in the place of an effect, the others being there."""
    if len(last.effects) == 1 and steps[0].rivals and any(rival.effect == name for rival in steps[0].rivals):
        return steps[0].rivals
    place = search.place(last, name)
    if place is None:
        return (Rival(name, last, math.inf),)
    without, rivals = place
    return search.ranked(without, [last, *(rival.fit for rival in rivals)], (name, *(rival.effect for rival in rivals)))
