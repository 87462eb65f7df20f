"""Fits that are used beyond their data."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import TYPE_CHECKING, Any

from metrology.chain.doubt import Doubt, with_acceptance
from metrology.gum.rounding import readable
from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.gum.evaluation import Evaluation

FAR = 1.0
"""Ranges of x beyond its data at which a line is taken too far; at an intercept near to them it often is, and well."""
SLOPE = 1e6
"""Ranges from which on it is the slope that a result takes: of a difference of two indications the rest cancels."""


def beyond(full: str, x: Any, unit: str, used: float) -> Iterator[str]:
    """Say where a fit is used beyond its data: nothing there says that the model holds.

    Parameters
    ----------
    full : str
        Name of what is taken from the fit.
    x : array_like
        Where its data are, in `unit`; one on a scale with an offset, such as of temperature, in SI.
    unit : str
        SI unit of x.
    used : float
        Where the fit is used.
    """
    low, high = min(x), max(x)
    slack = 1e-9 * (high - low)
    if not isfinite(used) or low - slack <= used <= high + slack:
        return
    text = (
        "{name} is an extrapolation: the fit is used at {used:figures}, and its data reach from {low:figures} to "
        "{high:figures}. That the model holds there is an assumption, which u does not contain."
    )
    yield said(text, name=full, **_places(unit, used=used, low=low, high=high))


def _places(unit: str, **places: float) -> dict[str, str]:
    """Places along x in words; zero in the unit of the largest of them."""
    texts = {name: readable(float(x), unit, 4) for name, x in places.items()}
    largest = texts[max(places, key=lambda name: abs(places[name]))]
    return {name: texts[name] if x else f"0 {largest.partition(' ')[2]}".rstrip() for name, x in places.items()}


def extrapolated(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Iterator[tuple[str, Doubt]]:
    """Results that rest on a fitted line where it has no data, by name, with what forbids a verdict on them.

    A result that moves with intercept a and slope b of a line by ∂y/∂a and ∂y/∂b moves with the line at the x that is
    (∂y/∂b)/(∂y/∂a) from the origin: the intercept itself with the origin, a prediction with where it is made.
    """
    lines = {one.name: one for one in plan.fits if one.u and campaign.fits[one.name].model.is_line}
    for name, estimate in evaluation.estimates.items() if lines else ():
        slopes = {row.input: row.sensitivity for row in estimate.budget}
        for fit, line in lines.items():
            by_intercept, by_slope = (slopes.get(f"{fit}.{key}", 0.0) for key in ("intercept", "slope"))
            stated = campaign.fits[fit]
            # Of a prediction of the fit `beyond` has said it.
            if name in plan.suspect or not by_intercept or not isfinite(by_slope / by_intercept):
                continue
            at = (stated.origin.si if stated.origin else 0.0) + by_slope / by_intercept
            low, high = min(line.x), max(line.x)
            away = max(low - at, at - high) / (high - low)
            if FAR < away < SLOPE:
                text = (
                    "{name} takes the line {fit} at x = {at:figures}, where it has no data: they reach from "
                    "{low:figures} to {high:figures}."
                )
                sentence = said(text, name=name, fit=fit, **_places(line.x_unit, at=at, low=low, high=high))
                yield name, with_acceptance(Doubt("readings", sentence), stated.accepted)
