"""Evaluation of a relaxation or creep test: from records to inputs, measurement model and finding."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from metrology import message
from metrology.gum.evaluation import Contribution
from metrology.relaxation import checks, outliers
from metrology.relaxation.blocks import Array, blocks
from metrology.relaxation.checks import Bends, Done, Seen
from metrology.relaxation.course import FINE, Course, course, scatter
from metrology.relaxation.evidence import HALF, Said, Supported, said, supported
from metrology.relaxation.finding import RelaxationFinding
from metrology.relaxation.fit import Fitted, Fitter
from metrology.relaxation.forms import Form, Scene
from metrology.relaxation.kernel import Answer
from metrology.relaxation.levels import levels
from metrology.relaxation.mean import FASTEST
from metrology.relaxation.model import Builder, Facts
from metrology.relaxation.noise import colours
from metrology.relaxation.presentation import presented
from metrology.relaxation.ramps import without
from metrology.relaxation.test import Mounting, RelaxationTest
from metrology.timeseries import Channel
from metrology.timeseries.white_noise import quantum

COURSES = 9
"""Branches, from the fastest to the slowest that is looked for, by whose answers a record is divided."""


@dataclass(frozen=True)
class RelaxationAnalysis:
    """What a test hands to the evaluation of the campaign, and what it shows.

    Parameters
    ----------
    contribution : Contribution
        Inputs, ensembles and measurands ``{test}.k_inf`` and so on: of several specimens the means.
    finding : RelaxationFinding
        What the report shows.
    failures : tuple of str
        Why a result is not there.
    """

    contribution: Contribution
    finding: RelaxationFinding
    failures: tuple[str, ...]


def analyse(
    test: RelaxationTest, facts: Facts, namespace: Mapping[str, float], shared: float = 0.0
) -> RelaxationAnalysis:
    """Stiffness at once, in equilibrium and at a time, relaxation times, and moduli over frequency.

    Parameters
    ----------
    test : RelaxationTest
        Records and what is known of the instruments.
    facts : Facts
        What the test declares.
    namespace : mapping of str to float
        Values that the model holds already: lengths, areas.
    shared : float
        Relative standard uncertainty of what turns force by stretch into the moduli, for their bands.
    """
    courses = [_course(test, one) for one in test.mountings]
    cleaned = [outliers.without(test, one, known) for one, known in zip(test.mountings, courses, strict=True)]
    test = replace(test, mountings=tuple(one for one, _ in cleaned))
    courses = [_course(test, one) if note else known for (one, note), known in zip(cleaned, courses, strict=True)]
    whole, found = _evaluated(test, [(one, known, None) for one, known in zip(test.mountings, courses, strict=True)])
    bends = checks.bent(test, whole)
    done = whole
    if bends.names:
        # Superposition with one modulus does not hold on such a ramp: it would draw zero and drift after it.
        parts = [_without(one, known, bends) for one, known in zip(whole, courses, strict=True)]
        done, found = _evaluated(test, parts)
    rounding = {one.mounting.name: one.rounding for one in done}
    steps = {one.mounting.name: _step(test, one) for one in done}
    instants = {one.mounting.name: one.instants for one in done}
    said_of = {one.mounting.name: (one.names, one.said) for one in done}
    at_once = frozenset(one.mounting.name for one in whole if not one.levels.before)
    built = Builder(test, facts, said_of, at_once).built(namespace, rounding, steps, instants)
    finding = presented(test, facts, (Seen(whole, done, bends), found, built), shared)
    finding = replace(finding, notes=(*finding.notes, *(note for _, note in cleaned if note)))
    return RelaxationAnalysis(
        Contribution(built.inputs, tuple(built.ensembles), {}, built.measurands),
        finding,
        tuple(_failures(test, found, bends)),
    )


Part = tuple[Mounting, Course, Done | None]
"""Readings that are evaluated, the course of what was imposed, and what the whole record said before, if anything."""


def _evaluated(test: RelaxationTest, parts: Sequence[Part]) -> tuple[list[Done], Supported]:
    """Weigh all forms on all specimens."""
    seen = [_scene(test, *part) for part in parts]
    fitters = [_fitter(test, part[0], scene, part[1]) for part, scene in zip(parts, seen, strict=True)]
    found = supported(fitters, test.branches)
    done = [_done(test, found, at, fitter, part) for at, (fitter, part) in enumerate(zip(fitters, parts, strict=True))]
    return done, found


def _without(one: Done, imposed: Course, bends: Bends) -> Part:
    """The record of a specimen, without its ramp where the answer is not proportional there."""
    if one.mounting.name not in bends.names:
        return one.mounting, imposed, one
    return (*without(one.mounting, imposed, one.levels), one)


def _course(test: RelaxationTest, one: Mounting) -> Course:
    division = test.stretch_division if test.held == "elongation" else test.force_division
    return course(one.time, test.channels(one)[0], division)


def _fitter(test: RelaxationTest, one: Mounting, scene: Scene, imposed: Course) -> Fitter:
    """Noise of the input acts on the answer by the stiffness, on top of the noise of the answer itself."""
    of, (_, y) = scene.answer.of, test.shown(one)
    steps = np.abs(np.diff(y))
    # No reading is known better than to its division, nor to what an instrument tells of the range.
    least = float(steps[steps > 0].min(initial=np.inf)) / np.sqrt(12)
    own = max(scatter(one.time, y), least, FINE * float(np.ptp(y)))
    return Fitter(scene, colours(of, (scene.scale / own) ** 2 * imposed.covariance(one.time, of)))


def _scene(test: RelaxationTest, one: Mounting, imposed: Course, before: Done | None) -> Scene:
    _, y = test.channels(one)
    t = one.time - one.time[0]
    u = imposed.at(t)
    first = blocks(t, u, y, imposed.first)
    held = before.levels if before is not None else levels(first, imposed)
    duration = float(first.time[-1] - first.time[0])
    ramp = min(held.ramps)
    shortest = max(ramp / FASTEST, 2 * float(first.step.min()))
    longest = max(duration - held.before, 10 * shortest)
    by = [imposed.branch(t, tau) for tau in np.geomspace(shortest, longest, COURSES).tolist()]
    of = blocks(t, u, y, imposed.first, by)
    scale = float(np.ptp(of.y)) / (float(np.ptp(of.u)) or 1.0)
    answer = Answer(of, imposed.time, imposed.u)
    return Scene(answer, test.held, float(np.sqrt(shortest * longest)), (shortest, longest), scale)


def _done(test: RelaxationTest, found: Supported, at: int, fitter: Fitter, part: Part) -> Done:
    """What all forms together say of a specimen."""
    scene, best = fitter.scene, found.fits[at][found.best]
    one, imposed, before = part
    # Of a ramp that is left out the course of what acted is not known: a step at some instant of it.
    whole = len(one.time) == len(test.mountings[at].time)
    unread = imposed.unread(one.time) if before is None else before.unread if whole else before.levels.ramp
    names, known = _said(test, found, at, scene, ramp=whole)
    instants = _of_instant(test, names, (scene, best), unread)
    of_branches = _of_branches(found, at, best.form, test.held)
    held = before.levels if before is not None else levels(scene.answer.of, imposed)
    rounding = _rounding(test, one, scene)
    return Done(
        one, scene, held, best, fitter.noise, names, known, of_branches, imposed.whole, unread, rounding, instants
    )  # fmt: skip


def _of_branches(found: Supported, at: int, best: Form, held: str) -> Said:
    """Times of the branches as ln τ, fastest first, their parts of r₀, and of what faster ones leave of the stiffness.

    By all forms with as many branches, with a drift and without.
    """
    m = best.branches
    if not m:
        return Said(np.empty(0), np.empty((0, 0)), 1.0)

    def numbers(form: Form, values: Array) -> Array:
        first = 1 + form.drift
        sizes = values[first + 1 : first + 1 + m] / values[first]
        # Of a held load each branch adds to the compliance: what it takes of the stiffness is over the sum after it.
        left = 1 - np.cumsum(sizes) + sizes if held == "elongation" else 1 + np.cumsum(sizes)
        return np.concatenate([values[-m:], sizes, sizes / left])

    return said(found, at, numbers, which=lambda form: form.branches == m)


def _said(test: RelaxationTest, found: Supported, at: int, scene: Scene, *, ramp: bool) -> tuple[tuple[str, ...], Said]:
    """Numbers that a specimen's record supports, by their names: of a power law no equilibrium.

    Without its `ramp` nothing is known of what relaxed faster than that took: there is no stiffness at once.
    """
    power = found.power > HALF
    ends: tuple[str, ...] = ("r_0",) if power and test.held == "load" else () if power else ("r_0", "r_inf")
    ends = ends if ramp else tuple(end for end in ends if end != "r_0")
    asked = () if test.at is None else ("r_t", "fall")

    def numbers(form: Form, values: Array) -> Array:
        known = [scene.initial(form, values) if end == "r_0" else scene.final(form, values) for end in ends]
        return np.array([*(stiffness(one) for one in known), *later(form, values)])

    def later(form: Form, values: Array) -> list[Any]:
        if test.at is None:
            return []
        now, fall = scene.at_time(form, values, test.at)
        return [stiffness(now), fall]

    def stiffness(one: Any) -> Any:
        return one if test.held == "elongation" else 1 / one

    if not ends and not asked:
        return (), Said(np.empty(0), np.empty((0, 0)), 1.0)
    known = said(found, at, numbers, which=lambda form: form.power == power)
    if not asked:
        return ends, known
    # Forms with an equilibrium and power laws both have a stiffness at a time: their difference counts.
    whole = said(found, at, lambda form, values: np.array(later(form, values)))
    values, covariance, first = known.values.copy(), known.covariance.copy(), len(ends)
    values[first:] = whole.values
    for place in range(2):
        own = covariance[first + place, first + place]
        covariance[first + place, first + place] = max(own, whole.covariance[place, place])
    return (*ends, *asked), Said(values, covariance, known.dof)


def _of_instant(
    test: RelaxationTest, names: Sequence[str], by: tuple[Scene, Fitted], unread: float
) -> dict[str, float]:
    """Half widths of what is not known of the instant of a step that lies between two readings, by number.

    The model has the step in the middle. Half the interval earlier, the stiffness at once has fallen that much longer
    when it is first read, and so has the one at a time: a rectangular distribution by the most probable form.
    """
    scene, best = by
    found = {}
    for name, time in (("r_0", 0.0), ("r_t", test.at)):
        if unread > 0 and name in names and time is not None:
            now, then = scene.at(best.form, best.values, np.array([time, time + unread / 2]))
            found[name] = abs(float(then - now if test.held == "elongation" else 1 / then - 1 / now))
    return found


def _rounding(test: RelaxationTest, one: Mounting, scene: Scene) -> float:
    """Half a division of what answered, stated or seen, as force by stretch, where readings hardly scatter."""
    _, y = test.shown(one)
    division = test.force_division if test.held == "elongation" else test.stretch_division
    if float(np.median(np.abs(np.diff(y)))) > 0:
        return 0.0
    division = max(division, quantum(Channel(one.name, one.time, y)))
    of = scene.answer.of
    # Of a held load the answer is in the denominator: δk = k²·δx/F.
    stiff = 1.0 if test.held == "elongation" else (np.ptp(of.u) / np.ptp(of.y)) ** 2
    return float(stiff * division / 2 / np.ptp(of.u))


def _step(test: RelaxationTest, one: Done) -> float:
    """Half a division of what was imposed over its whole step, where its readings hardly scatter."""
    u, _ = test.shown(one.mounting)
    division = test.stretch_division if test.held == "elongation" else test.force_division
    if not division > 0 or float(np.median(np.abs(np.diff(u)))) > 0:
        return 0.0
    return float(division / 2 / np.ptp(one.scene.answer.of.u))


def _failures(test: RelaxationTest, found: Supported, bends: Bends) -> Iterator[str]:
    power = found.power > HALF
    if power:
        load = (
            "{test} has no equilibrium stiffness: a power law is supported (probability {power:.3g}), which has none."
        )
        elongation = (
            "{test} has no instantaneous and no equilibrium stiffness: a power law is supported (probability "
            "{power:.3g}), which has none."
        )
        text = load if test.held == "load" else elongation
        yield message.said(text, test=test.name, power=float(found.power))
    if bends.names and not (power and test.held == "elongation"):
        text = "{test} has no instantaneous stiffness: what answered on the ramp is not linear, and is left out."
        yield message.said(text, test=test.name)
