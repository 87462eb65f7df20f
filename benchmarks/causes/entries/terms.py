"""Columns that a sparse regression may choose among, by kind of test, and the causes that they stand for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_filter

from .base import swinging
from .records import Campaign, Record, si


@dataclass(frozen=True)
class Regression:
    """Target y and columns A, all about 1. The first columns, without a name, are the model as stated."""

    y: np.ndarray
    A: np.ndarray
    names: tuple[str | None, ...]


def regressions(campaign: Campaign) -> list[Regression]:
    """One regression for each law of the test."""
    return {"response": _response, "decay": _decay, "elongation": _elongation}[campaign.method](campaign)


def smooth(t: np.ndarray, y: np.ndarray, periods: float) -> tuple[np.ndarray, ...]:
    """Value, first and second derivative on an even grid by cubic Savitzky-Golay over a share of a period."""
    even = np.linspace(t[0], t[-1], len(t))
    step = even[1] - even[0]
    window = max(7, 2 * int(periods / step / 2) + 1)
    rows = np.interp(even, t, y)
    return even, *(savgol_filter(rows, window, 3, deriv=order, delta=step)[window:-window] for order in range(3))


def _decay(campaign: Campaign) -> list[Regression]:
    targets, blocks = [], []
    for record in campaign.records:
        t, x = swinging(record)
        x = x - np.mean(x[-len(x) // 4 :])
        period = 2 * np.pi / _rate(t, x)
        _, e, v, a = smooth(t, x, 0.2 * period)
        size, omega = np.abs(e).max(), 2 * np.pi / period
        e, v, a = e / size, v / (size * omega), a / (size * omega**2)
        targets.append(a)
        blocks.append(np.column_stack([e, v, np.ones_like(e), e**3, e**2, np.abs(e) * v, np.abs(v) * v, np.sign(v)]))
    names = (None, None, None, "cubic", "even stiffness", "damping", "quadratic drag", "friction")
    return [Regression(np.concatenate(targets), np.vstack(blocks), names)]


def _rate(t: np.ndarray, x: np.ndarray) -> float:
    spectrum = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)), 4 * len(x)))
    return 2 * np.pi * (8 + int(np.argmax(spectrum[8:]))) / (4 * (t[-1] - t[0]))


def _response(campaign: Campaign) -> list[Regression]:
    module, line = [], []
    for record in campaign.fitted:
        first, second = _run(campaign, record)
        module.append(first)
        line.append(second)
    of_module = ("tilt", "drag", "quadratic drag", "friction", "thrust gain")
    of_line = (None, None, "cell zero", "cubic", "damping", "cell drift", "gain drift")
    return [_joined(module, of_module), _joined(line, of_line)]


def _joined(rows: list[np.ndarray], names: tuple[str | None, ...]) -> Regression:
    every = np.vstack(rows)
    return Regression(every[:, 0], every[:, 1:], names)


def _run(campaign: Campaign, record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Columns of the balance of forces on the module, and of the law of the line; the first is the target."""
    read, pulse = record.columns, record.settings["thrust"][0]
    m, taut, most = si(campaign.test["rig"]["mass"]), si(campaign.test["rig"]["taut"]), si(pulse["force"])
    use = np.isfinite(read["x"]) & np.isfinite(read["v"])
    t, v0, a, _ = smooth(read["t"][use], read["v"][use], 0.15)
    t = t[: len(read["t"][use])]
    cut = (len(t) - len(v0)) // 2
    t = t[cut : cut + len(v0)]
    x, T = np.interp(t, read["t"][use], read["x"][use]), np.interp(t, read["s"], np.nan_to_num(read["T"]))
    on = (t > si(pulse["from"]) + 0.1) & (t < (si(pulse["to"]) if "to" in pulse else 1e9))
    F, moving = most * on, t > si(pulse["from"]) + 0.1
    e, far = x - taut, np.abs(v0).max()
    calm = moving & (np.abs(np.gradient(T, t)) < 3 * np.median(np.abs(np.gradient(T, t))[moving]) + 1)
    w = v0 / far
    module = np.column_stack([(m * a + T - F) / most, np.ones_like(w), w, w * np.abs(w), np.sign(w), F / most])
    pulls = calm & (e > 0.1 * e.max())
    q = e / e.max()
    line = np.column_stack([T / T.max(), q, w, np.ones_like(q), q**3, q * w, t / t[-1], t / t[-1] * T / T.max()])
    return module[calm], line[pulls]


def _elongation(campaign: Campaign) -> list[Regression]:
    one = campaign.records[0].columns
    F = one["F"] / one["F"].max()
    zeros = [(one["repeat"] == repeat).astype(float) for repeat in np.unique(one["repeat"])]
    order = np.arange(len(F)) / len(F)
    top = np.abs(one["x"]).max()
    A = np.column_stack([F, *zeros, F**2, order, one["back"].astype(float), -np.expm1(-F / 0.15)])
    return [Regression(one["x"] / top, A, (None, *([None] * len(zeros)), "curvature", "drift", "backlash", "toe"))]
