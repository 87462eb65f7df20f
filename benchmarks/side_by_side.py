"""Run the ways of doing one thing in turns, each in a fresh process, and print time and added memory side by side."""

from __future__ import annotations

import argparse
import gc
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
Case = Callable[[int], object]


def main(
    script: str,
    title: str,
    cases: Mapping[str, Callable[[], Case]],
    size: int,
    repeats: int = 10,
    rounds: int = 3,
) -> None:
    """Entry point of a benchmark: as parent run all cases in turns, as child run one of them.

    Each case is a function that imports what it needs and returns the work as a function of the problem's size.
    """
    parser = argparse.ArgumentParser(description=title)
    parser.add_argument("--peer-python", default=sys.executable, help="interpreter in which the peers are installed")
    parser.add_argument("--rounds", type=int, default=rounds, help="turns that each way takes")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.case:
        print(json.dumps(_measure(cases[options.case], size, repeats)))
        return
    print(title)
    results = _turns(script, list(cases), options.peer_python, options.rounds)
    first = results[next(iter(cases))]
    print(f"{'':24}{'best / ms':>11}{'median / ms':>13}{'added / MB':>12}{'time ratio':>12}{'memory ratio':>14}")
    for name, found in results.items():
        if not found:
            print(f"{name:24} not installed, skipped")
            continue
        ratio = found["best"] / first["best"]
        memory = f"{found['memory'] / first['memory']:.2f}" if first["memory"] > 0.1 else "–"
        print(
            f"{name:24}{found['best'] * 1e3:11.2f}{found['median'] * 1e3:13.2f}{found['memory']:12.1f}"
            f"{ratio:12.2f}{memory:>14}   {found['result']}"
        )


def _turns(script: str, names: list[str], peer: str, rounds: int) -> dict[str, dict[str, float]]:
    times: dict[str, list[float]] = {name: [] for name in names}
    found: dict[str, dict[str, float]] = {}
    for _ in range(rounds):
        for name in names:
            result = _child(script, name, sys.executable if name.startswith(("metrology", "numpy")) else peer)
            times[name] += result.get("times", [])
            if result and (name not in found or result["memory"] < found[name]["memory"]):
                found[name] = result
    return {
        name: {**found[name], "best": min(times[name]), "median": statistics.median(times[name])}
        if name in found
        else {}
        for name in names
    }


def _child(script: str, name: str, python: str) -> dict[str, object]:
    done = subprocess.run(
        [python, script, "--case", name],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )
    if "ModuleNotFoundError" in done.stderr:
        return {}
    if done.returncode:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout.splitlines()[-1])


def _measure(prepare: Callable[[], Case], size: int, repeats: int) -> dict[str, object]:
    work = prepare()
    work(min(size, 2000))  # loads whatever is loaded late
    gc.collect()
    before = _memory("VmRSS")
    _forget_peak()
    result = work(size)
    added = max(_memory("VmHWM") - before, 0.0)
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work(size)
        times.append(time.perf_counter() - start)
    return {"times": times, "memory": added, "result": str(result)}


def _memory(key: str) -> float:
    """Resident memory, now (VmRSS) or at its peak (VmHWM), in MB."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) * 1024 / 1e6
    raise RuntimeError(f"no {key} in /proc/self/status")


def _forget_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")
