"""Releases of a test: record, longitudinal mode, direct fit, envelope, peaks and noise floor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.coordinate import SENSED
from metrology.decay import DecayFinding, DecayRecord
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import estimate, number, scale
from metrology.message import said
from metrology.report.figures import damping, decrement
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, FULL, GREY, INK, NAMES, ORANGE, PALE, Plot, decimate, plain
from metrology.report.figures.zoom import as_json, packed

if TYPE_CHECKING:
    from metrology.report.figures import Job, Subject
    from metrology.timeseries import Trace

MOST = 12
"""Releases drawn beneath the first; the table has them all."""
_ACROSS = 4
_LARGE, _SMALL = 600, 200
"""Columns of a line in the large panel and in a small one."""
_OTHERS = (
    "The other releases, as measured and their longitudinal mode; drawn to where the noise begins. The certificate has "
    "the first."
)
_RAW, _MODE = Pen(stroke=PALE, width=1.4), Pen(stroke=BLUE, width=0.7)
_FIT, _FALL = Pen(stroke=ORANGE, width=0.7, dash=(3.0, 2.0)), Pen(stroke=INK, width=0.6)
_FLOOR, _ZERO = Pen(stroke=INK, width=0.6, dash=(0.6, 1.2)), Pen(stroke=GREY, width=0.5)


def jobs(finding: DecayFinding, subject: Subject) -> Iterator[Job]:
    """The plots of a test: its records, their decrement, and the decay rate against amplitude."""
    test, title = subject.test, subject.title
    known: dict[str, Any] = {"label": subject.label, "language": subject.language}
    drawn = [record for record in finding.records if record.time]
    traces = subject.of(f"decay/{test}")
    if drawn and not subject.certified:
        yield f"decay/{test}", partial(draw, finding, title, traces=traces, **known)
    elif drawn[1:]:
        yield f"decay/{test}", partial(draw_others, finding, title, traces=traces, **known)
    if finding.records:
        yield f"decrement/{test}", partial(decrement.draw, finding, title, **known)
        yield f"damping/{test}", partial(damping.draw, finding, title, **known)


def story(finding: DecayFinding, subject: Subject) -> Iterator[Job]:
    """The first release alone, for the certificate."""
    if any(record.time for record in finding.records):
        yield "story", partial(draw, finding, subject.title, label=subject.label, most=0, language=subject.language)


def draw(
    finding: DecayFinding, title: str, *, label: str = "", traces: Mapping[str, Trace] = MappingProxyType({}),
    most: int = MOST, language: Language = ENGLISH,
) -> Plot:  # fmt: skip
    """The first release in full, with residuals of its direct fit beneath; at most so many others as small panels.

    `traces`: every sample by record, for the plots that can be zoomed.
    """
    first, *others = [record for record in finding.records if record.time]
    others = others[:most]
    below = _room(others)
    height = (88.0 if not most else 60.0) + below
    plot = Sketch(
        (FULL, height), (15.0, (36.0 if not most else 30.0) + below, NAMES, 2.0), label=label, language=language
    )
    _large(plot, first)
    plot.panel((15.0, 9.5 + below, NAMES, (60.0 if not most else 35.0)))
    _residual(plot, first)
    _panels(plot, others, height)
    panels = [_zoomed(record, traces.get(record.record, {}), language) for record in (first, *others)]
    return replace(
        plot.finish(_alt(finding, title), _caption(first, len(others))), series=as_json(panels, beneath=True)
    )


def draw_others(
    finding: DecayFinding, title: str, *, label: str = "", traces: Mapping[str, Trace] = MappingProxyType({}),
    language: Language = ENGLISH,
) -> Plot:  # fmt: skip
    """All releases but the first, as small panels; `traces` as for `draw`."""
    others = [record for record in finding.records if record.time][1:][:MOST]
    height = _room(others)
    plot = Sketch((FULL, height), (0.0, 0.0, 0.0, 0.0), label=label, language=language)
    _panels(plot, others, height)
    panels = [_zoomed(record, traces.get(record.record, {}), language) for record in others]
    return replace(plot.finish(_alt(finding, title), said(_OTHERS)), series=as_json(panels, beneath=True))


def _room(others: Sequence[DecayRecord]) -> float:
    """Height of so many small panels, in mm."""
    return 22.0 * -(-len(others) // _ACROSS) + (7.0 if others else 0.0)


def _panels(plot: Sketch, others: Sequence[DecayRecord], height: float) -> None:
    """Small panels at the foot of a plot of this height."""
    span = (min(map(_start, others), default=0.0), max(map(_end, others), default=1.0))
    for index, record in enumerate(others):
        down, across = divmod(index, _ACROSS)
        left, low = 15.0 + 39.5 * across, 7.0 + _room(others) - 22.0 * (down + 1)
        plot.panel((left, low, 135.0 - 39.5 * across, height - low - 10.8))
        _small(plot, record, span, first=across == 0, bottom=index + _ACROSS >= len(others))


def _zoomed(record: DecayRecord, trace: Trace, language: Language) -> dict[str, Any]:
    """Every sample that there is of a record, for the plot that can be zoomed, which stands beneath the still one."""
    factor, unit = scale(max(map(abs, record.displacement), default=0.0), record.unit)
    lines = {"displacement": (language.say("measured"), "measured"),
             "filtered": (language.say("longitudinal mode"), "mode"),
             "fit": (language.say("direct fit"), "before")}  # fmt: skip
    known = {"measured": {"u": record.noise / factor}} if record.noise else {}
    return {
        "name": plain(record.record, 40),
        "title": language.say("{quantity} / {unit}", quantity=_word(record), unit=unit),
        "count": record.count,
        "time": packed(_column(record, trace, "time")),
        "curves": [
            {"name": name, "role": role, "y": packed(_column(record, trace, key), factor), **known.get(role, {})}
            for key, (name, role) in lines.items()
        ],
    }


def _column(record: DecayRecord, trace: Trace, key: str) -> Iterable[float]:
    """A column of the trace, or where there is none, what the findings keep of it."""
    kept: Iterable[float] = getattr(record, key)
    return trace.get(key, kept)


def _large(plot: Sketch, record: DecayRecord) -> None:
    time = np.array(record.time)
    shown = time <= _end(record)
    factor, unit = scale(max(map(abs, record.displacement), default=0.0), record.unit)
    values = {key: np.array(getattr(record, key))[shown] / factor for key in ("displacement", "filtered", "fit")}
    values["filtered"] = np.where(time[shown] >= record.filtered_from, values["filtered"], np.nan)
    reach = 1.05 * max(float(np.nanmax(np.abs(line), initial=0.0)) for line in values.values()) or 1.0
    plot.window((float(time[0]), float(time[shown][-1])), (-reach, reach))
    mark = Mark("o", BLUE, 2.6 if sum(record.peak_used) < 60 else 1.6)
    _envelope(plot, record, factor, reach)
    for key, pen in (("displacement", _RAW), ("filtered", _MODE), ("fit", _FIT)):
        _stroke(plot, time[shown], values[key], pen, _LARGE)
    _peaks(plot, record, factor, mark)
    plot.x_axis("")
    plot.y_axis(said("{quantity} / {unit}", quantity=_word(record), unit=unit), 4)
    names = (
        said("envelope ±2u"), said("as measured"), said("longitudinal mode"), said("direct fit"), said("peaks used"),
        said("noise floor"),
    )  # fmt: skip
    floor = record.noise_floor / factor
    heights = (0.0, 0.0, 0.0, 0.0, reach, -floor)
    plot.labels(zip(names, heights, (_FALL, _RAW, _MODE, _FIT, mark, _FLOOR), strict=True))


def _stroke(plot: Sketch, time: Any, values: Any, pen: Pen, columns: int) -> None:
    ((x, y),) = decimate(time, values, columns=columns)
    plot.line(x.tolist(), y.tolist(), pen)


def _small(plot: Sketch, record: DecayRecord, span: tuple[float, float], *, first: bool, bottom: bool) -> None:
    """One release; all share a span of time, for only the lowest of a column has numbers on its axis."""
    time = np.array(record.time)
    shown = time <= _end(record)
    factor, unit = scale(max(map(abs, record.displacement), default=0.0), record.unit)
    raw, mode = np.array(record.displacement)[shown] / factor, np.array(record.filtered)[shown] / factor
    mode = np.where(time[shown] >= record.filtered_from, mode, np.nan)
    reach = 1.05 * float(np.max(np.abs(raw), initial=0.0)) or 1.0
    plot.window(span, (-reach, reach))
    _stroke(plot, time[shown], raw, Pen(stroke=PALE, width=1.2), _SMALL)
    _stroke(plot, time[shown], mode, Pen(stroke=BLUE, width=0.5), _SMALL)
    plot.note(plain(record.record, 32), span[0], rise=3.0)
    plot.x_axis(said("time / s") if bottom else "", 3)
    plot.y_axis(unit if first else "", 2)


def _word(record: DecayRecord) -> str:
    return SENSED[record.unit].word


def _start(record: DecayRecord) -> float:
    return float(record.time[0])


def _end(record: DecayRecord) -> float:
    used = [t for t, ok in zip(record.peak_time, record.peak_used, strict=True) if ok]
    last = record.time[-1] if record.time else 0.0
    return min(last, 1.25 * used[-1]) if used else last


def _envelope(plot: Sketch, record: DecayRecord, factor: float, reach: float) -> None:
    used = np.array(record.peak_used, bool)
    if not used.any():
        return
    t, a = np.array(record.peak_time)[used], np.array(record.peak_amplitude)[used]
    rate = record.zeta_decrement * record.omega_decrement
    rate_u = np.hypot(
        record.zeta_decrement_u * record.omega_decrement, record.zeta_decrement * record.omega_decrement_u
    )
    middle, height = float(np.mean(t)), float(np.mean(np.log(a)))
    span = np.linspace(record.time[0], _end(record), 120)
    envelope = np.exp(height - rate * (span - middle)) / factor
    spread = np.exp(2 * rate_u * np.abs(span - middle))
    low, high = np.minimum(envelope / spread, reach), np.minimum(envelope * spread, reach)
    seen = np.where(envelope <= reach, envelope, np.nan)
    for sign in (1.0, -1.0):
        plot.band(span.tolist(), (sign * low).tolist(), (sign * high).tolist(), BAND)
        plot.line(span.tolist(), (sign * seen).tolist(), _FALL)


def _peaks(plot: Sketch, record: DecayRecord, factor: float, mark: Mark) -> None:
    time, used = np.array(record.peak_time), np.array(record.peak_used, bool)
    height = np.copysign(np.array(record.peak_amplitude), np.interp(time, record.time, record.filtered)) / factor
    inside = time <= _end(record)
    plot.dots(time[used & inside].tolist(), height[used & inside].tolist(), mark)
    rest = ~used & inside
    plot.dots(time[rest].tolist(), height[rest].tolist(), Mark("o", GREY, mark.size, hollow=True))
    for sign in (1.0, -1.0):
        plot.level(sign * record.noise_floor / factor, _FLOOR)


def _residual(plot: Sketch, record: DecayRecord) -> None:
    time = np.array(record.time)
    shown = (time <= _end(record)) & (time >= record.filtered_from)
    residual = (np.array(record.filtered) - np.array(record.fit))[shown]
    factor, unit = scale(float(np.nanmax(np.abs(residual), initial=0.0)), record.unit)
    low, high = float(np.nanmin(residual, initial=0.0)) / factor, float(np.nanmax(residual, initial=0.0)) / factor
    margin = 0.05 * (high - low)
    plot.window((float(time[0]), float(time[time <= _end(record)][-1])), (low - margin, high + margin))
    plot.level(0.0, _ZERO)
    _stroke(plot, time[shown], residual / factor, Pen(stroke=BLUE, width=0.5), _LARGE)
    plot.x_axis(said("time / s"), 8)
    plot.y_axis(said("residual / {unit}", unit=unit), 2)


def _alt(finding: DecayFinding, title: str) -> str:
    words = []
    for record in finding.records:
        zeta = estimate(*record.zeta, "%")
        factor, unit = scale(record.noise_floor, record.unit)
        text = (
            "{record}: {used} of {peaks} peaks used above a noise floor of {floor:figures} {unit}, "
            "ζ = {zeta:figures} ± {u:figures} %"
        )
        words.append(said(
            text, record=plain(record.record), used=sum(record.peak_used), peaks=len(record.peak_used),
            floor=number(record.noise_floor / factor, 2), unit=unit, zeta=zeta.value, u=zeta.u,
        ))  # fmt: skip
    text = (
        "{title}: decaying oscillations against time, envelopes falling exponentially. {records}. Beneath the first, "
        "its longitudinal mode less the direct fit."
    )
    return said(text, title=title, records=tuple(words))


def _caption(first: DecayRecord, others: int) -> str:
    alone = (
        "{record}: {quantity} as measured, its longitudinal mode, the direct fit, and the envelope by the decrement "
        "with the band of ±2 standard uncertainties; beneath, longitudinal mode less direct fit. Drawn to where the "
        "noise begins; smallest and largest value of each column drawn, so that no spike is lost."
    )
    several = (
        "{record}: {quantity} as measured, its longitudinal mode, the direct fit, and the envelope by the decrement "
        "with the band of ±2 standard uncertainties; beneath, longitudinal mode less direct fit. Small panels: the "
        "other releases, as measured and their longitudinal mode. Drawn to where the noise begins; smallest and "
        "largest value of each column drawn, so that no spike is lost."
    )
    return said(several if others else alone, record=plain(first.record), quantity=_word(first))
