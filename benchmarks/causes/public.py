"""Public records as cases, made from files that the user has: none of them is shipped, none is fetched.

What is known of each stands in `RECORDS`, with source, commit and licence. The right answers are what several fits of
these records agree on; nobody planted anything.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .names import NAMES
from .plan import FORMAT, dump


@dataclass(frozen=True)
class Public:
    """A record: where it comes from, how it becomes a campaign, and what is right to say of it."""

    source: str
    files: str
    method: str
    make: Callable[[list[Path]], dict[str, str]]
    causes: tuple[str, ...]
    group: tuple[tuple[str, ...], ...]
    must_not: tuple[str, ...]
    verdict: tuple[str, ...]


def columns(file: Path) -> dict[str, np.ndarray]:
    """Columns of numbers by heading; what is no number is NaN."""
    with file.open(encoding="utf-8-sig", newline="") as lines:
        head, *rows = csv.reader(lines)
    return {
        name.strip(): np.array([_number(row[i]) if i < len(row) else np.nan for row in rows])
        for i, name in enumerate(head)
    }


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


def _decay(
    name: str, heading: str, stated: dict[str, str], t: np.ndarray, y: np.ndarray, resolution: str | None = None
) -> dict[str, str]:
    rows = "\n".join(f"{a:.9g},{b:.9g}" for a, b in zip(t, y, strict=True) if np.isfinite(a) and np.isfinite(b))
    test = {
        "method": "decay",
        "sample": name,
        "instruments": {"displacement": "sensor"},
        **stated,
        "readings": ["record.csv"],
    }
    sensor = {"kind": "as published", **({"resolution": resolution} if resolution else {})}
    campaign = _campaign(name, {"sensor": sensor}, {name: {"material": "as published"}}, {"decay": test})
    return {"campaign.yaml": dump(campaign), "record.csv": f"time / s,{heading}\n{rows}\n"}


def _campaign(name: str, instruments: dict[str, Any], samples: dict[str, Any], tests: dict[str, Any]) -> dict[str, Any]:
    return {"format": "metrology-campaign/1", "id": name, "title": f"Public record: {name}", "instruments": instruments,
            "samples": samples, "tests": tests}  # fmt: skip


def torsion(files: list[Path]) -> dict[str, str]:
    """Angle / rad against time / s. The moment of inertia is not published: k and c are for each kg·m²."""
    read = columns(files[0])
    return _decay("torsion-pendulum", "angle / rad", {"inertia": "1 kg*m^2"}, read["time / s"], read["angle / rad"])


def spring_disk(files: list[Path]) -> dict[str, str]:
    """Displacement / mm against time / s."""
    read = columns(files[0])
    x = read["displacement / mm"]
    return _decay(
        "spring-disk", "displacement / um", {"mass": "0.2016 kg"}, read["time / s"], 1e3 * (x - np.nanmean(x)), "0.1 mm"
    )


def pendulum(files: list[Path]) -> dict[str, str]:
    """Angle from hanging / rad; every fifth reading of 1 kHz is ample for a swing of some 1.3 Hz."""
    read = columns(files[0])
    t, angle = read["t_s"][::5], read["theta_rad"][::5] - np.pi
    # m·a² + I of the authors' model / (kg·m²).
    inertia = 0.147584572 * 0.147754901**2 + 1.09118505e-4
    return _decay("single-pendulum", "angle / rad", {"inertia": f"{inertia:.6g} kg*m^2"}, t, angle)


def steel(files: list[Path]) -> dict[str, str]:
    """Crosshead against load of several specimens, each a repeat; the extensometer gives the reference stiffness."""
    return _machine(
        "steel-1045", files, ("Extension (mm)", "Load (kN)", "Strain (mm/mm)"), (1e-3, 1e3), (2e3, 10e3), 25.4e-3
    )


def composite(files: list[Path]) -> dict[str, str]:
    """Crosshead against load of several specimens, each a repeat; their length is not published, hence no reference."""
    return _machine(
        "composite", files, ("Machine_Displacement", "Machine_Load", "eyy--1"), (1e-3, 1.0), (100.0, 600.0), None
    )


def _machine(
    name: str,
    files: list[Path],
    heads: tuple[str, str, str],
    scale: tuple[float, float],
    limits: tuple[float, float],
    length: float | None,
) -> dict[str, str]:
    loads = np.linspace(*limits, 8)
    rows, stiffness = ["load,repeat,direction,reading / mm"], []
    for i, file in enumerate(files):
        read = columns(file)
        use = np.isfinite(read[heads[0]]) & np.isfinite(read[heads[1]]) & np.isfinite(read[heads[2]])
        x, F, strain = read[heads[0]][use] * scale[0], read[heads[1]][use] * scale[1], read[heads[2]][use]
        if not (limits[1] < F).any():
            raise ValueError(f"{file}: the load ends at {F.max():.4g} N, and {limits[1]:g} N is needed: leave it out")
        first = slice(0, int(np.argmax(limits[1] < F)) + 1)
        order = np.argsort(F[first], kind="stable")
        rows += [
            f"L{j + 1},{i + 1},loading,{1e3 * np.interp(load, F[first][order], x[first][order]):.5f}"
            for j, load in enumerate(loads)
        ]
        inside = (F[first] > limits[0]) & (F[first] < limits[1])
        stiffness.append(1 / (abs(np.polyfit(F[first][inside], strain[first][inside], 1)[0]) * (length or 1.0)))
    instruments = {
        "crosshead": {"kind": "crosshead of the testing machine", "resolution": "1 um"},
        "cell": {"kind": "load cell"},
    }
    spread = float(np.std(stiffness)) if len(stiffness) > 1 else 0.02 * stiffness[0]
    value = f"{np.mean(stiffness):.6g} ± {spread:.2g} N/m"
    samples: dict[str, dict[str, Any]] = {name: {"material": "as published"}}
    if length:
        samples[name] |= {"references": {"k": {"value": value, "source": "strain of the specimen"}}}
    test = {"method": "elongation", "sample": name, "instruments": {"extension": "crosshead", "load": "cell"},
            "loads": {f"L{j + 1}": {"force": f"{load:.1f} N"} for j, load in enumerate(loads)},
            "readings": "readings.csv"}  # fmt: skip
    return {
        "campaign.yaml": dump(_campaign(name, instruments, samples, {"elongation": test})),
        "readings.csv": "\n".join(rows) + "\n",
    }


SOFTER = ("cubic", "pendulum")
FASTER = ("quadratic drag", "damping", "line damping")
OPEN = ("explained", "ambiguous", "unexplained", "not testable")
NAMED = ("explained", "explained in the main", "ambiguous")
RECORDS = {
    "torsion-pendulum": Public(
        "GuenterQuast/PhyPraKit @ d9b1d59e2ad9, examples/Drehpendel.labx, first 75 s, "
        "as CSV `time / s,angle / rad`; GPL-3.0",
        "one", "decay", torsion, ("friction", "cubic"), (SOFTER,), ("setup",), NAMED,
    ),
    "spring-disk-1": Public(
        "filo0509/smorzamento @ d2a1b2f4e8ba, data_raw/molla_durissima_discopieno_14.91945_0.2016_1.csv, as CSV "
        "`time / s,displacement / mm`; MIT",
        "one", "decay", spring_disk, ("quadratic drag", "cubic"), (FASTER, SOFTER), ("setup",), NAMED,
    ),
    "spring-disk-4": Public(
        "the same repository, …_4.csv: nothing is missing but a second oscillation at 1.01 Hz, which may be named",
        "one", "decay", spring_disk, (), (), ("friction", *FASTER, *SOFTER), ("nothing missing", *NAMED),
    ),
    "single-pendulum": Public(
        "dynamicslab/MultiArm-Pendulum @ e99a7e13fe2a, SinglePendulumDataForParameterEstimation.mat, "
        "as CSV with the columns `t_s` and `theta_rad`; MIT; Kaheman et al., arXiv 2205.06231",
        "one", "decay", pendulum, ("pendulum",), (SOFTER,), ("setup", "even stiffness"), NAMED,
    ),
    "steel-1045": Public(
        "DuncanWilliamGibbons/tensile-analyzer @ a5c59ddcb956, Test Data/Steel_1045_Normalized_{1,2,3}.csv; MIT",
        "all specimens", "elongation", steel, ("mounting",), (), ("curvature", "load", "misread"), OPEN,
    ),
    "composite": Public(
        "EPFL-ENAC/CCFatiguePlatform @ b342dc81905b, Data/raw/TST_Liu_2021-12_QS; specimens at one temperature; MIT",
        "all specimens", "elongation", composite, ("mounting",), (), ("load", "misread"), NAMED,
    ),
}  # fmt: skip


def convert(record: str, files: list[Path], place: Path) -> Path:
    """Write the case of a public record below a folder, and return its own."""
    one, folder = RECORDS[record], place / record
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in {**one.make(files), "expected.yaml": _expected(record, one)}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def _expected(record: str, one: Public) -> str:
    kind = {0: "public", 1: "one", 2: "pair"}[len(one.causes)]
    right = set(one.causes).union(*one.group)
    wrong = [name for name in one.must_not if name in NAMES[one.method] and name not in right]
    return dump({
        "format": FORMAT, "case": record, "method": one.method, "kind": kind, "causes": list(one.causes),
        "group": [list(group) for group in one.group], "size": {}, "distance": {}, "unlisted": None,
        "remainder": {"share": 0.0},
        "k": None, "c": None, "must_not": wrong,
        "verdict": list(one.verdict), "noise": "as measured", "traits": [], "seed": 0, "source": one.source,
    })  # fmt: skip
