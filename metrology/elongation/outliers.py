"""Checks of single readings: off the others by medians or by studentised residuals, or coarser than is stated."""

from __future__ import annotations

from math import sqrt

import numpy as np

from metrology import raw
from metrology.check import Check
from metrology.elongation.evidence import Evidence, untested
from metrology.elongation.line import Floats
from metrology.message import said
from metrology.ties import largest

OUTLIER = "outlier"


def records(evidence: Evidence) -> Check:
    """Readings off the others at their load by more than all loads together stretch the sample: no slip is as large.

    By medians, first of each repeat, then of each load: a few wrong readings do not move them.
    """
    loads, repeats = evidence.layout.loads, evidence.layout.repeats
    left = evidence.values - _medians(evidence.values, repeats)
    level = _medians(left, loads)
    off = left - level - _medians(left - level, repeats)
    wrong = np.flatnonzero(np.abs(off) > np.ptp(level))
    read = np.array([one.value for one in evidence.readings])
    step = 0.0 if _resolved(evidence) else raw.coarse(read, evidence.resolution)
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


def _resolved(evidence: Evidence) -> bool:
    """Whether all readings lie as near to one straight line as they are resolved: even steps are then of the loads."""
    columns = evidence.layout.straight_columns(evidence.forces, zero_each=False)
    left = evidence.values - columns @ np.linalg.lstsq(columns, evidence.values, rcond=None)[0]
    return bool(np.abs(left).max() <= evidence.resolution)


def _medians(values: Floats, groups: np.ndarray[tuple[int, ...], np.dtype[np.intp]]) -> Floats:
    """For every reading the median of its group."""
    return np.array([np.median(values[groups == group]) for group in range(int(groups.max()) + 1)])[groups]


def outlier(evidence: Evidence) -> Check:
    """Largest studentised residual, with a Bonferroni limit for having looked at all; nothing is excluded by it.

    What the others scatter by is no less than their rounding: under a coarse division nearly all at a load are alike.
    Several readings that hide each other in the scatter are looked for together.
    """
    from scipy.special import stdtr

    means, count = evidence.means, len(evidence.values)
    if means.dof < 2 or evidence.s <= evidence.floor:
        return untested(OUTLIER, said("too few readings, or no scatter"))
    spare = np.maximum(1 - means.leverage, 1e-9)
    rest = np.maximum((means.variance * means.dof - means.leftover**2 / spare) / (means.dof - 1), _least(evidence))
    ratios = np.where(means.leverage < 1 - 1e-6, means.leftover / np.sqrt(rest * spare), 0.0)
    worst = largest(np.abs(ratios))
    statistic = float(ratios[worst])
    p_value = min(1.0, count * 2 * float(stdtr(means.dof - 1, -abs(statistic))))
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
    from scipy.special import comb, fdtrc

    means, count = evidence.means, len(evidence.values)
    axes = np.linalg.svd(means.columns, full_matrices=False)
    basis = axes[0][:, axes[1] > 1e-10 * axes[1].max()]
    left, spare, whole = means.leftover.copy(), 1 - np.sum(basis**2, axis=1), means.variance * means.dof
    chosen: list[int] = []
    found, least, without = [], 1.0, means.variance
    most = (means.dof - 1) // 2
    for size in range(1, most + 1):
        ratios = np.where(spare > 1e-6, left**2 / np.maximum(spare, 1e-6), 0.0)
        chosen.append(largest(ratios))
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
        chance = float(fdtrc(size, means.dof - size, F)) * float(comb(count, size)) * (most - 1)
        if chance < least:
            found, least, without = sorted(chosen), chance, variance
    return found, least, without
