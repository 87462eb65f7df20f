"""Universal files of type 58, as modal analysers write them: one function over time a record."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from metrology import units
from metrology.readings.headings import spelled
from metrology.readings.sheet import Heading, Job, Sampled, Sheet, refused
from metrology.readings.tables import check_size, of_columns, seconds
from metrology.units.dimensions import TextError, quoted

_TIME, _UNEVEN = 1, 0
_OVER_TIME = (0, 1, 17)
"""Specific data types of an abscissa that may be time: unknown, general, time."""
_WORDS = {8: "position", 11: "velocity", 12: "acceleration", 13: "force", 2: "strain", 9: "force", 15: "pressure"}
"""Specific data types of the ordinate (dataset 58, record 8)."""


def read(job: Job) -> Sheet:
    """Return the record that is stated, by number or name, or all records over time; each says when it was sampled."""
    sets = _sets(job)
    names = _names(sets)
    if job.stated.channel is not None:
        sets = [_chosen(job, sets, names)]
        names = [_ordinate(sets[0])]
    records = dict(zip(names, sets, strict=True))
    used = {name: one for name, one in records.items() if job.wanted([Heading(name)])} or records
    columns: dict[str, Any] = {name: np.real(one["data"]) for name, one in records.items()}
    of_file = {name: _unit(str(one.get("ordinate_axis_units_lab", ""))) for name, one in records.items()}
    if any(_is_uneven(one) for one in used.values()):
        stamps, unit = _stamps(job, used)
        return of_columns(job, {"time": stamps, **columns}, {"time": unit, **of_file})
    return of_columns(job, columns, of_file, sampled={name: _sampled(job, name, one) for name, one in used.items()})


def _is_uneven(one: dict[str, Any]) -> bool:
    return bool(one.get("abscissa_spacing") == _UNEVEN)


def _sampled(job: Job, name: str, one: dict[str, Any]) -> Sampled:
    """When a record of even spacing was sampled: its increment and its start are in the unit of its abscissa."""
    factor = units.unit(_unit_of_time(job, name, one)).factor
    step, start = (seconds(job, name, one.get(key, 0.0), key) for key in ("abscissa_inc", "abscissa_min"))
    return Sampled(step * factor, start * factor)


def _stamps(job: Job, used: dict[str, dict[str, Any]]) -> tuple[Any, str]:
    """The stamps that all records have which are used, and their unit."""
    (first, one), *others = used.items()
    stamps, unit = np.asarray(one["x"], dtype=np.float64), _unit_of_time(job, first, one)
    for name, other in others:
        same = _is_uneven(one) and _is_uneven(other) and np.array_equal(stamps, other["x"])
        if not same or _unit_of_time(job, name, other) != unit:
            fix = "read each by an entry of its own, with its 'channel'"
            got = f"'{first}' and '{name}' on stamps of their own"
            raise refused(job.log.where, got, "records on the same stamps in an entry of readings", fix)
    return stamps, unit


def _unit_of_time(job: Job, name: str, one: dict[str, Any]) -> str:
    """Unit of the abscissa; seconds where the file names none.

    Raises
    ------
    MetrologyError
        Where it is no time.
    """
    label, kind = _unit(str(one.get("abscissa_axis_units_lab", ""))), int(one.get("abscissa_spec_data_type", 0))
    unit = "s" if label in ("", "S") else spelled(label)  # in capitals from older analysers; none counts in siemens
    with suppress(TextError):
        if kind in _OVER_TIME and units.dimension(unit) == units.dimension("s"):
            return unit
    axis = str(one.get("abscissa_axis_lab", "")).strip()
    got = f"a record over {quoted(axis)} in {quoted(label)} (specific data type {kind})"
    expected = "one over time, in a unit such as s or ms"
    raise refused(f"{job.log.where} {name}", got, expected, "state the 'channel' of a record over time")


def _sets(job: Job) -> list[dict[str, Any]]:
    import pyuff

    # The library reads from a path only.
    with tempfile.TemporaryDirectory(prefix="metrology-") as folder:
        path = Path(folder) / "readings.uff"
        path.write_bytes(job.content)
        file = pyuff.UFF(str(path))
        kinds = [int(kind) for kind in file.get_set_types()]
        found = [file.read_sets(index) for index, kind in enumerate(kinds) if kind == 58]
    found = [one for one in found if int(one.get("func_type", 0)) in (0, _TIME)]
    if not found:
        raise refused(job.log.where, "no dataset 58 with a response over time", "one at least")
    check_size(job, sum(len(one["data"]) for one in found), len(found))
    return found


def _ordinate(one: dict[str, Any]) -> str:
    """What is recorded, by its label or its type."""
    label = str(one.get("ordinate_axis_lab", "")).strip()
    kind = _WORDS.get(int(one.get("ordinate_spec_data_type", 0)), "")
    return label if label and label.upper() != "NONE" else kind or str(one.get("id1", "")).strip() or "record"


def _names(sets: list[dict[str, Any]]) -> list[str]:
    """A name for each record, no two alike: those of a second node or direction have its number."""
    names: list[str] = []
    for one in sets:
        name, count = _ordinate(one), 1
        while (found := name if count == 1 else f"{name} {count}") in names:
            count += 1
        names.append(found)
    return names


def _chosen(job: Job, sets: list[dict[str, Any]], names: list[str]) -> dict[str, Any]:
    stated = str(job.stated.channel)
    if stated.isdecimal() and 1 <= int(stated) <= len(sets):
        return sets[int(stated) - 1]
    return sets[names.index(job.choose("channel", names, stated))]


def _unit(text: str) -> str:
    plain = text.strip()
    return "" if plain.upper() == "NONE" else plain
