"""A batch of generated campaigns on one and two workers, of this machine and of a Dask cluster on loopback.

Each campaign derives one quantity from three inputs, by law and trials, judges it and lays out its report. Wall time
gives the efficiency where the machine is idle; CPU time tells on a busy one what a second worker, the cluster and a
larger batch cost. Memory is the most that the process which gives out the work, and any worker, ever held.

python benchmarks/batch.py [--sizes 10 100 1000]
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
CAMPAIGN = """\
format: metrology-campaign/1
id: wire-{0}
title: Wire {0}
seed: {0}
quantities:
  F: {{value: {1} N, uncertainty: [{{standard: 0.02 N}}]}}
  x: {{value: 0.49 mm, uncertainty: [{{half_width: 0.005 mm, distribution: rectangular}}]}}
  zero: {{value: 0 mm, uncertainty: [{{half_width: 0.005 mm, distribution: triangular}}]}}
derived:
  - {{quantity: k, expression: F/(x - zero), unit: N/m}}
requirements:
  - {{id: R1, quantity: k, limits: {{lower: 15 kN/m}}, decision: {{rule: guard band}}}}
"""
UNPROFILED = {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}
"""Else a worker keeps a profile of every second, 1 MB each."""
TICKS = os.sysconf("SC_CLK_TCK")


def write(folder: Path, count: int) -> None:
    """Write campaigns that differ in their force and their seed."""
    for number in range(count):
        own = folder / f"wire-{number}"
        own.mkdir(parents=True)
        (own / "campaign.yaml").write_text(CAMPAIGN.format(number, 9.8 + number / 1e4))


def spent(processes: list[int]) -> float:
    """CPU time of processes that still run, s."""
    fields = [Path(f"/proc/{one}/stat").read_text().rsplit(")", 1)[1].split() for one in processes]
    return sum(int(field[11]) + int(field[12]) for field in fields) / TICKS


def most(process: int | str = "self") -> float:
    """Most memory that a process ever held, MB."""
    return int(re.search(r"VmHWM:\s+(\d+)", Path(f"/proc/{process}/status").read_text())[1]) / 1e3


def measured(kind: str, count: int, size: int) -> dict[str, float]:
    """One batch in this process: made, and then found up to date."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    from metrology.batch import find, make, workers

    with TemporaryDirectory() as name, cluster(kind, count) as (address, processes):
        write(Path(name) / "lab", size)
        paths, output = find(Path(name) / "lab"), Path(name) / "reports"
        begun, own, theirs = time.perf_counter(), time.process_time(), spent(processes)
        with workers.crew(count, address) as found:
            outcomes = make(paths, output, found)
        wall, own = time.perf_counter() - begun, time.process_time() - own
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        theirs = spent(processes) - theirs if processes else children.ru_utime + children.ru_stime
        held = max([most(one) for one in processes], default=children.ru_maxrss / 1e3)
        again = time.process_time()
        with workers.crew(count, address) as found:
            make(paths, output, found)
        return {
            "made": sum(one.state == "made" for one in outcomes), "wall": wall, "own": own / size,
            "theirs": theirs / size, "memory": most(), "held": held, "again": (time.process_time() - again) / size,
        }  # fmt: skip


@contextmanager
def cluster(kind: str, count: int) -> Iterator[tuple[str | None, list[int]]]:
    """Address and worker processes of a cluster on loopback; nothing where the workers are local."""
    if kind == "local":
        yield None, []
        return
    here = ("--host", "127.0.0.1", "--no-dashboard")
    with TemporaryDirectory() as folder:
        options = ("--nthreads", "1", "--no-nanny", "--local-directory", folder)
        scheduler = subprocess.Popen(
            [sys.executable, "-m", "dask", "scheduler", *here, "--port", "0"], stderr=subprocess.PIPE, text=True
        )
        started = [scheduler]
        try:
            address = next(
                found[1] for line in scheduler.stderr if (found := re.search(r"Scheduler at:\s+(\S+)", line))
            )
            command = [sys.executable, "-m", "dask", "worker", address, *here, *options]
            started += [
                subprocess.Popen(command, stderr=subprocess.DEVNULL, env=os.environ | UNPROFILED) for _ in range(count)
            ]
            _wait(address, count)
            yield address, [process.pid for process in started[1:]]
        finally:
            for process in started:
                process.kill()
                process.communicate()


def _wait(address: str, count: int) -> None:
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=120)


def main() -> None:
    """Run every batch in a fresh process and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=[10, 100, 1000])
    parser.add_argument("--kinds", nargs="+", default=["local", "dask"], choices=["local", "dask"])
    parser.add_argument("--peer-python", help=argparse.SUPPRESS)
    parser.add_argument("--case", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.case:
        kind, count, size = options.case
        print(json.dumps(measured(kind, int(count), int(size))))
        return
    head = ("campaigns", "workers", "wall / s", "efficiency", "CPU here", "CPU there", "skip", "MB here", "MB there")
    print(f"Generated campaigns in a batch; CPU in ms for each campaign; load at start {os.getloadavg()[0]:.1f}")
    print("".join(f"{word:>12}" for word in head))
    for size in options.sizes:
        for kind in options.kinds:
            alone = 0.0
            for count in (1, 2):
                command = [sys.executable, __file__, "--case", kind, str(count), str(size)]
                done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
                row = json.loads(done.stdout.splitlines()[-1])
                alone = alone or row["wall"]
                share = f"{alone / count / row['wall']:.0%}"
                cpu = (f"{1e3 * row[name]:.0f}" for name in ("own", "theirs", "again"))
                cells = (f"{row['made']:.0f}", f"{kind} {count}", f"{row['wall']:.1f}", share, *cpu)
                memory = (f"{row['memory']:.0f}", f"{row['held']:.0f}")
                print("".join(f"{cell:>12}" for cell in (*cells, *memory)), flush=True)


if __name__ == "__main__":
    main()
