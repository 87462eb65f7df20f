"""Records of a held elongation or load, drawn by equations of their own: what is read of a line that relaxes or creeps.

Shares no code with the package: the internal variables of the branches are integrated step by step (SciPy for power
laws, by quadrature of Boltzmann's integral), and what the instruments read has noise with a memory, divisions, and a
crosshead with backlash.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Held:
    """A line that is elongated (or loaded) in ramps to levels, each held for a time; SI.

    `stiff` is the instantaneous stiffness (N/m), `parts` and `times` what of it relaxes; with `load` they are the
    compliance (m/N) and what it gains. `exponent` makes it a power law: stiff·(t/1 s)^(−exponent), or
    stiff·(1 + parts[0]·(t/1 s)^exponent) of a load.
    `preload` is what was imposed 10 s before the record, from rest, and is in the zero of the stretch; `flow` (m/(N·s),
    of a load) what a constant force adds each second, for ever. `stiffens` is what the stiffness gains from rest to the
    highest level, and `loosens` what the relaxing part gains beyond that: its tangents at u are 1 + stiffens·u/u_max.
    """

    stiff: float = 2.0e4
    parts: tuple[float, ...] = (0.12, 0.08)
    times: tuple[float, ...] = (3.0, 60.0)
    exponent: float = 0.0
    load: bool = False
    levels: tuple[float, ...] = (5.0e-3,)
    holds: tuple[float, ...] = (600.0,)
    before: float = 5.0
    ramp: float = 0.5
    rate: float = 50.0
    read_noise: float = 0.05
    input_noise: float = 0.0
    memory: float = 0.0
    white: float = 1.0
    read_division: float = 0.0
    input_division: float = 0.0
    backlash: float = 0.0
    drift: float = 0.0
    wander: float = 0.0
    compliance: float = 0.0
    preload: float = 0.0
    flow: float = 0.0
    stiffens: float = 0.0
    loosens: float = 0.0
    more: dict[str, float] = field(default_factory=dict)


def noise(rng: np.random.Generator, count: int, correlation: float, white: float) -> np.ndarray:
    """Noise of unit variance: a part white, the rest an autoregression of first order (by SciPy's filter)."""
    from scipy.signal import lfilter

    steps = rng.normal(size=count)
    steps[0] /= np.sqrt(1 - correlation**2)
    slow = lfilter([np.sqrt(1 - correlation**2)], [1.0, -correlation], steps)
    return np.sqrt(1 - white) * slow + np.sqrt(white) * rng.normal(size=count)


def noise_at(rng: np.random.Generator, t: np.ndarray, memory: float, white: float) -> np.ndarray:
    """The same at stamps that need not be even: what is kept from one to the next is exp(−Δt/memory)."""
    kept = np.exp(-np.diff(t, prepend=t[0]) / memory) if memory else np.zeros(len(t))
    slow, last = np.empty(len(t)), rng.normal()
    for at, kick in enumerate(rng.normal(size=len(t)).tolist()):
        last = kept[at] * last + np.sqrt(1 - kept[at] ** 2) * kick
        slow[at] = last
    return np.sqrt(1 - white) * slow + np.sqrt(white) * rng.normal(size=len(t))


def path(one: Held) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the imposed course: time and level."""
    t, u = [0.0, one.before], [0.0, 0.0]
    for level, hold in zip(one.levels, one.holds, strict=True):
        t += [t[-1] + one.ramp, t[-1] + one.ramp + hold]
        u += [level, level]
    return np.array(t), np.array(u)


def branch(t: np.ndarray, u: np.ndarray, tau: float) -> np.ndarray:
    """Internal variable z of one branch, τ·z′ + z = u, exactly between stamps where u is linear."""
    z, found = u[0], np.empty(len(t))
    found[0] = z
    for at in range(1, len(t)):
        step = t[at] - t[at - 1]
        e, slope = np.exp(-step / tau), (u[at] - u[at - 1]) / step
        z = u[at] - slope * tau + (z - u[at - 1] + slope * tau) * e
        found[at] = z
    return found


def power(t: np.ndarray, corners: tuple[np.ndarray, np.ndarray], exponent: float) -> np.ndarray:
    """∫ (t − s)^exponent·u′(s) ds, ramp by ramp, by quadrature with the weight of the singularity."""
    from scipy.integrate import quad

    found = np.zeros(len(t))
    for begin, end, low, high in zip(corners[0], corners[0][1:], corners[1], corners[1][1:], strict=False):
        if high == low:
            continue
        for at in np.flatnonzero(t > begin):
            last = min(t[at], end)
            if last < t[at]:
                value = quad(lambda s, now=t[at]: (now - s) ** exponent, begin, last)[0]
            else:
                value = quad(lambda s: 1.0, begin, last, weight="alg", wvar=(0.0, exponent))[0]
            found[at] += (high - low) / (end - begin) * value
    return found


def stamps(one: Held, every: Sequence[float] | None = None) -> np.ndarray:
    corners, _ = path(one)
    return np.arange(0.0, corners[-1], 1 / one.rate) if every is None else np.asarray(every)


def answered(one: Held, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What was imposed and what answers, without instruments."""
    corners = path(one)
    # A crosshead with backlash moves before the specimen does.
    u = np.maximum(np.interp(t, *corners) - one.backlash, 0.0)
    if one.exponent:
        raised = power_on(t, corners, one)
        y = one.stiff * (u + one.parts[0] * raised) if one.load else one.stiff * raised
    else:
        spring, acting = (
            u + more * u**2 / (2 * max(one.levels)) for more in (one.stiffens, one.stiffens + one.loosens)
        )
        risen = sum(part * branch(t, acting, tau) for part, tau in zip(one.parts, one.times, strict=True))
        left = 0.0 if one.load else sum(one.parts) * acting - risen
        # relaxation: k₀·(1 − Σ g)·u + Σ k₀·g·(u − z); creep: J₀·u + Σ J₀·g·z
        y = one.stiff * (spring + risen) if one.load else one.stiff * ((1 - sum(one.parts)) * spring + left)
        if one.preload:
            fading = sum(part * np.exp(-(t + 10.0) / tau) for part, tau in zip(one.parts, one.times, strict=True))
            y = y + one.stiff * one.preload * (1 - sum(one.parts) + fading)
        if one.flow:
            y = y + one.flow * np.concatenate([[0.0], np.cumsum((u[1:] + u[:-1]) / 2 * np.diff(t))])
    return u, y


def power_on(t: np.ndarray, corners: tuple[np.ndarray, np.ndarray], one: Held) -> np.ndarray:
    exponent = one.exponent if one.load else -one.exponent
    moving = [(a, b, (d - c) / (b - a)) for a, b, c, d in
              zip(corners[0], corners[0][1:], corners[1], corners[1][1:], strict=False) if c != d]  # fmt: skip
    found = np.zeros(len(t))
    for begin, end, slope in moving:
        for sign, at in ((1.0, begin), (-1.0, end)):
            found += sign * slope * np.maximum(t - at, 0.0) ** (1 + exponent) / (1 + exponent)
    return found


def record(one: Held, rng: np.random.Generator, every: Sequence[float] | None = None) -> dict[str, np.ndarray]:
    """Readings of time, force and elongation."""
    t = stamps(one, every)
    u, y = answered(one, t)
    n = len(t)
    correlation = np.exp(-1 / (one.rate * one.memory)) if one.memory else 0.0
    own = noise(rng, n, correlation, one.white) if every is None else noise_at(rng, t, one.memory, one.white)
    read = y + one.read_noise * own + one.drift * t / t[-1]
    if one.wander:
        read = read + one.wander * np.cumsum(rng.normal(size=n)) / np.sqrt(n)
    u = np.interp(t, *path(one))
    imposed = u + one.input_noise * rng.normal(size=n)
    if one.read_division:
        read = np.round(read / one.read_division) * one.read_division
    if one.input_division:
        imposed = np.round(imposed / one.input_division) * one.input_division
    if one.load:
        return {"time": t, "force": imposed, "elongation": read}
    return {"time": t, "force": read, "elongation": imposed + one.compliance * read}


@dataclass(frozen=True)
class Bent:
    """A strip whose elastic force bends with its elongation, F_e ∝ (exp(bend·x/x_max) − 1), and relaxes (Fung); SI.

    `bend` above zero stiffens it as a tissue, below zero softens it as a rubber, 0 leaves it linear. F = Σ of
    F_e·(1 − Σ parts) and of parts·(F_e − z), z relaxing towards F_e. The cell has a zero `offset` and a `drift` over
    the record, both in N; the record begins `before` seconds before the ramp.
    """

    stiff: float = 2.0e3
    bend: float = 3.0
    parts: tuple[float, ...] = (0.2, 0.15)
    times: tuple[float, ...] = (0.8, 12.0)
    level: float = 5.0e-3
    ramp: float = 1.0
    before: float = 0.0
    hold: float = 90.0
    offset: float = 0.4
    drift: float = 0.0
    noise: float = 0.01
    rate: float = 20.0

    def elastic(self, x: np.ndarray | float) -> np.ndarray:
        """Force at once / N, `stiff` times the level at the level."""
        part = np.asarray(x) / self.level
        shape = np.expm1(self.bend * part) / np.expm1(self.bend) if self.bend else part
        return self.stiff * self.level * shape

    def at(self, time: float) -> float:
        """Force by elongation after a step to the level / (N/m)."""
        left = sum(part * np.exp(-time / tau) for part, tau in zip(self.parts, self.times, strict=True))
        return self.stiff * (1 - sum(self.parts) + left)

    def record(self, rng: np.random.Generator) -> dict[str, np.ndarray]:
        """Readings of time, force and elongation; the internal variables integrated by SciPy."""
        from scipy.integrate import solve_ivp

        t = np.arange(0.0, self.before + self.ramp + self.hold, 1 / self.rate)
        tau, parts = np.array(self.times), np.array(self.parts)

        def course(now: np.ndarray | float) -> np.ndarray:
            return np.interp(now, [self.before, self.before + self.ramp], [0.0, self.level])

        def rate(now: float, z: np.ndarray) -> np.ndarray:
            return (self.elastic(course(now)) - z) / tau

        z = solve_ivp(rate, (0.0, t[-1]), np.zeros(len(tau)), t_eval=t, max_step=self.ramp / 40, rtol=1e-8, atol=1e-9).y
        spring = self.elastic(course(t))
        force = spring * (1 - parts.sum()) + parts @ (spring - z)
        read = force + self.offset + self.drift * t / t[-1] + self.noise * rng.normal(size=len(t))
        return {"time": t, "force": read, "elongation": course(t)}
