"""Campaigns with an effect hidden in them at a stated distance, drawn by a generator that shares nothing with ours."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from response_cases import HELD_OUT, MATERIALS, PRIORS, SCATTER, SHORT, measured
from truth_full import Full, follow
from truth_response import Instruments, Scatter, campaign, common_part

from metrology.diagnostics import Response, Settings, response
from metrology.diagnostics.search import Search
from metrology.estimation import Prior
from metrology.rig import Rig

TESTS = (*SHORT, *HELD_OUT)
TAUT, MASS = 0.1, 25.0
SIZES = {"nylon": 0.010, "spectra": 0.0026, "peek": 0.0014, "al-1100": 2.0e-4}
"""Largest elongation in these runs, about / m."""
NOWHERE = Scatter()
PLANS: dict[str, tuple[Scatter, tuple[Prior, ...]]] = {
    "few": (SCATTER, PRIORS),
    "usual": (
        replace(SCATTER, gain=2e-3, scale=1e-3, zero_run=2e-3, clock=5e-4),
        (
            *PRIORS,
            Prior("cell.gain", 2e-3),
            Prior("motion.scale", 1e-3),
            Prior("cell.zero", 0.0, 2e-3),
            Prior("clock.T", 5e-4),
        ),
    ),
}
"""What the laboratory knows within an uncertainty: scatter of the truth, and the priors that state it."""
Values = dict[str, float]


@dataclass(frozen=True)
class Plant:
    """An effect of the generator.

    `fields`: given amount, a material and random numbers, its fields; those of `Instruments` begin with '.'.
    `values`: from those fields to the parameters that the candidate of that name should find.
    """

    amount: float
    fields: Callable[[float, str, np.random.Generator], Values]
    values: Mapping[str, Callable[[Values], float]]


def _plain(field: str, parameter: str, amount: float, null: float = 0.0) -> Plant:
    return Plant(amount, lambda a, _m, _r: {field: null + a}, {parameter: lambda found: found[field]})


def _omega(material: str) -> float:
    return float(np.sqrt(MATERIALS[material][0] / MASS))


def _stiffness(material: str) -> float:
    return MATERIALS[material][0]


PLANTED: dict[str, Plant] = {
    "friction": _plain("friction", "friction.force", 1e-3),
    "drag": _plain("viscous", "drag.viscous", 1e-2),
    "quadratic drag": _plain("quadratic", "drag.quadratic", 0.1),
    "tilt": _plain("tilt", "tilt.angle", 1e-5),
    "cubic": Plant(
        0.02,
        lambda a, m, _r: {"cubic": a * _stiffness(m) / SIZES[m] ** 2},
        {"cubic.stiffness": lambda found: found["cubic"]},
    ),
    "damping": Plant(
        0.05,
        lambda a, m, _r: {"amplitude": a * _stiffness(m) / _omega(m) / SIZES[m]},
        {"damping.amplitude": lambda found: found["amplitude"]},
    ),
    "frame": Plant(
        0.03,
        lambda a, m, r: {
            "frame": a / _stiffness(m), "frame_omega": min(float(r.uniform(2.5, 12)) * _omega(m), 400.0),
            "frame_zeta": 0.03,
        },
        {"frame.compliance": lambda found: found["frame"], "frame.frequency": lambda found: found["frame_omega"]},
    ),
    "toe": Plant(
        0.05,
        lambda a, m, r: {"toe": min(a, 0.9), "toe_end": float(r.uniform(0.1, 0.5)) * SIZES[m]},
        {"toe.ratio": lambda found: 1 - found["toe"], "toe.extent": lambda found: found["toe_end"]},
    ),
    "zener": Plant(
        0.05,
        lambda a, m, r: {"branch": a * _stiffness(m), "branch_time": float(np.exp(r.uniform(-1.2, 1.8))) / _omega(m)},
        {"zener.stiffness": lambda found: found["branch"], "zener.time": lambda found: found["branch_time"]},
    ),
    "hysteresis": Plant(
        0.03,
        lambda a, m, r: {"loop": a * _stiffness(m), "loop_end": float(r.uniform(0.05, 0.3)) * SIZES[m]},
        {"hysteresis.stiffness": lambda found: found["loop"], "hysteresis.yield": lambda found: found["loop_end"]},
    ),
    "sag": _plain("weight", "sag.weight", 0.3),
    "slip": Plant(0.05, lambda a, m, _r: {"slip": a * SIZES[m]}, {"slip.set": lambda found: found["slip"]}),
    "yaw": Plant(
        0.05,
        lambda a, m, r: {"arm": float(np.sqrt(a)) * 0.2, "inertia": 0.5, "yaw_omega": float(r.uniform(0.5, 2.5))
                         * _omega(m)},
        {"yaw.frequency": lambda found: found["yaw_omega"]},
    ),
    "appendage": Plant(
        0.02,
        lambda a, m, r: {"tank": a * stated(m).m, "tank_omega": float(r.uniform(0.5, 2.5)) * _omega(m)},
        {"appendage.mass": lambda found: found["tank"], "appendage.frequency": lambda found: found["tank_omega"]},
    ),
    "thrust gain": _plain("thrust_gain", "thrust.gain", 0.01, 1.0),
    "thrust lag": _plain("lag", "thrust.lag", 2e-3),
    "thrust delay": _plain("delay", "thrust.delay", 2e-3),
    "mass": Plant(0.01, lambda a, _m, _r: {"heavier": a}, {"mass.factor": lambda found: 1 + found["heavier"]}),
    "free length": _plain("longer", "free_length.shift", 1e-3),
    "cell gain": _plain(".gain", "cell.gain", 0.01, 1.0),
    "cell zero": _plain(".zero", "cell.zero", 1e-3),
    "cell drift": _plain(".drift", "cell.drift", 1e-4),
    "motion scale": _plain(".scale", "motion.scale", 0.003, 1.0),
    "clock x": _plain(".clock_x", "clock.x", 1e-3),
    "clock v": _plain(".clock_v", "clock.v", 1e-3),
    "clock T": _plain(".clock_T", "clock.T", 1e-3),
    "hum x": Plant(
        1e-5,
        lambda a, _m, r: {".hum_x": a, ".hum_frequency": float(r.uniform(20, 40))},
        {"hum.x": lambda found: found[".hum_x"]},
    ),
    "hum T": Plant(
        1e-4,
        lambda a, _m, r: {".hum": a, ".hum_frequency": float(r.uniform(20, 90))},
        {"hum.T": lambda found: found[".hum"]},
    ),
}  # fmt: skip
"""Effects in the table of candidates."""

UNLISTED: dict[str, Plant] = {
    "magnet": _plain("magnet", "", 0.01),
    "ripple": _plain("ripple", "", 0.01),
    "leak": _plain("leak", "", 1e-3),
    "warming": _plain("warming", "", 1e-3),
    "sway": Plant(1e-3, lambda a, _m, r: {"sway": a, "sway_rate": float(r.uniform(0.2, 0.6))}, {}),
    "knock": Plant(0.02, lambda a, _m, r: {"knock": a, "knock_time": float(r.uniform(3.5, 8.0))}, {}),
    "patch": _plain("patch", "", 2e-3),
    "cable": _plain("cable", "", 0.02),
    "cell curve": _plain(".curve", "", 5e-3),
}
"""In nobody's table."""
EVERY = {**PLANTED, **UNLISTED}


def stated(material: str, *, on_k: float = 1.1, on_c: float = 0.8) -> Rig:
    """The rig as the lab states it: stiffness and damping off, the free length that of the taut position."""
    k, c = MATERIALS[material]
    return Rig(m=MASS, k=on_k * k, c=on_c * c, taut=TAUT, length=TAUT)


def drawn(material: str, scatter: Scatter, fields: Values, seed: int, **changes):
    """Measured runs with these fields."""
    k, c = MATERIALS[material]
    own = {name: value for name, value in fields.items() if not name.startswith(".")}
    seen = {name[1:]: value for name, value in fields.items() if name.startswith(".")}
    clocks = tuple(seen.pop(f"clock_{channel}", 0.0) for channel in "xvT")
    truth = Full(m=MASS, k=k, c=c, taut=TAUT, **own)
    instruments = replace(Instruments(offset=clocks, **seen), **changes)
    records = campaign(truth, TESTS, instruments, scatter, np.random.default_rng(seed), follow=follow)
    noise = {"noise": NOISE} if changes else {}
    return [measured(record, **noise) for record in records]


def known(plan: str, seed: int) -> Values:
    """Inputs that a campaign drawn with this seed has in common, as the rig names them: what is stated scatters too."""
    common = common_part(PLANS[plan][0], np.random.default_rng(seed))
    return {
        "mass.factor": common["mass"], "thrust.gain": common["thrust"], "free_length.shift": common["length"],
        "cell.gain": common["gain"], "motion.scale": common["scale"], "clock.T": common["clock"],
    }  # fmt: skip


QUIET = {"rounding": (0.0, 0.0, 0.0), "noise": (0.0, 0.0, 0.0)}
NOISE = dict(zip("xvT", Instruments().noise, strict=True))


def distance(material: str, plan: str, fields: Values) -> float:
    """Standard deviations by which fields move the data, all that is known or sought marginalised.

    The base model is fitted to what the instruments would read without noise: the root of what is left of the cost.
    """
    k, c = MATERIALS[material]
    begun = {"k": k, "c": c, "mass.factor": 1 + fields.get("heavier", 0.0)}
    begun |= {"thrust.gain": fields.get("thrust_gain", 1.0), "free_length.shift": fields.get("longer", 0.0)}
    fit = _quiet(material, plan, fields).fit((), [begun])
    return math.inf if fit is None else math.sqrt(fit.cost)


def unlike(material: str, plan: str, fields: Values, tried: int = 4) -> float:
    """Distance that the best single cause of the table leaves of these fields: what tells them from it.

    Of the candidates, those that promise most on the straight line are fitted: a lesser one might leave less.
    """
    subject = _quiet(material, plan, fields)
    base = subject.fit((), [{}])
    if base is None:
        return math.inf
    search = Search(subject, tried, workers=1, say=lambda _text: None)
    view = search.view(base)
    alone = sorted((one for one in view.evidence if len(one) == 1), key=lambda one: -view.evidence[one])
    search.fit_sets(view, alone[:tried])
    return math.sqrt(min(fit.cost for fit in (base, *search.fits.values())))


def _quiet(material: str, plan: str, fields: Values) -> Response:
    """Runs that are read without noise, nothing being off but these fields."""
    runs = tuple(drawn(material, NOWHERE, fields, 1, **QUIET))
    return Response(stated(material, on_k=1.0, on_c=1.0), runs, ("k", "c"), PLANS[plan][1])


def sized(name: str, material: str, plan: str, d: float, seed: int) -> tuple[Values, float]:
    """Fields of an effect that move the data by d, and the distance that was reached."""
    plant, amount, reached = EVERY[name], EVERY[name].amount, 0.0
    for _ in range(8):
        fields = plant.fields(amount, material, np.random.default_rng(seed))
        reached = distance(material, plan, fields)
        if abs(reached / d - 1) < 0.08:
            break
        amount *= min(max(d / max(reached, 1e-6), 0.02), 20.0)
    return fields, reached


def diagnosed(material: str, plan: str, fields: Values, seed: int):
    """Diagnosis of a campaign drawn with this seed."""
    scatter, priors = PLANS[plan]
    runs = drawn(material, scatter, fields, seed)
    settings = Settings(sample=material, workers=1)
    return response(stated(material), runs, rng=np.random.default_rng(seed), priors=priors, settings=settings)
