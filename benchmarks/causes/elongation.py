"""Cases of elongation under dead loads: readings of an indicator, loads up and down, several repeats.

    x = F/k + (what is planted) + zero of the repeat + error of the indicator at the load + noise

Creep is that of three Kelvin-Voigt elements in series whose times span the test; the toe is a·tanh(F/F₀); the backlash
opens within the first step back.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .alike import groups
from .noise import KINDS, STEP
from .plan import Case, Plan, Truth, answer, dump, laboratory
from .sizing import distance, size_for

GRAVITY = 9.806
REPEATS = 3
SPECIMENS = {"tape": ((2.2e4, 2.7e4), 0.5, 7), "cord": ((1500.0, 2100.0), 0.1, 8), "bar": ((2.0e5, 3.0e5), 6.0, 6)}
"""Range of k / (N/m), step of the loads / kg, number of loads."""
SIGMA, DIGIT, INDICATOR, MASSES = 3e-6, 1e-6, 1.5e-6, 1e-5
"""Noise and step of a reading, u of the indicator at a load / m; u of a mass, relative."""
PARAMETERS = {
    "backlash": ("backlash.width", "m"), "creep": ("compliance of the branches, over three", "m/N"),
    "curvature": ("curvature.coefficient", "m/N^2"), "drift": ("drift over one reading", "m"), "load": ("load.error",
    "m"),
    "misread": ("misread.error", "m"), "mounting": ("compliance from one repeat to the next", "m/N"),
    "slip": ("slip.set", "m"), "toe": ("toe.extent", "m"),
}  # fmt: skip
UNLISTED = ("sticking dial", "stick-slip clamp", "periodic dial", "repeat bend")
SIGNED = ("curvature", "drift", "load", "misread", "backlash", "mounting")


@dataclass(frozen=True)
class Bench:
    """What is true of one test: stiffness, masses / kg in the order of the readings, and what is planted."""

    k: float
    mass: np.ndarray
    repeat: np.ndarray
    back: np.ndarray
    sizes: dict[str, float] = field(default_factory=dict)
    place: dict[str, float] = field(default_factory=dict)

    @property
    def force(self) -> np.ndarray:
        """Force / N of each reading, buoyancy of steel in air included."""
        return self.mass * GRAVITY * (1 - 1.20 / 8000)


def bench(specimen: str, rng: np.random.Generator) -> Bench:
    """A test with nothing planted."""
    ks, step, count = SPECIMENS[specimen]
    up = np.arange(1, count + 1) * step
    mass = np.tile(np.concatenate([up, up[::-1]]), REPEATS)
    repeat = np.repeat(np.arange(1, REPEATS + 1), 2 * count)
    back = np.tile(np.repeat([False, True], count), REPEATS)
    place = {
        "load": float(up[rng.integers(1, count - 1)]), "reading": float(rng.integers(2, len(mass) - 2)),
        "slip": float(2 * count * rng.integers(REPEATS) + rng.integers(3, 2 * count - 4)),
        "toe": float(rng.uniform(0.1, 0.2)),
        "pitch": float(rng.uniform(0.2, 0.45)),
    }  # fmt: skip
    return Bench(float(rng.uniform(*ks)), mass, repeat, back, place=place)


def truth_of(b: Bench) -> np.ndarray:
    """Extensions / m without zeros, indicator and noise."""
    F, k, size = b.force, b.k, b.sizes.get
    x = F / k
    most, count = float(F.max()), len(F)
    order = np.arange(count)
    x = (
        x
        + size("toe", 0.0) * np.tanh(F / (1.2 * b.place["toe"] * most))
        + size("curvature", 0.0) * F**2
        + size("creep", 0.0) * _crept(b)
    )
    x = x + size("backlash", 0.0) * _play(b) + size("load", 0.0) * (b.mass == b.place["load"])
    x = x + size("misread", 0.0) * (order == b.place["reading"]) + size("slip", 0.0) * (order > b.place["slip"])
    x = x + size("drift", 0.0) * (order + 0.15 * np.sin(order / count * np.pi) * count)
    x = x + size("periodic dial", 0.0) * np.sin(2 * np.pi * x / (b.place["pitch"] * most / k))
    x = x + size("sticking dial", 0.0) * np.where(b.back, -1.0, 1.0) * (b.mass > 0.6 * b.mass.max()) * (b.repeat % 2)
    x = x + size("stick-slip clamp", 0.0) * np.floor(1.7 * F / most + 0.31 * b.repeat) * (b.repeat > 1)
    x = x + size("mounting", 0.0) * F * (1 - 0.05 * F / most) * (b.repeat - 2)
    return x + size("repeat bend", 0.0) * 4 * F / most * (1 - F / most) * (b.repeat - 2)


def _crept(b: Bench) -> np.ndarray:
    """Mean strain of three Kelvin-Voigt elements of compliance 1, a reading a unit of time, at rest before a repeat."""
    found = np.zeros(len(b.force))
    for repeat in np.unique(b.repeat):
        z = np.zeros(3)
        for i in np.flatnonzero(b.repeat == repeat):
            fade = np.exp(-1.0 / np.array([1.0, 4.0, 16.0]))
            z = b.force[i] + (z - b.force[i]) * fade
            found[i] = z.sum() / 3
    return found


def _play(b: Bench) -> np.ndarray:
    """Unloading readings off by a width that opens within the first step back."""
    top = b.mass.max()
    return np.where(b.back, np.minimum(1.0, (top - b.mass) / (0.5 * (b.mass[1] - b.mass[0])) + 0.2), 0.0)


class Refit:
    """What a line through all readings, a zero for each repeat and the inputs within their priors can follow."""

    def __init__(self, base: Bench, u: float) -> None:
        self.plain, self.u = truth_of(base), u
        F = base.force
        loads = [(base.mass == one).astype(float) for one in np.unique(base.mass)]
        zeros = [(base.repeat == one).astype(float) for one in np.unique(base.repeat)]
        self.jacobian = np.column_stack([F / base.k, *zeros, *loads]) / u
        self.priors = np.array([np.inf] * (1 + len(zeros)) + [INDICATOR] * len(loads))

    def distance(self, changed: Bench) -> float:
        """Distance of a test from the base model."""
        return distance((truth_of(changed) - self.plain) / self.u, self.jacobian, self.priors)


def plant(b: Bench, name: str, size: float) -> Bench:
    """The same test with an effect of that size in it."""
    return replace(b, sizes={**b.sizes, name: size})


def first_size(name: str, b: Bench) -> float:
    """A size that shows a little."""
    most = float(b.force.max())
    return {"curvature": 1e-5 / most**2, "creep": 1e-5 / most, "mounting": 1e-5 / most, "drift": 1e-6}.get(name, 1e-5)


def make(plan: Plan) -> Case:
    """Files of a case."""
    rng = plan.rng()
    base = bench(plan.specimen, rng)
    sigma = SIGMA * (0.3 if plan.noise == "bare" else 1.0)
    step = max(DIGIT, 1e-6 * np.round(1e6 * STEP.get(plan.noise, 0.0) * sigma))
    refit = Refit(base, float(np.hypot(sigma, step / np.sqrt(12))))
    wanted = dict(zip(plan.causes, plan.distances, strict=True))
    if plan.unlisted:
        wanted[plan.unlisted] = plan.unlisted_distance()
    b, sizes = base, {}
    for name, d in wanted.items():
        sign = float(rng.choice([-1, 1])) if name in SIGNED else 1.0

        def measure(size: float, name: str = name, sign: float = sign) -> float:
            return refit.distance(plant(base, name, sign * size))

        sizes[name] = sign * size_for(d, first_size(name, base), measure)
        b = plant(b, name, sizes[name])
    true = truth_of(b)
    error = {one: rng.standard_normal() * INDICATOR for one in np.unique(b.mass)}
    shared = np.array([error[one] for one in b.mass])
    shift = rng.uniform(5e-5, 2e-4) + np.cumsum(rng.standard_normal(REPEATS) * 4e-6)
    x = true + shared + shift[b.repeat - 1] + sigma * KINDS[plan.noise](len(true), rng)
    x = np.round(x / step) * step
    found = {cause: (PARAMETERS[cause][0], sizes[cause], PARAMETERS[cause][1]) for cause in plan.causes}
    distances = dict(zip(plan.causes, plan.distances, strict=True))
    alike = groups("elongation", plan.specimen, sizes, distances)
    truth = Truth(found, distances, alike, (base.k, "N/m"))
    names = {one: f"L{i + 1}" for i, one in enumerate(np.unique(b.mass))}
    files = {"readings.csv": _readings(b, x, names), "campaign.yaml": dump(campaign(plan, names, step, rng))}
    files["expected.yaml"] = answer(plan, truth)
    return Case(files)


def _readings(b: Bench, x: np.ndarray, names: dict[float, str]) -> str:
    rows = [
        f"{names[mass]},{repeat},{'unloading' if back else 'loading'},{1e3 * value:.3f}"
        for mass, repeat, back, value in zip(b.mass, b.repeat, b.back, x, strict=True)
    ]
    return "\n".join(["load,repeat,direction,reading / mm", *rows]) + "\n"


def campaign(plan: Plan, names: dict[float, str], step: float, rng: np.random.Generator) -> dict[str, Any]:
    """What the laboratory states."""
    u = INDICATOR * (2 ** rng.uniform(-1, 1) if "wrong noise" in plan.traits else 1.0)
    found = laboratory(plan, f"Elongation: {plan.specimen}")
    certificate = {"number": "C-1", "date": "2026-03-01", "due": "2027-03-01"}
    found["instruments"] = {
        "indicator": {"kind": "dial indicator", "resolution": f"{1e6 * step:.0f} um",
                      "certificate": {**certificate, "expanded_uncertainty": f"{2e6 * u:.2f} um", "k": 2}},
        "weights": {"kind": "set of weights", "certificate": {**certificate, "number": "C-2",
        "expanded_uncertainty": "0.002 %", "k": 2}},
    }  # fmt: skip
    found["samples"] = {
        plan.specimen: {
            "section": {"shape": "tape", "width": "25.00(5) mm", "thickness": "0.0500(10) mm"},
            "length": "2.990(1) m",
        }
    }
    found["tests"] = {
        "elongation": {
            "method": "elongation", "sample": plan.specimen, "instruments": {"extension": "indicator",
            "load": "weights"},
            "gravity": f"{GRAVITY} m/s^2",
            "loads": {name: {"mass": f"{mass:.3f} kg"} for mass, name in names.items()}, "readings": "readings.csv",
        }
    }  # fmt: skip
    return found
