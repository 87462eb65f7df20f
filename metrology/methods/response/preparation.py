"""A response test on its way into the measurement model: what is known of the rig, and what comes out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from math import hypot
from typing import TYPE_CHECKING, Any

from metrology import units
from metrology.errors import Fault, MetrologyError
from metrology.message import said
from metrology.method import Analysed, Task
from metrology.method.instruments import add_modulus
from metrology.methods.response.clock import parted, with_rate
from metrology.methods.response.known import INERT, KNOWN, amount
from metrology.methods.response.runs import measured_runs
from metrology.methods.response.schema import ResponseTest
from metrology.methods.response.units import due
from metrology.response.finding import plotted

if TYPE_CHECKING:
    import numpy as np

    from metrology.diagnosis import Diagnosis
    from metrology.estimation import Identification, Prior, Settings
    from metrology.gum.evaluation import Contribution
    from metrology.method.declared import Declared
    from metrology.method.model import HeldParameter, Model
    from metrology.methods.response.schema import Given as StatedGiven
    from metrology.response import ResponseFinding
    from metrology.response.analysis import Given, ResponseAnalysis
    from metrology.response.analysis import ResponseTest as Test
    from metrology.rig import Rig
    from metrology.rig.own import OwnEffect
    from metrology.timeseries import Trace
    from metrology.verify import VerificationFinding

    Ready = tuple[Test, Identification | None]
    """The test as the analysis takes it, and what it found."""

STANDS_FOR = {"k": "stiffness", "c": "damping"}
TENTH_OF_CRITICAL = 0.1
PLOTTED = 50
"""Numbers in a row from which on they are for plots."""
QUICK = 20_000
"""Trials that are enough for the value of another test that a simulation begins with."""


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
        model.held.extend(_held(name, analysis.identified))
    return Analysed(_explained(analysis.finding, test), (ready, analysis.identified), contribution)


def _add_motions(task: Task[ResponseTest], analysis: ResponseAnalysis) -> None:
    """Add what the runs show: the model beside those that were kept out of the fit, and the residuals of the fit."""
    model, name = task.model, task.name
    if analysis.verification is not None:
        _add_verification(task, analysis.verification)
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


def prepared(model: Model, campaign: Declared, name: str, test: ResponseTest) -> Test:
    """Return the test as the analysis takes it."""
    from metrology.diagnostics.own import check_forces
    from metrology.response import analysis

    given = {
        key: _given(model, campaign, f"{name}.{word}", stated)
        for key, word in STANDS_FOR.items()
        if (stated := getattr(test, word)) is not None
    }
    rig, runs = _rig(campaign, test, given), measured_runs(campaign, name, test)
    check_forces(campaign.own, rig, runs[0].run)
    return analysis.ResponseTest(
        name=name,
        sample=test.sample,
        rig=rig,
        runs=runs,
        free=test.free,
        priors=_with_clock(test, (*_priors(test), *_stated_priors(campaign, test))),
        given=given,
        settings=_settings(test),
        certificates=_certificates(campaign, test),
    )


def _held(name: str, found: Identification) -> Iterator[HeldParameter]:
    """What nobody stated an uncertainty of, with the derivatives of k and c by it."""
    from metrology.estimation import followed
    from metrology.method.model import HeldParameter

    rig = found.rig
    line = ("length", "weight") if rig.weight > 0 else ()
    acting = {parameter for parameter, _ in KNOWN.values() if not parameter.startswith("start.")}
    # The motion shows line and set-up in series: how stiff the set-up is, k of the line alone rests on.
    series = ("setup.compliance",) if "k" in found.joint.names else ()
    names = [one for one in (*sorted(acting), *line, *series) if one not in found.layout.names]
    for parameter, moved in followed(found, names).items():
        entry = rig.parameters[parameter]
        slopes = {f"{name}.{key}": float(moved[at]) for at, key in enumerate(found.joint.names) if key in STANDS_FOR}
        reach, value = (entry.plausible[1] - entry.plausible[0]) / 2, rig.value(parameter)
        yield HeldParameter(
            name, parameter, entry.meaning, entry.unit, value, min(reach, abs(value)) if value else reach, slopes
        )


def _given(model: Model, campaign: Declared, name: str, stated: StatedGiven) -> Given:
    from metrology import gum
    from metrology.response.analysis import Given

    if stated.value is not None:
        known = stated.value.input(name)
        return Given(name, known.value, known.u, stated.value.source or said("stated"), known)
    quantity = f"{stated.test}.{'k' if name.endswith('.stiffness') else 'c'}"
    if quantity not in model.identities:
        message = Fault(
            campaign.at("tests", name.partition(".")[0]), f"'{stated.test}', which has no result", "a test that has"
        )
        raise MetrologyError(message)
    at = next(index for index, measurand in enumerate(model.measurands) if measurand.name == quantity)
    evaluation = gum.evaluate(model.measurands[: at + 1], model.knowledge, seed=campaign.seed, max_trials=QUICK)
    estimate = evaluation.estimates[quantity]
    return Given(quantity, *estimate.reported, said("test {test}", test=quantity.rpartition(".")[0]))


def _rig(campaign: Declared, test: ResponseTest, given: Mapping[str, Given]) -> Rig:
    from metrology.rig import Rig

    stated, sample = test.rig, campaign.samples[test.sample]
    start = test.identification.start if test.identification else None
    k = given["k"].value if "k" in given else start.k.si if start and start.k else 0.0
    usual = 2 * TENTH_OF_CRITICAL * (k * stated.inert.si) ** 0.5
    c = given["c"].value if "c" in given else start.c.si if start and start.c else usual
    weighs = stated.line_weight != "none"
    return Rig(
        m=stated.inert.si,
        k=k,
        c=c,
        taut=stated.taut.si,
        length=sample.length.si if weighs and sample.length else 0.0,
        weight=sample.linear_density.si * stated.gravity.si if weighs and sample.linear_density else 0.0,
        line_weight=stated.line_weight,
        cap=stated.cap.si,
        attachment=stated.attachment,
        gravity=stated.gravity.si,
        effects={name: value.si for name, value in test.model.items()},
        own=tuple(effect.own for effect in campaign.own if effect.force),
        coordinate=stated.coordinate,
    )


def _priors(test: ResponseTest) -> tuple[Prior, ...]:
    """What is known within an uncertainty: inputs of the rig, and effects that the model carries."""
    from metrology.estimation import Prior

    sizes_of = {name: value.u for name, value in test.model.items() if value.u > 0}
    found = [Prior(name, common=u, source=said("model of the campaign")) for name, u in sizes_of.items()]
    for key, (parameter, unit) in KNOWN.items():
        spread = getattr(test.known, key)
        if spread is None:
            continue
        whole = test.rig.inert.si if key in INERT else None
        sizes = {part: amount(text, due(unit, test), whole) / (whole or 1.0) for part, text in spread.amounts().items()}
        if parameter in sizes_of:
            # Where the model says more of an input than the laboratory knew before, only its scatter is left to say.
            found = [one for one in found if one.name != parameter]
            sizes["common"] = sizes_of[parameter]
        found.append(Prior(parameter, sizes.get("common", 0.0), sizes.get("per_run", 0.0), source=spread.source))
    return tuple(found)


def _rate(test: ResponseTest) -> float:
    """Relative standard uncertainty of the rate of the clock; 0 where none is stated."""
    stated = test.known.clock_rate
    return amount(stated.common, "1") if stated and stated.common else 0.0


def _with_clock(test: ResponseTest, priors: tuple[Prior, ...]) -> tuple[Prior, ...]:
    return with_rate(priors, _rate(test)) if _rate(test) else priors


def _in_true_time(name: str, test: ResponseTest, found: Contribution) -> Contribution:
    """Return what a fit contributes, with the rate of the clock as an input where it is uncertain."""
    stated = test.known.clock_rate
    return parted(found, name, _rate(test), stated.source) if stated and found.measurands else found


def _stated_priors(campaign: Declared, test: ResponseTest) -> tuple[Prior, ...]:
    """What the rig and the sample state with an uncertainty of their own, where `known` does not say it."""
    from metrology.estimation import Prior

    rig, sample, known = test.rig, campaign.samples[test.sample], test.known
    found = []
    if rig.inert.u > 0 and not (known.mass or known.inertia):
        found.append(Prior("mass.factor", rig.inert.u / rig.inert.si, source=said("stated with the rig")))
    if rig.taut.u > 0 and not known.free_length:
        found.append(Prior("free_length.shift", rig.taut.u, source=said("stated with the rig")))
    if rig.line_weight == "none" or not (sample.length and sample.linear_density):
        return tuple(found)
    density = sample.linear_density
    relative = hypot(density.u / density.si, rig.gravity.u / rig.gravity.si)
    if sample.length.u > 0:
        found.append(Prior("length", sample.length.u, source=said("length of the sample")))
    if relative > 0:
        source = said("linear density of the sample and gravity")
        found.append(Prior("weight", relative * density.si * rig.gravity.si, source=source))
    return tuple(found)


def _settings(test: ResponseTest) -> Settings:
    from metrology.estimation import Settings

    stated = test.identification.bounds if test.identification else {}
    return Settings(bounds={name: (low.si, high.si) for name, (low, high) in stated.items()})


def _certificates(campaign: Declared, test: ResponseTest) -> dict[str, float]:
    """Standard uncertainty of a reading by the certificates, by channel, where they say it in the channel's unit."""
    found = {}
    roles = {"x": ("position", "m"), "v": ("velocity", "m/s"), "T": ("tension", "N")}
    for channel, (role, unit) in roles.items():
        instrument = campaign.instruments.get(getattr(test.instruments, role) or "")
        certificate = instrument.certificate if instrument else None
        stated = certificate.expanded_uncertainty if certificate else None
        if certificate is not None and stated is not None and stated.si_unit == units.si_unit(due(unit, test)):
            found[channel] = certificate.u
    return found
