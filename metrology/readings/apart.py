"""Readers whose C libraries crash or hang on a damaged file run in a process of their own, bounded in time and memory.

SciPy's reader of MAT files ended the process on one file in some hundred that were changed at random, and HDF5 did not
return: a report on many campaigns must survive such a file.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from metrology.declaration.columns import Column
from metrology.errors import Fault, MetrologyError
from metrology.readings import formats
from metrology.readings.binding import wanted
from metrology.readings.sheet import Job, Log, Sheet, refused

SECONDS = 120
MEMORY = 6 << 30
"""Address space of the process: HDF5, NumPy and SciPy map about 2 GiB before they read anything."""
FORMATS = ("mat", "hdf5", "mdf4")


def load(job: Job, found: formats.Format, columns: Sequence[Column]) -> Sheet:
    """Read a content by its format, in a process of its own where its library is one of those.

    Raises
    ------
    MetrologyError
        As the reader itself; and for a file at which the process crashed, or did not end in time.
    """
    if found.name not in FORMATS:
        return formats.load(job, found)
    task = pickle.dumps((found.name, job.path, job.content, job.stated, tuple(columns), job.log.where))
    command = [sys.executable, "-P", "-m", "metrology.readings.apart"]
    try:
        done = subprocess.run(command, input=task, capture_output=True, timeout=SECONDS, check=False)  # noqa: S603
    except subprocess.TimeoutExpired:
        raise refused(job.log.where, f"a {found.title} that is not read in {SECONDS} s", "a whole file") from None
    if done.returncode or not done.stdout:
        raise refused(job.log.where, f"a {found.title} that crashes its reader", "a whole file", "copy it again")
    answer = pickle.loads(done.stdout)  # noqa: S301 - written by our own process
    if isinstance(answer, Exception):
        raise answer
    if isinstance(answer[0], Fault):
        raise MetrologyError(*answer)
    sheet, notices, chunks = answer
    for notice in notices:
        job.log.note(notice)
    table: Sheet = replace(sheet, chunks=iter(chunks))
    return table


def main() -> None:
    """Read one task from the standard input, and write the table or the error to the standard output."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    name, path, content, stated, columns, where = pickle.loads(sys.stdin.buffer.read())  # noqa: S301
    log = Log(where)
    job = Job(path, content, stated, wanted(columns, stated), sum(column.required for column in columns), log)
    found = next(one for one in formats.FORMATS if one.name == name)
    answer: object
    try:
        sheet = formats.load(job, found)
        answer = (replace(sheet, chunks=iter(())), tuple(log.notices), list(sheet.chunks))
    except MetrologyError as error:
        answer = error.faults
    except MemoryError:
        answer = ValueError("it states more data than there is memory for")
    except Exception as error:  # noqa: BLE001 - a reader of somebody else's raises what it likes at a damaged file
        answer = ValueError(f"{type(error).__name__}: {error}"[:200])
    sys.stdout.buffer.write(pickle.dumps(answer))
    sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
