"""Attained coverage: how often the interval of a result holds the value that simulated repetitions were drawn with.

A repetition is the evaluation made again with other readings. The estimates are the truth; every input is drawn about
its own: what has finite degrees of freedom with a new scatter, readings by the method's own fit where it has one
(`Ensemble.again`), parameters of a curve by fits to drawn points. Each repetition has an interval of its own, by the
way in which the result is reported, and that interval holds the truth or it does not (JCGM 100:2008, C.2.29 f).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, sqrt
from typing import Annotated, Any

import numpy as np

from metrology.doc import Doc
from metrology.gum.distributions import MeanSquare, Normal, Student
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import KNOWN, Component, Floats, Knowledge
from metrology.gum.joint import joint
from metrology.gum.law import Law, propagate
from metrology.gum.output import Empirical
from metrology.gum.sampling import sampler

REPETITIONS = 2000
"""Their share is known to half a per cent, √(0.95·0.05/2000)."""
DRAWN = 400
"""Repetitions where the interval is that of Monte Carlo draws, which each of them needs: known to 1.1 %."""
TRIALS = 2000
"""Draws of each of those: the smallest block for a 95 % interval, 100/(1 − p) (JCGM 101:2008, 7.9.4 b)."""
_CHANCE = 4.0
"""Standard deviations of the share below which an interval is too narrow: one right interval in 30 000."""
_STEP = 1e-2
"""Step of the differences, in standard uncertainties of the input."""


@dataclass(frozen=True)
class Attained:
    """How often the interval of a result held the value that simulated repetitions of its tests were drawn with."""

    share: Annotated[float, Doc("Part of the repetitions whose interval held it.")]
    repetitions: Annotated[int, Doc("Number of repetitions.")]

    def is_short_of(self, probability: float) -> bool:
        """Whether fewer intervals held it than chance allows: the interval is too narrow."""
        return probability - self.share > _CHANCE * sqrt(probability * (1 - probability) / self.repetitions)


def attained(
    measurands: Sequence[Measurand],
    knowledge: Knowledge,
    wanted: Mapping[str, bool],
    *,
    probability: float = 0.95,
    seed: int,
    repetitions: int = REPETITIONS,
) -> dict[str, Attained]:
    """Attained coverage of results.

    Parameters
    ----------
    measurands : sequence of Measurand
        As for `metrology.gum.evaluate`.
    knowledge : Knowledge
        The inputs, in SI.
    wanted : mapping of str to bool
        By result: whether its interval is that of the GUM uncertainty framework, value ± k·u; otherwise it is the
        shortest one of Monte Carlo draws.
    probability : float
        Of the interval.
    seed : int
        Zero or more; the same seed gives the same repetitions.
    repetitions : int
        At most; `DRAWN` where the interval comes from draws.

    Returns
    -------
    dict of str to Attained
        Share of the intervals that held the value, by result; without those that cannot be repeated.

    Notes
    -----
    JCGM 100:2008 C.2.29, G.4; JCGM 101:2008 8.
    """
    law = propagate(measurands, knowledge)
    rows = [row for row, line in enumerate(law.linear) if line.measurand.name in wanted and _is_repeatable(law, row)]
    if not rows:
        return {}
    generator = np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=(0, 1))))
    reads = frozenset[str]().union(*(law.linear[row].reads for row in rows))
    again = _repeat(law, knowledge, reads, generator, repetitions)
    held: dict[str, Any] = {}
    with np.errstate(all="ignore"):
        values = _evaluated(law, again.estimates, rows)
        for row in rows:
            name, truth = law.linear[row].measurand.name, law.linear[row].value
            if wanted[name]:
                held[name] = np.abs(values[name] - truth) <= _expanded(law, row, again, values, probability)
        drawn = [row for row in rows if not wanted[law.linear[row].measurand.name]]
        intervals = list(_drawn(law, drawn, again, probability, generator)) if drawn else []
        for row in drawn:
            name, truth = law.linear[row].measurand.name, law.linear[row].value
            held[name] = np.array([one[name][0] <= truth <= one[name][1] for one in intervals])
    return {name: Attained(float(one.mean()), len(one)) for name, one in held.items()}


def _is_repeatable(law: Law, row: int) -> bool:
    """Whether the result has an uncertainty, with degrees of freedom that are known, finite or not."""
    return law.u(row) > 0 and not law.dof(row)[1].startswith("undefined")


@dataclass(frozen=True)
class _Again:
    """Repetitions: estimates of the inputs (R,), and u² of each term over that of the evaluation itself, (terms, R)."""

    knowledge: Knowledge
    estimates: dict[str, Any]
    ratios: Floats


def _repeat(law: Law, knowledge: Knowledge, reads: frozenset[str], generator: np.random.Generator, size: int) -> _Again:
    terms = law.joint.terms
    ratios = np.ones((len(terms), size))
    inputs = {name: one for name, one in knowledge.inputs.items() if name in reads}
    fitted = [one for one in knowledge.redrawn if one.repeat is not None and set(one.members) & inputs.keys()]
    simulated = [one for one in knowledge.ensembles if one.again is not None and set(one.members) & inputs.keys()]
    apart = {member for one in fitted for member in one.members} | {
        member for one in simulated for member in one.members
    }
    settled = Knowledge(
        {name: replace(one, components=tuple(map(_settled, one.components))) for name, one in inputs.items()},
        tuple(replace(one, dof=KNOWN) for one in knowledge.ensembles if not apart & set(one.members)),
        knowledge.correlations,
    )
    moved = sampler(settled, joint(settled, inputs.keys() - apart)).draw(generator, size)
    estimates: dict[str, Any] = {
        name: 2 * one.value - moved[name] if isinstance(moved.get(name), np.ndarray) else one.value
        for name, one in inputs.items()
    }
    for rows, dof in law.joint.scatters:
        ratios[rows] = generator.chisquare(dof, size) / dof
    for row, term in enumerate(terms):
        if isinstance(known := term.component.drawn, MeanSquare) and term.input.name in inputs:
            share = generator.chisquare(known.dof, size) / known.dof
            estimates[term.input.name] = term.input.value * share
            ratios[row] = share**2
    for fit in fitted:
        errors, variances = fit.repeat(generator, size)  # type: ignore[misc]
        for member, error, ratio in zip(fit.members, errors, variances, strict=True):
            if member in inputs:
                estimates[member] = inputs[member].value + error
                ratios[law.joint.of_input(member)] = ratio
    for ensemble in simulated:
        assert ensemble.again is not None
        errors, scatter, rest = ensemble.again(generator, size)
        for member, error, own in zip(ensemble.members, errors, rest, strict=True):
            if member in inputs:
                estimates[member] = inputs[member].value + error
                ratios[law.joint.of_input(member)] = own
        ratios[law.joint.rows(ensemble.name)] = scatter
    return _Again(knowledge, estimates, ratios)


def _settled(component: Component) -> Component:
    """The component as errors have it: what scatters as a scaled t about an estimate came of normal readings."""
    if not isfinite(component.dof):
        return component
    drawn = component.drawn
    u = drawn.scale if isinstance(drawn, Student) else component.u
    return replace(component, distribution=Normal(u), dof=inf)


def _evaluated(law: Law, quantities: Mapping[str, Any], rows: Collection[int], by: str = "") -> dict[str, Any]:
    """Inputs and the results `rows` with all that they read; `by`: only what depends on one input is made anew."""
    needed = frozenset[str]().union(*(law.linear[row].reads for row in rows))
    known = dict(quantities)
    for line in law.linear:
        if line.reads <= needed and (not by or by in line.reads):
            try:
                known[line.measurand.name] = line.measurand.function(known)
            except (ArithmeticError, ValueError):
                known[line.measurand.name] = np.nan
    return known


def _expanded(law: Law, row: int, again: _Again, values: dict[str, Any], probability: float) -> Any:
    """k·u of each repetition by the law of propagation at its own estimates, with its own degrees of freedom."""
    from scipy.special import ndtri, stdtrit

    line, terms = law.linear[row], law.joint.terms
    reads = sorted(index for name in line.reads for index in law.joint.of_input(name) if terms[index].component.u > 0)
    slopes: dict[str, Any] = {}
    for name in dict.fromkeys(terms[index].input.name for index in reads):
        step = _STEP * sqrt(sum(terms[index].component.u ** 2 for index in law.joint.of_input(name)))
        ends = [
            _evaluated(law, values | {name: values[name] + side * step}, [row], name)[line.measurand.name]
            for side in (1, -1)
        ]
        slopes[name] = (ends[0] - ends[1]) / (2 * step)
    size = again.ratios.shape[1]
    parts = np.array([
        np.broadcast_to(slopes[terms[index].input.name], size) * law.joint.u[index] * np.sqrt(again.ratios[index])
        for index in reads
    ])  # fmt: skip
    matrix = law.joint.among(reads)
    variance = np.einsum("ar,ab,br->r", parts, matrix, parts, optimize=True)
    inverse = np.zeros(size)
    places = {index: place for place, index in enumerate(reads)}
    for rows, dof in law.joint.scatters:
        own = [places[index] for index in rows if index in places]
        if not own:
            continue
        share = np.einsum("ar,ab,br->r", parts[own], matrix[np.ix_(own, own)], parts[own]) / variance
        inverse += share**2 / dof
    tail = (1 + probability) / 2
    k = np.where(inverse > 0, stdtrit(1 / np.maximum(inverse, 1e-300), tail), ndtri(tail))
    return k * np.sqrt(variance)


def _drawn(
    law: Law, rows: Sequence[int], again: _Again, probability: float, generator: np.random.Generator
) -> Iterator[dict[str, tuple[float, float]]]:
    """Shortest intervals of Monte Carlo draws of the results `rows`, a repetition at a time.

    All repetitions share their draws, each in the sizes that its own scatters give them: an interval is wrong by no
    more than the draws of one evaluation are.
    """
    names = [law.linear[row].measurand.name for row in rows]
    reads = frozenset[str]().union(*(law.linear[row].reads for row in rows))
    pools = list(_pools(law, again, reads, generator))
    for at in range(min(DRAWN, again.ratios.shape[1])):
        known = {name: again.estimates[name] for name in reads}
        known = {name: one[at] if isinstance(one, np.ndarray) else one for name, one in known.items()}
        for pool in pools:
            for name, (row, offsets) in pool.items():
                known[name] = known[name] + offsets * sqrt(again.ratios[row, at])
        values = _evaluated(law, known, rows)
        yield {name: _shortest(values[name], probability) for name in names}


def _shortest(values: Any, probability: float) -> tuple[float, float]:
    ordered = np.sort(np.broadcast_to(values, TRIALS))
    return Empirical(float(ordered.mean()), float(ordered.std()), ordered).interval(probability)


def _pools(
    law: Law, again: _Again, reads: frozenset[str], generator: np.random.Generator
) -> Iterator[dict[str, tuple[int, Floats]]]:
    """Draws of what moves together, by input, with the row of the term that says how much each repetition has of it."""
    terms, knowledge = law.joint.terms, again.knowledge
    fits = [one for one in knowledge.redrawn if reads & set(one.members)]
    fitted = {member for one in fits for member in one.members}
    for fit in fits:
        drawn = zip(fit.members, fit.draw(generator, TRIALS), strict=True)
        yield {name: (law.joint.of_input(name)[0], offsets) for name, offsets in drawn if name in reads}
    free = [row for row, term in enumerate(terms) if term.input.name in reads - fitted and term.component.u > 0]
    steady = [row for row in free if not terms[row].ensemble and (again.ratios[row] == 1).all()]
    shared = [rows for rows in law.joint.causes.values() if not set(rows) & set(steady)]
    together = [*(law.joint.rows(one.name) for one in law.joint.ensembles), *shared]
    alone = set(free).difference(steady, *together)
    for rows in (steady, *together, *([row] for row in alone)):
        own = [row for row in rows if row in free]
        part = Knowledge(
            {
                name: replace(
                    knowledge.inputs[name],
                    components=tuple(
                        terms[row].component for row in own if terms[row].input.name == name and not terms[row].ensemble
                    ),
                )
                for name in dict.fromkeys(terms[row].input.name for row in own)
            },
            tuple(one for one in knowledge.ensembles if one.name in {terms[row].ensemble for row in own}),
            knowledge.correlations,
        )
        values = sampler(part, joint(part, part.inputs)).draw(generator, TRIALS)
        first = {terms[row].input.name: row for row in own}
        yield {name: (first[name], values[name] - one.value) for name, one in part.inputs.items()}
