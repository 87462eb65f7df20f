"""Stiffness by the line that the data support: the stated line, corrected for the effects that were found."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any

from metrology.elongation.analysis import contribution
from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Component, Input

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis, Source
    from metrology.elongation.test import ElongationTest

EQUATION = "k = 1/(b + Δb), b = Σ n_i (F_i − F̄) (x_i − x̄) / Σ n_i (F_i − F̄)²"


def corrected(test: ElongationTest, known: Mapping[str, Input], found: Diagnosis) -> Contribution:
    """K = 1/(b + Δb): slope b of the stated line, and what the effects that were found change of it.

    With the effects known, the readings determine the slope as well as without them: b is uncertain by the scatter
    that the model with the effects leaves, and Δb, independent of b, by the sizes of the effects, by how repeats
    differ, by what no model explains and by the choice of the model (Frisch & Waugh, Econometrica 1 (1933) 387).

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
        Component(one.name, Normal(sqrt(variance)), one.dof or inf, "A", "diagnosis of the test")
        for one in supported.sources
        if one.kind in ("effects", "per run", "inadequacy", "models") and (variance := _variance(one, at)) > 0
    )
    value = supported.values[at] - 1.0 / float(line.function(namespace))
    assert isfinite(value)
    correction = Input(name, value, components, "m/N", "correction of the slope for the effects that were found")

    def stiffness(quantities: Mapping[str, Any]) -> Any:
        return 1.0 / (1.0 / line.function(quantities) + quantities[name])

    measurand = Measurand(line.name, stiffness, line.unit, EQUATION)
    return Contribution((*stated.inputs, correction), stated.ensembles, stated.correlations, (measurand,))


def _variance(one: Source, at: int) -> float:
    """Variance of the slope by one cause."""
    return sum(x * x for x in one.columns[at])
