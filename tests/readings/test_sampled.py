"""When readings were taken, and in which unit, by the metadata of their files: planted numbers, or a refusal."""

from __future__ import annotations

import logging
import zipfile
from pathlib import Path

import numpy as np
import pytest
import writers

from metrology.api.arrays import taken_out
from metrology.declaration.columns import Column, Table
from metrology.declaration.readings import Readings
from metrology.errors import MetrologyError
from metrology.readings.files import read

TIME, POSITION, VELOCITY = Column("time", "s", increasing=True), Column("displacement", "m"), Column("velocity", "m/s")
MOVED = [1.0, 2.5, 2.0, -1.0]
STAMPS = [0.0, 0.002, 0.004, 0.006]


def table(path: Path, *columns: Column, **stated: object) -> Table:
    entry = Readings.model_validate({"file": path.name, **stated})
    return read(path, (TIME, POSITION, *columns), others=True, stated=entry)


def refusal(path: Path, *columns: Column, **stated: object) -> str:
    with pytest.raises(MetrologyError) as caught:
        table(path, *columns, **stated)
    return "\n".join(str(fault).partition(path.name)[2] for fault in caught.value.faults)


def hdf5(path: Path, **said: dict[str, object]) -> None:
    """A file with the displacement / mm, and what the attributes say of it and of other datasets."""
    import h5py

    with h5py.File(path, "w") as file:
        for name, attributes in said.items():
            made = file.create_dataset(name, data=np.array(attributes.pop("data", MOVED)))
            made.attrs.update(attributes)


# -- the unit of the stamps


@pytest.mark.parametrize(("unit", "step"), [("s", 0.002), ("ms", 2.0), ("sec", 0.002), ("S", 0.002), ("us", 2000.0)])
@pytest.mark.parametrize("even", [True, False])
def test_planted_stamps_of_a_universal_file_in_any_unit_of_time(
    unit: str, step: float, even: bool, tmp_path: Path
) -> None:
    columns = {f"time / {unit}": [step * i for i in range(4)], "displacement / mm": MOVED}
    (tmp_path / "a.uff").write_text(writers.uff_record(columns, even=even), encoding="ascii")
    found = table(tmp_path / "a.uff")
    assert found.numbers["time"].tolist() == pytest.approx(STAMPS, rel=1e-15)
    assert found.numbers["displacement"].tolist() == [0.001, 0.0025, 0.002, -0.001]


def test_planted_a_start_in_milliseconds_is_one(tmp_path: Path) -> None:
    columns = {"time / ms": [100.0, 102.0, 104.0, 106.0], "displacement / mm": MOVED}
    writers.uff(tmp_path / "a.uff", columns)
    assert table(tmp_path / "a.uff").numbers["time"].tolist() == [0.1, 0.102, 0.104, 0.106]


@pytest.mark.parametrize(
    ("over", "axis", "told"),
    [
        (18, "frequency / Hz", "over 'frequency' in 'Hz' (specific data type 18)"),
        (0, "angle / deg", "over 'angle' in 'deg' (specific data type 0)"),
        (17, "time / mm", "over 'time' in 'mm' (specific data type 17)"),
    ],
)
def test_refusal_of_a_record_that_is_not_over_time(over: int, axis: str, told: str, tmp_path: Path) -> None:
    columns = {axis: [2.0 * i for i in range(4)], "displacement / mm": MOVED}
    (tmp_path / "a.uff").write_text(writers.uff_record(columns, over=over), encoding="ascii")
    assert refusal(tmp_path / "a.uff").startswith(f" displacement: got a record {told}; expected one over time, in a")


# -- columns that were sampled at other times


def two_records(path: Path, *, step: float, start: float = 0.0, even: bool = True) -> None:
    first = {"time / s": STAMPS, "displacement / mm": MOVED}
    second = {"time / s": [start + step * i for i in range(4)], "velocity / mm/s": MOVED}
    records = [writers.uff_record(one, even=even) for one in (first, second)]
    path.write_text("".join(records), encoding="ascii")


@pytest.mark.parametrize("even", [True, False])
def test_planted_records_on_the_same_stamps_are_one_table(even: bool, tmp_path: Path) -> None:
    two_records(tmp_path / "a.uff", step=0.002, even=even)
    found = table(tmp_path / "a.uff", VELOCITY)
    assert found.numbers["time"].tolist() == STAMPS
    assert found.numbers["velocity"].tolist() == found.numbers["displacement"].tolist()


def test_refusal_of_records_that_were_sampled_at_other_times(tmp_path: Path) -> None:
    two_records(tmp_path / "a.uff", step=0.005, start=1.0)
    assert refusal(tmp_path / "a.uff", VELOCITY) == (
        ": got 'displacement' with a step of 0.002 s from 0 s on, and 'velocity' with a step of 0.005 s from 1 s on; "
        "expected columns that were sampled at the same times. "
        "Fix: read each by an entry of its own, or give the file a column of time stamps"
    )
    # Each by itself is on stamps of its own.
    assert table(tmp_path / "a.uff").numbers["time"].tolist() == STAMPS
    found = read(tmp_path / "a.uff", (TIME, VELOCITY), others=True)
    assert found.numbers["time"].tolist() == [1.0, 1.005, 1.01, 1.015]
    two_records(tmp_path / "a.uff", step=0.005, even=False)
    assert refusal(tmp_path / "a.uff", VELOCITY).startswith(
        ": got 'displacement' and 'velocity' on stamps of their own"
    )


TWO = {"displacement / mm": MOVED, "velocity / mm/s": MOVED}


def test_refusal_of_channels_that_were_started_at_other_times(tmp_path: Path) -> None:
    said = {
        name: {"wf_increment": 0.002, "wf_start_offset": start}
        for name, start in (("displacement", 0.0), ("velocity", 1.0))
    }
    writers.tdms(tmp_path / "a.tdms", TWO, said=said)
    assert "and 'velocity' with a step of 0.002 s from 1 s on" in refusal(tmp_path / "a.tdms", VELOCITY)
    assert table(tmp_path / "a.tdms").numbers["time"].tolist() == STAMPS
    found = read(tmp_path / "a.tdms", (TIME, VELOCITY), others=True)
    assert found.numbers["time"].tolist() == [1.0, 1.002, 1.004, 1.006]


def test_refusal_of_channels_that_were_started_at_other_instants(tmp_path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    for instants, same in ((("12:00:00", "12:00:00"), True), (("12:00:00", "12:00:01"), False)):
        with TdmsWriter(tmp_path / "a.tdms") as file:
            for name, instant in zip(("displacement", "velocity"), instants, strict=True):
                said = {"wf_increment": 0.002, "wf_start_time": np.datetime64(f"2026-10-05T{instant}")}
                unit = "mm" if name == "displacement" else "mm/s"
                said["unit_string"] = unit
                file.write_segment([ChannelObject("run", name, np.array(MOVED), properties=said)])
        if same:
            found = table(tmp_path / "a.tdms", VELOCITY)
            assert (found.numbers["time"].tolist(), found.date) == (STAMPS, "2026-10-05")
        else:
            told = refusal(tmp_path / "a.tdms", VELOCITY)
            assert "from 0 s after 2026-10-05T12:00:00.000000 on, and 'velocity' with a step of 0.002 s" in told


def test_refusal_of_the_step_of_another_channel(tmp_path: Path) -> None:
    writers.tdms(tmp_path / "a.tdms", TWO, said={"velocity": {"wf_increment": 1.0}})
    assert refusal(tmp_path / "a.tdms").startswith(": got no column 'time'; expected the heading 'time / s'")
    hdf5(tmp_path / "a.h5", temperature={"data": np.arange(9.0), "dt": 1.0}, displacement={"units": "mm"})
    assert refusal(tmp_path / "a.h5").startswith(": got no column 'time'; expected the heading 'time / s'")


def test_limit_a_channel_that_says_nothing_stands_beside_the_others_with_a_notice(tmp_path: Path) -> None:
    writers.tdms(tmp_path / "a.tdms", TWO, said={"displacement": {"wf_increment": 0.002}})
    found = table(tmp_path / "a.tdms", VELOCITY)
    assert found.numbers["time"].tolist() == STAMPS
    assert found.notices == ("the file does not say when 'velocity' was sampled: with the others, on the same rows",)


# -- attributes of HDF5 files


@pytest.mark.long
@pytest.mark.parametrize("step", [0.002, np.array([0.002]), "0.002"])
@pytest.mark.parametrize("more", [False, True])
def test_planted_the_step_and_the_unit_of_a_dataset(step: object, more: bool, tmp_path: Path) -> None:
    others = {"other": {"units": "mm"}} if more else {}
    hdf5(tmp_path / "a.h5", displacement={"units": "mm", "dt": step}, **others)
    for stated in ({}, {"dataset": "displacement"}):
        found = table(tmp_path / "a.h5", **stated)
        assert found.numbers["time"].tolist() == STAMPS
        assert found.numbers["displacement"].tolist() == [0.001, 0.0025, 0.002, -0.001]


def test_refusal_of_a_unit_or_a_rate_that_contradicts_a_single_dataset(tmp_path: Path) -> None:
    hdf5(tmp_path / "a.h5", displacement={"units": "mm", "dt": 0.002})
    metres = {"displacement": {"column": "displacement", "unit": "m"}}
    for stated in ({}, {"dataset": "displacement"}):
        told = refusal(tmp_path / "a.h5", columns=metres, time={"rate": "100 Hz"}, **stated)
        assert told.replace(" [displacement]", "") == (
            ": got a step of 0.01 s stated, and 0.002 s in the file; expected the same time between two samples. "
            "Fix: remove 'time', or find out which is right\n"
            " displacement: got the unit 'm' stated; expected 'mm', as the file has it"
        )


def test_planted_a_matrix_has_one_unit_a_column(tmp_path: Path) -> None:
    hdf5(tmp_path / "a.h5", run={"data": np.column_stack([STAMPS, MOVED]), "units": ["s", "mm"]})
    found = table(tmp_path / "a.h5", columns={"time": "1", "displacement": "2"})
    assert found.numbers["displacement"].tolist() == [0.001, 0.0025, 0.002, -0.001]
    stated = {"time": "1", "displacement": {"column": "2", "unit": "m"}}
    assert (
        refusal(tmp_path / "a.h5", columns=stated) == " 2: got the unit 'm' stated; expected 'mm', as the file has it"
    )
    hdf5(tmp_path / "a.h5", run={"data": np.column_stack([STAMPS, MOVED, MOVED]), "units": ["s", "mm"]})
    assert refusal(tmp_path / "a.h5").startswith(": got 2 units of 3 columns in 'run'; expected one, or one each")


@pytest.mark.long
def test_refusal_of_a_step_that_is_no_number(tmp_path: Path) -> None:
    for step in ("fast", float("nan"), np.array([0.001, 0.002])):
        hdf5(tmp_path / "a.h5", displacement={"units": "mm", "dt": step})
        assert refusal(tmp_path / "a.h5").startswith(" displacement: got ")
        assert " as 'dt'; expected a number of seconds. Fix: leave it out" in refusal(tmp_path / "a.h5")


def test_refusal_of_a_group_beside_a_dataset(tmp_path: Path) -> None:
    writers.hdf5(tmp_path / "a.h5", {"time / s": STAMPS, "displacement / mm": MOVED}, group="/run")
    assert refusal(tmp_path / "a.h5", group="run", dataset="time") == (
        " [run, time]: got 'group' and 'dataset' together; expected one of the two. "
        "Fix: state the whole path: 'dataset: run/time'"
    )


# -- instants


@pytest.mark.long
def test_planted_nanoseconds_are_kept(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    stamps = np.datetime64("2026-10-05T23:59:59.999900000", "ns") + np.arange(8) * np.timedelta64(20833, "ns")
    due = [20833e-9 * i for i in range(8)]
    for array in (stamps, stamps - stamps[0]):
        pq.write_table(pa.table({"time": array, "displacement / mm": np.arange(8.0)}), tmp_path / "a.parquet")
        found = table(tmp_path / "a.parquet").numbers["time"]
        assert (found - found[0]).tolist() == pytest.approx(due, abs=3e-11)  # of a double of some 1e5 s
    _, handed = taken_out({"readings": {"time": stamps, "displacement / mm": np.arange(8.0)}})
    ((name, content),) = handed.contents.items()
    found = read(Path(name), (TIME, POSITION), others=True, raw=content).numbers["time"]
    assert (found - found[0]).tolist() == pytest.approx(due, abs=3e-11)


@pytest.mark.parametrize(
    "cell", ["31.02.2026 12:30:00", "0000-00-00 12:00:00", "10:75:00", "10:15:60", "2026-13-01 00:00:00"]
)
def test_refusal_of_a_time_of_day_that_is_none(cell: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f"time,displacement / mm\n10:00:00,1\n{cell},2\n", encoding="utf-8")
    assert refusal(tmp_path / "a.csv").startswith(f":3: got '{cell}' under 'time', which has no unit; expected a time")


def test_law_after_a_tdms_file_its_library_may_warn_again(tmp_path: Path) -> None:
    writers.tdms(tmp_path / "a.tdms", TWO, rate=500.0)
    table(tmp_path / "a.tdms")
    (tmp_path / "a.tdms").write_bytes((tmp_path / "a.tdms").read_bytes()[:-40])
    refusal(tmp_path / "a.tdms")
    for name in ("reader", "tdms_segment", "types"):
        logger = logging.getLogger(f"nptdms.{name}")
        assert logger.filters == []
        logger.warning("of another reader")


# -- cells that are formatted as percent


def workbook(path: Path, heading: str, stored: list[object], formats: list[str]) -> None:
    from openpyxl import Workbook

    sheet = Workbook().active
    sheet.append(["time / s", heading])
    for at, (value, code) in enumerate(zip(stored, formats, strict=True), start=2):
        sheet.append([at, value])
        sheet.cell(at, 2).number_format = code
    sheet.parent.save(path)


def strain(path: Path) -> Table:
    entry = Readings.model_validate({"file": path.name, "columns": {"strain": {"column": "2"}, "time": "1"}})
    return read(path, (TIME, Column("strain", "1")), stated=entry)


@pytest.mark.long
@pytest.mark.parametrize("heading", ["Strain [%]", "Strain", "Strain [-]"])
@pytest.mark.parametrize("code", ["0%", "0.00%", '0.000" x"%'])
def test_planted_a_cell_that_shows_percent_holds_a_hundredth(heading: str, code: str, tmp_path: Path) -> None:
    workbook(tmp_path / "a.xlsx", heading, [0.0006, 0.0012, -0.01], [code] * 3)
    found = strain(tmp_path / "a.xlsx")
    assert found.numbers["strain"].tolist() == [0.0006, 0.0012, -0.01]
    assert f"the cells of '{heading}' are formatted as percent, and were read in %" in found.notices


@pytest.mark.parametrize("code", ["General", "0.00", '0.00"%"'])
def test_planted_a_cell_that_does_not_show_percent_is_as_it_stands(code: str, tmp_path: Path) -> None:
    workbook(tmp_path / "a.xlsx", "Strain [%]", [0.06, 0.12], [code] * 2)
    assert strain(tmp_path / "a.xlsx").numbers["strain"].tolist() == [0.0006, 0.0012]


def test_planted_percent_of_a_spreadsheet_of_opendocument(tmp_path: Path) -> None:
    writers.ods(tmp_path / "b.ods", {"time / s": [1.0, 2.0], "Strain [%]": [0.0006, 0.0012]})
    with zipfile.ZipFile(tmp_path / "b.ods") as old, zipfile.ZipFile(tmp_path / "a.ods", "w") as new:
        for name in old.namelist():
            content = old.read(name).replace(b'"float" office:value="0.0', b'"percentage" office:value="0.0')
            new.writestr(name, content)
    assert strain(tmp_path / "a.ods").numbers["strain"].tolist() == [0.0006, 0.0012]
    assert strain(tmp_path / "b.ods").numbers["strain"].tolist() == pytest.approx([0.000006, 0.000012], rel=1e-14)


def test_refusal_of_percent_beside_another_format_or_unit(tmp_path: Path) -> None:
    workbook(tmp_path / "a.xlsx", "Strain [%]", [0.0006, 0.12], ["0.00%", "0.00"])
    with pytest.raises(MetrologyError, match=r"a.xlsx:3 Strain \[%\]: got a cell that is not formatted as percent, as"):
        strain(tmp_path / "a.xlsx")
    workbook(tmp_path / "a.xlsx", "Strain [mm/mm]", [0.0006, 0.0012], ["0.00%", "0.00%"])
    with pytest.raises(MetrologyError, match=r"got the unit '%' in its metadata; expected 'mm/mm', as the file has it"):
        strain(tmp_path / "a.xlsx")
