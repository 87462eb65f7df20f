"""Conformity with requirements: the verdict on each, or the failed checks and the prior that forbid it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from metrology.chain.doubt import Doubt
from metrology.chain.knowledge import value_of
from metrology.chain.plan import Identity, Plan
from metrology.errors import faults_at
from metrology.findings import Conformity, Withheld
from metrology.gum.conformity import decide
from metrology.gum.evaluation import Estimate, Measurand
from metrology.gum.guard_bands import Rule, rule_risk
from metrology.gum.printed_probability import probability
from metrology.gum.risk import Limits, Prior
from metrology.judged import judged_name
from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.judgement import Decision, Requirement
    from metrology.campaign.schema import Campaign
    from metrology.gum.evaluation import Evaluation
    from metrology.gum.output import Output


def add_judged_inputs(plan: Plan, campaign: Campaign) -> None:
    """Add the inputs that a requirement is on as results, since a verdict needs an evaluated quantity.

    Every result with a requirement stands on page 1: a verdict says what it is on (ISO/IEC 17025:2017, 7.8.6.2).
    """
    for requirement in campaign.requirements:
        name = requirement.quantity
        if name in plan.identities:
            plan.identities[name] = replace(plan.identities[name], headline=True)
        if name in plan.inputs and judged_name(name) not in plan.names:
            quantity = plan.inputs[name]
            words = quantity.description or said("as stated")
            measurand = Measurand(judged_name(name), value_of(name), quantity.unit, words)
            unit = campaign.quantities[name].unit if name in campaign.quantities else quantity.unit
            given = (one.display_unit for one in campaign.imported if name in plan.imported[one.about])
            unit = next(given, "") or unit
            # What readings or a fit give is a result already, which need not stand there twice.
            of_readings = (f"{key}.{name}" for key, one in campaign.ensembles.items() if name in one.columns)
            same = next(of_readings, name.replace(".", ".result.", 1))
            if same in plan.identities:
                unit = plan.identities[same].display_unit
                plan.identities[same] = replace(plan.identities[same], headline=False)
            plan.add_measurand(measurand, Identity(name, "derived", display_unit=unit))


def least_risk(campaign: Campaign) -> float:
    """Smallest risk that a rule of the campaign sets its guard band by: it takes draws enough to be judged by them."""
    rules = (requirement.decision for requirement in campaign.requirements)
    return min((one.risk for one in rules if one.rule in ("specific risk", "global risk")), default=1.0)


def conformity(
    campaign: Campaign, evaluation: Evaluation, failures: list[str], doubts: Mapping[str, Sequence[Doubt]]
) -> tuple[tuple[Conformity, ...], tuple[Withheld, ...]]:
    """Return the verdict on every requirement, and those that a failed check forbids.

    One whose quantity could not be evaluated joins the failures.

    Parameters
    ----------
    doubts : mapping of str to sequence of Doubt
        By result: failed checks on its way.
    """
    verdicts, withheld = [], []
    for at, requirement in enumerate(campaign.requirements):
        estimate = _judged_estimate(requirement, evaluation)
        if estimate is None or estimate.output is None or not exists(estimate):
            text = "Requirement {name} cannot be judged, for want of {quantity}."
            failures.append(said(text, name=requirement.id, quantity=requirement.quantity))
        else:
            with faults_at(campaign.at("requirements", at)):
                made = _verdict(requirement, estimate)
            own = (*doubts.get(estimate.name, ()), *_of_prior(requirement, estimate))
            barring = (one for one in own if one.bars(made.verdict) and _hangs_on(one, made, requirement))
            barred = list(dict.fromkeys(one.sentence for one in barring))
            if barred:
                withheld.append(_withheld(made, barred))
            else:
                accepted = tuple(one.acceptance for one in own if one.acceptance)
                verdicts.append(replace(made, accepted=accepted))
    return tuple(verdicts), tuple(withheld)


def _withheld(made: Conformity, reasons: Sequence[str]) -> Withheld:
    """Requirement without its verdict."""
    same = {field.name: getattr(made, field.name) for field in fields(Withheld) if field.name != "reasons"}
    return Withheld(**same, reasons=tuple(reasons))


def _judged_estimate(requirement: Requirement, evaluation: Evaluation) -> Estimate | None:
    """What a requirement is on: a result, or an input as stated."""
    estimates = evaluation.estimates
    return estimates.get(requirement.quantity) or estimates.get(judged_name(requirement.quantity))


def _hangs_on(doubt: Doubt, made: Conformity, requirement: Requirement) -> bool:
    """Whether a doubt could change a verdict: one of the shape alone does not far enough from the limits.

    By Chebyshev's inequality no distribution has more than 1/z² beyond z standard uncertainties.
    """
    if not doubt.shape or not made.u > 0:
        return True
    risk = requirement.decision.risk if "risk" in requirement.decision.rule else made.rule_risk or 0.0
    away = [abs(made.value - limit) for limit in (made.lower, made.upper) if limit is not None]
    return not min(away) > made.u / sqrt(max(min(risk, 0.025), 1e-300))


def exists(estimate: Estimate) -> bool:
    """Whether there is a value with an uncertainty; otherwise the failures say why there is none."""
    return all(isfinite(one) for one in (estimate.value, estimate.u, *estimate.reported))


def _verdict(requirement: Requirement, estimate: Estimate) -> Conformity:
    lower, upper = requirement.limits.lower, requirement.limits.upper
    limits = Limits(lower.si if lower else None, upper.si if upper else None)
    rule, prior = _rule(requirement.decision, estimate), _prior(requirement)
    output = estimate.output
    assert output is not None
    decision = decide(output, limits=limits, rule=rule, prior=prior)
    low, high = output.interval(rule.probability)
    stated = lower or upper
    assert stated is not None
    return Conformity(
        requirement=requirement.id,
        text=requirement.text,
        result=requirement.quantity,
        quantity=requirement.quantity.rpartition(".")[2],
        value=output.value,
        u=output.u,
        unit=estimate.unit,
        display_unit=stated.unit,
        lower=limits.lower,
        upper=limits.upper,
        rule=decision.rule,
        guard_band=decision.guard_band,
        acceptance_lower=decision.acceptance_lower,
        acceptance_upper=decision.acceptance_upper,
        probability=decision.probability,
        verdict=decision.verdict,
        specific_risk=decision.specific_risk,
        global_consumer_risk=decision.global_consumer_risk,
        global_producer_risk=decision.global_producer_risk,
        sentence=decision.sentence,
        rule_risk=rule_risk(rule, output, limits, prior),
        agreed=requirement.decision.agreed.isoformat() if requirement.decision.agreed else "",
        source=requirement.source,
        close_out=requirement.close_out,
        lower_stated=lower.value if lower else "",
        upper_stated=upper.value if upper else "",
        low=low,
        high=high,
        resolution=decision.resolution,
    )


def _rule(decision: Decision, estimate: Estimate) -> Rule:
    return Rule(
        decision.rule,
        factor=decision.factor,
        risk=decision.risk,
        binary=decision.binary,
        coverage_factor=decision.k,
        probability=estimate.coverage.p,
    )


def _prior(requirement: Requirement) -> Prior | None:
    """Return the prior of a requirement: the file's keys are the words that `Prior`'s constructors take, in order."""
    if requirement.prior is None:
        return None
    stated = dict(requirement.prior)
    make = getattr(Prior, stated.pop("distribution"))
    prior: Prior = make(*(getattr(value, "si", value) for value in stated.values()))
    return prior


PRIOR = 0.01
"""Probability of a result so far out, by the prior, below which the one contradicts the other."""
NODES = 4001
"""Equal parts of a prior over which that probability is averaged."""


def priors(campaign: Campaign, evaluation: Evaluation) -> Iterator[str]:
    """Say which requirements state a prior that the result contradicts."""
    for requirement in campaign.requirements:
        estimate = _judged_estimate(requirement, evaluation)
        if estimate is not None and exists(estimate):
            yield from (one.sentence for one in _of_prior(requirement, estimate, always=True))


def _of_prior(requirement: Requirement, estimate: Estimate, *, always: bool = False) -> Iterator[Doubt]:
    """A prior that the result contradicts, where the verdict hangs on it: by a rule that bounds a risk."""
    prior, output = _prior(requirement), estimate.output
    if prior is None or output is None or not (always or "risk" in requirement.decision.rule):
        return
    p = surprise(output, prior)
    if p < PRIOR:
        text = (
            "{requirement}: {name} contradicts the prior, {prior}: the probability of a result so far out is "
            "{p:figures}. Probabilities that follow from both do not hold."
        )
        known = {"name": requirement.quantity, "prior": _words(requirement), "p": probability(p)}
        yield Doubt("prior", said(text, requirement=requirement.id, **known))


def _words(requirement: Requirement) -> str:
    """The prior as it is stated, each number with its unit."""
    name, *numbers = dict(requirement.prior or ()).values()
    return f"{name} ({', '.join(str(getattr(one, 'value', one)) for one in numbers)})"


def surprise(output: Output, prior: Prior) -> float:
    """Two-sided probability, by the prior, of a result at least as far out as the one found; by equal parts of it."""
    if not 0 < output.u < inf:
        return 1.0
    nodes = prior.quantile((np.arange(NODES) + 0.5) / NODES)
    # The error of a result is distributed about it as the quantity is: P(y < found | η) = P(quantity > η | found).
    below = sum(output.above(float(node)) for node in nodes) / NODES
    return float(max(0.0, 2 * min(below, 1 - below)))
