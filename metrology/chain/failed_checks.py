"""Failed checks on the way to every result: what forbids a verdict on it."""

from __future__ import annotations

import re
from itertools import product
from math import isfinite, sqrt
from typing import TYPE_CHECKING

from metrology.campaign.copies import of_one_record
from metrology.chain.contradictions import contradictions
from metrology.chain.doubt import Doubt, with_acceptance
from metrology.chain.extrapolation import extrapolated
from metrology.gum.points import REFUTED
from metrology.gum.printed_probability import probability
from metrology.gum.rounding import readable, significant
from metrology.message import counted, said

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from metrology.campaign.imported import Imported
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.chain.standing import Standing
    from metrology.findings import Comparison, TestItem
    from metrology.gum.evaluation import Evaluation
    from metrology.message import Value

POSITIVE = re.compile(r"(k|E|EA)(_0|_inf|_t|_sec|_tan)?|omega_n")
"""Results that no sample has at zero, or below; a damping may be too small to be seen."""
UNDETERMINED = "value within its uncertainty"
"""Name of the check that such a result is known to be above zero."""
MODULUS = re.compile(r"E(_0|_inf|_t|_sec|_tan)?")
STIFFEST = 1.21e12
"""Modulus in Pa of diamond along ⟨111⟩, by c11 = 1079, c12 = 124, c44 = 578 GPa (H. J. McSkimin, P. Andreatch, J. Appl.
Phys. 43 (1972) 2944): no material is stiffer. A unit wrong by 1000 makes one that is."""
ON_FILE = (
    "{names:comma} of {report} rests on the file {paths:comma}, and so does {other}: they are taken for independent."
)
SHARE = 0.05
"""Part of u² of a result below which it does not matter what distribution a contribution has."""
POOR = 1.3**2
"""Reduced χ² beyond which a fit that no diagnosis judged leaves more than noise, as of the direct fit of a decay."""


def doubts(
    campaign: Campaign, plan: Plan, stands: Standing, evaluation: Evaluation, compared: Sequence[Comparison]
) -> dict[str, tuple[Doubt, ...]]:
    """Failed checks on the way to every result, by its name; an acceptance that fits none joins the warnings."""
    against, of_names = contradictions(campaign, plan, compared)
    for name, doubt in _impossible(plan, evaluation):
        against[plan.identities[name].test] = (*against.get(plan.identities[name].test, ()), doubt)
    found = {test.id: _accepted(campaign, plan, test, against.get(test.id, ())) for test in plan.tests}
    for name, doubt in extrapolated(campaign, plan, evaluation):
        if plan.identities[name].headline:
            plan.warnings.append(doubt.sentence)
        of_names[name] = (*of_names.get(name, ()), doubt)
    for names in (_of_readings(plan), _of_fits(campaign, plan), _of_imports(campaign, plan)):
        for name, more in names.items():
            of_names[name] = (*of_names.get(name, ()), *more)
    plan.warnings.extend(_needless(campaign, [*found.values(), *of_names.values()]))
    again = list(_evaluated_again(campaign, plan))
    return {
        name: tuple(dict.fromkeys((
            *(one for test in tests for one in found[test] if _concerned(plan, name, test, one)),
            *(one for other in sorted(stands.reads.get(name, frozenset({name})) & of_names.keys())
              for one in of_names[other] if not one.shape or _matters(evaluation, name, other)),
            *(doubt for both, doubt in again if both <= stands.reads.get(name, frozenset()) | set(tests)),
            *_undetermined(plan, name, evaluation),
        )))
        for name, tests in stands.tests.items()
    }  # fmt: skip


def _evaluated_again(campaign: Campaign, plan: Plan) -> Iterator[tuple[frozenset[str], Doubt]]:
    """Two tests, or inputs of another campaign, that rest on one record: together they are no two measurements."""
    if not campaign.derived and not campaign.imported:
        return
    for pair in sorted(of_one_record(campaign), key=sorted):
        text = "{tests:comma} evaluate one record, which is taken for two."
        yield pair, Doubt("records", said(text, tests=tuple(sorted(pair))))
    yield from _imported_again(campaign, plan)


def _imported_again(campaign: Campaign, plan: Plan) -> Iterator[tuple[frozenset[str], Doubt]]:
    """Inputs of another campaign that rest on a record of another one, or of a test of this one."""
    own = {owner[1]: {table.source.sha256 for table in tables} for owner, tables in campaign.tables.items()
           if owner[0] == "tests"}  # fmt: skip
    for at, one in enumerate(campaign.imported):
        entered = plan.imported[one.about]
        known: dict[str, Value] = {"names": entered, "report": one.report}
        for other in campaign.imported[:at]:
            others = plan.imported[other.about]
            if one.is_numbered and (other.report, other.result) == (one.report, one.result):
                text = "{names:comma} and {others:comma} are one result of {report}, evaluated twice."
                sentence = said(text, others=others, **known)
            elif other.sha256 != one.sha256 and (paths := _of_files(one, {sha for _, sha in other.records})):
                sentence = said(ON_FILE, paths=paths, other=other.result, **known)
            else:
                continue
            yield from ((frozenset(both), Doubt("records", sentence)) for both in product(entered, others))
        for test, files in own.items():
            if paths := _of_files(one, files):
                doubt = Doubt("records", said(ON_FILE, paths=paths, other=test, **known))
                yield from ((frozenset((name, test)), doubt) for name in entered)


def _of_files(one: Imported, files: Collection[str]) -> tuple[str, ...]:
    """Files, by name, that the campaign of an imported result read, among those of some hashes."""
    return tuple(path for path, sha in one.records if sha in files)


def _matters(evaluation: Evaluation, name: str, given: str) -> bool:
    """Whether the distribution of an input shows in that of a result."""
    estimate = evaluation.estimates[name]
    part = sum(row.contribution for row in estimate.budget if row.input == given)
    return part**2 > SHARE * estimate.u**2 if isfinite(estimate.u) else True


def _of_readings(plan: Plan) -> dict[str, tuple[Doubt, ...]]:
    """Means and fits whose readings are not independent or do not scatter, and fits that are used beyond their data."""
    plan.warnings.extend(dict.fromkeys(one.sentence for found in plan.suspect.values() for one in found))
    return {
        name: tuple(with_acceptance(Doubt("readings", one.sentence), one.accepted) for one in found)
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
        doubt = with_acceptance(Doubt("fit", sentence), stated.accepted)
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
        if one.accepted:
            text = "{names:comma}: {result} of {report} is judged for what its own report accepts: {accepted:space}"
            sentence = said(text, accepted=one.accepted, **known)
            doubts.append(Doubt("imported result", sentence, acceptance=sentence))
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
        if one.reconstructed:
            text = "{names:comma}: {result} of {report} rests on readings that were reconstructed, not measured."
            plan.warnings.append(said(text, **known))
        # One that is found nowhere may have gone into any of them.
        for name in entered or plan.identities:
            found[name] = (*found.get(name, ()), *doubts)
    return found


def _needless(campaign: Campaign, every: Sequence[Sequence[Doubt]]) -> Iterator[str]:
    """Say of acceptances of what did not fail that they do nothing; of the checks of tests `_accepted` says so."""
    used = {id(one.accepted) for group in every for one in group}
    stated = [(name, one.accepted) for entries in (campaign.ensembles, campaign.fits) for name, one in entries.items()]
    compared = [(one.title or said("comparison {number}", number=at + 1), one.accepted)
                for at, one in enumerate(campaign.comparisons)]  # fmt: skip
    for name, accepted in (*stated, *compared):
        if accepted is not None and id(accepted) not in used:
            yield said("{name}: an acceptance is stated, but nothing of it failed.", name=name)


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
    return tuple(with_acceptance(one, stated.get(one.check)) for one in own)


def _doubts(plan: Plan, test: TestItem) -> Iterator[Doubt]:
    """Failed checks that no diagnosis explains, a diagnosis without a model, and a model that held-out runs refute."""
    found = next((one for one in plan.diagnosis if one.test == test.id), None)
    verdict = found.verdict if found is not None else "nothing missing"
    if verdict in ("unexplained", "explained in the main"):
        found_so = said("The diagnosis of {test} is: {verdict}.", test=test.id, verdict=verdict)
        yield Doubt("diagnosis", found_so, covered=True)
    if found is not None and found.refuted:
        from metrology.estimation.fit import CONTRADICTED

        text = "The extended model of {test} moves {names:comma} by more than {limit:g} u from what is stated."
        sentence = said(text, test=test.id, names=found.refuted, limit=CONTRADICTED)
        # Said where nothing is required, too: no verdict is then withheld that would say it.
        plan.warnings.append(sentence)
        yield Doubt("stated inputs", sentence)
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
