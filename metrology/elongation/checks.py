"""Checks of the readings against what the model of the line supposes."""

from __future__ import annotations

from math import sqrt

import numpy as np

from metrology.check import Check
from metrology.elongation.evidence import Evidence, untested
from metrology.elongation.line import Floats, compare
from metrology.elongation.outliers import outlier, records
from metrology.message import said

LINEARITY = "linearity (lack of fit)"
ZERO = "zero shift between repeats"
HYSTERESIS = "loading against unloading"
SCATTER = "stiffness between repeats"


def run(evidence: Evidence) -> tuple[Check, ...]:
    """All checks, in the order in which the report shows them."""
    return tuple(check(evidence) for check in CHECKS)


def linearity(evidence: Evidence) -> Check:
    """Lack of fit: whether the means leave the line by more than their scatter and the instruments explain.

    F = [(SS_line − SS_means)/(L − 2)] / s². A lack of fit passes where indicator, resolution and masses explain it:
    then rᵀ·V⁻¹·r/(L − 2), with V of repeatability and declared uncertainties together, is no large value of F.
    """
    if evidence.means.about_line:
        return untested(LINEARITY, said("too few readings are repeated; what is not straight is part of the scatter"))
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
    from scipy.special import chdtrc

    extra = len(evidence.forces) - 2
    if evidence.means.dof < 1 or extra < 1 or not evidence.declared.all():
        text = "the readings do not scatter; largest deviation of a mean from the line {away:.2g} µm"
        return untested(LINEARITY, said(text, away=away))
    covariance = np.diag(evidence.declared**2)
    deviation = _deviation(evidence, covariance)
    statistic = float(deviation @ np.linalg.solve(covariance, deviation))
    p_value = float(chdtrc(extra, statistic))
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
    from scipy.special import fdtrc

    covariance = evidence.means.variance * evidence.means.cofactor + np.diag(evidence.declared**2)
    deviation = _deviation(evidence, covariance)
    extra = len(evidence.forces) - 2
    return float(fdtrc(extra, evidence.means.dof, deviation @ np.linalg.solve(covariance, deviation) / extra))


def zero_shift(evidence: Evidence) -> Check:
    """F test of one zero for all repeats against one zero each."""
    if not evidence.means.zero_each or len(evidence.means.shifts) < 2:
        reason = said("the repeats do not share loads, or there is only one; one zero serves all readings")
        return untested(ZERO, reason)
    result = compare(evidence.values, evidence.plain(), evidence.means.columns, floor=evidence.floor)
    shift = 1e6 * float(np.ptp(evidence.means.shifts))
    if result.p_value is None:
        text = "the readings do not scatter; the zeros differ by up to {shift:.2g} µm, which the line allows for"
        return untested(ZERO, said(text, shift=shift))
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
    from scipy.special import stdtr

    differences = _pairs(evidence)
    if len(differences) < 2:
        return untested(HYSTERESIS, said("fewer than two loads were read both loading and unloading"))
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
    p_value = float(2 * stdtr(count - 1, -abs(statistic)))
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
        return untested(SCATTER, said("there are no repeats with a line each"))
    full = evidence.means.columns
    result = compare(evidence.values, full, np.hstack([full, slopes]), floor=evidence.floor)
    if result.p_value is None:
        return untested(SCATTER, said("too few readings in a repeat, or no scatter"))
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
    from scipy.special import fdtrc

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
    return float(fdtrc(extra, dof, found @ np.linalg.solve(covariance, found) / extra))


CHECKS = (linearity, zero_shift, hysteresis, between_repeats, outlier, records)
"""Every check of the method; each holds its rate of false alarms on normal readings without a fault, or less."""
