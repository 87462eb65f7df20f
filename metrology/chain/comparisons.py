"""Comparisons: results with one another, with stated values, and with the references of each sample."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

from metrology.chain import across, zener
from metrology.chain.conformity import exists
from metrology.chain.knowledge import value_of
from metrology.chain.plan import Identity, Plan
from metrology.declaration.quantity import Stated
from metrology.findings import Comparison
from metrology.gum.comparison import en
from metrology.gum.evaluation import Estimate, Measurand
from metrology.gum.output import expanded
from metrology.judged import judged_name
from metrology.language.display import scale
from metrology.message import said
from metrology.units import si_unit

if TYPE_CHECKING:
    from metrology.campaign.judgement import Side
    from metrology.campaign.schema import Campaign
    from metrology.gum.evaluation import Evaluation


def comparisons(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> tuple[Comparison, ...]:
    """Return the comparisons that the file asks for, and those of each sample's results with its references.

    Inputs are judged as results are: by their distribution, and with what they share with the other side.
    """
    evaluation = _with_inputs(campaign, plan, evaluation)
    asked = list(_asked(campaign, plan, evaluation))
    named = {frozenset((a[0], b[0])) for _, a, b in asked if a and b}
    pairs = [*asked, *_with_references(campaign, plan, evaluation), *_twice(campaign, plan, evaluation, named)]
    made = []
    for title, a, b in pairs:
        if a and b:
            made.append(_comparison(title, a, b, evaluation))
        else:
            name = title or said("A comparison")
            plan.failures.append(said("{name} cannot be made, for want of a result.", name=name))
    return (*made, *_relaxing(campaign, plan, evaluation))


Known = tuple[str, float, float, str, float, Stated | None]
"""Name, value, standard uncertainty, display unit, coverage factor of the expanded uncertainty; how it is stated."""
STATED = 2.0
"""Coverage factor of a value that is stated without degrees of freedom (ISO/IEC 17043:2010, B.3.1.3 e)."""


def _with_inputs(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Evaluation:
    """The evaluation with every input that the file compares as a result of its own, and their joint correlation."""
    from metrology import gum
    from metrology.gum.law import propagate

    sides = [side.quantity for entry in campaign.comparisons for side in entry.between]
    names = [name for name in dict.fromkeys(sides) if name in plan.inputs and name not in evaluation.estimates]
    if not names:
        return evaluation
    known_as = {judged_name(name): name for name in names}
    added = [Measurand(known, value_of(name), plan.inputs[name].unit) for known, name in known_as.items()]
    p, seed, monte_carlo = campaign.coverage_probability, campaign.seed, campaign.monte_carlo
    found = (
        gum.evaluate(added, plan.knowledge, probability=p, seed=seed, digits=monte_carlo.digits,
                     max_trials=monte_carlo.max_trials)
        if any(one.monte_carlo.trials for one in evaluation.estimates.values()) or not evaluation.estimates
        else gum.evaluate_law(added, plan.knowledge, probability=p)
    )  # fmt: skip
    own = [one for one in plan.measurands if one.name not in known_as]
    law = propagate([*own, *added], plan.knowledge)
    return replace(
        evaluation,
        estimates={**evaluation.estimates, **{known_as[name]: one for name, one in found.estimates.items()}},
        names=tuple(known_as.get(one.measurand.name, one.measurand.name) for one in law.linear),
        correlation=law.coefficients(),
    )


def _asked(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Iterator[tuple[str, Known | None, Known | None]]:
    for entry in campaign.comparisons:
        a, b = (_side(side, campaign, plan, evaluation) for side in entry.between)
        yield entry.title, a, b


def _twice(
    campaign: Campaign, plan: Plan, evaluation: Evaluation, named: set[frozenset[str]]
) -> Iterator[tuple[str, Known | None, Known | None]]:
    """One quantity of one sample by several tests: what a campaign knows twice is compared, asked for or not."""
    for a, b in across.pairs(campaign, plan, evaluation):
        sides = known_value(a, plan, evaluation), known_value(b, plan, evaluation)
        if frozenset((a, b)) not in named and all(sides):
            yield "", *sides


def _relaxing(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Iterator[Comparison]:
    """Relaxation time, and part of the stiffness, of a Zener element and of what a held elongation shows beside it."""
    for a, b in zener.pairs(campaign, plan, evaluation):
        title = said("{a} against {b}", a=a.name, b=b.name)
        times: list[Known] = [(one.name, one.time, one.time_u, "s", STATED, None) for one in (a, b)]
        parts: list[Known] = [(one.name, one.part, one.part_u, "1", STATED, None) for one in (a, b)]
        yield _comparison(said("Relaxation time: {pair}", pair=title), times[0], times[1], evaluation)
        title = said("Part of the stiffness that relaxes: {pair}", pair=title)
        yield _comparison(title, parts[0], parts[1], evaluation)


def _side(side: Side, campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Known | None:
    if side.quantity is not None:
        return known_value(side.quantity, plan, evaluation)
    assert side.value is not None
    name = side.value.source or side.value.description or said("stated value")
    return _as_stated(name, side.value, side.value.unit, campaign)


def known_value(name: str, plan: Plan, evaluation: Evaluation) -> Known | None:
    """Return a result or an input by its name; None where its evaluation failed."""
    if name in evaluation.estimates:
        estimate = evaluation.estimates[name]
        if not exists(estimate):
            return None
        identity = plan.identities.get(name)
        unit = (identity.display_unit if identity else scale(estimate.value, estimate.unit)[1]) or estimate.unit
        return name, *estimate.reported, unit, _coverage_factor(estimate), None
    stated = plan.inputs.get(name)
    if stated is None:
        return None
    return name, stated.value, stated.u, scale(stated.value, stated.unit)[1] or stated.unit, STATED, None


def _coverage_factor(estimate: Estimate) -> float:
    """U/u of the interval that is reported: with few degrees of freedom far more than 2."""
    if estimate.output is None or not estimate.output.u > 0:
        return STATED
    return expanded(estimate.output, estimate.coverage.p) / estimate.output.u


def _with_references(
    campaign: Campaign, plan: Plan, evaluation: Evaluation
) -> Iterator[tuple[str, Known | None, Known | None]]:
    for name, identity in plan.identities.items():
        sample = campaign.samples.get(identity.sample)
        reference = _reference_of(identity, sample.references) if sample else None
        if reference is not None and identity.headline:
            label = reference.source or said("reference value")
            yield (
                said("{a} against {b}", a=name, b=label),
                known_value(name, plan, evaluation),
                _as_stated(label, reference, identity.display_unit, campaign),
            )


def _reference_of(identity: Identity, references: Mapping[str, Stated]) -> Stated | None:
    """Reference of a quantity; that of E stands for the instantaneous modulus, as a pull of a minute gives it."""
    own = references.get(identity.quantity)
    return references.get("E") if own is None and identity.quantity == "E_0" else own


def _as_stated(name: str, stated: Stated, unit: str, campaign: Campaign) -> Known:
    """A stated value; with degrees of freedom its coverage factor is Student's t (JCGM 100, G.4.1)."""
    from metrology.gum.law import coverage_factor, effective_dof

    dof = effective_dof((part.u**2, part.dof) for part in stated.input("").components)
    factor = coverage_factor(campaign.coverage_probability, dof) if isfinite(dof) else STATED
    return name, stated.si, stated.u, unit, factor, stated


def _by_causes(a: Known, b: Known, evaluation: Evaluation) -> float:
    """Correlation coefficient of a result and a stated value by the causes that both name (JCGM 100, F.1.2.3)."""
    for (name, *_), (*_, stated) in ((a, b), (b, a)):
        estimate = evaluation.estimates.get(name)
        if stated is None or estimate is None or not estimate.u * stated.u > 0:
            continue
        moved = dict[str, float]()
        for row in estimate.budget:
            moved[row.cause] = moved.get(row.cause, 0.0) + row.moved
        parts = (part for part in stated.input("").components if part.cause)
        shared = sum(moved.get(part.cause, 0.0) * part.sign * part.u for part in parts)
        return shared / (estimate.u * stated.u)
    return 0.0


def _comparison(title: str, a: Known, b: Known, evaluation: Evaluation) -> Comparison:
    r = across.correlation(evaluation, a[0], b[0]) or _by_causes(a, b, evaluation)
    agreement = en(a[1], a[2], b[1], b[2], correlation=r, k=(a[4], b[4]))
    return Comparison(
        title=title or said("{a} against {b}", a=a[0], b=b[0]),
        a=a[0],
        b=b[0],
        value_a=a[1],
        u_a=a[2],
        value_b=b[1],
        u_b=b[2],
        unit=si_unit(a[3]),
        display_unit=a[3],
        difference=agreement.difference,
        u_difference=agreement.u_difference,
        en=agreement.en,
        agrees=agreement.agrees,
        sentence=agreement.sentence,
    )
