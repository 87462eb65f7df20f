"""Every format of readings, by its content: a format is one module and one line here."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec

from metrology.message import said
from metrology.readings.sheet import Job, Sheet, refused

PACKED = (".gz", ".zip")
KEYS = {
    "sheet": ("xlsx", "ods"),
    "group": ("tdms", "hdf5", "mat", "mdf4"),
    "dataset": ("hdf5", "mat", "numpy"),
    "channel": ("uff58",),
    "decimal": ("text", "xlsx", "ods"),
    "separator": ("text",),
    "header": ("text", "xlsx", "ods"),
    "encoding": ("text", "lvm"),
}
"""Keys of an entry of readings that only some formats have."""
OLE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
LOCKED = "EncryptedPackage".encode("utf-16-le")
ARCHIVES = (b"PK\x03\x04", b"\x1f\x8b")
EXTRA = "pip install 'tether-metrology[files]'"


@dataclass(frozen=True)
class Format:
    """A format of readings.

    Parameters
    ----------
    name, title : str
        Word in campaign files, and what it is called, with its article.
    suffixes : tuple of str
        How names of such files usually end.
    is_it : callable
        Whether a content is of this format, from its first bytes.
    module : str
        Module of `metrology.readings` that reads it, with a function ``read(job)``.
    needs : str
        Package that has to be installed for it; none where empty.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    is_it: Callable[[bytes], bool]
    module: str
    needs: str = ""


def _begins(*marks: bytes) -> Callable[[bytes], bool]:
    return lambda raw: raw.startswith(marks)


def _zip_with(name: bytes) -> Callable[[bytes], bool]:
    return lambda raw: raw.startswith(b"PK") and name in raw


def _is_numpy(raw: bytes) -> bool:
    return raw.startswith(b"\x93NUMPY") or (raw.startswith(b"PK") and b".npy" in raw[:200])


_CALAMINE = "python_calamine"
_UFF = re.compile(rb"\s*-1\s*\r?\n\s*58b?\s")
FORMATS = (
    Format("xlsx", "an Excel workbook", (".xlsx", ".xlsm"), _zip_with(b"xl/workbook.xml"), "spreadsheet", _CALAMINE),
    Format(
        "ods", "an OpenDocument spreadsheet", (".ods",), _zip_with(b"opendocument.spread"), "spreadsheet", _CALAMINE
    ),
    Format("tdms", "a TDMS file of LabVIEW or DIAdem", (".tdms",), _begins(b"TDSm"), "tdms", "nptdms"),
    Format("hdf5", "an HDF5 file", (".h5", ".hdf5", ".hdf"), _begins(b"\x89HDF\r\n"), "hdf5", "h5py"),
    Format("mat", "a MAT file", (".mat",), _begins(b"MATLAB 5.0", b"MATLAB 7.3"), "mat", "h5py"),
    Format("parquet", "a Parquet file", (".parquet", ".pq"), _begins(b"PAR1"), "parquet", "pyarrow"),
    Format("mdf4", "an MDF file", (".mf4", ".mdf"), _begins(b"MDF     4"), "mdf", "asammdf"),
    Format("numpy", "a NumPy file", (".npy", ".npz"), _is_numpy, "arrays"),
    Format(
        "uff58", "a Universal file", (".uff", ".unv", ".uf"), lambda raw: bool(_UFF.match(raw[:200])), "uff", "pyuff"
    ),
    Format("lvm", "a LabVIEW measurement file", (".lvm",), _begins(b"LabVIEW Measurement"), "lvm"),
    Format("text", "a text", (".csv", ".txt", ".tsv", ".dat", ".asc", ".tra", ".trc"), lambda _raw: True, "text"),
)
SUFFIXES = tuple(suffix for one in FORMATS for suffix in one.suffixes)


def is_readable(name: str) -> bool:
    """Whether a file of this name may hold readings, packed or not."""
    plain = name.lower()
    return plain.endswith((*SUFFIXES, *(f"{suffix}{packed}" for suffix in SUFFIXES for packed in PACKED), ".zip"))


def recognise(job: Job, name: str) -> Format:
    """The format of a content: by its first bytes, whatever the file is called.

    Raises
    ------
    MetrologyError
        Where another format is stated, or a key that the format does not have; and for workbooks of other formats.
    """
    _refuse_other_workbooks(job, name)
    found = _recognised(job, name)
    for key, names in KEYS.items():
        if getattr(job.stated, key) is not None and found.name not in names:
            title = " or ".join(one.title for one in FORMATS if one.name in names)
            raise refused(job.log.where, f"'{key}' stated for {found.title}", title, f"leave '{key}' out")
    return found


def _refuse_other_workbooks(job: Job, name: str) -> None:
    if job.content.startswith(OLE):
        locked = LOCKED in job.content or name.lower().endswith((".xlsx", ".xlsm"))
        got = "a workbook that is locked by a password" if locked else "a file of old Office programs, such as .xls"
        fix = "save it without a password" if locked else "open it and save it as .xlsx"
        raise refused(job.log.where, got, "an Excel workbook, .xlsx", fix)
    if job.content.startswith(b"PK") and b"xl/workbook.bin" in job.content:
        fix = "open it and save it as .xlsx"
        raise refused(job.log.where, "a binary Excel workbook, .xlsb", "an Excel workbook, .xlsx", fix)


def _recognised(job: Job, name: str) -> Format:
    found = next(one for one in FORMATS if one.is_it(job.content))
    if found.name == "text" and job.content.startswith(ARCHIVES):
        raise refused(job.log.where, "an archive within, or one without readings", "a file with readings", "unpack it")
    stated = job.stated.format
    if stated is not None and stated != found.name and not (found.name == "hdf5" and stated == "mat"):
        title = next(one.title for one in FORMATS if one.name == stated)
        raise refused(job.log.where, found.title, f"{title}, as 'format: {stated}' has it", "leave 'format' out")
    if stated == "mat":
        found = next(one for one in FORMATS if one.name == "mat")
    usual = next((one for one in FORMATS if name.lower().endswith(one.suffixes)), found)
    if found.name == "hdf5" and usual.name == "mat":
        return usual
    if usual is not found and (found.name != "text" or usual.name != "lvm"):
        if found.name == "text" and b"\0" in job.content[:4096]:
            raise refused(job.log.where, f"no {usual.title.partition(' ')[2]}", usual.title, "copy the file again")
        job.log.note(said("it is {format}, whatever its name says", format=found.title))
    return found


def load(job: Job, found: Format) -> Sheet:
    """Read a content by its format.

    Raises
    ------
    MetrologyError
        Where the package that reads it is not installed, and for a damaged file.
    """
    if found.needs and find_spec(found.needs) is None:
        expected = f"the package that reads it, {found.needs}"
        raise refused(job.log.where, f"{found.title}, and no package for it", expected, EXTRA)
    return import_module(f"metrology.readings.{found.module}").read(job)  # type: ignore[no-any-return]
