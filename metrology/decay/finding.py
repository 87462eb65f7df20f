"""What the evaluation of a free-decay test yields for the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.check import Check
from metrology.doc import Doc

Floats = tuple[float, ...]


@dataclass(frozen=True)
class DecayRecord:
    """One release, evaluated in two ways, with what the report draws of it. SI; time zero at the release.

    `time`, `displacement`: the record as measured, decimated for drawing (min–max); `filtered`: the longitudinal
    mode on the same `time` (before the filter has full support, from `filtered_from` on, the record less the fitted
    other motions); `fit`: the longitudinal oscillation fitted directly; `residual`: the record less everything
    fitted, zero before `fitted_from`. `count`: samples of the whole record, also those before the release.
    `peak_time`, `peak_amplitude`: extrema found (absolute value), `peak_used` those that entered; `noise_floor`:
    amplitude below which peaks are not used. `amplitude`, `rate`: decay rate λ (1/s) against amplitude (m), with
    `rate_u`; `frequency` (rad/s) against the same amplitudes, with `frequency_u`.
    `zeta_*`, `omega_*` (damped, rad/s): by logarithmic decrement over the peaks, and by direct fit. `filter_bias`:
    what filter and peaks do to ζ of the fitted clean decay. Without a decrement its values are NaN, and `sentence`
    says why. `unit`: of the readings, m or rad. `others`: what else was found in the record, in words.
    """

    record: Annotated[str, Doc("File of the release.")]
    time: Floats
    displacement: Floats
    filtered: Floats
    fit: Floats
    peak_time: Floats
    peak_amplitude: Floats
    peak_used: tuple[bool, ...]
    noise_floor: float
    log_decrement: Annotated[float, Doc("Logarithmic decrement.")]
    zeta_decrement: Annotated[float, Doc("Damping ratio by the logarithmic decrement.")]
    zeta_decrement_u: Annotated[float, Doc("Its standard uncertainty.")]
    omega_decrement: Annotated[float, Doc("Damped angular frequency by the extrema / (rad/s).")]
    omega_decrement_u: Annotated[float, Doc("Its standard uncertainty.")]
    zeta_fit: Annotated[float, Doc("Damping ratio by direct fit.")]
    zeta_fit_u: Annotated[float, Doc("Its standard uncertainty.")]
    omega_fit: Annotated[float, Doc("Damped angular frequency by direct fit / (rad/s).")]
    omega_fit_u: Annotated[float, Doc("Its standard uncertainty.")]
    amplitude: Floats
    rate: Floats
    rate_u: Floats
    filter_bias: float
    sentence: Annotated[str, Doc("The same in words.")] = ""
    frequency: Floats = ()
    frequency_u: Floats = ()
    residual: Floats = ()
    fitted_from: float = 0.0
    filtered_from: float = 0.0
    noise: Annotated[float, Doc("Standard uncertainty of one reading.")] = 0.0
    filter_length: Annotated[float, Doc("Length of the filter / s.")] = 0.0
    others: str = ""
    count: int = 0
    unit: str = "m"

    @property
    def has_peaks(self) -> bool:
        """Whether there is a logarithmic decrement; without it the result is that of the direct fit."""
        return any(self.peak_used)

    @property
    def zeta(self) -> tuple[float, float]:
        """ζ and its u by decrement, else by direct fit."""
        return (self.zeta_decrement, self.zeta_decrement_u) if self.has_peaks else (self.zeta_fit, self.zeta_fit_u)

    @property
    def decay_rate(self) -> tuple[float, float]:
        """λ = ζ·ω_n, near enough ζ·ω_d for a drawing, and its u / (1/s)."""
        omega = self.omega_decrement if self.has_peaks else self.omega_fit
        return self.zeta[0] * omega, self.zeta[1] * omega


Verdict = Literal["viscous", "dry", "quadratic", "not viscous"]


@dataclass(frozen=True)
class DampingShape:
    """What the shape of the envelope says of the cause of the damping, over all records of a test.

    `dry_force` F (N) and `quadratic` b (N·s²/m²) are what each would be, were it there together with the viscous part,
    with standard uncertainties; `dry_z`, `quadratic_z` the ratios; `dry_share`, `quadratic_share` the part of
    the decay rate at the amplitude where each weighs most; `gain_dry`, `gain_quadratic` how much each lowers χ².
    """

    verdict: Annotated[Verdict, Doc("The verdict.")]
    dry_force: float
    dry_force_u: Annotated[float, Doc("Standard uncertainty of the dry force / N.")]
    dry_z: float
    dry_share: float
    quadratic: float
    quadratic_u: Annotated[float, Doc("Standard uncertainty of the quadratic coefficient / (N·s²/m²).")]
    quadratic_z: float
    quadratic_share: float
    gain_dry: float
    gain_quadratic: float
    sentence: Annotated[str, Doc("The same in words.")]


@dataclass(frozen=True)
class DecayFinding:
    """Everything that the report shows of one free-decay test (several releases), in SI.

    `filter`: what was removed and how, in words; `damping`: what the envelope's shape says (viscous, dry, quadratic)
    with its evidence, `shape` the same in numbers. `failures`: for each record that could not be evaluated, why.
    `significance`: rate at which each check may fail on data with nothing wrong in them.
    """

    records: Annotated[tuple[DecayRecord, ...], Doc("The releases, one entry each.")]
    mass: Annotated[float, Doc("Mass that swings / kg.")]
    filter: str
    damping: str
    checks: Annotated[tuple[Check, ...], Doc("Checks of the data against what the model supposes.")]
    equations: Annotated[tuple[str, ...], Doc("Equations of the method, as text.")]
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")] = ()
    failures: tuple[str, ...] = ()
    shape: DampingShape | None = None
    significance: float | None = None

    @property
    def unit(self) -> str:
        """Unit of the readings, m or rad."""
        return self.records[0].unit if self.records else "m"
