"""One release of a free-decay test: its record evaluated in both ways, and what the report draws of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan, pi, sqrt
from typing import Any

import numpy as np

from metrology.decay.decrement import (
    FLOOR,
    Decrement,
    Filter,
    best_filter,
    bias,
    by_peaks,
    damping_ratio,
    log_decrement,
    rates,
)
from metrology.decay.finding import DecayRecord
from metrology.decay.hop import without
from metrology.decay.oscillation import Fit, Floats
from metrology.decay.separated import Separated, on_even_steps, without_others
from metrology.decay.start import Unusable
from metrology.message import said
from metrology.timeseries import SCREEN, Channel, Trace, thinned

DRAWN = 1500
"""Samples of a record that are kept for drawing: more than a page can show."""


CLEAR = 10.0
"""Amplitude over the standard deviation of the noise from which on the direct fit alone is a result: three peaks above
five of filtered noise ask for about as much."""


@dataclass(frozen=True)
class Release:
    """One usable record: taken apart, and its decrement by peaks, or why it has none.

    `filter` is the one used and `bias` what it does to ζ, where there are peaks.
    """

    record: Channel
    separated: Separated
    decrement: Decrement | None
    bias: float = 0.0
    filter: Filter | None = field(repr=False, default=None)
    without: str = ""

    @property
    def fitted_delta(self) -> float:
        """Log decrement by the direct fit."""
        main = self.separated.fit.main
        return log_decrement(main.rate, main.omega)

    @property
    def fitted(self) -> tuple[Floats, Floats]:
        """δ = 2π·λ/ω_d and ω_d by the direct fit, and their covariance, shape (2, 2)."""
        main, covariance = self.separated.fit.main, self.separated.fit.covariance
        slopes = np.array([[-self.fitted_delta / main.omega, 2 * pi / main.omega], [1.0, 0.0]])
        return np.array([self.fitted_delta, main.omega]), slopes @ covariance @ slopes.T

    @property
    def least(self) -> float:
        """Smallest amplitude used, in the unit of the record; without peaks the largest."""
        if self.decrement is None:
            return float(self.separated.fit.amplitudes[0])
        return float(self.decrement.size[self.decrement.used.index(False) - 1 if False in self.decrement.used else -1])

    @property
    def fitted_zeta(self) -> float:
        """Damping ratio by the direct fit."""
        return damping_ratio(self.fitted_delta)


def evaluate(record: Channel, separated: Separated | Unusable) -> Release:
    """Evaluate one record by peaks and by direct fit, from what `separation.separate` made of it or why it could not.

    Raises
    ------
    Unusable
        When the record has no decay that can be evaluated.
    """
    if isinstance(separated, Unusable):
        raise separated
    record = without(record, separated.hops)
    try:
        even = on_even_steps(separated)
        chosen = best_filter(even)
        decrement = by_peaks(even, chosen)
    except Unusable as reason:
        # A record with a handful of swings, or none to filter, has its direct fit all the same where that is no noise.
        if separated.fit.amplitudes[0] < CLEAR * separated.noise:
            raise
        return Release(record, separated, None, without=reason.args[0])
    return Release(record, separated, decrement, bias(even, decrement, chosen.taps), chosen)


def fitted_zeta_u(fit: Fit) -> float:
    """Return the standard uncertainty of ζ = λ/√(λ² + ω_d²) from the covariance of ω_d and λ of a direct fit."""
    rate, omega = fit.main.rate, fit.main.omega
    slope = np.array([-rate * omega, omega**2]) / (omega**2 + rate**2) ** 1.5
    return sqrt(float(slope @ fit.covariance @ slope))


def drawn(release: Release, *, mains: float) -> DecayRecord:
    """Return the record of the report: time zero at the release, thinned for drawing."""
    separated, fit = release.separated, release.separated.fit
    start, free = separated.release, float(separated.free.time[0])
    columns = _columns(release)
    index = thinned(columns["displacement"], DRAWN)
    residual = np.zeros(columns["time"].size)  # also before the first sample fitted, and where an outlier is masked
    residual[np.searchsorted(columns["time"], separated.free.time - start - 1e-9 * separated.free.step)] = fit.residual
    return DecayRecord(
        record=release.record.name,
        time=_tuple(columns["time"][index]),
        displacement=_tuple(columns["displacement"][index]),
        filtered=_tuple(columns["filtered"][index]),
        fit=_tuple(columns["fit"][index]),
        zeta_fit=release.fitted_zeta,
        zeta_fit_u=fitted_zeta_u(fit),
        omega_fit=fit.main.omega,
        omega_fit_u=sqrt(fit.covariance[0, 0]),
        residual=_tuple(residual[index]),
        fitted_from=free - start,
        noise=separated.noise,
        others=separated.describe(mains),
        sentence=release.without and said("By direct fit alone. {reason}", reason=release.without),
        count=release.record.time.size,
        unit=release.record.unit,
        **_by_decrement(release),
    )


def _by_decrement(release: Release) -> dict[str, Any]:
    """Return what a record has by its peaks; NaN and nothing to draw where there are none."""
    start, decrement = release.separated.release, release.decrement
    if decrement is None or release.filter is None:
        names = ("log_decrement", "zeta_decrement", "zeta_decrement_u", "omega_decrement", "omega_decrement_u")
        empty = ("peak_time", "peak_amplitude", "peak_used", "amplitude", "rate", "rate_u")
        floor = FLOOR * release.separated.noise
        return dict.fromkeys(names, nan) | dict.fromkeys(empty, ()) | {"noise_floor": floor, "filter_bias": 0.0}
    against = rates(decrement)
    return {
        "peak_time": _tuple(decrement.time - start),
        "peak_amplitude": _tuple(decrement.size),
        "peak_used": decrement.used,
        "noise_floor": decrement.floor,
        "log_decrement": decrement.delta,
        "zeta_decrement": decrement.zeta,
        "zeta_decrement_u": decrement.zeta_u,
        "omega_decrement": decrement.omega,
        "omega_decrement_u": sqrt(decrement.covariance[1, 1]),
        "amplitude": _tuple(against.amplitude),
        "rate": _tuple(against.rate),
        "rate_u": _tuple(against.rate_u),
        "filter_bias": release.bias,
        "frequency": _tuple(against.omega),
        "frequency_u": _tuple(against.omega_u),
        "filtered_from": float(decrement.filtered.time[0]) - start,
        "filter_length": 2 * release.filter.half * release.separated.free.step,
    }


def trace(release: Release) -> Trace:
    """Return every sample of the record for the screen, time zero at the release; before it only as measured."""
    record, columns = release.record, _columns(release)
    before = np.full(record.time.size - columns["time"].size, np.nan)
    whole = {name: np.concatenate([before, column]) for name, column in columns.items()}
    whole |= {"time": record.time - release.separated.release, "displacement": record.value}
    index = thinned(record.value, SCREEN)
    return {name: column[index] for name, column in whole.items()}


def _columns(release: Release) -> dict[str, Floats]:
    """Return what is drawn of the record from its release on, sample by sample."""
    start, free = release.separated.release, float(release.separated.free.time[0])
    shown = release.record.part(start)
    return {
        "time": shown.time - start,
        "displacement": shown.value,
        "filtered": _longitudinal(release, shown),
        "fit": release.separated.fit.part(shown.time - free),
    }


def _longitudinal(release: Release, shown: Channel) -> Floats:
    """Return the filtered record; where the filter has no full support, the record less all else that was fitted."""
    value = without_others(release.separated, shown)
    if release.decrement is not None:
        filtered = release.decrement.filtered
        inside = (shown.time > filtered.time[0] - 1e-12) & (shown.time < filtered.time[-1] + 1e-12)
        value[inside] = np.interp(shown.time[inside], filtered.time, filtered.value)
    return value


def _tuple(values: Floats) -> tuple[float, ...]:
    return tuple(values.tolist())
