"""Stiffness by the line that the data support: the stated line, corrected for the effects that were found."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Component, Input

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis, Source

EQUATION = "k = 1/(b + Δb), b = Σ n_i (F_i − F̄) (x_i − x̄) / Σ n_i (F_i − F̄)²"


def corrected(test: str, known: Mapping[str, Input], stated: Contribution, found: Diagnosis) -> Contribution:
    """K = 1/(b + Δb): slope b of the stated line, and what the effects that were found change of it.

    With the effects known, the readings determine the slope as well as without them: Δb is uncertain by the sizes of
    the effects, by how repeats differ, by what no model explains and by the choice of the model, and independent of b
    (Frisch & Waugh, Econometrica 1 (1933) 387). Where slopes differ between repeats, the scatter about one line, which
    u(b) has, holds a part of that already: as large a one as that of its degrees of freedom which the slopes have.

    Parameters
    ----------
    test : str
        First part of every name.
    known : mapping of str to Input
        All inputs of the campaign: the line may be corrected by what other parts of it bring, such as a fitted curve.
    stated : Contribution
        With k by the stated line.
    found : Diagnosis
        With the slope / (m/N) by the model that the data support.

    Returns
    -------
    Contribution
        The stated one with the correction Δb / (m/N) as a further input, and k / (N/m) in place of the stated k.
    """
    supported = found.supported
    assert supported is not None
    (line,) = stated.measurands
    at = supported.names.index("slope")
    namespace = {one: quantity.value for one, quantity in known.items()}
    name = f"{test}.slope correction"
    scatter = next((one.dof for one in supported.sources if one.kind == "readings"), None) or inf
    components = tuple(
        Component(one.name, Normal(u), one.dof or inf, "A", "diagnosis of the test")
        for one in supported.sources
        if one.kind in ("effects", "per run", "inadequacy", "models") and (u := _u(one, at, scatter)) > 0
    )
    value = supported.values[at] - 1.0 / float(line.function(namespace))
    assert isfinite(value)
    correction = Input(name, value, components, "m/N", "correction of the slope for the effects that were found")

    def stiffness(quantities: Mapping[str, Any]) -> Any:
        return 1.0 / (1.0 / line.function(quantities) + quantities[name])

    measurand = Measurand(line.name, stiffness, line.unit, EQUATION)
    return Contribution((*stated.inputs, correction), stated.ensembles, stated.correlations, (measurand,))


def _u(one: Source, at: int, scatter: float) -> float:
    """Standard uncertainty of the slope by one cause; `scatter`: degrees of freedom of the readings."""
    variance = sum(x * x for x in one.columns[at])
    held = (one.dof or 0.0) / scatter if one.kind == "per run" else 0.0
    return float((variance * max(1.0 - held, 0.0)) ** 0.5)
