"""NumPy files: one array in an .npy file, several by name in an .npz file; never Python objects."""

from __future__ import annotations

import io
import math
import zipfile
from typing import Any

import numpy as np

from metrology.readings.sheet import Job, Sheet, refused
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


def columns_of(job: Job, array: Any, name: str) -> Sheet:
    """The columns of one array: its fields, or numbered from 1, along its longer side."""
    if array.dtype.names:
        return of_columns(job, {field: array[field] for field in array.dtype.names})
    check_size(job, array.size)
    flat = np.squeeze(array)
    if flat.ndim == 1:
        return of_columns(job, {name: flat})
    if flat.ndim != 2:
        raise refused(job.log.where, f"an array of shape {array.shape}", "columns of numbers")
    across = flat.T if flat.shape[0] < flat.shape[1] else flat
    return of_columns(job, {str(index + 1): across[:, index] for index in range(across.shape[1])})
