"""Lines in the spectrum of residuals: mains, vibration of the line."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.subject import Array, Fit
from metrology.estimation import MeasuredRun

TRIAL = 0.1
"""Amplitude to try, in standard uncertainties of a reading."""


def strongest(fit: Fit, runs: Sequence[MeasuredRun], one: Candidate, above: float) -> list[Direction]:
    """Direction of the strongest line in the residuals of a channel, the spectra of all runs added; none without one.

    Parameters
    ----------
    fit : Fit
        Whose residuals are looked at.
    runs : sequence of MeasuredRun
        For the time stamps.
    one : Candidate
        Line in a channel, with an amplitude, a frequency / Hz and a phase.
    above : float
        Lowest frequency that counts, Hz: what lies lower may be the motion itself.
    """
    channel = one.cause.spectral
    longest = max(run.run.end - run.run.t0 for run in runs)
    step = min((float(np.median(np.diff(run.stamps(channel)))) for run in runs if channel in run.channels), default=0.0)
    if step == 0.0:
        return []
    count = round(longest / step) * 2
    power = sum(_power(fit, run, (at, channel), step, count) for at, run in enumerate(runs) if channel in run.channels)
    grid = np.fft.rfftfreq(count, step)
    inside = np.flatnonzero((grid > max(above, 3.0 / longest)) & (grid < 0.95 * grid[-1]))
    if not inside.size:
        return []
    frequency = float(grid[inside[np.argmax(np.asarray(power)[inside])]])
    return [_line(fit, runs, one, frequency, len(grid) / 2)]


def _power(fit: Fit, run: MeasuredRun, place: tuple[int, str], step: float, count: int) -> Array:
    at, channel = place
    segment = next(one for one in fit.problem.blocks[at].segments if one.name == channel)
    t, residual = run.stamps(channel), fit.residuals[at][segment.first : segment.last]
    even = np.zeros(count)
    places = np.round((t - run.run.t0) / step).astype(int)
    fine = (places >= 0) & (places < count)
    even[places[fine]] = residual[fine]
    power: Array = np.abs(np.fft.rfft(even)) ** 2 / max(int((residual != 0).sum()), 1)
    return power


def _line(fit: Fit, runs: Sequence[MeasuredRun], one: Candidate, frequency: float, looks: float) -> Direction:
    """Sine and cosine of every run by themselves: no run begins in step with what hums."""
    channel, rows, amount = one.cause.spectral, [], 0.0
    ways: list[str] = []
    count = 2 * sum(channel in run.channels for run in runs)
    for at, run in enumerate(runs):
        part = np.zeros((len(fit.residuals[at]), count))
        segment = next((entry for entry in fit.problem.blocks[at].segments if entry.name == channel), None)
        if segment is not None:
            amount = TRIAL * run.noise[channel]
            turn = 2 * math.pi * frequency * run.stamps(channel)
            own = fit.used[at][segment.first : segment.last, None]
            wave = -TRIAL * np.column_stack([np.sin(turn), np.cos(turn)]) * own
            part[segment.first : segment.last, len(ways) : len(ways) + 2] = wave
            ways += [f"sin@{run.name}", f"cos@{run.name}"]
        rows.append(part)
    values = {one.parameters[0].name: amount, one.parameters[1].name: frequency}
    return Direction(one.name, values, amount, tuple(rows), looks, tuple(ways))
