"""Evaluation of a free-decay test: from the records of several releases to inputs and measurands of ω_n, ζ, c and k."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, pi, sqrt
from typing import Any

import numpy as np

from metrology import raw
from metrology.decay import envelope, evidence
from metrology.decay.finding import DecayFinding
from metrology.decay.release import Release, drawn, evaluate, trace
from metrology.decay.start import Unusable
from metrology.decay.test import DecayTest
from metrology.gum import functions
from metrology.gum.bounded import Rectangular
from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.message import said
from metrology.timeseries import Trace

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Correlations = Mapping[tuple[str, str], float]
HALF = 0.5
"""Probability by chance below which releases scatter: noise alone would scatter less more often than not."""
EQUATIONS = (
    said("δ = (2/i)·ln(a₀/a_i), over maxima and minima i = 0, 1, 2, …; by direct fit δ = 2π·λ/ω_d"),
    "ζ = δ/√(4π² + δ²)",
    "ω_n = ω_d/√(1 − ζ²)",
    "c = 2·ζ·√(k·m)",
    "k_dyn = m·ω_n²",
)


@dataclass(frozen=True)
class DecayAnalysis:
    """What a free-decay test gives to the evaluation of the campaign, and what the report shows of it.

    Without any usable record `measurands` is empty and `finding.failures` says why. `traces`: every sample of each
    record, for the screen.
    """

    inputs: tuple[Input, ...]
    ensembles: tuple[Ensemble, ...]
    correlations: Mapping[tuple[str, str], float]
    measurands: tuple[Measurand, ...]
    finding: DecayFinding
    traces: Mapping[str, Trace] = field(default_factory=dict)

    @property
    def contribution(self) -> Contribution:
        """What it puts into the measurement model."""
        return Contribution(self.inputs, self.ensembles, self.correlations, self.measurands)


def analyse(test: DecayTest) -> DecayAnalysis:
    """Evaluate a free-decay test: direct fit and log decrement over the peaks, mean over the releases.

    The estimates of δ and ω_d are the means over the releases. Their scatter, as the covariance matrix of
    simultaneous readings with ν = n − 1, is the Type A uncertainty: it contains the noise within each record, which
    is therefore not added again (JCGM 100 4.2, 5.2.3). Where that noise explains the scatter, it is the Type A
    uncertainty itself, and so it is of a single record. What all releases share is added as Type B: the difference
    between the two ways of evaluation, the clock, the mass and k.

    Parameters
    ----------
    test : DecayTest
        Releases with their records, mass, and what is known of the instruments.

    Returns
    -------
    DecayAnalysis
        Inputs with their joint covariance, and what the report shows; without inputs where no release could be
        evaluated, with the reason of each.
    """
    releases: list[Release] = []
    failures: list[str] = []
    for record, separated in zip(test.records, test.separated, strict=True):
        try:
            releases.append(evaluate(record, separated))
        except Unusable as reason:
            failures.append(said("{name}: {sentence}", name=record.name, sentence=reason.args[0]))
    if not releases:
        return _nothing(test, tuple(failures))
    shape = envelope.shape([(release.separated, release.least) for release in releases], test.mass.value)
    inputs, ensembles, correlations = _inputs(test, releases)
    finding = DecayFinding(
        records=tuple(drawn(release, mains=test.mains) for release in releases),
        mass=test.mass.value,
        filter=evidence.filter_words(releases),
        damping=shape.sentence,
        checks=(
            raw.check({record.name: record for record in test.records}, test.resolution),
            *evidence.checks(releases, shape),
        ),
        equations=EQUATIONS,
        notes=evidence.notes(releases, scale=test.scale),
        failures=tuple(failures),
        shape=shape,
        significance=evidence.LEVEL,
    )
    traces = {release.record.name: trace(release) for release in releases}
    return DecayAnalysis(inputs, ensembles, correlations, _measurands(test), finding, traces)


def _nothing(test: DecayTest, failures: tuple[str, ...]) -> DecayAnalysis:
    finding = DecayFinding(
        records=(),
        mass=test.mass.value,
        filter="",
        damping=said("Not tested: no record could be evaluated."),
        checks=(),
        equations=EQUATIONS,
        failures=failures,
    )
    return DecayAnalysis((), (), {}, (), finding)


def _inputs(test: DecayTest, releases: list[Release]) -> tuple[tuple[Input, ...], tuple[Ensemble, ...], Correlations]:
    """Return δ and ω_d with what else the results take, how far they scatter, and the noise within the releases.

    The direct fit leads: it is the likelihood of the rig's own motion, as of a response test, and uses every sample.
    Where the releases differ by more than their noise, no estimate from one of them is better than another, and the
    logarithmic decrement of the method as published leads.
    """
    names = (f"{test.name}.log_decrement", f"{test.name}.omega_d")
    peaks = [release.decrement for release in releases if release.decrement is not None]
    values, noise = (np.array(found) for found in zip(*(release.fitted for release in releases), strict=True))
    extra = np.zeros(2)
    leads = "peaks" if len(peaks) == len(releases) > 1 and not evidence.is_noise(releases) else "fit"
    if peaks and (leads == "peaks" or not evidence.agree(releases)):
        by_peaks = np.array([(one.delta, one.omega) for one in peaks])
        same = np.array([one.fitted[0] for one in releases if one.decrement is not None])
        extra = abs(same.mean(axis=0) - by_peaks.mean(axis=0))
        if leads == "peaks":
            values, noise = by_peaks, np.array([one.covariance for one in peaks])
    count = len(releases)
    texts = (
        said(
            "logarithmic decrement δ, mean over the releases" if count > 1 else "logarithmic decrement δ, by direct fit"
        ),
        said(
            "damped angular frequency ω_d, mean over the releases"
            if count > 1
            else "damped angular frequency ω_d, by direct fit"
        ),
    )
    scattered, scatter, within = spread_of_mean(values, noise)
    ensembles: tuple[Ensemble, ...] = ()
    if scattered:
        source = said("scatter of {count} releases, noise within each record included", count=count)
        of, name = tuple(names[at] for at in scattered), said("{test} releases", test=test.name)
        ensembles = (Ensemble(name, of, scatter, count - 1, source),)
    units, mean = ("1", "rad/s"), values.mean(axis=0)
    dof = inf if leads == "peaks" else sum(release.separated.fit.dof for release in releases)
    parts = [() if at in scattered else _within(sqrt(within[at, at]), count, dof) for at in range(2)]
    inputs = tuple(
        Input(names[i], float(mean[i]), (*parts[i], *_two_ways(float(extra[i]))), units[i], texts[i]) for i in range(2)
    )
    correlations = {} if scattered else {names: float(within[0, 1]) / (inputs[0].u * inputs[1].u)}
    others = (test.clock,) if test.clock is not None else ()
    return (*inputs, test.mass, *others), ensembles, correlations


def spread_of_mean(values: Floats, noise: Floats) -> tuple[list[int], Floats, Floats]:
    """Return which means over releases scatter, the covariance of these, and that of all by the noise within.

    The scatter S of a few releases may be small by chance, and then says nothing of how well their mean is known. It
    is the Type A uncertainty where noise alone would scatter less more often than not, P(χ²) < ½, and then no less
    than the noise; else the noise, which is known, is. With three releases an interval of 95 % then holds the true
    value in 94 % to 98 % of all tests, however much the releases differ. Where they differ in one quantity by more
    than noise, none is taken to be free of it.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        Estimates of each release.
    noise : ndarray, shape (n, m, m)
        Covariance of each by the noise within its record.
    """
    from scipy.special import chdtrc

    count = len(values)
    within = noise.mean(axis=0)
    if count < 2:
        return [], np.zeros((0, 0)), within
    scatter = np.atleast_2d(np.cov(values, rowvar=False))
    ratio = np.diag(scatter) / np.maximum(np.diag(within), 1e-300)
    chances = chdtrc(count - 1, (count - 1) * ratio)
    differ = chances.min() < evidence.LEVEL
    scattered = [at for at, chance in enumerate(chances) if differ or chance < HALF]
    least = np.sqrt(np.maximum(1.0, 1.0 / np.maximum(ratio[scattered], 1e-300)))
    return scattered, scatter[np.ix_(scattered, scattered)] * np.outer(least, least) / count, within / count


def _within(u: float, count: int, dof: float) -> tuple[Component, ...]:
    """Return the noise within the records as a component of a mean over them."""
    source = (
        said("one release only: no scatter known")
        if count == 1
        else said("mean over {count} records, which scatter by no more than it explains", count=count)
    )
    return (Component(said("noise within the record"), Normal(u), dof, kind="A", source=source),)


def _two_ways(half_width: float) -> tuple[Component, ...]:
    """Return the difference between peaks and direct fit as a component: which way is nearer the truth is not known."""
    source = said("difference between the two ways")
    return (Component(said("peaks against direct fit"), Rectangular(half_width), source=source),) if half_width else ()


def _measurands(test: DecayTest) -> tuple[Measurand, ...]:
    delta, omega_d, mass = f"{test.name}.log_decrement", f"{test.name}.omega_d", test.mass.name
    zeta, omega_n, clock = f"{test.name}.zeta", f"{test.name}.omega_n", test.clock.name if test.clock else None

    def damping(x: Mapping[str, Any]) -> Any:
        return x[delta] / functions.sqrt(4 * pi**2 + x[delta] ** 2)

    def frequency(x: Mapping[str, Any]) -> Any:
        undamped = x[omega_d] / functions.sqrt(1 - x[zeta] ** 2)
        return undamped if clock is None else undamped / (1 + x[clock])

    def coefficient(x: Mapping[str, Any]) -> Any:
        return 2 * x[zeta] * functions.sqrt(x[test.stiffness] * x[mass])

    def dynamic(x: Mapping[str, Any]) -> Any:
        return x[mass] * x[omega_n] ** 2

    by_clock = "" if clock is None else "/(1 + δ_t)"
    unit_k, unit_c = ("N·m/rad", "N·m·s/rad") if test.coordinate == "angle" else ("N/m", "N·s/m")
    c = Measurand(f"{test.name}.c", coefficient, unit_c, "c = 2·ζ·√(k·m)")
    k = Measurand(f"{test.name}.k", dynamic, unit_k, "k_dyn = m·ω_n²")
    return (
        Measurand(zeta, damping, "1", "ζ = δ/√(4π² + δ²)"),
        Measurand(omega_n, frequency, "rad/s", f"ω_n = ω_d/√(1 − ζ²){by_clock}"),
        *((k, c) if test.stiffness == k.name else (c, k)),
    )


def by_clock(test: DecayTest, analysis: DecayAnalysis) -> dict[str, float]:
    """Derivatives of the results by what a second of the clock lasts beyond a second: ω_n is in its time, ζ in none.

    Parameters
    ----------
    test, analysis : DecayTest, DecayAnalysis
        A test with results, and its evaluation.

    Returns
    -------
    dict of str to float
        By the full name of the result.
    """
    power = {f"{test.name}.omega_n": 1, f"{test.name}.k": 2, f"{test.name}.c": 1}
    known: dict[str, float] = {one.name: one.value for one in analysis.inputs}
    for measurand in analysis.measurands:
        # c with the k of another test is in the time of none: c = 2·ζ·√(k·m).
        if measurand.name != f"{test.name}.c" or test.stiffness in known:
            known[measurand.name] = measurand.function(known)
    return {name: -times * known[name] for name, times in power.items() if name in known}
