"""Evaluation of an elongation test: from readings to inputs, measurement model and finding."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from metrology.elongation import checks, model
from metrology.elongation.evidence import Evidence, runs
from metrology.elongation.finding import ElongationFinding, LoadLevel, RepeatLine
from metrology.elongation.line import Floats, Layout, Means, average, slope, slope_weights
from metrology.elongation.test import ElongationTest, Reading
from metrology.errors import Fault, MetrologyError
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Ensemble, Input
from metrology.message import counted, said

SCATTERS = {
    (True, True): "Scatter of one reading about the line s = {s:.3g} µm with {dof} degrees of freedom; rounding taken "
    "as independent between readings.",
    (True, False): "Scatter of one reading about the line s = {s:.3g} µm with {dof} degrees of freedom; rounding taken "
    "as common to all readings at a load.",
    (False, True): "Scatter of one reading s = {s:.3g} µm with {dof} degrees of freedom; rounding taken as independent "
    "between readings.",
    (False, False): "Scatter of one reading s = {s:.3g} µm with {dof} degrees of freedom; rounding taken as common to "
    "all readings at a load.",
}
"""Whether it is that about the line, and whether rounding averages out → what is said of the scatter."""


@dataclass(frozen=True)
class ElongationAnalysis:
    """What an elongation test hands to the evaluation of the campaign, and what it shows.

    Parameters
    ----------
    inputs : tuple of Input
        Inputs of the model; those shared with other tests (g, the weights) appear under the same name in each.
    ensembles : tuple of Ensemble
        Repeatability of the mean readings.
    correlations : mapping of (str, str) to float
        Empty: the model carries what is common.
    measurands : tuple of Measurand
        ``{test}.k``.
    finding : ElongationFinding
        What the report shows.
    """

    inputs: tuple[Input, ...]
    ensembles: tuple[Ensemble, ...]
    correlations: Mapping[tuple[str, str], float]
    measurands: tuple[Measurand, ...]
    finding: ElongationFinding

    @property
    def contribution(self) -> Contribution:
        """What it puts into the measurement model."""
        return Contribution(self.inputs, self.ensembles, self.correlations, self.measurands)


def analyse(test: ElongationTest) -> ElongationAnalysis:
    """Stiffness of a sample from dead loads and extensions: k = Σ n(F − F̄)² / Σ n(F − F̄)(x − x̄).

    The line of extension against load is fitted by least squares with one slope for all readings and a zero for each
    repeat; in a balanced test its slope is that of the plain line through all readings. k is its reciprocal.
    Everything uncertain goes through that same formula:

    - *repeatability* (Type A): the pooled scatter s of the readings at the same load, after the zero of the repeat,
      with ν = n − L − R + 1, or where they are too few of all readings about the line, ν = n − R − 1; the mean
      readings are one ensemble (JCGM 100 4.2.3, 5.2.3), so that k inherits ν exactly;
    - *resolution*: rounding of each reading, rectangular (JCGM 100 F.2.2.1): independent between readings where they
      scatter by half a division or more, otherwise common to the readings at a load. It is in the scatter already in
      the first case, which JCGM 100 4.3.10 warns of: it raises u of a mean by 15 % at most, at s of half a division;
    - *indicator*: the error of indication is one and the same in all readings at a load and independent between loads
      (JCGM 100 F.2.4.1, F.1.2.3): nothing is gained by repeating. A correlation alike between all loads would only
      lessen u(k); an error proportional to extension, which would not average, is stated as `scale`;
    - *masses*: what is common to them (the set's certificate) as one relative correction, what is each one's own as
      its own component (JCGM 100 F.1.2.3); *g* and *air buoyancy* as inputs common to all loads.

    Parameters
    ----------
    test : ElongationTest
        Loads, readings and what is known of the instruments.

    Returns
    -------
    ElongationAnalysis
        Slope and k as inputs and measurands, and what the report shows.

    Raises
    ------
    MetrologyError
        Where the readings fall as the load grows.
    """
    layout = _layout(test)
    stated = contribution(test)
    evidence = _evidence(test, layout, stated.inputs)
    _refuse_falling(test, evidence)
    return ElongationAnalysis(
        inputs=stated.inputs,
        ensembles=stated.ensembles,
        correlations=stated.correlations,
        measurands=stated.measurands,
        finding=_finding(test, evidence, _repeats(test), stated.inputs),
    )


def contribution(test: ElongationTest, *, slope_variance: float | None = None) -> Contribution:
    """Model of k by the line through the readings in use.

    Parameters
    ----------
    test : ElongationTest
        Loads, readings and what is known of the instruments.
    slope_variance : float, optional
        Variance of the slope / (m/N)² by the scatter of the readings, where that is known otherwise than by the
        readings at the same load: the scatter of one reading is then as large as this needs.
    """
    layout, forces, means = _averaged(test)
    if slope_variance is not None:
        weights = slope_weights(forces, means)
        means = replace(means, variance=slope_variance / float(weights @ means.cofactor @ weights))
    counts = np.bincount(layout.loads, minlength=len(test.loads)).tolist()
    information = means.information
    stiffness = Measurand(
        f"{test.name}.k", lambda namespace: model.stiffness(test, information, namespace), "N/m", model.EQUATIONS[2]
    )
    return Contribution(model.inputs(test, means, counts), model.ensembles(test, means, layout), {}, (stiffness,))


def leverages(test: ElongationTest) -> Floats:
    """What the mean reading at each load moves the slope of the line by, in 1/N, shape (L,)."""
    _, forces, means = _averaged(test)
    return slope_weights(forces, means)


def by_drift(test: ElongationTest) -> tuple[float, float] | None:
    """What a steady drift of the reading does to k, where no reading shows it.

    Where every repeat takes the loads in one order, each of them once, a reading that moves by a from one reading to
    the next is a·j at the j-th load: an extension of load, in every repeat alike. Reading them on the way back as well
    parts the two.

    Parameters
    ----------
    test : ElongationTest
        As for `analyse`.

    Returns
    -------
    (float, float) or None
        Derivative of k by a / (N/m per m), and mean extension from one reading to the next / m; None where the order
        differs.
    """
    orders: dict[str, list[str]] = {}
    for reading in test.readings:
        orders.setdefault(reading.repeat, []).append(reading.load)
    order, *others = orders.values()
    if len(set(order)) < len(order) or any(one != order for one in others):
        return None
    _, forces, means = _averaged(test)
    weights = slope_weights(forces, means)
    place = np.array([order.index(load.name) for load in test.loads], dtype=float)
    slope = float(weights @ means.values)
    steps = abs(slope) * float(np.mean(np.abs(np.diff(forces[np.argsort(place)]))))
    return -float(weights @ place) / slope**2, steps


def _averaged(test: ElongationTest) -> tuple[Layout, Floats, Means]:
    layout, forces = _layout(test), model.forces(test)
    return layout, forces, average(np.array([reading.value for reading in test.used]), layout, forces)


def _repeats(test: ElongationTest) -> dict[str, int]:
    return {name: index for index, name in enumerate(dict.fromkeys(reading.repeat for reading in test.used))}


def _layout(test: ElongationTest) -> Layout:
    order, repeats = {load.name: index for index, load in enumerate(test.loads)}, _repeats(test)
    return Layout.of([order[one.load] for one in test.used], [repeats[one.repeat] for one in test.used])


def _corrected(test: ElongationTest, readings: tuple[Reading, ...]) -> Floats:
    values = np.array([reading.value for reading in readings], dtype=float)
    if test.correction is None or not len(values):
        return values
    namespace = {item.name: item.value for item in test.correction.inputs}
    return np.asarray(test.correction.function(namespace, values), dtype=float)


def _evidence(test: ElongationTest, layout: Layout, inputs: tuple[Input, ...]) -> Evidence:
    values = _corrected(test, test.used)
    namespace = {item.name: item.value for item in inputs}
    forces = np.array([model.force(test, load, namespace) for load in test.loads])
    means = average(values, layout, forces)
    uncertain = {item.name: item.u for item in inputs}
    b = slope(forces, means)
    declared = [
        sqrt(
            uncertain[model.reading_name(test, load)] ** 2
            + uncertain.get(model.indicator_name(test, load), 0.0) ** 2
            + (b * force * load.quantity.u / (load.quantity.value or 1.0)) ** 2
        )
        for load, force in zip(test.loads, forces.tolist(), strict=True)
    ]
    resolution = sqrt(12.0) * test.resolution.u
    return Evidence(test.used, values, layout, forces, means, np.array(declared), test.significance, resolution)


def _refuse_falling(test: ElongationTest, evidence: Evidence) -> None:
    b = slope(evidence.forces, evidence.means)
    if not b > 0:
        got = f"readings that change by {1e6 * b:.3g} µm/N"
        down = " (of a scale that counts down: the reading without load minus each reading)" if b < 0 else ""
        fix = f"give the readings with the sign of extension{down}, and check which load each belongs to"
        raise MetrologyError(Fault(f"{test.name}.readings", got, "readings that grow with the load", fix))


def _finding(
    test: ElongationTest, evidence: Evidence, repeats: Mapping[str, int], inputs: tuple[Input, ...]
) -> ElongationFinding:
    means = evidence.means
    b = slope(evidence.forces, means)
    force_of = dict(zip((load.name for load in test.loads), evidence.forces.tolist(), strict=True))
    shifts = {name: float(means.shifts[index]) for name, index in repeats.items()}
    used = evidence.layout
    intercept = float((evidence.values - means.shifts[used.repeats] - b * evidence.forces[used.loads]).mean())
    force = np.array([force_of[reading.load] for reading in test.readings])
    extension = _corrected(test, test.readings) - [shifts.get(reading.repeat, 0.0) for reading in test.readings]
    return ElongationFinding(
        force=tuple(force.tolist()),
        extension=tuple(extension.tolist()),
        residual=tuple((extension - intercept - b * force).tolist()),
        repeat=tuple(reading.repeat for reading in test.readings),
        direction=tuple(reading.direction for reading in test.readings),
        excluded=tuple(reading.excluded for reading in test.readings),
        intercept=intercept,
        slope=b,
        slope_u=_slope_u(evidence, b, _common(test, evidence, inputs)),
        levels=_levels(test, evidence, intercept, b),
        repeats=tuple(RepeatLine(*line) for line in runs(evidence)),
        checks=checks.run(evidence),
        equations=model.EQUATIONS,
        notes=_notes(test, means, inputs),
        significance=test.significance,
    )


def _covariance(evidence: Evidence) -> Floats:
    """Covariance of the mean extensions: repeatability, and what is declared for each load."""
    return np.asarray(evidence.means.variance * evidence.means.cofactor + np.diag(evidence.declared**2))


def _common(test: ElongationTest, evidence: Evidence, inputs: tuple[Input, ...]) -> float:
    """Relative standard uncertainty of the slope from what acts on all loads alike."""
    known = {item.name: item for item in inputs}
    relative = [
        item.u / (1 + item.value) for item in (test.weights, test.scale) if item is not None and item.name in known
    ]
    if test.gravity.name in known and evidence.forces.any():
        air, weight = test.air_density, test.weight_density
        buoyancy = air.value / weight.value
        relative.append(test.gravity.u / test.gravity.value)
        relative.append(sqrt(air.u**2 + (buoyancy * weight.u) ** 2) / weight.value / (1 - buoyancy))
    return sqrt(sum(u**2 for u in relative))


def _slope_u(evidence: Evidence, b: float, common: float) -> float:
    weights = slope_weights(evidence.forces, evidence.means)
    return sqrt(float(weights @ _covariance(evidence) @ weights) + (common * b) ** 2)


def _levels(test: ElongationTest, evidence: Evidence, intercept: float, b: float) -> tuple[LoadLevel, ...]:
    means, forces, loads = evidence.means, evidence.forces, evidence.layout.loads
    counts = np.bincount(loads, minlength=len(forces))
    corrected = evidence.values - means.shifts[evidence.layout.repeats]
    covariance, share = _covariance(evidence), counts / counts.sum()
    weights = slope_weights(forces, means)
    levels = []
    for index, load in enumerate(test.loads):
        x, force = float(means.values[index]), float(forces[index])
        secant = x - intercept
        effect = np.eye(len(forces))[index] - share + float(share @ forces) * weights
        usable = force > 0 and secant > 0
        levels.append(
            LoadLevel(
                load=load.name,
                force=force,
                extension=x,
                standard_deviation=float(corrected[loads == index].std(ddof=1)) if counts[index] > 1 else evidence.s,
                count=int(counts[index]),
                stiffness=force / secant if usable else None,
                stiffness_u=force / secant**2 * sqrt(float(effect @ covariance @ effect)) if usable else None,
                residual=x - intercept - b * force,
            )
        )
    return tuple(levels)


def _notes(test: ElongationTest, means: Means, inputs: tuple[Input, ...]) -> tuple[str, ...]:
    notes = []
    if means.zero_each and len(means.shifts) > 1:
        text = "Each repeat has a zero of its own in the line; extensions are shown less the shift of it."
        notes.append(said(text))
    elif len(means.shifts) > 1:
        text = (
            "One zero serves all repeats, since they do not hold enough readings at common loads to tell their zeros."
        )
        notes.append(said(text))
    text = SCATTERS[means.about_line, model.averaging(test, means)]
    notes.append(said(text, s=1e6 * sqrt(means.variance), dof=int(means.dof)))
    if any(item.name == test.air_density.name for item in inputs):
        buoyancy = test.air_density.value / test.weight_density.value
        text = "Air buoyancy lessens the force by {part:.3g} %; it is taken into account."
        notes.append(said(text, part=100 * buoyancy))
    excluded = sum(1 for reading in test.readings if reading.excluded)
    if excluded:
        one = "{count} reading shown but not used, each with its reason."
        notes.append(counted(one, "{count} readings shown but not used, each with its reason.", excluded))
    return tuple(notes)
