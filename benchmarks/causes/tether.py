"""What is true of one campaign of response tests, and what a refit of the model as stated can follow."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .closed import base_motion
from .noise import Sensor
from .rig import Push, Rig, motion
from .sizing import distance

TAUT, GAP, BEGIN, END = 1.5, 0.05, 1.0, 12.0
FRAMES, CELL = 100, 200
SIGMA = {"x": 2.0e-4, "v": 1.5e-3, "T": 4.0e-3}
DIGIT = {"x": 1e-5, "v": 1e-4, "T": 1e-3}
SPECIMENS = {
    "nylon": (25.0, (150, 190), (6, 9)),
    "spectra": (25.0, (650, 850), (25, 40)),
    "cord": (15.0, (350, 500), (4, 8)),
}
"""Mass / kg, ranges of k / (N/m) and c / (N·s/m)."""
RUNS = {
    "low-step-1": (0.38, END, "identification"),
    "low-impulse-1": (0.38, 3.0, "identification"),
    "high-step-1": (0.62, END, "identification"),
    "high-impulse-1": (0.62, 2.6, "identification"),
    "low-step-2": (0.38, END, "verification"),
    "high-impulse-2": (0.62, 2.6, "verification"),
}
"""Thrust / N, until / s, purpose."""
FITTED = tuple(name for name, run in RUNS.items() if run[2] == "identification")
KNOWN = {
    "mass": (1e-3, 0.0), "free length": (5e-4, 0.0), "thrust gain": (5e-3, 2e-3), "cell gain": (3e-3, 0.0),
    "cell zero": (0.0, 3e-3), "clock T": (1e-3, 0.0), "start": (0.0, 2e-4),
}  # fmt: skip
"""Standard uncertainty of inputs: common to all runs, and of each run. Mass and gains are relative, the rest SI."""
PARAMETERS = {
    "friction": ("friction.force", "N"), "drag": ("drag.viscous", "N*s/m"), "quadratic drag": ("drag.quadratic",
    "N*s^2/m^2"),
    "cubic": ("cubic.stiffness", "N/m^3"), "damping": ("damping.amplitude", "N*s/m^2"), "zener": ("zener.stiffness",
    "N/m"),
    "hysteresis": ("hysteresis.stiffness", "N/m"), "toe": ("1 - toe.ratio", "1"), "slip": ("slip.set", "m"),
    "tilt": ("tilt.angle", "rad"), "thrust lag": ("thrust.lag", "s"), "frame": ("frame.compliance", "m/N"),
    "yaw": ("yaw.arm^2/yaw.inertia", "1/kg"), "thrust gain": ("thrust.gain - 1", "1"), "mass": ("mass.factor - 1", "1"),
    "free length": ("free_length.shift", "m"), "cell gain": ("cell.gain - 1", "1"), "cell zero": ("cell.zero", "N"),
    "cell drift": ("cell.drift", "N/s"), "gain drift": ("gain_drift.rate", "1/s"), "clock x": ("clock.x", "s"),
    "clock v": ("clock.v", "s"), "clock T": ("clock.T", "s"), "motion scale": ("motion.scale - 1", "1"),
    "thrust delay": ("thrust.delay", "s"), "hum x": ("hum.x", "m"), "hum v": ("hum.v", "m/s"), "hum T": ("hum.T", "N"),
}  # fmt: skip
"""What the size of a cause is."""
UNLISTED = ("fifth", "hose", "slosh", "fading", "valve", "hop")


@dataclass(frozen=True)
class Rest:
    """What is true of one campaign: rig, sizes of causes that are not in the motion, and shapes of those that are."""

    rig: Rig
    sizes: dict[str, float] = field(default_factory=dict)
    shape: dict[str, float] = field(default_factory=dict)

    def size(self, name: str) -> float:
        """Size of a cause, 0 where it is absent."""
        return self.sizes.get(name, 0.0)


@dataclass(frozen=True)
class Own:
    """What one run has of its own."""

    thrust: float = 0.0
    zero: float = 0.0
    start: float = 0.0
    phase: float = 0.0
    slip: float = 1.0
    hop: float = 6.0


def plant(rest: Rest, name: str, size: float) -> Rest:
    """The same campaign with an effect of that size in it."""
    if name in ("frame", "yaw"):
        omega = rest.shape[f"{name}.frequency"]
        gain = size * omega**2 if name == "frame" else size
        shape = {**rest.rig.shape, "mode.frequency": omega, "mode.damping": rest.shape[f"{name}.damping"]}
        return replace(rest, rig=replace(rest.rig, effects={**rest.rig.effects, "mode": gain}, shape=shape))
    motions = ("friction", "drag", "quadratic drag", "cubic", "damping", "zener", "hysteresis", "toe", "slip", "tilt",
               "thrust lag", "fifth", "hose", "slosh", "fading", "valve")  # fmt: skip
    if name in motions:
        shape = {**rest.rig.shape, **{key: v for key, v in rest.shape.items() if key.startswith(name)}}
        return replace(rest, rig=replace(rest.rig, effects={**rest.rig.effects, name: size}, shape=shape))
    return replace(rest, sizes={**rest.sizes, name: rest.size(name) + size})


def shapes(rig: Rig, rng: np.random.Generator) -> dict[str, float]:
    """Second parameters of effects, as the rig makes them sensible."""
    omega, e = np.sqrt(rig.k / rig.m), 0.62 / rig.k + 0.62 / np.sqrt(rig.k * rig.m) * 1.2
    return {
        "zener.time": float(rng.uniform(0.4, 2.0) / omega), "hysteresis.yield": float(rng.uniform(0.1, 0.3) * e),
        "toe.extent": float(rng.uniform(0.2, 0.45) * e), "slosh.frequency": float(rng.uniform(0.6, 1.6) * omega),
        "frame.frequency": float(rng.uniform(2, 4) * omega), "frame.damping": float(rng.uniform(0.02, 0.05)),
        "yaw.frequency": float(rng.uniform(0.4, 0.8) * omega), "yaw.damping": float(rng.uniform(0.01, 0.05)),
        "hum.frequency": float(rng.uniform(8, 45)),
    }  # fmt: skip


def first_size(name: str, rig: Rig) -> float:
    """A size that shows a little."""
    e = 0.62 / rig.k + 0.62 / np.sqrt(rig.k * rig.m)
    return {
        "friction": 1e-3, "drag": 5e-3, "quadratic drag": 0.05, "cubic": 0.02 * rig.k / e**2,
        "damping": 0.1 * rig.c / e,
        "zener": 0.02 * rig.k, "hysteresis": 0.03 * rig.k, "toe": 0.05, "slip": 1e-4, "tilt": 3e-5, "thrust lag": 5e-3,
        "frame": 0.01 / rig.k, "yaw": 0.01 / rig.m, "thrust gain": 0.03, "mass": 0.01, "free length": 3e-3,
        "cell gain": 0.02,
        "cell zero": 0.02, "cell drift": 1e-4, "gain drift": 1e-4, "clock x": 2e-3, "clock v": 2e-3, "clock T": 5e-3,
        "motion scale": 2e-3, "thrust delay": 5e-3, "hum x": 5e-5, "hum v": 3e-4, "hum T": 1e-3,
        "fifth": 0.02 * rig.k / e**4,
        "hose": 0.01, "slosh": 0.05, "fading": 1e-3, "valve": 0.1 * rig.c, "hop": 1e-4,
    }[name]  # fmt: skip


def truth_of(run: str, rest: Rest, own: Own, stamps: tuple[np.ndarray, np.ndarray]) -> dict[str, np.ndarray]:
    """What the instruments would read of one run without noise, at the stamps of cameras and cell."""
    force, until, _ = RUNS[run]
    t, s = stamps
    size, rig = rest.size, rest.rig
    late = size("thrust delay")
    until = until + late if until < END else END + 1.0
    push = Push(force * (1 + size("thrust gain") + own.thrust), BEGIN + late, until)
    rig = replace(rig, m=rig.m * (1 + size("mass")), start=-GAP - size("free length") + own.start)
    places_ = [
        np.maximum(t - size("clock x"), 0),
        np.maximum(t - size("clock v"), 0),
        np.maximum(s - size("clock T"), 0),
    ]
    every, at = np.unique(np.concatenate(places_), return_inverse=True)
    rows = motion(rig, push, every, rig.get("slip") * own.slip) if rig.effects else base_motion(rig, push, every)
    n = len(t)
    x, v, T = rows[0][at[:n]] + TAUT + size("free length"), rows[1][at[n : 2 * n]], rows[2][at[2 * n :]]
    scale = 1 + size("motion scale")
    hum = {
        channel: size(f"hum {channel}") * np.sin(2 * np.pi * rest.shape.get("hum.frequency", 20.0) * when + own.phase)
        for channel, when in (("x", t), ("v", t), ("T", s))
    }
    T = (
        T * (1 + size("cell gain")) * (1 + size("gain drift") * s)
        + size("cell zero")
        + own.zero
        + size("cell drift") * s
    )
    x, v = scale * x + hum["x"] + size("hop") * (t > own.hop), scale * v + hum["v"]
    return {"x": x, "v": v, "T": T + hum["T"], "pulls": rows[2][at[2 * n :]] > 0}


def grid() -> tuple[np.ndarray, np.ndarray]:
    """Stamps of cameras and cell."""
    return np.arange(round(END * FRAMES) + 1) / FRAMES, np.arange(round(END * CELL) + 1) / CELL


class Refit:
    """What a refit of the model as stated can follow: J over k, c and the inputs within their priors."""

    def __init__(self, base: Rest, sensors: dict[str, Sensor]) -> None:
        self.base, self.u = base, {channel: one.u for channel, one in sensors.items()}
        self.stamps = grid()
        self.plain = {run: truth_of(run, base, Own(), self.stamps) for run in FITTED}
        self.jacobian, self.priors = self._columns()

    def moved(self, rest: Rest, own: dict[str, Own] | None = None) -> np.ndarray:
        """Change of all readings in noise units, NaN for tensions beside a change of contact in either motion."""
        news = {run: truth_of(run, rest, (own or {}).get(run, Own()), self.stamps) for run in FITTED}
        return np.concatenate([self._difference(news[run], self.plain[run]) for run in FITTED])

    def _difference(self, new: dict[str, np.ndarray], old: dict[str, np.ndarray]) -> np.ndarray:
        changes = np.zeros(len(old["T"]), dtype=bool)
        for pulls in (new["pulls"], old["pulls"]):
            changes[1:] |= pulls[1:] != pulls[:-1]
        beside = (np.convolve(changes, np.ones(5), "same") > 0) | (new["pulls"] != old["pulls"])
        parts = [(new[channel] - old[channel]) / self.u[channel] for channel in "xvT"]
        parts[2][beside] = np.nan
        return np.concatenate(parts)

    def _columns(self) -> tuple[np.ndarray, np.ndarray]:
        rig, columns, priors = self.base.rig, [], []
        for name, step in (("k", 1e-5 * rig.k), ("c", 1e-4 * rig.c)):
            columns.append(self.moved(replace(self.base, rig=replace(rig, **{name: getattr(rig, name) + step}))) / step)
            priors.append(np.inf)
        steps = {
            "mass": 1e-5,
            "free length": 1e-7,
            "thrust gain": 1e-5,
            "cell gain": 1e-4,
            "cell zero": 1e-4,
            "clock T": 1e-6,
        }
        common = {name: self.moved(plant(self.base, name, step)) / step for name, step in steps.items()}
        common["start"] = self.moved(self.base, dict.fromkeys(FITTED, Own(start=1e-7))) / 1e-7
        length = len(columns[0]) // len(FITTED)
        for name, column in common.items():
            shared, each = KNOWN[name]
            if shared:
                columns.append(column)
                priors.append(shared)
            for i in range(len(FITTED)) if each else ():
                rows = np.zeros_like(column)
                rows[i * length : (i + 1) * length] = column[i * length : (i + 1) * length]
                columns.append(rows)
                priors.append(each)
        return np.column_stack(columns), np.array(priors)

    def distance(self, rest: Rest) -> float:
        """Distance of a campaign from the base model."""
        moved = self.moved(rest)
        used = np.isfinite(moved) & np.isfinite(self.jacobian).all(axis=1)
        return distance(moved[used], self.jacobian[used], self.priors)
