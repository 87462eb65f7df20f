"""`metrology check --fix`: what is mechanical is fixed in the file, nothing else is touched."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from test_lsp import READINGS, WIRE

from metrology.cli import main
from metrology.declaration.document import parse

REQUIRED = "requirements:\n  - {id: R1, quantity: pull.k, limits: {lower: 15 kN/m}, decision: {rule: guard band}}\n"
GOOD = WIRE.replace("\n\n", "\n") + REQUIRED


@pytest.fixture
def fixed(tmp_path: Path):
    """What becomes of a file, and the exit status."""

    def fix(content: str | bytes) -> tuple[str, int]:
        (tmp_path / "wire.csv").write_text(READINGS)
        path = tmp_path / "campaign.yaml"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        status = main(["check", "--fix", str(tmp_path)])
        return path.read_bytes().decode(), status

    return fix


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("    length: 2.000(1) m", '    lenght: 2.000(1) m   # as "lenght: x"'),
        ("resolution: 0.01 mm", "resolution: 0,01 mm"),
        ("diameter: 0.500(2) mm", "diameter: 0,500(2) mm"),
        ("gravity: 9.8065(3) m/s^2", "gravity: 9,8065(3) m/s^2"),
        ("gravity: 9.81 ± 0.01 m/s^2", "gravity: 9,81 ± 0,01 m/s^2"),
        ("mass: 1.0000(1) kg", "mass: 1.0000(1) Kg"),
        ("lower: 15 kN/m", "lower: 15 KN/m"),
        ('title: "Stiffness: a wire"  # the first', "title: Stiffness: a wire  # the first"),
        ("title: 'Stiffness: a \"wire\"'", 'title: Stiffness: a "wire"'),
        ("format: metrology-campaign/1\n", ""),
        ("    method: elongation\n    sample: wire\n", "\tmethod: elongation\n\tsample: wire\n"),
    ],
)
def test_one_thing_that_can_be_meant_is_put_right(fixed, right: str, wrong: str):
    for known in ("gravity: 9.8065(3) m/s^2", "title: Stiffness of a steel wire"):
        if known.split(" ")[0] == right.split(" ")[0]:
            start = GOOD.replace(known, right)
            break
    else:
        start = GOOD
    start = (
        start.replace("    length: 2.000(1) m", '    length: 2.000(1) m   # as "lenght: x"')
        if "lenght" in wrong
        else start
    )
    broken = start.replace('    length: 2.000(1) m   # as "lenght: x"' if "lenght" in wrong else right, wrong)
    assert broken != start
    assert fixed(broken) == (start, 0)


def test_everything_at_once_is_put_right_and_the_second_time_nothing_is_left(fixed, capsys: pytest.CaptureFixture[str]):
    broken = (
        GOOD.removeprefix("format: metrology-campaign/1\n")
        .replace("    length", "    lenght")
        .replace("0.01 mm", "0,01 mm")
    )
    broken = broken.replace("title: Stiffness of", "title: Stiffness: of").replace("15 kN", "15 KN").rstrip("\n")
    good = GOOD.replace("Stiffness of a steel wire", '"Stiffness: of a steel wire"')
    assert fixed(b"\xef\xbb\xbf" + broken.replace("\n", "\r\n").encode()) == (good, 0)
    said = capsys.readouterr().out
    for told in ("-    lenght: ", "+    length: ", "byte order mark", "Windows", "last line"):
        assert told in said
    assert fixed(good) == (good, 0)
    assert "@@" not in capsys.readouterr().out


@pytest.mark.parametrize(
    "wrong",
    [
        "length: 1,234 m",  # may be a thousand
        "length: 1,234,567 m",
        "length: 2.000(1) mx",
        "length: 2.000(1) Mpa",  # millipascal or megapascal
        "xyz: 2.000(1) m",
        "length: ''",
    ],
)
def test_what_needs_a_judgement_is_left_as_it_is(fixed, wrong: str):
    broken = GOOD.replace("length: 2.000(1) m", wrong)
    assert fixed(broken) == (broken, 2)


def test_tabs_stay_where_two_widths_would_mean_two_things(fixed):
    broken = GOOD.replace("    sample: wire\n", "\tsample: wire\n").replace(
        "    instruments: {ext", "\tinstruments: {ext"
    )
    text, status = fixed(broken)
    assert (text == broken and status == 2) or parse(Path("c"), text.encode()).data["tests"]["pull"]["sample"] == "wire"


def test_what_is_no_text_or_no_file_is_refused(fixed, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "campaign.yaml"
    path.write_bytes(b"format: \xff\n")
    assert main(["check", "--fix", str(path)]) == 2
    assert path.read_bytes() == b"format: \xff\n"
    assert main(["check", "--fix", str(tmp_path / "none.yaml")]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_fault_carries_its_edit_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "campaign.yaml"
    (tmp_path / "wire.csv").write_text(READINGS)
    path.write_text(GOOD.replace("    length", "    lenght"))
    assert main(["check", "--json", str(path)]) == 2
    ((fault,),) = (entry["faults"] for entry in json.loads(capsys.readouterr().out))
    assert fault["edit"] == {"line": 9, "column": 5, "old": "lenght", "new": "length"}
