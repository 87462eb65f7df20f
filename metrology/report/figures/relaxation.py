"""Records of a held elongation or load with the model and its residuals; storage and loss over frequency."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import scale
from metrology.language.done import in_words
from metrology.message import counted, said
from metrology.relaxation import RelaxationFinding
from metrology.relaxation.finding import Specimen
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, FULL, GREY, INK, NAMES, ORANGE, PALE, Plot, plain

if TYPE_CHECKING:
    from metrology.report.figures import Job, Subject

_MARKS = (Mark("o", BLUE, 2.2), Mark("s", ORANGE, 2.2), Mark("^", GREY, 2.6), Mark("D", PALE, 2.4), Mark("v", INK, 2.4))
_MODEL, _ZERO, _ERROR = Pen(stroke=INK, width=0.9), Pen(stroke=GREY, width=0.5), Pen(stroke=ORANGE, width=0.8)
_READ = Mark("o", ORANGE, 3.4)
_LEGEND = 6
"""Specimens that are named in the plot; the table has them all."""
_LONG = 18
"""Characters of such a name."""


def jobs(finding: RelaxationFinding, subject: Subject) -> Iterator[Job]:
    """The records, where the certificate does not have them, and the moduli that follow from them."""
    if not subject.certified:
        yield from story(finding, subject)
    drawn = partial(draw_moduli, finding, subject.title, label=subject.label, language=subject.language)
    yield f"moduli/{subject.test}", drawn


def story(finding: RelaxationFinding, subject: Subject) -> Iterator[Job]:
    """The records alone, for the certificate."""
    drawn = partial(draw, finding, subject.title, label=subject.label, language=subject.language)
    yield f"relaxation/{subject.test}", drawn


# ---- records --------------------------------------------------------------------------------------------------------
def draw(finding: RelaxationFinding, title: str, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Whole records over time on the left, the longest hold over logarithmic time on the right, residuals beneath."""
    plot = Sketch((FULL, 86.0), (15.0, 41.0, 107.0, 3.0), label=label, language=language)
    factor, unit = _unit(finding)
    word = said("{quantity} / {unit}", quantity=_word(finding), unit=unit)
    rows: list[Any] = [
        (mark, one, tuple(np.array(part) for part in (one.record.time, one.record.answer, one.record.model)))
        for mark, one in zip(cycle(_MARKS), finding.specimens, strict=False)
    ]
    answers = np.concatenate([part / factor for *_, (_, *both) in rows for part in both])
    low, high = float(answers.min()), float(answers.max())
    longest = max(float(time[-1]) for *_, (time, _, _) in rows)
    clock, second = (3600.0, "h") if longest > 3 * 3600 else (1.0, "s")
    span = (0.0, longest / clock)
    plot.window(span, (low - 0.04 * (high - low), high + 0.06 * (high - low)))
    for mark, _, (time, answer, model) in rows:
        plot.dots((time / clock).tolist(), (answer / factor).tolist(), mark)
        plot.line((time / clock).tolist(), (model / factor).tolist(), _MODEL)
    plot.x_axis("")
    plot.y_axis(word, 5)
    longest_holds = [(mark, one, _longest(one, *parts)) for mark, one, parts in rows if one.holds]
    holds = [row for row in longest_holds if len(row[2][0]) > 1]
    if not holds:
        _name(plot, rows, factor)
    rest = [(mark, time / clock, answer - model) for mark, _, (time, answer, model) in rows]
    plot.panel((15.0, 11.0, 107.0, 50.0))
    _residuals(plot, rest, span, finding)
    plot.x_axis(said("time / {unit}", unit=second), 5)
    if holds:
        _held(plot, finding, holds, (factor, word))
    return plot.finish(_alt(finding, title), _caption(finding))


def _name(plot: Sketch, shown: Sequence[tuple[Mark, Specimen, Any]], factor: float) -> None:
    """Name the specimens and the model at the right, where the last reading of each is."""
    names: list[tuple[str, float, Pen | Mark]] = [
        (plain(one.name, _LONG), float(answer[-1]) / factor, mark) for mark, one, (_, answer, _) in shown[:_LEGEND]
    ]
    plot.labels([*names, (said("model"), float(shown[0][2][2][-1]) / factor, _MODEL)])


def _word(finding: RelaxationFinding) -> str:
    if finding.held == "elongation":
        return said("force")
    return said("strain") if finding.by_strain else said("elongation")


def _unit(finding: RelaxationFinding) -> tuple[float, str]:
    """Factor and unit of what answered."""
    most = max(max(abs(value) for value in one.record.answer) for one in finding.specimens)
    if finding.held == "elongation":
        return (1e3, "kN") if most >= 1e3 else (1.0, "N")
    if finding.by_strain:
        return (1e-2, "%") if most > 2e-3 else (1e-6, "10⁻⁶")
    return scale(most, "m")


def _residuals(
    plot: Sketch, rest: list[tuple[Mark, Any, Any]], span: tuple[float, float], finding: RelaxationFinding
) -> None:
    values = np.concatenate([np.abs(part) for *_, part in rest])
    # A block of one reading in the ramp has all of its noise: what most of them hold sets the window.
    most = 1.3 * float(np.quantile(values, 0.98)) or 1.0
    if finding.held == "elongation" or not finding.by_strain:
        factor, unit = scale(most, "N" if finding.held == "elongation" else "m")
    else:
        factor, unit = 1e-6, "10⁻⁶"
    plot.window(span, (-most / factor, most / factor))
    plot.level(0.0, _ZERO)
    for mark, time, part in rest:
        plot.dots(time.tolist(), (part / factor).tolist(), mark)
    plot.y_axis(said("residual / {unit}", unit=unit), 3)


def _held(
    plot: Sketch, finding: RelaxationFinding, holds: list[tuple[Mark, Specimen, Any]], shown: tuple[float, str]
) -> None:
    """The longest hold over the logarithm of the time since the middle of the ramp to it."""
    factor, word = shown
    times = [time for *_, (time, _, _) in holds]
    span = (min(float(time[0]) for time in times), max(float(time[-1]) for time in times))
    values = np.concatenate([part / factor for *_, (_, *both) in holds for part in both])
    low, high = float(values.min()), float(values.max())
    plot.panel((83.0, 41.0, NAMES, 3.0))
    plot.window(span, (low - 0.05 * (high - low), high + 0.05 * (high - low)))
    for mark, _, (time, answer, model) in holds:
        plot.dots(time.tolist(), (answer / factor).tolist(), mark)
        plot.line(time.tolist(), (model / factor).tolist(), _MODEL)
    plot.x_axis("")
    plot.y_axis(word, 5)
    _name(plot, holds, factor)
    plot.panel((83.0, 11.0, NAMES, 50.0))
    _residuals(plot, [(mark, time, answer - model) for mark, _, (time, answer, model) in holds], span, finding)
    plot.x_decades(said("time since the ramp / s"))


def _longest(one: Specimen, time: Any, answer: Any, model: Any) -> tuple[Any, Any, Any]:
    """Logarithms of the times of the longest hold, and its readings and model."""
    held = int(np.argmax(one.holds))
    stimulus = np.array(one.record.input)
    near = np.abs(stimulus - one.levels[held]) <= 0.03 * float(np.ptp(stimulus))
    runs = np.flatnonzero(near)
    ends = np.split(runs, np.flatnonzero(np.diff(runs) > 1) + 1)
    chosen = max(ends, key=lambda run: float(time[run[-1]] - time[run[0]]))
    chosen = chosen[chosen > 0]
    since = time[chosen] - (time[chosen[0]] - one.ramp / 2)
    return np.log10(since), answer[chosen], model[chosen]


def _alt(finding: RelaxationFinding, title: str) -> str:
    load = (
        "{title}: {quantity} over time of {specimens} while the load is held, with the model ({form}) and its "
        "residuals; on the right the longest hold over logarithmic time."
    )
    elongation = (
        "{title}: {quantity} over time of {specimens} while the elongation is held, with the model ({form}) and its "
        "residuals; on the right the longest hold over logarithmic time."
    )
    return said(
        load if finding.held == "load" else elongation, title=title, quantity=_word(finding),
        form=in_words(finding.forms[0].name),
        specimens=counted("{count} specimen", "{count} specimens", len(finding.specimens)),
    )  # fmt: skip


def _caption(finding: RelaxationFinding) -> str:
    text = (
        "Left, the records as means of consecutive readings, with the most probable form ({form}); right, the longest "
        "hold over the time since the middle of its ramp. Beneath, the residuals of the means: those of one reading, "
        "in the ramps, scatter most."
    )
    return said(text, form=in_words(finding.forms[0].name))


# ---- moduli ---------------------------------------------------------------------------------------------------------
def draw_moduli(finding: RelaxationFinding, title: str, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Storage on the left, loss on the right, with their bands, and the DMA sweep where there is one."""
    plot = Sketch((FULL, 66.0), (15.0, 11.0, 92.0, 9.0), label=label, language=language)
    curve = finding.moduli
    unit = {"E": "Pa", "k": "N/m", "EA": "N"}[curve.quantity]
    for part, sign in (("storage", "′"), ("loss", "″")):
        if part == "loss":
            plot.panel((98.0, 11.0, 1.5, 9.0))
        _modulus(plot, finding, part, (f"{curve.quantity}{sign}", unit))
        if part == "storage":
            read: list[tuple[str, Pen | Mark]] = [(said("DMA sweep, ±2u"), _READ)] if finding.dma else []
            plot.legend([(said("predicted"), _MODEL), (said("95 % interval"), Pen(fill=BAND)), *read])
    alone = (
        "{title}: storage and loss of {quantity} predicted from {low:.2g} Hz to {high:.2g} Hz, with their 95 % bands."
    )
    swept = (
        "{title}: storage and loss of {quantity} predicted from {low:.2g} Hz to {high:.2g} Hz, with their 95 % bands "
        "and a DMA sweep."
    )
    low, high = float(curve.frequency[0]), float(curve.frequency[-1])
    alt = said(swept if finding.dma else alone, title=title, quantity=curve.quantity, low=low, high=high)
    caption = said(
        "Storage and loss predicted from the hold, over the frequencies that the records support: from 1/(2π·longest "
        "hold) to 1/(2π·longest ramp)."
    )
    return plot.finish(alt, caption)


def _modulus(plot: Sketch, finding: RelaxationFinding, part: str, named: tuple[str, str]) -> None:
    curve, (symbol, si) = finding.moduli, named
    middle, low, high = (np.array(getattr(curve, f"{part}{end}")) for end in ("", "_low", "_high"))
    x = np.log10(np.array(curve.frequency))
    read = [
        (float(np.log10(one.frequency)), getattr(one, part), getattr(one, f"{part}_u") or 0.0) for one in finding.dma
    ]
    ends = [*low.tolist(), *high.tolist(), *(value - 2 * u for _, value, u in read), *(v + 2 * u for _, v, u in read)]
    factor, unit = scale(max(abs(end) for end in ends), si)
    bottom, top = min(ends), max(ends)
    room = 0.06 * (top - bottom) or 0.1 * abs(top)
    plot.window((min(x[0], *(at for at, _, _ in read), x[0]), max(x[-1], *(at for at, _, _ in read), x[-1])),
                ((bottom - room) / factor, (top + room) / factor))  # fmt: skip
    plot.band(x.tolist(), (low / factor).tolist(), (high / factor).tolist(), BAND)
    plot.line(x.tolist(), (middle / factor).tolist(), _MODEL)
    plot.errors(
        [at for at, _, _ in read], [v / factor for _, v, _ in read], [2 * u / factor for _, _, u in read], _ERROR
    )
    plot.dots([at for at, _, _ in read], [value / factor for _, value, _ in read], _READ)
    plot.x_decades(said("frequency / Hz"))
    plot.y_axis(f"{symbol} / {unit}", 4)
