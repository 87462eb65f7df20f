"""Load against extension: readings, the line with its band, the residuals beneath, excluded readings marked."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.elongation import ElongationFinding
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import estimate, number, scale
from metrology.message import said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, FULL, GREY, INK, NAMES, ORANGE, Plot

if TYPE_CHECKING:
    from metrology.report.figures import Job, Subject

_HEIGHT, _TALL = 52.0, 95.0
_LINE, _SLOPE, _ZERO = Pen(stroke=INK, width=0.8), Pen(fill=BAND), Pen(stroke=GREY, width=0.5)
_MEAN = Pen(stroke=INK, width=0.8)
_WAYS = {"loading": (Mark("^", BLUE), -1), "unloading": (Mark("v", ORANGE, hollow=True), 1)}
_OUT = Mark("x", INK, 4.0)


def jobs(finding: ElongationFinding, subject: Subject) -> Iterator[Job]:
    """The plot of a test, where it has readings and the certificate does not have it."""
    if finding.force and not subject.certified:
        drawn = partial(draw, finding, subject.title, label=subject.label, language=subject.language)
        yield f"elongation/{subject.test}", drawn


def story(finding: ElongationFinding, subject: Subject) -> Iterator[Job]:
    """The same plot with more room, for the certificate."""
    if finding.force:
        yield (
            "story",
            partial(draw, finding, subject.title, label=subject.label, height=_TALL, language=subject.language),
        )


def draw(
    finding: ElongationFinding, title: str, *, label: str = "", height: float = _HEIGHT, language: Language = ENGLISH
) -> Plot:
    """Readings with the fitted line and its 2u band above, residuals below; `height` in mm."""
    left_out = np.array([bool(reason) for reason in finding.excluded])
    factor, unit = scale(max(map(abs, finding.extension), default=0.0), "m")
    force, extension = np.array(finding.force), np.array(finding.extension) / factor
    plot = Sketch((FULL, height), (15.0, 0.5 * height, NAMES, 2.0), label=label, language=language)
    margin = 0.04 * float(np.ptp(force)) or 1.0
    span = (float(force.min()) - margin, float(force.max()) + margin)
    lift = 0.08 * float(np.ptp(extension)) or 1.0
    plot.window(span, (float(extension.min()) - lift, float(extension.max()) + lift))
    _line(plot, finding, force, factor)
    _readings(plot, finding, extension, left_out)
    plot.x_axis("")
    plot.y_axis(said("extension / {unit}", unit=unit), 5)
    plot.labels(_names(finding, extension, left_out, factor))
    plot.panel((15.0, 9.5, NAMES, 0.5 * height + 3.0))
    _residuals(plot, finding, left_out, span)
    return plot.finish(_alt(finding, title, int(left_out.sum())), _caption(finding))


def _names(
    finding: ElongationFinding, extension: Any, left_out: Any, factor: float
) -> list[tuple[str, float, Pen | Mark]]:
    """Names with the height at which what they name ends."""
    force, direction = np.array(finding.force), np.array(finding.direction)
    end = (finding.intercept + finding.slope * float(np.max(force))) / factor
    ways = {name: (direction == name) & ~left_out for name in _WAYS}
    used = [
        (name, float(extension[ways[name]][np.argmax(force[ways[name]])]), mark)
        for name, (mark, _) in _WAYS.items()
        if ways[name].any()
    ]
    excluded = [(said("excluded"), float(extension[left_out][-1]), _OUT)] if left_out.any() else []
    return [(said("±2u of the slope"), end, _SLOPE), (said("line"), end, _LINE), *used, *excluded]


def _line(plot: Sketch, finding: ElongationFinding, force: Any, factor: float) -> None:
    span = np.linspace(float(np.min(force)), float(np.max(force)), 41)
    line = (finding.intercept + finding.slope * span) / factor
    half = 2 * finding.slope_u * np.abs(span - float(np.mean(force))) / factor
    plot.band(span.tolist(), (line - half).tolist(), (line + half).tolist(), BAND)
    plot.line(span.tolist(), line.tolist(), _LINE)


def _readings(plot: Sketch, finding: ElongationFinding, values: Any, left_out: Any, apart: float = 0.0) -> None:
    force, direction = np.array(finding.force), np.array(finding.direction)
    for name, (mark, side) in _WAYS.items():
        chosen = (direction == name) & ~left_out
        plot.dots((force[chosen] + side * apart).tolist(), values[chosen].tolist(), mark)
    plot.dots(force[left_out].tolist(), values[left_out].tolist(), _OUT)


def _residuals(plot: Sketch, finding: ElongationFinding, left_out: Any, span: tuple[float, float]) -> None:
    residual = np.array(finding.residual)
    factor, unit = scale(float(np.max(np.abs(residual[~left_out]), initial=0.0)), "m")
    residual = residual / factor
    bars = [2 * level.standard_deviation / factor / max(level.count, 1) ** 0.5 for level in finding.levels]
    means = [level.residual / factor for level in finding.levels]
    bound = 1.25 * float(np.max(np.abs(residual[~left_out]), initial=0.0)) or 1.0
    bound = max([bound, *(1.1 * (abs(mean) + bar) for mean, bar in zip(means, bars, strict=True))])
    plot.window(span, (-bound, bound))
    plot.level(0.0, _ZERO)
    _readings(plot, finding, residual, left_out, apart=0.006 * (span[1] - span[0]))
    forces, wide = [level.force for level in finding.levels], 0.008 * (span[1] - span[0])
    plot.errors(forces, means, bars, _MEAN)
    for force, mean in zip(forces, means, strict=True):
        plot.line((force - wide, force + wide), (mean, mean), _MEAN)
    beyond = left_out & (np.abs(residual) > bound)
    for force, value in zip(np.array(finding.force)[beyond], residual[beyond], strict=True):
        plot.text("↑" if value > 0 else "↓", (float(force), 0.88 * float(np.sign(value)) * bound), align=0.5)
    plot.x_axis(said("load / N"), 8)
    plot.y_axis(said("residual / {unit}", unit=unit), 4)


def _alt(finding: ElongationFinding, title: str, left_out: int) -> str:
    stiffness = estimate(1 / finding.slope, finding.slope_u / finding.slope**2, "N/m")
    largest = max(
        (abs(r) for r, reason in zip(finding.residual, finding.excluded, strict=True) if not reason), default=0.0
    )
    factor, unit = scale(largest, "m")
    text = (
        "{title}: extension against load for {readings} readings at {loads} loads, {excluded} excluded. The straight "
        "line has the slope 1/k with k = {k:figures} ± {u:figures} N/m; the largest residual used is {largest:figures} "
        "{unit}."
    )
    return said(
        text, title=title, readings=len(finding.force), loads=len(finding.levels), excluded=left_out,
        k=stiffness.value, u=stiffness.u, largest=number(largest / factor, 2), unit=unit,
    )  # fmt: skip


def _caption(finding: ElongationFinding) -> str:
    caption = said(
        "Extension against load with the fitted line and the band of ±2 standard uncertainties of its slope; beneath, "
        "the residuals, with the mean of each load and twice its standard deviation of the mean (black)."
    )
    if not any(finding.excluded):
        return caption
    text = "{caption} Crosses are excluded readings; an arrow marks one that lies beyond the axis."
    return said(text, caption=caption)
