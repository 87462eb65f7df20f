"""The table that ends a run: every number to the place of its uncertainty."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import findings_sample
import pytest

from metrology import chain, checklist
from metrology.campaign.load import load
from metrology.cli import main
from metrology.identification import Party
from metrology.summary import print_summary


@pytest.mark.parametrize(
    ("expression", "cells"),
    [
        ("2*r", ("4.00", "0.20", "[3.61, 4.39]")),
        ("1e-12*r", ("2.00e-12", "0.10e-12", "[1.80e-12, 2.20e-12]")),
        ("sqrt(-r)", ("undefined", "–")),
    ],
)
def test_closed_form_ends_of_an_interval_have_the_digits_of_the_value(expression, cells, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "160")
    (tmp_path / "campaign.yaml").write_text(
        "format: metrology-campaign/1\nid: small\ntitle: Small\nquantities: {r: 2.00(10)}\n"
        f"derived: [{{quantity: q, expression: {expression}}}]\n"
    )
    print_summary(chain.evaluate(load(tmp_path / "campaign.yaml")), tmp_path)
    row = next(line for line in capsys.readouterr().out.splitlines() if " q " in line)
    assert [cell for cell in cells if cell not in row] == []


def test_the_terminal_says_what_page_1_says_of_a_comparison(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "160")
    (tmp_path / "campaign.yaml").write_text(
        "format: metrology-campaign/1\nid: small\ntitle: Small\nquantities: {r: 2.00(10), s: 3.00(10)}\n"
        "derived: [{quantity: q, expression: 2*r}]\ncomparisons: [{title: r against s, between: [r, s]}]\n"
    )
    assert main(["run", str(tmp_path / "campaign.yaml"), "--output", str(tmp_path / "made")]) == 0
    assert "comparison r against s: they differ, |E_n| = 3.6" in capsys.readouterr().out


def test_closed_form_a_campaign_of_fits_alone_has_their_parameters_on_the_terminal(tmp_path, monkeypatch, capsys):
    """y = 1 + 2x with residuals (1, −2, 1)·0.1: slope 2, s = 0.1·√6, u(slope) = s/√2."""
    monkeypatch.setenv("COLUMNS", "160")
    (tmp_path / "f.csv").write_text("x / m,y / N\n0,1.1\n1,2.8\n2,5.1\n")
    campaign = (
        "format: metrology-campaign/1\nid: small\ntitle: Small\nfits: {line: {readings: f.csv, x: x / m, y: y / N}}\n"
    )
    (tmp_path / "campaign.yaml").write_text(campaign)
    print_summary(chain.evaluate(load(tmp_path / "campaign.yaml")), tmp_path)
    row = next(line for line in capsys.readouterr().out.splitlines() if " slope " in line)
    assert [word for word in (" line ", " fit ", " 2.00 ", " 0.17 ", " N/m ") if word not in row] == []
    # Where anything is derived from them, that is the result.
    (tmp_path / "campaign.yaml").write_text(
        f"{campaign}derived: [{{quantity: k, expression: s, where: {{s: line.slope}}, unit: N/m}}]\n"
    )
    print_summary(chain.evaluate(load(tmp_path / "campaign.yaml")), tmp_path)
    assert " slope " not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("width", "present", "absent"),
    [(120, ("sample", "test", "method", "interval"), ()), (80, ("test", "value", "interval"), ("method",)),
     (60, ("test", "value"), ("method", "sample", "interval"))],
)  # fmt: skip
def test_limit_a_narrow_terminal_has_fewer_columns_and_every_digit(width, present, absent, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    made = findings_sample.build(1, records=1)
    print_summary(made, Path("made"))
    table = capsys.readouterr().out.split("└")[0]
    head = table.splitlines()[2]
    assert [word for word in present if word not in head] == []
    assert [word for word in absent if word in head] == []
    assert max(map(len, table.splitlines())) <= width
    assert "…" not in table
    assert "24730" in table
    assert made.results[0].test in table


def test_law_the_terminal_says_how_many_items_a_draft_lacks_and_where_the_pdf_lies(tmp_path, capsys):
    made = findings_sample.build(1, records=1)
    bare = replace(made, campaign=replace(made.campaign, report_number="", laboratory=Party("")))
    (tmp_path / "report.pdf").touch()
    print_summary(bare, tmp_path)
    out = capsys.readouterr().out
    missing = checklist.lacking(bare)
    assert f"DRAFT {len(missing)} items missing for 17025" in out
    assert out.rstrip().endswith("report.pdf")


def test_limit_without_a_result_the_terminal_prints_the_title_without_headings(tmp_path, capsys):
    made = findings_sample.build(1, records=1)
    print_summary(replace(made, results=(), consensus=()), tmp_path)
    out = capsys.readouterr().out
    assert out.startswith(f"{made.campaign.id}: {made.campaign.title}")
    assert "95% interval" not in out


def test_law_a_narrow_terminal_says_of_which_sample_a_result_is(tmp_path, monkeypatch, capsys):
    """Derived quantities have no test; of two samples nothing else tells them apart."""
    monkeypatch.setenv("COLUMNS", "60")
    (tmp_path / "campaign.yaml").write_text(
        "format: metrology-campaign/1\nid: small\ntitle: Small\nquantities: {r: 2.00(10) N/m}\n"
        "samples: {left: {material: steel}, right: {material: steel}}\nderived:\n"
        "  - {quantity: k, sample: left, expression: 2*r, unit: N/m}\n"
        "  - {quantity: k, sample: right, expression: 3*r, unit: N/m}\n"
    )
    print_summary(chain.evaluate(load(tmp_path / "campaign.yaml")), tmp_path)
    printed = capsys.readouterr().out
    assert [word for word in ("left", "right", "[3.61, 4.39]") if word not in printed] == []
