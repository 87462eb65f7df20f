"""From a file of readings to its table in SI, whatever its format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from metrology.declaration.columns import Column, Table, source_file
from metrology.declaration.readings import Readings
from metrology.readings import apart, formats
from metrology.readings.binding import Binder, count
from metrology.readings.packed import MAX_BYTES, limited, stored, unpacked
from metrology.readings.sheet import Job, Log

__all__ = ["MAX_BYTES", "read"]


def read(
    path: Path,
    columns: Sequence[Column],
    *,
    others: bool = False,
    stated: Readings | None = None,
    raw: bytes | None = None,
) -> Table:
    """Read a file that has the stated columns.

    Parameters
    ----------
    path : Path
        Of any format of `metrology.readings.formats`, also gzipped or in an archive; at most 64 MiB unpacked.
    columns : sequence of Column
        In any order.
    others : bool
        Whether the file may have further columns, which are passed over.
    stated : Readings, optional
        How the file is to be read; found in it where nothing is said.
    raw : bytes, optional
        Its content, of a file that lies nowhere.

    Raises
    ------
    MetrologyError
        With the line of each fault, the first 20 of them.
    """
    stated = stated or Readings.model_validate(path.name)
    raw = stored(path) if raw is None else limited(path, raw)
    source = source_file(path.name, raw)
    content, name = unpacked(path, raw, stated.member)
    shown = path if not stated.part else Path(f"{path} [{stated.part}]")
    due = sum(column.required for column in columns)
    job = Job(path, content, stated, partial(count, tuple(columns), stated), due, Log(str(shown)))
    found = formats.recognise(job, name)
    with apart.readable(str(shown), found):
        sheet = apart.load(job, found)
        return Binder(columns, stated, job.log, others=others).read(sheet, shown, source)


def renamed(table: Table, path: str) -> Table:
    """The table with the path of its file from the campaign's folder."""
    return replace(table, source=replace(table.source, path=path))
