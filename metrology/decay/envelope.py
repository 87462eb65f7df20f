"""Viscous, dry or quadratic: what the shape of the envelope says of the cause of the damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np

from metrology.decay.finding import DampingShape
from metrology.decay.oscillation import Fit, Form, Mode, fit
from metrology.decay.separation import Separated
from metrology.timeseries import average

ALARM = 3.5
"""Standard deviations beyond which a second cause of damping is called significant: false alarms well under 1 %."""

_APART = 6.0  # difference of χ² from which one of two explanations is preferred (odds of e³, twenty to one)


@dataclass(frozen=True)
class Extra:
    """One more damping parameter of one record, in physical units, with u and the χ² that it takes away."""

    value: float
    u: float
    gain: float


def extra(separated: Separated, form: Form, mass: float) -> Extra:
    """Return the force of dry friction F (N) or the coefficient of quadratic drag b (N·s²/m²) that a record calls for.

    The amplitude of m·x″ + c·x′ + k·x = −F·sign(x′) − b·|x′|·x′ falls as
    dA/dt = −λ·A − 2F/(π·m·ω) − (4·b·ω/(3π·m))·A² (mean over one period, light damping), so that
    F = β·A(0)·π·m·ω/2 and b = 3π·m·β/(4·ω·A(0)), β as in `oscillation.Mode`.
    """
    count = max(1, int(separated.free.rate / (24 * separated.fit.main.frequency)))
    coarse = average(separated.free, count)
    t = coarse.time - coarse.time[0]
    lags = int(2 * coarse.rate / separated.fit.main.frequency)
    held = separated.fit.modes[1:]
    base = fit(t, coarse.value, [separated.fit.main], held=held, lags=lags)
    starts = _starts(base.main, form)
    found = [fit(t, coarse.value, [start], held=held, form=form, lags=lags) for start in starts]
    best = min(found, key=lambda trial: trial.squares)
    u = sqrt(max(best.covariance[2, 2], 0.0))
    variance = _variance_near(best, coarse.rate)
    gain = (base.squares - best.squares) / variance
    size, omega = float(best.amplitudes[0]), best.main.omega
    unit = size * pi * mass * omega / 2 if form == "dry" else 3 * pi * mass / (4 * omega * size)
    return Extra(best.main.beta * unit, u * unit, gain)


def _starts(main: Mode, form: Form) -> tuple[Mode, Mode]:
    """Return two modes to start from: none of the further damping, and half of the decay due to it."""
    return replace(main, beta=0.0), Mode(main.omega, 0.5 * main.rate, (0.3 if form == "dry" else 1.0) * main.rate)


def _variance_near(fitted: Fit, rate: float) -> float:
    """Return the variance per sample that white noise as strong as the residuals around the mode would have."""
    spectrum = abs(np.fft.rfft(fitted.residual)) ** 2 / fitted.residual.size
    frequency = np.fft.rfftfreq(fitted.residual.size, 1 / rate)
    near = abs(frequency - fitted.main.frequency) < 0.5 * fitted.main.frequency
    return max(float(spectrum[near].mean()), 1e-300)


def shape(records: Sequence[Separated], mass: float) -> DampingShape:
    """Tell viscous from dry and quadratic damping, over all records of a test.

    Every record is fitted again with each further damping; the parameters are averaged with weights 1/u², widened where
    they scatter by more than u. Alarm beyond 3.5 standard uncertainties, for a positive parameter only: nothing drives a free decay.
    """
    dry = _mean([extra(record, "dry", mass) for record in records])
    quadratic = _mean([extra(record, "quadratic", mass) for record in records])
    z_dry, z_quadratic = dry.value / dry.u, quadratic.value / quadratic.u
    found = DampingShape(
        "viscous", dry.value, dry.u, z_dry, quadratic.value, quadratic.u, z_quadratic, dry.gain, quadratic.gain, ""
    )
    apart = dry.gain - quadratic.gain
    numbers = (
        f"dry friction {1e3 * dry.value:.2g} mN ± {1e3 * dry.u:.2g} mN ({z_dry:+.1f} u), quadratic drag {quadratic.value:.2g} ±"
        f" {quadratic.u:.2g} N·s²/m² ({z_quadratic:+.1f} u) beside the viscous part"
    )
    if z_dry <= ALARM and z_quadratic <= ALARM:
        text = f"The envelope agrees with viscous damping: {numbers}; neither is significant."
        return replace(found, sentence=text)
    if z_dry > ALARM and apart > _APART:
        text = f"The envelope shows dry (Coulomb) friction: {numbers}. χ² falls by {dry.gain:.3g} against {quadratic.gain:.3g}."
        return replace(found, verdict="dry", sentence=text + _CAUTION)
    if z_quadratic > ALARM and apart < -_APART:
        text = (
            f"The envelope shows quadratic damping: {numbers}. χ² falls by {quadratic.gain:.3g} against {dry.gain:.3g}."
        )
        return replace(found, verdict="quadratic", sentence=text + _CAUTION)
    text = f"The envelope is not that of viscous damping, but dry and quadratic cannot be told apart: {numbers}."
    return replace(found, verdict="not viscous", sentence=text + _CAUTION)


_CAUTION = " One ζ then does not describe the sample: it is a mean over the amplitudes of these records."


def _mean(found: Sequence[Extra]) -> Extra:
    """Return the weighted mean over records, its u widened by the scatter, and the sum of the gains of the positive ones."""
    value, u = np.array([x.value for x in found]), np.array([x.u for x in found])
    weight = 1 / u**2
    mean = float(weight @ value / weight.sum())
    chi_squared = float(weight @ (value - mean) ** 2)
    widen = sqrt(max(1.0, chi_squared / max(value.size - 1, 1)))
    gain = sum(x.gain for x in found if x.value > 0)
    return Extra(mean, widen / sqrt(weight.sum()), gain)
