"""Headings that may be meant, marks within numbers, keys that a format has, and what lies in a file beside readings."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
import writers

from metrology.declaration.columns import Column, Table
from metrology.declaration.readings import Readings
from metrology.errors import MetrologyError
from metrology.readings.files import read

TIME, POSITION = Column("time", "s", increasing=True), Column("displacement", "m")
MOVED = [1.0, 2.5, 2.0, -1.0]
STAMPS = [0.0, 0.002, 0.004, 0.006]
TWO = {"displacement / mm": MOVED, "velocity / mm/s": MOVED}


def table(path: Path, **stated: object) -> Table:
    entry = Readings.model_validate({"file": path.name, **stated})
    return read(path, (TIME, POSITION), others=True, stated=entry)


def refusal(path: Path, **stated: object) -> str:
    with pytest.raises(MetrologyError) as caught:
        table(path, **stated)
    return "\n".join(str(fault).partition(path.name)[2] for fault in caught.value.faults)


def rows(*lines: str) -> Callable[[Path], object]:
    return lambda path: path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.parametrize(
    ("headings", "told"),
    [
        ("displacement / mm,displacement / um", "'displacement / mm' and 'displacement / um'"),
        ("Displacement [mm],displacement (um)", "'Displacement [mm]' and 'displacement (um)'"),
    ],
)
def test_refusal_of_two_headings_that_fit_one_column(headings: str, told: str, tmp_path: Path) -> None:
    rows(f"time / s,{headings}", "0,1,500", "1,2,700")(tmp_path / "a.csv")
    for stated in ({}, {"columns": {"displacement": "displacement"}}):
        assert refusal(tmp_path / "a.csv", **stated).startswith(
            f":1: got {told} for 'displacement'; expected one heading that fits. Fix: state which: 'columns: "
        )
    second = headings.partition(",")[2]
    found = table(tmp_path / "a.csv", columns={"displacement": second})
    assert found.numbers["displacement"].tolist() == [0.0005, 0.0007]
    assert table(tmp_path / "a.csv", columns={"displacement": "2"}).numbers["displacement"].tolist() == [0.001, 0.002]


def test_law_a_heading_as_it_stands_goes_before_one_by_its_name(tmp_path: Path) -> None:
    rows("time / s,displacement / um,displacement", "s,,mm", "0,500,1", "1,700,2")(tmp_path / "a.csv")
    found = table(tmp_path / "a.csv", columns={"displacement": "displacement"})
    assert found.numbers["displacement"].tolist() == [0.001, 0.002]


CSV = rows("time / s,displacement / mm", "0,1", "1,2")


@pytest.mark.parametrize("key", ["sheet", "group", "dataset", "channel"])
def test_refusal_of_a_key_that_the_format_does_not_have(key: str, tmp_path: Path) -> None:
    CSV(tmp_path / "a.csv")
    told = refusal(tmp_path / "a.csv", **{key: "1"}).removeprefix(" [1]")
    assert told.startswith(f": got '{key}' stated for a text; expected a")
    assert told.endswith(f"Fix: leave '{key}' out")


def test_refusal_of_other_keys_that_the_format_does_not_have(tmp_path: Path) -> None:
    CSV(tmp_path / "a.csv")
    assert "got 'member: b.csv' of a file that is no archive" in refusal(tmp_path / "a.csv", member="b.csv")
    writers.npy(tmp_path / "a.npy", {"time / s": STAMPS, "displacement / mm": MOVED})
    assert "got 'dataset' stated for one array; expected an .npz file" in refusal(tmp_path / "a.npy", dataset="a")
    writers.tdms(tmp_path / "a.tdms", TWO, rate=500.0)
    for key, value in {"decimal": "comma", "separator": "tab", "header": "2", "encoding": "utf-8"}.items():
        assert f": got '{key}' stated for a TDMS file" in refusal(tmp_path / "a.tdms", **{key: value})


@pytest.mark.parametrize("encoding", ["undefined", "punycode", "hex", "rot13", "no-such"])
def test_refusal_of_an_encoding_that_is_none(encoding: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time / s,displacement / mm\n0,1\n1,2\n" + "a" * 80, encoding="utf-8")
    told = refusal(tmp_path / "a.csv", encoding=encoding)
    assert told == f": got the encoding '{encoding}'; expected one such as 'utf-8' or 'cp1252'"


# -- what a file has beside the readings


def test_limit_what_macos_adds_to_an_archive_is_no_file_of_readings(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("run/a.csv", "time / s,displacement / mm\n0,1\n1,2\n")
        for name in ("__MACOSX/run/._a.csv", "run/.DS_Store", "run/._a.csv"):
            archive.writestr(name, b"\0\5\x16\7")
    assert table(tmp_path / "a.zip").numbers["displacement"].tolist() == [0.001, 0.002]


def test_twice_a_workbook_of_strict_open_xml_reads_like_another(tmp_path: Path) -> None:
    columns = {"time / s": STAMPS, "displacement / mm": MOVED}
    writers.xlsx(tmp_path / "a.xlsx", columns)
    spaces = {
        b"http://schemas.openxmlformats.org/spreadsheetml/2006/main": b"http://purl.oclc.org/ooxml/spreadsheetml/main",
        b"http://schemas.openxmlformats.org/officeDocument/2006/relationships": (
            b"http://purl.oclc.org/ooxml/officeDocument/relationships"
        ),
    }
    with zipfile.ZipFile(tmp_path / "a.xlsx") as archive, zipfile.ZipFile(tmp_path / "b.xlsx", "w") as strict:
        for name in archive.namelist():
            content = archive.read(name)
            for usual, other in spaces.items():
                content = content.replace(usual, other)
            strict.writestr(name, content)
    first, second = table(tmp_path / "a.xlsx"), table(tmp_path / "b.xlsx")
    assert {name: one.tolist() for name, one in first.numbers.items()} == {
        name: one.tolist() for name, one in second.numbers.items()
    }


# -- marks within numbers


@pytest.mark.parametrize(
    ("cells", "mark"), [(("1.000", "1.181"), "point"), (("1,000", "-1,181"), "comma"), (("1.000", "1,181"), "point")]
)
def test_refusal_of_a_mark_that_may_group_the_digits(cells: tuple[str, ...], mark: str, tmp_path: Path) -> None:
    rows("time / s;displacement / um", *(f"{i};{cell}" for i, cell in enumerate(cells)))(tmp_path / "a.csv")
    other = "comma" if mark == "point" else "point"
    assert refusal(tmp_path / "a.csv") == (
        f": got numbers such as '{cells[0]}', whose {mark} may be a decimal mark or group the digits; "
        f"expected one of the two. Fix: state 'decimal: {mark}', or 'decimal: {other}' and no groups"
    )
    if mark == "point" and "," not in cells[1]:
        found = table(tmp_path / "a.csv", decimal="point")
        assert found.numbers["displacement"].tolist() == [1e-6, 1.181e-6]


@pytest.mark.parametrize("cells", [("0.000", "1.181"), ("1.000", "12.5"), ("1.000", "1000.5")])
def test_planted_a_number_that_is_no_group_settles_the_mark(cells: tuple[str, ...], tmp_path: Path) -> None:
    rows("time / s;displacement / um", *(f"{i};{cell}" for i, cell in enumerate(cells)))(tmp_path / "a.csv")
    assert table(tmp_path / "a.csv").numbers["displacement"].tolist() == [float(cell) / 1e6 for cell in cells]


def test_refusal_of_groups_names_the_mark_that_the_other_numbers_show(tmp_path: Path) -> None:
    rows("time / s;displacement / um", "0,5;890", "0,6;1.154", "0,7;1.418")(tmp_path / "a.csv")
    assert refusal(tmp_path / "a.csv") == (
        ":3 displacement / um: got '1.154', and 1 more down to line 4; expected a number, such as '12,34'. "
        "Fix: the decimal mark is a comma, and nothing groups the digits"
    )
    rows("time / s,displacement / um", '0,"1,218.2"', '1,"1,472.7"', '2,"1,727"', '3,"0,5"')(tmp_path / "a.csv")
    nothing = "Fix: the decimal mark is a point, and nothing groups the digits: take the commas out of the file"
    number = "expected a number, such as '12.34'"
    assert refusal(tmp_path / "a.csv").splitlines() == [
        f":2 displacement / um: got '1,218.2', and 1 more down to line 3; {number}. {nothing}",
        f":4 displacement / um: got '1,727'; {number}. {nothing}; "
        "where the comma is the decimal mark, state 'decimal: comma'",
        f":5 displacement / um: got '0,5'; {number}. "
        "Fix: the decimal mark is a point, unless 'decimal: comma' is stated",
    ]


# -- one cause, one fault


def test_refusal_of_one_cause_is_told_once_with_its_count(tmp_path: Path) -> None:
    rows("time / s,displacement / um", *(f"{i},NaN" for i in range(500)), "500,x")(tmp_path / "a.csv")
    number = "expected a number, such as '12.34'"
    assert refusal(tmp_path / "a.csv") == (
        f":2 displacement / um: got 'NaN', and 499 more down to line 501; {number}\n"
        f":502 displacement / um: got 'x'; {number}"
    )
    rows("time / s,displacement / um", *(f"{i},1,5" for i in range(50)))(tmp_path / "a.csv")
    assert refusal(tmp_path / "a.csv") == (
        ":2: got 3 cells in '0,1,5', and 49 more down to line 51; expected 2, as in the heading. "
        "Fix: the decimal mark is a point; commas separate cells"
    )
    rows("time / s,displacement / um", *(f"{9 - i},1" for i in range(9)))(tmp_path / "a.csv")
    assert refusal(tmp_path / "a.csv").startswith(
        ":3 time / s: got 8 after 9, and 7 more down to line 10; expected time"
    )


def test_planted_a_cell_that_is_nan_is_a_gap_where_gaps_are_allowed(tmp_path: Path) -> None:
    rows("time / s,displacement / um", "0,NaN", "1,2", "2,")(tmp_path / "a.csv")
    found = read(tmp_path / "a.csv", (TIME, Column("displacement", "m", gaps=True)))
    assert [str(one) for one in found.numbers["displacement"]] == ["nan", "2e-06", "nan"]
    assert found.notices == ("'NaN' under 'displacement / um' was read as a gap",)
