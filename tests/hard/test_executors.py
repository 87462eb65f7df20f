"""Executors: the same bits from any of them, and work that is made up for when a worker dies."""

from __future__ import annotations

import multiprocessing
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from dask import config

from metrology.batch import Workers, bundle, make, stamp, workers
from metrology.batch.job import work
from metrology.errors import MetrologyError

REFERENCE = Path(__file__).parents[1] / "reference"
EXAMPLES = ("jcgm106-7-two-sided", "gum-h2-resistance-reactance")
"""Two that are quick: one of a single quantity, one whose draws are joint and whose readings lie in a file."""


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaigns")
    for name in EXAMPLES:
        shutil.copytree(REFERENCE / name, folder / name)
    return [folder / name / "campaign.yaml" for name in EXAMPLES]


@pytest.fixture(scope="module")
def alone(campaigns):
    """Reports made one after the other in this very process."""
    return [work(bundle.pack(path, Path("reports")), stamp.code()).files for path in campaigns]


def made(campaigns, executor):
    """Reports by an executor, the work given out in reverse."""
    futures = [executor.submit(work, bundle.pack(path, Path("reports")), stamp.code()) for path in campaigns[::-1]]
    found = [future.result() for future in futures[::-1]]
    assert not any(one.faults for one in found)
    return [one.files for one in found]


def dask(*arguments, log):
    command = [sys.executable, "-m", "dask", *arguments]
    with log.open("w") as file:
        return subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)


def address(log):
    """Where the scheduler listens: it takes a free port and says which."""
    for _ in range(600):
        if found := re.search(r"Scheduler at:\s+(tcp://127\.0\.0\.1:\d+)", log.read_text()):
            return found[1]
        time.sleep(0.1)
    raise AssertionError(log.read_text())


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """A scheduler and three workers, started as on any host: its address, and the workers' processes by name."""
    folder = tmp_path_factory.mktemp("cluster")
    here = ("--host", "127.0.0.1", "--no-dashboard")
    processes = {"scheduler": dask("scheduler", *here, "--port", "0", log=folder / "scheduler.log")}
    try:
        place = address(folder / "scheduler.log")
        for name in ("one", "two", "three"):
            options = ("--name", name, "--nthreads", "1", "--no-nanny", "--local-directory", str(folder))
            processes[name] = dask("worker", place, *here, *options, log=folder / f"{name}.log")
        yield place, processes
    finally:
        for process in processes.values():
            process.kill()
            process.wait()


@pytest.mark.long
def test_twice_threads_give_the_same_bits(campaigns, alone):
    with ThreadPoolExecutor(2) as executor:
        assert made(campaigns, executor) == alone


@pytest.mark.long
@pytest.mark.parametrize("count", [1, 2])
def test_twice_processes_give_the_same_bits(campaigns, alone, count):
    with workers.local(count) as found:
        assert made(campaigns[:count], found.executor) == alone[:count]


@pytest.mark.long
def test_twice_dask_gives_the_same_bits_also_when_a_worker_is_killed(campaigns, alone, cluster, tmp_path):
    place, processes = cluster
    with workers.cluster(place) as found:
        found.executor._client.wait_for_workers(3, timeout=60)
        with ThreadPoolExecutor(1) as here:
            outcomes = here.submit(make, campaigns, tmp_path, found)
            # A worker's first campaign takes seconds: whoever has one now is in the middle of it.
            busy = victim(found.executor._client)
            processes[busy].kill()
            processes[busy].wait()
            assert [one.state for one in outcomes.result()] == ["made", "made"]
        assert len(found.executor._client.nthreads()) == 2
        assert emptied(found.executor._client)
        assert found.width() == 4
    for name, files in zip(EXAMPLES, alone, strict=True):
        assert {file: (tmp_path / name / file).read_bytes() for file in files} == files


def victim(client):
    """Name of a worker that is at work."""
    for _ in range(600):
        states = client.run_on_scheduler(at_work)
        if states:
            return states[0]
        time.sleep(0.05)
    raise AssertionError("no worker got any work")


def emptied(client):
    """Whether the cluster lets go of every report once it was written."""
    for _ in range(100):
        if client.run_on_scheduler(held) == 0:
            return True
        time.sleep(0.05)
    return False


def held(dask_scheduler):
    return len(dask_scheduler.tasks)


def at_work(dask_scheduler):
    return [state.name for state in dask_scheduler.workers.values() if state.processing]


@pytest.mark.long
def test_refusal_no_scheduler():
    soon = config.set({"distributed.comm.timeouts.connect": "1s"})
    with soon, pytest.raises(MetrologyError, match=r"--scheduler: got tcp://127.0.0.1:1, where no scheduler answers"):
        workers.cluster("tcp://127.0.0.1:1").__enter__()


def test_refusal_worker_of_other_code(campaigns):
    found = work(bundle.pack(campaigns[0], Path("reports")), "other")
    assert not found.files
    assert re.search("worker on .*: got other code, templates or libraries; expected those of", str(found.faults[0]))


def test_refusal_worker_whose_linear_algebra_has_threads(campaigns, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    found = work(bundle.pack(campaigns[0], Path("reports")), stamp.code())
    assert "got OPENBLAS_NUM_THREADS=2; expected OPENBLAS_NUM_THREADS=1" in str(found.faults[0])


DIES_ONCE = "import os, pathlib; p = pathlib.Path({!r}); first = not p.exists(); p.touch(); first and os._exit(1)"


def test_law_a_job_whose_process_dies_once_is_done(tmp_path):
    with workers.Processes(1) as executor:
        assert executor.submit(exec, DIES_ONCE.format(str(tmp_path / "been"))).result() is None
    assert (tmp_path / "been").exists()


def test_law_a_job_whose_process_dies_twice_takes_no_other_down():
    with workers.Processes(2) as executor:
        killer = executor.submit(os._exit, 3)
        others = [executor.submit(abs, -number) for number in range(4)]
        assert [other.result() for other in others] == [0, 1, 2, 3]
        with pytest.raises(workers.WorkerDiedError, match="its process died 2 times"):
            killer.result()


def test_law_processes_are_replaced_after_their_lifetime(monkeypatch):
    monkeypatch.setattr(workers, "LIFETIME", 2)
    with workers.Processes(1) as executor:
        found = [executor.submit(os.getpid).result() for _ in range(5)]
    assert [found.count(process) for process in dict.fromkeys(found)] == [2, 2, 1]


@pytest.mark.long
def test_planted_campaign_that_kills_its_process_is_named(campaigns, tmp_path):
    """The first two processes are killed: the campaign that had both is named, the next is made."""
    killed: list[int] = []

    def kill() -> None:
        while len(killed) < 2:
            for child in multiprocessing.active_children():
                if child.pid and child.pid not in killed:
                    os.kill(child.pid, signal.SIGKILL)
                    killed.append(child.pid)
            time.sleep(0.01)

    killer = threading.Thread(target=kill)
    with workers.local(1) as found:
        killer.start()
        first, second = make(campaigns, tmp_path, Workers(found.executor, lambda: 1))
    killer.join()
    assert first.state == "not made"
    assert first.reasons[0].startswith("its process died 2 times: killed, out of memory")
    assert (second.reasons, second.state) == ((), "made")
