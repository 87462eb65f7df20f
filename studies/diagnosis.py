"""How well diagnosis names what was planted: campaigns drawn by an independent generator, judged one by one.

``python studies/diagnosis.py [--each N] [--nothing N] [--out docs/studies/diagnosis.md]`` writes a table: verdicts by
planted effect and size, false alarms, cover of intervals, held-out residuals and the bias of k and c that is removed.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from response_cases import HELD_OUT, MATERIALS, PRIORS, SCATTER, SHORT, measured, stated, truth_of
from truth_response import Instruments, campaign

from metrology import __version__
from metrology.diagnose import Settings, response

TESTS = (*SHORT, *HELD_OUT)
PLANTED = {
    "friction": ("truth", "friction", "friction.force"),
    "drag": ("truth", "viscous", "drag.viscous"),
    "quadratic drag": ("truth", "quadratic", "drag.quadratic"),
    "tilt": ("truth", "tilt", "tilt.angle"),
    "cubic": ("truth", "cubic", "cubic.stiffness"),
    "damping": ("truth", "amplitude", "damping.amplitude"),
    "cell zero": ("instruments", "zero", "cell.zero"),
    "cell drift": ("instruments", "drift", "cell.drift"),
    "hum T": ("instruments", "hum", "hum.T"),
    "clock T": ("instruments", "clock", "clock.T"),
}
"""Effect → where the generator carries it, under which name, and the parameter of the candidate."""
UNKNOWN = {"magnet": 12.0, "ripple": 12.0}
"""In nobody's table: force over the smallest friction that shows."""


@lru_cache(maxsize=8)
def smallest(material: str) -> dict[str, float]:
    """Size of every effect at a distance of one standard deviation, from runs with nothing planted."""
    found = diagnosed(material, 10_000, {})
    return {one.effect: one.size / 5.0 for one in found.detectable if one.size}


def runs(material: str, seed: int, planted: dict[str, float]):
    """Measured runs with effects of these sizes."""
    truth, instruments = truth_of(material), Instruments()
    for name, size in planted.items():
        where, field, _ = PLANTED.get(name, ("truth", name, ""))
        if where == "truth":
            truth = replace(truth, **{field: size})
        elif field == "clock":
            instruments = replace(instruments, offset=(0.0, 0.0, size))
        else:
            instruments = replace(instruments, **{field: size})
    records = campaign(truth, TESTS, instruments, SCATTER, np.random.default_rng(seed))
    return [measured(record) for record in records]


def diagnosed(material: str, seed: int, planted: dict[str, float]):
    """Diagnosis of a campaign drawn with this seed."""
    settings = Settings(sample=material, workers=1)
    return response(
        stated(material),
        runs(material, seed, planted),
        rng=np.random.default_rng(seed),
        priors=PRIORS,
        settings=settings,
    )


def case(task: tuple[str, str, tuple[str, ...], float, int]) -> dict:
    """One campaign: what was planted, what was named, and the figures of the bars."""
    kind, material, effects, d, seed = task
    unit = smallest(material)
    if kind == "unknown":
        planted = {effects[0]: d / 6 * UNKNOWN[effects[0]] * unit["friction"] * 5}
    else:
        planted = {name: d * unit[name] for name in effects}
    begun = time.perf_counter()
    found = diagnosed(material, seed, planted)
    k, c = MATERIALS[material]
    truths = {PLANTED[name][2]: size for name, size in planted.items() if name in PLANTED}
    values = [one for cause in found.causes if cause.verdict == "supported" for one in cause.parameters]
    covered = [abs(one.value - truths[one.name]) < 1.96 * one.u for one in values if one.name in truths]
    kept = [abs(one.after - {"k": k, "c": c}[one.name]) < 1.96 * one.u_after for one in found.shifts]
    bias = [
        abs(one.after - {"k": k, "c": c}[one.name]) / max(abs(one.before - {"k": k, "c": c}[one.name]), 1e-300)
        for one in found.shifts
    ]
    return {
        "kind": kind, "material": material, "planted": list(effects), "d": d, "verdict": found.verdict,
        "named": list(found.named), "possible": list(found.possible), "groups": [list(group) for group in found.groups],
        "covered": covered, "kept": kept, "bias": bias, "seconds": time.perf_counter() - begun,
        "probability": [(cause.effect, cause.probability) for cause in found.causes if cause.effect in found.possible],
        "held": [one.after for one in found.gain.values()],
    }  # fmt: skip


def tasks(each: int, nothing: int):
    """Campaigns of the study."""
    names, materials = list(PLANTED), list(MATERIALS)
    for at in range(nothing):
        yield "nothing", materials[at % 4], (), 0.0, 20_000 + at
    for row, name in enumerate(names):
        for at in range(each):
            for d in (5.0, 8.0, 40.0):
                yield "one", materials[(at + row) % 4], (name,), d, 30_000 + 100 * row + at
    for at in range(2 * each):
        pair = (names[at % len(names)], names[(at * 3 + 1 + at // len(names)) % len(names)])
        if len(set(pair)) == 2:
            yield "two", materials[at % 4], pair, 15.0, 50_000 + at
    for at in range(2 * each):
        yield "unknown", materials[at % 4], (list(UNKNOWN)[at % 2],), 12.0, 60_000 + at


def share(rows: list[dict], right) -> str:
    """How many of the rows are right, in words."""
    count = sum(bool(right(row)) for row in rows)
    return f"{count} of {len(rows)} ({100 * count / max(len(rows), 1):.0f} %)"


def first(row: dict) -> bool:
    """Whether the planted effect, or its group, is named first."""
    return bool(row["possible"]) and (
        row["possible"][0] == row["planted"][0]
        or any(row["planted"][0] in group and row["possible"][0] in group for group in row["groups"])
    )


def table(rows: list[dict]) -> str:
    """The bars as a table, then the confusion matrix."""
    by = {kind: [row for row in rows if row["kind"] == kind] for kind in ("nothing", "one", "two", "unknown")}
    large, medium, small = ([row for row in by["one"] if row["d"] == d] for d in (40.0, 8.0, 5.0))
    both = [row for row in by["one"] if row["d"] >= 6]
    named = [row for row in rows if row["named"]]
    covered = [one for row in named for one in row["covered"]]
    kept = [one for row in by["one"] if row["named"] == row["planted"] for one in row["kept"]]
    held = [one for row in by["one"] if row["named"] == row["planted"] for one in row["held"]]
    bias = [one for row in large if row["named"] == row["planted"] for one in row["bias"]]
    sure = [(name in row["planted"]) for row in rows for name, p in row["probability"] if p > 0.9]
    lines = [
        ("nothing planted: nothing missing", share(by["nothing"], lambda row: row["verdict"] == "nothing missing")),
        ("one effect, d = 8: named first, or its group", share(medium, first)),
        ("one effect, d = 40: named first, or its group", share(large, first)),
        ("d ≥ 6: among those reported as possible", share(both, lambda row: row["planted"][0] in row["possible"])),
        ("d ≥ 6: reported as possible, on average", f"{np.mean([len(row['possible']) for row in both] or [0]):.2f}"),
        ("d = 5: named or missed, not misnamed", share(small, lambda row: not row["possible"] or first(row))),
        ("two effects (d = 15): both named", share(by["two"], lambda row: set(row["planted"]) <= set(row["possible"]))),
        ("two effects: exactly these", share(by["two"], lambda row: set(row["planted"]) == set(row["possible"]))),
        ("two effects: at least one", share(by["two"], lambda row: set(row["planted"]) & set(row["possible"]))),
        ("unknown effect: unexplained, none named", share(by["unknown"], lambda row: row["verdict"] == "unexplained")),
        ("95 % intervals of sizes cover", f"{sum(covered)} of {len(covered)}"),
        ("95 % intervals of k, c cover after extension", f"{sum(kept)} of {len(kept)}"),
        ("held-out residual over noise, largest 5 %", f"{np.quantile(held or [0], 0.95):.3f}"),
        ("bias of k, c after over before (d = 40), median", f"{np.median(bias or [0]):.3f}"),
        ("causes given more than 90 %: right", f"{sum(sure)} of {len(sure)}"),
        ("seconds a campaign, median and largest",
         f"{np.median([row['seconds'] for row in rows]):.1f}, {max(row['seconds'] for row in rows):.1f}"),
    ]  # fmt: skip
    text = [
        "| bar | found |",
        "|---|---|",
        *(f"| {name} | {value} |" for name, value in lines),
        "",
        "Verdicts by what was planted:",
        "",
    ]
    text += ["| planted | d | first cause |", "|---|---|---|"]
    for key in dict.fromkeys((tuple(row["planted"]), row["d"]) for row in rows):
        own = Counter(
            ", ".join(row["possible"]) or row["verdict"] for row in rows if (tuple(row["planted"]), row["d"]) == key
        )
        words = "; ".join(f"{name}: {count}" for name, count in own.most_common())
        text.append(f"| {' + '.join(key[0]) or 'nothing'} | {key[1]:g} | {words} |")
    return "\n".join(text) + "\n"


def main() -> None:
    """Run the study and write its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=10)
    parser.add_argument("--nothing", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("docs/studies/diagnosis.md"))
    parser.add_argument("--rows", type=Path)
    given = parser.parse_args()
    rows = []
    with ProcessPoolExecutor(given.workers) as pool:
        for row in pool.map(case, tasks(given.each, given.nothing)):
            rows.append(row)
            if given.rows:
                # Kept row by row, so that a study that is stopped can still be read.
                with given.rows.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
    made = f"Version {__version__}, {datetime.now(UTC):%Y-%m-%d}, {len(rows)} campaigns of {len(TESTS)} runs."
    text = f"# What diagnosis names\n\n{made}\n\n{table(rows)}"
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
