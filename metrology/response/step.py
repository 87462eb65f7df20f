"""Response of a mass on a spring with a damper to a unit step of the force, from rest, with the band of k and c."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metrology.estimation.problem import Array

PERIODS = 20.0
"""Periods that are shown at most; sooner it ends where the envelope has fallen to a fiftieth."""
SETTLED = 4.0
POINTS = 600
SMALL = 1e-4
"""Part of its value by which k and c are moved for a derivative."""


@dataclass(frozen=True)
class StepResponse:
    """Times / s, and for each channel x, v, T the response to a unit of force with its standard uncertainty."""

    time: Array
    values: dict[str, Array]
    u: dict[str, Array]


def unit_step(k: float, c: float, m: float, t: Array) -> Array:
    """Position, velocity and tension over time per unit of force, shape (3, n): m·x″ + c·x′ + k·x = 1, from rest.

    The tension k·x + c·x′ is never negative, so that a line which only pulls stays taut.

    Examples
    --------
    >>> x, v, T = unit_step(100.0, 2.0, 1.0, np.array([0.0, 100.0]))
    >>> x.round(6).tolist(), v.round(6).tolist(), T.round(6).tolist()
    ([0.0, 0.01], [0.0, 0.0], [0.0, 1.0])
    """
    rate = c / (2 * m)
    omega = np.sqrt(complex(k / m - rate**2))
    fallen = np.exp(-rate * t)
    # sin(ωt)/ω, which is t where the damping is critical.
    sine = fallen * t * np.sinc(omega * t / np.pi)
    cosine = fallen * np.cos(omega * t)
    rows = [(1 - cosine - rate * sine) / k, sine / m, 1 - cosine + rate * sine]
    return np.asarray(np.real(rows))


def response(k: float, c: float, m: float, covariance: Array) -> StepResponse:
    """Return the response by the estimates of k and c, with its standard uncertainty by the law of propagation.

    Parameters
    ----------
    k, c, m : float
        Stiffness, damping, mass, in SI.
    covariance : ndarray, shape (2, 2)
        Of k and c.
    """
    omega, rate = np.sqrt(k / m), c / (2 * m)
    time = np.linspace(0.0, min(PERIODS * 2 * np.pi / omega, max(SETTLED / rate, 2 * np.pi / omega)), POINTS)
    slopes = np.array([
        (unit_step(k * (1 + at[0]), c * (1 + at[1]), m, time) - unit_step(k * (1 - at[0]), c * (1 - at[1]), m, time))
        / (2 * SMALL * (k if at[0] else c))
        for at in SMALL * np.eye(2)
    ])  # fmt: skip
    u = np.sqrt(np.maximum(np.einsum("ant,ab,bnt->nt", slopes, covariance, slopes), 0.0))
    names = ("x", "v", "T")
    values = unit_step(k, c, m, time)
    return StepResponse(time, dict(zip(names, values, strict=True)), dict(zip(names, u, strict=True)))
