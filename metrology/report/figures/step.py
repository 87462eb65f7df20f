"""What a unit step of the force does to the module on its line, by the k and c of the result, with their band."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from metrology.coordinate import QUANTITIES, Coordinate
from metrology.language.display import number, scale
from metrology.message import said
from metrology.report.figures.over_time import band, largest, spread, stroke
from metrology.report.figures.response import SIMULATED
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, FULL, NAMES, Plot
from metrology.response.step import StepResponse, response
from metrology.units import unit_text

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.report.figures import Job, Subject

_ROW = 20.0
FORCES = {"position": "N", "angle": "N·m"}


@dataclass(frozen=True)
class Known:
    """Value and u of stiffness and damping, their correlation coefficient, and the coverage factor of their band."""

    k: tuple[float, float]
    c: tuple[float, float]
    r: float
    factor: float


def jobs(findings: Findings, subject: Subject) -> Iterator[Job]:
    """The plot of a response test that has k and c, found in its runs or given to it."""
    finding = next(one.response for one in findings.tests if one.id == subject.test)
    known = None if finding is None else _known(findings, subject.test)
    if finding is None or known is None or finding.mass is None:
        return
    (k, u_k), (c, u_c) = known.k, known.c
    cross = known.r * u_k * u_c
    found = response(k, c, finding.mass, np.array([[u_k**2, cross], [cross, u_c**2]]))
    yield f"step/{subject.test}", partial(draw, found, known, finding.coordinate, subject)


def _known(findings: Findings, test: str) -> Known | None:
    results = {one.quantity: one for one in findings.results if one.test == test and one.quantity in ("k", "c")}
    finding = next(one.response for one in findings.tests if one.id == test)
    given = {one.name: (one.value, one.u) for one in finding.given} if finding is not None else {}
    pairs = given | {name: (one.value, one.u) for name, one in results.items()}
    if not {"k", "c"} <= pairs.keys() or not all(isfinite(u) and value > 0 for value, u in pairs.values()):
        return None
    names = {one.name for one in results.values()}
    r = next((one.coefficient for one in findings.correlations if {one.a, one.b} == names), 0.0)
    factors = [one.coverage.k for one in results.values() if one.coverage.k is not None]
    return Known(pairs["k"], pairs["c"], r, max(factors, default=1.96))


def draw(found: StepResponse, known: Known, coordinate: Coordinate, subject: Subject) -> Plot:
    """Position, velocity and tension over time, each with its 95 % band."""
    height = _ROW * len(found.values) + 14.0
    plot = Sketch((FULL, height), (0.0, 0.0, 0.0, 0.0), label=subject.label, language=subject.language)
    time, units = found.time.tolist(), QUANTITIES[coordinate]
    for at, (name, values) in enumerate(found.values.items()):
        ends = {"low": values - known.factor * found.u[name], "high": values + known.factor * found.u[name]}
        factor, unit = scale(largest(ends["low"], ends["high"]), units[name].unit)
        top = 2.0 + _ROW * at
        plot.panel((16.0, height - top - _ROW + 3.0, NAMES, top))
        plot.window((time[0], time[-1]), spread(*ends.values(), factor=factor))
        band(plot, time, ends, factor)
        stroke(plot, time, values.tolist(), factor, SIMULATED)
        plot.x_axis(said("time / s") if at == len(found.values) - 1 else "")
        if not at:
            level = float(values[-1]) / factor
            plot.labels([(said("model"), level, SIMULATED), (said("95 % band"), level, Pen(fill=BAND))])
        plot.y_axis(f"{'φ' if name == 'x' and coordinate == 'angle' else name} / {unit_text(unit)}", 3)
    last = tuple(
        said(
            "{quantity} {value:figures} {unit}", quantity=units[name].word, value=number(float(values[-1]), 4),
            unit=units[name].unit,
        )
        for name, values in found.values.items()
    )  # fmt: skip
    half = known.factor * float(found.u["x"].max())
    factor, unit = scale(half, units["x"].unit)
    force = f"1 {FORCES[coordinate]}"
    alt = (
        "{title}: what the model does after a step of {force}, from rest on the taut line. After {time:figures} s: "
        "{last:comma}."
    )
    caption = (
        "Unit step of the thrust, {force}, from rest on the taut line, by k and c of the result and the stated mass; "
        "band of k and c with their correlation, ±{half:figures} {unit} at most in {quantity}."
    )
    return plot.finish(
        said(alt, title=subject.title, force=force, time=number(time[-1], 3), last=last),
        said(caption, force=force, half=number(half / factor, 2), unit=unit, quantity=units["x"].word),
    )
