"""Parquet files: columns by name, units out of the metadata of the columns."""

from __future__ import annotations

from typing import Any

from metrology.readings.sheet import Job, Sheet
from metrology.readings.tables import check_size, of_columns


def read(job: Job) -> Sheet:
    """Return the columns of the table."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    source = pa.BufferReader(job.content)
    file = pq.ParquetFile(source)
    check_size(job, file.metadata.num_rows * file.metadata.num_columns, file.metadata.num_columns)
    table = file.read(use_threads=False)
    columns = {name: _values(table.column(name)) for name in table.column_names}
    units = {one.name: ((one.metadata or {}).get(b"unit") or b"").decode("utf-8", "replace") for one in table.schema}
    return of_columns(job, columns, units)


def _values(column: Any) -> Any:
    return column.to_numpy(zero_copy_only=False)
