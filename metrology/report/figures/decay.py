"""One release: the record, its longitudinal mode, the direct fit, envelope, peaks and noise floor."""

from __future__ import annotations

from typing import Any

import numpy as np

from metrology.decay import DecayRecord
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


def draw(record: DecayRecord, title: str, *, label: str = "") -> Plot:
    """Displacement against time down to where the noise begins, with residuals of the direct fit beneath."""
    time = np.array(record.time)
    shown = time <= _end(record)
    factor, unit = scale(float(np.max(np.abs(record.displacement), initial=0.0)), "m")
    figure = canvas(FULL, 74.0, label=label)
    upper = place(figure, (15.0, 29.0, 1.5, 7.0))
    lower = place(figure, (15.0, 9.0, 1.5, 49.5), sharex=upper)
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
    return finish(figure, _alt(record, title), _caption(record))


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


def _alt(record: DecayRecord, title: str) -> str:
    zeta = estimate(record.zeta_decrement, record.zeta_decrement_u, "%")
    factor, unit = scale(record.noise_floor, "m")
    return (
        f"{title}, {plain(record.record)}: decaying oscillation against time with {sum(record.peak_used)} of "
        f"{len(record.peak_used)} peaks used, above a noise floor of "
        f"{number(record.noise_floor / factor, 2)} {unit}. The envelope falls "
        f"exponentially with ζ = {zeta.value} ± {zeta.u} %; beneath, the longitudinal mode less the direct fit."
    )


def _caption(record: DecayRecord) -> str:
    return (
        f"{plain(record.record)}: displacement as measured, its longitudinal mode, the direct fit, "
        f"and the envelope by the decrement "
        "with the band of ±2 standard uncertainties; beneath, longitudinal mode less direct fit. "
        "Drawn to where the noise begins; "
        "smallest and largest value of each column drawn, so that no spike is lost."
    )
