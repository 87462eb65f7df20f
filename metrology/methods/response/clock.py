"""Rate of the clock by which all records of a response test are stamped, as an uncertain input of its results."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import hypot, sqrt
from typing import TYPE_CHECKING, Any

from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution
from metrology.gum.inputs import Component, Input
from metrology.message import said
from metrology.method.clock import RATE, held

if TYPE_CHECKING:
    import numpy as np

    from metrology.estimation import Identification, Prior
    from metrology.method.model import HeldParameter

    Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

MASS = "mass.factor"
SCALED = {"c": 1, MASS: 2}
"""Results of a fit that are in its time, by the power of the true time over that: m·x″ + c·x′ + k·x = F."""


def with_rate(priors: Sequence[Prior], u: float) -> tuple[Prior, ...]:
    """Return priors of a fit in the time of the clock: where a second lasts 1 + δ, a mass acts there as m/(1 + δ)²."""
    from metrology.estimation import Prior

    mass = next((one for one in priors if one.name == MASS), Prior(MASS))
    wider = replace(mass, common=hypot(mass.common, 2 * u), source=_with_clock(mass.source))
    return (*(one for one in priors if one.name != MASS), wider)


def _with_clock(source: str) -> str:
    return said("{source}; clock rate", source=source) if source else said("clock rate")


def parted(found: Contribution, test: str, u: float, source: str) -> Contribution:
    """Return what a fit with such priors contributes, with the rate of the clock as an input of its own.

    The mass that was stated keeps the rest of the uncertainty; k, c and the mass of the fit become those in true time.

    Parameters
    ----------
    found : Contribution
        With the input ``{test}.mass.factor.stated``, but where the fit seeks the mass.
    test : str
        First part of every name.
    u : float
        Relative standard uncertainty of the rate.
    source : str
        Where it comes from.
    """
    mass, rate = f"{test}.{MASS}.stated", f"{test}.clock rate"
    known = Component(said("stated"), Normal(u), source=source)
    inputs = [_rest(one, u) if one.name == mass else one for one in found.inputs]
    measurands = [
        replace(one, function=_in_true_time(one.function, mass, rate, SCALED.get(name, 0)))
        if (name := one.name.removeprefix(f"{test}.")) not in ("omega_n", "zeta")
        else one
        for one in found.measurands
    ]
    added = Input(rate, 0.0, (known,), "1", RATE)
    return replace(found, inputs=(*inputs, added), measurands=tuple(measurands))


def taken_as_exact(test: str, found: Identification, mass: Floats) -> HeldParameter:
    """The rate of the clock where nothing is stated of it, by what the mass of a fit does to its results.

    Parameters
    ----------
    test : str
        Name of the test.
    found : Identification
        With status 'ok', and no mass that is free.
    mass : ndarray, shape (p,)
        Derivative of what all runs share, in the order of ``found.joint.names``, by the share of the mass.
    """
    joint = found.joint
    values = dict(zip(joint.names, joint.values.tolist(), strict=True))
    slopes = {
        key: SCALED.get(key, 0) * values[key] - 2 * by_mass
        for key, by_mass in zip(joint.names, mass.tolist(), strict=True)
    }
    if (k := values.get("k", 0.0)) > 0:
        share = values.get(MASS, 1.0)
        slopes["omega_n"] = sqrt(k / (found.rig.m * share)) * (slopes["k"] / k - slopes.get(MASS, 0.0) / share) / 2
    return held(test, {f"{test}.{key}": slope for key, slope in slopes.items()})


def _rest(mass: Input, u: float) -> Input:
    (whole,) = mass.components
    left = whole.u**2 - (2 * u) ** 2
    if left <= 1e-12 * whole.u**2:
        return replace(mass, components=())
    source = whole.source.removesuffix("; clock rate")
    return replace(mass, components=(replace(whole, distribution=Normal(sqrt(left)), source=source),))


def _in_true_time(
    function: Callable[[Mapping[str, Any]], Any], mass: str, rate: str, power: int
) -> Callable[[Mapping[str, Any]], Any]:
    def moved(known: Mapping[str, Any]) -> Any:
        longer = known[rate]
        seen = ChainMap({mass: known[mass] - 2 * longer}, known) if mass in known else known  # type: ignore[arg-type]
        return function(seen) * (1 + longer) ** power

    return moved
