"""What must hold within each fit of a campaign: enough points of one dimension, and a model that fits them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology import units
from metrology.campaign.names import axis_dimension
from metrology.declaration.entry import Refusal, from_text, mean
from metrology.declaration.fits import Axis, Fit, PointCorrelation, Prediction, Scatter
from metrology.expression import RESERVED, Expression
from metrology.units.dimensions import Dimension, TextError, quoted

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign

_SINGULAR = 1e-12


def check_fits(campaign: Campaign) -> list[Refusal]:
    """Everything that is wrong within the fits, with places from the root of the file."""
    found = []
    for name, fit in campaign.fits.items():
        judged = [*_axes(fit), *_scatters(fit), *_model(fit), *_points(campaign, name, fit), *_predictions(fit)]
        found += [
            Refusal(("fits", name, *refusal.loc), refusal.got, refusal.expected, refusal.fix) for refusal in judged
        ]
    return found


def _axes(fit: Fit) -> Iterator[Refusal]:
    for key, axis in (("x", fit.x), ("y", fit.y), ("u_x", fit.u_x), ("u_y", fit.u_y)):
        try:
            units.unit(axis.unit if axis is not None else "1")
        except TextError as error:
            yield from_text(error, key, "unit")


def _scatters(fit: Fit) -> Iterator[Refusal]:
    for key, scatter, axis in (("u_x", fit.u_x, fit.x), ("u_y", fit.u_y, fit.y)):
        if scatter is None:
            continue
        due, got = axis_dimension(axis), scatter_dimension(scatter)
        if due is not None and got is not None and got != due:
            yield Refusal((key,), f"'{key}', {got.name}", f"{due.name}, as the axis")
        if scatter.value is not None and scatter.value.si <= 0:
            yield Refusal((key, "value"), quoted(scatter.value.value), "an uncertainty greater than zero")
        if scatter.values is not None and min(scatter.values, default=1.0) <= 0:
            yield Refusal((key, "values"), f"{min(scatter.values):g}", "uncertainties greater than zero")


def scatter_dimension(scatter: Scatter) -> Dimension | None:
    """Dimension of the uncertainty of an axis."""
    return scatter.value.dimension if scatter.value is not None else axis_dimension(scatter)


def _model(fit: Fit) -> Iterator[Refusal]:
    if fit.covariance == "iso28037" and fit.u_x is None:
        yield Refusal(("covariance",), "'covariance: iso28037' without 'u_x'", "errors in x and y")
    if fit.model.expression is None:
        return
    yield from _both_axes(fit)
    if fit.origin is not None:
        yield Refusal(("origin",), "'origin' with an expression", "'origin' with 'model: line' only")
    for name in fit.model.start:
        if name in RESERVED or name == "x":
            yield Refusal(("model", "start", name), quoted(name), "a name that is neither x nor a function or constant")
    try:
        expression = Expression.parse(fit.model.expression)
        known = {"x", *fit.model.start}
        for name in sorted(expression.names - known):
            near = mean(name, sorted(known)) or "give its start value under 'start'"
            yield Refusal(
                ("model", "expression"), f"'{name}', an unknown name", "x and the parameters of 'start'", near
            )
        for name in sorted(known - expression.names):
            yield Refusal(
                ("model", "expression"), f"an expression without '{name}'", "x and every parameter of 'start'"
            )
        yield from _dimensions(fit, expression)
    except TextError as error:
        yield from_text(error, "model", "expression")


def _both_axes(fit: Fit) -> Iterator[Refusal]:
    """What a curve with errors in x cannot have."""
    if fit.u_x is not None and fit.u_y is None:
        yield Refusal(("u_x",), "'u_x' with an expression, without 'u_y'", "the uncertainty of y as well", of_key=True)
    if fit.u_x is not None and fit.correlation is not None:
        got = "'correlation' with 'u_x' and an expression"
        yield Refusal(("correlation",), got, "'correlation' of both axes with 'model: line' only")


def _dimensions(fit: Fit, expression: Expression) -> Iterator[Refusal]:
    x, y = axis_dimension(fit.x), axis_dimension(fit.y)
    if x is None or y is None or expression.names != {"x", *fit.model.start}:
        return
    got = expression.dimension({"x": x} | {name: start.dimension for name, start in fit.model.start.items()})
    if got != y:
        yield Refusal(("model", "expression"), f"an expression that gives {got.name}", f"{y.name}, as y")


def _points(campaign: Campaign, name: str, fit: Fit) -> Iterator[Refusal]:
    lengths = {key: length for key, axis in _named_axes(fit) if (length := _length(campaign, name, axis)) is not None}
    if len(set(lengths.values())) > 1:
        got = ", ".join(f"{length} values of {key}" for key, length in lengths.items())
        yield Refusal((), got, "as many values of each")
        return
    if "x" not in lengths:
        return
    count, needed = lengths["x"], len(fit.parameters) + (fit.u_y is None)
    if count < needed:
        plenty = f"at least {needed} points for {len(fit.parameters)} parameters"
        yield Refusal(("x",), f"{count} points", plenty + (" and their scatter" if fit.u_y is None else ""))
    elif len(set(values_of(campaign, name, fit.x))) < len(fit.parameters):
        yield Refusal(("x",), "values of x that are the same", f"at least {len(fit.parameters)} different ones")
    yield from _correlation(fit, count)


def _named_axes(fit: Fit) -> Iterator[tuple[str, Axis]]:
    for key, axis in (("x", fit.x), ("y", fit.y), ("u_x", fit.u_x), ("u_y", fit.u_y)):
        if axis is not None:
            yield key, axis


def _length(campaign: Campaign, name: str, axis: Axis) -> int | None:
    if axis.values is not None:
        return len(axis.values)
    tables = campaign.tables.get(("fits", name))
    return len(tables[0]) if axis.column is not None and tables else None


def values_of(campaign: Campaign, name: str, axis: Axis) -> tuple[float, ...]:
    """Values of an axis of the fit `name` in SI, wherever they are written; one for a scatter common to all points."""
    if axis.column is not None:
        return tuple(float(value) for value in campaign.tables["fits", name][0].numbers[axis.column])
    if isinstance(axis, Scatter) and axis.value is not None:
        return (axis.value.si,)
    unit, difference = units.unit(axis.unit), isinstance(axis, Scatter)
    return tuple(unit.in_si(value, difference=difference) for value in axis.values or ())


def _predictions(fit: Fit) -> Iterator[Refusal]:
    x, y = axis_dimension(fit.x), axis_dimension(fit.y)
    if fit.origin is not None and x is not None and fit.origin.dimension != x:
        yield Refusal(("origin",), quoted(fit.origin.value), f"{x.name}, as x")
    for index, point in enumerate(fit.predict):
        yield from _new_readings(point, y, ("predict", index, "unit"))
        given, due = (point.x, x) if point.x is not None else (point.y, y)
        if given is not None and due is not None and given.dimension != due:
            key = "x" if point.x is not None else "y"
            yield Refusal(("predict", index, key), f"'{given.value}', {given.dimension.name}", f"{due.name}, as {key}")


def _new_readings(point: Prediction, due: Dimension | None, place: tuple[str | int, ...]) -> Iterator[Refusal]:
    if point.readings is None:
        return
    try:
        got = units.dimension(point.unit)
    except TextError as error:
        yield from_text(error, *place)
        return
    if due is not None and got != due:
        yield Refusal(place, f"'{point.unit}', {got.name}", f"{due.name}, as y")


def _correlation(fit: Fit, count: int) -> Iterator[Refusal]:
    if fit.correlation is None:
        return
    found = list(_shapes(fit, fit.correlation, count))
    yield from found
    if found:
        return
    matrices = {key: _matrix(getattr(fit.correlation, key), count) for key in ("x", "y")}
    wrong = [key for key, matrix in matrices.items() if not _definite(matrix)]
    yield from (Refusal(("correlation", key), *_IMPOSSIBLE) for key in wrong)
    if not wrong and fit.correlation.xy is not None:
        between = np.diag(np.broadcast_to(np.asarray(fit.correlation.xy, dtype=float), count))
        if not _definite(np.block([[matrices["x"], between], [between, matrices["y"]]])):
            yield Refusal(("correlation",), *_IMPOSSIBLE)


_IMPOSSIBLE = ("coefficients that no points can have together", "a positive definite correlation matrix")


def _shapes(fit: Fit, stated: PointCorrelation, count: int) -> Iterator[Refusal]:
    """What is wrong with coefficients before they are judged together."""
    for key in ("x", "y"):
        given, place = getattr(stated, key), ("correlation", key)
        if given is None:
            continue
        if getattr(fit, f"u_{key}") is None:
            yield Refusal(place, f"a correlation of {key} without 'u_{key}'", f"'u_{key}' too")
        if not isinstance(given, float) and _widths(given) != [count] * count:
            yield Refusal(place, f"a matrix of {len(given)} rows", f"a square one of {count} points")
            continue
        matrix = _matrix(given, count)
        if not np.array_equal(matrix, matrix.T) or not (np.diag(matrix) == 1).all():
            yield Refusal(place, "a matrix that is not symmetric with ones in its diagonal", "a correlation matrix")
    if stated.xy is not None and (fit.u_x is None or fit.u_y is None):
        yield Refusal(("correlation", "xy"), "a correlation of x and y without the uncertainty of both", "'u_x', 'u_y'")
    if isinstance(stated.xy, tuple) and _widths(stated.xy) != [0] * count:
        got = f"{len(stated.xy)} coefficients"
        yield Refusal(("correlation", "xy"), got, f"one, or one for each of {count} points")


def _widths(rows: tuple[Any, ...]) -> list[int]:
    """Lengths of the rows of a matrix; zero for a number."""
    return [len(row) if isinstance(row, tuple) else 0 for row in rows]


def _matrix(stated: Any, count: int) -> Any:
    """Correlation matrix of one axis: independent points, one coefficient for all pairs, or as stated."""
    if stated is None or isinstance(stated, float):
        matrix = np.full((count, count), stated or 0.0)
        np.fill_diagonal(matrix, 1.0)
        return matrix
    return np.array(stated)


def _definite(matrix: Any) -> bool:
    """Whether a fit can be weighted by the inverse of the matrix."""
    return bool(np.linalg.eigvalsh(matrix)[0] > _SINGULAR * max(1.0, 0.1 * len(matrix)))
