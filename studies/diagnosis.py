"""How well diagnosis names what was planted: campaigns drawn by an independent generator, judged one by one.

``python studies/diagnosis.py [--each N] [--nothing N] [--rows FILE] [--out docs/studies/diagnosis.md] [--workers N |
--scheduler ADDRESS]`` writes a table:
the bars, verdicts by planted effect and size, power against size, and two pictures. With `--rows` every campaign is
kept as one line of JSON; campaigns that stand there are not drawn again.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from concurrent.futures import as_completed
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from judging import document, pictures
from planting import EVERY, MATERIALS, PLANTED, UNLISTED, diagnosed, distance, known, sized, unlike

from metrology.batch import Workers, workers
from metrology.errors import MetrologyError
from metrology.rig import PARAMETERS

Task = tuple[str, str, str, tuple[str, ...], float, int]
"""Kind, material, plan of known inputs, effects, distance, seed."""
PHYSICS = (
    "friction", "drag", "quadratic drag", "tilt", "cubic", "damping", "frame", "toe", "zener", "hysteresis", "sag",
    "slip", "yaw", "thrust lag", "cell drift", "hum T",
)  # fmt: skip


def case(task: Task) -> dict[str, Any]:
    """One campaign: what was planted, what was named, and the figures of the bars."""
    kind, material, plan, effects, d, seed = task
    fields: dict[str, float] = {}
    reached = []
    for name in effects:
        own, moved = sized(name, material, plan, d, seed)
        fields |= own
        reached.append(moved)
    together = distance(material, plan, fields) if len(effects) > 1 else d
    left = unlike(material, plan, fields) if kind == "unlisted" else d
    begun, wall = time.process_time(), time.perf_counter()
    found = diagnosed(material, plan, fields, seed)
    k, c = MATERIALS[material]
    truths = {"k": k, "c": c} | planted(effects, fields, known(plan, seed))
    sizes = [one for cause in found.causes if cause.verdict == "supported" for one in cause.parameters]
    intervals = [(one.name, truths[one.name], one.value, one.low, one.high) for one in sizes if one.name in truths]
    shifts = [(one.name, truths[one.name], one.before, one.u_before, one.after, one.u_after) for one in found.shifts]
    return {
        "task": list(task), "kind": kind, "material": material, "planted": list(effects), "d": d, "reached": reached,
        "together": together, "left": left,
        "verdict": found.verdict, "named": list(found.named), "possible": list(found.possible),
        "groups": [list(group) for group in found.groups], "intervals": intervals, "shifts": shifts,
        "probability": [(cause.effect, cause.probability) for cause in found.causes if cause.probability > 0.01],
        "bayes": [(cause.effect, cause.log_bayes) for cause in found.causes if cause.log_bayes is not None],
        "tests": [(one.name, one.statistic, one.limit, one.passed) for one in found.tests],
        "held": [one.after for one in found.gain.values()], "chi": found.chi_squared,
        "smallest": [one.size for one in found.detectable if one.effect in effects], "fields": fields,
        "sizes": [(one.name, one.value) for one in sizes],
        "seconds": time.process_time() - begun, "wall": time.perf_counter() - wall,
        "failures": list(found.failures),
    }  # fmt: skip


def planted(effects: tuple[str, ...], fields: dict[str, float], common: dict[str, float]) -> dict[str, float]:
    """Parameters that the candidates should find: what was planted, and beside it what all runs share of an input."""
    values = {parameter: value for name in effects for parameter, value in EVERY[name].values.items() if parameter}
    found = {parameter: value(fields) for parameter, value in values.items()}
    for parameter in found.keys() & common.keys():
        # Where the effect vanishes tells a factor, 1, from a shift, 0.
        if PARAMETERS[parameter].null == 1.0:
            found[parameter] *= common[parameter]
        else:
            found[parameter] += common[parameter]
    return found


def tasks(each: int, nothing: int) -> Iterator[Task]:
    """Campaigns of the study, one of every sort before the next of any: a study that is cut short is still balanced."""
    materials, plans = list(MATERIALS), ("usual", "few")
    for turn in range(each):
        for at in range(turn * nothing // each, (turn + 1) * nothing // each):
            yield "nothing", materials[at % 4], plans[at // 4 % 2], (), 0.0, 20_000 + at
        for row, name in enumerate(PLANTED):
            # Anything larger of a wrong input is noticed on the spot.
            for place, d in enumerate((5.0, 9.0, 12.0 if name in ("mass", "free length") else 40.0)):
                seed = 30_000 + 100 * row + turn + 100_000 * place
                yield "one", materials[(turn + row) % 4], plans[(turn + row // 4) % 2], (name,), d, seed
        for row, name in enumerate(UNLISTED):
            for place, d in enumerate((15.0, 40.0)):
                seed = 60_000 + 100 * row + turn + 100_000 * place
                yield "unlisted", materials[(turn + row) % 4], plans[turn % 2], (name,), d, seed
        for row in range(10):
            at = 10 * turn + row
            pair = (PHYSICS[at % len(PHYSICS)], PHYSICS[(at + 1 + 3 * turn + row % 5) % len(PHYSICS)])
            if len(set(pair)) == 2 and set(pair) != {"toe", "sag"}:  # the generator's sagging line has no toe
                yield "two", materials[at % 4], plans[at % 2], pair, 15.0, 50_000 + at


def rows_of(path: Path | None) -> list[dict[str, Any]]:
    """Campaigns that were judged before."""
    if path is None or not path.exists():
        return []
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def study(chosen: list[Task], crew: AbstractContextManager[Workers], path: Path | None = None) -> list[dict[str, Any]]:
    """Judge campaigns side by side, each kept as soon as it is done."""
    rows = rows_of(path)
    done = {json.dumps(row["task"]) for row in rows}
    left = [task for task in chosen if json.dumps(task) not in done]
    with crew as found:
        posed = {found.executor.submit(case, task): task for task in left}
        for future in as_completed(posed):
            try:
                rows.append(future.result())
            except MetrologyError as error:  # A size that stops the module altogether: no campaign.
                print(f"left out {posed[future]}: {error}", file=sys.stderr)
                continue
            if path is not None:
                with path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    return rows


def main() -> None:
    """Run the study and write its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=10)
    parser.add_argument("--nothing", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--scheduler", help="a Dask scheduler, whose workers have this folder on PYTHONPATH")
    parser.add_argument("--only", default="", help="judge only campaigns whose kind, effect or material has this name")
    parser.add_argument("--out", type=Path, default=Path("docs/studies/diagnosis.md"))
    parser.add_argument("--rows", type=Path)
    parser.add_argument("--table", action="store_true", help="judge nothing more, only write what the rows say")
    given = parser.parse_args()
    chosen = list(tasks(given.each, given.nothing))
    if given.only:
        wanted = set(given.only.split(","))
        chosen = [one for one in chosen if wanted & {one[0], one[1], *one[3]}]
    rows = rows_of(given.rows)
    if not given.table:
        rows = study(chosen, workers.crew(given.workers, given.scheduler), given.rows)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    text = document(rows)
    given.out.write_text(text, encoding="utf-8")
    pictures(rows, given.out.parent)
    print(text)


if __name__ == "__main__":
    main()
