"""Campaigns of a careful laboratory, with readings of the independent generators and known true k and c, as files.

Shares no code with `metrology`. A `Work` is a campaign file as values with its tables of readings; `write` puts it into
a folder. What a laboratory knows twice is in it: the modulus by a handbook, the stiffness by dead loads beside that by
oscillation, density and section; `bare` leaves that out. Two requirements go with every campaign, k at least half and
at most twice the true one: a number that nothing holds back passes one of them, whatever it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import truth_decay
import truth_elongation
import truth_relaxation
import truth_response
import truth_tension
import yaml

Column = list[Any]
WIDTH = 25e-3
DENSITY = {"al-1100": 2710.0, "peek": 1300.0, "nylon": 1140.0, "spectra": 970.0}
MODULUS = {"al-1100": 69e9, "peek": 4.0e9, "nylon": 2.5e9, "spectra": 90e9}
"""kg/m³ and Pa, about; the section follows from the true k and the modulus."""


@dataclass(frozen=True)
class Work:
    """A campaign as values, its tables by file (columns by heading), what is true, and the files that are corrupted."""

    method: str
    campaign: dict[str, Any]
    tables: dict[str, dict[str, Column]]
    truth: dict[str, float]
    raw: tuple[str, ...]

    @property
    def weighed(self) -> bool:
        """Whether a mass enters its result."""
        return self.method in ("elongation", "decay", "response")

    def write(self, folder: Path) -> Path:
        """Write campaign and readings into a folder; the path of the campaign file."""
        for name, table in self.tables.items():
            rows = zip(*table.values(), strict=True)
            text = "\n".join([",".join(table), *(",".join(map(_cell, row)) for row in rows), ""])
            (folder / name).write_text(text)
        path = folder / "campaign.yaml"
        path.write_text(yaml.safe_dump(self.campaign, sort_keys=False, allow_unicode=True))
        return path


def _cell(value: Any) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _base(k: float, quantity: str) -> dict[str, Any]:
    limits = {"R1": {"lower": f"{k / 2:.6g} N/m"}, "R2": {"upper": f"{2 * k:.6g} N/m"}}
    return {
        "format": "metrology-campaign/1",
        "id": "S-1",
        "title": "A campaign",
        "requirements": [
            {
                "id": name, "text": "stiffness", "quantity": quantity, "limits": each,
                "decision": {"rule": "simple acceptance"},
            }
            for name, each in limits.items()
        ],
    }  # fmt: skip


def _sample(material: str, k: float, length: float, rng: np.random.Generator, *, bare: bool) -> dict[str, Any]:
    if bare:
        return {"length": f"{length:.4f} ± 0.001 m"}
    area = k * length / MODULUS[material]
    handbook = MODULUS[material] * (1 + 0.05 * rng.standard_normal())
    return {
        "material": material,
        "length": f"{length:.4f} ± 0.001 m",
        "section": {
            "shape": "tape", "width": f"{1e3 * WIDTH:.2f} ± 0.02 mm",
            "thickness": f"{1e3 * area / WIDTH:.6g} ± {1e3 * area / WIDTH * 0.01:.2g} mm",
        },
        "density": f"{DENSITY[material]:g} kg/m^3",
        "linear_density": f"{1e3 * DENSITY[material] * area:.5g} g/m",
        "references": {"E": {"value": f"{handbook / 1e9:.4g} ± {0.05 * handbook / 1e9:.2g} GPa", "source": "handbook"}},
    }  # fmt: skip


def _indicator(one: truth_elongation.Stretched) -> dict[str, Any]:
    return {
        "kind": "indicator",
        "resolution": f"{1e6 * one.division:g} um",
        "certificate": {
            "number": "C-1", "laboratory": "L", "date": "2026-01-01", "due": "2027-01-01",
            "expanded_uncertainty": f"{2e6 * one.indicator:g} um",
        },
    }  # fmt: skip


def _pulled(one: truth_elongation.Stretched, rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Column]]:
    """An elongation test as the campaign file states it, and its table."""
    rows = truth_elongation.readings(one, rng)
    test = {
        "method": "elongation", "sample": "tape", "date": "2026-05-05", "instruments": {"extension": "indicator"},
        "gravity": f"{truth_elongation.GRAVITY} m/s^2", "air_density": "1e-6 kg/m^3",
        "loads": {f"m{at}": {"mass": f"{mass} ± {one.mass_u} kg"} for at, mass in enumerate(one.masses)},
        "readings": "elongation.csv",
    }  # fmt: skip
    load, repeat, way, x = (list(column) for column in zip(*rows, strict=True))
    return test, {"load": load, "repeat": repeat, "direction": way, "reading / mm": [1e3 * value for value in x]}


def elongation(rng: np.random.Generator, *, bare: bool = False) -> Work:
    """Dead loads on a tape; the modulus of its material is known from a handbook."""
    material = str(rng.choice(list(truth_elongation.MATERIALS)))
    one = truth_elongation.MATERIALS[material]
    one = replace(one, k=one.k * float(rng.uniform(0.8, 1.25)))
    test, table = _pulled(one, rng)
    campaign = {
        **_base(one.k, "pull.k"),
        "instruments": {"indicator": _indicator(one)},
        "samples": {"tape": _sample(material, one.k, 3.0, rng, bare=bare)},
        "tests": {"pull": test},
    }
    return Work("elongation", campaign, {"elongation.csv": table}, {"pull.k": one.k}, ("elongation.csv",))


def decay(rng: np.random.Generator, *, bare: bool = False) -> Work:
    """Releases of a plate on a tape, whose stiffness is known by dead loads too."""
    material = str(rng.choice(list(truth_decay.MATERIALS)))
    plate = truth_decay.MATERIALS[material]
    k = plate.k * float(rng.uniform(0.8, 1.25))
    plate = replace(plate, k=k, duration=min(plate.duration, 4.0))
    records = truth_decay.releases(plate, truth_decay.Vibrometer(), 3, rng)
    names = tuple(f"release-{at + 1}.csv" for at in range(3))
    tables: dict[str, dict[str, Column]] = {
        name: {"time / s": t.tolist(), "displacement / um": (1e6 * x).tolist()}
        for name, (t, x) in zip(names, records, strict=True)
    }
    tests: dict[str, Any] = {
        "swing": {
            "method": "decay", "sample": "tape", "date": "2026-05-06", "instruments": {"displacement": "vibrometer"},
            "mass": f"{plate.m} ± {1e-4 * plate.m:.2g} kg", "readings": list(names),
        }
    }  # fmt: skip
    instruments: dict[str, Any] = {"vibrometer": {"kind": "laser vibrometer", "resolution": "0.1 um"}}
    if not bare:
        one = replace(truth_elongation.MATERIALS[material], k=k)
        tests["pull"], tables["elongation.csv"] = _pulled(one, rng)
        tests["swing"]["stiffness"] = "pull"
        instruments["indicator"] = _indicator(one)
    campaign = {
        **_base(k, "swing.k"),
        "instruments": instruments,
        "samples": {"tape": _sample(material, k, 3.0, rng, bare=bare)},
        "tests": tests,
    }
    return Work("decay", campaign, tables, {"swing.k": k, "swing.c": plate.c}, names)


RUNS = (
    truth_response.Test("step", ((1.0, 0.62),), 12.0, x0=0.05),
    truth_response.Test("impulse", ((1.0, 0.62), (4.0, 0.0)), 9.0, x0=0.05),
    truth_response.Test("weak-step", ((1.0, 0.5),), 12.0, x0=0.05),
)
SCATTER = truth_response.Scatter(
    mass=0.001, thrust=0.005, thrust_run=0.002, length=5e-4, start_run=2e-4, gain=0.003, zero_run=3e-3
)
KNOWN = {
    "mass": {"common": "0.1 %"}, "free_length": {"common": "0.5 mm"},
    "thrust_gain": {"common": "0.5 %", "per_run": "0.2 %"},
    "cell_gain": {"common": "0.3 %"}, "cell_zero": {"per_run": "3 mN"}, "start_position": {"per_run": "0.2 mm"},
}  # fmt: skip
LINES = {"nylon": (167.64, 8.0), "spectra": (753.33, 35.0)}


def response(rng: np.random.Generator, *, bare: bool = False) -> Work:
    """A module on a line: two runs that are fitted, one that verifies; the modulus is known from a handbook."""
    material = str(rng.choice(list(LINES)))
    k, c = (value * float(rng.uniform(0.8, 1.25)) for value in LINES[material])
    truth = truth_response.Truth(m=25.0, k=k, c=c, taut=0.1)
    records = truth_response.campaign(truth, RUNS, truth_response.Instruments(), SCATTER, rng)
    tables: dict[str, dict[str, Column]] = {}
    runs: dict[str, Any] = {}
    for at, one in enumerate(records):
        motion, cell = f"{one.test.name}-motion.csv", f"{one.test.name}-cell.csv"
        x, v = one.readings["x"].tolist(), one.readings["v"].tolist()
        tables[motion] = {"time / s": one.t["x"].tolist(), "x / m": x, "v / m/s": v}
        tables[cell] = {"time / s": one.t["T"].tolist(), "T / N": one.readings["T"].tolist()}
        thrust = [{"from": f"{t:g} s", "force": f"{f:g} N"} for t, f in one.test.thrust if f]
        for part, (t, f) in zip(thrust, one.test.thrust[1:], strict=False):
            assert f == 0
            part["to"] = f"{t:g} s"
        runs[one.test.name] = {
            "purpose": "verification" if at == 2 else "identification", "readings": [motion, cell], "thrust": thrust,
            "start": {"position": f"{one.test.x0:g} m"},
        }  # fmt: skip
    sought = {"free": ["k", "c"], "start": {"k": f"{1.2 * k:.3g} N/m", "c": f"{0.8 * c:.3g} N*s/m"}}
    campaign = {
        **_base(k, "ride.k"),
        "instruments": {"camera": {"kind": "motion capture"}, "cell": {"kind": "load cell"}},
        "samples": {"tape": _sample(material, k, 1.5, rng, bare=bare)},
        "tests": {
            "ride": {
                "method": "response", "sample": "tape", "date": "2026-05-07",
                "instruments": {"position": "camera", "velocity": "camera", "tension": "cell"},
                "rig": {"mass": "25.00 kg", "taut": "0.1 m"}, "known": KNOWN,
                "identification": sought, "runs": runs,
            }
        },
    }  # fmt: skip
    return Work("response", campaign, tables, {"ride.k": k, "ride.c": c}, tuple(tables))


MACHINE = {
    "cell": {"kind": "load cell", "class": "0.5", "resolution": "0.1 mN"},
    "machine": {"kind": "testing machine", "class": "0.5", "resolution": "0.01 um"},
    "clip": {"kind": "extensometer", "class": "0.5", "resolution": "0.01 um"},
}
STIFFNESSES = {"al-1100": 25e3, "peek": 4e3, "nylon": 2e3, "spectra": 20e3}
"""N/m of 0.2 m of a tape on a testing machine, about."""
CLASS = 0.005
"""Largest error of an instrument of class 0.5: what each of a day reads is off by so much at most, of its reading."""


def _of_machine(rng: np.random.Generator, *, bare: bool) -> tuple[float, dict[str, Any]]:
    """Stiffness and sample of a tape of 0.2 m."""
    material = str(rng.choice(list(STIFFNESSES)))
    k = STIFFNESSES[material] * float(rng.uniform(0.8, 1.25))
    return k, _sample(material, k, 0.2, rng, bare=bare)


def tension(rng: np.random.Generator, *, bare: bool = False) -> Work:
    """Three mountings of a tape in a testing machine, with an extensometer; the modulus by a handbook."""
    k, sample = _of_machine(rng, bare=bare)
    rigid = 0.02 / k
    most = 0.004 * k * 0.2
    one = truth_tension.Machine(
        EA=k * 0.2, length=0.2, most=most, count=600, compliance=rigid, force_noise=3e-4 * most,
        strain_noise=2e-6, crosshead_noise=1e-6,
    )  # fmt: skip
    names = tuple(f"specimen-{at + 1}.csv" for at in range(3))
    tables: dict[str, dict[str, Column]] = {}
    gain = 1 + CLASS * rng.uniform(-1, 1, 3)
    for name in names:
        found = truth_tension.pull(replace(one, compliance=rigid * float(rng.uniform(0.8, 1.25))), rng)
        tables[name] = {
            "time / s": found["time"].tolist(), "force / N": (gain[0] * found["force"]).tolist(),
            "crosshead / mm": (1e3 * gain[1] * found["crosshead"]).tolist(),
            "extension / um": (1e6 * gain[2] * one.gauge * found["strain"]).tolist(),
        }  # fmt: skip
    test = {
        "method": "tension", "sample": "tape", "date": "2026-05-08", "gauge_length": "50.0 ± 0.1 mm",
        "instruments": {"force": "cell", "crosshead": "machine", "extension": "clip"},
        "specimens": {chr(97 + at): {"readings": name} for at, name in enumerate(names)},
    }  # fmt: skip
    campaign = {**_base(k, "pull.k"), "instruments": MACHINE, "samples": {"tape": sample}, "tests": {"pull": test}}
    return Work("tension", campaign, tables, {"pull.k": k}, names)


def relaxation(rng: np.random.Generator, *, bare: bool = False) -> Work:
    """Two mountings of a tape whose elongation is held; the modulus by a handbook."""
    k, sample = _of_machine(rng, bare=bare)
    level = float(rng.uniform(0.5e-3, 2e-3))
    one = truth_relaxation.Held(
        stiff=k, parts=(0.1, 0.08), times=(3.0, 40.0), levels=(level,), holds=(300.0,), rate=10.0,
        read_noise=5e-4 * k * level,
    )  # fmt: skip
    names = tuple(f"hold-{at + 1}.csv" for at in range(2))
    tables: dict[str, dict[str, Column]] = {}
    gain = 1 + CLASS * rng.uniform(-1, 1, 2)
    for name in names:
        found = truth_relaxation.record(one, rng)
        tables[name] = {
            "time / s": found["time"].tolist(), "force / N": (gain[0] * found["force"]).tolist(),
            "crosshead / mm": (1e3 * gain[1] * found["elongation"]).tolist(),
        }  # fmt: skip
    test = {
        "method": "relaxation", "sample": "tape", "date": "2026-05-08", "setup_compliance": f"0 ± {1e3 / k:.3g} nm/N",
        "instruments": {"force": "cell", "crosshead": "machine"},
        "specimens": {chr(97 + at): {"readings": name} for at, name in enumerate(names)},
    }  # fmt: skip
    machine = {name: MACHINE[name] for name in ("cell", "machine")}
    campaign = {**_base(k, "hold.k_0"), "instruments": machine, "samples": {"tape": sample}, "tests": {"hold": test}}
    return Work("relaxation", campaign, tables, {"hold.k_0": k, "hold.k_inf": 0.82 * k}, names)


METHODS: dict[str, Callable[..., Work]] = {
    "elongation": elongation, "decay": decay, "response": response, "tension": tension, "relaxation": relaxation,
}  # fmt: skip
