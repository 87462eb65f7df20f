"""Readings of every format: the same results as from the CSV file, to the byte; hostile files are refused."""

from __future__ import annotations

import gzip
import json
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import writers
from hostile import HOSTILE

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
RUNG = writers.RUNG


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
    of_file = " ".join(text for text in told["warnings"] if text.startswith(file))
    told["warnings"] = [text for text in told["warnings"] if not text.startswith(file)]
    told["messages"] = [one for one in told["messages"] if one["text"] not in of_file]
    told["notices"] = [one for one in told["notices"] if not one["sentence"].startswith(file)]
    text = json.dumps(told, sort_keys=True)
    if file.endswith(".parquet"):  # no line of headings: its first row is row 1
        text = re.sub(r"\(line (\d+)\)", lambda match: f"(line {int(match[1]) + 1})", text)
        text = re.sub(r'"line": (\d+)', lambda match: f'"line": {int(match[1]) + 1}', text)
    for part in (" [run/1.csv]", " [Sheet]", " [/runs/1]"):
        text = text.replace(f"{file}{part}", file)
    return text.replace(f'"{file}', '"FILE')


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
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
