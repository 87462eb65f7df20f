"""What plots and tables owe to the data that they show."""

from __future__ import annotations

import re
from dataclasses import replace
from math import inf
from pathlib import Path

import findings_sample
import pytest
import response_sample

from metrology.errors import MetrologyError
from metrology.findings import Findings
from metrology.gum.guard_bands import Rule
from metrology.report import document, html, quality, staging
from metrology.report.figures import damping, decay, decrement, fit, response
from metrology.report.figures.style import BLUE, PALE
from metrology.response import FittedRun


@pytest.fixture(scope="module")
def release() -> findings_sample.DecayFinding:
    return next(test.decay for test in findings_sample.build(1, records=1).tests if test.decay is not None)


def ticks(svg: str) -> list[float]:
    """Numbers that stand along the axes."""
    words = re.findall(r"<text [^>]*>([^<]*)</text>", svg)
    return [float(word.replace("−", "-")) for word in words if re.fullmatch(r"−?[\d.]+", word)]


def test_law_axes_of_the_decay_rate_show_the_data(release: findings_sample.DecayFinding) -> None:
    record = replace(
        release.records[0],
        amplitude=(0.0010, 0.0012, 0.0014), rate=(154.2, 154.0, 154.1), rate_u=(0.1, 0.1, 5.0),
        zeta_decrement=0.5, omega_decrement=308.2,
    )  # fmt: skip
    seen = ticks(damping.draw(replace(release, records=(record,)), "PEEK").svg)
    assert min(seen) >= 1.0  # amplitudes in mm, rates in 1/s: none begins at zero
    assert {154.0, 154.2} <= set(seen)


def test_law_peaks_fill_their_axis(release: findings_sample.DecayFinding) -> None:
    shallow = replace(
        release.records[0],
        peak_time=(0.0, 1.0, 2.0), peak_amplitude=(1e-3, 8e-4, 6e-4), peak_used=(True, True, True), noise_floor=1e-8,
    )  # fmt: skip
    marks = re.findall(r">(0\.0*[125]|1)<", decrement.draw(replace(release, records=(shallow,)), "PEEK").svg)
    assert "1" in marks
    assert not [mark for mark in marks if float(mark) < 0.5]


def test_law_filtered_trace_begins_where_the_filter_has_support(release: findings_sample.DecayFinding) -> None:
    whole = release.records[0]
    late = replace(whole, filtered_from=0.5 * (whole.time[0] + whole.time[-1]))
    spoiled = replace(late, filtered=tuple(1e3 if t < late.filtered_from else y
                                           for t, y in zip(late.time, late.filtered, strict=True)))  # fmt: skip
    drawn = [decay.draw(replace(release, records=(one,)), "Al").svg for one in (whole, late, spoiled)]
    assert drawn[1] != drawn[0]
    assert ticks(drawn[2]) == ticks(drawn[1])


def widths(svg: str, colour: str) -> list[float]:
    """How far each line of a colour goes across."""
    lines = re.findall(rf'<path d="([^"]*)"[^>]*stroke="{colour}"', svg)
    across = [[float(x) for x in re.findall(r"[ML](-?[\d.]+) ", line)] for line in lines]
    return [max(line) - min(line) for line in across]


def test_law_runs_above_each_other_share_the_axis_of_the_lowest() -> None:
    long = response_sample.fitted_channel("x", "m")
    half = replace(long, **{name: getattr(long, name)[:101] for name in ("time", "measured", "fitted", "residual")})
    runs = (FittedRun("long", (long,)), FittedRun("short", (half,)))
    whole, part = widths(response.draw_fit(runs, "Nylon").svg, BLUE)
    share = (half.time[-1] - half.time[1]) / (long.time[-1] - long.time[1])
    assert part / whole == pytest.approx(share, rel=1e-3)


def test_law_releases_above_each_other_share_the_axis_of_the_lowest(release: findings_sample.DecayFinding) -> None:
    first = release.records[0]
    count = len(first.time) // 2
    columns = ("time", "displacement", "filtered", "fit")
    short = replace(first, **{name: getattr(first, name)[:count] for name in columns})
    five = replace(release, records=(first, first, short, first, first, first))
    _, _legend, whole, part, *others = widths(decay.draw(five, "Al").svg, PALE)
    assert part < 0.8 * whole
    assert others == pytest.approx([whole] * 3, abs=0.02)


@pytest.mark.parametrize(("deviation", "told"), [(None, "beneath, residuals."), (1e-3, "±2 residual standard")])
def test_law_caption_of_a_fit_names_the_band_only_where_there_is_one(deviation: float | None, told: str) -> None:
    entry = replace(findings_sample.build(1, records=1).fits[0], residual_standard_deviation=deviation)
    assert told in fit.draw(entry).caption


def test_law_value_without_an_uncertainty_says_so(findings: Findings) -> None:
    bare = replace(findings.comparisons[0], value_b=69e9, u_b=0.0, unit="Pa", display_unit="GPa")
    text = html.render(replace(findings, comparisons=(bare,)), {}).text
    assert re.search(r"69 <span class=\"aside\">\(without uncertainty\)</span>", text)
    assert "± 0<" not in text


def test_limit_symmetric_interval_is_shown_where_the_draws_have_no_u(findings: Findings) -> None:
    first = findings.results[0]
    heavy = replace(first, monte_carlo=replace(first.monte_carlo, u=inf))
    line = document.context(replace(findings, results=(heavy,), correlations=()), {})["lines"][0]
    assert line.symmetric.u == "–"
    assert "–" not in (line.symmetric.value, line.symmetric.low, line.symmetric.high)


@pytest.mark.parametrize(
    ("rule", "told"),
    [
        (Rule("simple acceptance"), "simple acceptance (w = 0)"),
        (Rule("guard band"), "guard band"),
        (Rule("specific risk", risk=0.01), "specific risk of 0.01"),
        (Rule("global risk"), "global risk of 0.025"),
    ],
)
def test_law_page_one_names_the_rule_that_was_agreed(findings: Findings, rule: Rule, told: str) -> None:
    assert quality.rule_name(replace(findings.conformity[0], rule=rule.text)) == told


def test_refusal_of_a_folder_with_the_name_of_a_file_of_the_report(tmp_path: Path) -> None:
    kept = tmp_path / "tapes" / "report.pdf" / "mine.txt"
    kept.parent.mkdir(parents=True)
    kept.write_text("keep me", encoding="utf-8")
    with pytest.raises(MetrologyError, match=r"a folder has the name of a file of the report \(.*report\.pdf\)"):
        staging.replace_folder(tmp_path / "tapes", {"report.pdf": b"%PDF"})
    assert kept.read_text(encoding="utf-8") == "keep me"
