"""How far the data support a result: the model as stated beside the one reported, and what forbids a verdict."""

from __future__ import annotations

import re
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from metrology.diagnosis import Shift
from metrology.findings import AsStated
from metrology.message import counted, said
from metrology.slip import likely

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Identity, Plan
    from metrology.diagnosis import Diagnosis
    from metrology.findings import Comparison, Result, TestItem
    from metrology.gum.evaluation import Estimate, Evaluation
    from metrology.gum.law import Law

POSITIVE = re.compile(r"(k|E|EA)(_0|_inf|_t|_sec|_tan)?|omega_n")
"""Results that no sample has at zero, or below; a damping may be too small to be seen."""
CERTAIN = 2.0
"""|E_n| beyond which two results of one sample contradict each other: one in 16 000 by chance (4 u, U = 2·u)."""
CLASS = sqrt(3.0)
"""Ratio of a result and what is known of it from elsewhere, beyond which one of them is wrong: midway between 1.5, by
which honest moduli of one class of material differ, and two, which half of a section or of a gauge length makes."""
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
    """

    check: str
    sentence: str
    covered: bool = False
    acceptance: str = ""
    concerns: tuple[str, ...] = ()

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
    """

    stated: Mapping[str, AsStated] = field(default_factory=dict)
    tests: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


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
    return Standing(found, tests)


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
    against = _contradictions(plan, compared)
    found = {test.id: _accepted(campaign, plan, test, against.get(test.id, ())) for test in plan.tests}
    return {
        name: (*(one for test in tests for one in found[test] if _concerned(plan, name, test, one)),
               *_undetermined(plan, name, evaluation))
        for name, tests in stands.tests.items()
    }  # fmt: skip


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
        text = "{name} is less than its standard uncertainty: {value:.3g} ± {u:.3g} {unit}."
        sentence = said(text, name=name, value=value, u=u, unit=estimate.unit)
        yield Doubt("value within its uncertainty", sentence)
        return
    output = estimate.output
    if identity.test in plan.corrected and POSITIVE.fullmatch(identity.quantity) and output is not None:
        low, high = output.interval(estimate.coverage.p)
        if low <= 0 < value:
            text = "{name} is not determined: its interval reaches from {low:.3g} to {high:.3g} {unit}."
            sentence = said(text, name=name, low=float(low), high=float(high), unit=estimate.unit)
            yield Doubt("value within its uncertainty", sentence)


def _accepted(campaign: Campaign, plan: Plan, test: TestItem, more: Sequence[Doubt]) -> tuple[Doubt, ...]:
    stated = {one.check: one for one in campaign.tests[test.id].accepted}
    own = (*_doubts(plan, test), *more)
    for name in stated.keys() - {one.check for one in own}:
        text = "{test}: '{name}' is accepted, but no check of that name failed."
        plan.warnings.append(said(text, test=test.id, name=name))
    text = "{sentence} Accepted by {by}: {reason}."
    return tuple(
        replace(one, acceptance=said(text, sentence=one.sentence, by=known.by, reason=known.reason))
        if (known := stated.get(one.check)) else one for one in own
    )  # fmt: skip


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


def _contradictions(plan: Plan, compared: Sequence[Comparison]) -> dict[str, tuple[Doubt, ...]]:
    """Tests whose result contradicts that of another test of the sample, or is far off what is known from elsewhere."""
    found: dict[str, tuple[Doubt, ...]] = {}
    for one in compared:
        sides = [each for each in (plan.identities.get(one.a), plan.identities.get(one.b)) if each and each.test]
        alike = len({(each.sample, each.quantity) for each in sides}) == 1
        ratio = one.value_a / one.value_b if one.value_b else inf
        off = ratio <= 0 or max(ratio, 1 / ratio) > CLASS
        if one.agrees is not False or not alike or not (off or (len(sides) > 1 and abs(one.en or 0.0) > CERTAIN)):
            continue
        name = BETWEEN if len(sides) > 1 else "value known from elsewhere"
        sentence = said("{a} and {b} contradict each other: their ratio is {ratio:.3g}.", a=one.a, b=one.b, ratio=ratio)
        if off and ratio > 0:
            sentence = said(
                "{sentence} Likely: {slip}.", sentence=sentence, slip=likely(ratio, dynamic=_is_dynamic(plan, sides))
            )
        doubt = Doubt(name, sentence)
        for each in sides:
            found[each.test] = (*found.get(each.test, ()), doubt)
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
