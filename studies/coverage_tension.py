"""How often the 95 % intervals of k and E hold the truth with the diagnosis on and an effect planted.

``python studies/coverage_tension.py [--first SEED] [--count N]`` prints hits by planted effect.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
import tension_cases as cases
import test_tension as campaigns
from truth_tension import pull

NAMES = ("", "cycles", *(name for name in cases.EFFECTS if name != "mullins"))
"""What is planted; of Mullins softening no single stiffness is the true one."""
campaigns.HEAD = campaigns.HEAD.replace("diagnosis: {off: true}\n", "")


def covered(folder: Path, name: str, seed: int) -> tuple[bool, bool]:
    """Whether k and E are covered, everything that is stated being drawn as stated."""
    rng = np.random.default_rng(seed)
    kind, d, limits = seed // len(NAMES), rng.choice([10.0, 30.0, 100.0]), rng.uniform(-0.005, 0.005, 2)
    area, length = 1e-5 + 1e-8 * rng.normal(), 0.1 + 1e-4 * rng.normal()
    planted, alone, chosen, records = {}, False, int(rng.integers(3)), {}
    if name in cases.EFFECTS:
        given, alone, _ = cases.EFFECTS[name]
        size, place = next(iter(given)), rng.uniform(0.25, 0.75) if name in cases.STEPS else 0.5
        factor = cases.factor(name, kind % len(cases.KINDS), place)
        planted = {**given, size: given[size] * d * factor, "slip_at": place}
    for number in range(3):
        one = replace(cases.machine(name, kind), EA=2e11 * area * (1 + 0.004 * rng.normal()), length=length,
                      compliance=2e-8 * (1 + 0.1 * rng.normal()))  # fmt: skip
        record = pull(replace(one, **planted) if not alone or number == chosen else one, rng)
        record["force"], record["strain"] = record["force"] / (1 + limits[0]), record["strain"] / (1 + limits[1])
        records["abc"[number]] = record
    # Of a parabola the stiffness is that at the middle of the range.
    part = 1 / (1 + 2 * planted.get("softening", 0.0) * float(np.mean(cases.RANGE)))
    found = campaigns.results(campaigns.written(folder, campaigns.BOTH + "    range: {share: [5 %, 90 %]}\n", records))
    truths = {"k": 2e11 * area / length * part, "E": 2e11 * part}
    k, E = (found[key].coverage.low <= truth <= found[key].coverage.high for key, truth in truths.items())
    return k, E


def main() -> None:
    """Run the study and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=9000)
    parser.add_argument("--count", type=int, default=150)
    given = parser.parse_args()
    hits: dict[str, list[tuple[bool, bool]]] = {name: [] for name in NAMES}
    for seed in range(given.first, given.first + given.count):
        name = NAMES[seed % len(NAMES)]
        with tempfile.TemporaryDirectory() as folder:
            hits[name].append(covered(Path(folder), name, seed))
    print("| planted | k | E | of |\n|---|---|---|---|")
    for name, rows in {**hits, "all": [one for found in hits.values() for one in found]}.items():
        k, E = np.sum(rows, axis=0) if rows else (0, 0)
        print(f"| {name or 'nothing'} | {k} | {E} | {len(rows)} |")


if __name__ == "__main__":
    main()
