"""Tables out of what libraries return: arrays by name, or rows of cells of any kind."""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import isfinite
from typing import Any

import numpy as np

from metrology.readings.sheet import MAX_COLUMNS, MAX_VALUES, Cells, Chunk, Heading, Job, Sampled, Sheet, refused
from metrology.units.dimensions import quoted


def check_size(job: Job, values: int, columns: int = 1) -> None:
    """Refuse a table of more numbers than are read, before memory is taken for them."""
    if columns > MAX_COLUMNS:
        raise refused(job.log.where, f"{columns} columns", f"at most {MAX_COLUMNS}")
    if values > MAX_VALUES:
        raise refused(job.log.where, f"{values} numbers", f"at most {MAX_VALUES}", "lower the rate, or split the file")


def of_columns(
    job: Job,
    columns: Mapping[str, Any],
    units: Mapping[str, str] | None = None,
    *,
    sampled: Mapping[str, Sampled | None] | None = None,
    date: str = "",
) -> Sheet:
    """A table of arrays of one length by name; rows are counted from 1, as such files have no lines.

    `units` and `sampled`: what the file says of a column, by its name.
    """
    arrays = {name: np.asarray(column) for name, column in columns.items()}
    lengths = {name: len(array) for name, array in arrays.items() if array.ndim == 1}
    if len(lengths) < len(arrays):
        wrong = next(name for name in arrays if name not in lengths)
        raise refused(job.log.where, f"'{wrong}', an array of shape {arrays[wrong].shape}", "a column of numbers")
    count = max(lengths.values(), default=0)
    # Channels of other lengths, sampled at another rate, are passed over where they are not asked for.
    used = [name for name in arrays if job.wanted([Heading(name)])] or list(arrays)
    if len({lengths[name] for name in used}) > 1:
        listed = ", ".join(f"'{name}': {lengths[name]}" for name in used[:6])
        raise refused(
            job.log.where, f"columns of several lengths, {listed}", "columns of one length in an entry of readings"
        )
    count = lengths[used[0]] if used else count
    kept = {name: array for name, array in arrays.items() if lengths[name] == count}
    check_size(job, count * len(kept), len(kept))
    headings = [Heading(name, (units or {}).get(name, "").strip(), (sampled or {}).get(name)) for name in kept]
    chunk: Chunk = ([_cells(array) for array in kept.values()], np.arange(1, count + 1, dtype=np.int64))
    return Sheet(headings, iter([chunk] if count else []), 0, date=date)


def seconds(job: Job, name: str, stated: Any, key: str) -> Fraction:
    """A time that the metadata of a column state, as the decimal fraction that it is written as.

    Raises
    ------
    MetrologyError
        Where it is no finite number.
    """
    try:
        value = float(stated)
    except (TypeError, ValueError):
        value = float("nan")
    if not isfinite(value):
        fix = "leave it out of the file, and state 'time' in the campaign file"
        raise refused(f"{job.log.where} {name}", f"{quoted(str(stated))} as '{key}'", "a number of seconds", fix)
    return Fraction(repr(value))


def _cells(array: Any) -> Cells:
    """Numbers as doubles; texts, instants and anything else as texts."""
    if array.dtype.kind in "fiub":
        return np.asarray(array, dtype=np.float64)
    if array.dtype.kind == "M":
        return instants(array)
    if array.dtype.kind == "m":
        return [_clock(one) for one in array.astype("timedelta64[ns]").astype(np.int64).tolist()]
    return [written(one) for one in array.tolist()]


def instants(array: Any) -> list[str]:
    """Days with times of day, to the microsecond, or finer where the array is."""
    finer = np.datetime_data(array.dtype)[0] in ("ns", "ps", "fs", "as")
    return [str(one).replace("T", " ") for one in (array if finer else array.astype("datetime64[us]"))]


def written(cell: Any) -> str:
    """A cell as text: a whole number without a point, an instant with its day, nothing where it is empty."""
    match cell:
        case None:
            return ""
        case bytes():
            return cell.decode("utf-8", "replace").strip()
        case bool():
            return str(cell).lower()
        case float():
            return str(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else repr(cell)
        case dt.datetime():
            return cell.isoformat(" ")
        case dt.timedelta():
            return _clock(1000 * (cell // dt.timedelta(microseconds=1)))
    return str(cell).strip()


def _clock(span: int) -> str:
    """A time of day, or a span of less than a hundred hours, in nanoseconds, as ``hh:mm:ss.fffffffff``."""
    whole, part = divmod(abs(span), 10**9)
    return f"{'-' * (span < 0)}{whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}.{part:09d}"


def of_rows(rows: Sequence[Sequence[Any]]) -> Iterator[tuple[int, list[str]]]:
    """Rows of cells as texts, each with its number from 1; those without a cell are left out."""
    for number, row in enumerate(rows, start=1):
        cells = [written(cell) for cell in row]
        if any(cells):
            yield number, cells
