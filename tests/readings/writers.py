"""Files of readings in every format, written without the libraries that read them wherever that can be done."""

from __future__ import annotations

import gzip
import io
import math
import struct
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

Columns = Mapping[str, Sequence[float | str]]
"""Columns by heading, such as ``time / s``."""
RUNG = {
    "time / s": [i / 1000 for i in range(400)],
    "displacement / um": [
        round(50 * math.exp(-3e-3 * i) * math.cos(0.14 * i) + 0.01 * (i * 7 % 5), 3) for i in range(400)
    ],
}


def named(heading: str) -> tuple[str, str]:
    name, _, unit = heading.partition(" / ")
    return name, unit


def csv(path: Path, columns: Columns) -> None:
    rows = zip(*columns.values(), strict=True)
    text = "\n".join([",".join(columns), *(",".join(map(str, row)) for row in rows)]) + "\n"
    path.write_text(text, encoding="utf-8")


def packed(path: Path, columns: Columns) -> None:
    csv(path, columns)
    path.write_bytes(gzip.compress(path.read_bytes()))


def zipped(path: Path, columns: Columns) -> None:
    csv(path, columns)
    text = path.read_bytes()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("run/1.csv", text)


def xlsx(path: Path, columns: Columns) -> None:
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(list(columns))
    for row in zip(*columns.values(), strict=True):
        book.active.append(list(row))
    book.save(path)


def ods(path: Path, columns: Columns, *, formula: str = "") -> None:
    """OpenDocument 1.3, part 3: the fewest elements that make a spreadsheet."""

    def cell(value: float | str) -> str:
        if isinstance(value, str):
            return f'<table:table-cell office:value-type="string"><text:p>{escape(value)}</text:p></table:table-cell>'
        return f'<table:table-cell{formula} office:value-type="float" office:value="{value!r}"/>'

    rows = [tuple(columns), *zip(*columns.values(), strict=True)]
    body = "".join(f"<table:table-row>{''.join(map(cell, row))}</table:table-row>" for row in rows)
    space = "urn:oasis:names:tc:opendocument:xmlns"
    content = (
        f'<?xml version="1.0" encoding="UTF-8"?><office:document-content xmlns:office="{space}:office:1.0" '
        f'xmlns:table="{space}:table:1.0" xmlns:text="{space}:text:1.0" office:version="1.3"><office:body>'
        f'<office:spreadsheet><table:table table:name="Blatt1">{body}</table:table></office:spreadsheet></office:body>'
        "</office:document-content>"
    )
    media = "application/vnd.oasis.opendocument.spreadsheet"
    manifest = f'<?xml version="1.0"?><manifest:manifest xmlns:manifest="{space}:manifest:1.0"/>'
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("mimetype", media)
        archive.writestr("content.xml", content)
        archive.writestr("META-INF/manifest.xml", manifest)


def _string(text: str) -> bytes:
    return struct.pack("<I", len(text.encode())) + text.encode()


def tdms(
    path: Path,
    columns: Columns,
    *,
    group: str = "Run 1",
    rate: float = 0.0,
    said: Mapping[str, Mapping[str, float]] | None = None,
) -> None:
    """TDMS version 4713, one segment (NI, "TDMS File Format Internal Structure"); `said`: properties by channel."""
    meta, raw = struct.pack("<I", 1 + len(columns)), b""
    meta += _string(f"/'{group}'") + struct.pack("<II", 0xFFFFFFFF, 0)
    for heading, values in columns.items():
        name, unit = named(heading)
        if name == "time" and rate:
            meta = struct.pack("<I", len(columns)) + meta[4:]
            continue
        properties = [_string("unit_string") + struct.pack("<I", 0x20) + _string(unit)]
        stated = {**({"wf_increment": 1 / rate} if rate else {}), **(said or {}).get(name, {})}
        properties += [_string(key) + struct.pack("<Id", 10, value) for key, value in stated.items()]
        meta += _string(f"/'{group}'/'{name}'") + struct.pack("<IIIQ", 20, 10, 1, len(values))
        meta += struct.pack("<I", len(properties)) + b"".join(properties)
        raw += np.asarray(values, "<f8").tobytes()
    path.write_bytes(b"TDSm" + struct.pack("<IIQQ", 2 | 4 | 8, 4713, len(meta) + len(raw), len(meta)) + meta + raw)


def uff(path: Path, columns: Columns) -> None:
    """Universal file of one record, whose abscissa is the first column."""
    path.write_text(uff_record(columns), encoding="ascii")


def uff_record(columns: Columns, *, over: int = 17, even: bool = True) -> str:
    """Universal file, dataset 58, real double precision (SDRC, "Universal File Dataset 58").

    `over`: specific data type of the abscissa, 17 for time and 18 for frequency.
    """
    (time, values) = columns.values()
    (over_what, of_time), (name, unit) = map(named, columns)
    count = len(values)
    head = ["    -1", "    58", "made for a test", "NONE", "05-Oct-26 12:00:00", "NONE", "NONE"]
    head += [f"{1:5d}{0:10d}{1:5d}{0:10d} {'NONE':10s}{1:10d}{1:4d} {'NONE':10s}{1:10d}{1:4d}"]
    start, step = (time[0], time[1] - time[0]) if even else (0.0, 0.0)
    head += [f"{4:10d}{count:10d}{int(even):10d}{start:13.5e}{step:13.5e}{0.0:13.5e}"]
    for kind, axis, of in ((over, over_what, of_time), (8, name, unit), (0, "NONE", "NONE"), (0, "NONE", "NONE")):
        head += [f"{kind:10d}{0:5d}{0:5d}{0:5d} {axis:20s} {of:20s}"]
    cells = [f"{y:20.12e}" if even else f"{t:13.5e}{y:20.12e}" for t, y in zip(time, values, strict=True)]
    each = 4 if even else 2
    lines = [*head, *("".join(cells[i : i + each]) for i in range(0, count, each)), "    -1"]
    return "\n".join(lines) + "\n"


def mat5(path: Path, columns: Columns) -> None:
    """MAT-file level 5 (MathWorks, "MAT-File Format", 1-9): a double matrix of one column for each variable."""
    head = b"MATLAB 5.0 MAT-file, made for a test".ljust(124) + struct.pack("<H", 0x0100) + b"IM"

    def element(kind: int, data: bytes) -> bytes:
        return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    body = b""
    for heading, values in columns.items():
        data = np.asarray(values, "<f8")
        flags, size = struct.pack("<II", 6, 0), struct.pack("<ii", len(data), 1)
        matrix = (
            element(6, flags) + element(5, size) + element(1, named(heading)[0].encode()) + element(9, data.tobytes())
        )
        body += element(14, matrix)
    path.write_bytes(head + body)


def hdf5(path: Path, columns: Columns, *, group: str = "/") -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for heading, values in columns.items():
            name, unit = named(heading)
            made = file.require_group(group).create_dataset(name, data=np.asarray(values))
            made.attrs["units"] = unit


def mat73(path: Path, columns: Columns) -> None:
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for heading, values in columns.items():
            file.create_dataset(named(heading)[0], data=np.asarray(values).reshape(1, -1))
    head = b"MATLAB 7.3 MAT-file, made for a test".ljust(124) + struct.pack("<H", 0x0200) + b"IM"
    content = bytearray(path.read_bytes())
    content[: len(head)] = head
    path.write_bytes(content)


def parquet(path: Path, columns: Columns) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [
        pa.field(named(heading)[0], _kind(values), metadata={"unit": named(heading)[1]})
        for heading, values in columns.items()
    ]
    arrays = [pa.array(list(values)) for values in columns.values()]
    pq.write_table(pa.table(arrays, schema=pa.schema(fields)), path)


def _kind(values: Sequence[float | str]) -> object:
    import pyarrow as pa

    return pa.string() if isinstance(values[0], str) else pa.int64() if isinstance(values[0], int) else pa.float64()


def npy(path: Path, columns: Columns) -> None:
    with path.open("wb") as file:  # numpy would add a suffix to a name
        np.save(file, np.column_stack([np.asarray(values, float) for values in columns.values()]))


def npz(path: Path, columns: Columns) -> None:
    stream = io.BytesIO()
    np.savez_compressed(stream, **{named(heading)[0]: np.asarray(values) for heading, values in columns.items()})
    path.write_bytes(stream.getvalue())


def lvm(path: Path, columns: Columns) -> None:
    """LabVIEW measurement file 2.0 with a column of stamps and a decimal comma."""
    (time, values) = columns.values()
    _, (name, unit) = map(named, columns)
    head = ["LabVIEW Measurement", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t,"]
    head += ["Multi_Headings\tNo", "X_Columns\tOne", "Time_Pref\tRelative", "Operator\tA. Smith", "Date\t2026/10/05"]
    head += ["Time\t12:00:00,5", "***End_of_Header***\t", "", "Channels\t1\t", f"Samples\t{len(values)}\t"]
    head += [
        f"Y_Unit_Label\t{unit}\t",
        "X_Dimension\tTime\t",
        "X0\t0,0\t",
        "Delta_X\t0,001\t",
        "***End_of_Header***\t\t",
    ]
    head += [f"X_Value\t{name}\tComment"]
    rows = [f"{t}\t{y}".replace(".", ",") for t, y in zip(time, values, strict=True)]
    path.write_text("\r\n".join([*head, *rows]) + "\r\n", encoding="utf-8")


class _Blocks:
    """Blocks of an MDF 4.10 file (ASAM MCD MDF, 4.1), each behind the one before; a link is a place in the file."""

    def __init__(self) -> None:
        self.content = b"MDF     4.10    test    " + bytes(4) + struct.pack("<H", 410) + bytes(34)

    def add(self, kind: str, links: Sequence[int], data: bytes = b"") -> int:
        place, data = len(self.content), data + b"\0" * (-len(data) % 8)
        head = struct.pack("<4s4xQQ", f"##{kind}".encode(), 24 + 8 * len(links) + len(data), len(links))
        self.content += head + struct.pack(f"<{len(links)}Q", *links) + data
        return place

    def text(self, words: str) -> int:
        return self.add("TX", (), words.encode() + b"\0")


def mdf4(path: Path, columns: Columns) -> None:
    """MDF 4.10: one group of doubles, whose first channel is the master of time."""
    blocks = _Blocks()
    head = blocks.add("HD", (0,) * 6, struct.pack("<QhhBBBxdd", 1_791_201_600_000_000_000, 0, 0, 1, 0, 0, 0.0, 0.0))
    rows = np.column_stack([np.asarray(values, "<f8") for values in columns.values()])
    channel = 0
    for index, heading in reversed(list(enumerate(columns))):
        name, unit = named(heading)
        master = int(index == 0)
        data = struct.pack("<BBBBIIIIBxH6d", 2 * master, master, 4, 0, 8 * index, 64, 0, 0, 0, 0, *[0.0] * 6)
        channel = blocks.add("CN", (channel, 0, blocks.text(name), 0, 0, 0, blocks.text(unit), 0), data)
    group = blocks.add(
        "CG", (0, channel, 0, 0, 0, 0), struct.pack("<QQHH4xII", 0, len(rows), 0, 0, rows.shape[1] * 8, 0)
    )
    group = blocks.add("DG", (0, group, blocks.add("DT", (), rows.tobytes()), 0), bytes(8))
    history = blocks.add(
        "FH", (0, blocks.add("MD", (), b"<FHcomment><TX>made for a test</TX></FHcomment>\0")), bytes(16)
    )
    content = bytearray(blocks.content)
    content[head + 24 : head + 40] = struct.pack("<QQ", group, history)
    path.write_bytes(bytes(content))


BY_FORMAT = {
    "text": (csv,),
    "lvm": (lvm,),
    "xlsx": (xlsx,),
    "ods": (ods,),
    "tdms": (tdms,),
    "uff58": (uff,),
    "parquet": (parquet,),
    "numpy": (npz, npy),
    "mat": (mat5, mat73),
    "hdf5": (hdf5,),
    "mdf4": (mdf4,),
}
"""Writers of each format of a campaign file."""
