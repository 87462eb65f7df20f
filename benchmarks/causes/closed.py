"""Closed form of a module on a line that only pulls, nothing else acting: for the refits that size an effect.

slack   e = e₀ + v₀·t + a·t²/2,   a = F/m
taut    e = F/k + e^(−δt)·(u₀·cos ωt + (v₀ + δ·u₀)/ω·sin ωt),   u₀ = e₀ − F/k, δ = c/2m, ω² = k/m − δ²
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from .rig import Push, Rig

LOOK = 2e-3
"""Distance / s of the places at which a change of contact is looked for."""


def moved(rig: Rig, force: float, begin: tuple[float, float], taut: bool, t: np.ndarray) -> np.ndarray:
    """e and v at times t after the begin of a regime."""
    e, v = begin
    if not taut:
        a = force / rig.m
        return np.array([e + v * t + 0.5 * a * t**2, v + a * t])
    decay, rest = rig.c / (2 * rig.m), force / rig.k
    omega = np.sqrt(rig.k / rig.m - decay**2)
    u, w = e - rest, (v + decay * (e - rest)) / omega
    fade, cos, sin = np.exp(-decay * t), np.cos(omega * t), np.sin(omega * t)
    position = fade * (u * cos + w * sin)
    return np.array([rest + position, fade * omega * (w * cos - u * sin) - decay * position])


def base_motion(rig: Rig, push: Push, stamps: np.ndarray) -> np.ndarray:
    """Rows e / m, v / (m/s), T / N at the stamps, as `rig.motion` without effects."""
    found = np.zeros((3, len(stamps)))
    found[0] = rig.start
    now, state, taut = push.begin, (rig.start, 0.0), False
    last = float(stamps[-1]) + 1e-6
    for edge, force in ((min(push.end, last), push.force), (last, 0.0)):
        while now < edge - 1e-12:
            end = now + _lasts(rig, force, state, taut, edge - now)
            inside = (stamps >= now) & (stamps < end)
            e, v = moved(rig, force, state, taut, stamps[inside] - now)
            found[:, inside] = [e, v, np.maximum(rig.k * e + rig.c * v, 0.0) if taut else np.zeros_like(e)]
            after = moved(rig, force, state, taut, np.array([end - now]))[:, 0]
            state = (float(after[0]), float(after[1]))
            taut = taut if end >= edge - 1e-12 else not taut
            now = end
    return found


def _lasts(rig: Rig, force: float, state: tuple[float, float], taut: bool, longest: float) -> float:
    sign = 1.0 if taut else -1.0

    def margin(t: np.ndarray) -> np.ndarray:
        e, v = moved(rig, force, state, taut, t)
        return sign * np.minimum(rig.k * e, rig.k * e + rig.c * v)

    t = np.append(np.arange(1, max(int(longest / LOOK), 1)) * LOOK, longest)
    t = np.concatenate([[1e-7], t[t > 1e-7]])
    below = np.flatnonzero(margin(t) < 0)
    if not len(below):
        return longest
    if below[0] == 0:
        return 1e-7
    return float(brentq(lambda s: float(margin(np.array([s]))[0]), t[below[0] - 1], t[below[0]], xtol=1e-14))
