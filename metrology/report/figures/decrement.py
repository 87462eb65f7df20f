"""Logarithm of the peaks against time: its slope is the decay rate ζω_n."""

from __future__ import annotations

from math import exp, log10

import numpy as np

from metrology.decay import DecayFinding, DecayRecord
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import number
from metrology.message import said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, GREY, HALF, INK, MARKERS, ORANGE, Plot, plain

_LINE, _FLOOR = Pen(stroke=INK, width=0.6), Pen(stroke=INK, width=0.5, dash=(0.5, 0.9))


def draw(finding: DecayFinding, title: str, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Peaks of every release on a logarithmic scale, with the regression line and its band for each."""
    plot = Sketch((HALF, 46.0), (14.5, 9.5, 1.5, 3.0), label=label, language=language)
    records = [record for record in finding.records if any(record.peak_used)]
    ends = [_seen(record)[-1] for record in records]
    depth = min((_lowest(record) for record in records), default=-1.0)
    lowest = 1.08 * depth
    plot.window((0.0, max(ends, default=1.0) * 1.03), (lowest, -0.08 * depth))
    for index, record in enumerate(records):
        _record(plot, record, index, lowest)
    plot.x_axis(said("time / s"), 5)
    plot.y_decades(said("peak amplitude / first peak"))
    return plot.finish(_alt(finding, title), said(_CAPTION))


def _first(record: DecayRecord) -> float:
    return next(size for size, used in zip(record.peak_amplitude, record.peak_used, strict=True) if used)


def _lowest(record: DecayRecord) -> float:
    """Logarithm of the smallest peak used over the first, and of the noise floor where that lies close below."""
    peaks = [size for size, used in zip(record.peak_amplitude, record.peak_used, strict=True) if used and size > 0]
    last = log10(min(peaks) / _first(record))
    floor = log10(record.noise_floor / _first(record)) if record.noise_floor > 0 else last
    return min(last, floor, -0.05) if floor > 1.5 * last else min(last, -0.05)


def _seen(record: DecayRecord) -> list[float]:
    """Times of the peaks used, and of those not used that follow closely."""
    last = max(t for t, used in zip(record.peak_time, record.peak_used, strict=True) if used)
    return [t for t in record.peak_time if t <= 1.25 * last]


def _record(plot: Sketch, record: DecayRecord, index: int, lowest: float) -> None:
    used = np.array(record.peak_used, bool)
    time, peaks = np.array(record.peak_time), np.array(record.peak_amplitude) / _first(record)
    rate = record.zeta_decrement * record.omega_decrement
    span = np.linspace(time[used][0], time[used][-1], 40)
    middle, height = float(np.mean(time[used])), float(np.mean(np.log(peaks[used])))
    to_ten = log10(exp(1.0))
    line = to_ten * (height - rate * (span - middle))
    half = to_ten * 2 * record.zeta_decrement_u * record.omega_decrement * np.abs(span - middle)
    plot.band(span.tolist(), np.maximum(line - half, lowest).tolist(), np.maximum(line + half, lowest).tolist(), BAND)
    plot.line(span.tolist(), np.maximum(line, lowest).tolist(), _LINE)
    shape, colour = MARKERS[index % len(MARKERS)], (BLUE, ORANGE, GREY)[index % 3]
    logs = np.log10(np.where(peaks > 0, peaks, 1e-300))
    plot.dots(time[used].tolist(), logs[used].tolist(), Mark(shape, colour, 2.4))
    rest = ~used & (time <= 1.25 * time[used][-1])
    plot.dots(time[rest].tolist(), logs[rest].tolist(), Mark(shape, colour, 2.4, hollow=True))
    if record.noise_floor > 0:
        plot.level(log10(record.noise_floor / _first(record)), _FLOOR)


def _alt(finding: DecayFinding, title: str) -> str:
    rates = ", ".join(
        f"{number(r.zeta_decrement * r.omega_decrement)} ± {number(r.zeta_decrement_u * r.omega_decrement, 2)}"
        for r in finding.records
        if r.has_peaks
    )
    names = tuple(plain(record.record, 40) for record in finding.records)
    falling = (
        "{title}: peak amplitudes on a logarithmic scale against time for {names:comma}. The points follow straight "
        "lines that fall with {rates:figures} per second; points below the dotted noise floor are not used."
    )
    none = (
        "{title}: peak amplitudes on a logarithmic scale against time for {names:comma}. The points follow straight "
        "lines that fall with no rate per second; points below the dotted noise floor are not used."
    )
    return said(falling if rates else none, title=title, names=names, rates=rates)


_CAPTION = (
    "Peaks of every release (one marker each, hollow where not used) on a logarithmic scale, with "
    "the regression line, its band of "
    "±2 standard uncertainties of the slope, and the noise floor (dotted) where it lies near."
)
