"""Stiffness by the line that the data support: the stated lines, corrected for the effects that were found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Any

from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Component, Input
from metrology.message import said

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis

RESULTS = ("EA", "k", "E")
"""Results that go with the reciprocal of the slope, where they are means over specimens; else all follow from EA."""


def corrected(test: str, slope: float, stated: Contribution, found: Diagnosis) -> Contribution:
    """Divide the results by 1 + δ, δ the relative change of the slope of strain by force with the effects known.

    δ is uncertain by the sizes of the effects, by what no model explains and by the choice of the model; what the
    readings leave of the slope beside that is in the stated slopes already.

    Parameters
    ----------
    test : str
        First part of every name.
    slope : float
        Mean slope of the stated lines / (1/N).
    stated : Contribution
        With the results by them.
    found : Diagnosis
        With the slope by the model that the data support.
    """
    supported = found.supported
    assert supported is not None
    at = supported.names.index("slope")
    name = f"{test}.slope correction"
    components = tuple(
        Component(one.name, Normal(u / slope), one.dof or inf, "A", said("diagnosis of the test"))
        for one in supported.sources
        if one.kind in ("effects", "inadequacy", "models") and (u := sum(x * x for x in one.columns[at]) ** 0.5) > 0
    )
    what = said("relative correction of the slope for the effects that were found")
    correction = Input(name, supported.values[at] / slope - 1.0, components, "1", what)
    several = any(one.name.startswith(f"{test}.") and one.name.count(".") > test.count(".") + 1
                  and one.name.endswith(".EA") for one in stated.measurands)  # fmt: skip
    concerned = {f"{test}.{one}" for one in (RESULTS if several else RESULTS[:1])}
    measurands = tuple(_divided(one, name) if one.name in concerned else one for one in stated.measurands)
    return Contribution((*stated.inputs, correction), stated.ensembles, stated.correlations, measurands)


def _divided(one: Measurand, correction: str) -> Measurand:
    function: Callable[[Mapping[str, Any]], Any] = one.function
    return replace(
        one,
        function=lambda n: function(n) / (1 + n[correction]),
        equation=said("{equation}, less δ", equation=one.equation),
    )
