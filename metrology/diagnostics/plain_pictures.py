"""Pictures of free decays and of elongation tests."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from metrology.decay.envelope import rates
from metrology.diagnosis import Curve, Picture, Role
from metrology.diagnostics.pictures import ROLES, curve, extremes, history, spectra, spectrum
from metrology.diagnostics.subject import Array, Fit, Marks
from metrology.message import said


def of_decay(
    records: Sequence[tuple[Array, Array, Array]], omega: float, before: Fit, after: Fit | None, of: str = "m"
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
    of : str
        Unit of the records.
    """
    fits = [(role, name, fit) for (role, name), fit in zip(ROLES, (before, after), strict=True) if fit is not None]
    found = list(_against_amplitude(records, omega, fits, of))
    lines = [
        spectrum(role, name, [(t, r) for (t, _, _), r in zip(records, fit.residuals, strict=True)])
        for role, name, fit in fits
    ]
    picture = spectra(said("Residual spectrum"), "spectrum", lines)
    found += [picture] if picture else []
    drawn = [curve(role, name, *extremes(records[0][0], fit.residuals[0])) for role, name, fit in fits]
    return (*found, history("history", said("Residual over time, first record"), drawn))


def _against_amplitude(
    records: Sequence[tuple[Array, Array, Array]], omega: float, fits: Sequence[tuple[Role, str, Fit]], of: str
) -> list[Picture]:
    measured = [rates(t, y, u, omega) for t, y, u in records]
    if not any(len(rows) for rows in measured):
        return []
    rows = np.concatenate(measured)
    models = []
    for role, name, fit in fits:
        followed = [rates(t, y - r * u, u, omega) for (t, y, u), r in zip(records, fit.residuals, strict=True)]
        models.append((role, name, np.concatenate(followed)))
    shapes = (
        (1, 2, "rate", said("decay rate"), "1/s", said("Decay rate against amplitude"),
         said("Level is viscous damping; growing with the amplitude quadratic drag; growing as it falls, friction.")),
        (3, 4, "frequency", said("frequency"), "Hz", said("Frequency against amplitude"),
         said("A frequency that changes with the amplitude is a stiffness that does.")),
    )  # fmt: skip
    found = []
    for at, beside, key, quantity, unit, title, reading in shapes:
        curves = [curve("measured", said("measured"), rows[:, 0], rows[:, at], rows[:, beside])]
        curves += [_sorted(role, name, table[:, 0], table[:, at]) for role, name, table in models]
        found.append(Picture(key, title, said("amplitude"), of, quantity, unit, tuple(curves), reading, False, "x"))
    return found


def _sorted(role: Role, name: str, x: Array, y: Array) -> Curve:
    order = np.argsort(x)
    return curve(role, name, x[order], y[order])


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
        for words, marks in ((said("loading"), ~back), (said("unloading"), back)):
            if marks.any():
                named = said("{what}, {model}", what=words, model=name)
                against.append(_means(role, named, force[marks], residual[marks], u))
        over.append(_thinned(role, name, order, residual, u))
    return (
        Picture("load", said("Residual against load"), "force", "N", said("residual"), "m", tuple(against),
                said("A curve is a line that is not straight; a difference between loading and unloading, backlash or "
                     "creep.")),
        Picture("order", said("Residual in the order of reading"), said("reading"), "1", said("residual"), "m",
                tuple(over), said("A slope is drift or creep, a step a slip, one point far off a misreading.")),
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
