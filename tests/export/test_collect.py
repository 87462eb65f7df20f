"""Many results in one table, and the control chart of a check standard."""

from __future__ import annotations

import errno
import json
import os
from dataclasses import replace
from datetime import date
from math import sqrt
from pathlib import Path
from shutil import copytree
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pytest

from metrology.cli import main
from metrology.errors import MetrologyError
from metrology.export import collect, control, picture

K = "al-1100-elongation.k"
STEADY = [24700.0, 24760.0, 24690.0, 24740.0, 24720.0, 24755.0, 24705.0, 24730.0]


def test_twice_the_table_holds_the_results(series):
    folder = series(STEADY)
    rows = collect.collect(folder).rows
    frame = collect.table(rows)
    assert list(frame["value"]) == STEADY
    assert frame["date"].iloc[0] == pd.Timestamp("2020-01-15")
    assert set(frame["unit"]) == {"N/m"}
    assert frame["verdicts"].iloc[0].startswith("R1: ")


@pytest.mark.parametrize("end", ["csv", "parquet"])
def test_twice_what_is_written_is_what_pandas_reads(end, series, tmp_path):
    rows = collect.collect(series(STEADY)).rows
    path = tmp_path / f"all.{end}"
    collect.write(rows, path)
    read = pd.read_csv(path) if end == "csv" else pd.read_parquet(path)
    assert list(read["value"]) == STEADY
    assert list(read.columns) == list(collect.Row.__dataclass_fields__)


def test_law_a_chart_is_of_one_sample(series):
    """A rod among the wires was a drift of 5000 N/m a year."""
    rows = collect.collect(series(STEADY)).rows
    rows = (*rows[:3], replace(rows[3], sample="rod", value=30000.0), *rows[4:])
    chart = control.chart(rows, K)
    assert chart.in_control
    assert len(chart.points) == len(STEADY) - 1
    assert "it is of rod, not of al-1100" in chart.sentence


def test_refusal_another_end_and_a_folder_without_results(series, tmp_path):
    with pytest.raises(MetrologyError, match=r"ends with \.csv or \.parquet"):
        collect.write(collect.collect(series(STEADY[:1])).rows, tmp_path / "all.xlsx")
    with pytest.raises(MetrologyError, match="no such folder"):
        collect.collect(tmp_path / "nowhere")


def test_law_a_file_that_cannot_be_read_is_listed_and_not_fatal(series, tmp_path, capsys):
    folder = series(STEADY[:2])
    (folder / "broken").mkdir()
    (folder / "broken" / "results.json").write_text('{"schema": "metrology-results/1"')
    assert main(["collect", str(folder), "--out", str(tmp_path / "all.csv")]) == 0
    told = capsys.readouterr()
    assert "broken/results.json: got" in told.err
    assert "2 results, 1 file(s) not read" in told.out


def test_closed_form_limits_come_from_the_moving_ranges(series):
    chart = control.chart(collect.collect(series(STEADY)).rows, K)
    s = np.mean(np.abs(np.diff(STEADY))) * sqrt(np.pi) / 2
    assert chart.s == pytest.approx(s)
    assert chart.action == pytest.approx((np.mean(STEADY) - 3 * s, np.mean(STEADY) + 3 * s))
    assert chart.in_control
    assert "is in control" in chart.sentence


def test_twice_the_drift_is_that_of_a_plain_line(series):
    values = [v + 40.0 * i for i, v in enumerate(STEADY)]
    chart = control.chart(collect.collect(series(values)).rows, K)
    days = [(point.date - chart.points[0].date).days / 365.25 for point in chart.points]
    (slope, _), covariance = np.polyfit(days, values, 1, cov=True)
    assert chart.drift.slope == pytest.approx(slope)
    assert chart.drift.u == pytest.approx(sqrt(covariance[0][0]))
    assert chart.drift.significant
    assert not chart.in_control
    assert "it drifts" in chart.sentence


def test_planted_a_jump_is_beyond_an_action_limit(series, tmp_path, capsys):
    folder = series([*STEADY, 25400.0])
    assert main(["collect", str(folder), "--out", str(tmp_path / "all.csv"), "--check-standard", K]) == 1
    assert "TR-8 is beyond an action limit" in capsys.readouterr().out
    made = {path.name for path in tmp_path.glob("all-*")}
    assert made == {f"all-{K}.{end}" for end in ("csv", "svg", "html")}


def rewritten(folder: Path, report: int, change) -> None:
    """Change one result of a report as it is on disk."""
    path = folder / f"c{report}" / "results.json"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def test_planted_a_result_that_its_report_does_not_judge_is_no_point(series, tmp_path, capsys):
    folder = series([*STEADY, 24.7])

    def withhold(document):
        document["withheld"] = [
            {"requirement": "R1", "text": "", "result": K, "reasons": ["e failed the check 'raw records'."]}
        ]
        document["conformity"] = []

    rewritten(folder, 8, withhold)
    assert main(["collect", str(folder), "--out", str(tmp_path / "all.csv"), "--check-standard", K]) == 0
    assert "Left out: TR-8: its report does not judge it (e failed the check 'raw records')." in capsys.readouterr().out
    rows = collect.collect(folder).rows
    assert rows[-1].verdicts == "R1: not judged"
    assert rows[-1].doubts == "e failed the check 'raw records'."
    assert len(control.chart(rows, K).points) == len(STEADY)


def test_planted_a_replaced_report_and_a_copy_are_no_points(series, tmp_path, capsys):
    """TR-3 was wrong and TR-8 replaces it, so that the standard did not jump; a copied folder is no further result."""
    folder = series([*STEADY[:3], 25900.0, *STEADY[4:], STEADY[3]])

    def replaces(document):
        document["campaign"]["replaces"] = {"number": "TR-3", "date": "2020-04-15", "reason": "mass corrected"}

    rewritten(folder, 8, replaces)
    copytree(folder / "c1", folder / "copy")
    assert main(["collect", str(folder), "--out", str(tmp_path / "all.csv"), "--check-standard", K]) == 0
    told = capsys.readouterr().out
    assert "TR-3: TR-8 replaces its report" in told
    assert "TR-1: it stands in c1/results.json too" in told
    assert len(control.chart(collect.collect(folder).rows, K).points) == len(STEADY)


def test_law_what_was_not_measured_is_said_and_another_unit_is_no_point(series):
    rows = [replace(row, reconstructed=at == 4) for at, row in enumerate(collect.collect(series(STEADY)).rows)]
    chart = control.chart((*rows[:3], replace(rows[3], unit="N·m/rad"), *rows[4:]), K)
    assert chart.left_out == ("TR-3: it is in N·m/rad, not in N/m",)
    assert "Reconstructed, not measured: 1 of them." in chart.sentence


@pytest.mark.parametrize("at", [1, 2, 4])
def test_planted_a_point_far_from_the_others_does_not_hide_in_the_limits_that_it_widens(at, series):
    values = [*STEADY[:5]]
    values.insert(at, 24.7)
    chart = control.chart(collect.collect(series(values)).rows, K)
    assert chart.action[0] < 24.7
    assert not chart.in_control
    assert f"TR-{at} is far from all others" in chart.sentence


def test_power_a_point_seven_standard_deviations_off_is_seen_among_ten():
    # The point left out over mean and scatter of the others is a non-central t. By the median alone 34 % were seen.
    from scipy import stats

    rng, days, seen, steady = np.random.default_rng(5), [f"2026-{month:02d}-15" for month in range(1, 11)], 0, 0
    for _ in range(300):
        values = rng.standard_normal(10)
        for shift in (0.0, 7.0):
            values[6] += shift
            points = tuple(control.Point(date.fromisoformat(d), v, 1.0, d) for d, v in zip(days, values, strict=True))
            seen, steady = seen + (shift > 0) * control._far(points, 6), steady + (not shift) * control._far(points, 6)
    limit = stats.t.isf(0.00135, 8)
    assert seen / 300 > stats.nct.sf(limit, 8, 7 / sqrt(10 / 9)) - 0.05
    assert steady <= 6


def test_limit_steady_results_are_far_from_none(series):
    rng = np.random.default_rng(5)
    rows = collect.collect(series(list(24700.0 + rng.normal(0, 30, 60)))).rows
    assert "far" not in control.chart(rows, K).sentence


def test_law_results_without_a_date_are_said(series):
    rows = collect.collect(series(STEADY)).rows
    rows = (*rows[:-1], collect.Row(**{**vars(rows[-1]), "date": ""}))
    chart = control.chart(rows, K)
    assert len(chart.points) == len(STEADY) - 1
    assert chart.left_out == ("TR-7: it has no date",)
    assert "TR-7: it has no date" in chart.sentence


def test_law_json_stands_alone_and_too_few_points_are_not_judged(series, tmp_path, capsys):
    folder = series(STEADY[:3])
    assert main(["collect", str(folder), "--json", "--out", str(tmp_path / "a.csv"), "--check-standard", K]) == 1
    document = json.loads(capsys.readouterr().out)
    assert [row["value"] for row in document["rows"]] == STEADY[:3]
    assert document["charts"][0]["in_control"] is None
    assert "a chart needs 4" in document["charts"][0]["sentence"]


def test_limit_equal_results_are_in_control(series):
    chart = control.chart(collect.collect(series([24700.0] * 5)).rows, K)
    assert (chart.s, chart.drift, chart.in_control) == (0.0, None, True)


def test_law_the_chart_is_whole_and_hostile_names_stay_text(series):
    rows = collect.collect(series(STEADY)).rows
    made = picture.files(control.chart(rows, K), "chart")
    svg = ET.fromstring(made["chart.svg"])
    assert svg.tag == "{http://www.w3.org/2000/svg}svg"
    page = made["chart.html"].decode()
    assert "default-src 'none'" in page
    assert page.count("<tr>") == 1 + len(STEADY)
    hostile = tuple(collect.Row(**{**vars(row), "report": "<script>=1", "name": "<img src=x>"}) for row in rows)
    page = picture.files(control.chart(hostile, "<img src=x>"), "chart")["chart.html"].decode()
    assert "<script" not in page
    assert "<img" not in page


def test_refusal_no_formula_reaches_a_spreadsheet(series, tmp_path):
    rows = tuple(collect.Row(**{**vars(row), "report": "=1+1"}) for row in collect.collect(series(STEADY)).rows)
    collect.write(rows, tmp_path / "all.csv")
    assert Path(tmp_path / "all.csv").read_text().count("'=1+1") == len(rows)


def test_law_a_table_that_cannot_be_made_leaves_the_older_one_whole(series, tmp_path, monkeypatch):
    rows = collect.collect(series(STEADY[:2])).rows
    path = tmp_path / "all.csv"
    collect.write(rows, path)
    before = path.read_bytes()
    monkeypatch.setattr(os, "fsync", _full)
    with pytest.raises(MetrologyError, match="no space left"):
        collect.write(rows[:1], path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir() if entry.is_file()] == ["all.csv"]


def _full(_handle):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_planted_a_file_that_was_changed_by_hand_is_neither_collected_nor_exported(tmp_path, capsys):
    text = "format: metrology-campaign/1\nid: c\ntitle: C\nquantities: {a: 1.25(1) mm}\n"
    (tmp_path / "campaign.yaml").write_text(f"{text}derived: [{{quantity: d, expression: 2*a, unit: mm}}]\n")
    assert main(["run", str(tmp_path), "--output", str(tmp_path / "reports"), "--quiet"]) == 0
    results = tmp_path / "reports" / "c" / "results.json"
    assert [row.value for row in collect.collect(tmp_path / "reports").rows] == [pytest.approx(2.5e-3)]
    results.write_text(results.read_text().replace("0.0025", "0.0035"))
    assert main(["collect", str(tmp_path / "reports"), "--out", str(tmp_path / "all.csv")]) == 2
    assert "got content that audit.jsonl of its folder does not know" in capsys.readouterr().err
    for form in (["dcc"], ["petab", "--output", str(tmp_path / "petab")]):
        assert main(["export", form[0], str(results), *form[1:]]) == 2
        assert "got content that audit.jsonl of its folder does not know" in capsys.readouterr().err
