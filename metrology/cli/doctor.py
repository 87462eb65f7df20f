"""`metrology doctor`: what is installed, what is not, and what each missing part would be for."""

from __future__ import annotations

import argparse
import ctypes
import platform
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from metrology import __version__
from metrology.cli.campaigns import DONE, FAILED
from metrology.report import pango

NEEDED = (
    "numpy",
    "scipy",
    "numba",
    "matplotlib",
    "weasyprint",
    "jinja2",
    "pydantic",
    "pyyaml",
    "rich",
    "uncertainties",
)
EXTRAS = {
    "files": ("python-calamine", "npTDMS", "pyuff", "h5py", "pyarrow"),
    "mdf": ("asammdf",),
    "sign": ("pyhanko", "pypdf"),
    "export": ("pandas", "pyarrow", "xmlschema"),
    "cluster": ("distributed",),
    "editor": ("cloudpickle", "pygls", "shtab", "watchfiles"),
}
"""Packages of each extra; `tests/test_doctor.py` compares them with pyproject.toml."""
PURPOSES = {
    "files": "readings from Excel, TDMS, UFF, MAT, HDF5 and Parquet files",
    "mdf": "readings from MDF4 files",
    "sign": "metrology sign and verify",
    "export": "metrology collect, and certificates checked against a schema",
    "cluster": "metrology batch on a cluster",
    "editor": "metrology watch, lsp and completion",
}
LIBRARIES = ("libpangoft2-1.0.so.0", "libpangoft2-1.0.dylib", "libpangoft2-1.0-0.dll", "pangoft2-1.0-0")


@dataclass(frozen=True)
class Found:
    """One thing that was looked for: whether it is there, whether nothing works without it, and how to get it."""

    name: str
    there: bool
    needed: bool
    text: str


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("doctor", help="say what is installed, what is not, and how to get it")
    parser.set_defaults(command=doctor)


def doctor(_options: argparse.Namespace) -> int:
    """Print every finding; status 1 where something is missing without which no report is made."""
    print(f"metrology {__version__}, Python {platform.python_version()}, {platform.system()} {platform.machine()}")
    found = list(examine())
    for one in found:
        mark = "ok     " if one.there else "MISSING" if one.needed else "absent "
        print(f"{mark} {one.name}: {one.text}")
    return DONE if all(one.there for one in found if one.needed) else FAILED


def examine() -> Iterator[Found]:
    """Look at packages, extras, Pango, the cache of compiled code and Git."""
    for name in NEEDED:
        installed = _version(name)
        yield Found(name, bool(installed), True, installed or "install the package again: pip install tether-metrology")
    yield _pango()
    for extra, packages in EXTRAS.items():
        missing = [name for name in packages if not _version(name)]
        how = f"without {', '.join(missing)}: pip install 'tether-metrology[{extra}]'"
        yield Found(f"extra {extra}", not missing, False, f"{PURPOSES[extra]}{f'; {how}' if missing else ''}")
    yield _cache()
    yield Found("git", shutil.which("git") is not None, False, "only for working on the package itself")


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def _pango(loads: Callable[[str], object] = ctypes.CDLL) -> Found:
    """Whether the library that lays out the PDF can be loaded."""
    for name in LIBRARIES:
        try:
            loads(name)
        except OSError:
            continue
        return Found("Pango", True, True, f"{name}, which lays out the PDF")
    return Found("Pango", False, True, pango.how())


def _cache() -> Found:
    """Whether compiled code can be kept between two runs."""
    try:
        with tempfile.TemporaryDirectory(dir=Path.home()):
            return Found("home folder", True, False, "can be written: compiled code is kept there")
    except OSError:
        text = "cannot be written: the simulation is compiled in every run; set NUMBA_CACHE_DIR to a folder that can"
        return Found("home folder", False, False, text)
