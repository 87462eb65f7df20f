"""What `metrology import` finds in a file: rates, resolutions and parts as planted; a damaged file is refused."""

from __future__ import annotations

import json
import math
import random
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
import writers

from metrology.campaign.load import load
from metrology.cli import main
from metrology.draft import draft, place
from metrology.draft.instruments import recognise
from metrology.draft.seen import as_words
from metrology.draft.survey import survey
from metrology.errors import MetrologyError

SWUNG = [round(5 * math.cos(0.3 * i) * math.exp(-0.01 * i), 4) for i in range(200)]


def text(path: Path, *lines: str) -> Path:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("stated", "rate"),
    [
        ("Messrate;5 kHz", 5000.0),
        ("Sampling rate: 200", 200.0),
        ("Sample rate=1.25 MHz", 1.25e6),
        ("Sample rate;500 S/s", 500.0),
        ("Data rate: 2 kS/s", 2000.0),
        ("Abtastrate;0,5 Hz", 0.5),
        ("Capture frame rate: 120.5 fps", 120.5),
    ],
)
def test_planted_a_rate_is_read_in_its_unit(stated: str, rate: float) -> None:
    assert (recognise([stated]).rate, recognise([stated]).doubtful) == (rate, "")


def test_planted_headings_behind_number_signs_and_units_in_a_line_of_their_own_are_found(tmp_path: Path) -> None:
    rows = [f"{0.01 * at:.3f}\t{x:.4f}" for at, x in enumerate(SWUNG)]
    notes = ("#Creator: a pendulum", "#Time\tPos", "#[s]\t[mm]")
    found = survey(text(tmp_path / "swing.txt", *notes, *rows))
    assert [(one.name, one.unit, one.role) for one in found.columns] == [
        ("Time", "s", "time"), ("Pos", "mm", "displacement")
    ]  # fmt: skip
    assert "the headings stand behind '#', above line 4" in found.notices
    path, made = draft([tmp_path / "swing.txt"], {"mass": "1.000(1) kg"})
    place(path, made)
    (table,) = load(path).tables["tests", "decay"]
    assert table.numbers["displacement"][:2].tolist() == pytest.approx([5e-3, 1e-3 * SWUNG[1]])


def test_planted_headings_in_any_language_are_known_by_the_units_below_them(tmp_path: Path) -> None:
    rows = (f'"{0.01 * at:.3f}","{x:.4f}"' for at, x in enumerate(SWUNG))
    found = survey(text(tmp_path / "swing.csv", "时间,位移", "(s),(mm)", *rows))
    assert [(one.name, one.unit, one.role) for one in found.columns] == [
        ("时间", "s", "time"), ("位移", "mm", "displacement")
    ]  # fmt: skip


def test_planted_numbered_columns_are_found_between_tabs(tmp_path: Path) -> None:
    rows = (f"{0.01 * at:.3f}\t{x:.4f}" for at, x in enumerate(SWUNG))
    text(tmp_path / "swing.txt", "# by hand", *rows)
    campaign = """
format: metrology-campaign/1
id: swing
title: Swing
instruments: {vib: {kind: vibrometer}}
samples: {s: {material: steel}}
tests:
  swing:
    method: decay
    sample: s
    instruments: {displacement: vib}
    mass: 1.000(1) kg
    readings:
      - file: swing.txt
        rows: [5, 150]
        columns: {time: {column: 1, unit: s}, displacement: {column: 2, unit: mm}}
"""
    (tmp_path / "campaign.yaml").write_text(campaign, encoding="utf-8")
    (table,) = load(tmp_path / "campaign.yaml").tables["tests", "swing"]
    assert table.numbers["displacement"][0] == pytest.approx(1e-3 * SWUNG[3])


def test_refusal_tells_what_an_import_could_not_read(tmp_path: Path) -> None:
    with pytest.raises(MetrologyError, match="no unit is read of 'strain', 'stress'") as told:
        draft([text(tmp_path / "a.csv", "strain,stress", *(f"{x / 1e3},{x}" for x in range(9)))], {})
    assert "write 'stress' times the area of the section as a column such as 'force / N'" in str(told.value)
    with pytest.raises(MetrologyError, match="such as 'force / N' or 'extension_mm'"):
        draft([text(tmp_path / "c.csv", "strain,channel 2", *(f"{x / 1e3},{x}" for x in range(9)))], {})
    with pytest.raises(MetrologyError) as circular:
        draft([text(tmp_path / "b.csv", "名,前", "又,一", *(f"{x},{x}" for x in range(9)))], {})
    assert "metrology import" not in str(circular.value)


def test_planted_units_behind_an_underscore_make_loads_and_readings(tmp_path: Path) -> None:
    rows = (f"{25.8 + 0.6 * at:.1f},{24.36 * at:.2f}" for at in range(6))
    found = survey(text(tmp_path / "a.csv", "spring_deflection_cm,added_mass_g", *rows))
    assert [(one.unit, one.role) for one in found.columns] == [("cm", "displacement"), ("g", "mass")]
    _, made = draft([tmp_path / "a.csv"], {})
    assert "method: elongation" in made.text


@pytest.mark.parametrize("stated", ["10,000 Hz", "10.000 Hz", "1.000,5 Hz", "10 000 Hz", "5 ms", "5 km"])
def test_limit_a_rate_that_may_be_misread_is_asked_for(stated: str, tmp_path: Path) -> None:
    rows = (f"{x:.4f}" for x in SWUNG)
    file = text(tmp_path / "a.txt", f"Sampling rate: {stated}", "Displacement [mm]", *rows)
    assert (survey(file).found.rate, survey(file).found.doubtful) == (0.0, stated)
    asked = draft([file], {})[1].missing["rate"]
    assert asked == f"samples in a second, such as 200 Hz; the file has '{stated}', which may be misread"
    path, made = draft([file], {"mass": "1 kg", "rate": "10 kHz"})
    place(path, made)
    (found,) = load(path).tables["tests", "decay"]
    assert found.numbers["time"][:3].tolist() == [0.0, 0.0001, 0.0002]


@pytest.mark.parametrize(
    ("cells", "resolution"),
    [
        (("1.00e-05", "1.11e-05", "9.80e-06"), 1e-7),
        (("1.2E+03", "-1.3E+03", "0.0E+00"), 1e2),
        (("1,25e-3", "1,26e-3", "1,27e-3"), 1e-5),
        (("0.0001", "1.2e-05", "0"), 1e-6),
        (("0.12", "0.3", "-0.04"), 0.01),
        (("12", "13", "15"), 1.0),
        (("0.123456789", "0.2", "0.3"), 0.0),
    ],
)
def test_planted_the_last_digit_of_readings(cells: tuple[str, ...], resolution: float, tmp_path: Path) -> None:
    file = text(tmp_path / "a.csv", "Zeit [s];Weg [m]", *(f"{i};{cell}" for i, cell in enumerate(cells)))
    assert survey(file).first("displacement").resolution == resolution


def test_planted_steps_of_more_than_the_last_digit_are_the_resolution_of_a_draft(tmp_path: Path) -> None:
    """A camera that is read to half a pixel: the check of raw records refuses the last digit, and then all else."""
    t = np.arange(0.0, 8.0, 1 / 60)
    pixels = 0.5 * np.round(2 * (393.0 + 44.0 * np.exp(-0.03 * t) * np.cos(6.2 * t)))
    file = text(
        tmp_path / "pixels.csv", "time [s];x [mm]", *(f"{a:.4f};{b:.1f}" for a, b in zip(t, pixels, strict=True))
    )
    path, made = draft([file], {"mass": "1 kg"})
    assert "resolution: 0.5 mm   # guess: the step of the readings" in made.text
    place(path, made)
    assert main(["diagnose", str(path), "--output", str(tmp_path)]) == 0
    found = json.loads(next(tmp_path.rglob("results.json")).read_text(encoding="utf-8"))
    assert len(found["diagnosis"]) == 1


@pytest.mark.parametrize("sign", [1, -1])
def test_law_compression_is_drafted_like_tension(sign: int, tmp_path: Path) -> None:
    """Straight to 60 % of the force, then four times as soft; the force of a press may be below zero."""
    forces = [0.5 * i for i in range(100)]
    ways = [0.01 * force + max(0.0, force - 30.0) * 0.03 for force in forces]
    rows = [f"{0.1 * i:.1f},{sign * f:.3f},{sign * x:.4f}" for i, (f, x) in enumerate(zip(forces, ways, strict=True))]
    file = text(tmp_path / "a.csv", "Time [s],Force [N],Displacement [mm]", *rows)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = draft([file], {})[1].text
    assert "range: {share: [10 %, 40 %]}   # guess: the record bends further up" in made


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("2 lb", "{mass: 2 lb}"),
        ("2.0000(2) kg", "{mass: 2.0000(2) kg}"),
        ("20 N", "{force: 20 N}"),
        ("5 mg", "{mass: 5"),
    ],
)
def test_law_a_load_is_a_mass_or_a_force_by_its_dimension(value: str, line: str, tmp_path: Path) -> None:
    file = text(tmp_path / "e.csv", "load,reading / mm", "A,0.41", "B,0.80", "C,1.21")
    assert f"      A: {line}" in draft([file], {"load.A": value})[1].text


@pytest.mark.parametrize(
    ("value", "told"), [("2 mm", "'2 mm', which is a length"), ("2 tonf", "'2 tonf', which is neither")]
)
def test_refusal_of_a_load_that_is_neither(value: str, told: str, tmp_path: Path) -> None:
    file = text(tmp_path / "e.csv", "load,reading / mm", "A,0.41", "B,0.80", "C,1.21")
    with pytest.raises(MetrologyError) as caught:
        draft([file], {"load.A": value})
    assert str(caught.value) == (
        f"--set load.A: got {told}; expected a mass or a force, such as '2.0000(2) kg' or '20 N'"
    )


def two_runs(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for run, unit in (("run1", "um"), ("run2", "mm")):
            file[f"{run}/time"], file[f"{run}/displacement"] = np.arange(200) / 500, np.array(SWUNG)
            file[f"{run}/time"].attrs["units"], file[f"{run}/displacement"].attrs["units"] = "s", unit
        file["set-up/gain"] = np.arange(3.0)


def displacements(path: Path) -> list[list[float]]:
    return [table.numbers["displacement"].tolist() for table in load(path).tables["tests", "decay"]]


@pytest.mark.long
def test_planted_groups_are_runs_and_one_of_them_may_be_stated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    two_runs(tmp_path / "a.h5")
    first, second = [[pytest.approx(x * unit, rel=1e-14) for x in SWUNG] for unit in (1e-6, 1e-3)]
    assert main(["import", str(tmp_path / "a.h5"), "--set", "mass=1 kg"]) == 0
    assert displacements(tmp_path / "a.yaml") == [first, second]
    assert "  note: a.h5: the group 'set-up' is left out, as it looks like no run\n" in capsys.readouterr().out
    arguments = ["--group", "run2", "--set", "mass=1 kg", "--output", str(tmp_path / "b.yaml")]
    assert main(["import", str(tmp_path / "a.h5"), *arguments]) == 0
    assert displacements(tmp_path / "b.yaml") == [second]


@pytest.mark.long
def test_refusal_of_groups_of_which_none_looks_like_a_run(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run1/gain"], file["run2/gain"] = np.arange(3.0), np.arange(4.0)
    with pytest.raises(MetrologyError, match=r"expected one of 'run1', 'run2'. Fix: name it: --group …"):
        draft([tmp_path / "a.h5"], {})


@pytest.mark.long
def test_planted_sheets_are_runs(tmp_path: Path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(["Auftrag", 17])
    for run in (1, 2, 3):
        sheet = book.create_sheet(f"Lauf {run}")
        for row in [("Zeit [s]", "Weg [mm]"), *((i / 500, run * x) for i, x in enumerate(SWUNG))]:
            sheet.append(row)
    book.save(tmp_path / "a.xlsx")
    path, made = draft([tmp_path / "a.xlsx"], {"mass": "1 kg"})
    place(path, made)
    assert [found[0] for found in displacements(path)] == pytest.approx([0.005, 0.010, 0.015])


def test_planted_one_of_several_members_or_sheets_is_imported(tmp_path: Path) -> None:
    columns = {"time / s": [i / 500 for i in range(200)], "displacement / mm": SWUNG}
    writers.csv(tmp_path / "a.csv", columns)
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        for name in ("a.csv", "b.csv"):
            archive.write(tmp_path / "a.csv", name)
        archive.writestr("__MACOSX/._a.csv", b"\0\5\x16\7")
    with pytest.raises(MetrologyError, match=r"2 files in it .* one of a.csv, b.csv. Fix: name it: --member …"):
        survey(tmp_path / "a.zip")
    assert survey(tmp_path / "a.zip", {"member": "b.csv"}).stated["member"] == "b.csv"
    with pytest.raises(MetrologyError, match="'sheet' stated for a text; expected an Excel workbook or"):
        survey(tmp_path / "a.csv", {"sheet": "b"})


def test_refusal_of_channels_that_were_sampled_at_other_times(tmp_path: Path) -> None:
    said = {"displacement": {"wf_increment": 0.002}, "velocity": {"wf_increment": 0.005}}
    writers.tdms(tmp_path / "a.tdms", {"displacement / mm": SWUNG, "velocity / mm/s": SWUNG}, said=said)
    with pytest.raises(MetrologyError, match=r"sampled at different times: 'velocity' with a step of 0\.005 s"):
        survey(tmp_path / "a.tdms")


def test_refusal_names_the_file_of_several(tmp_path: Path) -> None:
    first = text(tmp_path / "a.csv", "time / s,displacement / mm", *(f"{i / 500},{x}" for i, x in enumerate(SWUNG)))
    second = text(tmp_path / "b.csv", "time / s,displacement / mm", "0,\0")
    with pytest.raises(MetrologyError) as caught:
        draft([first, second], {})
    assert str(caught.value) == f"{second}:2: got a null character; expected lines of plain text"


@pytest.mark.parametrize("suffix", ["uff", "tdms", "npz"])
def test_refusal_of_a_damaged_file_whatever_its_library_raises(suffix: str, tmp_path: Path) -> None:
    """Some characters changed at random: every file is read or refused, and no exception of a library comes through."""
    columns = {"time / s": [i / 500 for i in range(60)], "displacement / mm": SWUNG[:60]}
    path = tmp_path / f"a.{suffix}"
    getattr(writers, suffix)(path, columns)
    whole, drawn, told = path.read_bytes(), random.Random(1), []
    for number in range(60):
        content = bytearray(whole)
        for _ in range(drawn.choice((1, 2, 6, 20))):
            letter = drawn.choice(b"0123456789 -.,eE\nab") if suffix == "uff" else drawn.randrange(256)
            content[drawn.randrange(min(len(content), 700))] = letter
        path.write_bytes(content[: drawn.randrange(len(content))] if number % 3 == 0 else content)
        try:
            survey(path)
        except MetrologyError as error:
            told.append(str(error))
    assert len(told) > 5
    assert all(one.startswith(str(path)) for one in told)


# -- what a file leaves open


def test_limit_a_mark_that_may_group_the_digits_is_asked_for(tmp_path: Path) -> None:
    """German thousands: 1.000 N at 50000 um is a stiffness of 0.02 N/um, and no thousandth of it."""
    rows = [f"{1000 + 182 * i}"[:1] + "." + f"{1000 + 182 * i}"[1:] + f";{50000 + 9100 * i}" for i in range(12)]
    file = text(tmp_path / "e.csv", "Kraft [N];Weg [um]", *rows)
    made = draft([file], {})[1]
    assert made.missing["decimal"].startswith("decimal mark, such as point or comma, of '1.000'; take the marks out")
    assert '      decimal: "?"\n' in made.text
    assert "decimal: point\n" in draft([file], {"decimal": "point"})[1].text
    with pytest.raises(MetrologyError, match="--set decimal: got 'dot'; expected 'point' or 'comma'"):
        draft([file], {"decimal": "dot"})


def test_limit_a_separator_is_a_guess_where_the_headings_have_another_mark(tmp_path: Path) -> None:
    rows = [f"{i / 500};{x:.4f};a" for i, x in enumerate(SWUNG)]
    file = text(tmp_path / "a.csv", "Zeit [s];Weg [mm];Notiz, kurz", *rows)
    assert "separator: semicolon   # guess: the headings have other marks, too" in draft([file], {})[1].text
    file = text(tmp_path / "b.csv", "Zeit [s];Weg [mm];Notiz", *rows)
    assert "separator: semicolon\n" in draft([file], {})[1].text


def test_limit_a_time_without_a_unit_is_asked_for(tmp_path: Path) -> None:
    file = text(tmp_path / "a.csv", "t,x [mm]", *(f"{i / 2},{x}" for i, x in enumerate(SWUNG)))
    made = draft([file], {"mass": "1 kg"})[1]
    assert made.missing == {"unit.time": "unit of 't', such as s"}
    assert "unit: ms" in draft([file], {"mass": "1 kg", "unit.time": "ms"})[1].text


def test_planted_digits_that_readings_share_are_the_resolution_and_doubles_share_none(tmp_path: Path) -> None:
    times = np.arange(200) / 500
    for values, told in (
        (np.array(SWUNG), "resolution: 0.0001 mm   # guess"),
        (np.array(SWUNG, dtype=np.float32), "resolution: 0.0001 mm   # guess"),
        (np.array(SWUNG) / 3, "# resolution: …   # the readings share no last digit"),
    ):
        np.savez(tmp_path / "a.npz", **{"time / s": times, "displacement / mm": values})
        assert told in draft([tmp_path / "a.npz"], {})[1].text


def test_planted_numbers_that_a_workbook_holds_as_texts(tmp_path: Path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    for row in [("Zeit [s]", "Weg [mm]"), *((f"{i / 500:.3f}", f"{x:.3f}") for i, x in enumerate(SWUNG))]:
        book.active.append([cell.replace(".", ",") for cell in row])
    book.save(tmp_path / "a.xlsx")
    path, made = draft([tmp_path / "a.xlsx"], {"mass": "1 kg"})
    assert "decimal: comma   # guess: numbers stand as texts with a comma" in made.text
    assert "resolution: 0.001 mm   # guess: the last digit of the readings" in made.text
    place(path, made)
    (found,) = load(path).tables["tests", "decay"]
    assert found.numbers["displacement"].tolist() == pytest.approx([round(x, 3) / 1000 for x in SWUNG], rel=1e-14)


@pytest.mark.parametrize(("stated", "unit", "told"), [(1000, "s", True), (2000, "s", False), (2000, "ms", True)])
def test_planted_a_rate_in_the_header_is_held_against_the_stamps(
    stated: int, unit: str, told: bool, tmp_path: Path
) -> None:
    rows = [f"{i / 2000:.4f};{x:.4f}" for i, x in enumerate(SWUNG)]
    file = text(tmp_path / "a.csv", f"Sample rate;{stated} Hz", "", f"Time [{unit}];Displacement [mm]", *rows)
    made = draft([file], {"mass": "1 kg"})[1]
    found = f"the header has {stated} Hz, the stamps {'2000' if unit == 's' else '2e+06'} Hz"
    assert made.remarks == [f"a.csv: {found}: find out which is right"] * told
    assert (f"   # guess: {found}\n" in made.text) == told


# -- stretches of stamps


def stretches(path: Path, *starts: tuple[float, int]) -> Path:
    rows = [f"{start + i / 500:.3f},{x}" for start, size in starts for i, x in enumerate(SWUNG[:size])]
    return text(path, "time / s,displacement / mm", *rows)


def test_planted_stretches_that_start_again_are_releases(tmp_path: Path) -> None:
    file = stretches(tmp_path / "a.csv", (0, 200), (0, 150), (0, 10), (0, 180))
    path, made = draft([file], {"mass": "1 kg"})
    assert made.remarks == ["a.csv: rows 352 to 361 are left out, as time stamps do not increase there"]
    place(path, made)
    assert displacements(path) == [[pytest.approx(x / 1000) for x in SWUNG[:size]] for size in (200, 150, 180)]


def test_limit_a_stamp_that_comes_twice_begins_no_release(tmp_path: Path) -> None:
    file = stretches(tmp_path / "a.csv", (0, 60), (59 / 500, 140))
    made = draft([file], {"mass": "1 kg"})[1]
    assert made.remarks == ["a.csv: rows 2 to 61 are left out, as time stamps do not increase there"]
    assert made.text.count("rows: [") == 1
    assert "rows: [62, 201]   # guess: the longest stretch of stamps that increase" in made.text


def test_law_numbers_of_single_precision_have_its_digits_and_whole_ones_all_of_theirs() -> None:
    cells = np.array([0.1, 12345678.0, -2.5e-7], dtype=np.float32).astype(np.float64).tolist()
    assert as_words(cells) == ("0.1", "12345678", "-2.5e-07")
    assert as_words([0.1, 1 / 3]) == ("0.1", "0.333333333333333")
    assert as_words(["0,1 ", 2.0]) == ("0,1", "2")


def test_planted_a_run_is_numbered_behind_the_unit(tmp_path: Path) -> None:
    rows = [f"{0.01 * at:.3f};{x:.4f};".replace(".", ",") for at, x in enumerate(SWUNG)]
    heads = '"Time (s) Run #1";"Position (cm) Run #1";"Velocity (m/s) Run #1"'
    found = survey(text(tmp_path / "swing.csv", heads, *rows))
    assert [(one.name, one.unit, one.role) for one in found.columns[:2]] == [
        ("Time Run #1", "s", "time"), ("Position Run #1", "cm", "displacement")
    ]  # fmt: skip
    path, made = draft([tmp_path / "swing.csv"], {"mass": "1.000(1) kg"})
    assert made.missing == {}
    place(path, made)
    (table,) = load(path).tables["tests", "decay"]
    assert table.numbers["displacement"][:2].tolist() == pytest.approx([5e-2, 1e-2 * SWUNG[1]])


@pytest.mark.parametrize("heads", ["Time A;Pos A;Time B;Pos B", "t1 / s;x1 / mm;t2 / s;x2 / mm"])
def test_planted_of_two_sensors_that_which_moves_is_taken_with_its_own_stamps(heads: str, tmp_path: Path) -> None:
    rows = [f"{0.01 * at:.3f};{7 + at % 2 / 100};{0.01 * at + 0.005:.3f};{x:.4f}" for at, x in enumerate(SWUNG)]
    units = () if "/" in heads else ("s;mm;s;mm",)
    path, made = draft([text(tmp_path / "swing.csv", heads, *units, *rows)], {"mass": "1.000(1) kg"})
    place(path, made)
    (table,) = load(path).tables["tests", "decay"]
    assert table.numbers["time"][:2].tolist() == pytest.approx([5e-3, 15e-3])
    assert table.numbers["displacement"][:2].tolist() == pytest.approx([5e-3, 1e-3 * SWUNG[1]])


def test_planted_grams_as_they_are_abbreviated_are_loads_and_a_load_in_cm_is_a_reading(tmp_path: Path) -> None:
    rows = [f"{50 * at},{20 + 3 * at}" for at in range(1, 7)]
    found = survey(text(tmp_path / "spring.csv", "Mass of load (gm),Load increasing (cm)", *rows))
    assert [(one.unit, one.role) for one in found.columns] == [("g", "mass"), ("cm", "reading")]
    path, made = draft([tmp_path / "spring.csv"], {})
    assert made.missing == {}
    place(path, made)
    assert "L1: {mass: 50 g}" in path.read_text(encoding="utf-8")
