"""Logarithm of the peaks against time: its slope is the decay rate ζω_n."""

from __future__ import annotations

from typing import Any

import numpy as np

from metrology.decay import DecayFinding, DecayRecord
from metrology.report.display import number
from metrology.report.figures.style import (
    BAND,
    BLUE,
    GREY,
    HALF,
    INK,
    MARKERS,
    ORANGE,
    Plot,
    canvas,
    finish,
    place,
    plain,
)


def draw(finding: DecayFinding, title: str, *, label: str = "") -> Plot:
    """Peaks of every release on a logarithmic scale, with the regression line and its band for each."""
    figure = canvas(HALF, 50.0, label=label)
    axes = place(figure, (14.5, 9.0, 1.5, 3.0))
    for index, record in enumerate(finding.records):
        _record(axes, record, index)
    axes.set_yscale("log")
    axes.set_ylabel("peak amplitude / first peak")
    axes.set_xlabel("time / s")
    axes.yaxis.set_major_formatter(lambda value, _position: f"{value:g}")
    axes.yaxis.set_minor_formatter(lambda _value, _position: "")
    return finish(figure, _alt(finding, title), _CAPTION)


def _record(axes: Any, record: DecayRecord, index: int) -> None:
    time, peaks, used = np.array(record.peak_time), np.array(record.peak_amplitude), np.array(record.peak_used, bool)
    if not used.any():
        return
    first = peaks[used][0]
    rate = record.zeta_decrement * record.omega_decrement
    span = np.linspace(time[used][0], time[used][-1], 40)
    middle, height = float(np.mean(time[used])), float(np.mean(np.log(peaks[used] / first)))
    line = np.exp(height - rate * (span - middle))
    spread = np.exp(2 * record.zeta_decrement_u * record.omega_decrement * np.abs(span - middle))
    axes.fill_between(span, line / spread, line * spread, color=BAND, lw=0)
    axes.plot(span, line, color=INK, lw=0.6)
    marker, colour = MARKERS[index % len(MARKERS)], (BLUE, ORANGE, GREY)[index % 3]
    axes.plot(time[used], peaks[used] / first, marker, color=colour, ms=2.4, mew=0.5, ls="none")
    shown = ~used & (time <= 1.25 * time[used][-1]) & (peaks > 0)
    axes.plot(time[shown], peaks[shown] / first, marker, color=colour, mfc="none", ms=2.4, mew=0.5, ls="none")
    axes.axhline(record.noise_floor / first, color=INK, lw=0.5, ls=(0, (1, 1.5)))


def _alt(finding: DecayFinding, title: str) -> str:
    rates = ", ".join(
        f"{number(r.zeta_decrement * r.omega_decrement)} ± {number(r.zeta_decrement_u * r.omega_decrement, 2)}"
        for r in finding.records
    )
    names = ", ".join(plain(record.record, 40) for record in finding.records)
    return (
        f"{title}: peak amplitudes on a logarithmic scale against time for {names}. The points follow "
        f"straight lines that fall with "
        f"{rates} per second; points below the dotted noise floor are not used."
    )


_CAPTION = (
    "Peaks of every release (one marker each, hollow where not used) on a logarithmic scale, with "
    "the regression line, its band of "
    "±2 standard uncertainties of the slope, and the noise floor (dotted)."
)
