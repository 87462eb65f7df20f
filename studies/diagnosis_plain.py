"""How well diagnosis names what was planted in free decays and elongation tests, drawn by independent generators.

``python studies/diagnosis_plain.py [--each N] [--nothing N] [--method elongation|decay] [--out FILE]
[--workers N | --scheduler ADDRESS]`` writes a table:
verdicts by planted effect and distance d, false alarms, cover of intervals, and the bias of k and c that is removed.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
import zlib
from collections import Counter
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import truth_decay
import truth_elongation
from plain_cases import decayed, stretched

from metrology import __version__
from metrology.batch import workers
from metrology.diagnostics import decay, elongation

TAKEN = {"transverse": ("other",), "pendulum": ("other", "drift")}
"""Names of the table that are right for a planted effect, where they are not its own: a swing slower than the record is
not told from drift."""
PARAMETER = {
    "friction": ("friction.force", 1.0), "quadratic drag": ("drag.quadratic", 1.0), "cubic": ("cubic.stiffness", 1.0),
    "damping": ("damping.amplitude", 1.0), "slip": ("slip.set", 1.0), "backlash": ("backlash.width", 1.0),
    "drift": ("drift.rate", 1.0), "misread": ("misread.error", 1.0),
}  # fmt: skip
GUESS = {
    "creep": 1e-2, "slip": 1e-5, "toe": 1e-5, "curvature": 1e-3, "backlash": 1e-5, "drift": 1e-6, "misread": 1e-5,
    "screw": 1e-5, "gain": 1e-2, "swapped": 0.1, "sway": 1e-5,
}  # fmt: skip


@lru_cache(maxsize=200)
def unit(method: str, material: str, name: str) -> float:
    """Size at a distance of one standard deviation."""
    if method == "elongation":
        one = truth_elongation.MATERIALS[material]
        size = GUESS[name]
        for _ in range(3):
            size *= 8.0 / truth_elongation.distance(name, one, size)
        return size / 8.0
    truth = truth_decay.MATERIALS[material]
    w = math.sqrt(truth.k / truth.m)
    size = {
        "friction": 1e-4 * truth.k * truth.amplitude, "quadratic drag": 2e-3 * truth.m / truth.amplitude,
        "cubic": 1e-4 * truth.k / truth.amplitude**2, "damping": 1e-4 * truth.m * w / truth.amplitude, "gain": 1e-3,
        "stop": 1e-4 * truth.k, "second": 1e-4 * truth.k,
    }.get(name, 1e-6)  # fmt: skip
    eye = truth_decay.Vibrometer()
    for _ in range(2):
        size *= 8.0 / truth_decay.distance(name, truth, eye, 5, size)
    return size / 8.0


def case(task: tuple[str, str, str, tuple[str, ...], float, int]) -> dict:
    """One test: what was planted, what was named, and the figures of the bars."""
    method, kind, material, effects, d, seed = task
    planted = {name: d * unit(method, material, name) for name in effects}
    rng, begun = np.random.default_rng(seed), time.process_time()
    if method == "elongation":
        test, k = stretched(material, seed, planted), truth_elongation.MATERIALS[material].k
        found = elongation(test, rng=rng)
        wanted = {"slope": 1 / k}
    else:
        test, truth = decayed(material, seed, planted)
        found = decay(test, rng=rng)
        wanted = {"k": truth.k, "c": truth.c}
    right = [TAKEN.get(name, (name,)) for name in effects]
    truths = {PARAMETER[name][0]: size for name, size in planted.items() if name in PARAMETER}
    values = [one for cause in found.causes if cause.verdict == "supported" for one in cause.parameters]
    covered = [abs(one.value - truths[one.name]) < 1.96 * one.u for one in values if one.name in truths]
    kept = [abs(one.after - wanted[one.name]) < 1.96 * one.u_after for one in found.shifts if one.name in wanted]
    # Where leaving the effect out moved the parameter visibly: by more than five of its standard uncertainties.
    bias = [
        abs(one.after - wanted[one.name]) / abs(one.before - wanted[one.name])
        for one in found.shifts
        if one.name in wanted and abs(one.before - wanted[one.name]) > 5 * max(one.u_before, one.u_after)
    ]
    return {
        "method": method, "kind": kind, "material": material, "planted": list(effects), "right": right, "d": d,
        "verdict": found.verdict, "possible": list(found.possible), "groups": [list(one) for one in found.groups],
        "covered": covered, "kept": kept, "bias": bias, "seconds": time.process_time() - begun,
    }  # fmt: skip


def tasks(method: str, each: int, nothing: int):
    """Tests of the study."""
    from_table = truth_elongation if method == "elongation" else truth_decay
    names, unknown, materials = list(from_table.EFFECTS), list(from_table.UNKNOWN), list(from_table.MATERIALS)
    for at in range(nothing):
        yield method, "nothing", materials[at % 4], (), 0.0, 20_000 + at
    for row, name in enumerate(names):
        for at in range(each):
            for place, d in enumerate((5.0, 8.0, 12.0, 30.0)):
                seed = 30_000 + 100 * row + at + 100_000 * place
                yield method, "one", materials[(at + row) % 4], (name,), d, seed
    for at in range(2 * each):
        pair = (names[at % len(names)], names[(at * 3 + 1 + at // len(names)) % len(names)])
        if len(set(pair)) == 2:
            yield method, "two", materials[at % 4], pair, 15.0, 50_000 + at
    for row, name in enumerate(unknown):
        for at in range(max(each // 2, 1)):
            seed = 60_000 + zlib.crc32(name.encode()) % 1000 * 10 + at
            yield method, "unknown", materials[(at + row) % 4], (name,), 20.0, seed


def share(rows: list[dict], right) -> str:
    """How many of the rows are right, in words."""
    count = sum(bool(right(row)) for row in rows)
    return f"{count} of {len(rows)} ({100 * count / max(len(rows), 1):.0f} %)"


def first(row: dict) -> bool:
    """Whether the planted effect, or its group, is named first."""
    if not row["possible"]:
        return False
    top = {row["possible"][0]} | {one for group in row["groups"] if row["possible"][0] in group for one in group}
    return bool(top & set(row["right"][0]))


def every(row: dict) -> list[bool]:
    """Which of the planted effects are among the possible ones."""
    return [bool(set(right) & set(row["possible"])) for right in row["right"]]


def table(rows: list[dict]) -> str:
    """The bars as a table, then the confusion matrix."""
    by = {kind: [row for row in rows if row["kind"] == kind] for kind in ("nothing", "one", "two", "unknown")}
    sized = {d: [row for row in by["one"] if row["d"] == d] for d in (5.0, 8.0, 12.0, 30.0)}
    both = [row for row in by["one"] if row["d"] >= 6]
    exactly = [row for row in by["one"] if first(row)]
    covered, kept = ([one for row in exactly for one in row[key]] for key in ("covered", "kept"))
    bias = [one for row in sized[30.0] if first(row) for one in row["bias"]]
    lines = [
        ("nothing planted: nothing missing", share(by["nothing"], lambda row: row["verdict"] == "nothing missing")),
        *((f"one effect, d = {d:g}: named first, or its group", share(sized[d], first)) for d in (8.0, 12.0, 30.0)),
        ("d ≥ 6: among those reported as possible", share(both, lambda row: all(every(row)))),
        ("d ≥ 6: reported as possible, on average", f"{np.mean([len(row['possible']) for row in both] or [0]):.2f}"),
        ("d = 5: named or missed, not misnamed", share(sized[5.0], lambda row: not row["possible"] or first(row))),
        ("d = 5: named", share(sized[5.0], first)),
        ("two effects (d = 15): both among the possible", share(by["two"], lambda row: all(every(row)))),
        ("two effects: at least one", share(by["two"], lambda row: any(every(row)))),
        ("unknown effect (d = 20): unexplained", share(by["unknown"], lambda row: row["verdict"] == "unexplained")),
        ("95 % intervals of sizes cover", f"{sum(covered)} of {len(covered)}"),
        ("95 % intervals of k, c cover after extension", f"{sum(kept)} of {len(kept)}"),
        (f"bias of k, c after over before (d = 30), median of {len(bias)}", f"{np.median(bias or [0]):.3f}"),
        ("CPU seconds a test, median and largest",
         f"{np.median([row['seconds'] for row in rows]):.1f}, {max(row['seconds'] for row in rows):.1f}"),
    ]  # fmt: skip
    text = ["| bar | found |", "|---|---|", *(f"| {name} | {value} |" for name, value in lines), ""]
    text += ["| planted | d | possible causes |", "|---|---|---|"]
    for key in dict.fromkeys((tuple(row["planted"]), row["d"]) for row in rows):
        own = Counter(
            f"{', '.join(row['possible'])} ({row['verdict']})" if row["possible"] else row["verdict"]
            for row in rows if (tuple(row["planted"]), row["d"]) == key
        )  # fmt: skip
        words = "; ".join(f"{name}: {count}" for name, count in own.most_common())
        text.append(f"| {' + '.join(key[0]) or 'nothing'} | {key[1]:g} | {words} |")
    return "\n".join(text) + "\n"


def main() -> None:
    """Run the study and write its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=10)
    parser.add_argument("--nothing", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--scheduler", help="a Dask scheduler, whose workers have this folder and tests/ on PYTHONPATH")
    parser.add_argument("--method", choices=("elongation", "decay"), action="append")
    parser.add_argument("--out", type=Path, default=Path("docs/studies/diagnosis-decay-elongation.md"))
    parser.add_argument("--rows", type=Path)
    given = parser.parse_args()
    parts = []
    for method in given.method or ("elongation", "decay"):
        rows = []
        with workers.crew(given.workers, given.scheduler) as found:
            for row in found.executor.map(case, tasks(method, given.each, given.nothing)):
                rows.append(row)
                if given.rows:
                    with given.rows.open("a", encoding="utf-8") as file:
                        file.write(json.dumps(row) + "\n")
        parts.append(f"## {method.capitalize()}\n\n{len(rows)} tests.\n\n{table(rows)}")
    made = f"Version {__version__}, {datetime.now(UTC):%Y-%m-%d}."
    head = f"# What diagnosis names in free decays and elongation tests\n\n{made}"
    text = "\n\n".join([head, *parts])
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
