"""From measured runs to k, c, ζ, ω_n, and a verdict on the model."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology import estimation, raw, verify
from metrology.check import Check
from metrology.errors import MetrologyError
from metrology.estimation import Estimated, Identification, MeasuredRun, Prior, step
from metrology.estimation.covariance import Covariance
from metrology.estimation.fit import CONTRADICTED
from metrology.estimation.inspection import COLUMNS, without_saturation
from metrology.estimation.inspection import faults as implausible
from metrology.estimation.priors import WIDER, input_of
from metrology.estimation.problem import Unknown
from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.functions import sqrt
from metrology.gum.inputs import Component, Input
from metrology.message import said
from metrology.response.finding import GivenValue, PaperResult, ResponseFinding
from metrology.response.presentation import equations, fitted_runs, inputs_after, model_text, sought
from metrology.response.test import ResponseTest
from metrology.rig import Rig, engines
from metrology.timeseries import Channel

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis

Progress = Callable[[str], None]


@dataclass(frozen=True)
class ResponseAnalysis:
    """What a response test puts into the measurement model of a campaign, what it shows, and the model's verdict."""

    contribution: Contribution
    finding: ResponseFinding
    verification: verify.VerificationFinding | None
    identified: Identification | None = None


def _called(function: Callable[..., Any], /, *inputs: Any, **named: Any) -> Any:
    return function(*inputs, **named)


def analyse(
    test: ResponseTest, rng: np.random.Generator, *, progress: Progress = lambda _text: None, judged: bool = True,
    once: Callable[..., Any] = _called,
) -> ResponseAnalysis:  # fmt: skip
    """Identify, where something is sought, and verify on the runs that the fit has not seen.

    Parameters
    ----------
    test : ResponseTest
        What was measured, and what is known.
    rng : numpy.random.Generator
        For the bands of the verification.
    progress : callable
        Told what is being done, in a few words.
    judged : bool
        Whether the model is verified, and set beside the method of the paper, which takes most of the time.
    once : callable
        Makes the calls that take long, ``once(function, *inputs, **named)``.

    Raises
    ------
    MetrologyError
        For runs that cannot be what they claim.
    """
    wrong = implausible(test.rig, test.runs)
    if wrong:
        raise MetrologyError(*wrong)
    # Both, before the first motion: which of them an earlier campaign had loaded would else change the last digits.
    for base in (True, False):
        engines.compiled(base)
    readable, notes = _readable(test)
    found = (_fitted if test.free else _simulated)(readable, rng, progress, once, judged=judged)
    sound = raw.check({name: channel for run in readable.runs for name, channel in _channels(run)})
    checks = (sound, *_contradicted(found.finding))
    return replace(found, finding=replace(found.finding, notes=(*notes, *found.finding.notes), checks=checks))


def _contradicted(finding: ResponseFinding) -> Iterator[Check]:
    """The check that fails where the runs move what is stated of an input too far; an effect of the model may do so."""
    apart = {input_of(one.name, one.run): abs(one.distance) for one in finding.inputs if one.prior_u}
    if names := tuple(name for name, distance in apart.items() if distance > CONTRADICTED):
        text = "The fitted and the stated {names:comma} disagree by more than {limit:g} u."
        yield Check("stated inputs", max(apart.values()), None, False, said(text, names=names, limit=CONTRADICTED))


def _channels(run: MeasuredRun) -> Iterator[tuple[str, Channel]]:
    """Every channel of a run with its readings in use, by a name for the reader."""
    for channel in run.channels:
        used = run.used(channel)
        if used.sum() > 1:
            name = f"{run.name} {COLUMNS[run.coordinate][channel]}"
            yield name, Channel(name, run.stamps(channel)[used], run.readings(channel)[used], run.unit(channel))


def _readable(test: ResponseTest) -> tuple[ResponseTest, tuple[str, ...]]:
    """Return the test without what a saturated cell or a stepping position gave, and what was left out."""
    cleaned = [without_saturation(run) for run in test.runs]
    priors = (*test.priors, *given_priors(test))
    runs, steps = step.without(test.rig, [run for run, _ in cleaned], test.free, priors)
    text = (
        "{run}: x steps by {size:.3g} m{unit} at {time:.4g} s, and v shows no such motion; x is left out from then on"
    )
    unit = runs[0].unit("x") if runs else ""
    stepped = (said(text, run=name, size=1e3 * one.size, unit=unit, time=one.time) for name, one in steps.items())
    return replace(test, runs=runs), (*(note for _, notes in cleaned for note in notes), *stepped)


def _fitted(
    test: ResponseTest, rng: np.random.Generator, progress: Progress, once: Callable[..., Any], *, judged: bool
) -> ResponseAnalysis:
    found = once(_fit, test, progress=progress)
    found = _or_failed(found, test.free)
    if found.status != "ok":
        return ResponseAnalysis(Contribution(), _finding(test, found, None, (found.sentence,)), None)
    paper = once(_paper, test, found, progress=progress) if judged else None
    shown, failures = once(_verified, found, test, rng, progress=progress) if judged else (None, ())
    known = estimation.knowns(found.joint, found.rig, test.name, origins=origins(found.priors))
    return ResponseAnalysis(known, _finding(test, found, paper, failures), shown, found)


def _fit(test: ResponseTest, *, progress: Progress) -> Identification:
    progress(f"{test.name}: fit to {len(test.of('identification'))} runs")
    return estimation.fit(
        test.rig, test.runs, free=test.free, priors=(*test.priors, *given_priors(test)), settings=test.settings
    )


def origins(priors: Sequence[Prior]) -> dict[str, str]:
    """Where each known comes from, by its name."""
    return {prior.name: prior.source for prior in priors}


def _or_failed(found: Identification, free: tuple[str, ...]) -> Identification:
    """Let a fit fail where no reading moves with a parameter that was sought: its value is where the search ended."""
    blind = [
        entry
        for entry in found.parameters
        # One with a one-sided bound is not determined either, but its bound is an answer.
        if entry.name in free and not entry.determined and entry.interval == "parabola"
    ]
    if not blind:
        return found
    sentence = said(
        "{sentences} (the search ended at {where:figures}); its start value may be far off, or the runs may lack what "
        "shows it: give another start value, or do not seek it",
        sentences=tuple(entry.sentence for entry in blind),
        where=", ".join(f"{entry.name} = {entry.value:.3g} {entry.unit}" for entry in blind),
    )
    return replace(found, status="failed", sentence=sentence)


def given_priors(test: ResponseTest) -> tuple[Prior, ...]:
    """What is known of the values that are given."""
    return tuple(
        Prior(name, common=given.u, mean=given.value, source=given.source)
        for name, given in test.given.items()
        if given.u > 0
    )


def _simulated(
    test: ResponseTest, rng: np.random.Generator, progress: Progress, once: Callable[..., Any], *, judged: bool
) -> ResponseAnalysis:
    """Judge the model with values from elsewhere, as the paper does for PEEK and Al-1100: every run judges."""
    judging = replace(test, runs=tuple(replace(run, purpose="verification") for run in test.runs))
    found = stated(test.rig, (*test.priors, *given_priors(test)))
    shown, failures = once(_verified, found, judging, rng, progress=progress) if judged else (None, ())
    finding = replace(_finding(test, found, None, failures), status="given")
    if test.of("identification"):
        note = said("nothing is sought, so the runs for identification judge the model as the others do")
        finding = replace(finding, notes=(*finding.notes, note))
    return ResponseAnalysis(_from_given(test), finding, shown, found)


def stated(rig: Rig, priors: Sequence[Prior]) -> Identification:
    """What is known without any run: every parameter at what is stated, with its uncertainty."""
    layout = estimation.lay_out(rig, (), (), priors)
    known = tuple(_as_stated(entry) for entry in layout.unknowns)
    u = np.array([entry.u for entry in known])
    spread = Covariance(np.diag(u**2), np.zeros((len(u), len(u))), dict(enumerate(np.diag(u))), ())
    return Identification(
        status="ok", sentence=said("nothing was sought: the values are given"), rig=rig, runs=(), layout=layout,
        priors=tuple(priors), theta=np.array([entry.value for entry in known]), covariance=spread, parameters=known,
        chi_squared=math.nan, dof=0, residuals=(), log_evidence=-math.inf, steps=0, notes=(),
    )  # fmt: skip


def _as_stated(entry: Unknown) -> Estimated:
    mean, u = float(entry.start if entry.mean is None else entry.mean), float(entry.u or 0.0)
    return Estimated(entry.name, entry.unit, mean, u, mean, u, None, None, "parabola", determined=True)


def _from_given(test: ResponseTest) -> Contribution:
    """ω_n and ζ of the module on the line, from the given values."""
    if not {"k", "c"} <= test.given.keys():
        return Contribution()
    of_mass = next((prior for prior in test.priors if prior.name == "mass.factor"), None)
    parts = (Component(said("stated"), Normal(of_mass.common * test.rig.m), source=of_mass.source),) if of_mass else ()
    inert = test.rig.parameters["m"]
    mass = Input(f"{test.name}.m", test.rig.m, parts, inert.unit, inert.meaning)
    k, c, m = test.given["k"].quantity, test.given["c"].quantity, mass.name
    measurands = (
        Measurand(f"{test.name}.omega_n", lambda known: sqrt(known[k] / known[m]), "rad/s", "ω_n = √(k/m)"),
        Measurand(
            f"{test.name}.zeta", lambda known: known[c] / (2 * sqrt(known[k] * known[m])), "1", "ζ = c/(2·√(k·m))"
        ),
    )
    known = (given.known for given in test.given.values() if given.known is not None)
    return Contribution((mass, *known), measurands=measurands)


def _verified(
    found: Identification, test: ResponseTest, rng: np.random.Generator, *, progress: Progress
) -> tuple[verify.VerificationFinding | None, tuple[str, ...]]:
    judging = test.of("verification")
    if not judging:
        return None, ()
    progress(f"{test.name}: verification by {len(judging)} runs")
    names = (test.sample, test.name)
    judged = verify.compare(found, judging, rng, names=names, certificates=test.certificates)
    lost = [run for run in judged.runs if not run.series]
    return judged, tuple(said("run {run}: {sentence:quoted}", run=run.run, sentence=run.sentence) for run in lost)


def verify_extended(
    test: ResponseTest, diagnosed: Diagnosis, rng: np.random.Generator, *, progress: Progress
) -> verify.VerificationFinding | None:
    """Verification of the model that a diagnosis extends, fitted to the runs for identification as the stated one was.

    None where there are no runs of either purpose, or where those for identification do not determine the effects.
    """
    supported, own = diagnosed.supported, diagnosed.extended_model
    test, _ = _readable(test)
    if supported is None or not (test.of("identification") and test.of("verification")):
        return None
    progress(f"{test.name}: fit of the extended model")
    common = dict(zip(supported.names, supported.values, strict=True))
    known = {prior.name for prior in (*test.priors, *given_priors(test)) if prior.common > 0}
    priors = tuple(
        replace(prior, common=WIDER * prior.common) if prior.name in own else prior
        for prior in (*test.priors, *given_priors(test))
    )
    sought = [name for name in own if name in common and name not in known and name not in test.free]
    rig = test.rig.with_values({**own, **{name: common[name] for name in test.free if name in common}})
    # Of a size that these runs alone do not determine, its range is what is known.
    bounds = {name: (-math.inf if low is None else low, math.inf if high is None else high)
              for name, (low, high) in diagnosed.ranges.items() if name in sought}  # fmt: skip
    settings = replace(test.settings, profile=False, near=True, bounds={**test.settings.bounds, **bounds})
    found = estimation.fit(rig, test.runs, free=(*test.free, *sought), priors=priors, settings=settings)
    if found.status != "ok":
        return None
    progress(f"{test.name}: verification of the extended model")
    names = (test.sample, test.name)
    judged = verify.compare(found, test.of("verification"), rng, names=names, certificates=test.certificates)
    return replace(judged, basis="extended")


def _paper(test: ResponseTest, weighted: Identification, *, progress: Progress) -> PaperResult | None:
    if not {"k", "c"} <= set(test.free):
        return None
    progress(f"{test.name}: the method of the paper")
    runs = test.of("identification")
    found = estimation.paper_way(test.rig, runs, start=(weighted.value("k"), weighted.value("c")))
    if found.status != "ok":
        return PaperResult("failed", found.sentence, None, None, None, None, (), None)
    rms = tuple(found.rms.items())
    return PaperResult("ok", found.sentence, found.k, found.c, found.k_u, found.c_u, rms, found.objective)


def _finding(
    test: ResponseTest, found: Identification, paper: PaperResult | None, failures: tuple[str, ...]
) -> ResponseFinding:
    ok = found.status == "ok" and bool(found.runs)
    names = tuple(entry.name for entry in found.layout.unknowns[: found.layout.common]) if ok else ()
    total = found.total[: len(names), : len(names)]
    u = np.sqrt(np.diag(total)) if ok else np.ones(0)
    correlation = total / np.outer(u, u) if ok else np.zeros((0, 0))
    return ResponseFinding(
        status=found.status, sentence=found.sentence, model=model_text(test.rig), sought=sought(found, test.free) if
        ok else (), inputs=inputs_after(found) if ok else (), given=tuple(
            GivenValue(name, test.rig.parameters[name].unit, given.value, given.u, given.source)
            for name, given in test.given.items()
        ),
        correlated=names, correlation=tuple(tuple(float(value) for value in row) for row in correlation),
        chi_squared=found.reduced_chi_squared if ok else None, paper=paper,
        runs=fitted_runs(found) if ok else (), notes=found.notes, failures=failures, equations=equations(test.rig),
        coordinate=test.rig.coordinate, mass=test.rig.m,
    )  # fmt: skip
