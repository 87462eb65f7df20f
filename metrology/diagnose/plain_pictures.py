"""Pictures of free decays and of elongation tests."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from metrology.diagnose.pictures import ROLES, curve, extremes, history, spectra, spectrum
from metrology.diagnose.subject import Array, Fit, Marks
from metrology.diagnosis import Curve, Picture, Role

LEAST = 4
"""Windows of a record, a quarter of a period apart, that its decay rate is told from."""
STEPS = 10
"""Points that a record gives at most: slopes over so many parts of it."""
FAINT = 10.0
"""Amplitude over its u below which a window is noise."""


def of_decay(
    records: Sequence[tuple[Array, Array, Array]], omega: float, before: Fit, after: Fit | None
) -> tuple[Picture, ...]:
    """Decay rate and frequency against amplitude, residual spectrum, residuals of the first record.

    Parameters
    ----------
    records : sequence of (t, y, u)
        Time / s, displacement / m and its standard uncertainty, evenly sampled.
    omega : float
        Angular frequency of the oscillation / rad/s.
    before, after : Fit
        The model as it stands and the extended one; its residuals are those of the records.
    """
    fits = [(role, name, fit) for (role, name), fit in zip(ROLES, (before, after), strict=True) if fit is not None]
    found = list(_against_amplitude(records, omega, fits))
    lines = [
        spectrum(role, name, [(t, r) for (t, _, _), r in zip(records, fit.residuals, strict=True)])
        for role, name, fit in fits
    ]
    picture = spectra("Residual spectrum", "spectrum", lines)
    found += [picture] if picture else []
    told = [curve(role, name, *extremes(records[0][0], fit.residuals[0])) for role, name, fit in fits]
    return (*found, history("history", "Residual over time, first record", told))


def _against_amplitude(
    records: Sequence[tuple[Array, Array, Array]], omega: float, fits: Sequence[tuple[Role, str, Fit]]
) -> list[Picture]:
    measured = [_rates(t, y, u, omega) for t, y, u in records]
    if not any(len(rows) for rows in measured):
        return []
    rows = np.concatenate(measured)
    models = []
    for role, name, fit in fits:
        followed = [_rates(t, y - r * u, u, omega) for (t, y, u), r in zip(records, fit.residuals, strict=True)]
        models.append((role, name, np.concatenate(followed)))
    shapes = (
        (1, 2, "rate", "decay rate", "1/s",
         "Level is viscous damping; growing with the amplitude quadratic drag; growing as it falls, friction."),
        (3, 4, "frequency", "frequency", "Hz",
         "A frequency that changes with the amplitude is a stiffness that does."),
    )  # fmt: skip
    found = []
    for at, beside, key, quantity, unit, reading in shapes:
        curves = [curve("measured", "measured", rows[:, 0], rows[:, at], rows[:, beside])]
        curves += [_sorted(role, name, table[:, 0], table[:, at]) for role, name, table in models]
        title = f"{quantity.capitalize()} against amplitude"
        found.append(Picture(key, title, "amplitude", "m", quantity, unit, tuple(curves), reading, False, "x"))
    return found


def _sorted(role: Role, name: str, x: Array, y: Array) -> Curve:
    order = np.argsort(x)
    return curve(role, name, x[order], y[order])


def _rates(t: Array, y: Array, u: Array, omega: float) -> Array:
    """Rows of amplitude, decay rate, its u, frequency, its u from the slopes of ln|z| and arg z over parts of a record.

    z is y·e^{−iωt} averaged with a Hann window over two periods, every quarter of a period.
    """
    step = float(np.median(np.diff(t)))
    hop = max(1, round(math.pi / 2 / omega / step))
    window = np.hanning(8 * hop + 1)
    window = 2 * window / window.sum()
    if len(y) < 2 * len(window):
        return np.empty((0, 5))
    z = np.convolve((y - y.mean()) * np.exp(-1j * omega * t), window, mode="valid")[::hop]
    at = t[4 * hop :: hop][: len(z)]
    sigma = float(np.median(u))
    faint = np.abs(z) < FAINT * sigma * math.sqrt(float(np.sum(window**2)) / 2)
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
        u_slope = sigma * math.sqrt(float(np.sum(np.abs(weights) ** 2)) / 2)
        slopes = [float(own @ column[part]) for column in (log, turn)]
        frequency = (omega + slopes[1]) / (2 * math.pi)
        rows.append((float(np.abs(z[part]).mean()), -slopes[0], u_slope, frequency, u_slope / (2 * math.pi)))
    return np.array(rows) if rows else np.empty((0, 5))


def of_elongation(columns: tuple[Array, Array, Marks], u: float, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
    """Residual extension against load, loading and unloading apart, and in the order of reading.

    Parameters
    ----------
    columns : tuple of (force, order, unloading)
        Of every reading, in the order of the residuals: N, place in time, whether read when unloading.
    u : float
        Standard uncertainty of a reading / m.
    before, after : Fit
        The model as it stands and the extended one.
    """
    force, order, back = columns
    against, over = [], []
    for (role, name), fit in zip(ROLES, (before, after), strict=True):
        if fit is None:
            continue
        residual = np.concatenate(fit.residuals) * u
        for words, marks in (("loading", ~back), ("unloading", back)):
            if marks.any():
                against.append(_means(role, f"{words}, {name}", force[marks], residual[marks], u))
        over.append(_thinned(role, name, order, residual, u))
    return (
        Picture("load", "Residual against load", "force", "N", "residual", "m", tuple(against),
                "A curve is a line that is not straight; loading and unloading apart, backlash or creep."),
        Picture("order", "Residual in the order of reading", "reading", "1", "residual", "m", tuple(over),
                "A slope is drift or creep, a step a slip, one point far off a misreading."),
    )  # fmt: skip


def _means(role: Role, name: str, x: Array, y: Array, u: float) -> Curve:
    """Mean at each load."""
    loads = np.unique(x)
    rows = [(load, y[x == load].mean(), u / math.sqrt(int((x == load).sum()))) for load in loads]
    return curve(role, name, *np.array(rows).T)


def _thinned(role: Role, name: str, x: Array, y: Array, u: float) -> Curve:
    order = np.argsort(x, kind="stable")
    at, value = extremes(x[order], y[order])
    return curve(role, name, at, value, np.full(len(at), u))
