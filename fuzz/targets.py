"""What is fuzzed: every reader of what comes from outside. A refusal in our words is right, another error is a find."""

from __future__ import annotations

import gzip
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from metrology import units
from metrology.campaign.load import load
from metrology.declaration.columns import Column
from metrology.errors import MetrologyError
from metrology.expression import Expression
from metrology.findings import from_json
from metrology.methods.decay import TIME
from metrology.methods.elongation import COLUMNS as ELONGATION
from metrology.readings.files import read
from metrology.signoff.opened import open_report
from metrology.signoff.verification import verify
from metrology.units.dimensions import TextError
from metrology.units.symbols import UnitError

HOME = Path(tempfile.mkdtemp(prefix="metrology-fuzz-"))
NAMES = {name: units.dimension(unit) for name, unit in (("k", "N/m"), ("L", "m"), ("A", "m^2"), ("p", "1"))}

DECAY = (TIME, Column("displacement", "m", varies=True))


def _file(name: str, content: bytes) -> Path:
    path = HOME / name
    path.write_bytes(content)
    return path


def campaign(data: bytes) -> None:
    """A campaign file, with readings beside it."""
    _file("r.csv", b"V / V,I / mA\n5.0,19.6\n4.9,19.7\n5.1,19.5\n")
    with suppress(MetrologyError):
        load(_file("campaign.yaml", data))


def quantity(data: bytes) -> None:
    """The text of a quantity."""
    try:
        read_quantity = units.parse(data.decode("utf-8", "replace"))
    except UnitError:
        return
    assert read_quantity.u is None or read_quantity.u > 0


def expression(data: bytes) -> None:
    """A model equation: its steps, its dimension, its value."""
    try:
        equation = Expression.parse(data.decode("utf-8", "replace"))
        equation.dimension(NAMES)
        equation.evaluate(dict.fromkeys(NAMES, 1.5))
    except TextError:
        return


def readings(data: bytes) -> None:
    """A file of readings, with words or as a time series."""
    for columns in (ELONGATION, DECAY):
        with suppress(MetrologyError):
            read(_file("a.csv", data), columns)


def packed(data: bytes) -> None:
    """Likewise gzipped: as it is, and as the content of a whole file."""
    for content in (data, gzip.compress(data, 1)):
        with suppress(MetrologyError):
            read(_file("a.csv.gz", content), DECAY)


def formats(data: bytes) -> None:
    """A file of readings of any format, by its first bytes."""
    with suppress(MetrologyError):
        read(_file("a.dat", data), DECAY)


def results(data: bytes) -> None:
    """A results.json."""
    with suppress(ValueError):
        from_json(data)


def pdf(data: bytes) -> None:
    """A signed report: opened, and its signatures judged."""
    path = _file("report.pdf", data)
    with suppress(MetrologyError):
        open_report(path)
        verify(path, rebuild=False)


TARGETS: dict[str, Callable[[bytes], None]] = {
    function.__name__: function
    for function in (campaign, quantity, expression, readings, packed, formats, results, pdf)
}
