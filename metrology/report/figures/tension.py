"""Records of a testing machine: force against stretch with the fitted lines, and their residuals over the range."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import scale
from metrology.message import counted, said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BLUE, FULL, GREY, INK, NAMES, ORANGE, PALE, Plot, plain
from metrology.tension import TensionFinding
from metrology.tension.finding import Specimen

if TYPE_CHECKING:
    from metrology.report.figures import Job, Subject

_HEIGHT = 96.0
_PENS = (BLUE, ORANGE, INK, GREY, PALE)
_DASHES: tuple[tuple[float, ...], ...] = ((), (4.0, 2.0), (1.5, 1.5), (6.0, 1.5, 1.5, 1.5))
_LINE, _ZERO = Pen(stroke=INK, width=0.5), Pen(stroke=GREY, width=0.5)
_END = Mark("o", INK, 2.6)
_LEGEND = 8
"""Specimens that are named in the plot; the table has them all."""
_LONG = 18
"""Characters of such a name."""


def jobs(finding: TensionFinding, subject: Subject) -> Iterator[Job]:
    """The plot of a test, where the certificate does not have it."""
    if not subject.certified:
        yield from story(finding, subject)


def story(finding: TensionFinding, subject: Subject) -> Iterator[Job]:
    """The same plot, for the certificate."""
    drawn = partial(draw, finding, subject.title, label=subject.label, language=subject.language)
    yield f"tension/{subject.test}", drawn


def draw(finding: TensionFinding, title: str, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Whole records on the left, the range with its line in the middle, residuals over the range beneath."""
    plot = Sketch((FULL, _HEIGHT), (15.0, 11.0, 107.0, 2.0), label=label, language=language)
    strain = finding.basis == "extensometer"
    most = max(one.force_most for one in finding.specimens)
    force_factor, force_unit = _force(most)
    stretches = [_stretch(one, strain=strain) for one in finding.specimens]
    factor, unit = _unit(max(float(np.nanmax(np.abs(one), initial=0.0)) for one in stretches), strain=strain)
    _whole(plot, finding, stretches, (factor, force_factor))
    plot.x_axis(said("{quantity} / {unit}", quantity=_word(strain=strain), unit=unit), 5)
    plot.y_axis(said("force / {unit}", unit=force_unit), 5)
    _range(plot, finding, stretches, force_factor, strain=strain)
    return plot.finish(_alt(finding, title), _caption())


def _word(*, strain: bool) -> str:
    return said("strain") if strain else said("displacement of the crosshead")


def _unit(most: float, *, strain: bool) -> tuple[float, str]:
    """Factor and unit of a strain, or of a displacement."""
    if not strain:
        return scale(most, "m")
    return (1e-2, "%") if most > 2e-3 else (1e-6, "10⁻⁶")


def _force(most: float) -> tuple[float, str]:
    """Factor and unit of forces: newtons up to a thousand."""
    return (1e3, "kN") if most >= 1e3 else (1.0, "N")


def _stretch(one: Specimen, *, strain: bool) -> Any:
    if strain:
        return np.array([np.nan if value is None else value for value in one.curve.strain])
    return np.array(one.curve.crosshead)


def _pen(at: int) -> Pen:
    return Pen(stroke=_PENS[at % len(_PENS)], width=1.1, dash=_DASHES[at // len(_PENS) % len(_DASHES)])


def _whole(plot: Sketch, finding: TensionFinding, stretches: list[Any], factors: tuple[float, float]) -> None:
    """Records as they are, each with the ends of its range."""
    factor, force_factor = factors
    ends = [(np.nanmin(one), np.nanmax(one)) for one in stretches]
    low, high = (float(pick(pair)) / factor for pick, pair in zip((min, max), zip(*ends, strict=True), strict=True))
    top = max(one.force_most for one in finding.specimens) / force_factor
    plot.window((low - 0.02 * (high - low), high + 0.03 * (high - low)), (0.0, 1.06 * top))
    for at, (one, stretch) in enumerate(zip(finding.specimens, stretches, strict=True)):
        seen = np.isfinite(stretch)
        force = np.array(one.curve.force)[seen] / force_factor
        plot.line((stretch[seen] / factor).tolist(), force.tolist(), _pen(at))
        marked = [(one.intercept + one.slope * force) / factor for force in (one.low, one.high)]
        plot.dots(marked, [one.low / force_factor, one.high / force_factor], _END)


def _range(plot: Sketch, finding: TensionFinding, stretches: list[Any], force_factor: float, *, strain: bool) -> None:
    """Above, stretch against force near the range; beneath, what the lines leave over it."""
    tops = [max(one.high, one.low) for one in finding.specimens]
    span = (0.0, 1.05 * max(tops) / force_factor)
    rows = [_near(one, stretch) for one, stretch in zip(finding.specimens, stretches, strict=True)]
    values = np.concatenate([stretch for _, stretch in rows])
    factor, unit = _unit(float(np.nanmax(np.abs(values), initial=0.0)), strain=strain)
    plot.panel((83.0, 45.0, NAMES, 2.0))
    plot.window(span, (float(np.nanmin(values)) / factor, float(np.nanmax(values)) / factor))
    for at, (one, (force, stretch)) in enumerate(zip(finding.specimens, rows, strict=True)):
        plot.line((force / force_factor).tolist(), (stretch / factor).tolist(), _pen(at))
        ends = (one.low, one.high)
        plot.line([end / force_factor for end in ends], [(one.intercept + one.slope * end) / factor for end in ends],
                  _LINE)  # fmt: skip
    plot.x_axis("")
    last = [float(stretch[np.isfinite(stretch)][-1]) / factor for _, stretch in rows[:_LEGEND]]
    names = [(plain(one.name, _LONG), end, _pen(at))
             for at, (one, end) in enumerate(zip(finding.specimens, last, strict=False))]  # fmt: skip
    plot.labels([*names, (said("line"), max(last), _LINE)])
    plot.y_axis(said("strain / {unit}", unit=unit) if strain else said("crosshead / {unit}", unit=unit), 4)
    plot.panel((83.0, 11.0, NAMES, 55.0))
    left = [_left(one, force, stretch) for one, (force, stretch) in zip(finding.specimens, rows, strict=True)]
    most = max(float(np.nanmax(np.abs(rest), initial=0.0)) for _, rest in left) or 1.0
    factor, unit = (1e-6, "10⁻⁶") if strain else scale(most, "m")
    plot.window(span, (-1.15 * most / factor, 1.15 * most / factor))
    plot.level(0.0, _ZERO)
    for at, (force, rest) in enumerate(left):
        plot.line((force / force_factor).tolist(), (rest / factor).tolist(), _pen(at))
    plot.x_axis(said("force / {unit}", unit=_force(max(one.force_most for one in finding.specimens))[1]), 5)
    plot.y_axis(said("residual / {unit}", unit=unit), 4)


def _near(one: Specimen, stretch: Any) -> tuple[Any, Any]:
    """The loading up to the end of the range."""
    force = np.array(one.curve.force)
    above = np.flatnonzero(force >= one.high)
    stop = int(above[0]) + 1 if len(above) else int(np.argmax(force)) + 1
    return force[:stop], stretch[:stop]


def _left(one: Specimen, force: Any, stretch: Any) -> tuple[Any, Any]:
    """What the line leaves over the range."""
    inside = (force >= one.low) & (force <= one.high)
    return force[inside], (stretch - one.intercept - one.slope * force)[inside]


def _alt(finding: TensionFinding, title: str) -> str:
    most = max(one.force_most for one in finding.specimens)
    factor, unit = scale(most, "N")
    text = (
        "{title}: force against {quantity} of {specimens} up to {most:.3g} {unit}, with the fitted lines and their "
        "residuals over the range."
    )
    return said(
        text, title=title, quantity=_word(strain=finding.basis == "extensometer"),
        specimens=counted("{count} specimen", "{count} specimens", len(finding.specimens)),
        most=float(most / factor), unit=unit,
    )  # fmt: skip


def _caption() -> str:
    return said(
        "Left, the records; dots end the range of the line. Right, the range with its lines; beneath, the residuals: "
        "a curve is a record that is not straight there. Records are thinned; every extreme is kept."
    )
