"""What the report shows of an elongation test: its finding, from the line through the readings."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt

import numpy as np

from metrology.elongation import checks, model
from metrology.elongation.evidence import Evidence, runs
from metrology.elongation.finding import ElongationFinding, LoadLevel, RepeatLine
from metrology.elongation.line import Floats, Means, slope, slope_weights
from metrology.elongation.test import ElongationTest
from metrology.gum.inputs import Input
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


def presented(
    test: ElongationTest, evidence: Evidence, repeats: Mapping[str, int], inputs: tuple[Input, ...]
) -> ElongationFinding:
    """The finding of a test: readings and line, loads, repeats, checks and notes."""
    means = evidence.means
    b = slope(evidence.forces, means)
    force_of = dict(zip((load.name for load in test.loads), evidence.forces.tolist(), strict=True))
    shifts = {name: float(means.shifts[index]) for name, index in repeats.items()}
    used = evidence.layout
    intercept = float((evidence.values - means.shifts[used.repeats] - b * evidence.forces[used.loads]).mean())
    force = np.array([force_of[reading.load] for reading in test.readings])
    extension = model.corrected_readings(test, test.readings) - [
        shifts.get(reading.repeat, 0.0) for reading in test.readings
    ]
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
