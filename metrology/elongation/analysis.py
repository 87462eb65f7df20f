"""Evaluation of an elongation test: from readings to inputs, measurement model and finding."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from metrology.elongation import model
from metrology.elongation.evidence import Evidence
from metrology.elongation.finding import ElongationFinding
from metrology.elongation.line import Floats, Layout, Means, average, slope, slope_weights
from metrology.elongation.presentation import presented
from metrology.elongation.test import ElongationTest
from metrology.errors import Fault, MetrologyError
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Ensemble, Input


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
        finding=presented(test, evidence, _repeats(test), stated.inputs),
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


def _evidence(test: ElongationTest, layout: Layout, inputs: tuple[Input, ...]) -> Evidence:
    values = model.corrected_readings(test, test.used)
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
