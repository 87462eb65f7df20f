"""The measurement model of the elongation test: dead load, extension, and k by the line through them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf, sqrt
from typing import Any

import numpy as np

from metrology.elongation.again import Again, averages
from metrology.elongation.line import Layout, Means
from metrology.elongation.test import ElongationTest, Load, Reading
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.message import said

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

EQUATIONS = (
    "F_i = m_i (1 + delta_w) g (1 - rho_a / rho_w)",
    "x_i = (1 + delta_s) (z_i + e_i)",
    "k = Σ n_i (F_i − F̄)² / Σ n_i (F_i − F̄) (x_i − x̄)",
)
"""Load; extension from mean reading z and error e of the indicator; stiffness of a balanced test (F, x: means)."""


def corrected_readings(test: ElongationTest, readings: tuple[Reading, ...]) -> Floats:
    """Values of some readings in m, by the correction of the indicator where it has one, shape (n,)."""
    values = np.array([reading.value for reading in readings], dtype=float)
    if test.correction is None or not len(values):
        return values
    namespace = {item.name: item.value for item in test.correction.inputs}
    return np.asarray(test.correction.function(namespace, values), dtype=float)


def force(test: ElongationTest, load: Load, namespace: Mapping[str, Any]) -> Any:
    """Force of a dead load in N: F = m·(1 + δ_w)·g·(1 − ρ_a/ρ_w), or the stated force.

    Parameters
    ----------
    test : ElongationTest
        Names the inputs.
    load : Load
        The load.
    namespace : mapping of str to quantity
        Values of the inputs in SI: floats, arrays of draws or ``uncertainties`` variables.

    Returns
    -------
    quantity
        Force in N, of the kind that the namespace holds.

    Notes
    -----
    For weights of 8000 kg/m³ it makes no difference whether m is the mass or the conventional mass of a certificate.
    """
    quantity = namespace[load.quantity.name]
    if load.quantity.unit == "N":
        return quantity
    mass = quantity if test.weights is None else quantity * (1.0 + namespace[test.weights.name])
    buoyancy = 1.0 - namespace[test.air_density.name] / namespace[test.weight_density.name]
    return mass * (namespace[test.gravity.name] * buoyancy)


def forces(test: ElongationTest) -> Floats:
    """Forces of all loads in N, with the values of the inputs as stated, shape (L,)."""
    known = (test.gravity, test.air_density, test.weight_density, *((test.weights,) if test.weights else ()))
    namespace = {item.name: item.value for item in (*known, *(load.quantity for load in test.loads))}
    return np.array([force(test, load, namespace) for load in test.loads])


def extension(test: ElongationTest, load: Load, namespace: Mapping[str, Any]) -> Any:
    """Mean extension at a load in m, up to a zero that is common to all loads: x = (1 + δ_s)·(c(z) + e).

    z is the mean reading, c the correction of the indicator, e its error at this load, δ_s the error of its scale.
    """
    reading = namespace[reading_name(test, load)]
    if test.correction is not None:
        reading = test.correction.function(namespace, reading)
    if test.indicator:
        reading = reading + namespace[indicator_name(test, load)]
    return reading if test.scale is None else reading * (1.0 + namespace[test.scale.name])


def stiffness(test: ElongationTest, information: Floats, namespace: Mapping[str, Any]) -> Any:
    """Stiffness k in N/m, reciprocal of the least-squares slope of extension against load: k = Fᵀ·M·F / (Fᵀ·M·x).

    Parameters
    ----------
    test : ElongationTest
        Names the inputs.
    information : ndarray, shape (L, L)
        M of `line.Means`; in a balanced test M_ij = n_i·δ_ij − n_i·n_j/n, so that k = Σ n(F − F̄)² / Σ n(F − F̄)(x −
        x̄).
    namespace : mapping of str to quantity
        Values of the inputs in SI.
    """
    forces = [force(test, load, namespace) for load in test.loads]
    extensions = [extension(test, load, namespace) for load in test.loads]
    weights = [_combine(row, forces) for row in information.tolist()]
    return _combine(weights, forces) / _combine(weights, extensions)


def _combine(weights: list[Any], terms: list[Any]) -> Any:
    total = weights[0] * terms[0]
    for weight, term in zip(weights[1:], terms[1:], strict=True):
        total = total + weight * term
    return total


def reading_name(test: ElongationTest, load: Load) -> str:
    """Name of the input that is the mean reading at a load: ``{test}.reading.{load}``."""
    return f"{test.name}.reading.{load.name}"


def indicator_name(test: ElongationTest, load: Load) -> str:
    """Name of the input that is the error of the indicator at a load: ``{test}.indicator.{load}``."""
    return f"{test.name}.indicator.{load.name}"


def averaging(test: ElongationTest, means: Means) -> bool:
    """Whether rounding errors of the readings of a test average out (`again.averages`)."""
    return bool(averages(means.variance, test.resolution.u))


def rounding(test: ElongationTest, means: Means, count: int) -> Component:
    """Rounding of the mean of `count` readings at one load."""
    from metrology.gum.distributions import Normal

    resolution = test.resolution
    if not averaging(test, means):
        source = said("common to the readings at a load, which scatter by less than half a division")
        return Component(
            resolution.name, resolution.distribution, resolution.dof, resolution.kind, _join(resolution.source, source)
        )
    text = "mean of {count} independent {shape} errors: scatter of half a division or more"
    source = said(text, count=count, shape=resolution.distribution.name)
    return Component(
        resolution.name, Normal(resolution.u / sqrt(count)), inf, resolution.kind, _join(resolution.source, source)
    )


def _join(*texts: str) -> str:
    return said("{texts}", texts=tuple(text for text in texts if text))


def inputs(test: ElongationTest, means: Means, counts: list[int]) -> tuple[Input, ...]:
    """Every input of the model: loads, surroundings, mean readings and errors of the indicator."""
    found = {item.name: item for item in _declared(test)}
    for load, value, count in zip(test.loads, means.values.tolist(), counts, strict=True):
        components = (rounding(test, means, count),) if test.resolution.u > 0 else ()
        name = reading_name(test, load)
        found[name] = Input(
            name, value, components, "m", said("mean reading at load {name}, n = {count}", name=load.name, count=count)
        )
        if test.indicator:
            name = indicator_name(test, load)
            here = _at_place(test.indicator, test.places.get(load.name, ""))
            found[name] = Input(name, 0.0, here, "m", said("error of the indicator at load {name}", name=load.name))
    return tuple(found.values())


def _at_place(components: tuple[Component, ...], place: str) -> tuple[Component, ...]:
    """What makes an indication uncertain at one place of the scale: without a cause of its own, another elsewhere."""
    return tuple(replace(one, cause=one.cause or (place and f"{one.name}, {place}")) for one in components)


def _declared(test: ElongationTest) -> tuple[Input, ...]:
    masses = any(load.quantity.unit == "kg" for load in test.loads)
    surroundings = (test.weights, test.gravity, test.air_density, test.weight_density) if masses else ()
    named = (*(load.quantity for load in test.loads), *surroundings, test.scale)
    return tuple(item for item in named if item is not None)


def ensembles(test: ElongationTest, means: Means, layout: Layout) -> tuple[Ensemble, ...]:
    """Repeatability of the mean readings: one pooled s² with its degrees of freedom, jointly for all loads.

    Empty where the readings at every load are all the same: the resolution then stands for the repeatability.
    """
    if means.variance <= (1e-9 * test.resolution.u) ** 2:
        return ()
    members = tuple(reading_name(test, load) for load in test.loads)
    text = "pooled scatter of the readings, s = {s:.3g} µm with {dof} degrees of freedom"
    source = said(text, s=1e6 * sqrt(means.variance), dof=int(means.dof))
    name, covariance = said("repeatability of {test}", test=test.name), means.variance * means.cofactor
    again = Again(layout, means, test.resolution.u)
    return (Ensemble(name, members, covariance, float(means.dof), source, again=again),)
