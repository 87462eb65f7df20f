"""One value, one judgement: JSON, CSV, terminal, HTML, PDF and DCC of a report say the same of every result."""

from __future__ import annotations

import csv
import html
import json
import re
from io import BytesIO, StringIO
from pathlib import Path

import numpy as np
import pages
import pytest
from pypdf import PdfReader

from metrology.cli import main
from metrology.findings import from_json

ROOT = Path(__file__).parents[1]
UNITS = {"N/m": 1.0, "GPa": 1e9, "%": 1e-2, "rad/s": 1.0, "N·s/m": 1.0, "mm": 1e-3, "Ω": 1.0, "kΩ": 1e3, "": 1.0}
UNITS |= {"N": 1.0, "kN": 1e3, "nm/N": 1e-9, "MPa": 1e6, "cN/tex": 1e4}
"""The units that these campaigns print, written here once more."""
HEAD = """\
format: metrology-campaign/1
id: random
title: Random quantities
seed: {seed}
report: {{number: TR-1, issued: 2026-11-20, authorised_by: "J. Doe, head"}}
laboratory: {{name: A laboratory, address: "1 Street, Town", contact: J. Doe, country: ZZ}}
customer: {{name: A customer, address: "2 Street, Town"}}
"""


def text_of(cell: str) -> str:
    return html.unescape(re.sub(r"<[^>]+>", "", cell)).replace("\u2212", "-").strip()


def printed(text: str) -> float:
    """A number as print shows it, with powers of ten as 1.2×10⁻³."""
    plain = text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")).replace("\u2212", "-").replace(" ", "")
    return float(plain.replace("×10", "e").replace("\u202f", "").replace("\u00a0", ""))


def last_place(text: str) -> float:
    """Half a unit of the last digit that is printed."""
    digits, _, power = text.replace("\u2212", "-").partition("×10")
    exponent = printed("1×10" + power) if power else 1.0
    decimals = len(digits.partition(".")[2].strip())
    whole = digits.strip("-+ ")
    zeros = len(whole) - len(whole.rstrip("0")) if "." not in whole else 0
    return 0.5000001 * exponent * 10.0 ** (zeros - decimals)


def agrees(text: str, value: float) -> bool:
    return abs(printed(text) - value) <= last_place(text) + 1e-9 * abs(value)


def made(folder: Path, path: Path, capsys: pytest.CaptureFixture[str]):
    """Everything that a report of a campaign says."""
    capsys.readouterr()
    with pytest.MonkeyPatch.context() as wide:
        wide.setenv("COLUMNS", "240")  # a narrow terminal shows fewer columns
        assert main(["report", str(path), "--output", str(folder)]) in (0, 1)
    shown = capsys.readouterr().out
    (place,) = (one.parent for one in folder.glob("*/results.json"))
    results = json.loads((place / "results.json").read_text(encoding="utf-8"))
    return results, shown, place


def leading(one: dict) -> tuple[float, float]:
    """Interval that leads: of the GUM uncertainty framework where clause 8 confirms it, else what the trials report."""
    trials = one["monte_carlo"]
    if trials["law_valid"]:
        return one["coverage"]["low"], one["coverage"]["high"]
    of = {"shortest": ("shortest_low", "shortest_high"), "symmetric": ("low", "high")}[trials["reported"]]
    return trials[of[0]], trials[of[1]]


def led(one: dict) -> None:
    """Value and u come by the same way as the interval (JCGM 101, 8)."""
    trials = one["monte_carlo"]
    if trials["law_valid"]:
        by = one["framework"]["value"], one["framework"]["u"]
    elif np.isfinite(float(trials["u"])):
        by = trials["mean"], trials["u"]
    else:  # the draws have no standard deviation: the value is their median, u half the interval over 1.96
        low, high = leading(one)
        assert low < one["value"] < high
        assert one["u"] == pytest.approx((high - low) / 2 / 1.959964, rel=1e-6)
        return
    assert (one["value"], one["u"]) == by


def compared(value: str, u: str, low: str, high: str, unit: str, one: dict) -> None:
    factor = UNITS[unit]
    ends = leading(one)
    for text, true in zip((value, u, low, high), (one["value"], one["u"], *ends), strict=True):
        assert agrees(text, true / factor), (one["name"], text, true / factor)


def terminal_rows(shown: str) -> list[list[str]]:
    """Rows of the table on the terminal but a consensus, which is no result; an interval may take two lines."""
    rows: list[list[str]] = []
    for line in shown.splitlines():
        if not line.startswith("│"):
            continue
        cells = [cell.strip() for cell in line.strip("│").split("│")]
        if cells[3]:
            rows.append(cells)
        else:
            rows[-1][-1] += " " + cells[-1]
    return [cells for cells in rows if cells[1] != "consensus"]


def assert_consistent(results: dict, shown: str, place: Path) -> int:
    headline = [one for one in results["results"] if one["headline"]]
    for one in headline:
        led(one)
    for row, one in zip(terminal_rows(shown), headline, strict=True):
        low, high = row[-1].strip("[]").split(",")
        compared(row[-4], row[-3], low, high, row[-2], one)

    table = {
        (row["test"], row["quantity"]): row for row in csv.DictReader(StringIO((place / "results.csv").read_text()))
    }
    for one in headline:
        row = table[one["test"], one["quantity"]]
        ends = tuple(float(row[key]) for key in ("interval_low", "interval_high"))
        assert (float(row["value"]), float(row["u"]), *ends) == (one["value"], one["u"], *leading(one))

    page = (place / "report.html").read_text(encoding="utf-8")
    rows = [
        re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, flags=re.DOTALL)
        for row in re.findall(r"<tr[^>]*>(.*?)</tr>", page, flags=re.DOTALL)
    ]
    first: dict[int, list[str]] = {}
    for cells in rows:
        for cell in cells[:2]:
            if found := re.search(r'href="#result-(\d+)"', cell):
                first.setdefault(int(found[1]), [text_of(one) for one in cells])
    text = "".join(page.extract_text() for page in PdfReader(BytesIO((place / "report.pdf").read_bytes())).pages[:2])
    text = text.replace("\u2212", "-")
    for at, one in enumerate(results["results"], 1):
        if one["headline"]:
            cells = first[at]
            interval = next(cell for cell in cells if "…" in cell)
            where = next(
                place for place, cell in enumerate(cells) if place and re.fullmatch(r"-?[\d.]+(×10\S+)?", cell)
            )
            unit = next((cell for cell in cells[where + 2 :] if cell in UNITS and cell), "")
            compared(cells[where], cells[where + 1], *interval.split("…"), unit, one)
            assert cells[where] in text, (one["name"], cells[where])

    listed = re.search(r'<ul class="attention">(.*?)</ul>', page, flags=re.DOTALL)
    assert (re.findall(r"<li><b>(.*?)</b>", listed[1]) if listed else []) == [one["kind"] for one in results["notices"]]

    for verdict in results["conformity"]:
        said = re.search(
            rf"^(pass|fail|conditional \w+|undecided) {verdict['requirement']}:", shown, flags=re.MULTILINE
        )
        assert said, shown
        assert said[1] == verdict["verdict"]
        judged = next(one for one in results["results"] if one["name"] == verdict["result"])
        assert (verdict["value"], verdict["u"]) == (judged["value"], judged["u"])
    return len(headline)


def in_dcc(place: Path, results: dict, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["export", "dcc", str(place / "results.json")]) == 0
    document = capsys.readouterr().out
    values = [float(one) for one in re.findall(r"<si:value>([^<]+)</si:value>", document)]
    for one in results["results"]:
        if one["headline"]:
            assert any(value == pytest.approx(one["value"], rel=1e-12) for value in values), one["name"]


@pytest.mark.long
def test_twice_every_output_of_lines_says_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    results, shown, place = made(tmp_path, ROOT / "campaigns" / "lines" / "campaign.yaml", capsys)
    assert assert_consistent(results, shown, place) >= 2
    in_dcc(place, results, capsys)


@pytest.mark.study
def test_twice_every_output_of_tapes_says_the_same_on_few_pages(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    results, shown, place = made(tmp_path, ROOT / "campaigns" / "tapes" / "campaign.yaml", capsys)
    assert assert_consistent(results, shown, place) >= 12
    in_dcc(place, results, capsys)
    pages.assert_short(from_json(place / "results.json"), 16)


def random_campaign(folder: Path, seed: int) -> Path:
    """Two quantities and what follows from them: sizes over many decades, few degrees of freedom, a requirement."""
    rng = np.random.default_rng([61, seed])
    a, b = (float(f"{10 ** rng.uniform(-2, 3):.4g}") for _ in "ab")
    u_a, u_b = (float(f"{10 ** rng.uniform(-4, -0.8):.2g}") for _ in "ab")
    dof = int(rng.integers(3, 12))
    limit = float(f"{(a + b) * rng.uniform(0.8, 1.2):.3g}")
    text = (
        HEAD.format(seed=seed)
        + f"""\
quantities:
  a: {{value: {a!r} mm, uncertainty: [{{standard: {100 * u_a!r} %, dof: {dof}}}]}}
  b: {{value: {b!r} mm, uncertainty: [{{half_width: {100 * u_b!r} %, distribution: rectangular}}]}}
derived:
  - {{quantity: total, expression: a + b, unit: mm}}
  - {{quantity: ratio, expression: a/b, unit: "%"}}
requirements:
  - {{id: R1, text: the total is small, quantity: total,
     limits: {{upper: {limit!r} mm}}, decision: {{rule: guard band, factor: 1.0}}}}
"""
    )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "campaign.yaml").write_text(text, encoding="utf-8")
    return folder / "campaign.yaml"


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_twice_every_output_of_random_campaigns_says_the_same(seed, tmp_path, capsys):
    results, shown, place = made(tmp_path / "out", random_campaign(tmp_path / "in", seed), capsys)
    assert assert_consistent(results, shown, place) == 2
    in_dcc(place, results, capsys)


@pytest.mark.study
@pytest.mark.parametrize("seed", range(100, 200))
def test_twice_every_output_of_a_hundred_random_campaigns_says_the_same(seed, tmp_path, capsys):
    test_twice_every_output_of_random_campaigns_says_the_same(seed, tmp_path, capsys)


@pytest.mark.study
@pytest.mark.parametrize("name", ["nylon", "spectra", "peek", "al-1100", "aramid", "polyester"])
def test_twice_every_output_of_the_shipped_campaigns_says_the_same(name, tmp_path, capsys):
    results, shown, place = made(tmp_path, ROOT / "campaigns" / name / "campaign.yaml", capsys)
    assert assert_consistent(results, shown, place) >= 2
