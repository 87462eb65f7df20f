"""Calibration lines and curves of a campaign: fitted, handed on as inputs, and shown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology import units
from metrology.chain import independence, points
from metrology.chain.axes import axis_unit, parameter_units, point_covariance, scatter_of, values_of
from metrology.chain.extrapolation import beyond
from metrology.chain.knowledge import value_of
from metrology.chain.plan import Identity, Plan, Suspect
from metrology.errors import faults_at
from metrology.expression import Expression
from metrology.findings import Fit as FitFinding
from metrology.gum import fit as gum_fit
from metrology.gum.curve import curve
from metrology.gum.curve_both import curve_both
from metrology.gum.evaluation import Measurand
from metrology.gum.fit import LINE
from metrology.gum.inputs import Input
from metrology.gum.inversion import crossing, equation, fieller
from metrology.gum.points import REFUTED
from metrology.gum.readings import mean, type_a
from metrology.gum.regression import line
from metrology.gum.rounding import readable, tolerance
from metrology.message import said
from metrology.method.instruments import fitted_curve

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.fits import Fit, Prediction
    from metrology.gum.fit import Regression

_CURVE_POINTS = 101


def add_fits(plan: Plan, campaign: Campaign) -> None:
    """Fit everything; the parameters become inputs with their joint covariance, the predictions results."""
    for name, stated in campaign.fits.items():
        with faults_at(campaign.at("fits", name)):
            _add_fit(plan, campaign, name, stated)


def _add_fit(plan: Plan, campaign: Campaign, name: str, stated: Fit) -> None:
    x, y = values_of(campaign, name, stated.x), values_of(campaign, name, stated.y)
    origin = stated.origin.si if stated.origin else 0.0
    regression = _weighed(_regression(campaign, name, stated, x - origin, y), stated)
    found = _finding(name, stated, regression, origin, parameter_units(stated))
    plan.fits.append(found)
    if not found.u:
        plan.failed_fits[name] = found.sentence
    if not regression.converged:
        plan.failures.append(said("fit {name}: {sentence:quoted}", name=name, sentence=regression.sentence))
        return
    known = gum_fit.knowledge(regression, name, parameter_units(stated))
    plan.add_inputs(known.inputs.values())
    plan.ensembles.extend(known.ensembles)
    plan.correlate(known.correlations)
    plan.redrawn.extend(known.redrawn)
    _suspect(plan, campaign, name, regression)
    _add_results(plan, campaign, name, regression)


def _suspect(plan: Plan, campaign: Campaign, name: str, regression: Regression) -> None:
    """Note what forbids that the parameters are judged: points that are copies, or do not follow the model.

    Uncertainties that are stated count as independent of one another, unless a correlation is stated too.
    """
    stated = campaign.fits[name]
    found: tuple[str, ...] = ()
    if not regression.u.any():
        found = (said("the points do not scatter, and no uncertainty of them is stated"),)
    elif stated.correlation is None:
        x = np.asarray(regression.x) + (stated.origin.si if stated.origin else 0.0)
        data = x, regression.y, regression.residuals
        design = regression.basis.gradient(np.asarray(regression.x), regression.basis.values)
        found = tuple(points.points(*data, design, _of_points(campaign, name, stated, regression)))
        if regression.p_value is None:
            found += tuple(points.scattered(*data, design, _si_units(stated)))
    if found:
        one = Suspect(said("{name}: {found}.", name=name, found=found), stated.accepted)
        plan.suspect |= {f"{name}.{parameter}": (one,) for parameter in regression.names}


def _of_points(campaign: Campaign, name: str, stated: Fit, regression: Regression) -> Any:
    """Standard uncertainty of each point in y, with that in x by the slope there; ones where none is stated."""
    x, count = np.asarray(regression.x), len(regression.x)
    u_x, u_y = (scatter_of(campaign, name, scatter, count) for scatter in (stated.u_x, stated.u_y))
    if u_x is None:
        return np.ones(count) if u_y is None else u_y
    step = 1e-6 * float(np.ptp(x))
    low, high = (regression.basis.function(x + sign * step, regression.basis.values) for sign in (-1, 1))
    return np.hypot((high - low) / (2 * step) * u_x, 0.0 if u_y is None else u_y)


def _regression(campaign: Campaign, name: str, stated: Fit, x: Any, y: Any) -> Regression:
    u_x, u_y = (scatter_of(campaign, name, scatter, len(y)) for scatter in (stated.u_x, stated.u_y))
    expression = stated.model.expression
    given = point_covariance(stated.correlation, u_x, u_y)
    if expression is None:
        regression = line(x, y, **(given or {"u_x": u_x, "u_y": u_y}))
        return replace(regression, names=stated.parameters)
    start = {parameter: value.si for parameter, value in stated.model.start.items()}
    model = Expression.parse(expression)
    if u_x is not None:
        return curve_both(model, x, y, start=start, u_x=u_x, u_y=u_y)
    return curve(model, x, y, start=start, **(given or {"u_y": u_y}))


def _weighed(regression: Regression, stated: Fit) -> Regression:
    """Covariance of the parameters in the way that the file asks for."""
    if stated.covariance == "iso28037" and regression.converged:
        regression = gum_fit.by_information(regression)
    if regression.p_value is None or regression.p_value >= REFUTED or not regression.converged:
        return regression
    if stated.scatter == "stated":
        text = "{sentence} The stated uncertainties are kept all the same, as the file asks."
        return replace(regression, sentence=said(text, sentence=regression.sentence))
    wider = gum_fit.scaled(regression)
    text = "{sentence} The uncertainties of the parameters are multiplied by √(χ²/ν) = {s:.3g}."
    return replace(wider, s=None, sentence=said(text, sentence=regression.sentence, s=float(wider.s or 0.0)))


def _add_results(plan: Plan, campaign: Campaign, name: str, regression: Regression) -> None:
    """Add the parameters and the predictions as results."""
    stated = campaign.fits[name]
    for parameter, unit in zip(stated.parameters, parameter_units(stated), strict=True):
        measurand = Measurand(
            f"{name}.result.{parameter}", value_of(f"{name}.{parameter}"), unit, said("least squares")
        )
        plan.add_measurand(measurand, Identity(parameter, "derived", test=name, display_unit=unit, headline=False))
    origin = stated.origin.si if stated.origin else 0.0
    function = fitted_curve(name, stated.model.expression, stated.parameters, origin=origin)
    for point in stated.predict:
        full = f"{name}.{point.name}"
        given = _given(point, f"{full}.at", said("place for which {name} is predicted", name=full))
        plan.add_inputs([given])
        if point.x is not None:
            axis, equation, solve = stated.y, said("value of the fit"), _value(function, given.name)
        else:
            text = "x at which the line takes y" if stated.model.is_line else "x at which the curve takes y"
            axis, equation = stated.x, said(text)
            solve = _inverse(function, stated, regression, given)
            plan.warnings.extend(_lopsided(campaign, full, regression, given))
        unit = axis_unit(axis)
        measurand = Measurand(full, solve, units.si_unit(unit), equation)
        plan.add_measurand(measurand, Identity(point.name, "derived", test=name, display_unit=unit))
        used = given.value if point.x is not None else plan.estimates().get(full, nan)
        sentences = list(beyond(full, np.asarray(regression.x) + origin, units.si_unit(axis_unit(stated.x)), used))
        wrong = tuple(independence.faults(_new_readings(point))) if point.readings else ()
        sentences += [said("{name}: {found}.", name=given.name, found=wrong)] if wrong else []
        if point.x is None:
            sentences += _unbounded(campaign, full, regression, given)
        plan.suspect[full] = tuple(Suspect(sentence, stated.accepted) for sentence in sentences)


def _given(point: Prediction, key: str, description: str) -> Input:
    """Return the x or the y at which the fit is used, as an input."""
    if point.readings is None:
        stated = point.x or point.y
        assert stated is not None
        return stated.input(key, description)
    values = _new_readings(point)
    scatter = type_a(said("repeatability"), values, source=said("{count} new readings", count=len(values)))
    return Input(key, mean(values), (scatter,), units.si_unit(point.unit), description, is_stated=True)


def _new_readings(point: Prediction) -> list[float]:
    return [units.unit(point.unit).in_si(value) for value in point.readings or ()]


def _value(function: Any, key: str) -> Any:
    return lambda ns: function(ns, ns[key])


def _inverse(function: Any, stated: Fit, regression: Regression, given: Input) -> Any:
    name = given.name.partition(".")[0]
    if not stated.model.is_line:
        x0 = crossing(regression, given.value, given.name, _si_units(stated))
        members = tuple(f"{name}.{parameter}" for parameter in stated.parameters)
        return equation(function, given.name, members, x0, float(np.ptp(regression.x)))
    origin = stated.origin.si if stated.origin else 0.0
    return lambda ns: origin + (ns[given.name] - ns[f"{name}.intercept"]) / ns[f"{name}.slope"]


def _si_units(stated: Fit) -> tuple[str, str]:
    """SI units of x and y."""
    return units.si_unit(axis_unit(stated.x)), units.si_unit(axis_unit(stated.y))


def _unbounded(campaign: Campaign, full: str, regression: Regression, given: Input) -> Iterator[str]:
    """Say where a slope is not significant: x may be anything then, and no draws or degrees of freedom bound it."""
    p = campaign.coverage_probability
    if regression.model == LINE and fieller(regression, given, p) is None:
        yield said(
            "{name}: the slope of the line is not significant, |b| ≤ t·u(b), so that y does not determine x: the "
            "{percent:g} % interval of Fieller has no end, and no other is to be trusted.",
            name=full,
            percent=100 * p,
        )


def _lopsided(campaign: Campaign, full: str, regression: Regression, given: Input) -> Iterator[str]:
    """Notice where a slope is known so little that the interval of x is not symmetric."""
    p, stated = campaign.coverage_probability, campaign.fits[full.split(".")[0]]
    found = fieller(regression, given, p) if regression.model == LINE else None
    if found is None:
        return
    x = (given.value - float(regression.values[0])) / float(regression.values[1])
    below, above = x - found[0], found[1] - x
    if min(below, above) > 0 and abs(above - below) > tolerance((above + below) / 4, 1):
        origin, unit = stated.origin.si if stated.origin else 0.0, units.si_unit(axis_unit(stated.x))
        low, high = (readable(end + origin, unit, 3) for end in found)
        yield said(
            "{name}: the slope is known so little that the {percent:g} % interval is not symmetric; by Fieller: "
            "{low:figures} to {high:figures}.",
            name=full,
            percent=100 * p,
            low=low,
            high=high,
        )


def _finding(
    name: str, stated: Fit, regression: Regression, origin: float, parameter_unit: tuple[str, ...]
) -> FitFinding:
    x = np.asarray(regression.x) + origin
    curve_x = np.linspace(x.min(), x.max(), _CURVE_POINTS)
    drawn = gum_fit.predict(regression, curve_x - origin) if regression.converged else None
    return FitFinding(
        name=name,
        model=regression.model,
        parameters=regression.names,
        values=_floats(regression.values),
        u=_floats(regression.u) if regression.converged else (),
        units=parameter_unit,
        correlation=tuple(_floats(row) for row in regression.correlation) if regression.converged else (),
        dof=regression.dof if isfinite(regression.dof) else None,
        residual_standard_deviation=regression.s,
        chi_squared=regression.chi_squared,
        p_value=regression.p_value,
        sentence=regression.sentence,
        x=_floats(x),
        y=_floats(regression.y),
        x_unit=units.si_unit(axis_unit(stated.x)),
        y_unit=units.si_unit(axis_unit(stated.y)),
        curve_x=_floats(curve_x),
        curve_y=_floats(drawn.value) if drawn else (),
        curve_u=_floats(drawn.u) if drawn else (),
    )


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(np.asarray(values, dtype=float).tolist())
