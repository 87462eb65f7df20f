"""Files that are made to harm, or that are no files of readings, and the message with which each is refused."""

from __future__ import annotations

import gzip
import io
import re
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import writers
from writers import RUNG


def _formula(path: Path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    for row in (["time / s", "displacement / mm"], [0, 1], [1, "=B2*2"], [2, 3]):
        book.active.append(row)
    book.save(path)


def _macros(path: Path) -> None:
    writers.xlsx(path, RUNG)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("xl/vbaProject.bin", b"\xd0\xcf\x11\xe0")


def _bomb(path: Path) -> None:
    writers.xlsx(path, RUNG)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/media/a.bin", bytes(65 << 20))


def _external(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file["time"] = np.arange(3.0)
        file["displacement"] = h5py.ExternalLink("/etc/passwd", "/x")


def _stored_outside(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file["time"] = np.arange(8.0)
        file.create_dataset("displacement", (8,), "f8", external=[("/etc/passwd", 0, 64)])


def _virtual(path: Path) -> None:
    import h5py

    layout = h5py.VirtualLayout(shape=(8,), dtype="f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "x", shape=(8,))
    with h5py.File(path, "w") as file:
        file["time"] = np.arange(8.0)
        file.create_virtual_dataset("displacement", layout)


def _inflated(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name in ("time", "displacement"):
            file.create_dataset(name, (10**12,), "f8", chunks=(1000,), compression="gzip")


def _pickle(path: Path) -> None:
    np.save(path, np.array([print], dtype=object), allow_pickle=True)


def _long_npy(path: Path) -> None:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    path.write_bytes(stream.getvalue())


def _archive(*names: str, content: bytes = b"time / s,displacement / m\n0,1\n1,2\n") -> Callable[[Path], None]:
    def write(path: Path) -> None:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in names:
                archive.writestr(name, content)

    return write


def _nested_archive(path: Path) -> None:
    _archive("a.csv")(path)
    _archive("a.zip", content=path.read_bytes())(path)


def _changed(
    write: Callable[[Path, writers.Columns], None], part: str, change: Callable[[bytes], bytes]
) -> Callable[[Path], None]:
    """A workbook with another content of one of its parts."""

    def spoiled(path: Path) -> None:
        write(path, RUNG)
        with zipfile.ZipFile(path) as archive:
            parts = {name: archive.read(name) for name in archive.namelist()}
        with zipfile.ZipFile(path, "w") as archive:
            for name, content in parts.items():
                archive.writestr(name, change(content) if name == part else content)

    return spoiled


def _laughing(content: bytes) -> bytes:
    bomb = b'<!DOCTYPE a [<!ENTITY b "bbbbbbbb"><!ENTITY c "&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;">]>'
    return bomb + content.rpartition(b"?>")[2]


def _cut_by_nulls(content: bytes) -> bytes:
    """Null characters in a tag, at which the reader of OpenDocument does not end: fuzzing found it."""
    return content.replace(b"</table:table>", b"</tab" + bytes(99) + b"le:table>")


def _basic(path: Path) -> None:
    writers.ods(path, RUNG)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("Basic/Standard/Module1.xml", "<module/>")


def _far_cell(path: Path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(["time / s", "displacement / mm"])
    book.active["XFD1048576"] = 1
    book.save(path)


def _deep(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        group = file
        for _ in range(500):
            group = group.create_group("g")
        group["time"] = group["displacement"] = np.arange(3.0)


def _huge_mdf(path: Path) -> None:
    writers.mdf4(path, RUNG)
    cycles = struct.pack("<QQ", 0, 400)
    before, _, behind = path.read_bytes().rpartition(cycles)
    path.write_bytes(before + struct.pack("<QQ", 0, 10**12) + behind)


def _huge_mat(path: Path) -> None:
    writers.mat5(path, RUNG)
    path.write_bytes(path.read_bytes().replace(struct.pack("<ii", 400, 1), struct.pack("<ii", 2**30, 2), 1))


def _long_parquet(path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    zeros = pa.array(np.zeros(11_000_000))
    pq.write_table(pa.table({"time": zeros, "displacement": zeros}), path, compression="zstd")


def _lvm_without_readings(path: Path) -> None:
    writers.lvm(path, RUNG)
    path.write_text(path.read_text(encoding="utf-8").rpartition("***End_of_Header***")[0] + "***End_of_Header***\n")


MOVED = {"time / s": [0.0, 1.0, 2.0], "displacement / mm": [1.0, 2.0, 3.0]}
OLE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(504)


def _formula_without_a_place(content: bytes) -> bytes:
    """A formula in the third row, of which neither the row nor the cell says where it stands."""
    placed = re.sub(rb'<c r="B3"[^>]*><v>', b"<c><f>B2*2</f><v>", content)
    assert placed != content
    return placed.replace(b'<row r="3"', b"<row")


def _error_cell(content: bytes) -> bytes:
    placed = re.sub(rb'<c r="B3"[^>]*><v>[^<]*', b'<c r="B3" t="e"><v>#DIV/0!', content)
    assert placed != content
    return placed


def _npz_bomb(path: Path) -> None:
    """A file of some kilobytes whose one array has a gibibyte."""
    path.write_bytes(gzip.compress(_zip_of_nulls(1 << 30)))


def _npz_bomb_in_a_zip(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.npz", _zip_of_nulls(65 << 20))


def _zip_of_nulls(size: int) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("time.npy", "w") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (size // 8,)})
        for _ in range(size >> 20):
            file.write(bytes(1 << 20))
    return stream.getvalue()


def _damaged_lzma(path: Path) -> None:
    rows = "".join(f"{i},{i % 7}\n" for i in range(3000))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("a.csv", "time / s,displacement / m\n" + rows)
    content = path.read_bytes()
    path.write_bytes(content[:60] + bytes(byte ^ 0x5A for byte in content[60:120]) + content[120:])


HOSTILE = {
    "way-out.zip": (_archive("../../a.csv"), ": got the name '../../a.csv' in the archive; expected names"),
    "absolute.zip": (_archive("/etc/a.csv"), ": got the name '/etc/a.csv' in the archive; expected names"),
    "many.zip": (_archive(*(f"{i}.csv" for i in range(2001))), ": got an archive of 2001 files; expected at most 2000"),
    "nested.zip": (_nested_archive, ": got an archive within, or one without readings; expected a file with readings"),
    "bomb.zip": (_archive("a.csv", content=bytes(65 << 20)), ": got a file that is too large; expected at most 64 MiB"),
    "bomb.csv.gz": (lambda path: path.write_bytes(gzip.compress(bytes(65 << 20))), ": got a file that is too large"),
    "entities.xlsx": (
        _changed(writers.xlsx, "xl/worksheets/sheet1.xml", _laughing),
        ": got a document type in 'xl/worksheets/sheet1.xml', which a workbook does not have; expected one without",
    ),
    "entities.ods": (_changed(writers.ods, "content.xml", _laughing), ": got a document type in 'content.xml', which"),
    "no-xml.ods": (
        _changed(writers.ods, "content.xml", _cut_by_nulls),
        ": got a workbook whose part 'content.xml' is no XML (not well-formed",
    ),
    "macros.ods": (_basic, ": got a workbook with macros; expected one without"),
    "far.xlsx": (_far_cell, ": got the sheet 'Sheet', with cells down to row 1048576 and out to column 16384"),
    "deep.h5": (_deep, ": got 0 groups and none stated; expected a file with a group"),
    "huge.mf4": (_huge_mdf, ": got 2000000000000 numbers; expected at most 20000000"),
    "huge.mat": (_huge_mat, ": got 2147484048 numbers; expected at most 20000000"),
    "long.parquet": (_long_parquet, ": got 22000000 numbers; expected at most 20000000"),
    "empty.lvm": (_lvm_without_readings, ":20: got no readings below the header; expected a line of headings"),
    "formula.xlsx": (_formula, ":3: got a formula in cell B3; expected a reading, which nothing computed"),
    "formula.ods": (
        lambda path: writers.ods(path, MOVED, formula=' table:formula="of:=1+1"'),
        ":2: got a formula in a cell of row 2; expected a reading, which nothing computed",
    ),
    "nowhere.xlsx": (
        _changed(writers.xlsx, "xl/worksheets/sheet1.xml", _formula_without_a_place),
        ":3: got a formula in cell 2 of row 3; expected a reading, which nothing computed. Fix: copy the cells",
    ),
    "error.xlsx": (
        _changed(writers.xlsx, "xl/worksheets/sheet1.xml", _error_cell),
        ":3: got the error '#DIV/0!' in cell B3; expected a reading, which nothing computed",
    ),
    "old.xls": (
        lambda path: path.write_bytes(OLE),
        ": got a file of old Office programs, such as .xls; expected an Excel workbook, .xlsx. Fix: open it and save",
    ),
    "locked.xlsx": (
        lambda path: path.write_bytes(OLE + "EncryptedPackage".encode("utf-16-le")),
        ": got a workbook that is locked by a password; expected an Excel workbook, .xlsx. Fix: save it without",
    ),
    "binary.xlsb": (
        _archive("xl/workbook.bin", content=b"a"),
        ": got a binary Excel workbook, .xlsb; expected an Excel workbook, .xlsx. Fix: open it and save it as .xlsx",
    ),
    "bomb.npz.gz": (_npz_bomb, ": got a file that is too large; expected at most 64 MiB"),
    "bomb-in.zip": (_npz_bomb_in_a_zip, ": got a file that is too large; expected at most 64 MiB"),
    "lzma.zip": (_damaged_lzma, ": got a damaged or locked archive; expected a whole one, without a password"),
    "macros.xlsx": (_macros, ": got a workbook with macros; expected one without"),
    "bomb.xlsx": (_bomb, ": got a file that is too large; expected at most 64 MiB of readings a file, unpacked"),
    "external.h5": (_external, ": got 'displacement', a link to another file; expected data in the file itself"),
    "outside.h5": (_stored_outside, ": got 'displacement', whose data lie in another file"),
    "virtual.h5": (_virtual, ": got 'displacement', whose data lie in another file"),
    "inflated.h5": (_inflated, ": got 2000000000000 numbers; expected at most 20000000"),
    "pickle.npy": (_pickle, ": got an array of Python objects, which run code when they are read; expected numbers"),
    "long.npy": (_long_npy, ": got a damaged or truncated NumPy file; expected a whole one"),
}  # fmt: skip
