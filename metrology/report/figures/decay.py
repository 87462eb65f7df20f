"""Releases of a test: record, longitudinal mode, direct fit, envelope, peaks and noise floor."""

from __future__ import annotations

from typing import Any

import numpy as np

from metrology.decay import DecayFinding, DecayRecord
from metrology.report.display import estimate, number, scale
from metrology.report.figures.style import (
    BAND,
    BLUE,
    FULL,
    GREY,
    INK,
    ORANGE,
    PALE,
    Plot,
    canvas,
    decimate,
    finish,
    legend,
    place,
    plain,
)

MOST = 12
"""Releases drawn beneath the first; the table has them all."""
_ACROSS = 4
_SMALL = 250
"""Columns of pixels of a small panel."""


def draw(finding: DecayFinding, title: str, *, label: str = "") -> Plot:
    """The first release in full, with residuals of its direct fit beneath; the others as small panels."""
    first, *others = [record for record in finding.records if record.time]
    others = others[:MOST]
    below = 26.0 * -(-len(others) // _ACROSS) + (2.0 if others else 0.0)
    figure = canvas(FULL, 62.0 + below, label=label)
    upper = place(figure, (15.0, 25.0 + below, 1.5, 7.0))
    lower = place(figure, (15.0, 9.0 + below, 1.5, 41.0), sharex=upper)
    _large(upper, lower, first)
    for index, record in enumerate(others):
        down, across = divmod(index, _ACROSS)
        left, low = 15.0 + 39.5 * across, 7.0 + below - 26.0 * (down + 1)
        panel = place(figure, (left, low, 135.0 - 39.5 * across, 62.0 + below - low - 15.0))
        _small(panel, record, first=across == 0, bottom=index + _ACROSS >= len(others))
    return finish(figure, _alt(finding, title), _caption(first, len(others)))


def _large(upper: Any, lower: Any, record: DecayRecord) -> None:
    time = np.array(record.time)
    shown = time <= _end(record)
    factor, unit = scale(float(np.max(np.abs(record.displacement), initial=0.0)), "m")
    filtered, fit = np.array(record.filtered)[shown], np.array(record.fit)[shown]
    _envelope(upper, record, time[shown], factor)
    raw, mode, fitted = decimate(time[shown], np.array(record.displacement)[shown], filtered, fit)
    upper.plot(raw[0], raw[1] / factor, color=PALE, lw=1.4, label="as measured")
    upper.plot(mode[0], mode[1] / factor, color=BLUE, lw=0.7, label="longitudinal mode")
    upper.plot(fitted[0], fitted[1] / factor, color=ORANGE, lw=0.7, ls=(0, (3, 2)), label="direct fit")
    _peaks(upper, record, factor)
    upper.set_ylabel(f"displacement / {unit}")
    upper.tick_params(labelbottom=False)
    legend(upper, 7)
    _residual(lower, time[shown], filtered - fit)


def _small(axes: Any, record: DecayRecord, *, first: bool, bottom: bool) -> None:
    time = np.array(record.time)
    shown = time <= _end(record)
    factor, unit = scale(float(np.max(np.abs(record.displacement), initial=0.0)), "m")
    for values, colour, width in ((record.displacement, PALE, 1.2), (record.filtered, BLUE, 0.5)):
        ((x, y),) = decimate(time[shown], np.array(values)[shown], columns=_SMALL)
        axes.plot(x, y / factor, color=colour, lw=width)
    axes.text(1.0, 1.03, plain(record.record, 32), ha="right", va="bottom", fontsize=5.5, transform=axes.transAxes)
    axes.tick_params(labelsize=5.5)
    if first:
        axes.set_ylabel(f"displacement / {unit}", fontsize=6)
    if bottom:
        axes.set_xlabel("time / s", fontsize=6, labelpad=1)


def _end(record: DecayRecord) -> float:
    used = [t for t, ok in zip(record.peak_time, record.peak_used, strict=True) if ok]
    last = record.time[-1] if record.time else 0.0
    return min(last, 1.25 * used[-1]) if used else last


def _envelope(axes: Any, record: DecayRecord, time: Any, factor: float) -> None:
    used = np.array(record.peak_used, bool)
    if not used.any():
        return
    t, a = np.array(record.peak_time)[used], np.array(record.peak_amplitude)[used]
    rate = record.zeta_decrement * record.omega_decrement
    rate_u = np.hypot(
        record.zeta_decrement_u * record.omega_decrement, record.zeta_decrement * record.omega_decrement_u
    )
    middle, height = float(np.mean(t)), float(np.mean(np.log(a)))
    span = np.linspace(time[0], time[-1], 120)
    envelope = np.exp(height - rate * (span - middle)) / factor
    spread = np.exp(2 * rate_u * np.abs(span - middle))
    for sign in (1.0, -1.0):
        axes.fill_between(span, sign * envelope / spread, sign * envelope * spread, color=BAND, lw=0)
        axes.plot(span, sign * envelope, color=INK, lw=0.6, label="envelope ±2u" if sign > 0 else None)


def _peaks(axes: Any, record: DecayRecord, factor: float) -> None:
    time, used = np.array(record.peak_time), np.array(record.peak_used, bool)
    filtered = np.interp(time, record.time, record.filtered)
    height = np.copysign(np.array(record.peak_amplitude), filtered) / factor
    inside = time <= _end(record)
    size = 2.6 if used.sum() < 60 else 1.6
    axes.plot(time[used & inside], height[used & inside], "o", color=BLUE, ms=size, ls="none", label="peaks used")
    rest = ~used & inside
    if rest.any():
        axes.plot(time[rest], height[rest], "o", color=GREY, mfc="none", mew=0.6, ms=size, ls="none", label="not used")
    floor = record.noise_floor / factor
    axes.axhline(floor, color=INK, lw=0.6, ls=(0, (1, 1.5)), label="noise floor")
    axes.axhline(-floor, color=INK, lw=0.6, ls=(0, (1, 1.5)))


def _residual(axes: Any, time: Any, residual: Any) -> None:
    factor, unit = scale(float(np.nanmax(np.abs(residual), initial=0.0)), "m")
    ((x, y),) = decimate(time, residual)
    axes.axhline(0.0, color=GREY, lw=0.5)
    axes.plot(x, y / factor, color=BLUE, lw=0.5)
    axes.set_ylabel(f"residual / {unit}")
    axes.set_xlabel("time / s")


def _alt(finding: DecayFinding, title: str) -> str:
    words = []
    for record in finding.records:
        zeta = estimate(record.zeta_decrement, record.zeta_decrement_u, "%")
        factor, unit = scale(record.noise_floor, "m")
        words.append(
            f"{plain(record.record)}: {sum(record.peak_used)} of {len(record.peak_used)} peaks used above a noise "
            f"floor of {number(record.noise_floor / factor, 2)} {unit}, ζ = {zeta.value} ± {zeta.u} %"
        )
    return (
        f"{title}: decaying oscillations against time, envelopes falling exponentially. {'; '.join(words)}. "
        "Beneath the first, its longitudinal mode less the direct fit."
    )


def _caption(first: DecayRecord, others: int) -> str:
    small = " Small panels: the other releases, as measured and their longitudinal mode." if others else ""
    return (
        f"{plain(first.record)}: displacement as measured, its longitudinal mode, the direct fit, and the envelope by "
        "the decrement with the band of ±2 standard uncertainties; beneath, longitudinal mode less direct fit."
        f"{small} Drawn to where the noise begins; smallest and largest value of each column drawn, so that no spike "
        "is lost."
    )
