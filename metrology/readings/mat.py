"""MAT files: variables of one length as columns; version 5 by SciPy, 7.3 as the HDF5 files that they are."""

from __future__ import annotations

from io import BytesIO
from math import prod
from typing import Any

import numpy as np

from metrology.readings import hdf5
from metrology.readings.arrays import columns_of
from metrology.readings.sheet import Job, Sheet
from metrology.readings.tables import check_size, of_columns


def read(job: Job) -> Sheet:
    """Return the variables as columns, or the columns of one variable."""
    if b"HDF" in job.content[:520] and not job.content.startswith(b"MATLAB 5.0"):
        return hdf5.read(job)
    from scipy.io import loadmat, whosmat

    hdf5.refuse_both(job)
    stream: Any = BytesIO(job.content)
    check_size(job, sum(prod(map(int, shape)) for _, shape, _ in whosmat(stream)))
    stream.seek(0)
    found = {name: one for name, one in loadmat(stream, struct_as_record=True).items() if name[:1] != "_"}
    wanted = job.stated.dataset or job.stated.group
    if wanted is None and len(found) > 1:
        columns = {name: np.ravel(one) for name, one in found.items() if _is_column(one)}
        return of_columns(job, columns)
    name = job.choose("dataset", list(found), wanted)
    one: Any = found[name]
    if one.dtype.names:
        fields = {field: np.ravel(one[field][0, 0]) for field in one.dtype.names}
        return of_columns(job, {field: array for field, array in fields.items() if array.dtype.kind in "fiub"})
    return columns_of(job, one, name)


def _is_column(one: Any) -> bool:
    return one.dtype.kind in "fiub" and one.ndim == 2 and 1 in one.shape and one.size > 1
