"""Load against extension: readings, the line with its band, the residuals beneath, excluded readings marked."""

from __future__ import annotations

from typing import Any

import numpy as np

from metrology.elongation import ElongationFinding
from metrology.report.display import estimate, number, scale
from metrology.report.figures.style import BAND, BLUE, FULL, GREY, INK, ORANGE, Plot, canvas, finish, legend, place


def draw(finding: ElongationFinding, title: str, *, label: str = "") -> Plot:
    """Readings with the fitted line and its 2u band above, residuals below."""
    force, extension, residual = (np.array(values) for values in (finding.force, finding.extension, finding.residual))
    left_out = np.array([bool(reason) for reason in finding.excluded])
    figure = canvas(FULL, 78.0, label=label)
    upper = place(figure, (15.0, 35.0, 1.5, 7.0))
    lower = place(figure, (15.0, 9.0, 1.5, 46.0), sharex=upper)
    factor, unit = scale(float(np.max(np.abs(extension), initial=0.0)), "m")
    _line(upper, finding, force, factor)
    _readings(upper, finding, extension / factor, left_out)
    upper.set_ylabel(f"extension / {unit}")
    upper.tick_params(labelbottom=False)
    legend(upper, 5)
    _residuals(lower, finding, residual, left_out)
    return finish(figure, _alt(finding, title, int(left_out.sum())), _caption(finding))


def _line(axes: Any, finding: ElongationFinding, force: Any, factor: float) -> None:
    span = np.linspace(float(np.min(force)), float(np.max(force)), 41)
    middle = float(np.mean(force))
    line = finding.intercept + finding.slope * span
    half = 2 * finding.slope_u * np.abs(span - middle)
    axes.fill_between(span, (line - half) / factor, (line + half) / factor, color=BAND, lw=0, label="±2u of the slope")
    axes.plot(span, line / factor, color=INK, lw=0.8, label="line")


def _readings(axes: Any, finding: ElongationFinding, values: Any, left_out: Any, apart: float = 0.0) -> None:
    force, direction = np.array(finding.force), np.array(finding.direction)
    step = apart * float(np.ptp(force))
    for name, marker, colour, fill, side in (("loading", "^", BLUE, BLUE, -1), ("unloading", "v", ORANGE, "none", 1)):
        chosen = (direction == name) & ~left_out
        if chosen.any():
            axes.plot(
                force[chosen] + side * step,
                values[chosen],
                marker,
                color=colour,
                mfc=fill,
                mew=0.7,
                ls="none",
                label=name,
            )
    if left_out.any():
        axes.plot(force[left_out], values[left_out], "x", color=INK, ms=4.5, mew=1.0, ls="none", label="excluded")


def _residuals(axes: Any, finding: ElongationFinding, residual: Any, left_out: Any) -> None:
    used = residual[~left_out]
    factor, unit = scale(float(np.max(np.abs(used), initial=0.0)), "m")
    axes.axhline(0.0, color=GREY, lw=0.5)
    _readings(axes, finding, residual / factor, left_out, apart=0.006)
    bound = 1.25 * float(np.max(np.abs(used), initial=0.0)) / factor or 1.0
    for level in finding.levels:
        bar = 2 * level.standard_deviation / factor / max(level.count, 1) ** 0.5
        bound = max(bound, 1.1 * (abs(level.residual / factor) + bar))
        axes.errorbar(
            [level.force],
            [level.residual / factor],
            yerr=[bar],
            fmt="_",
            color=INK,
            ms=9,
            mew=0.9,
            elinewidth=0.7,
            capsize=2,
        )
    beyond = left_out & (np.abs(residual / factor) > bound)
    for force, value in zip(np.array(finding.force)[beyond], residual[beyond], strict=True):
        axes.annotate(
            "↑" if value > 0 else "↓", (force, np.sign(value) * bound), ha="center", va="top" if value > 0 else "bottom"
        )
    axes.set_ylim(-bound, bound)
    axes.set_ylabel(f"residual / {unit}")
    axes.set_xlabel("load / N")


def _alt(finding: ElongationFinding, title: str, left_out: int) -> str:
    stiffness = estimate(1 / finding.slope, finding.slope_u / finding.slope**2, "N/m")
    largest = max(
        (abs(r) for r, reason in zip(finding.residual, finding.excluded, strict=True) if not reason), default=0.0
    )
    factor, unit = scale(largest, "m")
    return (
        f"{title}: extension against load for {len(finding.force)} readings at {len(finding.levels)} "
        f"loads, {left_out} excluded. "
        f"The straight line has the slope 1/k with k = {stiffness.value} ± {stiffness.u} N/m; "
        f"the largest residual used is {number(largest / factor, 2)} {unit}."
    )


def _caption(finding: ElongationFinding) -> str:
    return (
        "Extension against load with the fitted line and the band of ±2 standard uncertainties of "
        "its slope; beneath, the "
        "residuals, with the mean of each load and twice its standard deviation of the mean (black)."
        + (
            " Crosses are excluded readings; an arrow marks one that lies beyond the axis."
            if any(finding.excluded)
            else ""
        )
    )
