"""Readings of every format: the same results as from the CSV file, to the byte; hostile files are refused."""

from __future__ import annotations

import gzip
import io
import json
import math
import re
import struct
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import writers

from metrology import chain
from metrology.campaign.load import load
from metrology.declaration.columns import Column
from metrology.declaration.readings import Readings
from metrology.errors import MetrologyError
from metrology.findings import to_json
from metrology.readings.files import read

CAMPAIGN = """\
format: metrology-campaign/1
id: formats
title: The same readings in another format
diagnosis: {off: true}
monte_carlo: {max_trials: 1000, digits: 1}
instruments: {gauge: {kind: gauge, resolution: 0.01 mm}}
samples: {wire: {material: steel}}
tests:
"""
ELONGATION = """\
  pull:
    method: elongation
    sample: wire
    instruments: {extension: gauge}
    loads: {A: {force: 10 N}, B: {force: 20 N}, C: {force: 30 N}}
    readings: FILE
"""
DECAY = """\
  ring:
    method: decay
    sample: wire
    instruments: {displacement: gauge}
    mass: 1.0 kg
    readings: [FILE]
"""
PULLED: dict[str, list[float | str]] = {
    "load": ["A", "B", "C"] * 6,
    "repeat": [repeat for repeat in (1, 2, 3) for _ in range(6)],
    "direction": (["loading"] * 3 + ["unloading"] * 3) * 3,
    "reading / mm": [round(0.40 * step + 0.01 * (i % 2), 2) for i in range(6) for step in (1, 2, 3)],
}
RUNG = {
    "time / s": [i / 1000 for i in range(400)],
    "displacement / um": [
        round(50 * math.exp(-3e-3 * i) * math.cos(0.14 * i) + 0.01 * (i * 7 % 5), 3) for i in range(400)
    ],
}


def _packed_tdms(path: Path, columns: writers.Columns) -> None:
    writers.tdms(path, columns)
    path.write_bytes(gzip.compress(path.read_bytes()))


WITH_UNITS = "columns: {time: {column: time, unit: s}, displacement: {column: displacement, unit: um}}"
WORDS = {
    "xlsx": (writers.xlsx, "{file: FILE, sheet: Sheet}"),
    "ods": (writers.ods, "FILE"),
    "parquet": (writers.parquet, "FILE"),
    "csv.gz": (writers.packed, "FILE"),
    "zip": (writers.zipped, "{file: FILE, member: run/1.csv}"),
}
NUMBERS = {
    "xlsx": (writers.xlsx, "FILE"),
    "tdms": (writers.tdms, "FILE"),
    "uff": (writers.uff, "FILE"),
    "mat": (writers.mat5, f"{{file: FILE, {WITH_UNITS}}}"),
    "h5": (writers.hdf5, "FILE"),
    "hdf5": (lambda path, columns: writers.hdf5(path, columns, group="/runs/1"), "{file: FILE, group: /runs/1}"),
    "parquet": (writers.parquet, "FILE"),
    "npz": (writers.npz, f"{{file: FILE, {WITH_UNITS}}}"),
    "npy": (
        writers.npy,
        "{file: FILE, columns: {time: {column: 1, unit: s}, displacement: {column: 2, unit: um}}}",
    ),
    "lvm": (writers.lvm, "FILE"),
    "mf4": (writers.mdf4, "FILE"),
    "ods": (writers.ods, "FILE"),
    "csv.gz": (writers.packed, "FILE"),
    "zip": (writers.zipped, "{file: FILE, member: run/1.csv}"),
    "tdms.gz": (_packed_tdms, "FILE"),
}


def results(folder: Path, test: str, file: str, stated: str) -> str:
    """The results with nothing that names the file."""
    folder.mkdir(exist_ok=True)
    path = folder / "campaign.yaml"
    path.write_text(CAMPAIGN + test.replace("FILE", stated.replace("FILE", file)), encoding="utf-8")
    campaign = load(path)
    told = json.loads(to_json(chain.evaluate(campaign)))
    assert [entry["path"] for entry in told.pop("inputs")] == ["campaign.yaml", file]
    told["warnings"] = [text for text in told["warnings"] if not text.startswith(file)]
    told["notices"] = [one for one in told["notices"] if not one["sentence"].startswith(file)]
    text = json.dumps(told, sort_keys=True)
    if file.endswith(".parquet"):  # no line of headings: its first row is row 1
        text = re.sub(r"\(line (\d+)\)", lambda match: f"(line {int(match[1]) + 1})", text)
    for part in (" [run/1.csv]", " [Sheet]", " [/runs/1]"):
        text = text.replace(f"{file}{part}", file)
    return text.replace(f'"{file}', '"FILE')


@pytest.mark.parametrize("suffix", WORDS)
def test_twice_an_elongation_in_another_format(suffix: str, tmp_path: Path) -> None:
    write, stated = WORDS[suffix]
    (tmp_path / "plain").mkdir()
    writers.csv(tmp_path / "plain" / "r.csv", PULLED)
    write(tmp_path / f"r.{suffix}", PULLED)
    assert results(tmp_path, ELONGATION, f"r.{suffix}", stated) == results(
        tmp_path / "plain", ELONGATION, "r.csv", "FILE"
    )


@pytest.mark.long
@pytest.mark.parametrize("suffix", [*NUMBERS, "mat 7.3"])
def test_twice_a_decay_in_another_format(suffix: str, tmp_path: Path) -> None:
    write, stated = NUMBERS.get(suffix, (writers.mat73, NUMBERS["mat"][1]))
    file = f"r.{suffix.partition(' ')[0]}"
    (tmp_path / "plain").mkdir()
    writers.csv(tmp_path / "plain" / "r.csv", RUNG)
    write(tmp_path / file, RUNG)
    assert results(tmp_path, DECAY, file, stated) == results(tmp_path / "plain", DECAY, "r.csv", "FILE")


def test_limit_a_file_above_the_stated_size_is_hashed_and_not_attached(tmp_path: Path) -> None:
    noted = f"# {'.' * 9000}\n" * 120
    writers.csv(tmp_path / "r.csv", PULLED)
    plain = (tmp_path / "r.csv").read_text(encoding="utf-8")
    (tmp_path / "r.csv").write_text(noted + plain, encoding="utf-8")
    path = tmp_path / "campaign.yaml"
    for stated, attached in (("", True), ("report: {attach_up_to: 2}\n", True), ("report: {attach_up_to: 1}\n", False)):
        path.write_text(stated + CAMPAIGN + ELONGATION.replace("FILE", "r.csv"), encoding="utf-8")
        assert [one.attached for one in chain.evaluate(load(path)).inputs] == [True, attached]


def test_limit_a_compressed_file_of_the_reader_s_own_library_is_read(tmp_path: Path) -> None:
    """asammdf writes compressed blocks, integers with a conversion, and a group for each rate."""
    from asammdf import MDF, Signal

    stamps = np.arange(400) / 1000
    raw = np.arange(400, dtype=np.int16)
    scaled = Signal(raw, stamps, name="displacement", unit="um", conversion={"a": 0.5, "b": 2.0})
    slow = Signal(np.arange(4.0), np.arange(4.0), name="temperature", unit="degC")
    file = MDF(version="4.11")
    file.append([scaled], comment="fast")
    file.append([slow], comment="slow")
    file.save(tmp_path / "a.mf4", compression=2, overwrite=True)
    assert refusal(tmp_path / "a.mf4").startswith(": got 2 groups and none stated; expected one of '1', '2'")
    found = table(tmp_path / "a.mf4", group="1")
    assert found.numbers["time"].tolist() == stamps.tolist()
    assert found.numbers["displacement"] == pytest.approx((0.5 * raw + 2.0) * 1e-6, rel=1e-15)


def test_law_rows_that_are_not_used_are_not_judged(tmp_path: Path) -> None:
    text = "time / s,displacement / m\nidle,,,\n0,1\n0.1,2\n0.2,3\ntime / s,displacement / m\n0,1\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    assert table(tmp_path / "a.csv", rows=["3", "5"]).numbers["time"].tolist() == [0.0, 0.1, 0.2]
    (tmp_path / "a.csv").write_text(text.replace("idle,,,\n", ""), encoding="utf-8")
    assert refusal(tmp_path / "a.csv") == (
        ":5: got the headings again, of another block of readings; expected one block of readings. "
        "Fix: state the lines: 'rows: [first, last]'"
    )


def test_limit_an_acceleration_in_g_is_one_of_free_fall(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time / s,acceleration [g]\n0,1\n1,2\n", encoding="utf-8")
    found = read(tmp_path / "a.csv", (TIME, Column("acceleration", "m/s^2")))
    assert found.numbers["acceleration"].tolist() == [9.80665, 19.6133]
    assert "the unit 'g' of 'acceleration [g]' was read as gn" in found.notices[0]


TIME, POSITION = Column("time", "s", increasing=True), Column("displacement", "m")


def table(path: Path, **stated: object):
    return read(path, (TIME, POSITION), stated=Readings.model_validate({"file": path.name, **stated}))


def refusal(path: Path, **stated: object) -> str:
    with pytest.raises(MetrologyError) as caught:
        table(path, **stated)
    return "\n".join(str(fault).partition(path.name)[2] for fault in caught.value.faults)


def test_closed_form_stamps_of_a_tdms_file_come_from_its_increment(tmp_path: Path) -> None:
    writers.tdms(tmp_path / "a.tdms", RUNG, rate=1000.0)
    assert table(tmp_path / "a.tdms").numbers["time"].tolist() == RUNG["time / s"]


def test_refusal_of_a_rate_that_contradicts_the_file(tmp_path: Path) -> None:
    writers.tdms(tmp_path / "a.tdms", RUNG, rate=1000.0)
    assert refusal(tmp_path / "a.tdms", time={"rate": "500 Hz"}) == (
        ": got a step of 0.002 s stated, and 0.001 s in the file; expected the same time between two samples. "
        "Fix: remove 'time', or find out which is right"
    )


def test_refusal_of_a_unit_that_contradicts_the_metadata(tmp_path: Path) -> None:
    writers.tdms(tmp_path / "a.tdms", RUNG)
    columns = {"time": "time", "displacement": {"column": "displacement", "unit": "mm"}}
    assert refusal(tmp_path / "a.tdms", columns=columns) == (
        " displacement: got the unit 'mm' stated; expected 'um', as the file has it"
    )


def test_refusal_of_several_groups_names_them(tmp_path: Path) -> None:
    import h5py

    writers.hdf5(tmp_path / "a.h5", RUNG, group="/first")
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file.copy("/first", "/second")
    assert refusal(tmp_path / "a.h5") == (
        ": got 2 groups and none stated; expected one of 'first', 'second'. "
        "Fix: state it in the campaign file: 'group: …'"
    )
    assert len(table(tmp_path / "a.h5", group="second")) == 400


def test_limit_a_file_is_what_its_content_says(tmp_path: Path) -> None:
    writers.tdms(tmp_path / "a.csv", RUNG)
    assert table(tmp_path / "a.csv").notices == ("it is a TDMS file of LabVIEW or DIAdem, whatever its name says",)
    assert refusal(tmp_path / "a.csv", format="xlsx").startswith(": got a TDMS file of LabVIEW or DIAdem; expected a")


def test_limit_a_sheet_is_found_by_its_columns(tmp_path: Path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(["Auftrag", 17])
    sheet = book.create_sheet("Messung")
    sheet.append(["Prüfprotokoll"])
    sheet.append(["time", "displacement"])
    sheet.append(["s", "[mm]"])
    for t, y in ((0, 1.5), (0.5, 2), (1.0, "2,5")):
        sheet.append([t, y])
    book.save(tmp_path / "a.xlsx")
    found = table(tmp_path / "a.xlsx", decimal="comma")
    assert found.numbers["displacement"].tolist() == [0.0015, 0.002, 0.0025]
    assert found.lines.tolist() == [4, 5, 6]
    assert found.notices == (
        "its sheet 'Messung' was read",
        "rows 1 to 1 above the headings were passed over",
        "row 3 was read as the units of the headings",
    )


# -- hostile files


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


@pytest.mark.long
@pytest.mark.parametrize("file", HOSTILE)
def test_refusal_of_hostile_files(file: str, tmp_path: Path) -> None:
    write, message = HOSTILE[file]
    write(tmp_path / file)
    assert refusal(tmp_path / file).startswith(message)


@pytest.mark.long
@pytest.mark.parametrize("suffix", NUMBERS)
def test_refusal_of_a_truncated_file(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"r.{suffix}"
    NUMBERS[suffix][0](path, RUNG)
    whole = path.read_bytes()
    columns = {"time": {"column": "time", "unit": "s"}, "displacement": {"column": "displacement", "unit": "um"}}
    stated = {"columns": columns} if suffix in ("mat", "npz") else {}
    for part in (0.2, 0.5, 0.9):
        path.write_bytes(whole[: int(part * len(whole))])
        with suppress(MetrologyError):
            assert len(table(path, **stated)) < 400
