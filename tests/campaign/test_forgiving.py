"""Texts as instruments and spreadsheets write them: read with a notice where nothing is lost, refused where it is."""

# ruff: noqa: E501 - messages stand in one piece, as the user reads them

from __future__ import annotations

from pathlib import Path

import pytest

from metrology.campaign.load import load
from metrology.declaration.columns import Column
from metrology.declaration.readings import Readings
from metrology.errors import MetrologyError
from metrology.readings.files import read

TIME = Column("time", "s", increasing=True)
POSITION = Column("position", "m", gaps=True)
PLAIN = "time / s,position / mm\n0,1.5\n0.1,2.5\n0.2,3.25\n"


def table(tmp_path: Path, content: str | bytes, due=(TIME, POSITION), **stated):
    path = tmp_path / "a.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read(path, due, stated=Readings.model_validate({"file": "a.csv", **stated}))


def refusal(tmp_path: Path, content: str | bytes, **stated) -> str:
    with pytest.raises(MetrologyError) as caught:
        table(tmp_path, content, **stated)
    return "\n".join(str(fault).partition("a.csv")[2] for fault in caught.value.faults)


FORGIVEN = {
    "byte order mark": (b"\xef\xbb\xbf" + PLAIN.encode(), "it begins with a byte order mark (UTF-8)"),
    "UTF-16": (PLAIN.encode("utf-16"), "it begins with a byte order mark (UTF-16-LE)"),
    "no last line end": (PLAIN[:-1], "the last line has no line end: the file may be cut short"),
    "trailing columns": (PLAIN.replace("\n", ",,\n"), "empty columns on the right were left out"),
    "brackets": (PLAIN.replace(" / mm", " [mm]"), "'position [mm]' was read as 'position / m'"),
    "parentheses": (PLAIN.replace(" / mm", "(mm)"), "'position(mm)' was read as 'position / m'"),
    "unit in words": (PLAIN.replace(" / mm", " / millimeter"), "'position / millimeter' was read as 'position / m'"),
    "in": (PLAIN.replace(" / mm", " in mm"), "'position in mm' was read as 'position / m'"),
    "case": (PLAIN.replace("position", "Position"), "'Position / mm' was read as 'position / m'"),
    "semicolons": (PLAIN.replace(",", ";"), "its cells are separated by semicolons"),
    "tabs": (PLAIN.replace(",", "\t"), "its cells are separated by tabs"),
    "decimal comma": (PLAIN.replace(",", ";").replace(".", ","), "its decimal mark is a comma"),
    "units below": (
        "time,position\ns,mm\n0,1.5\n0.1,2.5\n0.2,3.25\n",
        "line 2 was read as the units of the headings",
    ),
    "header block": ("Operator;Smith\nDate;x\n" + PLAIN, "lines 1 to 2 above the headings were passed over"),
    "rows of empty cells": (PLAIN + ",\n,\n", "lines of empty cells were left out"),
    "Windows-1252": (
        PLAIN.replace("time / s", "Zeit für x / s").replace("position", "position").encode("cp1252"),
        "it was read as Windows-1252, as it is not UTF-8; state 'encoding: cp1252'",
    ),
}


@pytest.mark.parametrize("case", FORGIVEN)
def test_twice_what_is_forgiven_reads_as_the_plain_file_and_is_noted(case: str, tmp_path: Path) -> None:
    content, notice = FORGIVEN[case]
    plain = table(tmp_path, PLAIN)
    stated = {"columns": {"time": "Zeit für x", "position": "position"}} if case == "Windows-1252" else {}
    forgiven = table(tmp_path, content, **stated)
    assert plain.notices == ()
    assert notice in forgiven.notices
    for name in ("time", "position"):
        assert forgiven.numbers[name].tobytes() == plain.numbers[name].tobytes()


def test_twice_lines_that_end_as_rfc_4180_says_need_no_notice(tmp_path: Path) -> None:
    plain, other = table(tmp_path, PLAIN), table(tmp_path, PLAIN.replace("\n", "\r\n"))
    assert (other.notices, other.numbers["position"].tobytes()) == ((), plain.numbers["position"].tobytes())


def test_twice_what_the_mapping_states_needs_no_notice(tmp_path: Path) -> None:
    text = "Prüfprotokoll\nZeit;Weg;Bemerkung\n0;1,5;gut\n0,1;2,5;1.000\n0,2;3,25;\n"
    stated = {
        "columns": {"time": {"column": "Zeit", "unit": "s"}, "position": {"column": "Weg", "unit": "mm"}},
        "decimal": "comma", "separator": "semicolon", "header": "1", "encoding": "utf-8",
    }  # fmt: skip
    found = table(tmp_path, text, **stated)
    assert found.notices == ()
    assert found.numbers["position"].tobytes() == table(tmp_path, PLAIN).numbers["position"].tobytes()
    assert found.lines.tolist() == [3, 4, 5]


def test_twice_columns_by_number_need_no_headings(tmp_path: Path) -> None:
    columns = {"time": {"column": "1", "unit": "s"}, "position": {"column": "2", "unit": "mm"}}
    found = table(tmp_path, PLAIN.partition("\n")[2], columns=columns)
    assert found.numbers["position"].tobytes() == table(tmp_path, PLAIN).numbers["position"].tobytes()


def test_closed_form_stamps_by_rate_are_the_decimal_fractions(tmp_path: Path) -> None:
    text = "position / mm\n" + "".join(f"{i}\n" for i in range(1, 400))
    for time in ({"rate": "200 Hz"}, {"step": "5 ms"}):
        found = table(tmp_path, text, time=time)
        assert found.numbers["time"].tolist() == [float(f"{i * 5}e-3") for i in range(399)]


def test_closed_form_times_of_day_count_from_the_first(tmp_path: Path) -> None:
    text = "Zeit;position / mm\n05.10.2026 23:59:59,50;1,5\n06.10.2026 00:00:00,25;2,5\n"
    found = table(tmp_path, text, columns={"time": "Zeit", "position": "position"})
    assert found.numbers["time"].tolist() == [0.0, 0.75]


def test_closed_form_rows_and_words(tmp_path: Path) -> None:
    columns = (Column("direction", kind="text", choices=("loading", "unloading")), POSITION)
    text = "Richtung,position / mm\nBelastung,1\nEntlastung,2\nBelastung,3\n"
    stated = {"column": "Richtung", "words": {"Belastung": "loading", "Entlastung": "unloading"}}
    mapping = {"columns": {"direction": stated, "position": "position"}, "rows": ["3", "4"]}
    found = table(tmp_path, text, columns, **mapping)
    assert found.texts["direction"] == ("unloading", "loading")
    assert found.lines.tolist() == [3, 4]
    assert found.name == "a.csv [rows 3 to 4]"


REFUSED = {
    "no headings": (
        "0,1\n0.1,2\n",
        ":1: got '0,1', numbers where headings are due; expected a line of headings. Fix: write the headings above the "
        "readings, or number the columns: 'columns: {time: {column: 1, unit: s}}'",
    ),
    "no headings above words": (
        "A,0,1\nB,0.1,2\nC,0.2,2\n",
        ":1: got 'A,0,1', a reading where headings are due; expected a line of headings. Fix: write the headings above the "
        "readings, or number the columns: 'columns: {time: {column: 1, unit: s}}'",
    ),
    "foreign headings": (
        "Zeit,Weg\n0,1\n0.1,2\n",
        ":1: got no column 'time'; expected the heading 'time / s'. Fix: the file has 'Zeit', 'Weg'; 'columns' in the "
        "campaign file says which is which\n"
        ":1: got no column 'position'; expected the heading 'position / m'. Fix: the file has 'Zeit', 'Weg'; 'columns' in "
        "the campaign file says which is which",
    ),
    "header block above words": (
        "Instrument;X1\nOperator;A. Smith\nl;t;d\nA;0;1,5\nB;0,1;2,5\nC;0,2;3,25\n",
        ":1: got 3 lines of text, such as an instrument's header block, with no heading that is due; expected a line with "
        "the headings that are due. Fix: 'metrology import' finds the columns; or state 'header' and 'columns' in the "
        "campaign file",
    ),
    "header block": (
        "Instrument;X1\nRate;200\nt;d\n0;1,5\n0,1;2,5\n0,2;3,25\n",
        ":1: got 3 lines of text, such as an instrument's header block, with no heading that is due; expected a line with "
        "the headings that are due. Fix: 'metrology import' finds the columns; or state 'header' and 'columns' in the "
        "campaign file",
    ),
    "one wrong column": (
        PLAIN.replace("position", "postion"),
        ":1: got 'postion / mm', an unknown column; expected the heading 'position / m'",
    ),
    "ambiguous comma": (
        "time / s;position / mm\n0;1,500\n1;2,500\n",
        ": got numbers such as '1,500', whose comma may be a decimal mark or group the digits; expected one of the two. "
        "Fix: state 'decimal: comma', or 'decimal: point' and no groups",
    ),
    "groups of digits": (
        "time / s;position / mm\n0;1,5\n1;1.002,5\n",
        ":3 position / mm: got '1.002,5'; expected a number, such as '12,34'. Fix: the decimal mark is a comma, and "
        "nothing groups the digits",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusal_of_texts_that_could_be_misread(case: str, tmp_path: Path) -> None:
    content, message = REFUSED[case]
    assert refusal(tmp_path, content) == message


def test_refusal_of_a_point_where_the_decimal_mark_is_a_comma(tmp_path: Path) -> None:
    text = "time / s;position / mm\n0;1,5\n1;1.002\n"
    message = refusal(tmp_path, text, decimal="comma")
    assert message.startswith(":3 position / mm: got '1.002'; expected a number, such as '12,34'")


def test_refusal_of_a_unit_that_contradicts_the_file(tmp_path: Path) -> None:
    columns = {"time": "time", "position": {"column": "position", "unit": "m"}}
    assert refusal(tmp_path, PLAIN, columns=columns) == (
        ":1 position / mm: got the unit 'm' stated; expected 'mm', as the file has it"
    )


def test_refusal_of_a_mapping_of_other_columns(tmp_path: Path) -> None:
    assert refusal(tmp_path, PLAIN, columns={"tim": "time", "position": "weg"}) == (
        ": got the column 'tim' stated for it; expected one of time, position. Fix: did you mean 'time'?\n"
        ":1: got no column 'weg'; expected the heading 'position / m'. Fix: the file has 'time / s', 'position / mm'; "
        "'columns' in the campaign file says which is which"
    )


def test_refusal_of_readings_that_are_not_there_points_to_their_key(faults) -> None:
    assert faults("readings: elongation.csv", "readings: elongaton.csv") == [
        "campaign.yaml:94:15 tests.al-elongation.readings: got 'elongaton.csv', which is not there; expected a file with "
        "readings. Fix: did you mean 'elongation.csv'?"
    ]


def test_refusal_of_an_unquoted_colon_says_how_it_is_quoted(faults) -> None:
    assert faults("title: Stiffness and damping of two tapes", "title: Tapes: stiffness") == [
        "campaign.yaml:4:13: got a second colon in a text without quotes; expected a text in quotes where it holds ': '. "
        'Fix: put the text in quotes: title: "Tapes: stiffness"'
    ]


def test_limit_names_have_letters_of_any_language(folder: Path) -> None:
    path = folder / "campaign.yaml"
    text = path.read_text(encoding="utf-8")
    text = (
        text.replace("al-elongation", "Züge-張力").replace("bridge:", "Brücke:").replace("V: V / V", "Spännung: V / V")
    )
    text = text.replace("{V: [{half", "{Spännung: [{half").replace("expression: V / I", "expression: Spännung / I")
    path.write_text("\ufeff" + text.replace("ü", "u\u0308"), encoding="utf-8")
    campaign = load("campaign.yaml")
    assert "Züge-張力" in campaign.tests
    assert campaign.notices == ("campaign.yaml: it begins with a byte order mark.",)


def test_law_guesses_of_a_draft_that_nobody_confirmed_are_told(folder):
    path = folder / "campaign.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("title:", "# guess: nothing\ntitle:", 1), encoding="utf-8")
    (told,) = load("campaign.yaml").notices
    assert told.startswith("campaign.yaml: an entry is marked as a guess, which nobody has confirmed")
