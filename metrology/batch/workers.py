"""Where the campaigns of a batch are evaluated: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    from distributed import Client

P = ParamSpec("P")
R = TypeVar("R")
LIFETIME = 50
"""Jobs after which a process is replaced by a fresh one, so that what libraries keep does not grow over a batch."""
ATTEMPTS = 2
"""How often a job is tried whose process dies."""
PATIENCE = 30
"""How long to wait for a scheduler, and for its first worker, s."""


@dataclass(frozen=True)
class Workers:
    """An executor, and how many jobs keep it busy: as many again as run at once wait before it; 0 when it is lost."""

    executor: Executor
    width: Callable[[], int]


class WorkerDiedError(Exception):
    """A job whose process died at every attempt."""


class Processes(Executor):
    """Processes of this machine, each a pool of its own: one that dies takes down the job that it had, and no other.

    The job is tried once more in a fresh process. In one pool for all, a death breaks every job under way, and nobody
    knows which of them was the cause.

    Parameters
    ----------
    workers : int
        Number of processes.
    """

    def __init__(self, workers: int) -> None:
        self._threads = ThreadPoolExecutor(workers, thread_name_prefix="batch")
        self._own = threading.local()
        self._pools: list[ProcessPoolExecutor] = []

    def submit(self, job: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Run a job in the next process that is free."""
        return self._threads.submit(self._run, job, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when the jobs under way are done."""
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        for pool in self._pools:
            pool.shutdown(wait=wait)

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Begin nothing more after an interruption."""
        self.shutdown(cancel_futures=kind is not None)

    def _run(self, job: Callable[..., R], args: tuple[Any, ...], kwargs: dict[str, Any]) -> R:
        for _ in range(ATTEMPTS):
            try:
                return self._pool().submit(job, *args, **kwargs).result()
            except BrokenProcessPool:
                self._end()
        raise WorkerDiedError(
            f"its process died {ATTEMPTS} times: killed, out of memory, or by a fault of a library. Run it by itself "
            "with `metrology report` to see which"
        )

    def _pool(self) -> ProcessPoolExecutor:
        """The process of this thread, a fresh one where the old one has done its share."""
        own = self._own
        if getattr(own, "jobs", LIFETIME) >= LIFETIME:
            self._end()
            # A forked copy of a process with threads may hang; a fresh interpreter costs two seconds for 50 jobs.
            own.pool, own.jobs = ProcessPoolExecutor(1, mp_context=get_context("spawn")), 0
            self._pools.append(own.pool)
        own.jobs += 1
        pool: ProcessPoolExecutor = own.pool
        return pool

    def _end(self) -> None:
        own = self._own
        if hasattr(own, "pool"):
            self._pools.remove(own.pool)
            own.pool.shutdown()
            del own.pool, own.jobs


def crew(count: int, scheduler: str | None) -> AbstractContextManager[Workers]:
    """The workers of a Dask scheduler where one is named, else processes of this machine."""
    return cluster(scheduler) if scheduler else local(count)


@contextmanager
def local(count: int) -> Iterator[Workers]:
    """Processes of this machine."""
    with Processes(count) as executor:
        yield Workers(executor, lambda: 2 * count)


@contextmanager
def cluster(address: str) -> Iterator[Workers]:
    """The workers of a Dask scheduler; one that joins or leaves meanwhile is taken as it comes.

    Raises
    ------
    MetrologyError
        Where Dask is not installed, no scheduler answers, or it has no worker.
    """
    try:
        from distributed import Client
    except ImportError:
        raise MetrologyError(
            Fault("--scheduler", "no Dask on this machine", "the package distributed", "install the extra `cluster`")
        ) from None
    try:
        client = Client(  # type: ignore[no-untyped-call]
            address, timeout=PATIENCE, set_as_default=False, name="metrology-batch"
        )
    except (OSError, ValueError) as error:
        got = f"{address}, where no scheduler answers ({' '.join(str(error).split())})"
        raise MetrologyError(Fault("--scheduler", got, "such as tcp://10.0.0.1:8786", "dask scheduler")) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            got = f"{address}, which has no worker"
            raise MetrologyError(Fault("--scheduler", got, "one at least", f"dask worker {address}")) from None
        # The client ends its executor; asked to end by itself, that waits for what a lost scheduler never gives.
        yield Workers(client.get_executor(), lambda: _width(client))  # type: ignore[no-untyped-call]


def _width(client: Client) -> int:
    """Twice the workers that are there, one at least; 0 where the scheduler cannot be reached."""
    try:
        count = sum(client.nthreads().values())  # type: ignore[no-untyped-call]
    except (OSError, RuntimeError):
        return 0
    return 2 * max(count, 1) if client.status == "running" else 0
