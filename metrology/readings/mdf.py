"""MDF4 files of measuring computers: channels of a group with their units; asammdf is an extra of its own, `mdf`."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from metrology.readings.sheet import Job, Sheet
from metrology.readings.tables import check_size, of_columns


def read(job: Job) -> Sheet:
    """Return the channels of one group: the stated one by its number or name, or the only one."""
    from asammdf import MDF

    with MDF(BytesIO(job.content)) as file:
        groups: list[Any] = list(file.groups)
        names = [group.channel_group.acq_name or str(index + 1) for index, group in enumerate(groups)]
        index = names.index(job.choose("group", names, job.stated.group))
        cycles, channels = groups[index].channel_group.cycles_nr, groups[index].channels
        check_size(job, cycles * len(channels), len(channels))
        columns: dict[str, Any] = {}
        units: dict[str, str] = {}
        for at in range(len(channels)):
            signal = file.get(group=index, index=at)
            columns[signal.name], units[signal.name] = signal.samples, signal.unit
        date = str(file.header.start_time)[:10]
    return of_columns(job, columns, units, date=date)
