"""Control chart of a check standard: whether the measurement stays the same, campaign after campaign."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from datetime import date
from itertools import pairwise
from math import isfinite, sqrt
from statistics import fmean, median, stdev

from metrology.export.collect import Row
from metrology.gum.rounding import significant
from metrology.judged import is_on

LEAST = 4
"""Points below which there is no chart: limits from fewer would be guesses."""
_RANGE = 1.1283791670955126
"""d₂ of two readings, 2/√π: a moving range is that many standard deviations in the mean (ISO 7870-2)."""
_YEAR = 365.25
_BEYOND = 0.00135
"""Probability beyond an action limit on one side: that of three standard deviations of a normal distribution."""
_MAD = 1.4826
"""Standard deviations of a normal distribution in its median absolute deviation."""
_WEIGHT = 0.37
"""Degrees of freedom, for each of the values less one, that a standard deviation by that has."""


@dataclass(frozen=True)
class Point:
    """One result of the check standard."""

    date: date
    value: float
    u: float
    report: str


@dataclass(frozen=True)
class Drift:
    """Slope of the line through the points, a year, with standard uncertainty and degrees of freedom."""

    slope: float
    u: float
    dof: float
    significant: bool


@dataclass(frozen=True)
class Chart:
    """A chart of individual values: warning limits at mean ± 2·s, action limits at mean ± 3·s.

    `s` comes from the moving ranges, which a drift does not widen. `in_control` is None where there are too few points.
    `left_out`: results that are no point of it, each with the reason.
    """

    name: str
    unit: str
    points: tuple[Point, ...]
    mean: float
    s: float
    warning: tuple[float, float]
    action: tuple[float, float]
    drift: Drift | None
    in_control: bool | None
    sentence: str
    left_out: tuple[str, ...] = ()


def chart(rows: tuple[Row, ...], name: str) -> Chart:
    """Return the control chart of the result `name`, such as ``check-wire.k``, over all campaigns that have it.

    Notes
    -----
    ISO 7870-2 (individuals and moving ranges). Out of control: a point beyond an action limit, two of three successive
    ones beyond the same warning limit, or a drift that is not zero by a two-sided t test at 5 %. A point that lies far
    off widens the limits that should show it, so each is also held against mean and standard deviation of the others,
    and against their median and median absolute deviation. A result that its own report does not judge is no point, nor
    is one without a date or a value, one of a report that another one replaces, or one that is there twice.
    """
    there = [row for row in rows if is_on(name, row.name)]
    reasons_by_row = [(row, _why_not(row) or _why_not_beside(row, there)) for row in there]
    found = [row for row, why in reasons_by_row if not why]
    left_out = tuple(f"{row.report or row.file}: {why}" for row, why in reasons_by_row if why)
    points = tuple(Point(date.fromisoformat(row.date), row.value, row.u, row.report) for row in found)
    values = [point.value for point in points]
    mean = sum(values) / len(values) if values else float("nan")
    ranges = [abs(b - a) for a, b in pairwise(values)]
    s = sum(ranges) / len(ranges) / _RANGE if ranges else float("nan")
    warning, action = ((mean - k * s, mean + k * s) for k in (2, 3))
    drift = _drift(points) if len(points) >= LEAST else None
    reasons = _reasons(points, (warning, action), drift) if len(points) >= LEAST else ()
    in_control = None if len(points) < LEAST else not reasons
    unit = found[0].unit if found else "1"
    sentence = _sentence(f"{name} / {unit}", points, s=s, drift=drift, reasons=reasons)
    if made := sum(row.reconstructed for row in found):
        sentence += f" Reconstructed, not measured: {made} of them."
    if left_out:
        sentence += f" Left out: {'; '.join(left_out)}."
    return Chart(name, unit, points, mean, s, warning, action, drift, in_control, sentence, left_out)


def _why_not(row: Row) -> str:
    """Why a result is no point of a chart; empty where it is one."""
    if not (isfinite(row.value) and isfinite(row.u)):
        return "it has no value with an uncertainty"
    if row.doubts:
        return f"its report does not judge it ({row.doubts.rstrip('.')})"
    return "" if row.date else "it has no date"


def _why_not_beside(row: Row, there: list[Row]) -> str:
    """Why a result is no point beside the others of its name; empty where it is one."""
    for other in there:
        if row.report and row.report == other.replaces:
            return f"{other.report or other.file} replaces its report"
    first = next((one for one in there if replace(one, file=row.file) == row), row)
    if first is not row:
        return f"it stands in {first.file} too"
    # A check standard is one item: what another one is cannot drift.
    (sample, _), *_ = Counter(one.sample for one in there).most_common()
    if row.sample != sample:
        return f"it is of {row.sample or 'no sample'}, not of {sample or 'no sample'}"
    unit = next(one.unit for one in there)
    return "" if row.unit == unit else f"it is in {row.unit}, not in {unit}"


def _far(points: tuple[Point, ...], at: int) -> bool:
    """Whether a point lies beyond the action limits that the others set, by mean or by median.

    By their mean and standard deviation it is Student's t of the point left out (Grubbs; ISO 5725-2, 7.3.4), which a
    single one cannot hide from; a second one far off widens that, and the median absolute deviation does not notice.
    """
    from scipy.special import stdtrit

    others = [point for index, point in enumerate(points) if index != at]
    values = [point.value for point in others]
    apart, slack = abs(points[at].value - fmean(values)), 1e-9 * abs(fmean(values))
    limit = -float(stdtrit(len(others) - 1, _BEYOND)) * sqrt(1 + 1 / len(others))
    if 0 < limit * stdev(values) < apart - slack:
        return True
    middle = median(point.value for point in others)
    s = _MAD * median(abs(point.value - middle) for point in others)
    if s == 0:
        s = sqrt(sum(point.u**2 for point in others) / len(others))
    factor = -float(stdtrit(max(1.0, _WEIGHT * (len(others) - 1)), _BEYOND)) * sqrt(1 + 1 / len(others))
    return abs(points[at].value - middle) > factor * s + 1e-9 * abs(middle)


def _drift(points: tuple[Point, ...]) -> Drift | None:
    """Slope by ordinary least squares, its uncertainty from the scatter about the line."""
    from metrology.gum import coverage_factor
    from metrology.gum.regression import line

    days = [float((point.date - points[0].date).days) for point in points]
    values = [point.value for point in points]
    if len(set(days)) < 2 or len(set(values)) < 2:
        return None
    middle = sum(values) / len(values)
    fit = line(days, [value - middle for value in values])
    slope, u = float(fit.values[1]) * _YEAR, float(fit.u[1]) * _YEAR
    return Drift(slope, u, fit.dof, abs(slope) > coverage_factor(0.95, fit.dof) * u)


def _reasons(
    points: tuple[Point, ...], limits: tuple[tuple[float, float], tuple[float, float]], drift: Drift | None
) -> tuple[str, ...]:
    (low, high), (least, most) = limits
    found = [f"{p.report or p.date} is beyond an action limit" for p in points if not least <= p.value <= most]
    found += [
        f"{p.report or p.date} is far from all others"
        for at, p in enumerate(points)
        if least <= p.value <= most and _far(points, at)
    ]
    sides = [-1 if p.value < low else 1 if p.value > high else 0 for p in points]
    for i in range(len(sides) - 2):
        if max(sides[i : i + 3].count(1), sides[i : i + 3].count(-1)) >= 2:
            found.append(f"two of three from {points[i].report or points[i].date} on are beyond a warning limit")
            break
    if drift is not None and drift.significant:
        found.append("it drifts")
    return tuple(found)


def _sentence(label: str, points: tuple[Point, ...], *, s: float, drift: Drift | None, reasons: tuple[str, ...]) -> str:
    name, _, unit = label.partition(" / ")
    if len(points) < LEAST:
        return f"{name}: {len(points)} results; a chart needs {LEAST}."
    verdict = f"is not in control: {'; '.join(reasons)}" if reasons else "is in control"
    u = sqrt(sum(point.u**2 for point in points) / len(points))
    scatter = f" It scatters by {s / u:.2g} times its stated standard uncertainty." if u > 0 else ""
    return f"{name} {verdict}; {len(points)} results.{_trend(drift, unit)}{scatter}"


def _trend(drift: Drift | None, unit: str) -> str:
    if drift is None:
        return ""
    slope, u = significant(drift.slope, drift.u)
    return f" Drift ({slope} ± {u}) {'' if unit == '1' else unit} a year (standard uncertainty, ν = {drift.dof:g})."
