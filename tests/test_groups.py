"""Readings in groups, from the campaign file to the result."""

from __future__ import annotations

from pathlib import Path

import pytest
from scipy.special import chdtr, chdtri

from metrology import run
from metrology.errors import MetrologyError

ROWS = "operator,part,x / mm\n" + "\n".join(
    f"{operator},{part},{value}"
    for operator, part, value in zip("AAAABBBB", "ppqqppqq", (1, 3, 5, 7, 2, 4, 10, 12), strict=True)
)
STATED = {"format": "metrology-campaign/1", "id": "gauge", "title": "A gauge", "seed": 1}


def _run(folder: Path, rows: str = ROWS, derived: object = (), **layout: object):
    (folder / "gauge.csv").write_text(rows)
    ensemble = {"readings": "gauge.csv", "columns": {"x": "x / mm"}, **layout}
    return run({**STATED, "ensembles": {"study": ensemble}, "derived": list(derived)}, folder=folder, coverage=False)


def test_deviations_of_a_gauge_are_results_that_others_use(tmp_path: Path) -> None:
    expression = "sqrt(study.s_within**2 + study.s_operator**2 + study.s_operator_part**2)"
    derived = [{"quantity": "s_R", "expression": expression, "unit": "mm"}]
    found = _run(tmp_path, derived=derived, crossed=["operator", "part"])
    by_law = {name: one.result.framework for name, one in found.items()}
    assert by_law["study.s_part"].value == pytest.approx(4e-3)
    assert by_law["s_R"].value == pytest.approx(1e-3 * (2 + 2.5 + 3) ** 0.5)
    assert by_law["study.x"].u == pytest.approx(1e-3 * (82 / 8) ** 0.5)


def test_groups_make_u_larger_than_readings_that_are_taken_as_independent(tmp_path: Path) -> None:
    grouped, alone = (_run(tmp_path, **layout)["study.x"].result for layout in ({"nested": ["part"]}, {}))
    assert grouped.framework.value == pytest.approx(alone.framework.value)
    assert (grouped.dof, alone.dof) == (1.0, pytest.approx(7.0))
    assert grouped.framework.u == pytest.approx(3e-3)
    assert alone.framework.u == pytest.approx(1e-3 * (98 + 8) ** 0.5 / 56**0.5)
    assert "F(1, 6)" in grouped.budget[0].source


@pytest.mark.parametrize(
    ("layout", "told"),
    [
        ({"nested": ["day"]}, "day"),
        ({"nested": ["part"], "crossed": ["operator", "part"]}, "'nested' and 'crossed' together"),
        ({"crossed": ["part"]}, "1 factor"),
        ({"nested": ["part", "part"]}, "every factor once"),
    ],
)
def test_refusal_names_what_is_wrong(tmp_path: Path, layout: dict[str, object], told: str) -> None:
    with pytest.raises(MetrologyError, match=told):
        _run(tmp_path, **layout)


def test_groups_of_different_size_count_alike(tmp_path: Path) -> None:
    found = _run(tmp_path, rows=ROWS + "\nB,q,16", nested=["part"])
    mean, deviation = found["study.x"].result, found["study.s_part"].result
    assert (mean.framework.value, mean.framework.u) == (pytest.approx((2.5e-3 + 10e-3) / 2), pytest.approx(3.75e-3))
    # MS_part = 125 mm², MS_within = 79/7 mm²; n = 9 − (4² + 5²)/9
    assert deviation.equation == "s² = (MS − MS_within)/4.444"
    assert deviation.framework.value == pytest.approx(1e-3 * ((125 - 79 / 7) / (9 - 41 / 9)) ** 0.5)


def test_refusal_of_combinations_that_share_no_level_names_the_file(tmp_path: Path) -> None:
    rows = "operator,part,x / mm\nA,p,1\nA,p,2\nB,q,3\nB,q,5"
    with pytest.raises(MetrologyError, match=r"gauge\.csv crossed.*2 of the 4 combinations of operator and part"):
        _run(tmp_path, rows=rows, crossed=["operator", "part"])


def test_truth_a_deviation_of_few_groups_passes_no_limit_that_it_may_well_exceed(tmp_path: Path) -> None:
    """The readings within two operators and parts: s = 1.41 mm with ν = 4; P(σ > L) = P(χ² < ν·s²/L²)."""
    limit = 3e-3
    (tmp_path / "gauge.csv").write_text(ROWS)
    study = {"readings": "gauge.csv", "columns": {"x": "x / mm"}, "crossed": ["operator", "part"]}
    rule = {"rule": "specific risk", "risk": 0.01}
    asked = {"id": "R1", "quantity": "study.s_within", "limits": {"upper": f"{limit} m"}, "decision": rule}
    found = run({**STATED, "ensembles": {"study": study}, "requirements": [asked]}, folder=tmp_path, coverage=False)
    (verdict,), one = found.findings.conformity, found["study.s_within"].result
    assert one.framework.value == pytest.approx(2**0.5 * 1e-3)
    assert one.framework.u == pytest.approx(2**0.5 * 1e-3 / 8**0.5)
    assert verdict.specific_risk == pytest.approx(float(chdtr(4, 4 * 2e-6 / limit**2)), rel=0.02)
    assert verdict.verdict == "conditional pass"
    ends = (one.monte_carlo.low, one.monte_carlo.high)
    assert one.headline  # the verdict is on page 1, and so is what it is on
    assert not found["study.s_part"].result.headline
    assert ends == pytest.approx([(8e-6 / float(chdtri(4, p))) ** 0.5 for p in (0.025, 0.975)], rel=0.01)


@pytest.mark.long
def test_law_a_mean_with_a_requirement_stands_once_on_page_1_in_its_unit(tmp_path: Path) -> None:
    (tmp_path / "gauge.csv").write_text(ROWS)
    study = {"readings": "gauge.csv", "columns": {"x": "x / mm"}, "crossed": ["operator", "part"]}
    asked = {"id": "R1", "quantity": "x", "limits": {"lower": "1 mm"}, "decision": {"rule": "guard band"}}
    found = run({**STATED, "ensembles": {"study": study}, "requirements": [asked]}, folder=tmp_path, coverage=False)
    shown = [(one.quantity, one.display_unit) for one in found.findings.results if one.headline]
    assert shown == [("x", "mm")]
