"""A response test evaluated, diagnosed and corrected: what its runs put into the measurement model."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError
from metrology.message import said
from metrology.method import Analysed, Task
from metrology.method.instruments import add_modulus
from metrology.methods.response.clock import MASS, parted, taken_as_exact
from metrology.methods.response.known import KNOWN
from metrology.methods.response.preparation import STANDS_FOR, clock_rate, prepared
from metrology.methods.response.schema import ResponseTest
from metrology.response.finding import plotted

if TYPE_CHECKING:
    import numpy as np

    from metrology.diagnosis import Diagnosis
    from metrology.estimation import Identification
    from metrology.gum.evaluation import Contribution
    from metrology.method.declared import Declared
    from metrology.method.model import HeldParameter
    from metrology.response import ResponseFinding
    from metrology.response.analysis import ResponseAnalysis
    from metrology.response.test import ResponseTest as Test
    from metrology.rig.own import OwnEffect
    from metrology.timeseries import Trace
    from metrology.verify import VerificationFinding

    Ready = tuple[Test, Identification | None]
    """The test as the analysis takes it, and what it found."""

PLOTTED = 50
"""Numbers in a row from which on they are for plots."""


def analyse(task: Task[ResponseTest]) -> Analysed[Ready]:
    """Put what was sought into the model, with the verdict on the model of the rig.

    Raises
    ------
    MetrologyError
        For runs that cannot be what they claim, each fault with its place in the campaign file.
    """
    import numpy as np

    from metrology.response.analysis import analyse

    name, test, campaign, model = task.name, task.test, task.campaign, task.model
    rng = np.random.default_rng([campaign.seed, *name.encode()])
    ready = prepared(model, campaign, name, test)
    try:
        analysis = analyse(ready, rng, progress=task.progress, judged=model.judged, once=model.once)
    except MetrologyError as error:
        raise MetrologyError(*(_placed(campaign, name, test, fault) for fault in error.faults)) from None
    contribution = _in_true_time(name, test, analysis.contribution)
    model.add(contribution)
    for measurand in contribution.measurands:
        task.add(measurand, headline=measurand.name.removeprefix(f"{name}.") in (*test.free, "zeta", "omega_n"))
    if test.rig.coordinate == "position" and "k" in test.free:
        add_modulus(task)
    failures = analysis.finding.failures
    model.failures.extend(said("{name}: {sentence:quoted}", name=name, sentence=sentence) for sentence in failures)
    _add_motions(task, analysis)
    if analysis.identified is not None and analysis.contribution.measurands:
        model.held.extend(_held(name, test, analysis.identified))
    return Analysed(_explained(analysis.finding, test), (ready, analysis.identified), contribution)


def _add_motions(task: Task[ResponseTest], analysis: ResponseAnalysis) -> None:
    """Add what the runs show: the model beside those that were kept out of the fit, and the residuals of the fit."""
    model, name = task.model, task.name
    if analysis.verification is not None:
        _add_verification(task, analysis.verification)
    elif analysis.identified is not None:
        text = "No run of {test} was kept out of the fit: its model is not validated (purpose: verification)."
        model.warnings.append(said(text, test=name))
    if analysis.identified is not None:
        from metrology.response.presentation import residuals

        model.traces.update({f"response/{name}/{key}": trace for key, trace in residuals(analysis.identified).items()})


def _add_verification(task: Task[ResponseTest], judged: VerificationFinding) -> None:
    from metrology import verify

    task.model.verification.append(_plain(verify.thinned(judged)))
    task.model.traces.update(_traces(task.name, judged))


def diagnose(task: Task[ResponseTest], ready: Ready, rng: np.random.Generator) -> Diagnosis:
    """What the model of the rig lacks, by all runs, beginning at what was identified."""
    without, own = task.campaign.diagnosis.without, task.campaign.own
    return task.model.once(_diagnosed, ready, rng, task.name, task.test.sample, without, own, progress=task.progress)


def _diagnosed(
    ready: Ready, rng: np.random.Generator, name: str, sample: str, without: tuple[str, ...],
    own: tuple[OwnEffect, ...], *, progress: Callable[[str], None],
) -> Diagnosis:  # fmt: skip
    from metrology.diagnostics import Settings, response
    from metrology.response.analysis import given_priors

    test, found = ready
    priors = (*test.priors, *given_priors(test))
    start: dict[str, float] = {}
    if found is not None and found.status == "ok":
        # Runs that were not fitted begin at what is stated: near enough that the optimum need not be searched again.
        start = {f"{prior.name}@{run.name}": 0.0 for prior in priors if prior.per_run > 0 for run in test.runs}
        start |= {entry.name: entry.value for entry in found.parameters}
    settings = Settings(sample, name, start, without, own=own, progress=progress)
    return response(test.rig, test.runs, rng=rng, free=test.free, priors=priors, settings=settings)


def corrected(task: Task[ResponseTest], ready: Ready, stated: Contribution, found: Diagnosis) -> Contribution:
    """k, c and the effects by the joint fit of the model that the data support; given values stay as given."""
    import numpy as np

    from metrology.estimation import Joint, Source, knowns
    from metrology.gum.inputs import KNOWN
    from metrology.response.analysis import given_priors, origins

    test, _ = ready
    supported = found.supported
    if not test.free or supported is None:
        return stated
    _verify_extended(task, test, found)
    sources = tuple(
        Source(one.name, one.kind, np.array(one.columns), one.mean, one.u, one.unit, one.dof or KNOWN)
        for one in supported.sources
    )
    joint = Joint(supported.names, supported.units, np.array(supported.values), sources)
    made = knowns(joint, test.rig, task.name, origins=origins((*test.priors, *given_priors(test))))
    return _in_true_time(task.name, task.test, made)


def _verify_extended(task: Task[ResponseTest], test: Test, found: Diagnosis) -> None:
    """Add the extended model, fitted to the runs for identification, beside those that were kept out of the fit."""
    import numpy as np

    from metrology.response.analysis import verify_extended

    # Effects that merely fit are no model that anybody states: there is nothing to verify.
    if not found.extended_model or found.verdict == "unexplained":
        return
    rng = np.random.default_rng([task.campaign.seed, *task.name.encode()])
    judged = task.model.once(verify_extended, test, found, rng, progress=task.progress)
    if judged is not None:
        _add_verification(task, judged)


def _traces(name: str, verification: VerificationFinding) -> dict[str, Trace]:
    """Every sample of the held-out runs, for the screen."""
    from metrology.verify import trace

    return {
        f"{'verification' if verification.basis == 'stated' else 'extended'}/{name}/{run.run}/{series.channel}": trace(
            series
        )
        for run in verification.runs
        for series in run.series
    }


def _explained(finding: ResponseFinding, test: ResponseTest) -> ResponseFinding:
    """Say of a rig that turns what its letters stand for, and why there is no E."""
    if test.rig.coordinate == "position":
        return finding
    notes = [
        said(
            "the rig turns: x and v are angle and angular velocity, F and T torques, and m is the moment of inertia, "
            "in the equation of every effect as well"
        )
    ]
    if "k" in test.free:
        text = "no modulus follows from k: E = k·L/A holds for a line that is pulled, not for one that is twisted"
        notes.append(said(text))
    return replace(finding, notes=(*finding.notes, *notes))


def _plain(value: Any) -> Any:
    """Return the value as JSON gives it back, lists in place of tuples; long ones, for plots, with seven digits."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if is_dataclass(value):
        return {entry.name: _plain(getattr(value, entry.name)) for entry in fields(value)}
    if isinstance(value, list | tuple):
        return list(plotted(value)) if len(value) > PLOTTED else [_plain(entry) for entry in value]
    return value


def _placed(campaign: Declared, name: str, test: ResponseTest, fault: Fault) -> Fault:
    """Return a fault of a run with the place where the campaign file declares that run."""
    run, _, rest = fault.where.partition(".")
    if run not in test.runs:
        return Fault(f"{campaign.at('tests', name)}: {fault.where}", fault.got, fault.expected, fault.fix)
    where = f"{campaign.at('tests', name, 'runs', run)} {rest}".rstrip()
    return Fault(where, fault.got, fault.expected, fault.fix)


def _held(name: str, test: ResponseTest, found: Identification) -> Iterator[HeldParameter]:
    """What nobody stated an uncertainty of, with the derivatives of k and c by it."""
    from metrology.estimation import followed
    from metrology.method.model import HeldParameter

    rig = found.rig
    line = ("length", "weight") if rig.weight > 0 else ()
    acting = {parameter for parameter, _ in KNOWN.values() if not parameter.startswith("start.")}
    # The motion shows line and set-up in series: how stiff the set-up is, k of the line alone rests on.
    series = ("setup.compliance",) if "k" in found.joint.names else ()
    names = [one for one in (*sorted(acting), *line, *series) if one not in found.layout.names]
    exact = followed(found, names)
    for parameter, moved in exact.items():
        entry = rig.parameters[parameter]
        slopes = {f"{name}.{key}": float(moved[at]) for at, key in enumerate(found.joint.names) if key in STANDS_FOR}
        reach, value = (entry.plausible[1] - entry.plausible[0]) / 2, rig.value(parameter)
        yield HeldParameter(
            name, parameter, entry.meaning, entry.unit, value, min(reach, abs(value)) if value else reach, slopes
        )
    by_mass = {one.name: one.columns[:, 0] / one.u for one in found.joint.sources if one.kind == "common"} | exact
    if test.known.clock_rate is None and MASS in by_mass:
        yield taken_as_exact(name, found, by_mass[MASS])


def _in_true_time(name: str, test: ResponseTest, found: Contribution) -> Contribution:
    """Return what a fit contributes, with the rate of the clock as an input where it is uncertain."""
    stated = test.known.clock_rate
    return parted(found, name, clock_rate(test), stated.source) if stated and found.measurands else found
