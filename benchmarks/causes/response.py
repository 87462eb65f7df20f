"""Cases of response tests: what is planted, what the laboratory states, and the readings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .alike import groups
from .noise import Sensor
from .plan import Case, Plan, Truth, answer, dump, laboratory, places, table
from .rig import Rig
from .sizing import size_for
from .tether import (
    BEGIN,
    DIGIT,
    END,
    GAP,
    KNOWN,
    PARAMETERS,
    RUNS,
    SIGMA,
    SPECIMENS,
    TAUT,
    UNLISTED,
    Own,
    Refit,
    Rest,
    first_size,
    grid,
    plant,
    shapes,
    truth_of,
)

__all__ = ["SPECIMENS", "UNLISTED", "make"]


def make(plan: Plan) -> Case:
    """Files of a case."""
    rng = plan.rng()
    base, sensors = setting(plan, rng)
    rest, sizes = planted(plan, base, sensors, rng)
    rest = replace(rest, rig=replace(rest.rig))
    errors = {name: float(rng.standard_normal() * u) for name, (u, _) in KNOWN.items() if u}
    if "wrong input" in plan.traits:
        name = str(rng.choice(list(errors)))
        errors[name] = float(rng.choice([-1, 1]) * rng.uniform(1.8, 2.5) * KNOWN[name][0])
    for name, error in errors.items():
        rest = replace(rest, sizes={**rest.sizes, name: rest.size(name) + error})
    files = readings(plan, rest, sensors, rng)
    rig = rest.rig
    found = {cause: (*PARAMETERS[cause][:1], sizes[cause], PARAMETERS[cause][1]) for cause in plan.causes}
    distances = dict(zip(plan.causes, plan.distances, strict=True))
    alike = groups("response", plan.specimen, sizes, distances)
    truth = Truth(found, distances, alike, (rig.k, "N/m"), (rig.c, "N*s/m"))
    files["campaign.yaml"] = dump(campaign(plan, sensors, rng))
    files["expected.yaml"] = answer(plan, truth)
    return Case(files)


def setting(plan: Plan, rng: np.random.Generator) -> tuple[Rest, dict[str, Sensor]]:
    """Rig and instruments, nothing planted."""
    m, ks, cs = SPECIMENS[plan.specimen]
    rig = Rig(m, float(rng.uniform(*ks)), float(rng.uniform(*cs)), -GAP)
    sensors = {
        channel: Sensor(plan.noise, SIGMA[channel] * (0.5 if plan.noise == "bare" else 1.0), DIGIT[channel],
                        spikes=int("spikes" in plan.traits) * 3 if channel != "v" else 0,
                        gaps=int("gaps" in plan.traits) * 2 if channel != "T" else 0)
        for channel in SIGMA
    }  # fmt: skip
    return Rest(rig, shape=shapes(rig, rng)), sensors


def planted(
    plan: Plan, base: Rest, sensors: dict[str, Sensor], rng: np.random.Generator
) -> tuple[Rest, dict[str, float]]:
    """The campaign with all that the plan plants, each at its distance, and the sizes."""
    wanted = dict(zip(plan.causes, plan.distances, strict=True))
    if plan.unlisted:
        wanted[plan.unlisted] = plan.unlisted_distance()
    rest, sizes = base, {}
    refit = Refit(base, sensors) if wanted else None
    for name, d in wanted.items():
        sign = float(rng.choice([-1, 1])) if name in SIGNED else 1.0

        def measure(size: float, name: str = name, sign: float = sign) -> float:
            return refit.distance(plant(base, name, sign * size)) if refit else 0.0

        sizes[name] = sign * size_for(d, first_size(name, base.rig), measure)
        rest = plant(rest, name, sizes[name])
    return rest, sizes


SIGNED = ("cubic", "tilt", "thrust gain", "mass", "cell gain", "cell zero", "cell drift", "gain drift",
          "clock x", "clock v", "clock T", "motion scale")  # fmt: skip


def readings(plan: Plan, rest: Rest, sensors: dict[str, Sensor], rng: np.random.Generator) -> dict[str, str]:
    """CSV files of all runs."""
    files = {}
    for run in RUNS:
        t, s = grid()
        if "irregular" in plan.traits:
            t, s = (np.round(_jittered(one, rng), 5) for one in (t, s))
        own = Own(
            thrust=rng.standard_normal() * KNOWN["thrust gain"][1], zero=rng.standard_normal() * KNOWN["cell zero"][1],
            start=rng.standard_normal() * KNOWN["start"][1], phase=rng.uniform(0, 2 * np.pi),
            slip=1 + 0.1 * rng.standard_normal(), hop=rng.uniform(4, 8),
        )  # fmt: skip
        true = truth_of(run, rest, own, (t, s))
        read = {channel: sensors[channel].read(true[channel], rng) for channel in ("x", "v", "T")}
        digits = {channel: places(sensors[channel].step) for channel in read}
        stamp = 5 if "irregular" in plan.traits else 3
        files[f"{run}-motion.csv"] = table(
            "time / s,x / m,v / m/s", (t, read["x"], read["v"]), (stamp, digits["x"], digits["v"])
        )
        files[f"{run}-cell.csv"] = table("time / s,T / N", (s, read["T"]), (stamp, digits["T"]))
    return files


def _jittered(stamps: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    step = stamps[1] - stamps[0]
    found = stamps + rng.uniform(-0.3, 0.3, len(stamps)) * step
    found[0] = 0.0
    return found


def campaign(plan: Plan, sensors: dict[str, Sensor], rng: np.random.Generator) -> dict[str, Any]:
    """What the laboratory states."""
    m, ks, _ = SPECIMENS[plan.specimen]
    test: dict[str, Any] = {
        "method": "response",
        "sample": plan.specimen,
        "instruments": {"position": "mocap", "velocity": "mocap", "tension": "load-cell", "thrust": "thrusters"},
        "rig": {"mass": f"{m:.2f} kg", "taut": f"{TAUT:.3f} m", "line_weight": "none"},
        "known": {
            "mass": {"common": f"{1e3 * m * KNOWN['mass'][0]:.0f} g", "source": "balance"},
            "free_length": {"common": "0.5 mm", "source": "steel tape"},
            "thrust_gain": {"common": "0.5 %", "per_run": "0.2 %", "source": "calibration of the thrusters"},
            "cell_gain": {"common": "0.3 %", "source": "certificate"},
            "cell_zero": {"per_run": "3 mN", "source": "readings before the runs"},
            "clock": {"common": "1 ms", "source": "trigger"},
            "start_position": {"per_run": "0.2 mm", "source": "repeated placing"},
        },
        "identification": {"free": ["k", "c"], "start": {"k": f"{0.8 * sum(ks) / 2:.0f} N/m"}},
    }
    if "wrong noise" in plan.traits or rng.uniform() < 0.5:
        factor = float(2 ** rng.uniform(-1, 1)) if "wrong noise" in plan.traits else 1.0
        units = {"x": "m", "v": "m/s", "T": "N"}
        test["noise"] = {channel: f"{factor * one.u:.3g} {units[channel]}" for channel, one in sensors.items()}
    test["runs"] = {}
    for run, (force, until, purpose) in RUNS.items():
        pulse = {"from": f"{BEGIN:.1f} s", "force": f"{force:.2f} N"}
        test["runs"][run] = {
            "purpose": purpose,
            "readings": [f"{run}-motion.csv", f"{run}-cell.csv"],
            "thrust": [pulse if until >= END else {**pulse, "to": f"{until:.1f} s"}],
            "held_until": f"{BEGIN:.1f} s",
            "start": {"position": f"{TAUT - GAP:.3f} m"},
        }
    found = laboratory(plan, f"Response of a {plan.specimen} line")
    found["instruments"] = {
        "mocap": {"kind": "motion capture", "resolution": f"{1e3 * sensors['x'].step:.3g} mm"},
        "load-cell": {
            "kind": "load cell",
            "range": ["-5 N", "50 N"],
            "resolution": f"{1e3 * sensors['T'].step:.3g} mN",
        },
        "thrusters": {"kind": "two cold-gas thrusters"},
    }
    found["samples"] = {
        plan.specimen: {"section": {"shape": "round", "diameter": "0.300(3) mm"}, "length": "1.500(1) m"}
    }
    found["tests"] = {"response": test}
    return found
