"""From a campaign to its findings: tests evaluated, uncertainties propagated, requirements judged."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import TYPE_CHECKING

from metrology import __version__
from metrology.chain import (
    across,
    attained,
    audit,
    comparisons,
    conformity,
    derived,
    diagnosis,
    fits,
    items,
    knowledge,
    methods,
)
from metrology.chain.display_units import in_fitting_units
from metrology.chain.doubt import Doubt
from metrology.chain.exact import sentences, taken_as_exact
from metrology.chain.failed_checks import doubts
from metrology.chain.plan import Plan
from metrology.chain.standing import Standing, shifted, standing
from metrology.chain.warnings import empty, of_results, undetermined, without_value
from metrology.errors import MetrologyError
from metrology.findings import SCHEMA, Correlation, Findings, Moments, Notice, Result
from metrology.language.catalogue import stored
from metrology.language.notices import WARNS, brief
from metrology.method.model import call
from metrology.methods import METHODS
from metrology.references import cite
from metrology.units import vocabularies

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.consensus import Consensus
    from metrology.diagnosis import Diagnosis
    from metrology.findings import Comparison
    from metrology.gum.attained import Attained
    from metrology.gum.evaluation import Evaluation
    from metrology.method.model import Memo
    from metrology.timeseries import Trace

FAINT = 1e-3
"""Part of a combined standard uncertainty below which rounding leaves no digits of how a contribution is correlated."""
SOFTWARE = ("numpy", "scipy", "uncertainties", "pydantic", "matplotlib", "weasyprint")


def evaluate(
    campaign: Campaign, *, progress: Callable[[str], None] = lambda _text: None, coverage: bool = True
) -> Findings:
    """Return everything that a campaign's readings say.

    Parameters
    ----------
    campaign : Campaign
        As `metrology.campaign.load` returns it.
    progress : callable
        Told what is being done, in a few words.
    coverage : bool
        Whether tests are repeated by simulation, to see how often the intervals hold what they should.

    Raises
    ------
    MetrologyError
        For readings that a method cannot use, and for a campaign with code of its own that was not run.
    """
    return traced(campaign, progress=progress, coverage=coverage)[0]


def traced(
    campaign: Campaign,
    *,
    progress: Callable[[str], None] = lambda _text: None,
    coverage: bool = True,
    once: Memo = call,
) -> tuple[Findings, Mapping[str, Trace]]:
    """Return what `evaluate` returns, and every sample behind its plots over time, which `results.json` thins.

    Traces by the key of their plot and what they are of: ``decay/TEST/RECORD``, ``response/TEST/RUN/CHANNEL``,
    ``verification/TEST/RUN/CHANNEL``; `report.make` takes them for the plots that can be zoomed. `once` makes the calls
    that take long and depend on nothing but their inputs. Other parameters and errors as for `evaluate`.
    """
    from metrology import gum
    from metrology.campaign.own import check_allowed

    check_allowed(campaign)
    progress("tests")
    plan = build(campaign, progress=progress, once=once)
    progress("uncertainties")
    try:
        evaluation = gum.evaluate(
            plan.measurands,
            plan.knowledge,
            probability=campaign.coverage_probability,
            seed=campaign.seed,
            digits=campaign.monte_carlo.digits,
            max_trials=campaign.monte_carlo.max_trials,
            risk=conformity.least_risk(campaign),
        )
    except MetrologyError as error:
        # Correlations that the distributions of the campaign file cannot have.
        here = {"correlations": campaign.at("correlations")}
        raise MetrologyError(*(replace(one, where=here.get(one.where, one.where)) for one in error.faults)) from None
    progress("verdicts")
    return _findings(campaign, plan, evaluation, coverage=coverage), plan.traces


def by_law(
    campaign: Campaign, *, progress: Callable[[str], None] = lambda _text: None, once: Memo = call
) -> tuple[Findings, Mapping[str, Trace]]:
    """Return what can be said at once: page 1 by the GUM uncertainty framework alone, and its traces.

    There is no Monte Carlo, no attained coverage, no verification and no diagnosis, so that a verdict may change when
    `traced` has all of them. Parameters and errors as for `traced`.
    """
    from metrology import gum
    from metrology.campaign.own import check_allowed

    check_allowed(campaign)
    off = campaign.diagnosis.model_copy(update={"off": True})
    plan = build(campaign.model_copy(update={"diagnosis": off}), progress=progress, once=once, judged=False)
    evaluation = gum.evaluate_law(plan.measurands, plan.knowledge, probability=campaign.coverage_probability)
    plan.warnings[:] = [one for one in plan.warnings if one != diagnosis.OFF]
    findings = _findings(campaign, plan, evaluation, coverage=False)
    return replace(findings, campaign=replace(findings.campaign, parts=("certificate",))), plan.traces


def build(
    campaign: Campaign,
    *,
    progress: Callable[[str], None] = lambda _text: None,
    once: Memo = call,
    judged: bool = True,
) -> Plan:
    """Return the measurement model of the whole campaign; `judged`: with the verification of its models."""
    plan = Plan(once=once, judged=judged)
    knowledge.add_stated(plan, campaign)
    knowledge.add_ensembles(plan, campaign)
    fits.add_fits(plan, campaign)
    derived.add_areas(plan, campaign)
    methods.add_tests(plan, campaign, progress)
    derived.add_derived(plan, campaign)
    knowledge.join_imported(plan, campaign)
    conformity.add_judged_inputs(plan, campaign)
    return plan


def _findings(campaign: Campaign, plan: Plan, evaluation: Evaluation, *, coverage: bool) -> Findings:
    plan.identities.update(in_fitting_units(plan, evaluation))
    instruments = items.instrument_states(campaign)
    stands = standing(plan, evaluation, probability=campaign.coverage_probability, seed=campaign.seed)
    held = attained.coverage(campaign, plan, evaluation, stands) if coverage else {}
    results = _results(plan, evaluation, stands, held)
    plan.failures.extend(without_value(evaluation))
    compared = comparisons.comparisons(campaign, plan, evaluation)
    against = doubts(campaign, plan, stands, evaluation, compared)
    results = tuple(_with_doubts(one, against.get(one.name, ())) for one in results)
    verdicts, withheld = conformity.conformity(campaign, evaluation, plan.failures, against)
    # What is accepted is said with its acceptance, and not once more without it.
    accepted = {one.sentence for own in against.values() for one in own if one.acceptance}
    plan.warnings[:] = [one for one in plan.warnings if one not in accepted]
    plan.warnings += [sentence for one in results for sentence in one.accepted]
    judged = {verdict.requirement for verdict in verdicts}
    exact = taken_as_exact(plan, evaluation)
    agreed, parted = across.consensus(campaign, plan, evaluation, against)
    found = Findings(
        schema=SCHEMA,
        campaign=items.campaign_item(campaign, plan.diagnosis),
        software=software(),
        inputs=items.input_files(campaign),
        seed=campaign.seed,
        samples=items.sample_items(campaign),
        instruments=instruments,
        tests=tuple(plan.tests),
        fits=tuple(plan.fits),
        results=results,
        correlations=_correlations(evaluation),
        conformity=verdicts,
        comparisons=compared,
        consensus=agreed,
        disagreements=parted,
        audit=audit.audit(campaign, plan, evaluation),
        warnings=(
            *campaign.notices,
            *plan.warnings,
            *of_results(campaign, results),
            *undetermined(results, against),
            *conformity.priors(campaign, evaluation),
            *empty(results, plan.failures),
            *sentences(exact, plan),
        ),
        failures=tuple(plan.failures),
        references=cite(_reference_keys(campaign) | _of_consensus(agreed)),
        verification=tuple(plan.verification),
        diagnosis=shifted(discrepancies(campaign, plan, evaluation, compared), results),
        withheld=withheld,
        exact=exact,
        input_correlations=_of_inputs(evaluation, results),
        unjudged=tuple(entry.id for entry in campaign.requirements if entry.id not in judged),
    )
    notices = tuple(Notice(*one) for one in brief(found))
    warnings = (*found.warnings, *(one.sentence for one in notices if one.kind in WARNS))
    return replace(found, notices=notices, messages=stored(found), warnings=tuple(dict.fromkeys(warnings)))


def _with_doubts(result: Result, own: Sequence[Doubt]) -> Result:
    """A result with what forbids that a requirement passes on it, and what the laboratory accepts of that."""
    barring = dict.fromkeys(one.sentence for one in own if one.bars("pass"))
    accepted = dict.fromkeys(one.acceptance for one in own if one.acceptance)
    return replace(result, doubts=tuple(barring), accepted=tuple(accepted))


def _of_inputs(evaluation: Evaluation, results: Sequence[Result]) -> tuple[Correlation, ...]:
    """Correlations of the inputs that have a part in a result; of others, rounding leaves no digit."""
    seen = {row.input for one in results for row in one.budget if abs(row.contribution) > FAINT * one.framework.u}
    return tuple(Correlation(*pair) for pair in evaluation.of_inputs if {*pair[:2]} <= seen)


def discrepancies(
    campaign: Campaign, plan: Plan, evaluation: Evaluation, compared: tuple[Comparison, ...]
) -> tuple[Diagnosis, ...]:
    """Return the diagnoses, with what could part an elongation from its reference."""
    if not plan.diagnosis:
        return ()
    from metrology.chain.discrepancy import explained

    return explained(campaign, plan, evaluation, compared)


def software() -> dict[str, str]:
    """Return the versions that made the numbers."""
    return {"metrology": __version__, "python": platform.python_version()} | {name: version(name) for name in SOFTWARE}


def _results(plan: Plan, evaluation: Evaluation, stands: Standing, held: Mapping[str, Attained]) -> tuple[Result, ...]:
    results = []
    for name, estimate in evaluation.estimates.items():
        identity = plan.identities[name]
        value, u = estimate.reported
        results.append(
            Result(
                name=name,
                sample=identity.sample,
                test=identity.test,
                method=identity.method,
                quantity=identity.quantity,
                value=value,
                u=u,
                framework=Moments(estimate.value, estimate.u),
                unit=estimate.unit,
                dof=estimate.dof,
                dof_note=estimate.dof_note,
                display_unit=identity.display_unit or estimate.unit,
                coverage=estimate.coverage,
                monte_carlo=estimate.monte_carlo,
                budget=estimate.budget,
                advice=estimate.advice,
                equation=estimate.equation,
                headline=identity.headline,
                unit_dsi=vocabularies.dsi(estimate.unit),
                unit_qudt=vocabularies.qudt(estimate.unit),
                stated=stands.stated.get(name),
                attained=held.get(name),
            )
        )
    return tuple(results)


def _correlations(evaluation: Evaluation) -> tuple[Correlation, ...]:
    """Return every correlation that is not zero, each pair once."""
    names, matrix = evaluation.names, evaluation.correlation
    return tuple(
        Correlation(names[i], names[j], coefficient)
        for i in range(len(names))
        for j in range(i)
        if (coefficient := matrix[i][j]) is not None and abs(coefficient) > 1e-12
    )


def _of_consensus(agreed: Sequence[Consensus]) -> set[str]:
    keys = {"iso13528", "cox"} if agreed else set()
    return keys | ({"paule", "knapp", "mackay"} if any(one.consistent is False for one in agreed) else set())


def _reference_keys(campaign: Campaign) -> set[str]:
    keys = {"jcgm100", "jcgm101", "jcgm102", "vim", "welch"}
    keys |= {key for test in campaign.tests.values() for key in METHODS[test.method].references}
    keys |= {"iso28037"} if campaign.fits else set()
    keys |= {"jcgm106", "ilac-g8"} if campaign.requirements else set()
    references = any(sample.references for sample in campaign.samples.values())
    return keys | ({"iso13528"} if campaign.comparisons or references else set())
