"""Readers whose C libraries crash or hang on a damaged file run in a process of their own, bounded in time and memory.

SciPy's reader of MAT files ended the process on one file in some hundred that were changed at random, that of workbooks
on a sheet with one cell far away, and HDF5 did not return: a report on many campaigns must survive such a file.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace

from metrology.errors import Fault, MetrologyError
from metrology.readings import formats
from metrology.readings.sheet import Job, SeveralPartsError, Sheet, refused

SECONDS = 120
"""A whole file of 64 MiB is read within seconds, on a busy machine within half a minute: what takes longer hangs."""
GRACE = 10
"""How much later the process ends itself, s: should nobody be there any more to end it."""
PR_SET_PDEATHSIG = 1
"""Linux's prctl(2)."""
MEMORY = 6 << 30
"""Address space of the process: HDF5, NumPy and SciPy map about 2 GiB before they read anything.

Windows sets no such limit, as it lacks the module `resource`."""
FORMATS = ("mat", "hdf5", "mdf4", "xlsx", "ods", "parquet")


@contextmanager
def readable(where: str, found: formats.Format) -> Iterator[None]:
    """Tell in our words of whatever a reader raises at a damaged file; that of texts is our own, and raises nothing."""
    try:
        yield
    except MetrologyError:
        raise
    except Exception as error:
        if found.name in ("text", "lvm") or isinstance(error, MemoryError):
            raise
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise refused(where, f"{found.title} that cannot be read ({reason})", "a whole file", "copy it again") from None


def load(job: Job, found: formats.Format) -> Sheet:
    """Read a content by its format, in a process of its own where its library is one of those.

    Raises
    ------
    MetrologyError
        As the reader itself; and for a file at which the process crashed, or did not end in time.
    """
    if found.name not in FORMATS:
        return formats.load(job, found)
    task = pickle.dumps((found.name, job))
    try:
        answered = _in_a_process(task)
    except subprocess.TimeoutExpired:
        raise refused(job.log.where, f"{found.title} that is not read in {SECONDS} s", "a whole file") from None
    if not answered:
        raise refused(job.log.where, f"{found.title} that crashes its reader", "a whole file", "copy it again")
    found_out = pickle.loads(answered)  # noqa: S301 - written by our own process
    if isinstance(found_out, Exception):
        raise found_out
    if isinstance(found_out[0], Fault):
        raise MetrologyError(*found_out)
    sheet, notices, faults, chunks = found_out
    job.log.faults.extend(faults)
    for notice in notices:
        job.log.note(notice)
    table: Sheet = replace(sheet, chunks=iter(chunks))
    return table


def _in_a_process(task: bytes) -> bytes:
    """What the process answers; nothing where it crashed."""
    command = [sys.executable, "-P", "-m", "metrology.readings.apart", str(os.getpid())]
    done = subprocess.run(command, input=task, capture_output=True, timeout=SECONDS, check=False)  # noqa: S603
    return b"" if done.returncode else done.stdout


def main() -> None:
    """Read one task from the standard input, and write the table or the error to the standard output."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    _end_with(int(sys.argv[1]))
    sys.stdout.buffer.write(answer(sys.stdin.buffer.read()))
    sys.stdout.buffer.flush()


def _end_with(parent: int) -> None:
    """End this process with the one that asked, which may be ended at any moment, and in any case after some time.

    Signals do this, as a library that hangs lets no Python run.
    """
    if hasattr(signal, "alarm"):
        signal.alarm(SECONDS + GRACE)
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before that
            sys.exit(1)


def answer(task: bytes) -> bytes:
    """The table of one task, or what is wrong with it, for the process that asked."""
    name, job = pickle.loads(task)  # noqa: S301 - written by our own process
    found = next(one for one in formats.FORMATS if one.name == name)
    found_out: object
    try:
        sheet = formats.load(job, found)
        found_out = (replace(sheet, chunks=iter(())), tuple(job.log.notices), job.log.faults, list(sheet.chunks))
    except SeveralPartsError as error:
        found_out = error
    except MetrologyError as error:
        found_out = error.faults
    except MemoryError:
        found_out = ValueError("it states more data than there is memory for")
    except Exception as error:  # noqa: BLE001 - a reader of somebody else's raises what it likes at a damaged file
        found_out = ValueError(f"{type(error).__name__}: {error}"[:200])
    return pickle.dumps(found_out)


if __name__ == "__main__":
    main()
