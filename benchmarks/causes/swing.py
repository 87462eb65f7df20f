"""A body that swings freely, as it truly is.

    m·x″ = −c·x′ − k·x − k₂·x² − k₃·x³ − k₅·x⁵ − k·(sin κx/κ − x) − (c₁·|x| + c₂·|x′|)·x′ − F_c·sign x′ − (stop, valve)

`stop` / (N/m): a stop that it touches beyond 0.6 of its first swing, on one side; `valve` / (N·s/m): damping on the way
up only, weaker beyond half of the first swing; `power` / (N·(s/m)^1.5): damping with the power 1.5 of the speed. These,
and `fifth`, are in
no table of causes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, sin, sqrt

import numpy as np

from .solve import MANY, Guard, stretch


@dataclass(frozen=True)
class Body:
    """Mass (or moment of inertia), stiffness, damping, SI; sizes of effects by name."""

    m: float
    k: float
    c: float
    effects: dict[str, float] = field(default_factory=dict)

    def get(self, name: str) -> float:
        """Size of an effect."""
        return self.effects.get(name, 0.0)


def swing(body: Body, amplitude: float, stamps: np.ndarray) -> np.ndarray:
    """Positions at stamps from the release at t = 0 on, let go at rest."""
    y, now, slide, rows = np.array([amplitude, 0.0]), 0.0, 0, []
    last = float(stamps[-1]) + 1e-6
    force, friction = _force(body, amplitude), body.get("friction")
    longest = 0.5 / sqrt(body.k / body.m)
    slide = _way(force(y, 0), friction)
    for _ in range(MANY):
        if now >= last - 1e-12:
            return np.concatenate(rows)
        if slide == 0:
            return np.concatenate([*rows, np.full(int((stamps >= now).sum()), y[0])])
        way = slide

        def rate(_t: float, y: np.ndarray, way: int = way) -> list[float]:
            return [y[1], (force(y, way) - way * friction) / body.m]

        guards: list[Guard] = [lambda _t, y, way=way: way * y[1]]
        states, now, y, which = stretch(rate, (now, last), y, guards, stamps, longest)
        rows.append(states[0])
        if which == 0:
            y[1] = 0.0
            slide = _way(force(y, 0), friction)
    raise ArithmeticError("too many turns")


def _way(force: float, friction: float) -> int:
    return 0 if abs(force) <= friction else int(np.sign(force))


def _force(body: Body, amplitude: float):
    """Force on the body at a state, without friction."""
    get, k, c = body.get, body.k, body.c
    k2, k3, k5, turn = get("even stiffness"), get("cubic"), get("fifth"), sqrt(get("pendulum"))
    c1, c2, stop, valve, power = get("damping"), get("quadratic drag"), get("stop"), get("valve"), get("power")
    limit, half = 0.6 * abs(amplitude), 0.5 * abs(amplitude)

    def force(y: np.ndarray, way: int) -> float:
        x, v = float(y[0]), float(y[1])
        found = -c * v - k * x - x * x * (k2 + x * (k3 + k5 * x * x)) - (c1 * abs(x) + c2 * abs(v)) * v
        if turn:
            found -= k * (sin(turn * x) / turn - x)
        if stop and x > limit:
            found -= stop * (x - limit)
        if valve and way > 0:
            found -= valve * v / (1 + (x / half) ** 4)
        return found - (power * abs(v) ** 0.5 * v if power else 0.0)

    return force


def closed(body: Body, amplitude: float, t: np.ndarray) -> np.ndarray:
    """Closed form without effects: A·e^(−δt)·(cos ωt + δ/ω·sin ωt)."""
    decay = body.c / (2 * body.m)
    omega = sqrt(body.k / body.m - decay**2)
    return amplitude * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))


def after_dry_friction(k: float, friction: float, amplitude: float, half_swings: int) -> float:
    """Turning point after so many half swings without viscous damping: (A − 2·n·F_c/k)·cos nπ (Den Hartog 1931)."""
    return (amplitude - 2 * half_swings * friction / k) * cos(np.pi * half_swings)
