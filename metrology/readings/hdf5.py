"""HDF5 files: datasets of a group, or one dataset; nothing that lies in another file is followed."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np

from metrology.readings.arrays import columns_of
from metrology.readings.sheet import Heading, Job, Sampled, Sheet, refused
from metrology.readings.tables import check_size, of_columns, seconds

MAX_OBJECTS = 2000
_UNITS = ("units", "unit", "Unit", "Units")
_STEPS = ("dt", "wf_increment", "step")


def read(job: Job) -> Sheet:
    """Return one dataset's columns, or the datasets of a group as columns."""
    import h5py

    refuse_both(job)
    with h5py.File(BytesIO(job.content), "r") as file:
        if job.stated.dataset is not None:
            return _of_dataset(job, _at(job, file, job.stated.dataset), job.stated.dataset)
        group = _at(job, file, job.stated.group) if job.stated.group else file
        if not isinstance(group, h5py.Group):
            return _of_dataset(job, group, str(job.stated.group))
        return _of_group(job, group if _datasets(job, group) else _inner(job, file))


def refuse_both(job: Job) -> None:
    """Refuse a group beside a dataset, of which one would be passed over."""
    if job.stated.group is not None and job.stated.dataset is not None:
        fix = f"state the whole path: 'dataset: {job.stated.group}/{job.stated.dataset}'"
        raise refused(job.log.where, "'group' and 'dataset' together", "one of the two", fix)


def _at(job: Job, file: Any, path: str) -> Any:
    """Object of a path, link by link, so that one that leads out of the file is seen before it is followed."""
    found = file
    for name in [part for part in path.split("/") if part]:
        if not hasattr(found, "keys") or name not in found.keys():  # noqa: SIM118 - `in` would follow the link
            known = ", ".join(list(found.keys())[:12]) if hasattr(found, "keys") else "a group"
            raise refused(job.log.where, f"no '{path}'", f"a path in it, such as {known}")
        found = _member(job, found, name)
    return found


def _member(job: Job, group: Any, name: str) -> Any:
    import h5py

    link = group.get(name, getlink=True)
    if isinstance(link, h5py.ExternalLink):
        raise refused(
            job.log.where, f"'{name}', a link to another file", "data in the file itself", "copy them into it"
        )
    if isinstance(link, h5py.SoftLink):
        raise refused(
            job.log.where, f"'{name}', a soft link to '{link.path}'", "the path itself", f"state '{link.path}'"
        )
    found = group[name]
    if isinstance(found, h5py.Dataset) and (found.external or found.is_virtual):
        got = f"'{name}', whose data lie in another file"
        raise refused(job.log.where, got, "data in the file itself", "copy them into it")
    return found


def _datasets(job: Job, group: Any) -> dict[str, Any]:
    import h5py

    if len(group) > MAX_OBJECTS:
        raise refused(job.log.where, f"{len(group)} objects in a group", f"at most {MAX_OBJECTS}")
    hard = [name for name in group.keys() if isinstance(group.get(name, getlink=True), h5py.HardLink)]  # noqa: SIM118
    found = {name: group[name] for name in hard}
    return {name: one for name, one in found.items() if isinstance(one, h5py.Dataset)}


def _inner(job: Job, file: Any) -> Any:
    """The only group that has datasets, where the file itself has none."""
    import h5py

    for name in list(file.keys())[:MAX_OBJECTS]:
        _member(job, file, name)
    found = [name for name in file if isinstance(file[name], h5py.Group) and _datasets(job, file[name])]
    return file[job.choose("group", found, None)]


def _of_group(job: Job, group: Any) -> Sheet:
    columns = {name: _member(job, group, name) for name in _datasets(job, group)}
    for name in group.keys():  # noqa: SIM118
        if not columns or job.wanted([Heading(name)]):
            _member(job, group, name)
    check_size(job, sum(one.size for one in columns.values()))
    if len(columns) == 1:
        ((name, only),) = columns.items()
        return _of_dataset(job, only, name)
    flat = {name: one for name, one in columns.items() if one.ndim == 1 or (one.ndim == 2 and 1 in one.shape)}
    units = {name: "".join(_attribute(one, _UNITS)[:1]) for name, one in flat.items()}
    sampled = {name: _sampled(job, name, one) for name, one in flat.items()}
    return of_columns(job, {name: one[()].ravel() for name, one in flat.items()}, units, sampled=sampled)


def _of_dataset(job: Job, dataset: Any, name: str) -> Sheet:
    if not hasattr(dataset, "shape"):
        raise refused(job.log.where, f"'{name}', a group", "a dataset", f"state 'group: {name}'")
    check_size(job, dataset.size)
    plain = name.rpartition("/")[2]
    sampled = _sampled(job, plain, dataset)
    return columns_of(job, dataset[()], plain, units=_attribute(dataset, _UNITS), sampled=sampled)


def _sampled(job: Job, name: str, dataset: Any) -> Sampled | None:
    """When a dataset was sampled, by an attribute of its own or of the group in which it lies."""
    for key in _STEPS:
        for holder in (dataset, dataset.parent):
            if found := _attribute(holder, (key,)):
                return Sampled(seconds(job, name, found[0] if len(found) == 1 else found, key))
    return None


def _attribute(holder: Any, names: tuple[str, ...]) -> list[str]:
    """What the first of these attributes holds, as texts: one, or one for each column; none where there is none."""
    found = next((holder.attrs[name] for name in names if name in holder.attrs), None)
    texts = [] if found is None else np.ravel(np.asarray(found)).tolist()
    return [one.decode("utf-8", "replace") if isinstance(one, bytes) else str(one) for one in texts]
