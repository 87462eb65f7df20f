"""What follows from the results: conformity with requirements, comparisons, and the audit of published figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from metrology.chain import across, zener
from metrology.chain.derived import over
from metrology.chain.knowledge import value_of
from metrology.chain.plan import Identity, Plan
from metrology.declaration.quantity import Stated
from metrology.findings import AuditRow, Comparison, Conformity, Withheld
from metrology.gum.comparison import en
from metrology.gum.conformity import Limits, Prior, Rule, decide, rule_risk
from metrology.gum.evaluation import Estimate, Measurand
from metrology.gum.output import expanded, probability
from metrology.language.display import scale
from metrology.message import said
from metrology.units import convert, si_unit

if TYPE_CHECKING:
    from metrology.campaign.judgement import Audit, Decision, Requirement, Side
    from metrology.campaign.schema import Campaign
    from metrology.chain.doubt import Doubt
    from metrology.gum.evaluation import Evaluation
    from metrology.gum.output import Output

_SLACK = 1e-9  # of the last printed place: what binary fractions may lack at a tie


def add_judged_inputs(plan: Plan, campaign: Campaign) -> None:
    """Add the inputs that a requirement is on as results, since a verdict needs an evaluated quantity.

    Every result with a requirement stands on page 1: a verdict says what it is on (ISO/IEC 17025:2017, 7.8.6.2).
    """
    for requirement in campaign.requirements:
        name = requirement.quantity
        if name in plan.identities:
            plan.identities[name] = replace(plan.identities[name], headline=True)
        if name in plan.inputs and _judged(name) not in plan.names:
            quantity = plan.inputs[name]
            measurand = Measurand(_judged(name), value_of(name), quantity.unit, quantity.description)
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


def _judged(name: str) -> str:
    return f"{name} (as stated)"


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
    for requirement in campaign.requirements:
        estimate = _judged_estimate(requirement, evaluation)
        if estimate is None or estimate.output is None or not _exists(estimate):
            text = "Requirement {name} cannot be judged, for want of {quantity}."
            failures.append(said(text, name=requirement.id, quantity=requirement.quantity))
        else:
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
    return estimates.get(requirement.quantity) or estimates.get(_judged(requirement.quantity))


def _hangs_on(doubt: Doubt, made: Conformity, requirement: Requirement) -> bool:
    """Whether a doubt could change a verdict: one of the shape alone does not far enough from the limits.

    By Chebyshev's inequality no distribution has more than 1/z² beyond z standard uncertainties.
    """
    if not doubt.shape or not made.u > 0:
        return True
    risk = requirement.decision.risk if "risk" in requirement.decision.rule else made.rule_risk or 0.0
    away = [abs(made.value - limit) for limit in (made.lower, made.upper) if limit is not None]
    return not min(away) > made.u / sqrt(max(min(risk, 0.025), 1e-300))


def _exists(estimate: Estimate) -> bool:
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


PRIOR = 0.01
"""Probability of a result so far out, by the prior, below which the one contradicts the other."""
NODES = 4001
"""Equal parts of a prior over which that probability is averaged."""


def priors(campaign: Campaign, evaluation: Evaluation) -> Iterator[str]:
    """Say which requirements state a prior that the result contradicts."""
    for requirement in campaign.requirements:
        estimate = _judged_estimate(requirement, evaluation)
        if estimate is not None and _exists(estimate):
            yield from (one.sentence for one in _of_prior(requirement, estimate, always=True))


def _of_prior(requirement: Requirement, estimate: Estimate, *, always: bool = False) -> Iterator[Doubt]:
    """A prior that the result contradicts, where the verdict hangs on it: by a rule that bounds a risk."""
    from metrology.chain.doubt import Doubt

    prior, output = _prior(requirement), estimate.output
    if prior is None or output is None or not (always or "risk" in requirement.decision.rule):
        return
    p = surprise(output, prior)
    if p < PRIOR:
        text = (
            "{requirement}: {name} contradicts the prior, {prior}: the probability of a result so far out is "
            "{p:figures}. Probabilities that follow from both do not hold."
        )
        shown = probability(p)
        yield Doubt(
            "prior", said(text, requirement=requirement.id, name=requirement.quantity, prior=prior.name, p=shown)
        )


def surprise(output: Output, prior: Prior) -> float:
    """Two-sided probability, by the prior, of a result at least as far out as the one found; by equal parts of it."""
    if not 0 < output.u < inf:
        return 1.0
    nodes = prior.quantile((np.arange(NODES) + 0.5) / NODES)
    # The error of a result is distributed about it as the quantity is: P(y < found | η) = P(quantity > η | found).
    below = sum(output.above(float(node)) for node in nodes) / NODES
    return float(max(0.0, 2 * min(below, 1 - below)))


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
    known_as = {_judged(name): name for name in names}
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
        sides = _known(a, plan, evaluation), _known(b, plan, evaluation)
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
        return _known(side.quantity, plan, evaluation)
    assert side.value is not None
    name = side.value.source or side.value.description or said("stated value")
    return _as_stated(name, side.value, side.value.unit, campaign)


def _known(name: str, plan: Plan, evaluation: Evaluation) -> Known | None:
    """Return a result or an input by its name; None where its evaluation failed."""
    if name in evaluation.estimates:
        estimate = evaluation.estimates[name]
        if not _exists(estimate):
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
                _known(name, plan, evaluation),
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


def audit(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> tuple[AuditRow, ...]:
    """Return each published figure with the recomputed one; a figure that needs a failed result is left out with it."""
    rows = []
    for index, entry in enumerate(campaign.audit):
        recomputed = _recomputed(campaign, plan, evaluation, index)
        if recomputed is None:
            plan.failures.append(said("{name} cannot be recomputed.", name=entry.figure))
        else:
            estimate = evaluation.estimates.get(entry.quantity or "")
            rows.append(_audit_row(entry, *recomputed, estimate.reported if estimate is not None else recomputed))
    return tuple(rows)


def _recomputed(campaign: Campaign, plan: Plan, evaluation: Evaluation, index: int) -> tuple[float, float] | None:
    entry = campaign.audit[index]
    if entry.quantity is not None:
        estimate = evaluation.estimates.get(entry.quantity)
        if estimate is not None:
            # A publication evaluates the equation at the estimates, as the GUM uncertainty framework does.
            return (estimate.value, estimate.u) if _exists(estimate) else None
        known = _known(entry.quantity, plan, evaluation)
        return known[1:3] if known else None
    values = {name: stated.value for name, stated in plan.inputs.items()}
    values |= {name: estimate.value for name, estimate in evaluation.estimates.items() if isfinite(estimate.value)}
    meaning = campaign.names.meanings["audit", index]
    if set(meaning.values()) - values.keys():
        return None
    assert entry.expression is not None
    try:
        return float(over(entry.expression, meaning)(values)), 0.0
    except ValueError:
        return None


def _audit_row(entry: Audit, value: float, u: float, reported: tuple[float, float]) -> AuditRow:
    published = entry.published.quantity
    differs_by = abs(value - published.value)
    agrees = differs_by <= published.resolution * (0.5 + _SLACK)
    text, result = (_text(convert(one, published.unit), published.digits) for one in (value, reported[0]))
    shown = _text(convert(published.value, published.unit), published.digits)
    # An expression recomputes the value alone: a published uncertainty beside it is shown nowhere and judged by nobody.
    if entry.quantity is not None and published.u is not None and published.u_digits is not None:
        place = published.factor * 10.0**-published.u_digits
        agrees = agrees and abs(u - published.u) <= place * (0.5 + _SLACK)
        text += f" ± {_text(u / published.factor, published.u_digits)}"
        result += f" ± {_text(reported[1] / published.factor, published.u_digits)}"
        shown += f" ± {_text(published.u / published.factor, published.u_digits)}"
    unit = "" if published.unit == "1" else f" {published.unit}"
    sentence = _audit_sentence(entry.remark, text + unit, shown + unit, agrees=agrees)
    if result != text:
        # Both stand in one report: which is which must be said.
        other = "{sentence}; by the GUM framework, Monte Carlo {result:figures}"
        sentence = said(other, sentence=sentence, result=result + unit)
    return AuditRow(
        figure=entry.figure,
        source=entry.source,
        published=shown + unit,
        recomputed=text + unit,
        difference=_difference(value, published.value, published.factor, published.digits, unit),
        agrees=agrees,
        sentence=sentence,
    )


def _text(value: float, digits: int) -> str:
    return f"{round(value, digits):.{max(digits, 0)}f}"


def _difference(value: float, published: float, factor: float, digits: int, unit: str) -> str:
    difference = (value - published) / factor
    relative = f" ({(value - published) / published:+.2%})" if published else ""
    return f"{difference:+.{max(digits, 0) + 1}f}{unit}{relative}"


def _audit_sentence(remark: str, recomputed: str, published: str, *, agrees: bool) -> str:
    differs = "recomputed {recomputed:figures}, published {published:figures}"
    verdict = (
        said("agrees to every published digit") if agrees else said(differs, recomputed=recomputed, published=published)
    )
    return said("{verdict}; {remark}", verdict=verdict, remark=remark) if remark else verdict
