"""Stiffness by the line that the data support: the stated line, corrected for the effects that were found."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any

from metrology.elongation.analysis import contribution, leverages
from metrology.elongation.model import force, indicator_name
from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Component, Input
from metrology.message import said

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis, Source, Supported
    from metrology.elongation.test import ElongationTest, Load

EQUATION = "k = 1/(b + Δb + Σ d_i e_i), b = Σ n_i (F_i − F̄) (x_i − x̄) / Σ n_i (F_i − F̄)²"
"""e_i: what is off at load i, and d_i what it moves the slope by beyond what it moves b by."""


def corrected(test: ElongationTest, known: Mapping[str, Input], found: Diagnosis) -> Contribution:
    """K = 1/(b + Δb + Σ d_i·e_i): slope b of the stated line, and what the effects that were found change of it.

    With the effects known, the readings determine the slope as well as without them: b is uncertain by the scatter
    that the model with the effects leaves, and Δb, independent of b, by the sizes of the effects, by how repeats
    differ, by what no model explains and by the choice of the model (Frisch & Waugh, Econometrica 1 (1933) 387).
    What is off at one load, by its mass or the error of the indicator, moves the slope of the extended model otherwise
    than that of the line: by the difference d_i.

    Parameters
    ----------
    test : ElongationTest
        Loads, readings and what is known of the instruments.
    known : mapping of str to Input
        All inputs of the campaign: the line may be corrected by what other parts of it bring, such as a fitted curve.
    found : Diagnosis
        With the slope / (m/N) by the model that the data support.

    Returns
    -------
    Contribution
        The stated one with the scatter that the effects leave, the correction Δb / (m/N) as a further input, and
        k / (N/m) in place of the stated k.
    """
    supported = found.supported
    assert supported is not None
    at = supported.names.index("slope")
    scatter = sum(_variance(one, at) for one in supported.sources if one.kind == "readings")
    stated = contribution(test, slope_variance=scatter)
    (line,) = stated.measurands
    namespace = {one: quantity.value for one, quantity in known.items()}
    name = f"{test.name}.slope correction"
    components = tuple(
        Component(one.name, Normal(sqrt(variance)), one.dof or inf, "A", said("diagnosis of the test"))
        for one in supported.sources
        if one.kind in ("effects", "per run", "inadequacy", "models") and (variance := _variance(one, at)) > 0
    )
    slope = supported.values[at]
    value = slope - 1.0 / float(line.function(namespace))
    assert isfinite(value)
    correction = Input(name, value, components, "m/N", said("correction of the slope for the effects that were found"))
    weights = _weights(test, supported, at)

    def moved(quantities: Mapping[str, Any]) -> Any:
        return sum(weight * _off(test, load, slope, quantities) for load, weight in weights)

    as_stated = moved(namespace)

    def stiffness(quantities: Mapping[str, Any]) -> Any:
        return 1.0 / (1.0 / line.function(quantities) + quantities[name] + moved(quantities) - as_stated)

    measurand = Measurand(line.name, stiffness, line.unit, EQUATION)
    return Contribution((*stated.inputs, correction), stated.ensembles, stated.correlations, (measurand,))


def _weights(test: ElongationTest, supported: Supported, at: int) -> list[tuple[Load, float]]:
    """What an error of the extension at each load moves the slope by, in 1/N, beyond what it does to the line's."""
    by_line = dict(zip((load.name for load in test.loads), leverages(test).tolist(), strict=True))
    known = {one.name: one for one in supported.sources if one.kind == "common" and one.u > 0}
    found = ((load, known.get(f"indicator.{load.name}")) for load in test.loads)
    # An error of the reading was sought, and what is added to a reading takes it off.
    return [(load, -one.columns[at][0] / one.u - by_line[load.name]) for load, one in found if one is not None]


def _off(test: ElongationTest, load: Load, slope: float, quantities: Mapping[str, Any]) -> Any:
    """Error of the indicator at a load less what its force extends by, in m: what both are off by moves the line."""
    extended = slope * force(test, load, quantities)
    return quantities[indicator_name(test, load)] - extended if test.indicator else -extended


def _variance(one: Source, at: int) -> float:
    """Variance of the slope by one cause."""
    return sum(x * x for x in one.columns[at])
