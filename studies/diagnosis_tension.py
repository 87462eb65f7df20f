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

SETUPS = {True: "rigid", False: "gives way"}


def _counted(outcomes: list[str]) -> str:
    return ", ".join(f"{said}: {count}" for said, count in Counter(outcomes).most_common())


def _distance(name: str, d: float) -> str:
    """Distance of a case in words."""
    if name in cases.UNLISTED:
        return "unlisted, 30 to 150"
    return "pair, 12 to 60" if len(cases.parts(name)) > 1 else f"{d:g}"


def main() -> None:
    """Run the study and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=500_000)
    parser.add_argument("--each", type=int, default=9)
    parser.add_argument("--nothing", type=int, default=102)
    parser.add_argument("--effect", action="append")
    parser.add_argument("--further", type=int, default=5, help="tests of each pair, and half of each unlisted effect")
    given = parser.parse_args()
    found: dict[tuple[str, str, bool], list[str]] = {}
    wrong, seconds = [], []
    every = [*cases.campaign(given.first, given.each, given.nothing), *cases.further(given.first, given.further)]
    for name, d, seed, rigid in every:
        if given.effect and name not in given.effect:
            continue
        begun = time.process_time()
        one = cases.judged(name, d, seed, rigid=rigid)
        seconds.append(time.process_time() - begun)
        said = cases.outcome(name, one, rigid=rigid)
        found.setdefault((name, _distance(name, d), rigid), []).append(said)
        if said not in ("named", "silent") or name in cases.UNLISTED:
            wrong.append(f"{name or 'nothing'} d = {d:g} seed {seed}: {one.verdict}, {', '.join(one.possible)}")
    print("| planted | d | set-up | outcomes |\n|---|---|---|---|")
    for (name, d, rigid), outcomes in found.items():
        print(f"| {name or 'nothing'} | {d} | {SETUPS[rigid]} | {_counted(outcomes)} |")
    for d in dict.fromkeys(size for _, size, _ in found):
        for rigid in (True, False):
            outcomes = [said for (_, size, stiff), parts in found.items() if (size, stiff) == (d, rigid)
                        for said in parts]  # fmt: skip
            print(f"\nd = {d}, {SETUPS[rigid]}: {_counted(outcomes)}, of {len(outcomes)}")
    print(f"\nCPU s a test: {np.median(seconds):.1f} median, {max(seconds):.1f} at most\n" + "\n".join(wrong))


if __name__ == "__main__":
    main()
