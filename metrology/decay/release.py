"""One release of a free-decay test: its record evaluated in both ways, and what the report draws of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from metrology.decay.decrement import (
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
from metrology.decay.oscillation import Fit, Floats
from metrology.decay.separation import Separated, Unusable, without_others
from metrology.timeseries import SCREEN, Channel, Trace, thinned

DRAWN = 1500
"""Samples of a record that are kept for drawing: more than a page can show."""


@dataclass(frozen=True)
class Release:
    """One usable record: taken apart, its decrement by peaks, the filter used, and what that does to ζ (`bias`)."""

    record: Channel
    separated: Separated
    decrement: Decrement
    bias: float
    filter: Filter = field(repr=False)

    @property
    def fitted_delta(self) -> float:
        """Log decrement by the direct fit."""
        main = self.separated.fit.main
        return log_decrement(main.rate, main.omega)

    @property
    def least(self) -> float:
        """Smallest amplitude used, in m."""
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
    chosen = best_filter(separated)
    decrement = by_peaks(separated, chosen)
    return Release(record, separated, decrement, bias(separated, decrement, chosen.taps), chosen)


def fitted_zeta_u(fit: Fit) -> float:
    """Return the standard uncertainty of ζ = λ/√(λ² + ω_d²) from the covariance of ω_d and λ of a direct fit."""
    rate, omega = fit.main.rate, fit.main.omega
    slope = np.array([-rate * omega, omega**2]) / (omega**2 + rate**2) ** 1.5
    return sqrt(float(slope @ fit.covariance @ slope))


def drawn(release: Release, *, mains: float) -> DecayRecord:
    """Return the record of the report: time zero at the release, thinned for drawing."""
    separated, decrement, fit = release.separated, release.decrement, release.separated.fit
    start, free = separated.release, float(separated.free.time[0])
    columns = _columns(release)
    index = thinned(columns["displacement"], DRAWN)
    residual = np.concatenate([np.zeros(columns["time"].size - separated.t.size), fit.residual])
    against = rates(decrement)
    return DecayRecord(
        record=release.record.name,
        time=_tuple(columns["time"][index]),
        displacement=_tuple(columns["displacement"][index]),
        filtered=_tuple(columns["filtered"][index]),
        fit=_tuple(columns["fit"][index]),
        peak_time=_tuple(decrement.time - start),
        peak_amplitude=_tuple(decrement.size),
        peak_used=decrement.used,
        noise_floor=decrement.floor,
        log_decrement=decrement.delta,
        zeta_decrement=decrement.zeta,
        zeta_decrement_u=decrement.zeta_u,
        omega_decrement=decrement.omega,
        omega_decrement_u=sqrt(decrement.covariance[1, 1]),
        zeta_fit=release.fitted_zeta,
        zeta_fit_u=fitted_zeta_u(fit),
        omega_fit=fit.main.omega,
        omega_fit_u=sqrt(fit.covariance[0, 0]),
        amplitude=_tuple(against.amplitude),
        rate=_tuple(against.rate),
        rate_u=_tuple(against.rate_u),
        filter_bias=release.bias,
        frequency=_tuple(against.omega),
        frequency_u=_tuple(against.omega_u),
        residual=_tuple(residual[index]),
        fitted_from=free - start,
        filtered_from=float(decrement.filtered.time[0]) - start,
        noise=separated.noise,
        filter_length=2 * release.filter.half / separated.free.rate,
        others=separated.describe(mains),
        count=release.record.time.size,
    )


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
    filtered = release.decrement.filtered
    value = without_others(release.separated, shown)
    first = int(np.searchsorted(shown.time, filtered.time[0] - 1e-12))
    value[first : first + filtered.time.size] = filtered.value
    return value


def _tuple(values: Floats) -> tuple[float, ...]:
    return tuple(values.tolist())
