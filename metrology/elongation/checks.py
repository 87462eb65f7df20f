"""Checks of the readings against what the model of the line supposes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from metrology import raw
from metrology.check import Check
from metrology.elongation.line import Floats, Layout, Means, compare, slope
from metrology.elongation.test import Reading
from metrology.message import said

LINEARITY = "linearity (lack of fit)"
ZERO = "zero shift between repeats"
HYSTERESIS = "loading against unloading"
SCATTER = "stiffness between repeats"
OUTLIER = "outlier"


@dataclass(frozen=True)
class Evidence:
    """The readings in use with the fit to them, as every check takes them.

    Parameters
    ----------
    readings : tuple of Reading
        Those in use.
    values : ndarray, shape (n,)
        Corrected readings in m.
    layout : Layout
        Load and repeat of each.
    forces : ndarray, shape (L,)
        Force of each load in N.
    means : Means
        Fit of the means.
    declared : ndarray, shape (L,)
        Standard uncertainty in m of the mean at each load that is not repeatability: resolution, indicator, mass.
    significance : float
        Rate at which each check may fail on data with nothing wrong in them.
    resolution : float
        Smallest difference in m that the indicator shows, as stated.
    """

    readings: tuple[Reading, ...]
    values: Floats
    layout: Layout
    forces: Floats
    means: Means
    declared: Floats
    significance: float
    resolution: float

    @property
    def s(self) -> float:
        """Scatter of one reading, in m."""
        return sqrt(self.means.variance)

    @property
    def floor(self) -> float:
        """Scatter in m below which readings count as all the same."""
        return 1e-12 * float(np.abs(self.values).max() + 1e-6)

    def plain(self) -> Floats:
        """Columns of the model that the scatter is about with one zero for all: one mean a load, or the line."""
        if self.means.about_line:
            return self.layout.straight_columns(self.forces, zero_each=False)
        return self.layout.level_columns()


def run(evidence: Evidence) -> tuple[Check, ...]:
    """All checks, in the order in which the report shows them."""
    return tuple(check(evidence) for check in CHECKS)


def records(evidence: Evidence) -> Check:
    """Readings off the others at their load by more than all loads together stretch the sample: no slip is as large.

    By medians, first of each repeat, then of each load: a few wrong readings do not move them.
    """
    loads, repeats = evidence.layout.loads, evidence.layout.repeats
    left = evidence.values - _medians(evidence.values, repeats)
    level = _medians(left, loads)
    off = left - level - _medians(left - level, repeats)
    wrong = np.flatnonzero(np.abs(off) > np.ptp(level))
    step = raw.coarse(np.array([one.value for one in evidence.readings]), evidence.resolution)
    if not len(wrong) and not step:
        sentence = said("No reading is off all others, and none coarser than the resolution.")
        return Check(raw.NAME, None, None, True, sentence)
    both = (
        "Off their load by more than all loads together stretch the sample: readings in lines {lines:comma}; readings "
        "in steps of {step:.3g} µm, where {stated:.3g} µm is stated. Read again."
    )
    far = (
        "Off their load by more than all loads together stretch the sample: readings in lines {lines:comma}. Read "
        "again."
    )
    coarse = "Readings in steps of {step:.3g} µm, where {stated:.3g} µm is stated. Read again."
    lines = tuple(str(evidence.readings[at].line) for at in wrong.tolist())
    text = both if len(wrong) and step else far if len(wrong) else coarse
    sentence = said(text, lines=lines, step=1e6 * step, stated=1e6 * evidence.resolution)
    return Check(raw.NAME, float(bool(len(wrong))) + float(bool(step)), None, False, sentence, effects=())


def _medians(values: Floats, groups: np.ndarray[tuple[int, ...], np.dtype[np.intp]]) -> Floats:
    """For every reading the median of its group."""
    return np.array([np.median(values[groups == group]) for group in range(int(groups.max()) + 1)])[groups]


def linearity(evidence: Evidence) -> Check:
    """Lack of fit: whether the means leave the line by more than their scatter and the instruments explain.

    F = [(SS_line − SS_means)/(L − 2)] / s². A lack of fit passes where indicator, resolution and masses explain it:
    then rᵀ·V⁻¹·r/(L − 2), with V of repeatability and declared uncertainties together, is no large value of F.
    """
    if evidence.means.about_line:
        return _untested(LINEARITY, said("too few readings are repeated; what is not straight is part of the scatter"))
    straight = evidence.layout.straight_columns(evidence.forces, zero_each=evidence.means.zero_each)
    result = compare(evidence.values, straight, evidence.means.columns, floor=evidence.floor)
    away = 1e6 * float(np.abs(_deviation(evidence, evidence.means.cofactor)).max())
    if result.p_value is None:
        return _without_scatter(evidence, away)
    if result.p_value >= evidence.significance:
        sentence = said(
            "No lack of fit: largest deviation of a mean from the line {away:.2g} µm, within the scatter of the "
            "readings.",
            away=away,
        )
        return Check(LINEARITY, result.statistic, result.p_value, True, sentence)
    if _explained(evidence) >= evidence.significance:
        sentence = said(
            "The means leave the line by more than the readings scatter, but by no more than the indicator and the "
            "masses may err: largest deviation of a mean from the line {away:.2g} µm.",
            away=away,
        )
        return Check(LINEARITY, result.statistic, result.p_value, True, sentence)
    sentence = said(
        "Lack of fit: largest deviation of a mean from the line {away:.2g} µm, more than readings and instruments "
        "explain. The sample is not linear over these loads (or a load or the indicator is wrong): k is a mean over "
        "them; see k per load, and test a narrower range.",
        away=away,
    )
    return Check(LINEARITY, result.statistic, result.p_value, False, sentence)


def _without_scatter(evidence: Evidence, away: float) -> Check:
    """Lack of fit of readings that repeat exactly: χ² of the means against what is declared, resolution included."""
    from scipy.stats import chi2

    extra = len(evidence.forces) - 2
    if evidence.means.dof < 1 or extra < 1 or not evidence.declared.all():
        text = "the readings do not scatter; largest deviation of a mean from the line {away:.2g} µm"
        return _untested(LINEARITY, said(text, away=away))
    covariance = np.diag(evidence.declared**2)
    deviation = _deviation(evidence, covariance)
    statistic = float(deviation @ np.linalg.solve(covariance, deviation))
    p_value = float(chi2.sf(statistic, extra))
    if p_value >= evidence.significance:
        sentence = said(
            "The readings repeat exactly, and leave the line by no more than the indicator may err: largest deviation "
            "of a mean from the line {away:.2g} µm.",
            away=away,
        )
        return Check(LINEARITY, statistic / extra, p_value, True, sentence)
    sentence = said(
        "Lack of fit: largest deviation of a mean from the line {away:.2g} µm, more than the indicator explains, "
        "though the readings repeat exactly. It shows fewer digits than stated, or stood still (or the sample is not "
        "linear, or a load is wrong).",
        away=away,
    )
    return Check(LINEARITY, statistic / extra, p_value, False, sentence)


def _deviation(evidence: Evidence, covariance: Floats) -> Floats:
    """Means less the line through them, weighted by the inverse of their covariance."""
    columns = np.column_stack([np.ones_like(evidence.forces), evidence.forces / evidence.forces.max()])
    weight = np.linalg.inv(covariance)
    centred = evidence.means.values - evidence.means.values.mean()
    return np.asarray(centred - columns @ np.linalg.solve(columns.T @ weight @ columns, columns.T @ weight @ centred))


def _explained(evidence: Evidence) -> float:
    """Probability of deviations as large, given repeatability and declared uncertainties."""
    from scipy.stats import f

    covariance = evidence.means.variance * evidence.means.cofactor + np.diag(evidence.declared**2)
    deviation = _deviation(evidence, covariance)
    extra = len(evidence.forces) - 2
    return float(f.sf(deviation @ np.linalg.solve(covariance, deviation) / extra, extra, evidence.means.dof))


def zero_shift(evidence: Evidence) -> Check:
    """F test of one zero for all repeats against one zero each."""
    if not evidence.means.zero_each or len(evidence.means.shifts) < 2:
        reason = said("the repeats do not share loads, or there is only one; one zero serves all readings")
        return _untested(ZERO, reason)
    result = compare(evidence.values, evidence.plain(), evidence.means.columns, floor=evidence.floor)
    shift = 1e6 * float(np.ptp(evidence.means.shifts))
    if result.p_value is None:
        text = "the readings do not scatter; the zeros differ by up to {shift:.2g} µm, which the line allows for"
        return _untested(ZERO, said(text, shift=shift))
    if result.p_value >= evidence.significance:
        text = "No zero shift: the zeros differ by up to {shift:.2g} µm, within their scatter."
        return Check(ZERO, result.statistic, result.p_value, True, said(text, shift=shift))
    sentence = said(
        "The zero shifts between repeats by up to {shift:.2g} µm (clamp, creep or temperature). k is not touched by "
        "it, since the line gives each repeat a zero of its own.",
        shift=shift,
    )
    return Check(ZERO, result.statistic, result.p_value, False, sentence, covered=True)


def hysteresis(evidence: Evidence) -> Check:
    """Paired t test of the readings at the same load of the same repeat: unloading less loading."""
    from scipy.stats import t

    differences = _pairs(evidence)
    if len(differences) < 2:
        return _untested(HYSTERESIS, said("fewer than two loads were read both loading and unloading"))
    mean, count = float(differences.mean()), len(differences)
    u = float(differences.std(ddof=1)) / sqrt(count)
    what = said(
        "unloading less loading {mean:+.2g} µm on average over {count} pairs, standard uncertainty {u:.2g} µm",
        mean=1e6 * mean,
        count=count,
        u=1e6 * u,
    )
    if u <= evidence.floor:
        same = abs(mean) <= evidence.floor
        text = "No difference: {what}." if same else "The same difference in every pair: {what}."
        return Check(HYSTERESIS, None, None, same, said(text, what=what))
    statistic = mean / u
    p_value = float(2 * t.sf(abs(statistic), count - 1))
    if p_value >= evidence.significance:
        return Check(HYSTERESIS, statistic, p_value, True, said("No difference beyond scatter: {what}.", what=what))
    sentence = said(
        "Loading and unloading differ: {what}. Hysteresis, creep under load, or play; where every load is read both "
        "ways, the line goes midway.",
        what=what,
    )
    return Check(HYSTERESIS, statistic, p_value, False, sentence)


def _pairs(evidence: Evidence) -> Floats:
    values: dict[tuple[str, str], dict[str, list[float]]] = {}
    for reading, value in zip(evidence.readings, evidence.values.tolist(), strict=True):
        values.setdefault((reading.load, reading.repeat), {}).setdefault(reading.direction, []).append(value)
    both = (cell for cell in values.values() if len(cell) == 2)
    return np.array([np.mean(cell["unloading"]) - np.mean(cell["loading"]) for cell in both])


def between_repeats(evidence: Evidence) -> Check:
    """F test of one slope for all repeats against one each: whether k scatters by more than its readings do.

    A difference passes where the rounding to the resolution explains it: readings that scatter by less than half a
    division share their rounding within a load of a repeat, and the zero of each repeat shifts it.
    """
    forces = evidence.forces[evidence.layout.loads]
    slopes = evidence.layout.repeat_columns() * forces[:, None]
    if not evidence.means.zero_each or slopes.shape[1] == 0:
        return _untested(SCATTER, said("there are no repeats with a line each"))
    full = evidence.means.columns
    result = compare(evidence.values, full, np.hstack([full, slopes]), floor=evidence.floor)
    if result.p_value is None:
        return _untested(SCATTER, said("too few readings in a repeat, or no scatter"))
    if result.p_value >= evidence.significance:
        sentence = said("k of the repeats agrees within the scatter of the readings.")
        return Check(SCATTER, result.statistic, result.p_value, True, sentence)
    if _explained_by_rounding(evidence, slopes) >= evidence.significance:
        sentence = said(
            "k differs from repeat to repeat by more than the readings scatter, but by no more than their rounding to "
            "the resolution explains."
        )
        return Check(SCATTER, result.statistic, result.p_value, True, sentence)
    sentence = said(
        "k differs from repeat to repeat by more than the readings scatter: what changes between repeats (mounting, "
        "temperature, creep) is not in u(k), which is then too small. Find the cause, or take more repeats."
    )
    return Check(SCATTER, result.statistic, result.p_value, False, sentence)


def _explained_by_rounding(evidence: Evidence, slopes: Floats) -> float:
    """Probability of slopes that differ as much, given the scatter and a rounding in common to a load of a repeat."""
    from scipy.stats import f

    if not evidence.s < 0.5 * evidence.resolution:
        return 0.0
    full = np.linalg.svd(evidence.means.columns, full_matrices=False)[0]
    free = slopes / np.linalg.norm(slopes, axis=0)
    axes, sizes, _ = np.linalg.svd(free - full @ (full.T @ free), full_matrices=False)
    axes = axes[:, sizes > 1e-10 * sizes.max()]
    left = evidence.means.leftover - axes @ (axes.T @ evidence.means.leftover)
    extra, dof = axes.shape[1], evidence.means.dof - axes.shape[1]
    layout = evidence.layout
    cells = (layout.loads[:, None] == layout.loads) & (layout.repeats[:, None] == layout.repeats)
    covariance = float(left @ left) / dof * np.eye(extra) + evidence.resolution**2 / 12 * axes.T @ cells @ axes
    found = axes.T @ evidence.values
    return float(f.sf(found @ np.linalg.solve(covariance, found) / extra, extra, dof))


def outlier(evidence: Evidence) -> Check:
    """Largest studentised residual, with a Bonferroni limit for having looked at all; nothing is excluded by it.

    What the others scatter by is no less than their rounding: under a coarse division nearly all at a load are alike.
    Several readings that hide each other in the scatter are looked for together.
    """
    from scipy.stats import t

    means, count = evidence.means, len(evidence.values)
    if means.dof < 2 or evidence.s <= evidence.floor:
        return _untested(OUTLIER, said("too few readings, or no scatter"))
    spare = np.maximum(1 - means.leverage, 1e-9)
    rest = np.maximum((means.variance * means.dof - means.leftover**2 / spare) / (means.dof - 1), _least(evidence))
    ratios = np.where(means.leverage < 1 - 1e-6, means.leftover / np.sqrt(rest * spare), 0.0)
    worst = int(np.abs(ratios).argmax())
    statistic = float(ratios[worst])
    p_value = min(1.0, count * 2 * float(t.sf(abs(statistic), means.dof - 1)))
    reading = evidence.readings[worst]
    line = "load {load}, repeat {repeat}, {direction} (line {line})"
    text = line if reading.line else "load {load}, repeat {repeat}, {direction}"
    at = said(text, load=reading.load, repeat=reading.repeat, direction=reading.direction, line=reading.line)
    text = "{away:+.2g} µm from the line" if means.about_line else "{away:+.2g} µm from its mean"
    off = said(text, away=1e6 * float(means.leftover[worst]))
    if p_value < evidence.significance:
        sentence = said(
            "The reading at {reading} lies {off}, farther than chance explains. It is used: an exclusion needs a "
            "reason that does not rest on its value.",
            reading=at,
            off=off,
        )
        return Check(OUTLIER, statistic, p_value, False, sentence)
    several, chance, variance = _several(evidence)
    if chance < evidence.significance:
        sentence = said(
            "{count} readings (lines {lines:comma}) lie off the others, together farther than chance explains: the "
            "scatter without them would be {without:.2g} µm, not {s:.2g} µm. They are used: an exclusion needs a "
            "reason that does not rest on their values.",
            count=len(several),
            lines=tuple(str(evidence.readings[at].line) for at in several),
            without=1e6 * sqrt(variance),
            s=1e6 * evidence.s,
        )
        return Check(OUTLIER, statistic, chance, False, sentence)
    sentence = said("No outlier: the reading farthest out, {reading}, lies {off}.", reading=at, off=off)
    return Check(OUTLIER, statistic, p_value, True, sentence)


def _least(evidence: Evidence) -> float:
    """Least variance of one reading, in m²: that of its rounding."""
    return max(evidence.floor**2, evidence.resolution**2 / 12)


def _several(evidence: Evidence) -> tuple[list[int], float, float]:
    """Readings that together lie farthest off the others, two and more but fewer than half of ν.

    Also the chance of such a set, and the variance of one reading, in m², without it.

    The F test of a column for each reading of the set, times the number of sets of as many, times the numbers tried.
    """
    from scipy.special import comb
    from scipy.stats import f

    means, count = evidence.means, len(evidence.values)
    axes = np.linalg.svd(means.columns, full_matrices=False)
    basis = axes[0][:, axes[1] > 1e-10 * axes[1].max()]
    left, spare, whole = means.leftover.copy(), 1 - np.sum(basis**2, axis=1), means.variance * means.dof
    chosen: list[int] = []
    found, least, without = [], 1.0, means.variance
    most = (means.dof - 1) // 2
    for size in range(1, most + 1):
        ratios = np.where(spare > 1e-6, left**2 / np.maximum(spare, 1e-6), 0.0)
        chosen.append(int(ratios.argmax()))
        column = -basis @ basis[chosen[-1]]
        column[chosen[-1]] += 1.0
        column /= np.linalg.norm(column)
        left = left - column * (column @ left)
        basis, spare = np.column_stack([basis, column]), spare - column**2
        if size < 2:
            continue
        variance = float(left @ left) / (means.dof - size)
        rest = max(variance, _least(evidence))
        F = (whole - float(left @ left)) / size / rest
        chance = float(f.sf(F, size, means.dof - size)) * float(comb(count, size)) * (most - 1)
        if chance < least:
            found, least, without = sorted(chosen), chance, variance
    return found, least, without


def _untested(name: str, reason: str) -> Check:
    return Check(name, None, None, None, said("Not tested: {reason}.", reason=reason))


CHECKS = (linearity, zero_shift, hysteresis, between_repeats, outlier, records)
"""Every check of the method; each holds its rate of false alarms on normal readings without a fault, or less."""


def runs(evidence: Evidence) -> Sequence[tuple[str, str, float, float, float]]:
    """Repeat, direction, stiffness with its u, and zero shift of each run that holds at least two loads."""
    forces, b = evidence.forces[evidence.layout.loads], slope(evidence.forces, evidence.means)
    zeros = evidence.values - b * forces
    keys = [(reading.repeat, reading.direction) for reading in evidence.readings]
    lines: list[tuple[str, str, float, float, float]] = []
    first: float | None = None
    for key in dict.fromkeys(keys):
        chosen = np.array([other == key for other in keys])
        away = forces[chosen] - forces[chosen].mean()
        zero = float(zeros[chosen].mean())
        first = zero if first is None else first
        spread = float(away @ away)
        own = float(away @ evidence.values[chosen]) / spread if spread > 0 else 0.0
        if own > 0:
            lines.append((*key, 1 / own, evidence.s / sqrt(spread) / own**2, zero - first))
    return lines
