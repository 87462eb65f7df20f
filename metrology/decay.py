"""Free decay of a mass on the sample: natural frequency ω_n, damping ratio ζ and damping coefficient c."""

from __future__ import annotations

from dataclasses import dataclass

from metrology.elongation import Check

Floats = tuple[float, ...]


@dataclass(frozen=True)
class DecayRecord:
    """One release, evaluated in two ways, with what the report draws of it. SI; time zero at the release.

    `time`, `displacement`: the record as measured, decimated for drawing (min–max); `filtered`: the longitudinal mode on the
    same `time`; `fit`: the oscillation fitted directly. `peak_time`, `peak_amplitude`: extrema used (absolute value);
    `noise_floor`: amplitude below which peaks are not used. `amplitude`, `rate`: decay rate λ (1/s) against amplitude (m), with
    `rate_u`. `zeta_*`, `omega_*`: by logarithmic decrement over the peaks, and by direct fit.
    """

    record: str
    time: Floats
    displacement: Floats
    filtered: Floats
    fit: Floats
    peak_time: Floats
    peak_amplitude: Floats
    peak_used: tuple[bool, ...]
    noise_floor: float
    log_decrement: float
    zeta_decrement: float
    zeta_decrement_u: float
    omega_decrement: float
    omega_decrement_u: float
    zeta_fit: float
    zeta_fit_u: float
    omega_fit: float
    omega_fit_u: float
    amplitude: Floats
    rate: Floats
    rate_u: Floats
    filter_bias: float
    sentence: str = ""


@dataclass(frozen=True)
class DecayFinding:
    """Everything that the report shows of one free-decay test (several releases), in SI.

    `filter`: what was removed and how, in words; `damping`: what the envelope's shape says (viscous, dry, quadratic) with its evidence.
    """

    records: tuple[DecayRecord, ...]
    mass: float
    filter: str
    damping: str
    checks: tuple[Check, ...]
    equations: tuple[str, ...]
    notes: tuple[str, ...] = ()
