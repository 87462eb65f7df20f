"""How far the data support a result: the model as stated beside the one reported."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from metrology.diagnosis import Shift
from metrology.findings import AsStated
from metrology.message import said

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from metrology.chain.plan import Plan
    from metrology.diagnosis import Diagnosis
    from metrology.findings import Result
    from metrology.gum.evaluation import Estimate, Evaluation
    from metrology.gum.law import Law

SAME = 1e-9
"""Relative difference below which two values are the same but for rounding."""


@dataclass(frozen=True)
class Standing:
    """What a result rests on.

    Parameters
    ----------
    stated : mapping of str to AsStated
        By result: what the model as stated gives, where the data support another one.
    tests : mapping of str to tuple of str
        By result: the tests that it depends on.
    reads : mapping of str to frozenset of str
        By result: itself, and every input and result that it is made of.
    """

    stated: Mapping[str, AsStated] = field(default_factory=dict)
    tests: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    reads: Mapping[str, frozenset[str]] = field(default_factory=dict)


def standing(plan: Plan, evaluation: Evaluation, *, probability: float = 0.95, seed: int = 1) -> Standing:
    """Evaluate the model as stated beside what the data support: each result by the way that its value is reported.

    Parameters
    ----------
    plan, evaluation : Plan, Evaluation
        The model that the data support, and its evaluation.
    probability, seed : float, int
        Of the Monte Carlo method, as in the evaluation.
    """
    from metrology.gum.law import propagate

    names = [test.id for test in plan.tests]
    by_test = {found.test: found for found in plan.diagnosis}
    before = copy(plan)
    for old, new in plan.corrected.values():
        before.exchange(new, old)
    law = propagate(before.measurands, before.knowledge)
    found, tests = {}, {}
    for row, line in enumerate(law.linear):
        name, u = line.measurand.name, law.u(row)
        if name not in evaluation.estimates:
            continue
        own = {line.measurand.name, *line.reads}
        tests[name] = tuple(test for test in names if any(one.startswith(f"{test}.") for one in own))
        after = evaluation.estimates[name]
        changed = [test for test in tests[name] if test in plan.corrected]
        if not changed or not isfinite(line.value):
            continue
        if abs(after.value - line.value) > SAME * abs(line.value) or abs(after.u - u) > SAME * u:
            why = said("{texts}", texts=tuple(reason(by_test[test]) for test in changed))
            found[name] = AsStated(line.value, u, why)
    drawn = {name for name in found if _is_drawn(evaluation.estimates[name])}
    moments = _drawn(law, before, probability, seed) if drawn else {}
    for name in drawn & moments.keys():
        value, u = moments[name]
        found[name] = replace(found[name], value=value, u=u)
    return Standing(found, tests, _reads(plan, before))


def _reads(*plans: Plan) -> dict[str, frozenset[str]]:
    """By result: itself and all that it is made of, by the model that the data support and by the one as stated."""
    from metrology.gum.linear import Namespace

    found: dict[str, frozenset[str]] = {}
    for plan in plans:
        known, reads = Namespace(dict(plan.estimates())), dict[str, frozenset[str]]()
        for one in plan.measurands:
            known.read = set()
            with suppress(ArithmeticError, ValueError, KeyError):
                one.function(known)
            reads[one.name] = frozenset({one.name, *known.read}).union(*(reads.get(name, ()) for name in known.read))
        found = {name: found.get(name, frozenset()) | names for name, names in reads.items()} | {
            name: names for name, names in found.items() if name not in reads
        }
    return found


def _is_drawn(estimate: Estimate) -> bool:
    """Whether a result is reported with mean and standard deviation of its Monte Carlo draws."""
    return not estimate.monte_carlo.law_valid and isfinite(estimate.monte_carlo.u)


def _drawn(law: Law, before: Plan, probability: float, seed: int) -> dict[str, tuple[float, float]]:
    """Mean and standard deviation of every output by Monte Carlo: enough trials for two digits of u (JCGM 101, 7.2.2).

    By them u of a result and of the model as stated differ by the models alone: the framework takes s/√n of few
    readings as it is, the draws of Student's t have √(ν/(ν − 2)) times that.
    """
    from metrology.gum.monte_carlo import Plan as Draws
    from metrology.gum.monte_carlo import run, sufficient
    from metrology.gum.sampling import sampler

    measurands = [line.measurand for line in law.linear]
    draws = Draws(probability, seed, max_trials=sufficient(probability), adaptive=False)
    outputs = run(measurands, sampler(before.knowledge, law.joint), draws, lambda _batches: 1.0).outputs
    return {
        one.name: (float(row.mean()), float(row.std(ddof=1)))
        for one, row in zip(measurands, outputs, strict=True)
        if np.isfinite(row).all()
    }


def reason(found: Diagnosis) -> str:
    """Why the results of a test are not those of the model as stated."""
    titles = {cause.effect: said("{title:lowered}", title=cause.title) for cause in found.causes}
    named = tuple(titles[name] for name in found.named)
    several = [tuple(titles[name] for name in one) for one in found.groups if len(one) > 1]
    groups = tuple(said("{titles:or}", titles=one) for one in several)
    match found.verdict:
        case "explained":
            return said("the model is extended: {effects:comma}", effects=named)
        case "explained in the main":
            text = "the model is extended: {effects:comma}; what it does not explain is in u"
            return said(text, effects=(*named, *groups))
        case "ambiguous":
            undecided = tuple(titles[name] for name in found.undecided)
            alike = "the mean over models that these data cannot distinguish: {groups:comma}"
            doubtful = "the mean over models with and without what these data do not decide: {effects:comma}"
            parts = (
                named and said("the model is extended: {effects:comma}", effects=named),
                groups and said(alike, groups=groups),
                undecided and said(doubtful, effects=undecided),
            )
            return said("{texts}", texts=tuple(part for part in parts if part))
        case _:
            return said("what no known cause explains is in u")


def shifted(diagnosis: Sequence[Diagnosis], results: Sequence[Result]) -> tuple[Diagnosis, ...]:
    """Diagnoses whose shifts are those of the results: one value, with the uncertainty of the whole budget."""
    return tuple(replace(one, shifts=tuple(_shifts(one, results)) or one.shifts) for one in diagnosis)


def _shifts(found: Diagnosis, results: Sequence[Result]) -> Iterator[Shift]:
    for result in results:
        stated = result.stated
        if result.test == found.test and result.headline and stated is not None and result.quantity != "E":
            moved = (result.value - stated.value) / max(stated.u, 1e-300)
            yield Shift(result.quantity, result.unit, stated.value, stated.u, result.value, result.u, moved)
