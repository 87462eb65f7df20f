"""How well diagnosis names what was planted in tension tests that an independent generator drew.

``python studies/diagnosis_tension.py [--first SEED] [--each N] [--nothing N] [--effect NAME]`` prints a table: outcomes
by planted effect and distance d, false alarms, and CPU time.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
import tension_cases as cases


def main() -> None:
    """Run the study and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=500_000)
    parser.add_argument("--each", type=int, default=9)
    parser.add_argument("--nothing", type=int, default=102)
    parser.add_argument("--effect", action="append")
    given = parser.parse_args()
    found: dict[tuple[str, float], list[str]] = {}
    wrong, seconds = [], []
    for name, d, seed, rigid in cases.campaign(given.first, given.each, given.nothing):
        if given.effect and name not in given.effect:
            continue
        begun = time.process_time()
        one = cases.judged(name, d, seed, rigid=rigid)
        seconds.append(time.process_time() - begun)
        said = cases.outcome(name, one)
        found.setdefault((name, d), []).append(said)
        if said not in ("named", "silent"):
            wrong.append(f"{name or 'nothing'} d = {d:g} seed {seed}: {one.verdict}, {', '.join(one.possible)}")
    print("| planted | d | outcomes |\n|---|---|---|")
    for (name, d), outcomes in found.items():
        words = ", ".join(f"{said}: {count}" for said, count in Counter(outcomes).most_common())
        print(f"| {name or 'nothing'} | {d:g} | {words} |")
    for size in (10.0, 30.0):
        told = Counter(said for (_, d), outcomes in found.items() if d == size for said in outcomes)
        print(f"\nd = {size:g}: " + ", ".join(f"{said} {count} of {told.total()}" for said, count in told.items()))
    print(f"CPU s a test: {np.median(seconds):.1f} median, {max(seconds):.1f} at most\n" + "\n".join(wrong))


if __name__ == "__main__":
    main()
