"""NumPy files: one array in an .npy file, several by name in an .npz file; never Python objects."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Sequence
from typing import Any

import numpy as np

from metrology.readings.sheet import Job, Sampled, Sheet, refused
from metrology.readings.tables import check_size, of_columns


def read(job: Job) -> Sheet:
    """Return the columns of an array, its fields, or the arrays of one length of an .npz file."""
    if job.content.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(job.content)) as archive:
            found = {name.removesuffix(".npy"): _array(job, archive.read(name)) for name in archive.namelist()}
        if job.stated.dataset is None and all(array.ndim == 1 for array in found.values()):
            return of_columns(job, found)
        name = job.choose("dataset", list(found), job.stated.dataset)
        return columns_of(job, found[name], name)
    if job.stated.dataset is not None:
        raise refused(job.log.where, "'dataset' stated for one array", "an .npz file", "leave 'dataset' out")
    return columns_of(job, _array(job, job.content), "1")


def _array(job: Job, raw: bytes) -> Any:
    stream = io.BytesIO(raw)
    version = np.lib.format.read_magic(stream)
    header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, kind = header(stream)
    if kind.hasobject:
        raise refused(job.log.where, "an array of Python objects, which run code when they are read", "numbers")
    if math.prod(shape) * kind.itemsize > len(raw):
        raise refused(job.log.where, "a damaged or truncated NumPy file", "a whole one", "copy the file again")
    return np.load(io.BytesIO(raw), allow_pickle=False)


def columns_of(job: Job, array: Any, name: str, *, units: Sequence[str] = (), sampled: Sampled | None = None) -> Sheet:
    """The columns of one array: its fields, or numbered from 1, along its longer side.

    `units`: none, one for all columns or one each, as the metadata of the array have them; `sampled` is of all.
    """
    columns = _columns(job, array, name)
    if len(units) not in (0, 1, len(columns)):
        raise refused(job.log.where, f"{len(units)} units of {len(columns)} columns in '{name}'", "one, or one each")
    each = units if len(units) == len(columns) else [*units] * len(columns) or [""] * len(columns)
    return of_columns(job, columns, dict(zip(columns, each, strict=True)), sampled=dict.fromkeys(columns, sampled))


def _columns(job: Job, array: Any, name: str) -> dict[str, Any]:
    if array.dtype.names:
        return {field: array[field] for field in array.dtype.names}
    check_size(job, array.size)
    flat = np.squeeze(array)
    if flat.ndim == 1:
        return {name: flat}
    if flat.ndim != 2:
        raise refused(job.log.where, f"an array of shape {array.shape}", "columns of numbers")
    across = flat.T if flat.shape[0] < flat.shape[1] else flat
    return {str(index + 1): across[:, index] for index in range(across.shape[1])}
