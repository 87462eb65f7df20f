"""Reads the folder of a case, for the simple entries: campaign and readings, in SI."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

SCALE = {"um": 1e-6, "mm": 1e-3, "g": 1e-3, "mN": 1e-3, "ms": 1e-3, "%": 1e-2}


@dataclass(frozen=True)
class Record:
    """Readings of one run, release or sequence of loads: columns by heading, SI."""

    name: str
    columns: dict[str, np.ndarray]
    fitted: bool
    settings: dict[str, Any]


@dataclass(frozen=True)
class Campaign:
    """One test of a case."""

    method: str
    test: dict[str, Any]
    records: tuple[Record, ...]

    @property
    def fitted(self) -> list[Record]:
        """Records to fit: runs for identification, all releases but the last; all of an elongation."""
        return [record for record in self.records if record.fitted]

    @property
    def held_out(self) -> list[Record]:
        """The others."""
        return [record for record in self.records if not record.fitted]


def si(text: str) -> float:
    """Value in SI of a quantity such as `24.3(5) mm`: its uncertainty is left aside."""
    number, _, unit = str(text).partition(" ")
    return float(re.sub(r"\(.*?\)", "", number)) * SCALE.get(unit, 1.0)


def columns(file: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV file by the word before the unit; text stays text, empty cells are NaN."""
    with file.open(encoding="utf-8") as lines:
        head, *rows = csv.reader(lines)
    found = {}
    for i, name in enumerate(head):
        word, _, unit = name.partition(" / ")
        cells = [row[i] for row in rows]
        try:
            found[word] = np.array([float(cell) if cell else np.nan for cell in cells]) * SCALE.get(unit, 1.0)
        except ValueError:
            found[word] = np.array(cells)
    return found


def load(folder: str) -> Campaign:
    """The only test of a case."""
    place = Path(folder)
    found = yaml.safe_load((place / "campaign.yaml").read_text(encoding="utf-8"))
    test = next(iter(found["tests"].values()))
    readers = {"response": _response, "decay": _decay, "elongation": _elongation}
    return Campaign(test["method"], test, tuple(readers[test["method"]](place, test)))


def _response(place: Path, test: dict[str, Any]) -> list[Record]:
    found = []
    for name, run in test["runs"].items():
        motion, cell = (columns(place / file) for file in run["readings"])
        every = {"t": motion["time"], "x": motion["x"], "v": motion["v"], "s": cell["time"], "T": cell["T"]}
        found.append(Record(name, every, run.get("purpose", "identification") == "identification", run))
    return found


def _decay(place: Path, test: dict[str, Any]) -> list[Record]:
    found = []
    for i, file in enumerate(test["readings"]):
        read = columns(place / file)
        every = {"t": read["time"], "x": read.get("displacement", read.get("angle"))}
        found.append(Record(file, every, i < len(test["readings"]) - 1, {}))
    return found


def _elongation(place: Path, test: dict[str, Any]) -> list[Record]:
    read = columns(place / test["readings"])
    masses = {name: si(load["mass"]) for name, load in test["loads"].items()}
    force = np.array([masses[name] for name in read["load"]]) * si(test["gravity"]) * (1 - 1.2 / 8000)
    every = {"F": force, "repeat": read["repeat"], "back": read["direction"] == "unloading", "x": read["reading"]}
    return [Record("readings", every, True, {})]
