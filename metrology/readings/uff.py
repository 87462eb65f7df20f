"""Universal files of type 58, as modal analysers write them: one function over time a record."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from metrology.readings.sheet import Job, Sheet, refused
from metrology.readings.tables import check_size, of_columns

_TIME, _UNEVEN = 1, 0
_WORDS = {8: "position", 11: "velocity", 12: "acceleration", 13: "force", 2: "strain", 9: "force", 15: "pressure"}
"""Specific data types of the ordinate (dataset 58, record 8)."""


def read(job: Job) -> Sheet:
    """Return the record that is stated, by number or name, or all records over time on the same stamps."""
    sets = _sets(job)
    names = _names(sets)
    if job.stated.channel is not None:
        sets = [_chosen(job, sets, names)]
        names = [_ordinate(sets[0])]
    columns: dict[str, Any] = {}
    step = float(sets[0].get("abscissa_inc", 0.0)) if sets[0].get("abscissa_spacing") != _UNEVEN else None
    if step is None:
        columns["time"] = np.asarray(sets[0]["x"], dtype=np.float64)
    units = {"time": str(sets[0].get("abscissa_axis_units_lab", "")).strip() or "s"}
    for name, one in zip(names, sets, strict=True):
        columns[name] = np.real(one["data"])
        units[name] = _unit(str(one.get("ordinate_axis_units_lab", "")))
    return of_columns(job, columns, units, step=step, start=float(sets[0].get("abscissa_min", 0.0)))


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
