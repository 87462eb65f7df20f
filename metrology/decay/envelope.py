"""Viscous, dry or quadratic: what the shape of the envelope says of the cause of the damping, and rates against it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np

from metrology.coordinate import SENSED
from metrology.decay.finding import DampingShape, Verdict
from metrology.decay.oscillation import Fit, Floats, Form, Mode, fit
from metrology.decay.separated import Separated
from metrology.gum.rounding import significant
from metrology.message import said
from metrology.timeseries import average

ALARM = 3.5
"""Standard deviations beyond which a second cause of damping is called significant: false alarms well under 1 %."""

NEGLIGIBLE = 0.03
"""Part of the decay rate below which a significant second cause changes nothing that matters."""

LEAST = 4
"""Windows of a record, a quarter of a period apart, that a decay rate is found from."""
STEPS = 10
"""Points that a record gives at most: slopes over so many parts of it."""
FAINT = 10.0
"""Amplitude over its u below which a window is noise."""

_APART = 6.0  # difference of χ² from which one of two explanations is preferred (odds of e³, twenty to one)


@dataclass(frozen=True)
class Extra:
    """One more damping parameter in physical units: u, the χ² that it takes away, its part of the decay rate."""

    value: float
    u: float
    gain: float
    share: float


def extra(separated: Separated, form: Form, mass: float, last: float) -> Extra:
    """Return the force of dry friction F (N) or the coefficient of quadratic drag b (N·s²/m²) that a record calls for.

    The amplitude of m·x″ + c·x′ + k·x = −F·sign(x′) − b·|x′|·x′ falls as
    dA/dt = −λ·A − 2F/(π·m·ω) − (4·b·ω/(3π·m))·A² (mean over one period, light damping), so that
    F = β·A(0)·π·m·ω/2 and b = 3π·m·β/(4·ω·A(0)), β as in `oscillation.Mode`. `last` is the smallest amplitude used,
    in the unit of the record: a velocity has the amplitude ω·A, an acceleration ω²·A.
    """
    free, main = separated.free, separated.fit.main
    count = max(1, int(1 / free.step / (24 * max(main.frequency, main.rate)))) if free.is_even else 1
    coarse = average(free, count)
    t = coarse.time - coarse.time[0]
    lags = int(2 / coarse.step / main.frequency)
    held = separated.fit.modes[1:]
    base = fit(t, coarse.value, [separated.fit.main], held=held, lags=lags)
    starts = _starts(base.main, form)
    found = [fit(t, coarse.value, [start], held=held, form=form, lags=lags) for start in starts]
    best = min(found, key=lambda trial: trial.squares)
    u = sqrt(max(best.covariance[2, 2], 0.0))
    variance = _variance_near(best, 1 / coarse.step)
    gain = (base.squares - best.squares) / variance
    size, omega = float(best.amplitudes[0]), best.main.omega
    moved = size / omega ** SENSED[free.unit].order
    unit = moved * pi * mass * omega / 2 if form == "dry" else 3 * pi * mass / (4 * omega * moved)
    # Dry friction weighs most where the amplitude is least: at the last peak that counts. Drag, at the first.
    relative = last / size if form == "dry" else 1.0
    share = best.main.beta / relative / base.main.rate
    return Extra(best.main.beta * unit, u * unit, gain, share)


def _starts(main: Mode, form: Form) -> tuple[Mode, Mode]:
    """Return two modes to start from: none of the further damping, and half of the decay due to it."""
    return replace(main, beta=0.0), Mode(main.omega, 0.5 * main.rate, (0.3 if form == "dry" else 1.0) * main.rate)


def _variance_near(fitted: Fit, rate: float) -> float:
    """Return the variance per sample that white noise as strong as the residuals around the mode would have."""
    spectrum = abs(np.fft.rfft(fitted.residual)) ** 2 / fitted.residual.size
    frequency = np.fft.rfftfreq(fitted.residual.size, 1 / rate)
    # Where a record lasts less than a period, no frequency of it lies so near: the nearest is taken.
    away = abs(frequency - fitted.main.frequency)
    near = away < max(0.5 * fitted.main.frequency, 1.001 * float(away.min()))
    return max(float(spectrum[near].mean()), 1e-300)


def shape(records: Sequence[tuple[Separated, float]], mass: float) -> DampingShape:
    """Tell viscous from dry and quadratic damping, over all records of a test.

    Every record is fitted again with each further damping; the parameters are averaged with weights 1/u², widened
    where they scatter by more than u. Alarm beyond 3.5 standard uncertainties, for a positive parameter only:
    nothing drives a free decay. What is significant but makes up less than 3 % of the decay rate at any amplitude
    used is said to be negligible, and the damping viscous.

    Parameters
    ----------
    records : sequence of (Separated, float)
        Records taken apart, each with the smallest amplitude used of it, in its own unit.
    mass : float
        The mass that oscillates, in kg.
    """
    dry = _mean([extra(record, "dry", mass, last) for record, last in records])
    drag = _mean([extra(record, "quadratic", mass, last) for record, last in records])
    z = dry.value / dry.u, drag.value / drag.u
    turns = SENSED[records[0][0].free.unit].coordinate == "angle"
    force, coefficient = ("mN·m", "N·m·s²/rad²") if turns else ("mN", "N·s²/m²")
    friction, air = (" ± ".join(significant(*pair)) for pair in ((1e3 * dry.value, 1e3 * dry.u), (drag.value, drag.u)))
    numbers = said(
        "dry friction {friction:figures} {force} ({dry:+.1f} u), quadratic drag {drag:figures} {coefficient} "
        "({quadratic:+.1f} u) together with the viscous part",
        friction=friction,
        force=force,
        dry=float(z[0]),
        drag=air,
        coefficient=coefficient,
        quadratic=float(z[1]),
    )
    verdict, sentence = _verdict(dry, drag, z, numbers)
    return DampingShape(
        verdict=verdict,
        dry_force=dry.value,
        dry_force_u=dry.u,
        dry_z=z[0],
        dry_share=dry.share,
        quadratic=drag.value,
        quadratic_u=drag.u,
        quadratic_z=z[1],
        quadratic_share=drag.share,
        gain_dry=dry.gain,
        gain_quadratic=drag.gain,
        sentence=sentence,
    )


def _verdict(dry: Extra, drag: Extra, z: tuple[float, float], numbers: str) -> tuple[Verdict, str]:
    """Return the verdict on the envelope's shape and the sentence that says it."""
    if max(z) <= ALARM:
        text = "The envelope agrees with viscous damping: {numbers}; neither is significantly above zero."
        return "viscous", said(text, numbers=numbers)
    share = max(x.share for x, alarm in ((dry, z[0]), (drag, z[1])) if alarm > ALARM)
    if share < NEGLIGIBLE:
        text = (
            "The envelope is that of viscous damping: {numbers}. What is significant is at most {share:.1g} % of the "
            "decay rate at any amplitude used, and negligible."
        )
        return "viscous", said(text, numbers=numbers, share=float(100 * share))
    gains = "χ² falls by {dry:.3g} with dry friction, by {drag:.3g} with quadratic drag"
    further = {
        "numbers": numbers,
        "gains": said(gains, dry=float(dry.gain), drag=float(drag.gain)),
        "caution": said("One ζ then does not describe the sample: it is a mean over the amplitudes of these records."),
    }
    if z[0] > ALARM and dry.gain - drag.gain > _APART:
        return "dry", said("The envelope shows dry (Coulomb) friction: {numbers}. {gains}. {caution}", **further)
    if z[1] > ALARM and drag.gain - dry.gain > _APART:
        return "quadratic", said("The envelope shows quadratic damping: {numbers}. {gains}. {caution}", **further)
    text = (
        "The envelope is not that of viscous damping, but dry and quadratic damping cannot be distinguished: "
        "{numbers}. {gains}. {caution}"
    )
    return "not viscous", said(text, **further)


def _mean(found: Sequence[Extra]) -> Extra:
    """Return the weighted mean over records, u widened by their scatter, and the gains of positive ones summed."""
    value, u = np.array([x.value for x in found]), np.array([x.u for x in found])
    weight = 1 / u**2
    mean = float(weight @ value / weight.sum())
    chi_squared = float(weight @ (value - mean) ** 2)
    widen = sqrt(max(1.0, chi_squared / max(value.size - 1, 1)))
    gain = sum(x.gain for x in found if x.value > 0)
    return Extra(mean, widen / sqrt(weight.sum()), gain, float(np.mean([x.share for x in found])))


def rates(t: Floats, y: Floats, u: Floats, omega: float) -> Floats:
    """Return rows of amplitude, decay rate, its u, frequency, its u: slopes of ln|z| and arg z over parts of a record.

    z is y·e^{−iωt} averaged with a Hann window over two periods, every quarter of a period.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times in s, evenly spaced.
    y : ndarray, shape (n,)
        Readings of the oscillation, in any unit.
    u : ndarray, shape (n,)
        Standard uncertainties of the readings, in the unit of `y`.
    omega : float
        Angular frequency about which it oscillates, in rad/s.

    Returns
    -------
    ndarray, shape (parts, 5)
        Amplitude in the unit of `y`, decay rate and its u in 1/s, frequency and its u in Hz; no rows where the record
        is too short.
    """
    step = float(np.median(np.diff(t)))
    hop = max(1, round(pi / 2 / omega / step))
    window = np.hanning(8 * hop + 1)
    window = 2 * window / window.sum()
    if len(y) < 2 * len(window):
        return np.empty((0, 5))
    z = np.convolve((y - y.mean()) * np.exp(-1j * omega * t), window, mode="valid")[::hop]
    at = t[4 * hop :: hop][: len(z)]
    sigma = float(np.median(u))
    faint = np.abs(z) < FAINT * sigma * sqrt(float(np.sum(window**2)) / 2)
    last = int(np.argmax(faint)) if faint.any() else len(z)
    log, turn = np.log(np.abs(z)), np.unwrap(np.angle(z))
    rows = []
    for part in np.array_split(np.arange(last), min(STEPS, last // LEAST)) if last >= LEAST else []:
        own = at[part] - at[part].mean()
        own = own / float(own @ own)
        # The slope is linear in the noise of the readings: its weights are the windows, summed.
        spread = np.zeros((len(part) - 1) * hop + 1, dtype=complex)
        spread[::hop] = own / z[part]
        weights = np.convolve(spread, window) * np.exp(-1j * omega * step * np.arange(len(spread) + 8 * hop))
        u_slope = sigma * sqrt(float(np.sum(np.abs(weights) ** 2)) / 2)
        slopes = [float(own @ column[part]) for column in (log, turn)]
        frequency = (omega + slopes[1]) / (2 * pi)
        rows.append((float(np.abs(z[part]).mean()), -slopes[0], u_slope, frequency, u_slope / (2 * pi)))
    return np.array(rows) if rows else np.empty((0, 5))


def suggested(rows: Floats, mass: float, effects: Sequence[str]) -> dict[str, float]:
    """Stiffness, damping and the sizes of effects, fitted to rates and frequencies by least squares.

    Harmonic balance (Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 2 and 3): ω² = (k + 3·k₃·A²/4)/m, and a rate of
    (c + 4·F_c/(π·ω·A) + 8·b₂·ω·A/(3π) + 4·c₁·A/(3π))/(2m).

    Parameters
    ----------
    rows : ndarray, shape (n, 5)
        From `rates`.
    mass : float
        kg.
    effects : sequence of str
        Those of the model; others than the four are passed over.

    Returns
    -------
    dict
        By name of parameter; empty where the rows are too few.
    """
    A, w = rows[:, 0], 2 * pi * rows[:, 3]
    columns = {
        "friction": ("friction.force", 4 / (pi * w * A)),
        "quadratic drag": ("drag.quadratic", 8 * w * A / (3 * pi)),
        "damping": ("damping.amplitude", 4 * A / (3 * pi)),
    }
    slowing = [columns[name] for name in effects if name in columns]
    bending = [("cubic.stiffness", 0.75 * A**2)] if "cubic" in effects else []
    if len(rows) < 2 + max(len(slowing), len(bending)):
        return {}
    return {**_fitted("c", 2 * mass * rows[:, 1], slowing), **_fitted("k", mass * w**2, bending)}


def _fitted(name: str, y: Floats, columns: Sequence[tuple[str, Floats]]) -> dict[str, float]:
    """Coefficients of a constant and some columns."""
    table = np.column_stack([np.ones(len(y)), *(column for _, column in columns)])
    size = np.linalg.norm(table, axis=0)
    found = np.linalg.lstsq(table / size, y, rcond=None)[0] / size
    return dict(zip((name, *(one for one, _ in columns)), found.tolist(), strict=True))
