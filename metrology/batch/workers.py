"""Where the campaigns of a batch are evaluated: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
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
"""How long to wait for the first worker, s; for a scheduler as long as Dask's configuration says, 30 s by default."""


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


@dataclass(frozen=True)
class Tls:
    """Certificates with which a batch and its scheduler know each other; files in PEM, None for Dask's configuration.

    Parameters
    ----------
    authority, certificate, key : Path, optional
        Of the authority behind both sides, of this side, and its key.
    plain : bool
        Whether a scheduler on another machine may be reached without.
    """

    authority: Path | None = None
    certificate: Path | None = None
    key: Path | None = None
    plain: bool = False


def crew(count: int, scheduler: str | None, tls: Tls = Tls()) -> AbstractContextManager[Workers]:
    """The workers of a Dask scheduler where one is named, else processes of this machine."""
    return cluster(scheduler, tls) if scheduler else local(count)


@contextmanager
def local(count: int) -> Iterator[Workers]:
    """Processes of this machine."""
    with Processes(count) as executor:
        yield Workers(executor, lambda: 2 * count)


@contextmanager
def cluster(address: str, tls: Tls = Tls()) -> Iterator[Workers]:
    """The workers of a Dask scheduler; one that joins or leaves meanwhile is taken as it comes.

    Raises
    ------
    MetrologyError
        Where Dask is not installed, no scheduler answers, another one does than that of the certificates, it has no
        worker, or it would be reached over a network without TLS.
    """
    _refuse_plain(address, tls)
    try:
        from distributed import Client
    except ImportError:
        raise MetrologyError(
            Fault("--scheduler", "no Dask on this machine", "the package distributed", "install the extra `cluster`")
        ) from None
    try:
        client = Client(  # type: ignore[no-untyped-call]
            address, set_as_default=False, name="metrology-batch", security=_security(address, tls)
        )
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        got = f"{address}, where no scheduler answers ({' '.join(str(error).split())})"
        raise MetrologyError(Fault("--scheduler", got, "such as tcp://10.0.0.1:8786", "dask scheduler")) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except (OSError, RuntimeError):  # no worker came, or the scheduler went
            got = f"{address}, which has no worker"
            raise MetrologyError(Fault("--scheduler", got, "one at least", f"dask worker {address}")) from None
        # The client ends its executor; asked to end by itself, that waits for what a lost scheduler never gives.
        yield Workers(client.get_executor(), lambda: _width(client))  # type: ignore[no-untyped-call]


def _refuse_plain(address: str, tls: Tls) -> None:
    """Refuse to hand out work over a network where anybody may listen, or be the scheduler."""
    host = address.partition("://")[2].rpartition(":")[0].strip("[]")
    if not address.startswith("tcp://") or tls.plain or _is_loopback(host):
        return
    expected = "tls://, with --tls-ca-file, --tls-cert and --tls-key, or Dask's own configuration"
    fix = "--no-tls where the network is closed to others"
    raise MetrologyError(Fault("--scheduler", f"{address}, which is another machine without TLS", expected, fix))


def _is_loopback(host: str) -> bool:
    from ipaddress import ip_address

    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _security(address: str, tls: Tls) -> Any:
    """What Dask is to know of certificates; None for what its configuration says."""
    from distributed.security import Security

    if not address.startswith("tls://"):
        return None
    given = {"tls_ca_file": tls.authority, "tls_client_cert": tls.certificate, "tls_client_key": tls.key}
    for path in filter(None, given.values()):
        if not path.is_file():
            raise MetrologyError(Fault(str(path), "no such file", "a certificate or a key in PEM"))
    files = {name: str(path) for name, path in given.items() if path}
    return Security(require_encryption=True, **files)  # type: ignore[no-untyped-call]


def _width(client: Client) -> int:
    """Twice the workers that are there, one at least; 0 where the scheduler cannot be reached."""
    if client.scheduler is None:  # the client gave it up, and takes no question any more
        return 0
    try:
        count = sum(client.nthreads().values())  # type: ignore[no-untyped-call]
    except (OSError, RuntimeError, AttributeError):  # the last where it is given up in this very moment
        return 0
    return 2 * max(count, 1) if client.status == "running" else 0
