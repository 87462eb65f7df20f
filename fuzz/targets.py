"""What is fuzzed: every reader of what comes from outside. A refusal in our words is right, another error is a find."""

from __future__ import annotations

import atexit
import gzip
import shutil
import tempfile
import zipfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib import import_module
from io import BytesIO
from pathlib import Path

from fuzz.forked import Forks
from fuzz.guard import watched
from metrology import units
from metrology.campaign.calibration import read_certificates
from metrology.campaign.load import load
from metrology.declaration.columns import Column
from metrology.declaration.document import parse
from metrology.draft import draft
from metrology.errors import MetrologyError
from metrology.expression import Expression
from metrology.findings import from_json
from metrology.methods.decay import TIME
from metrology.methods.elongation import COLUMNS as ELONGATION
from metrology.readings import apart, formats
from metrology.readings.binding import Binder
from metrology.readings.files import read
from metrology.signoff.opened import open_report
from metrology.signoff.verification import verify
from metrology.units.dimensions import TextError
from metrology.units.symbols import UnitError

HOME = Path(tempfile.mkdtemp(prefix="metrology-fuzz-"))
"""Where inputs are written, and the temporary files of readers; removed at the end."""
atexit.register(shutil.rmtree, HOME, ignore_errors=True)
tempfile.tempdir = str(HOME)
NAMES = {name: units.dimension(unit) for name, unit in (("k", "N/m"), ("L", "m"), ("A", "m^2"), ("p", "1"))}

DECAY = (TIME, Column("displacement", "m", varies=True))
WITHIN: dict[str, tuple[bytes, str]] = {}
"""Archives by format, and the part of them in whose place the input stands: a changed archive fails its checksums."""
GZIP = b"\x1f\x8b"
CAMPAIGN = b"instruments: {a: {certificate: {dcc: k.xml}}}"


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
    """Likewise gzipped: as it is where it begins like such a file, or as the content of a whole one."""
    content = data if data.startswith(GZIP) else gzip.compress(data, 1)
    with suppress(MetrologyError):
        read(_file("a.csv.gz", content), DECAY)


def _format(name: str) -> Callable[[bytes], None]:
    def target(data: bytes) -> None:
        whole, part = WITHIN.get(name, (b"", ""))
        content = data if data.startswith(b"PK") or not whole else _placed(data, whole, part)
        with suppress(MetrologyError):
            read(_file("a.dat", content), DECAY)

    target.__doc__ = f"A file of readings in the format {name}."
    return target


def _placed(data: bytes, whole: bytes, part: str) -> bytes:
    stream = BytesIO()
    with zipfile.ZipFile(BytesIO(whole)) as old, zipfile.ZipFile(stream, "w") as new:
        for name in old.namelist():
            new.writestr(name, data if name == part else old.read(name))
    return stream.getvalue()


LIBRARIES = {
    "mat": ("scipy.io", "h5py"),
    "hdf5": ("h5py",),
    "mdf4": ("asammdf",),
    "parquet": ("pyarrow.parquet",),
    "xlsx": ("python_calamine",),
    "ods": ("python_calamine",),
}


def warm(name: str) -> None:
    """Import what reads a format, once for all forks; compile the rig, whose cache lies where none may write later."""
    if name == "evaluation":
        from mutation import evaluated, unchanged

        evaluated(unchanged("response"))
    for library in LIBRARIES.get(name, ()):
        import_module(library)


apart._in_a_process = Forks()
# Beneath what turns every exception into a refusal, so that an error of ours is a find.
formats.load = watched(formats.load)  # type: ignore[assignment]
Binder.read = watched(Binder.read)  # type: ignore[assignment,method-assign]


def certificate(data: bytes) -> None:
    """A digital calibration certificate."""
    _file("k.xml", data)
    read_certificates(parse(HOME / "campaign.yaml", CAMPAIGN))


def unknown(data: bytes) -> None:
    """A file that nobody described, for a draft."""
    with suppress(MetrologyError):
        draft([_file("a.txt", data)], {})


def results(data: bytes) -> None:
    """A results.json."""
    with suppress(ValueError):
        from_json(data)


def pdf(data: bytes) -> None:
    """A signed report: opened, and its signatures judged."""
    path = _file("report.pdf", data)
    with suppress(MetrologyError):
        open_report(path)
        verify(path, again=None)


@cache
def _evaluation() -> Callable[[bytes], object]:
    from hypothesis import given, settings
    from mutation import evaluated, works

    tested = given(works())(settings(database=None)(evaluated))  # type: ignore[no-untyped-call]
    driven: Callable[[bytes], object] = tested.hypothesis.fuzz_one_input
    return driven


def evaluation(data: bytes) -> None:
    """A small campaign of any method with changed readings and values, up to its results."""
    _evaluation()(data)


TARGETS: dict[str, Callable[[bytes], None]] = {
    function.__name__: function
    for function in (campaign, quantity, expression, readings, packed, certificate, unknown, results, pdf, evaluation)
}
FORMATS = ("text", "lvm", "xlsx", "ods", "tdms", "uff58", "parquet", "numpy", "mat", "hdf5", "mdf4")
TARGETS |= {name: _format(name) for name in FORMATS}
