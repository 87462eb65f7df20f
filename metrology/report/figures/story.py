"""The one picture of the certificate: what was measured, how well, and what the model as stated does not explain."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.language.display import number, scale
from metrology.message import said
from metrology.report.figures import models, over_time, response
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BLUE, FULL, GREY, NAMES, ORANGE, Plot, plain

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.report.figures import Subject
    from metrology.tested import TestItem

HEIGHT, LOWER = 120.0, 90.0
"""Height of the picture in mm; of one that stands below the few lines of a short certificate."""
FEW = 2
"""Results of a certificate without requirements up to which it is short."""
LEFT = 0.45
"""Part of the height that the residuals have."""
VISIBLE = 0.12
"""Part of the height of a panel from which on the distance of two curves is plain: seven millimetres in 59."""
LEAST = 40
"""Readings that a window shows at least: fewer are no curve."""
_GRAVITY = ("unexplained", "not finished", "ambiguous", "explained in the main", "explained")
_READING = Mark("o", GREY, 2.8)
_STATED, _VALIDATED = Pen(stroke=ORANGE, width=1.0, dash=(4.0, 1.6)), Pen(stroke=BLUE, width=0.8)
_LEFT_STATED, _LEFT_VALIDATED = Pen(stroke=ORANGE, width=0.6, dash=(4.0, 1.2)), Pen(stroke=BLUE, width=0.6)


@dataclass(frozen=True)
class Shown:
    """A channel of a held-out run by the model as stated and, where there is one, by the validated one.

    `left`: residuals over the noise of one reading; `rms`: their root mean square over the whole run.
    """

    run: str
    channel: Mapping[str, Any]
    names: tuple[str, ...]
    time: tuple[Any, ...]
    predicted: tuple[Any, ...]
    left: tuple[Any, ...]
    rms: tuple[float, ...]


def job(findings: Findings, subjects: Mapping[str, Subject]) -> tuple[str, Callable[[], Plot]] | None:
    """What draws the picture of a campaign, and the test whose own plot it is, if any; None where no test has one."""
    for check in (one for one in findings.verification if one.get("basis", "stated") == "stated"):
        shown = _largest_gain(check, _second(findings, check["test"]))
        if shown is not None:
            short = sum(one.headline for one in findings.results) <= FEW and not findings.conformity
            return "", partial(draw, shown, subjects[check["test"]], LOWER if short else HEIGHT)
    for test in _ranked(findings):
        for _, drawn in _of_method(test, subjects[test.id]):
            # The annex need not draw it again.
            return test.id, partial(_of, drawn, test.id)
    return None


def _of(drawn: Callable[[], Plot], test: str) -> Plot:
    """A plot that says whose it is."""
    return replace(drawn(), of=test)


def _second(findings: Findings, test: str) -> Mapping[str, Any]:
    found = [one for one in findings.verification if one["test"] == test and one.get("basis") == "extended"]
    return {run["run"]: run for one in found for run in one["runs"]}


def _ranked(findings: Findings) -> list[TestItem]:
    """Tests with something to show, those with the gravest diagnosis first."""
    verdicts = {one.test: one.verdict for one in findings.diagnosis}

    def rank(test: TestItem) -> int:
        verdict = verdicts.get(test.id, "")
        return _GRAVITY.index(verdict) if verdict in _GRAVITY else len(_GRAVITY)

    return sorted((test for test in findings.tests if test.finding is not None), key=rank)


def _of_method(test: TestItem, subject: Subject) -> Iterator[tuple[str, Callable[[], Plot]]]:
    """What a method shows of a test: `story` of its plots where it has one, else its first plot."""
    module = import_module(f"metrology.report.figures.{test.by}")
    yield from getattr(module, "story", module.jobs)(test.finding, subject)


# ---- which run, and which part of it -------------------------------------------------------------------------------
def _largest_gain(check: Mapping[str, Any], second: Mapping[str, Any]) -> Shown | None:
    """The channel of the held-out run in which the validated model gains most, or the stated one fits worst."""
    found = [shown for run in check["runs"] for shown in _channels(run, second.get(run["run"]))]
    return max(found, key=_gain, default=None)


def _gain(shown: Shown) -> float:
    return shown.rms[0] / shown.rms[-1] if len(shown.rms) > 1 else shown.rms[0]


def _channels(stated: Mapping[str, Any], extended: Mapping[str, Any] | None) -> Iterator[Shown]:
    runs = [stated] if extended is None else [stated, extended]
    noises = response.noises(*runs)
    for channels in zip(*(run["series"] for run in runs), strict=True):
        name = channels[-1]["channel"]
        ratios = [_ratio(run, name) for run in runs]
        if name not in noises or not all(ratios) or not channels[-1]["time"]:
            continue
        yield Shown(
            stated["run"], channels[-1], (said("model as stated"), said("validated model"))[: len(runs)],
            tuple(np.array(one["time"], float) for one in channels),
            tuple(_floats(models.best(one)) for one in channels),
            tuple(_floats(response.left(one)) / noises[name] for one in channels),
            tuple(ratio for ratio in ratios if ratio),
        )  # fmt: skip


def _ratio(run: Mapping[str, Any], channel: str) -> float | None:
    return next(
        (one["closed_rms"] for one in run["scores"] if one["name"] == "all" and one["channel"] == channel), None
    )


def _floats(values: Sequence[float | None]) -> Any:
    return np.array([np.nan if value is None else value for value in values], float)


def window(shown: Shown) -> tuple[float, float]:
    """Part of the run where the models differ most, as wide as their distance can be seen in it; else the whole run."""
    time, measured = shown.time[-1], _floats(shown.channel["measured"])
    whole = (float(time[0]), float(time[-1]))
    if len(shown.predicted) < 2:
        return whole
    gap = np.abs(np.interp(time, shown.time[0], shown.predicted[0]) - shown.predicted[-1])
    gap = np.where(np.isfinite(gap), gap, 0.0)
    centre, best = float(time[int(np.argmax(gap))]), whole
    for halvings in range(7):
        half = (whole[1] - whole[0]) / 2 ** (halvings + 1)
        start = min(max(centre - half, whole[0]), whole[1] - 2 * half)
        inside = (time >= start) & (time <= start + 2 * half) & np.isfinite(measured)
        if inside.sum() < LEAST:
            break
        best = (start, start + 2 * half)
        if float(np.max(gap[inside])) >= VISIBLE * float(np.ptp(measured[inside])):
            break
    return best


# ---- the picture ----------------------------------------------------------------------------------------------------
def draw(shown: Shown, subject: Subject, height: float = HEIGHT) -> Plot:
    """Readings as points with both models; beneath, the residuals of both over the noise of one reading."""
    seen, below = window(shown), LEFT * height
    plot = Sketch((FULL, height), (16.0, below + 4.0, NAMES, 3.0), label=subject.label, language=subject.language)
    _upper(plot, shown, seen)
    plot.panel((16.0, 10.0, NAMES, height - below))
    _lower(plot, shown, seen)
    return plot.finish(_alt(shown, subject.title), _caption(shown, seen))


def _upper(plot: Sketch, shown: Shown, seen: tuple[float, float]) -> None:
    inside = [(time >= seen[0]) & (time <= seen[1]) for time in shown.time]
    measured = _floats(shown.channel["measured"])[inside[-1]]
    lines = [line[part] for line, part in zip(shown.predicted, inside, strict=True)]
    factor, unit = scale(
        over_time.largest(*(line[np.isfinite(line)] for line in (measured, *lines))), shown.channel["unit"]
    )
    plot.window(seen, over_time.spread(*(line[np.isfinite(line)] for line in (measured, *lines)), factor=factor))
    plot.dots(shown.time[-1][inside[-1]].tolist(), (measured / factor).tolist(), _READING)
    pens = (_STATED, _VALIDATED)
    for time, part, line, pen in zip(shown.time, inside, lines, pens, strict=False):
        over_time.stroke(plot, time[part], line, factor, pen)
    plot.x_axis("")
    plot.y_axis(f"{over_time.symbol(shown.channel)} / {unit}", 5)
    ends = [(name, _last(line) / factor, pen) for name, line, pen in zip(shown.names, lines, pens, strict=False)]
    plot.labels([(said("readings"), _last(measured) / factor, _READING), *ends])


def _lower(plot: Sketch, shown: Shown, seen: tuple[float, float]) -> None:
    pens = (_LEFT_STATED, _LEFT_VALIDATED)
    parts = [(time[(time >= seen[0]) & (time <= seen[1])], line[(time >= seen[0]) & (time <= seen[1])])
             for time, line in zip(shown.time, shown.left, strict=True)]  # fmt: skip
    plot.window(seen, over_time.spread(*(line[np.isfinite(line)] for _, line in parts), (2.5, -2.5), factor=1.0))
    for (time, line), pen in zip(parts, pens, strict=False):
        over_time.stroke(plot, time, line, 1.0, pen)
    for level in (2.0, -2.0):
        plot.line(seen, (level, level), response.LIMIT)
    plot.x_axis(said("time / s"), 8)
    plot.y_axis(said("residual / noise"), 4)
    stated, *validated = map(number, shown.rms)
    names = [
        said("as stated: RMS {rms:figures}", rms=stated),
        *(said("validated: RMS {rms:figures}", rms=rms) for rms in validated),
    ]
    plot.labels([
        ("±2", 2.0, response.LIMIT),
        *((name, 0.0, pen) for name, pen in zip(names, pens, strict=False)),
    ])  # fmt: skip


def _last(line: Any) -> float:
    known = line[np.isfinite(line)]
    return float(known[-1]) if known.size else 0.0


def _caption(shown: Shown, seen: tuple[float, float]) -> str:
    both = (
        "Held-out run {run}, {channel}, {start:figures} s to {stop:figures} s: readings and the model as stated and "
        "the validated model, with the run's own inputs re-estimated. Below: residuals over the noise of one reading; "
        "RMS over the whole run, 1 for noise alone. Neither model was fitted to it."
    )
    one = (
        "Held-out run {run}, {channel}, {start:figures} s to {stop:figures} s: readings and the model, with the run's "
        "own inputs re-estimated. Below: residuals over the noise of one reading; RMS over the whole run, 1 for noise "
        "alone. The model was not fitted to it."
    )
    return said(
        both if len(shown.names) > 1 else one,
        run=plain(shown.run),
        channel=response.NAMES.get(shown.channel["unit"], shown.channel["channel"]),
        start=number(seen[0]),
        stop=number(seen[1]),
    )


def _alt(shown: Shown, title: str) -> str:
    named = zip(shown.names, shown.rms, strict=True)
    values = tuple(said("{name} {rms:figures}", name=name, rms=number(rms)) for name, rms in named)
    text = "{title}, held-out run {run}: readings and models against time. Residual over noise: {values}."
    return said(text, title=title, run=plain(shown.run), values=values)
