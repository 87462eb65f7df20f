"""Every way to get a campaign wrong that was thought of, with the message that it gives."""

# ruff: noqa: E501 - messages stand in one piece, as the user reads them

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from metrology.campaign.load import load
from metrology.errors import MetrologyError

Faults = Callable[..., list[str]]
CASES = yaml.safe_load((Path(__file__).parent / "refusals.yaml").read_text(encoding="utf-8"))


@pytest.mark.long
@pytest.mark.parametrize("case", CASES, ids=lambda case: case["case"])
def test_refusal_of_the_campaign_file(case: dict[str, object], faults: Faults) -> None:
    assert faults(case["old"], case["new"]) == case["messages"]


HEADING = "load,repeat,direction,reading / mm\n"
ROW = "A,1,loading,0.41\n"
READINGS = {
    "not a number": (
        ROW,
        "A,1,loading,NaN\n",
        ["elongation.csv:2 reading / mm: got 'NaN'; expected a number, such as '12.34'"],
    ),
    "empty cell": (
        ROW,
        "A,1,loading,\n",
        ["elongation.csv:2 reading / mm: got an empty cell; expected a number, such as '12.34'"],
    ),
    "decimal comma": (
        ROW,
        "A,1,loading,0,41\n",
        [
            "elongation.csv:2: got 5 cells in 'A,1,loading,0,41'; expected 4, as in the heading. "
            "Fix: the decimal mark is a point; commas separate cells"
        ],
    ),
    "quoted decimal comma": (
        ROW,
        'A,1,loading,"0,41"\n',
        [
            "elongation.csv:2 reading / mm: got '0,41'; expected a number, such as '12.34'. Fix: the decimal mark is a point, unless 'decimal: comma' is stated"
        ],
    ),
    "semicolons": (
        HEADING,
        "load;repeat;direction;reading\n",
        ["elongation.csv:1: got 'reading', without a unit; expected a length, such as 'reading / m'"],
    ),
    "wrong unit": (
        HEADING,
        "load,repeat,direction,reading / kg\n",
        ["elongation.csv:1: got 'reading / kg', a mass; expected a length, such as 'reading / m'"],
    ),
    "no unit": (
        HEADING,
        "load,repeat,direction,reading\n",
        ["elongation.csv:1: got 'reading', without a unit; expected a length, such as 'reading / m'"],
    ),
    "wrong column": (
        HEADING,
        "load,repeat,directoin,reading / mm\n",
        [
            "elongation.csv:1: got 'directoin', an unknown column; expected one of 'load', 'repeat', 'direction', "
            "'reading / m'. Fix: did you mean 'direction'?"
        ],
    ),
    "column twice": (
        HEADING,
        "load,load,repeat,direction,reading / mm\n",
        ["elongation.csv:1: got the heading 'load' a second time; expected every heading once"],
    ),
    "undeclared load": (
        ROW,
        "D,1,loading,0.41\n",
        ["elongation.csv:2 load: got 'D'; expected one of the declared loads A, B, C"],
    ),
    "duplicate reading": (
        "A,1,unloading,0.41\n",
        "A,1,loading,0.41\n",
        [
            "elongation.csv:5: got load A, repeat 1, loading a second time (first in line 2); expected every reading once. "
            "Fix: number the repeats"
        ],
    ),
    "misspelled direction": (
        ROW,
        "A,1,lading,0.41\n",
        ["elongation.csv:2 direction: got 'lading'; expected one of loading, unloading. Fix: did you mean 'loading'?"],
    ),
    "empty line": (ROW, "\n" + ROW, ["elongation.csv:2: got an empty line; expected a reading a line"]),
}


@pytest.mark.parametrize("case", READINGS)
def test_refusal_of_readings(case: str, faults: Faults) -> None:
    old, new, messages = READINGS[case]
    assert faults(old, new, file="elongation.csv") == messages


def test_refusal_of_a_truncated_file(folder: Path, faults: Faults) -> None:
    text = (folder / "elongation.csv").read_text(encoding="utf-8")
    (folder / "elongation.csv").write_text(text[:-10], encoding="utf-8")
    assert faults() == [
        "elongation.csv:19: got 3 cells in 'C,3,unloa'; expected 4, as in the heading. Fix: the file may be cut short",
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "elongation.csv: got an empty file; expected a heading line and readings"),
        (HEADING.encode(), "elongation.csv:1: got no readings below the heading; expected a line a reading"),
        (b"\xef\xbb\xbf" + HEADING.encode(),
         "elongation.csv:1: got no readings below the heading; expected a line a reading"),
        (HEADING.encode() + b"A,1,loading,0.4\xb5\n",
         "elongation.csv:2 reading / mm: got '0.4µ'; expected a number, such as '12.34'"),
        (HEADING.encode() + b"A,1,loading,0.4\x81\n",
         "elongation.csv:2: got byte 0x81; expected text in UTF-8. "
         "Fix: save the file as UTF-8, or state its 'encoding' in the campaign file"),
    ],
)  # fmt: skip
def test_refusal_of_files_that_are_no_csv(content: bytes, message: str, folder: Path, faults: Faults) -> None:
    (folder / "elongation.csv").write_bytes(content)
    assert faults() == [message]


def test_refusal_of_one_reading_only(folder: Path, faults: Faults) -> None:
    (folder / "elongation.csv").write_text(HEADING + ROW, encoding="utf-8")
    assert faults() == [
        "campaign.yaml:96:16 tests.al-elongation.exclusions[0].line: got line 4; expected a line of elongation.csv with a "
        "reading, 2 to 2",
        "elongation.csv: got no reading of load 'B'; expected at least one reading of every load",
        "elongation.csv: got no reading of load 'C'; expected at least one reading of every load",
        "elongation.csv: got 1 reading in 1 repeat; expected at least 5: fewer have no scatter about a line from which an "
        "uncertainty follows. Fix: read the loads again, or more loads",
    ]


def test_refusal_of_one_simultaneous_reading(folder: Path, faults: Faults) -> None:
    (folder / "bridge.csv").write_text("V / V,I / mA\n5.007,19.663\n", encoding="utf-8")
    assert faults() == ["bridge.csv: got one reading only; expected at least two readings, for a standard deviation"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\n0.001,", "\n0.000,", "decay-1.csv:3 time / s: got the time stamp 0 a second time; expected time stamps that increase. Fix: 'rows: [first, last]' in the campaign file says which lines are used"),
        ("\n0.002,", "\n0.0005,", "decay-1.csv:4 time / s: got 0.0005 after 0.001; expected time stamps that increase. Fix: 'rows: [first, last]' in the campaign file says which lines are used"),
    ],
)  # fmt: skip
def test_refusal_of_time_stamps_that_do_not_increase(old: str, new: str, message: str, faults: Faults) -> None:
    assert faults(old, new, file="decay-1.csv") == [message]


def test_refusal_of_a_dead_channel(folder: Path, faults: Faults) -> None:
    rows = "".join(f"{i / 1000},1.5\n" for i in range(30))
    (folder / "decay-1.csv").write_text("time / s,displacement / um\n" + rows, encoding="utf-8")
    assert faults() == [
        "decay-1.csv:2 displacement / um: got the same reading, 1.5, on every line; expected readings that vary. "
        "Fix: the channel may be dead"
    ]


def test_refusal_of_a_link_that_leaves_the_folder(folder: Path, faults: Faults) -> None:
    outside = folder.parent / "outside.csv"
    outside.write_text("V / V,I / mA\n1,2\n2,3\n", encoding="utf-8")
    (folder / "bridge.csv").unlink()
    (folder / "bridge.csv").symlink_to(outside)
    assert faults() == [
        "campaign.yaml:114:15 ensembles.bridge.readings: got 'bridge.csv'; expected a file with readings in the campaign's "
        "folder. Fix: a link leads out of the campaign's folder"
    ]


def test_refusal_tells_all_faults_at_once(faults: Faults, folder: Path) -> None:
    text = (folder / "campaign.yaml").read_text(encoding="utf-8")
    for old, new in (
        ("length: 2.990 ± 0.001 m", "length: 2.990 ± 0.001 N"),
        ("{displacement: vibrometer}", "{displacement: vibrator}"),
        ("expression: V / I,", "expression: V / II,"),
        ("coefficient: 0.9", "coefficient: *a"),
        ("quantity: al-elongation.k\n", "quantity: al-elongation.q\n"),
    ):
        text = text.replace(old, new, 1)
    (folder / "campaign.yaml").write_text(text, encoding="utf-8")
    (folder / "decay-2.csv").write_text("time / s,displacement / um\n0,x\n", encoding="utf-8")
    places = [message.partition(": ")[0] for message in faults()]
    assert places == [
        "campaign.yaml:71:13 samples.al.length",
        "campaign.yaml:100:33 tests.al-decay.instruments.displacement",
        "campaign.yaml:119:36 correlations[0].coefficient",
        "campaign.yaml:150:31 derived[2].expression",
        "campaign.yaml:161:15 requirements[0].quantity",
        "decay-2.csv:2 displacement / um",
    ]


def _load_bytes(folder: Path, content: bytes) -> str:
    (folder / "campaign.yaml").write_bytes(content)
    with pytest.raises(MetrologyError) as caught:
        load("campaign.yaml")
    return str(caught.value)


def test_refusal_of_an_alias_bomb(folder: Path) -> None:
    levels = [f"{chr(98 + i)}: &{chr(98 + i)} [{','.join(['*' + chr(97 + i)] * 9)}]" for i in range(20)]
    bomb = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "\n".join(levels) + "\n"
    message = _load_bytes(folder, bomb.encode())
    assert "campaign.yaml:1:4 a: got the anchor '&a'; expected the value alone. Fix: remove the anchor" in message
    assert "got the alias '*a'; expected the value itself" in message


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "campaign.yaml:1:1: got an empty file; expected entries, the first of them 'format:'"),
        (b"- a\n- b\n", "campaign.yaml:1:1: got a list; expected a mapping of 'key: value' entries"),
        (b"id: \xe9\n", "campaign.yaml:1: got byte 0xe9; expected text in UTF-8. Fix: save the file as UTF-8"),
        (b"a: " + b"[" * 30 + b"]" * 30 + b"\n", "campaign.yaml:1:24: got more than 20 levels; expected a campaign as documented"),
        (b"a: [" + b"x," * 100_100 + b"]\n", "campaign.yaml:1:199999: got more than 100000 entries; expected a smaller campaign. "
         "Fix: keep readings in CSV files"),
        (b"#" * (1 << 20) + b"#", "campaign.yaml: got a file of more than 1 MiB; expected a campaign file of at most 1 MiB. "
         "Fix: keep readings in CSV files"),
        (b"? [a, b]\n: c\n", "campaign.yaml:1:3: got a key that is no plain word; expected 'key: value'"),
        (b"a: \x07\n", "campaign.yaml:1: got a character that YAML does not allow; expected printable text"),
    ],
)  # fmt: skip
def test_refusal_of_files_that_are_no_campaign(content: bytes, message: str, folder: Path) -> None:
    assert _load_bytes(folder, content) == message


def test_refusal_of_a_file_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MetrologyError) as caught:
        load("campaign.yaml")
    assert str(caught.value) == (
        "campaign.yaml: got no such file; expected a campaign file. Fix: metrology new NAME writes a starter campaign"
    )


def test_refusal_of_a_pipe(folder: Path) -> None:
    (folder / "campaign.yaml").unlink()
    os.mkfifo(folder / "campaign.yaml")
    with pytest.raises(MetrologyError) as caught:
        load("campaign.yaml")
    assert str(caught.value) == (
        "campaign.yaml: got a device or a pipe; expected a campaign file, which is a plain file"
    )


def test_refusal_of_a_device_and_of_a_folder(tmp_path: Path) -> None:
    with pytest.raises(MetrologyError, match=r"^/dev/zero: got a device or a pipe"):
        load("/dev/zero")
    with pytest.raises(MetrologyError, match="got a folder; expected a campaign file"):
        load(tmp_path)


def test_limit_a_campaign_has_as_many_results_as_their_correlations_can_be_kept(faults: Faults) -> None:
    more = "".join(f"  - {{quantity: d{i}, expression: 2*a, unit: mm}}\n" for i in range(201))
    (told,) = faults("derived:\n", "derived:\n" + more)
    assert "tests, fits and derived quantities; expected at most 200" in told
    assert "metrology collect" in told


def test_refusal_of_a_language_is_one_fault(tmp_path: Path) -> None:
    path = tmp_path / "campaign.yaml"
    path.write_text("format: metrology-campaign/1\nid: a\ntitle: A\nreport: {language: english}\n")
    with pytest.raises(MetrologyError) as refused:
        load(path)
    (fault,) = refused.value.faults
    assert str(fault).endswith("report.language: got 'english'; expected one of 'en', 'de', 'fr', 'it', 'es'")
