"""Cases of free decays: what is true of a body and its vibrometer, what the laboratory states, and the readings."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .alike import groups
from .noise import Sensor
from .plan import Case, Plan, Truth, answer, dump, laboratory, places, table
from .sizing import size_for
from .swing import Body, closed, swing

RELEASES = 3
HELD = 0.1
"""Share of the record before the release."""


@dataclass(frozen=True)
class Specimen:
    """A test: ranges of mass (or inertia), k and c, first swing, rate / Hz, length / s, noise and its digit; SI."""

    m: tuple[float, float]
    k: tuple[float, float]
    c: tuple[float, float]
    amplitude: float
    rate: float
    length: float
    sigma: float
    digit: float
    turns: bool = False


SPECIMENS = {
    "tape": Specimen((1.15, 1.25), (2.2e4, 2.7e4), (15.0, 50.0), 4e-4, 2000.0, 0.9, 4e-7, 1e-7),
    "spring": Specimen((0.18, 0.22), (100.0, 140.0), (0.02, 0.05), 8e-3, 200.0, 10.0, 1.5e-5, 1e-6),
    "torsion": Specimen((0.018, 0.022), (0.25, 0.35), (4e-4, 8e-4), 1.0, 50.0, 50.0, 1e-3, 1e-4, turns=True),
}
PARAMETERS = {
    "friction": ("friction.force", "N"), "quadratic drag": ("drag.quadratic", "N*s^2/m^2"),
    "cubic": ("cubic.stiffness", "N/m^3"),
    "even stiffness": ("even.stiffness", "N/m^2"), "damping": ("damping.amplitude", "N*s/m^2"),
    "pendulum": ("sine.rate^2", "1/m^2"), "drift": ("drift", "m"), "mains": ("amplitude", "m"), "other": ("amplitude",
    "m"),
}  # fmt: skip
IN_MOTION = (
    "friction",
    "quadratic drag",
    "cubic",
    "even stiffness",
    "damping",
    "pendulum",
    "fifth",
    "stop",
    "valve",
    "power",
)
UNLISTED = ("fifth", "stop", "valve", "power", "gain step", "hop")
SIGNED = ("cubic", "even stiffness", "drift")


@dataclass(frozen=True)
class Rest:
    """What is true of one test: body, sizes of what is only in the readings, and its shapes."""

    body: Body
    amplitude: float
    sizes: dict[str, float] = field(default_factory=dict)
    shape: dict[str, float] = field(default_factory=dict)

    def size(self, name: str) -> float:
        """Size of a cause, 0 where it is absent."""
        return self.sizes.get(name, 0.0)


def plant(rest: Rest, name: str, size: float) -> Rest:
    """The same test with an effect of that size in it."""
    if name in IN_MOTION:
        return replace(rest, body=replace(rest.body, effects={**rest.body.effects, name: size}))
    return replace(rest, sizes={**rest.sizes, name: size})


def first_size(name: str, body: Body, amplitude: float) -> float:
    """A size that shows a little."""
    speed = amplitude * np.sqrt(body.k / body.m)
    return {
        "friction": 1e-3 * body.k * amplitude, "quadratic drag": 0.05 * body.c / speed,
        "cubic": 1e-3 * body.k / amplitude**2,
        "even stiffness": 1e-3 * body.k / amplitude, "damping": 0.05 * body.c / amplitude,
        "pendulum": 0.01 / amplitude**2,
        "drift": 1e-3 * amplitude, "mains": 1e-3 * amplitude, "other": 1e-3 * amplitude,
        "fifth": 1e-3 * body.k / amplitude**4,
        "stop": 1e-2 * body.k, "valve": 0.1 * body.c, "power": 0.05 * body.c / np.sqrt(speed),
        "gain step": 1e-3, "hop": 1e-3 * amplitude,
    }[name]  # fmt: skip


def truth_of(rest: Rest, amplitude: float, stamps: np.ndarray, phase: float, when: float = 0.4) -> np.ndarray:
    """What the instrument would read without noise and offset; `stamps` from the release on, `when` share of it."""
    body, size, end = rest.body, rest.size, float(stamps[-1])
    x = swing(body, amplitude, stamps) if body.effects else closed(body, amplitude, stamps)
    late, part = stamps > when * end, stamps / end
    x = x * (1 + size("gain step") * late) + size("hop") * late
    x = (
        x
        + size("drift") * (part + 0.4 * (part - part**2))
        + size("mains") * np.sin(2 * np.pi * rest.shape["mains"] * stamps + phase)
    )
    ring = np.exp(-rest.shape["other.rate"] * stamps) * np.sin(
        2 * np.pi * rest.shape["other.frequency"] * stamps + phase
    )
    return x + size("other") * ring


def refitted(t: np.ndarray, x: np.ndarray, body: Body) -> np.ndarray:
    """What a fitted damped oscillation with an offset leaves of a record."""
    decay = body.c / (2 * body.m)
    p = np.array([decay, np.sqrt(body.k / body.m - decay**2)])

    def columns(p: np.ndarray) -> np.ndarray:
        fade = np.exp(-p[0] * t)
        return np.column_stack([fade * np.cos(p[1] * t), fade * np.sin(p[1] * t), np.ones_like(t)])

    for _ in range(8):  # variable projection by Gauss and Newton
        A = columns(p)
        a = np.linalg.lstsq(A, x, rcond=None)[0]
        r = x - A @ a
        wave, turned = A[:, 0] * a[0] + A[:, 1] * a[1], A[:, 0] * a[1] - A[:, 1] * a[0]
        J = np.column_stack([A, -t * wave, t * turned])
        step = np.linalg.lstsq(J, r, rcond=None)[0][3:]
        p = p + step
        if np.all(np.abs(step) < 1e-10 * np.abs(p)):
            break
    return r


def make(plan: Plan) -> Case:
    """Files of a case."""
    rng, specimen = plan.rng(), SPECIMENS[plan.specimen]
    m, k, c = (float(rng.uniform(*limits)) for limits in (specimen.m, specimen.k, specimen.c))
    body = Body(m, k, c)
    ratio = float(rng.choice([rng.uniform(0.35, 0.6), rng.uniform(1.5, 2.6)]))
    natural = np.sqrt(k / m) / (2 * np.pi)
    shape = {"mains": 50.0 + float(rng.uniform(-0.03, 0.03)), "other.frequency": ratio * natural,
             "other.rate": float(rng.uniform(0.5, 3) / specimen.length)}  # fmt: skip
    sensor = Sensor(plan.noise, specimen.sigma * (0.5 if plan.noise == "bare" else 1.0), specimen.digit,
                    spikes=3 * int("spikes" in plan.traits), gaps=2 * int("gaps" in plan.traits))  # fmt: skip
    rest = Rest(body, specimen.amplitude, shape=shape)
    wanted = dict(zip(plan.causes, plan.distances, strict=True))
    if plan.unlisted:
        wanted[plan.unlisted] = plan.unlisted_distance()
    sizes = {}
    for name, d in wanted.items():
        sizes[name] = sized(name, d, Rest(body, specimen.amplitude, shape=shape), sensor, specimen, rng)
        rest = plant(rest, name, sizes[name])
    return _written(plan, rest, sizes, sensor, rng)


def sized(name: str, d: float, rest: Rest, sensor: Sensor, specimen: Specimen, rng: np.random.Generator) -> float:
    """Size with distance d in all releases together."""
    stamps = np.arange(0, specimen.length, 1 / specimen.rate)
    sign = float(rng.choice([-1, 1])) if name in SIGNED else 1.0

    def measure(size: float) -> float:
        x = truth_of(plant(rest, name, sign * size), rest.amplitude, stamps, 1.0)
        return float(np.linalg.norm(refitted(stamps, x, rest.body)) / sensor.u * np.sqrt(RELEASES))

    return sign * size_for(d, first_size(name, rest.body, rest.amplitude), measure)


def _written(plan: Plan, rest: Rest, sizes: dict[str, float], sensor: Sensor, rng: np.random.Generator) -> Case:
    specimen, files, names = SPECIMENS[plan.specimen], {}, []
    head, factor, unit = ("angle / rad", 1.0, "rad") if specimen.turns else ("displacement / um", 1e6, "m")
    for i in range(RELEASES):
        t = _stamps(specimen, "irregular" in plan.traits, rng)
        free = t >= 0
        amplitude = rest.amplitude * (1 + 0.05 * rng.standard_normal())
        x = np.full(len(t), amplitude)
        x[free] = truth_of(rest, amplitude, t[free], rng.uniform(0, 2 * np.pi), rng.uniform(0.25, 0.5))
        y = sensor.read(x + rng.uniform(-0.02, 0.02) * rest.amplitude, rng) * factor
        names.append(f"decay-{i + 1}.csv")
        files[names[-1]] = table(
            f"time / s,{head}", (t, y), (6 if "irregular" in plan.traits else 4, places(sensor.step * factor))
        )
    body = rest.body
    found = {
        cause: (PARAMETERS[cause][0], sizes[cause], _unit(PARAMETERS[cause][1], specimen.turns))
        for cause in plan.causes
    }
    distances = dict(zip(plan.causes, plan.distances, strict=True))
    alike = groups("decay", plan.specimen, sizes, distances)
    turned = ("N*m/rad", "N*m*s/rad") if specimen.turns else ("N/m", "N*s/m")
    truth = Truth(found, distances, alike, (body.k, turned[0]), (body.c, turned[1]))
    files["campaign.yaml"] = dump(campaign(plan, names, body, sensor, unit))
    files["expected.yaml"] = answer(plan, truth)
    return Case(files)


def _stamps(specimen: Specimen, irregular: bool, rng: np.random.Generator) -> np.ndarray:
    step = 1 / specimen.rate
    t = np.arange(-round(HELD * specimen.length / step), round(specimen.length / step)) * step
    return np.round(t + rng.uniform(-0.3, 0.3, len(t)) * step, 6) if irregular else t


def _unit(unit: str, turns: bool) -> str:
    return f"as of an angle: {unit}" if turns else unit


def campaign(plan: Plan, names: list[str], body: Body, sensor: Sensor, unit: str) -> dict[str, Any]:
    """What the laboratory states; its mass is exact, since k = m·ω² takes all its error."""
    turns = SPECIMENS[plan.specimen].turns
    inertia = {"inertia": f"{body.m:.9g} kg*m^2"} if turns else {"mass": f"{body.m:.9g} kg"}
    found = laboratory(plan, f"Free decay: {plan.specimen}")
    found["instruments"] = {
        "sensor": {"kind": "angle encoder" if turns else "laser vibrometer", "resolution": f"{sensor.step:.3g} {unit}"}
    }
    found["samples"] = {plan.specimen: {"material": "steel"}}
    found["tests"] = {"decay": {"method": "decay", "sample": plan.specimen, "instruments": {"displacement": "sensor"},
                                **inertia,
                                "readings": names}}  # fmt: skip
    return found
