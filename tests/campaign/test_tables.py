"""Readings: strict, quick, in SI."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from metrology.declaration.columns import Column
from metrology.errors import MetrologyError
from metrology.readings.files import read

TIME = Column("time", "s", increasing=True)
POSITION = Column("position", "m", gaps=True)


def _write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8", newline="")
    return path


def test_closed_form_units_of_the_heading(tmp_path: Path) -> None:
    path = _write(tmp_path / "a.csv", "# note\nposition/mm,time / ms\n1.5,0\n-2.5e1,1\n")
    table = read(path, [TIME, POSITION])
    assert table.numbers["position"].tolist() == [0.0015, -0.025]
    assert table.numbers["time"].tolist() == [0.0, 0.001]
    assert table.lines.tolist() == [3, 4]
    assert table.units == {"position": "mm", "time": "ms"}
    assert table.at(1, "time") == f"{path}:4 time"


def test_closed_form_decimal_readings_keep_all_their_digits(tmp_path: Path) -> None:
    values = [f"{i / 100:.2f}" for i in range(1, 2000)]
    table = read(_write(tmp_path / "a.csv", "x / mm\n" + "\n".join(values) + "\n"), [Column("x", "m")])
    assert table.numbers["x"] == pytest.approx([float(f"{value}e-3") for value in values], rel=3e-16)


def test_limit_windows_lines_and_blank_lines_at_the_end(tmp_path: Path) -> None:
    table = read(_write(tmp_path / "a.csv", "time / s\r\n0\r\n1\r\n\r\n"), [TIME])
    assert table.numbers["time"].tolist() == [0.0, 1.0]


def test_limit_gaps_where_they_are_allowed(tmp_path: Path) -> None:
    path = _write(tmp_path / "a.csv", "time / s,position / m\n0,1\n1,\n2,3\n")
    assert np.array_equal(read(path, [TIME, POSITION]).numbers["position"], [1, np.nan, 3], equal_nan=True)
    with pytest.raises(MetrologyError, match=r"a\.csv:3 position / m: got an empty cell"):
        read(path, [TIME, Column("position", "m")])


def test_refusal_of_a_channel_that_is_all_gaps(tmp_path: Path) -> None:
    path = _write(tmp_path / "a.csv", "time / s,position / m\n0,\n1,\n")
    with pytest.raises(MetrologyError, match="got gaps alone; expected at least one reading"):
        read(path, [TIME, POSITION])


def test_twice_gzipped_as_plain(tmp_path: Path) -> None:
    text = "time / s,position / m\n0,1\n1,2\n"
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(text.encode()))
    plain = read(_write(tmp_path / "a.csv", text), [TIME, POSITION])
    packed = read(tmp_path / "a.csv.gz", [TIME, POSITION])
    assert packed.numbers["position"].tolist() == plain.numbers["position"].tolist()
    assert packed.source.sha256 != plain.source.sha256


def test_refusal_of_a_truncated_gzip_file(tmp_path: Path) -> None:
    packed = gzip.compress(b"time / s\n" + b"".join(b"%d\n" % i for i in range(1000)))
    (tmp_path / "a.csv.gz").write_bytes(packed[:-20])
    with pytest.raises(MetrologyError, match=r"got a damaged or truncated gzip file; expected a whole gzip file"):
        read(tmp_path / "a.csv.gz", [TIME])


def test_refusal_of_a_gzip_file_that_is_too_large_unpacked(tmp_path: Path) -> None:
    mebibyte = gzip.compress(b"A" * (1 << 20))
    (tmp_path / "a.csv.gz").write_bytes(mebibyte * 65)
    with pytest.raises(MetrologyError) as caught:
        read(tmp_path / "a.csv.gz", [TIME])
    assert [str(fault).partition("a.csv.gz")[2] for fault in caught.value.faults] == [
        ": got a file that is too large; expected at most 64 MiB of readings a file, unpacked. "
        "Fix: split the file, or lower the rate: keep every n-th sample of a record that was filtered before"
    ]


@pytest.mark.parametrize("cell", ["1_000", "١", "0x10", "1e", "inf", "-nan", "1 2", "1.2.3", "--1", "1,5"])
def test_refusal_of_what_python_or_a_person_may_take_for_a_number(cell: str, tmp_path: Path) -> None:
    path = _write(tmp_path / "a.csv", f'x / m\n1\n"{cell}"\n')
    with pytest.raises(MetrologyError, match=r"a\.csv:3 x / m: got ") as caught:
        read(path, [Column("x", "m")])
    assert len(caught.value.faults) == 1


def test_refusal_stops_at_twenty_faults(tmp_path: Path) -> None:
    path = _write(tmp_path / "a.csv", "x / m\n" + "".join(f"bad {i}\n" for i in range(1000)))
    with pytest.raises(MetrologyError) as caught:
        read(path, [Column("x", "m")])
    assert len(caught.value.faults) == 20
    assert ["not listed" in one.got for one in caught.value.faults] == [False] * 19 + [True]


def test_refusal_of_an_unmatched_quotation_mark(tmp_path: Path) -> None:
    path = _write(tmp_path / "a.csv", 'x / m,y / m\n1,2\n"1,2\n3,4\n')
    with pytest.raises(MetrologyError, match=r"a\.csv:3: got .*with an unmatched quotation mark"):
        read(path, [Column("x", "m"), Column("y", "m")])


def test_limit_a_record_of_a_minute_is_read_whole(tmp_path: Path) -> None:
    data = np.column_stack([np.arange(12_000) / 200, *np.random.default_rng(1).normal(size=(3, 12_000))])
    path = tmp_path / "a.csv"
    np.savetxt(path, data, delimiter=",", fmt="%.6f", header="time / s,x / m,v / m/s,T / N", comments="")
    table = read(path, [TIME, Column("x", "m"), Column("v", "m/s"), Column("T", "N")])
    assert np.allclose(table.numbers["T"], data[:, 3], atol=1e-6)
