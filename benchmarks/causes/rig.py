"""The rig of a response test as it truly is: a module pushed on a table, tied by a line that only pulls.

    m·x″ = F(t) + m·g·θ − b·v − b₂·v·|v| − F_c·sign v + (what is in nobody's table) − T
    T = the smaller force that keeps the line from pushing: max(0, T₁) where the line is longer than free, else 0
    T₁ = k·e + k₃·e³ + k₅·e⁵ − toe + k₁·(e − z) + k_h·h + (c + c₁·e)·e′
    e = x − u − Δ, from where the line is just taut; z′ = (e − z)/τ, h′ by Bouc and Wen
    u″ + 2·ζ·ω·u′ + ω²·u = G·T: a frame (G = ω²·C) or a module that yaws (G = r²/J)

The Zener branch relaxes towards zero while the line is slack; its loop stays as it is.
The toe changes its slope over a fifth of its extent and
not at a point; the loop of the hysteresis rounds with the power 1.1. An effect that is absent has the value 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .solve import Guard, stretch

GRAVITY = 9.8
X, V, Z, H, U, W, Y, YV = range(8)
EFFECTS = {
    "friction": "N", "drag": "N*s/m", "quadratic drag": "N*s^2/m^2", "cubic": "N/m^3", "damping": "N*s/m^2",
    "zener": "N/m", "hysteresis": "N/m", "toe": "1", "slip": "m", "tilt": "rad", "thrust lag": "s", "mode": "1/kg",
    "fifth": "N/m^5", "hose": "N/m", "slosh": "kg", "fading": "1/s", "valve": "N*s/m",
}  # fmt: skip
"""What the motion knows, with the unit of its size. From `fifth` on: in no table of causes.

`hose` / (N/m) pulls the module back to its start; `slosh` / kg of its mass moves on a spring; `fading` / (1/s) of the
thrust; `valve` / (N·s/m) damps the line while it is drawn out and not while it comes back.
"""


@dataclass(frozen=True)
class Rig:
    """A rig, SI. `start` is the distance from taut, negative: slack. `shape` holds second parameters of effects."""

    m: float
    k: float
    c: float
    start: float
    effects: dict[str, float] = field(default_factory=dict)
    shape: dict[str, float] = field(default_factory=dict)

    def get(self, name: str) -> float:
        """Size of an effect."""
        return self.effects.get(name, 0.0)


@dataclass(frozen=True)
class Push:
    """Thrust / N from `begin` to `end` / s."""

    force: float
    begin: float
    end: float


def toe(e: float, extent: float, lack: float) -> float:
    """What a toe takes from k·e, over k: ∫ lack·(1 − s) de, s a smooth step from 0.9 to 1.1 of the extent."""
    low, width = 0.9 * extent, 0.2 * extent
    if e <= low:
        return lack * e
    q = min((e - low) / width, 1.0)
    return lack * (low + width * (q - q**3 + 0.5 * q**4))


class Motion:
    """One run: regimes one after the other, line slack or taut, module sliding either way or stuck."""

    def __init__(self, rig: Rig, push: Push, slips: float) -> None:
        self.rig, self.push, self.slips = rig, push, slips
        self.taut, self.slide, self.loop, self.offset, self.thrust = False, 0, 1, 0.0, 0.0
        get = rig.get
        self.k, self.c, self.m = rig.k, rig.c, rig.m - get("slosh")
        self.cubic, self.fifth, self.c1, self.k1, self.kh = map(
            get, ("cubic", "fifth", "damping", "zener", "hysteresis")
        )
        self.friction, self.drag, self.drag2, self.gain = map(get, ("friction", "drag", "quadratic drag", "mode"))
        self.tau, self.yields = rig.shape.get("zener.time", 1.0), rig.shape.get("hysteresis.yield", 1.0)
        self.omega, self.zeta = rig.shape.get("mode.frequency", 1.0), rig.shape.get("mode.damping", 0.02)
        self.extent, self.lack = rig.shape.get("toe.extent", 1.0), get("toe")
        self.lag, self.hose, self.valve, self.fading = map(get, ("thrust lag", "hose", "valve", "fading"))
        self.slosh, self.slosh_rate = get("slosh"), rig.shape.get("slosh.frequency", 1.0)
        self.slope = rig.m * GRAVITY * get("tilt")

    def would_pull(self, y: np.ndarray) -> float:
        """T₁ / N, which a taut line has."""
        e, rate = y[X] - y[U] - self.offset, y[V] - y[W]
        T = self.k * (e - toe(e, self.extent, self.lack)) + (self.c + self.c1 * abs(e)) * rate
        T += e**3 * (self.cubic + self.fifth * e * e) + self.k1 * (e - y[Z]) + self.kh * y[H]
        return T + (self.valve * rate if rate > 0 else 0.0)

    def margin(self, y: np.ndarray) -> float:
        """Positive where the line is longer than free and does not push."""
        return min(self.k * (y[X] - y[U] - self.offset), self.would_pull(y))

    def net(self, t: float, y: np.ndarray, T: float) -> float:
        """All forces but friction."""
        v = y[V]
        thrust = self._lagged(t) if self.lag else self.thrust
        if self.fading:
            thrust *= np.exp(-self.fading * (t - self.push.begin))
        found = thrust + self.slope - self.drag * v - self.drag2 * v * abs(v) - T - self.hose * (y[X] - self.rig.start)
        if self.slosh:
            found += self.slosh * self.slosh_rate * (self.slosh_rate * y[Y] + 0.1 * y[YV])
        return found

    def _lagged(self, t: float) -> float:
        """F·(1 − exp(−(t − begin)/τ)) while it pushes, dying away with τ after it."""
        push = self.push
        risen = -np.expm1(-(min(t, push.end) - push.begin) / self.lag)
        return float(push.force * risen * (np.exp(-(t - push.end) / self.lag) if t > push.end else 1.0))

    def rate(self, t: float, y: np.ndarray) -> list[float]:
        """Rates of the states."""
        T = self.would_pull(y) if self.taut else 0.0
        net = self.net(t, y, T)
        a = (net - self.slide * self.friction) / self.m if self.slide else 0.0
        found = [y[V] if self.slide else 0.0, a, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        e = y[X] - y[U] - self.offset if self.taut else 0.0
        if self.k1:
            found[Z] = (e - y[Z]) / self.tau
        if self.kh:
            found[H] = self._loop_rate(y[V] - y[W], y[H]) if y[X] - y[U] > self.offset else 0.0
        if self.gain:
            found[U], found[W] = y[W], self.gain * T - 2 * self.zeta * self.omega * y[W] - self.omega**2 * y[U]
        if self.slosh:  # Y: how far the load has moved against the module
            found[Y], found[YV] = y[YV], -a - self.slosh_rate * (self.slosh_rate * y[Y] + 0.1 * y[YV])
        return found

    def _loop_rate(self, speed: float, h: float) -> float:
        return speed * (1 - (abs(h) / self.yields) ** 1.1) if speed * h > 0 else speed

    def follow(self, stamps: np.ndarray) -> np.ndarray:
        """Rows x − taut, v, T at the stamps, from rest."""
        y = np.zeros(8)
        y[X], edges = self.rig.start, [self.push.begin, min(self.push.end, stamps[-1] + 1e-6), stamps[-1] + 1e-6]
        found = np.zeros((3, len(stamps)))
        found[0] = self.rig.start
        rows, now = [], self.push.begin
        for edge, thrust in zip(edges[1:], (self.push.force, 0.0), strict=True):
            self.thrust = thrust
            self.slide = self._set_going(now, y) if y[V] == 0 else self.slide
            while now < edge - 1e-12:
                part, now, y = self._regime(now, edge, y, stamps)
                rows.append(part)
        moved = np.hstack(rows)
        found[:, len(stamps) - moved.shape[1] :] = moved
        return found

    def _regime(
        self, now: float, edge: float, y: np.ndarray, stamps: np.ndarray
    ) -> tuple[np.ndarray, float, np.ndarray]:
        sign = 1.0 if self.taut else -1.0
        guards: list[Guard] = [lambda _t, y: sign * self.margin(y)]
        slide = self.slide
        guards.append((lambda _t, y: slide * y[V]) if slide else self._grip)
        states, now, y, which = stretch(self.rate, (now, edge), y, guards, stamps, self.longest())
        part = np.vstack([states[X], states[V], self._tensions(states)])
        if which == 0:
            self.taut = not self.taut
        elif which == 1:
            self._turn(now, y)
        return part, now, y

    def longest(self) -> float:
        """Longest step: no guard crosses twice within it."""
        own = np.sqrt(self.k / self.m) if self.taut else 0.0
        fastest = max(own, self.omega / 2 if self.gain else 0.0, self.slosh_rate / 2 if self.slosh else 0.0)
        return float(min(0.4 / fastest, 0.25)) if fastest else 0.25

    def _tensions(self, states: np.ndarray) -> np.ndarray:
        if not self.taut:
            return np.zeros(states.shape[1])
        return np.array([max(self.would_pull(y), 0.0) for y in states.T])

    def _grip(self, t: float, y: np.ndarray) -> float:
        T = self.would_pull(y) if self.taut else 0.0
        return self.friction - abs(self.net(t, y, T))

    def _set_going(self, t: float, y: np.ndarray) -> int:
        T = self.would_pull(y) if self.taut else 0.0
        net = self.net(t + 1e-9, y, T)
        return 0 if abs(net) <= self.friction else int(np.sign(net))

    def _turn(self, now: float, y: np.ndarray) -> None:
        if self.slide:  # it has come to rest
            y[V] = 0.0
            if self.slips and self.taut and not self.offset:
                self.offset = self.slips
                self.taut = self.margin(y) > 0
        self.slide = self._set_going(now, y)


def motion(rig: Rig, push: Push, stamps: np.ndarray, slips: float | None = None) -> np.ndarray:
    """Rows x − taut / m, v / (m/s), T / N at the stamps / s, which begin before the thrust does."""
    return Motion(rig, push, rig.get("slip") if slips is None else slips).follow(stamps)
