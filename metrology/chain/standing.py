"""How far the data support a result: the model as stated beside the one reported, and what forbids a verdict."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field, replace
from itertools import combinations
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from metrology.diagnosis import Shift
from metrology.findings import AsStated
from metrology.gum.comparison import en
from metrology.gum.output import probability
from metrology.gum.points import REFUTED
from metrology.gum.rounding import readable, significant
from metrology.message import counted, said
from metrology.slip import likely

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from metrology.campaign.judgement import Comparison as StatedComparison
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Identity, Plan
    from metrology.declaration.acceptance import Acceptance
    from metrology.diagnosis import Diagnosis
    from metrology.findings import Comparison, Result, TestItem
    from metrology.gum.evaluation import Estimate, Evaluation
    from metrology.gum.law import Law
    from metrology.message import Value

POSITIVE = re.compile(r"(k|E|EA)(_0|_inf|_t|_sec|_tan)?|omega_n")
"""Results that no sample has at zero, or below; a damping may be too small to be seen."""
UNDETERMINED = "value within its uncertainty"
"""Name of the check that such a result is known to be above zero."""
CERTAIN = 2.0
"""|E_n| beyond which two results of one sample contradict each other: one in 16 000 by chance (4 u, U = 2·u)."""
CLASS = sqrt(3.0)
"""Ratio of a result and what is known of it from elsewhere, beyond which one of them is wrong: midway between 1.5, by
which honest moduli of one class of material differ, and two, which half of a section or of a gauge length makes."""
MATERIAL = re.compile(r"(E|G|nu|rho)(_0|_inf|_t|_sec|_tan)?")
"""Quantities of a material: what a handbook says of them is of another specimen, and holds within its class (`CLASS`).
A value known from elsewhere of any other quantity is of this very one."""
MODULUS = re.compile(r"E(_0|_inf|_t|_sec|_tan)?")
STIFFEST = 1.21e12
"""Modulus in Pa of diamond along ⟨111⟩, by c11 = 1079, c12 = 124, c44 = 578 GPa (H. J. McSkimin, P. Andreatch, J. Appl.
Phys. 43 (1972) 2944): no material is stiffer. A unit wrong by 1000 makes one that is."""
DAMPING = ("c", "zeta")
"""Results of a test that say nothing of its other ones."""
SHARE = 0.05
"""Part of u² of a result below which it does not matter what distribution a contribution has."""
ELSEWHERE = "value known from elsewhere"
"""Failed check of a result and what is known of it from elsewhere."""
BETWEEN = "another test of the sample"
"""Failed check of two tests whose results contradict each other."""
POOR = 1.3**2
"""Reduced χ² beyond which a fit that no diagnosis judged leaves more than noise, as of the direct fit of a decay."""
SAME = 1e-9
"""Relative difference below which two values are the same but for rounding."""


@dataclass(frozen=True)
class Doubt:
    """A failed check on the way to a result.

    Parameters
    ----------
    check : str
        Its name, by which the laboratory may accept it.
    sentence : str
        What failed, of which test.
    covered : bool
        Whether the uncertainty covers what failed, so that a fail stands and only a pass is forbidden.
    acceptance : str
        Reason and person, where the laboratory accepts it.
    concerns : tuple of str
        Quantities of its test that it says something of; empty where it is all.
    shape : bool
        Whether it is of the shape of a distribution alone: value and standard uncertainty hold, and so does a verdict
        that no distribution with them could change.
    """

    check: str
    sentence: str
    covered: bool = False
    acceptance: str = ""
    concerns: tuple[str, ...] = ()
    shape: bool = False

    def bars(self, verdict: str) -> bool:
        """Whether it forbids a verdict."""
        return not self.acceptance and not (self.covered and "fail" in verdict)


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
        own = {line.measurand.name, *line.reads}
        tests[name] = tuple(test for test in names if any(one.startswith(f"{test}.") for one in own))
        after = evaluation.estimates.get(name)
        changed = [test for test in tests[name] if test in plan.corrected]
        if after is None or not changed or not isfinite(line.value):
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
    from metrology.gum.law import Namespace

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


def doubts(
    campaign: Campaign, plan: Plan, stands: Standing, evaluation: Evaluation, compared: Sequence[Comparison]
) -> dict[str, tuple[Doubt, ...]]:
    """Failed checks on the way to every result, by its name; an acceptance that fits none joins the warnings."""
    against, of_names = _contradictions(campaign, plan, compared)
    for name, doubt in _impossible(plan, evaluation):
        against[plan.identities[name].test] = (*against.get(plan.identities[name].test, ()), doubt)
    found = {test.id: _accepted(campaign, plan, test, against.get(test.id, ())) for test in plan.tests}
    for names in (_of_readings(plan), _of_fits(campaign, plan), _of_imports(campaign, plan)):
        for name, more in names.items():
            of_names[name] = (*of_names.get(name, ()), *more)
    return {
        name: tuple(dict.fromkeys((
            *(one for test in tests for one in found[test] if _concerned(plan, name, test, one)),
            *(one for other in sorted(stands.reads.get(name, frozenset({name})) & of_names.keys())
              for one in of_names[other] if not one.shape or _matters(evaluation, name, other)),
            *_undetermined(plan, name, evaluation),
        )))
        for name, tests in stands.tests.items()
    }  # fmt: skip


def _matters(evaluation: Evaluation, name: str, given: str) -> bool:
    """Whether the distribution of an input shows in that of a result."""
    estimate = evaluation.estimates[name]
    part = sum(row.contribution for row in estimate.budget if row.input == given)
    return part**2 > SHARE * estimate.u**2 if isfinite(estimate.u) else True


def _of_readings(plan: Plan) -> dict[str, tuple[Doubt, ...]]:
    """Means and fits whose readings are not independent or do not scatter, and fits that are used beyond their data."""
    plan.warnings.extend(dict.fromkeys(one.sentence for found in plan.suspect.values() for one in found))
    return {
        name: tuple(_with(Doubt("readings", one.sentence), one.accepted) for one in found)
        for name, found in plan.suspect.items()
    }


def _of_fits(campaign: Campaign, plan: Plan) -> dict[str, tuple[Doubt, ...]]:
    """Parameters of fits that χ² refutes and whose stated uncertainties are kept all the same."""
    found: dict[str, tuple[Doubt, ...]] = {}
    for fit in plan.fits:
        stated = campaign.fits[fit.name]
        if fit.p_value is None or fit.p_value >= REFUTED or stated.scatter != "stated":
            continue
        text = "The data of fit {name} refute its stated uncertainties ({p:figures}), which are kept all the same."
        chance = probability(fit.p_value)
        sentence = said(text, name=fit.name, p=f"p {chance}" if chance.startswith("<") else f"p = {chance}")
        doubt = _with(Doubt("fit", sentence), stated.accepted)
        found |= {f"{fit.name}.{parameter}": (doubt,) for parameter in fit.parameters}
    return found


def _of_imports(campaign: Campaign, plan: Plan) -> dict[str, tuple[Doubt, ...]]:
    """Inputs that are results of other campaigns which their own report does not judge, or not as they enter here."""
    found: dict[str, tuple[Doubt, ...]] = {}
    for one in campaign.imported:
        entered = plan.imported[one.about]
        known: dict[str, Value] = {
            "names": entered or (one.result,), "result": one.result, "report": one.report,
        }  # fmt: skip
        doubts = []
        if one.reasons:
            text = "{names:comma}: {result} of {report} is not judged in its own report: {reasons:space}"
            doubts.append(Doubt("imported result", said(text, reasons=one.reasons, **known)))
        if one.lost:
            text = "{names:comma}: {result} of {report} enters with its standard uncertainty alone: {what}."
            doubts.append(Doubt("imported result", said(text, what=one.lost, **known), covered=True, shape=True))
        if one.loose:
            text = (
                "{names:comma}: part of the uncertainty of {result} of {report} is in no row of its budget, as is that "
                "of another result of that report; how the two are correlated is not known."
            )
            doubts.append(Doubt("imported result", said(text, **known)))
        plan.warnings.extend(doubt.sentence for doubt in doubts)
        # One that is found nowhere may have gone into any of them.
        for name in entered or plan.identities:
            found[name] = (*found.get(name, ()), *doubts)
    return found


def _with(doubt: Doubt, accepted: Acceptance | None) -> Doubt:
    """A doubt with what the laboratory says where it accepts it."""
    if accepted is None:
        return doubt
    text = "{sentence} Accepted by {by}: {reason}."
    return replace(doubt, acceptance=said(text, sentence=doubt.sentence, by=accepted.by, reason=accepted.reason))


def _concerned(plan: Plan, name: str, test: str, doubt: Doubt) -> bool:
    """Whether a doubt says something of a result: of one that is derived from others of the test it may."""
    identity = plan.identities[name]
    return not doubt.concerns or identity.test != test or identity.quantity in doubt.concerns


def _undetermined(plan: Plan, name: str, evaluation: Evaluation) -> Iterator[Doubt]:
    """A result that is positive by nature, and not known to be so: the readings say next to nothing of it.

    By its standard uncertainty; by its interval where a diagnosis changed the model.
    """
    estimate, identity = evaluation.estimates[name], plan.identities[name]
    value, u = estimate.reported
    if identity.test and POSITIVE.fullmatch(identity.quantity) and u > value:
        less = "{name} is less than its standard uncertainty: {value:figures} ± {u:figures} {unit}."
        text = less if value > 0 else "{name} is not positive: {value:figures} ± {u:figures} {unit}."
        rounded, of_u = significant(value, u)
        sentence = said(text, name=name, value=rounded, u=of_u, unit=estimate.unit)
        yield Doubt(UNDETERMINED, sentence)
        return
    output = estimate.output
    if identity.test in plan.corrected and POSITIVE.fullmatch(identity.quantity) and output is not None:
        low, high = output.interval(estimate.coverage.p)
        if low <= 0 < value:
            text = "{name} is not determined: its interval reaches from {low:.3g} to {high:.3g} {unit}."
            sentence = said(text, name=name, low=float(low), high=float(high), unit=estimate.unit)
            yield Doubt(UNDETERMINED, sentence)


def _impossible(plan: Plan, evaluation: Evaluation) -> Iterator[tuple[str, Doubt]]:
    """Moduli that no material has: force, stretch, length or section of the test is wrong, it is not known which."""
    for name, estimate in evaluation.estimates.items():
        identity, (value, u) = plan.identities[name], estimate.reported
        of_test = identity.method != "derived" and MODULUS.fullmatch(identity.quantity)
        if of_test and isfinite(u) and value - 2 * u > STIFFEST:
            text = (
                "{name} is above the modulus of diamond, {limit:figures}: force, stretch, length or section is wrong."
            )
            sentence = said(text, name=name, limit=readable(STIFFEST, "Pa", 3))
            plan.warnings.append(sentence)
            yield name, Doubt("modulus", sentence)


def _accepted(campaign: Campaign, plan: Plan, test: TestItem, more: Sequence[Doubt]) -> tuple[Doubt, ...]:
    stated = {one.check: one for one in campaign.tests[test.id].accepted}
    own = (*_doubts(plan, test), *more)
    failed = {one.name for one in getattr(test.finding, "checks", ()) if one.passed is False}
    for name in stated.keys() - {one.check for one in own}:
        text = (
            "{test}: '{name}' is accepted; the check failed, but forbids no verdict: the model or the uncertainty "
            "contains what failed."
            if name in failed
            else "{test}: '{name}' is accepted, but no check of that name failed."
        )
        plan.warnings.append(said(text, test=test.id, name=name))
    return tuple(_with(one, stated.get(one.check)) for one in own)


def _doubts(plan: Plan, test: TestItem) -> Iterator[Doubt]:
    """Failed checks that no diagnosis explains, a diagnosis without a model, and a model that held-out runs refute."""
    found = next((one for one in plan.diagnosis if one.test == test.id), None)
    verdict = found.verdict if found is not None else "nothing missing"
    if verdict in ("unexplained", "explained in the main"):
        found_so = said("The diagnosis of {test} is: {verdict}.", test=test.id, verdict=verdict)
        yield Doubt("diagnosis", found_so, covered=True)
    if verdict == "not finished":
        yield Doubt("diagnosis", said("The diagnosis of {test} is not finished.", test=test.id))
    if test.id in plan.undiagnosed:
        yield Doubt("diagnosis", plan.undiagnosed[test.id])
    misfit = getattr(test.finding, "chi_squared", None)
    if found is None and misfit is not None and misfit > POOR:
        text = "The fit of {test} leaves {times:.3g} times the noise of its readings."
        yield Doubt("fit", said(text, test=test.id, times=sqrt(misfit)))
    if test.decay is not None and (lost := len(test.decay.failures)):
        sentence = counted(
            "{count} record of {test} could not be evaluated: what the others scatter by does not hold for it.",
            "{count} records of {test} could not be evaluated: what the others scatter by does not hold for them.",
            lost,
            test=test.id,
        )
        yield Doubt("records", sentence)
    explained = verdict in ("explained", "ambiguous") and found is not None and found.is_decided
    there = {*found.named, *(name for group in found.groups for name in group)} if found is not None else set()
    for check in getattr(test.finding, "checks", ()):
        # What a diagnosis explains is in the model; that the recorder failed is in none.
        in_model = explained and (check.effects is None or not there.isdisjoint(check.effects))
        if check.passed is False and not check.covered and not in_model:
            failed = said("{test} failed the check '{name}'.", test=test.id, name=check.name)
            yield Doubt(check.name, failed, concerns=check.concerns)
    judged = [one for one in plan.verification if one["test"] == test.id]
    if judged and judged[-1]["verdict"] == "not validated":
        refuted = (
            said("Held-out runs of {test} do not validate the extended model.", test=test.id)
            if judged[-1]["basis"] == "extended"
            else said("Held-out runs of {test} do not validate the model.", test=test.id)
        )
        yield Doubt("verification", refuted)


def _contradictions(
    campaign: Campaign, plan: Plan, compared: Sequence[Comparison]
) -> tuple[dict[str, tuple[Doubt, ...]], dict[str, tuple[Doubt, ...]]]:
    """Tests, and quantities by name, that contradict another test of the sample or what is known from elsewhere."""
    of_tests: dict[str, tuple[Doubt, ...]] = {}
    of_names: dict[str, tuple[Doubt, ...]] = {}
    exchanged = _exchanged(campaign, plan, compared)
    for one in compared:
        names = [name for name in dict.fromkeys((one.a, one.b)) if name in plan.names]
        sides = [each for name in names if (each := plan.identities.get(name)) and each.test]
        doubt = (
            _between(plan, one, sides) if len(names) > 1 else _elsewhere(plan, one, names[0], exchanged) if names
            else None
        )  # fmt: skip
        if doubt is None:
            continue
        entry = next((each for each in campaign.comparisons if _is_of(each, one)), None)
        doubt = _with(doubt, entry.accepted if entry is not None else None)
        for each in sides:
            of_tests[each.test] = (*of_tests.get(each.test, ()), doubt)
        for name in names if not sides else ():
            of_names[name] = (*of_names.get(name, ()), doubt)
    return of_tests, of_names


def _is_of(stated: StatedComparison, one: Comparison) -> bool:
    """Whether a comparison is the one that the file states."""
    sides = [side.quantity or (side.value and (side.value.source or side.value.description)) for side in stated.between]
    own = f"{one.a} against {one.b}"
    return (stated.title or own) == one.title and all(side in (one.a, one.b) for side in sides if side)


def _off(one: Comparison) -> tuple[bool, float]:
    """Whether two values are further apart than honest ones of one class, and their ratio."""
    ratio = one.value_a / one.value_b if one.value_b else inf
    return ratio <= 0 or max(ratio, 1 / ratio) > CLASS, ratio


def _between(plan: Plan, one: Comparison, sides: Sequence[Identity]) -> Doubt | None:
    """Results of two tests, or of one and a quantity that the campaign states."""
    alike = len({(each.sample, each.quantity) for each in sides}) == 1
    off, _ = _off(one)
    if one.agrees is not False or not alike or not (off or (len(sides) > 1 and abs(one.en or 0.0) > CERTAIN)):
        return None
    return Doubt(BETWEEN if len(sides) > 1 else ELSEWHERE, _contradiction(plan, one, sides))


def _elsewhere(plan: Plan, one: Comparison, name: str, exchanged: Mapping[str, str]) -> Doubt | None:
    """A quantity and what is known of it from elsewhere: of a material its class, of anything else this very one."""
    identity = plan.identities.get(name)
    sides = [identity] if identity is not None and identity.test else []
    off, _ = _off(one)
    if one.agrees or one.difference == 0:
        return None
    if off:
        return Doubt(ELSEWHERE, _contradiction(plan, one, sides))
    if identity is not None and MATERIAL.fullmatch(identity.quantity):
        return None
    sentence = (
        said("{a} and {b} contradict each other: no uncertainty covers their difference.", a=one.a, b=one.b)
        if one.en is None
        else said("{a} and {b} contradict each other: |E_n| = {en:.3g}.", a=one.a, b=one.b, en=abs(one.en))
    )
    if name in exchanged:
        sentence = said("{texts:space}", texts=(sentence, exchanged[name]))
    concerns = DAMPING if sides and sides[0].quantity in DAMPING else ()
    return Doubt(ELSEWHERE, sentence, covered=True, concerns=concerns)


def _contradiction(plan: Plan, one: Comparison, sides: Sequence[Identity]) -> str:
    off, ratio = _off(one)
    sentence = said("{a} and {b} contradict each other: their ratio is {ratio:.3g}.", a=one.a, b=one.b, ratio=ratio)
    if not off or ratio <= 0:
        return sentence
    slip = likely(ratio, dynamic=_is_dynamic(plan, sides))
    return said("{sentence} Likely: {slip}.", sentence=sentence, slip=slip)


def _exchanged(campaign: Campaign, plan: Plan, compared: Sequence[Comparison]) -> dict[str, str]:
    """Results of two samples of which each fits the other's reference and not its own: what that means, by result."""
    found: dict[str, str] = {}
    refuted = [
        (one, identity) for one in compared
        if one.agrees is False and (identity := plan.identities.get(one.a)) is not None and identity.test
        and one.b not in plan.names and identity.quantity in campaign.samples[identity.sample].references
    ]  # fmt: skip
    for (one, own), (other, others) in combinations(refuted, 2):
        if own.sample == others.sample or (own.quantity, one.unit) != (others.quantity, other.unit):
            continue
        crossed = (en(a.value_a, a.u_a, b.value_b, b.u_b).agrees for a, b in ((one, other), (other, one)))
        if all(crossed):
            text = "{a} fits the reference of {second} and {b} that of {first}: the samples may be exchanged."
            sentence = said(text, a=one.a, b=other.a, first=own.sample, second=others.sample)
            found |= {one.a: sentence, other.a: sentence}
            plan.warnings.append(sentence)
    return found


def _is_dynamic(plan: Plan, sides: Sequence[Identity]) -> bool:
    """Whether one of some results follows from a frequency, as those of a mass that moves do."""
    methods = {test.id: test.method for test in plan.tests}
    return any(methods[each.test] in ("decay", "response") for each in sides)


def shifted(diagnosis: Sequence[Diagnosis], results: Sequence[Result]) -> tuple[Diagnosis, ...]:
    """Diagnoses whose shifts are those of the results: one value, with the uncertainty of the whole budget."""
    return tuple(replace(one, shifts=tuple(_shifts(one, results)) or one.shifts) for one in diagnosis)


def _shifts(found: Diagnosis, results: Sequence[Result]) -> Iterator[Shift]:
    for result in results:
        stated = result.stated
        if result.test == found.test and result.headline and stated is not None and result.quantity != "E":
            moved = (result.value - stated.value) / max(stated.u, 1e-300)
            yield Shift(result.quantity, result.unit, stated.value, stated.u, result.value, result.u, moved)
