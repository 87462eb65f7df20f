"""TDMS files of LabVIEW and DIAdem: a group's channels with their units, sampling interval and time of start."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any

from metrology.readings.sheet import Job, Sampled, Sheet, refused
from metrology.readings.tables import check_size, of_columns, seconds

_UNITS = ("unit_string", "NI_UnitDescription", "unit")
_LOGGERS = ("reader", "tdms_segment", "types")


def read(job: Job) -> Sheet:
    """Return the channels of one group: the stated one, or the only one."""
    with _strict(job):
        return _read(job)


def _read(job: Job) -> Sheet:
    from nptdms import TdmsFile

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
    sampled = {one.name: _sampled(job, one) for one in channels}
    begin = next((one.since for one in sampled.values() if one and one.since), "")
    return of_columns(job, columns, units, sampled=sampled, date=_day(begin))


def _sampled(job: Job, channel: Any) -> Sampled | None:
    """When a channel was sampled (NI, waveform attributes); None where it does not say it."""
    said = channel.properties
    if not said.get("wf_increment"):
        return None
    step, start = (seconds(job, channel.name, said.get(key, 0.0), key) for key in ("wf_increment", "wf_start_offset"))
    return Sampled(step, start, str(said.get("wf_start_time", "")))


@contextmanager
def _strict(job: Job) -> Iterator[None]:
    """Raise what the library would only log: that a file is cut short, or that its text is none.

    For what this thread reads, and no longer: the program that reads may use the library itself.
    """
    here = threading.get_ident()

    def refuse(record: logging.LogRecord) -> bool:
        if record.thread == here:
            got = f"a TDMS file that cannot be read ({record.getMessage()[:100]})"
            raise refused(job.log.where, got, "a whole file", "copy it again")
        return True

    loggers = [logging.getLogger(f"nptdms.{name}") for name in _LOGGERS]
    for logger in loggers:
        logger.addFilter(refuse)
    try:
        yield
    finally:
        for logger in loggers:
            logger.removeFilter(refuse)


def _day(stated: Any) -> str:
    """Day of the start, nothing where it is that of an empty time stamp."""
    day = str(stated)[:10]
    return "" if day.startswith(("1903", "1904", "1970")) else day
