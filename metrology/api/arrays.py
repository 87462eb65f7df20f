"""Readings as arrays: tables of NumPy, pandas or xarray within a dictionary, written as the CSV files of a campaign."""

from __future__ import annotations

import csv
import datetime as dt
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from typing import Any

from metrology.errors import Fault, MetrologyError

Place = tuple[str | int, ...]
Columns = list[tuple[str, Any]]
TABLE = "a table of columns of one length, such as {'time / s': array, 'displacement / mm': array}"


@dataclass
class Handed:
    """What is taken out of a dictionary: the content of every table by the name of its file, and where each stood."""

    taken: set[str]
    contents: dict[str, bytes] = field(default_factory=dict)
    places: dict[str, Place] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    def of(self, value: Any, place: Place = ()) -> Any:
        """The value as a campaign file can hold it: every table in it is the name of a file."""
        if (columns := _columns(value)) is not None:
            return self._file(columns, place)
        if isinstance(value, Mapping):
            return {str(key): self.of(entry, (*place, str(key))) for key, entry in value.items()}
        if isinstance(value, list | tuple):
            return [self.of(entry, (*place, index)) for index, entry in enumerate(value)]
        if getattr(value, "ndim", 0):
            self.faults.append(Fault(spelled(place), f"an array of shape {value.shape} alone", TABLE))
            return ""
        if isinstance(value, Path):
            return value.as_posix()
        return value.item() if hasattr(value, "item") else value

    def _file(self, columns: Columns, place: Place) -> str:
        name = self._name(place)
        self.places[name] = place
        cells = [self._cells(column, (*place, heading)) for heading, column in columns]
        read = [(heading, one) for (heading, _), one in zip(columns, cells, strict=True) if one is not None]
        if len({len(one) for _, one in read}) > 1:
            sizes = ", ".join(f"'{heading}': {len(one)}" for heading, one in read)
            self.faults.append(Fault(spelled(place), f"columns of several lengths, {sizes}", "columns of one length"))
        if not self.faults:
            stream = StringIO(newline="")
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow([heading for heading, _ in read])
            writer.writerows(zip(*(one for _, one in read), strict=True))
            self.contents[name] = stream.getvalue().encode()
        return name

    def _name(self, place: Place) -> str:
        """A name of a file that no text of the dictionary has: ``pull.csv`` for the readings of the test pull."""
        parts = [str(key + 1) if isinstance(key, int) else key for key in place if key not in ("tests", "readings")]
        plain = re.sub(r"[^\w-]+", "-", "-".join(parts)) or "readings"
        names = (f"{plain}{f'-{count}' if count else ''}.csv" for count in range(len(self.taken) + 1))
        name = next(name for name in names if name not in self.taken)
        self.taken.add(name)
        return name

    def _cells(self, column: Any, place: Place) -> list[str] | None:
        """The cells of a column at full precision, an empty one for NaN; None where it is no column of readings."""
        import numpy as np

        from metrology.readings.tables import instants, written

        array, where = _array(column), spelled(place)
        if array is None:
            got, fix = "an array with a unit of its own", "hand over its numbers, with the unit in the heading"
            self.faults.append(Fault(where, got, "numbers or texts", fix))
        elif array.ndim != 1:
            self.faults.append(Fault(where, f"an array of shape {array.shape}", "a column, of shape (n,)"))
        elif array.dtype.kind == "M":
            return instants(array)
        elif array.dtype.kind in "fiu":
            numbers = array.astype(np.float64)
            self._refuse(where, np.isinf(numbers), numbers)
            return ["" if one != one else written(one) for one in numbers.tolist()]
        elif array.dtype.kind in "OUT":
            self._refuse(where, np.array([not isinstance(one, str) for one in array], dtype=bool), array)
            return [str(one) for one in array]
        else:
            fix = "divide a time span by np.timedelta64(1, 's')" if array.dtype.kind == "m" else ""
            self.faults.append(Fault(where, f"an array of type {array.dtype}", "numbers or texts", fix))
        return None

    def _refuse(self, where: str, wrong: Any, array: Any) -> None:
        """Name the first element that is wrong, and how many there are."""
        if not wrong.any():
            return
        at, count = int(wrong.argmax()), int(wrong.sum())
        more = f" and {count - 1} more such" if count > 1 else ""
        if array.dtype.kind == "O":
            got, fix = f"{array[at]!r:.60}{more} in an array of type object", "numbers: array.astype(float)"
            self.faults.append(Fault(f"{where}[{at}]", got, "numbers alone (float, int), or texts alone", fix))
        else:
            self.faults.append(Fault(f"{where}[{at}]", f"{array[at]}{more}", "finite numbers", "a gap is NaN"))


def taken_out(stated: Mapping[str, Any]) -> tuple[dict[str, Any], Handed]:
    """A dictionary without its arrays, and those as files.

    Raises
    ------
    MetrologyError
        For everything in the tables that no file of readings can hold.
    """
    handed = Handed(set(_texts(stated)))
    plain = handed.of(stated)
    if handed.faults:
        raise MetrologyError(*handed.faults)
    return plain, handed


def of_arrays(error: MetrologyError, handed: Handed) -> MetrologyError:
    """The same faults by index, and without names of files: line 2 of the file of a table is its element 0."""
    return MetrologyError(*(_by_index(fault, handed) for fault in error.faults))


def _by_index(fault: Fault, handed: Handed) -> Fault:
    # The file is one that nobody wrote: the path of the entry says where it stands in the dictionary.
    fault = replace(fault, where=re.sub(r"^(?:.*[/\\])?campaign\.yaml:\d+:\d+ ", "", fault.where))
    for name, place in handed.places.items():
        if fault.got == f"'{name}'":
            return replace(fault, got="one table")
        if match := re.match(rf"(?:.*[/\\])?{re.escape(name)}(?::(\d+))?(?= |$)", fault.where):
            index = f"[{int(match[1]) - 2}]" if match[1] and int(match[1]) > 1 else ""
            return replace(fault, where=f"{spelled(place)}{index}{fault.where[match.end() :]}")
    return fault


def spelled(place: Place) -> str:
    """A place as Python writes it: ``tests.pull.readings['reading / mm']``."""
    shown = (f".{key}" if isinstance(key, str) and re.fullmatch(r"[\w-]+", key) else f"[{key!r}]" for key in place)
    return "".join(shown).removeprefix(".")


def _texts(value: Any) -> Iterator[str]:
    """Every text of a dictionary, among which the names of its files are."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for entry in value.values():
            yield from _texts(entry)
    elif isinstance(value, list | tuple):
        for entry in value:
            yield from _texts(entry)


def _columns(value: Any) -> Columns | None:
    """Columns of a table, each with its heading; None for everything that is no table."""
    pandas, xarray = sys.modules.get("pandas"), sys.modules.get("xarray")
    if pandas is not None and isinstance(value, pandas.DataFrame):
        named = value.reset_index() if any(name is not None for name in value.index.names) else value
        return [(str(name), named.iloc[:, at]) for at, name in enumerate(named.columns)]
    if xarray is not None and isinstance(value, xarray.DataArray) and value.ndim == 1 and value.name and value.coords:
        value = value.to_dataset()
    if xarray is not None and isinstance(value, xarray.Dataset):
        return [(_heading(name, one), one) for name, one in value.variables.items() if one.ndim or name in value]
    if names := getattr(getattr(value, "dtype", None), "names", None):
        return [(name, value[name]) for name in names]
    if not isinstance(value, Mapping) or not all(isinstance(o, list | tuple) or _is_column(o) for o in value.values()):
        return None
    # No key of a campaign file has a unit: lists below one are columns too.
    is_table = any(_is_column(one) or " / " in str(name) for name, one in value.items())
    return [(_heading(name, one), one) for name, one in value.items()] if is_table else None


def _is_column(value: Any) -> bool:
    return getattr(value, "ndim", 0) > 0 and not hasattr(value, "columns") and not hasattr(value, "data_vars")


def _heading(name: Any, column: Any) -> str:
    """The heading of a variable of xarray: with the unit of its attributes where it has none."""
    unit = getattr(column, "attrs", {}).get("units", "") if hasattr(column, "dims") else ""
    return f"{name} / {unit}" if unit and "/" not in str(name) else str(name)


def _array(column: Any) -> Any:
    """A column as an array; None where that would drop a unit."""
    import numpy as np

    package = type(column).__module__.partition(".")[0]
    if package not in ("pandas", "xarray") and (hasattr(column, "units") or hasattr(column, "unit")):
        return None
    if getattr(getattr(column, "dtype", None), "kind", "O") in "fiu":
        if package == "pandas":
            return column.to_numpy(dtype=float, na_value=np.nan)
        if np.ma.isMaskedArray(column):
            return np.ma.filled(column.astype(np.float64), np.nan)
    if getattr(getattr(column, "dtype", None), "tz", None) is not None:
        return column.to_numpy(dtype="datetime64[ns]")  # in UTC, as pandas says
    array = np.asarray(column)
    return _of_objects(array) if array.dtype.kind == "O" and array.ndim == 1 else array


def _of_objects(array: Any) -> Any:
    """Numbers, texts or instants (those of a time zone in UTC) among which some are missing; else what it was."""
    import numpy as np

    missing = [one is None or type(one).__name__ in ("NAType", "NaTType") for one in array]
    there = [one for one, gap in zip(array, missing, strict=True) if not gap]
    if there and all(isinstance(one, dt.datetime) for one in there) and len({one.tzinfo is None for one in there}) == 1:
        plain = [one.astimezone(dt.UTC).replace(tzinfo=None) if one.tzinfo else one for one in there]
        return np.array(_filled(plain, missing, None), dtype="datetime64[us]")
    if any(missing) and all(isinstance(one, str) for one in there):
        return np.array(_filled(there, missing, ""), dtype=object)
    if any(missing) and all(isinstance(one, int | float | np.number) and not isinstance(one, bool) for one in there):
        return np.array(_filled(there, missing, np.nan), dtype=float)
    return array


def _filled(there: list[Any], missing: list[bool], gap: Any) -> list[Any]:
    rest = iter(there)
    return [gap if one else next(rest) for one in missing]
