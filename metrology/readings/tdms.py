"""TDMS files of LabVIEW and DIAdem: a group's channels with their units, sampling interval and time of start."""

from __future__ import annotations

import logging
from io import BytesIO
from typing import Any

from metrology.readings.sheet import Job, Sheet, refused
from metrology.readings.tables import check_size, of_columns

_UNITS = ("unit_string", "NI_UnitDescription", "unit")


def read(job: Job) -> Sheet:
    """Return the channels of one group: the stated one, or the only one."""
    from nptdms import TdmsFile

    for name in ("reader", "tdms_segment", "types"):
        logging.getLogger(f"nptdms.{name}").addFilter(_refuse)
    file = TdmsFile.read_metadata(BytesIO(job.content))
    groups = [group for group in file.groups() if len(group)]
    name = job.choose("group", [group.name for group in groups], job.stated.group)
    channels = next(group for group in groups if group.name == name).channels()
    check_size(job, sum(len(channel) for channel in channels), len(channels))
    if sum(len(channel) for channel in channels) > len(job.content):
        raise refused(job.log.where, "more values stated than the file has bytes", "a whole TDMS file", "copy it again")
    data = TdmsFile.read(BytesIO(job.content), raw_timestamps=False)[name]
    columns: dict[str, Any] = {one.name: one[:] for one in data.channels() if len(one)}
    units = {
        one.name: str(next((one.properties[key] for key in _UNITS if key in one.properties), "")) for one in channels
    }
    timed = [one.properties for one in channels if one.properties.get("wf_increment")]
    increments = {float(properties["wf_increment"]) for properties in timed}
    step = increments.pop() if len(increments) == 1 else None
    begin = next((properties["wf_start_time"] for properties in timed if "wf_start_time" in properties), "")
    offset = float(timed[0].get("wf_start_offset", 0.0)) if timed else 0.0
    return of_columns(job, columns, units, step=step, start=offset, date=_day(begin))


def _refuse(record: logging.LogRecord) -> bool:
    """Raise what the library would only log: that a file is cut short, or that its text is none."""
    raise ValueError(record.getMessage()[:100])


def _day(stated: Any) -> str:
    """Day of the start, nothing where it is that of an empty time stamp."""
    day = str(stated)[:10]
    return "" if day.startswith(("1903", "1904", "1970")) else day
