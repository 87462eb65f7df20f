"""`metrology import`: files that nobody described become a campaign that runs, with every guess marked."""

from __future__ import annotations

import gzip
import io
import json
import math
import re
from pathlib import Path

import exports
import pytest
import writers

from metrology import chain
from metrology.campaign.load import load
from metrology.cli import main
from metrology.draft import draft, place
from metrology.draft.instruments import recognise
from metrology.errors import MetrologyError

DIAGNOSED = "\ndiagnosis: {off: true}\nmonte_carlo: {max_trials: 1000, digits: 1}\n"


def lvm(path: Path) -> None:
    writers.lvm(path, {"time / s": exports.STAMPS, "Weg / um": exports.MOVED})


def tdms(path: Path) -> None:
    writers.tdms(path, {"Zeit / s": exports.STAMPS, "Auslenkung / um": exports.MOVED})


DECAYS = {
    "polytec.txt": (exports.polytec, "Polytec"),
    "motive.csv": (exports.motive, "OptiTrack Motive"),
    "vicon.csv": (exports.vicon, "Vicon Nexus"),
    "labview.lvm": (lvm, "LabVIEW"),
    "diadem.tdms": (tdms, ""),
}
LINES = {
    "zwick.tra": (exports.zwick, "ZwickRoell testXpert"),
    "instron.csv": (exports.instron, "Instron Bluehill"),
    "mts.txt": (exports.mts, "MTS"),
}


def evaluated(path: Path):
    path.write_text(path.read_text(encoding="utf-8") + DIAGNOSED, encoding="utf-8")
    return {result.quantity: result for result in chain.evaluate(load(path)).results}


def imported(folder: Path, files: list[str], **given: str) -> Path:
    path, made = draft([folder / file for file in files], given)
    assert made.missing == {}
    place(path, made)
    return path


@pytest.mark.long
def test_planted_the_slope_of_a_german_workbook_is_found_without_a_word(tmp_path: Path) -> None:
    exports.german_workbook(tmp_path / "Messung.xlsx")
    path = imported(tmp_path, ["Messung.xlsx"])
    k = evaluated(path)["k"]
    assert k.value == pytest.approx(9.806 * (1 - 1.2 / 8000) / 0.4e-3, rel=0.02)
    assert path.name == "Messung.yaml"


@pytest.mark.parametrize("file", DECAYS)
def test_planted_the_frequency_of_an_instruments_export_is_found(file: str, tmp_path: Path) -> None:
    write, maker = DECAYS[file]
    write(tmp_path / file)
    path = imported(tmp_path, [file], mass="1.000(1) kg")
    assert maker in path.read_text(encoding="utf-8")
    assert evaluated(path)["omega_n"].value == pytest.approx(140.032, rel=1e-4)


MACHINE = {"class.cell": "0.5", "length": "60.0(2) mm"}


@pytest.mark.parametrize("file", LINES)
def test_planted_the_stiffness_of_a_testing_machines_export_is_found(file: str, tmp_path: Path) -> None:
    write, maker = LINES[file]
    write(tmp_path / file)
    path = imported(tmp_path, [file], **MACHINE)
    assert maker in path.read_text(encoding="utf-8")
    assert evaluated(path)["k"].value == pytest.approx(1000 * exports.SLOPE, rel=3e-3)


def test_planted_a_pull_with_an_extensometer_gives_the_modulus_and_nothing_is_typed_twice(tmp_path: Path) -> None:
    files = [f"zug-{number}.tra" for number in (1, 2)]
    for number, file in enumerate(files):
        exports.zwick_with_strain(tmp_path / file, number)
    path = imported(tmp_path, files, **{"class.cell": "0.5", "class.extensometer": "0.5"})
    text = path.read_text(encoding="utf-8")
    assert "section: {shape: tape, width: 10.00 mm, thickness: 1.00 mm}   # from the file" in text
    assert "instruments: {force: cell, crosshead: crosshead, strain: extensometer}   # guess: by the headings" in text
    assert evaluated(path)["E"].value == pytest.approx(exports.MODULUS, rel=0.01)


def test_planted_of_two_strains_that_along_the_load_is_taken_and_a_bend_is_left_out(tmp_path: Path) -> None:
    """Image correlation reads the contraction as well; beyond 60 % of the force the specimen flows."""
    rows = ["Machine_Load,Machine_Displacement,exx,eyy,Original Diameter (mm)"]
    for i in range(300):
        force = min(i * 10.0, 1800.0 + i)
        along = force * 1e-6 + max(0, i - 181) * 1e-4
        noise = 1e-7 * ((7 * i) % 5 - 2)
        rows.append(f"{force:.2f},{i * 0.01:.3f},{-0.3 * along:.7f},{along + noise:.7f},{7.1 if i == 0 else ''}")
    (tmp_path / "dic.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    units = {"unit.force": "N", "unit.crosshead": "mm"}
    path = imported(tmp_path, ["dic.csv"], **units, **{"class.cell": "0.5", "class.extensometer": "1"})
    text = path.read_text(encoding="utf-8")
    assert "strain: {column: eyy, unit: 1}" in text
    assert "range: {share: [10 %, 40 %]}   # guess: the record bends further up" in text
    assert "section: {shape: round, diameter: 7.1 mm}" in text
    assert evaluated(path)["EA"].value == pytest.approx(1e6, rel=0.01)


def test_planted_sizes_on_a_first_row_whose_stamp_repeats_are_kept(tmp_path: Path) -> None:
    rows = ["Time (s),Extension (mm),Load (kN),Strain (mm/mm),Original Length (mm),Original Diameter (mm)"]
    for i in range(200):
        strain = 2.5e-7 * i + 1e-7 * ((7 * i) % 5 - 2)
        sizes = "," if i else "25.4,7.13"
        rows.append(f"{max(i - 1, 0) * 0.5},{0.004 * i:.3f},{0.01 * i:.4f},{strain:.9f},{sizes}")
    (tmp_path / "bar.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    path = imported(tmp_path, ["bar.csv"], **{"class.cell": "0.5", "class.extensometer": "0.5"})
    text = path.read_text(encoding="utf-8")
    assert "section: {shape: round, diameter: 7.13 mm}" in text
    assert "gauge_length: 25.4 mm   # from the file" in text
    found = evaluated(path)
    assert found["EA"].value == pytest.approx(4e7, rel=0.01)
    # what the crosshead moves beyond the gauge length: 0.4 mm/kN less 25.4 mm of strain
    assert found["C"].value == pytest.approx(4e-7 - 25.4e-3 * 2.5e-8, rel=0.01)


@pytest.mark.parametrize(("held", "title"), [("elongation", "Relaxation"), ("load", "Creep")])
def test_planted_what_is_held_is_found(held: str, title: str, tmp_path: Path) -> None:
    exports.hold(tmp_path / "halt.csv", held)
    text = imported(tmp_path, ["halt.csv"], **MACHINE, **{"class.crosshead": "1"}).read_text(encoding="utf-8")
    assert f"held: {held}   # guess" in text
    assert f'title: "{title}, halt"' in text
    assert "section: {shape: round, diameter: 0.50 mm}   # from the file" in text
    assert load(tmp_path / "halt.yaml").tests["hold"].held == held


def test_planted_runs_under_thrust_are_a_response_test(tmp_path: Path) -> None:
    files = ["lauf1.csv", "lauf2.csv"]
    for thrust, file in zip((0.4, 0.6), files, strict=True):
        exports.thrust(tmp_path / file, thrust)
    path = imported(tmp_path, files, mass="25.00 kg")
    test = load(path).tests["response"]
    assert [run.purpose for run in test.runs.values()] == ["identification", "verification"]
    assert test.rig.taut.si == pytest.approx(1.5, abs=1e-3)
    assert test.identification.start.k.si == pytest.approx(169.0, rel=0.02)
    assert test.runs["run-1"].held_until.si == pytest.approx(0.99)
    assert test.runs["run-1"].start.position.si == pytest.approx(1.45, abs=1e-5)
    text = path.read_text(encoding="utf-8")
    assert "start_position: {per_run: 3e-05 m, source: scatter of the rest}" in text
    taut, spread = (
        float(re.search(rf"{key}: (?:{{common: )?([\d.e-]+) m", text)[1]) for key in ("taut", "free_length")
    )
    assert abs(taut - 1.5) < 3 * spread < 1e-3


def test_planted_the_force_of_a_run_lies_in_a_file_of_its_own(tmp_path: Path) -> None:
    """No speed was read: that of the positions before and after serves, and the line is taut where it was planted."""
    for number, thrust in enumerate((0.4, 0.6, 0.5), start=1):
        exports.thrust(tmp_path / "whole.csv", thrust)
        rows = [line.split(";") for line in (tmp_path / "whole.csv").read_text(encoding="utf-8").splitlines()]
        for name, kept, every in (("motion", (0, 1, 4), 1), ("force", (0, 3), 2)):
            text = "\n".join([";".join(rows[0][at] for at in kept)]
                             + [";".join(row[at] for at in kept) for row in rows[1::every]])  # fmt: skip
            (tmp_path / f"run{number}_{name}.csv").write_text(text + "\n", encoding="utf-8")
    files = sorted(one.name for one in tmp_path.glob("run*.csv"))
    path = imported(tmp_path, files, mass="25.00 kg")
    test = load(path).tests["response"]
    assert [[one.file for one in run.readings] for run in test.runs.values()] == [
        [f"run{number}_{name}.csv" for name in ("motion", "force")] for number in (1, 2, 3)
    ]
    assert test.rig.taut.si == pytest.approx(1.5, abs=1e-4)
    assert test.identification.start.k.si == pytest.approx(169.0, rel=0.02)
    with pytest.raises(MetrologyError):
        draft([tmp_path / one for one in files[:-1]], {"mass": "25 kg"})


def test_limit_a_strain_by_the_crosshead_is_no_extensometer(tmp_path: Path) -> None:
    exports.instron(tmp_path / "i.csv")
    head, *rows = (tmp_path / "i.csv").read_text(encoding="utf-8").splitlines()
    added = ["", ',"Tensile strain (Extension)"', ',"(mm/mm)"', *(f',"{x / 60:.7f}"' for x in exports.PULLED)]
    text = "\n".join([head, *(row + more for row, more in zip(rows, added, strict=True))]) + "\n"
    (tmp_path / "i.csv").write_text(text, encoding="utf-8")
    assert "instruments: {force: cell, crosshead: crosshead}" in imported(tmp_path, ["i.csv"], **MACHINE).read_text(
        "utf-8"
    )


def test_limit_of_stamps_that_start_again_the_longest_stretch_is_used(tmp_path: Path) -> None:
    exports.polytec(tmp_path / "p.txt")
    text = (tmp_path / "p.txt").read_text(encoding="utf-8").splitlines()
    (tmp_path / "p.txt").write_text("\n".join([*text[:8], *text[7:]]) + "\n", encoding="utf-8")
    path = imported(tmp_path, ["p.txt"], mass="1 kg")
    assert "rows: [9, 608]   # guess: the longest stretch of stamps that increase" in path.read_text(encoding="utf-8")
    assert evaluated(path)["omega_n"].value == pytest.approx(140.032, rel=1e-4)


def test_planted_loads_that_are_read_once_make_an_elongation(tmp_path: Path) -> None:
    """A decimal comma in the column of loads: the words of the file stand for loads by other names."""
    text = "Last [kg];Ablesung [mm]\n" + "".join(f"{m},0;{0.4 * m:.2f}\n".replace(".", ",") for m in range(1, 7))
    (tmp_path / "e.csv").write_text(text, encoding="utf-8")
    path = imported(tmp_path, ["e.csv"])
    assert 'words: {"1,0": L1' in path.read_text(encoding="utf-8")
    assert evaluated(path)["k"].value == pytest.approx(9.806 * (1 - 1.2 / 8000) / 0.4e-3, rel=0.01)


def test_planted_loads_in_thousands_beside_a_decimal_comma(tmp_path: Path) -> None:
    """``1.000`` grams beside readings of ``0,489`` is a kilogram: as one gram, k was a thousandth."""
    text = "Last [g];Ablesung [mm]\n500;0,245\n1.000;0,489\n2.000;0,978\n3.000;1,467\n4.000;1,955\n5.000;2,446\n"
    (tmp_path / "e.csv").write_text(text, encoding="utf-8")
    path = imported(tmp_path, ["e.csv"])
    assert "{mass: 1000 g}" in path.read_text(encoding="utf-8")
    assert evaluated(path)["k"].value == pytest.approx(9.806 / 0.489e-3, rel=0.01)


def test_planted_columns_side_by_side_are_a_test_each(tmp_path: Path) -> None:
    """Two springs read at the same loads, 250 N/m and 200 N/m; a column of a mean is none of them."""
    rows = [f"{m},{9.806 * m / 250:.4f},{9.806 * m / 200:.4f},{m}" for m in range(1, 9)]
    text = "\n".join(["Mass (kg),Spring 1 (m),Spring 2 (m),Mean (m)", *rows]) + "\n"
    (tmp_path / "e.csv").write_text(text, encoding="utf-8")
    path = imported(tmp_path, ["e.csv"])
    assert "name: Spring 2   # guess: by the heading" in path.read_text(encoding="utf-8")
    assert "# left out: Spring 2 (m) (3: a test of its own), Mean (m) (4)" in path.read_text(encoding="utf-8")
    path.write_text(path.read_text(encoding="utf-8") + DIAGNOSED, encoding="utf-8")
    k = {result.test: result.value for result in chain.evaluate(load(path)).results if result.quantity == "k"}
    air = 1 - 1.2 / 8000
    assert k == {
        "elongation-1": pytest.approx(250 * air, rel=1e-3),
        "elongation-2": pytest.approx(200 * air, rel=1e-3),
    }


def test_planted_loads_without_a_unit_are_asked_for_at_once(tmp_path: Path) -> None:
    rows = [f"{m},{9.806e-3 * m / 0.02:.2f}" for m in (5, 15.1, 24.9, 35, 45.2)]
    (tmp_path / "e.csv").write_text("\n".join(["pesi,allungamento [mm]", *rows]) + "\n", encoding="utf-8")
    missing = draft([tmp_path / "e.csv"], {})[1].missing
    assert missing == {"unit.load": "unit of 'pesi', such as g or N: every load is its number in it"}
    with pytest.raises(MetrologyError, match=r"--set unit\.load: got '5 mm', which is a length; expected a mass"):
        draft([tmp_path / "e.csv"], {"unit.load": "mm"})
    k = evaluated(imported(tmp_path, ["e.csv"], **{"unit.load": "g"}))["k"]
    assert k.value == pytest.approx(20 * (1 - 1.2 / 8000), rel=1e-3)
    steps = [f"{step},{0.4 * step:.2f}" for step in range(1, 6)]
    (tmp_path / "s.csv").write_text("\n".join(["load,reading / mm", *steps]) + "\n", encoding="utf-8")
    assert list(draft([tmp_path / "s.csv"], {})[1].missing) == [f"load.L{step}" for step in range(1, 6)]


def test_refusal_of_files_of_several_kinds_names_each(tmp_path: Path) -> None:
    exports.polytec(tmp_path / "a.txt")
    exports.zwick(tmp_path / "b.tra")
    with pytest.raises(MetrologyError, match=r"got files of several kinds \(a.txt: decay, b.tra: tension\)"):
        draft([tmp_path / "a.txt", tmp_path / "b.tra"], {})


def test_law_every_guess_is_marked_and_every_fact_has_its_source(tmp_path: Path) -> None:
    exports.zwick(tmp_path / "zwick.tra")
    text = imported(tmp_path, ["zwick.tra"], **MACHINE).read_text(encoding="utf-8")
    assert "crosshead: {column: Standardweg}   # guess: by its heading" in text
    exports.polytec(tmp_path / "p.txt")
    text = imported(tmp_path, ["p.txt"], mass="1 kg").read_text(encoding="utf-8")
    assert "date: 2026-10-05   # from the file" in text
    assert "resolution: 0.001 um   # guess: the last digit of the readings" in text


def test_twice_several_files_are_the_releases_of_one_test(tmp_path: Path) -> None:
    for name in ("a.txt", "b.txt"):
        exports.polytec(tmp_path / name)
    # A release of its own: the numbers of the other would be a copy.
    other = re.sub(r"(?m)^([\d.]+\t-?[\d.]+)$", r"\g<1>7", (tmp_path / "b.txt").read_text("utf-8"))
    (tmp_path / "b.txt.gz").write_bytes(gzip.compress(other.encode()))
    path = imported(tmp_path, ["a.txt", "b.txt.gz"], mass="1 kg")
    assert [table.name for table in load(path).tables["tests", "decay"]] == ["a.txt", "b.txt.gz"]


def test_refusal_of_a_draft_in_which_something_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exports.polytec(tmp_path / "run.txt")
    assert main(["import", str(tmp_path / "run.txt")]) == 0
    said = capsys.readouterr().out
    assert "to fill in: mass that swings, such as 1.196(1) kg (--set mass=…)" in said
    assert main(["check", "--json", str(tmp_path / "run.yaml")]) == 2
    (entry,) = json.loads(capsys.readouterr().out)
    assert [fault["got"] for fault in entry["faults"]] == ["'?'"]
    assert "tests.decay.mass" in entry["faults"][0]["where"]


class Terminal(io.StringIO):
    """A terminal at which somebody types."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("typed", "left"), [("1.196(1) kg\n", 0), ("\n", 1), ("", 1)])
def test_limit_what_is_missing_is_asked_for_and_may_be_left_open(
    typed: str, left: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    exports.polytec(tmp_path / "run.txt")
    monkeypatch.setattr("sys.stdin", Terminal(typed))
    assert main(["import", str(tmp_path / "run.txt")]) == 0
    assert capsys.readouterr().out.count("to fill in: mass that swings") == left
    assert ("mass: 1.196(1) kg" in (tmp_path / "run.yaml").read_text(encoding="utf-8")) == (not left)


def test_misuse_a_voltage_is_to_be_multiplied_by_the_sensitivity_of_its_sensor(tmp_path: Path) -> None:
    rows = ["Time ( s )\tVoltage ( mV )", *(f"{i / 10:.1f}\t{13 * math.cos(i):.3f}" for i in range(90))]
    (tmp_path / "v.txt").write_text("\n".join(rows) + "\n", encoding="utf-8")
    with pytest.raises(MetrologyError) as caught:
        draft([tmp_path / "v.txt"], {"mass": "1 kg"})
    assert "Fix: multiply 'Voltage ( mV )' by the sensitivity of its sensor" in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run.txt", "--set", "mas=1 kg"], "--set mas: got 'mas', which this draft does not have; expected one of id"),
        (["run.txt", "--set", "mass"], "--set mass: got no value; expected a name and a value"),
        (["run.txt", "--output", "run.txt"], "run.txt: got a file that exists; expected a new one"),
        (["run.txt", "--output", "below/c.yaml"], "run.txt: got a file elsewhere; expected a file in below"),
        (["poem.txt"], "poem.txt: got no table of numbers; expected headings above columns of numbers"),
        (["table.csv"], "table.csv: got columns of no known test ('p / Pa' looks like nothing known"),
    ],
)
def test_refusal_of_what_cannot_be_imported(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    exports.polytec(tmp_path / "run.txt")
    (tmp_path / "below").mkdir()
    (tmp_path / "poem.txt").write_text("Roses\nare\nred\nand\nblue\n", encoding="utf-8")
    (tmp_path / "table.csv").write_text("p / Pa,T / K\n1,2\n2,3\n4,4\n", encoding="utf-8")
    assert main(["import", *arguments]) == 2
    assert capsys.readouterr().err.startswith(message)


def test_closed_form_what_a_header_block_says() -> None:
    found = recognise(
        ["MTS TestSuite", "Operator: A. Smith", "Serial No;0123", "Sample Rate [Hz]", "Sampling rate=200 Hz"]
    )
    assert found.maker == "MTS"
    assert found.rate == 200.0
    assert found.facts == {"operator": "A. Smith", "serial": "0123"}


def test_refusal_of_a_file_without_columns_names_what_it_has(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time / s,force / N\n0,1\n1,2\n2,3\n", encoding="utf-8")
    with pytest.raises(MetrologyError, match="'time / s' looks like time; 'force / N' looks like force"):
        draft([tmp_path / "a.csv"], {})


def test_planted_each_specimen_has_the_sizes_of_its_own_file(tmp_path: Path) -> None:
    """One modulus of strips of three widths: with the width of the first for all, it would scatter by the half."""
    for name, width in (("A1", 10.0), ("A2", 20.0), ("A3", 5.0)):
        head = [f"Specimen label,{name}", f"Width,{width:.2f},mm", "Thickness,2.00,mm", "Length,100.00,mm", ""]
        rows = [f"{0.01 * i:.2f},{2500 * width * 2 * 1e-4 * i + 0.002 * ((7 * i) % 5 - 2):.3f}" for i in range(100)]
        text = "\n".join([*head, "Extension,Load", "(mm),(N)", *rows]) + "\n"
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    path = imported(tmp_path, ["A1.csv", "A2.csv", "A3.csv"], **{"class.cell": "0.5"})
    specimens = load(path).tests["tension"].specimens
    assert [one.section.width.si for one in specimens.values()] == pytest.approx([0.01, 0.02, 0.005])
    assert [one.remark for one in specimens.values()] == ["A1", "A2", "A3"]
    assert load(path).samples["sample"].section is None
    assert evaluated(path)["E"].value == pytest.approx(2.5e9, rel=2e-3)


def test_limit_files_that_differ_in_what_a_test_has_once_are_told(tmp_path: Path) -> None:
    for name, operator in (("a.txt", "A. Smith"), ("b.txt", "B. Jones")):
        exports.polytec(tmp_path / name)
        text = (tmp_path / name).read_text(encoding="utf-8")
        head = f"Operator:\t{operator}\nDiameter\t{len(operator)}.0\tmm\n"
        (tmp_path / name).write_text(head + text.replace("2026-10-05", f"2026-10-0{len(operator)}"), encoding="utf-8")
    (tmp_path / "c.txt").write_text((tmp_path / "a.txt").read_text("utf-8").replace("Diameter\t8", "Diameter\t9"))
    made = draft([tmp_path / "a.txt", tmp_path / "c.txt"], {"mass": "1 kg"})[1]
    told = "a.txt: {shape: round, diameter: 8.0 mm}; c.txt: {shape: round, diameter: 9.0 mm}"
    assert made.remarks == [f"the files differ in the section of the sample ({told})"]
    assert "    # section: …   # the files differ" in made.text
    assert "operator" not in draft([tmp_path / "a.txt", tmp_path / "b.txt"], {"mass": "1 kg"})[1].text


def test_refusal_of_a_draft_whose_readings_have_faults_names_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [f"{i / 500},{x}" for i, x in enumerate(exports.MOVED)]
    (tmp_path / "run.csv").write_text("\n".join(["time / s,displacement / mm", *rows, "Mean,1.5"]) + "\n", "utf-8")
    assert main(["import", str(tmp_path / "run.csv")]) == 1
    said = capsys.readouterr().out.splitlines()
    file = tmp_path / "run.csv"
    assert said[1:] == [
        "  to fill in: mass that swings, such as 1.196(1) kg (--set mass=…)",
        f"  to correct: {file}:602 time / s: got 'Mean'; expected a number, such as '12.34'",
        f"When that is corrected: metrology report {tmp_path / 'run.yaml'}",
    ]


def test_limit_what_is_missing_is_no_fault_of_a_draft(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever the question, its example stands for the answer while the draft is read back."""
    (tmp_path / "e.csv").write_text("load,x\nA,0.41\nB,0.80\nC,1.21\nD,1.60\nE,2.01\nF,2.40\n", "utf-8")
    exports.hold(tmp_path / "h.csv", "load")
    exports.thrust(tmp_path / "t.csv", 0.4)
    rows = "".join(f"{1000 + i}"[:1] + "." + f"{1000 + i}"[1:] + f";{50000 + 91 * i}\n" for i in range(12))
    (tmp_path / "d.csv").write_text(f"Kraft [N];Weg [um]\n{rows}", "utf-8")
    for name in "ehtd":
        assert main(["import", str(tmp_path / f"{name}.csv")]) == 0
        assert "to correct" not in capsys.readouterr().out


def test_limit_the_command_that_is_told_runs_in_a_shell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, told in (("-x", "./-x.yaml"), ("my run", "'my run.yaml'"), ("Prüfung", "Prüfung.yaml")):
        exports.polytec(tmp_path / f"{name}.txt")
        assert main(["import", "--", f"{name}.txt"]) == 0
        assert capsys.readouterr().out.endswith(f"Its report: metrology report {told}\n")
    exports.polytec(tmp_path / "a\nb.txt")
    assert main(["import", "a\nb.txt", "--set", "mass=1 kg"]) == 0
    assert load(tmp_path / "a\nb.yaml").id == "a-b"
    capsys.readouterr()
    exports.polytec(tmp_path / "12:30.txt")
    assert main(["import", "12:30.txt"]) == 2
    assert capsys.readouterr().err == (
        "12:30.txt: got ':' in the name of a file; expected a name that a campaign can have. Fix: rename the file\n"
    )


@pytest.mark.parametrize("load", ["Masse [g]", "Last"])
def test_refusal_of_loads_that_come_again_without_a_number_of_the_repeat(load: str, tmp_path: Path) -> None:
    cycle = [("500", "auf"), ("1000", "auf"), ("1500", "auf"), ("1000", "ab"), ("500", "ab")]
    rows = [(mass, way, f"{0.82e-3 * int(mass):.3f}") for _ in range(3) for mass, way in cycle]
    for head, some, times in (
        (f"{load};Weg [mm]", (0, 2), "6 times"),
        (f"{load};Richtung;Weg [mm]", (0, 1, 2), "3 tim"),
    ):
        text = "\n".join([head, *(";".join(row[at] for at in some) for row in rows)]) + "\n"
        (tmp_path / "e.csv").write_text(text, encoding="utf-8")
        with pytest.raises(MetrologyError) as caught:
            draft([tmp_path / "e.csv"], {})
        assert str(caught.value).startswith(
            f"{tmp_path / 'e.csv'}: got loads under '{load}' that were read up to {times}"
        )
        assert "expected a column 'repeat' that numbers the repeats. Fix: add it to the file" in str(caught.value)
    numbered = [f"{3 * i // len(rows) + 1};{';'.join(row)}" for i, row in enumerate(rows)]
    (tmp_path / "e.csv").write_text("\n".join([f"Wdh.;{load};Richtung;Weg [mm]", *numbered]) + "\n", encoding="utf-8")
    given = {} if "[" in load else {f"load.L{i}": f"{i / 2} kg" for i in (1, 2, 3)}
    k = evaluated(imported(tmp_path, ["e.csv"], **given))["k"]
    assert k.value == pytest.approx(9.806 * (1 - 1.2 / 8000) / 0.82e-3, rel=1e-2)


@pytest.mark.parametrize("head", ["", "testXpert II;V3.6\r\n"])
def test_planted_a_header_block_of_testxpert_has_sizes_with_their_symbols(head: str, tmp_path: Path) -> None:
    """Imitated: a block without the program's name is known by the headings that it writes."""
    exports.zwick(tmp_path / "a.TRA")
    text = (tmp_path / "a.TRA").read_bytes().decode("cp1252")
    sizes = "Einspannlänge;150;mm\r\nProbenbreite b0;10,05;mm\r\nProbendicke a0;1,02;mm\r\n"
    (tmp_path / "a.TRA").write_bytes((head + sizes + text.partition("\n")[2]).encode("cp1252"))
    made = draft([tmp_path / "a.TRA"], {"class.cell": "0.5"})[1]
    assert "# a.TRA: text by ZwickRoell testXpert" in made.text
    assert "section: {shape: tape, width: 10.05 mm, thickness: 1.02 mm}   # from the file" in made.text
    assert "length: 150 mm   # from the file" in made.text


def test_planted_a_header_block_of_bluehill_has_sizes_in_groups(tmp_path: Path) -> None:
    """Imitated: ``Specimen properties : Width,10,mm,,`` above the headings."""
    exports.instron(tmp_path / "i.csv")
    rows = (tmp_path / "i.csv").read_text(encoding="utf-8").splitlines()[2:]
    said = {"Length": 80, "Thickness": 2.5, "Width": 9.75, "Final width": 9.5, "Area": 24.375}
    head = ["General : Specimen number (included),3,,,", "Test : Operator,A. Smith,,,"]
    head += [f"Specimen properties : {key},{value},mm{'^2' * (key == 'Area')},," for key, value in said.items()]
    (tmp_path / "i.csv").write_text("\n".join([*head, ",,,,", *rows]) + "\n", encoding="utf-8")
    text = draft([tmp_path / "i.csv"], {"class.cell": "0.5"})[1].text
    assert "# i.csv: text by Instron Bluehill" in text
    assert "section: {shape: tape, width: 9.75 mm, thickness: 2.5 mm}   # from the file" in text
    assert "length: 80 mm   # from the file" in text
    assert "operator: A. Smith   # from the file" in text


def test_planted_a_french_block_has_sizes_and_a_way_beside_that_of_the_crosshead_is_an_extensometer(
    tmp_path: Path,
) -> None:
    """Imitated: testXpert in French, whose ``Course standard`` is read over L0 by what is on the specimen."""
    head = ['"Épaisseur éprouvette",1,"mm"', '"Largeur éprouvette",10,"mm"', '"L0 - course standard",25,"mm"']
    head += ['"Opérateur","A. Martin"', '"Temps","Traverse absolue","Force standard","Course standard"']
    rows = []
    for i in range(200):
        force, noise = 5.0 * i, 2e-5 * ((7 * i) % 5 - 2)
        rows.append(f"{0.1 * i:.1f},{force * 8e-5 - 700:.4f},{force:.2f},{force * 25 / 700e3 + noise:.5f}")
    (tmp_path / "f.tra").write_text("\n".join([*head, '"s","mm","N","mm"', *rows]) + "\n", encoding="utf-8")
    path = imported(tmp_path, ["f.tra"], **{"class.cell": "0.5", "class.extensometer": "0.5"})
    text = path.read_text(encoding="utf-8")
    assert "section: {shape: tape, width: 10 mm, thickness: 1 mm}   # from the file" in text
    assert "gauge_length: 25 mm   # from the file" in text
    assert "operator: A. Martin   # from the file" in text
    found = evaluated(path)
    assert found["E"].value == pytest.approx(70e9, rel=0.01)
    assert found["C"].value == pytest.approx(8e-8 - 25e-3 / 700e3, rel=0.02)


def test_law_two_ways_of_one_crosshead_are_no_extensometer(tmp_path: Path) -> None:
    rows = [f"{0.1 * i:.1f};{i * 0.01 - 300:.3f};{i * 0.01:.3f};{5.0 * i:.2f}" for i in range(100)]
    head = ["Prüfzeit;Traversenweg absolut;Standardweg;Standardkraft", "s;mm;mm;N"]
    (tmp_path / "z.csv").write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")
    text = draft([tmp_path / "z.csv"], {"class.cell": "0.5", "length": "100 mm"})[1].text
    assert "instruments: {force: cell, crosshead: crosshead}" in text


@pytest.mark.parametrize(("count", "rise", "share"), [(200, 200, "40"), (30, 30, "50"), (22, 22, "70"), (60, 12, "")])
def test_limit_the_range_of_a_draft_holds_as_many_readings_as_a_line_needs(
    count: int, rise: int, share: str, tmp_path: Path
) -> None:
    """A record that flows from 80 % of its force on, which it reaches in so many readings; 12 are needed."""
    rows = ["Time (s),Strain (mm/mm),Force (N)"]
    for i in range(count):
        force = 1000.0 * min(1.0, (i + 1) / rise) + 0.1 * i
        strain = force * 1e-6 + max(0.0, force - 800) * 1e-4 + max(0, i - rise) * 1e-3 + 1e-7 * ((7 * i) % 5 - 2)
        rows.append(f"{i},{strain:.8f},{force:.2f}")
    (tmp_path / "y.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    path = imported(tmp_path, ["y.csv"], **{"class.cell": "0.5", "class.extensometer": "0.5"})
    text = path.read_text(encoding="utf-8")
    assert (f"    range: {{share: [10 %, {share} %]}}   # guess: the record bends further up" in text) is bool(share)
    assert ("    # range: " in text) is (not share)
    if share:
        evaluated(path)


def test_limit_columns_that_are_left_out_are_named(tmp_path: Path) -> None:
    rows = [f"{i / 500},{x},{x},{20 + 0.001 * i:.3f}," for i, x in enumerate(exports.MOVED)]
    text = "\n".join(["time / s,Displacement [mm],Displacement [mm],Temp [degC],empty", *rows]) + "\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    made = draft([tmp_path / "a.csv"], {"mass": "1 kg"})[1].text
    assert '        # left out: "Displacement [mm]" (3), "Temp [degC]" (4)\n' in made
    exports.instron(tmp_path / "i.csv")
    head, *lines = (tmp_path / "i.csv").read_text(encoding="utf-8").splitlines()
    added = ["", ',"Tensile strain"', ',"(mm/mm)"', *(f',"{x / 60:.7f}"' for x in exports.PULLED)]
    text = "\n".join([head, *(row + more for row, more in zip(lines, added, strict=True))]) + "\n"
    (tmp_path / "i.csv").write_text(text, encoding="utf-8")
    assert "# left out: Tensile strain (4: computed from the crosshead)\n" in draft([tmp_path / "i.csv"], {})[1].text
