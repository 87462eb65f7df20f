"""Axes of a fit as the file states them: values, uncertainties and correlation of the points, units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from metrology import units

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.fits import Axis, Fit, PointCorrelation, Scatter


def point_covariance(stated: PointCorrelation | None, u_x: Any, u_y: Any) -> dict[str, Any]:
    """Return the covariance of the points: of y alone, or of x and y stacked; nothing where they are independent."""
    if stated is None or u_y is None:
        return {}
    within_y = _matrix(stated.y, len(u_y)) * np.outer(u_y, u_y)
    if u_x is None:
        return {"covariance": within_y}
    within_x = _matrix(stated.x, len(u_x)) * np.outer(u_x, u_x)
    between = np.diag(np.broadcast_to(np.asarray(stated.xy or 0.0, dtype=float), len(u_x)) * u_x * u_y)
    return {"covariance": np.block([[within_x, between], [between, within_y]])}


def _matrix(coefficient: float | tuple[tuple[float, ...], ...] | None, size: int) -> Any:
    if coefficient is None:
        return np.eye(size)
    if isinstance(coefficient, float | int):
        return np.full((size, size), coefficient) + (1 - coefficient) * np.eye(size)
    return np.asarray(coefficient, dtype=float)


def values_of(campaign: Campaign, name: str, axis: Axis, *, difference: bool = False) -> Any:
    """Return the values of an axis in SI."""
    if axis.column is not None:
        (table,) = campaign.tables["fits", name]
        return table.numbers[axis.column]
    unit = units.unit(axis.unit)
    return np.array([unit.in_si(value, difference=difference) for value in axis.values or ()])


def scatter_of(campaign: Campaign, name: str, scatter: Scatter | None, size: int) -> Any:
    """Return the standard uncertainty of each point along an axis, in SI; None where none is stated."""
    if scatter is None:
        return None
    if scatter.value is not None:
        return np.full(size, scatter.value.si)
    return values_of(campaign, name, scatter, difference=True)


def axis_unit(axis: Axis) -> str:
    """Return the unit in which an axis is written."""
    if axis.column is None:
        return axis.unit
    return axis.column.partition("/")[2].strip() or "1"


def parameter_units(stated: Fit) -> tuple[str, ...]:
    """Return the SI units of the parameters."""
    if not stated.model.is_line:
        return tuple(start.si_unit for start in stated.model.start.values())
    x, y = units.dimension(axis_unit(stated.x)), units.dimension(axis_unit(stated.y))
    return units.si_unit(axis_unit(stated.y)), units.si_unit(y / x)
