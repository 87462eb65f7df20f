"""Readings that are taken as independent: copies, held and cut off ones, a drift, points that leave their line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.chain import independence, points

HEAD = "format: metrology-campaign/1\nid: W\ntitle: Independent readings\n"
REQUIRED = "requirements: [{{id: R, quantity: {name}, limits: {{upper: {upper}}}, decision: {{rule: guard band}}}}]\n"
NORMAL = np.random.default_rng(3).normal(5.0, 0.01, 20).round(5)
MIXED = np.random.default_rng(5).permutation(np.repeat(np.random.default_rng(3).normal(5.0, 0.01, 20).round(6), 5))
LOST = np.random.default_rng(6).normal(5.0, 0.2, 60)
LOST[[7, 19, 33, 50]] = 9999.0
DRIFT = NORMAL + 0.01 * np.arange(20)
OTHER = np.random.default_rng(7).normal(5.0, 0.01, 300).round(5)
OTHER[np.random.default_rng(8).permutation(300)[:30]] += 0.1
"""A tenth of the readings is of another range: their mean is 5 standard uncertainties off that of the others."""
CLIPPED = np.minimum(np.random.default_rng(4).normal(5.0, 0.2, 40).round(5), 5.0)


def evaluated(folder: Path, text: str, **files: str):
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content)
    (folder / "campaign.yaml").write_text(HEAD + text)
    return chain.evaluate(load(folder / "campaign.yaml"), coverage=False)


def of_readings(folder: Path, values, more: str = ""):
    text = f'ensembles: {{e: {{readings: v.csv, columns: {{V: "V / V"}}{more}}}}}\n'
    column = "V / V\n" + "".join(f"{value:.5f}\n" for value in values)
    return evaluated(folder, text + REQUIRED.format(name="V", upper="99999 V"), v=column)


@pytest.mark.long
@pytest.mark.parametrize(
    ("values", "why"),
    [
        pytest.param(NORMAL, "", id="independent"),
        pytest.param(NORMAL.round(2), "", id="coarse"),
        pytest.param(np.tile(NORMAL, 5), "a stretch of 100 readings is among them more than once", id="copied"),
        pytest.param(np.repeat(np.tile(NORMAL, 2), 3), "each of the readings stands 3 times in a row", id="held"),
        pytest.param(MIXED, "all 100 readings are copies of 20, in another order", id="copied and mixed"),
        pytest.param(MIXED[1:], "all 99 readings are copies of 20, in another order", id="copied and mixed but one"),
        pytest.param(LOST, "4 of 60 readings are the same", id="9999 where a reading was lost"),
        pytest.param(np.full(8, 5.1), "all 8 readings are alike", id="alike"),
        pytest.param(CLIPPED, "of 40 readings are the same", id="clipped"),
        pytest.param(OTHER, "30 of 300 readings are apart from the others", id="of another range"),
        pytest.param(DRIFT, "neighbouring readings are alike", id="drift"),
        pytest.param([*[5.0] * 29, 6.0], "rounding does not average out", id="one step"),
        pytest.param([5.0, 5.0, 6.0, 4.0, 6.0, 4.0, 5.0], "", id="three steps"),
    ],
)
def test_planted_a_mean_of_readings_that_are_not_independent_is_not_judged(values, why: str, tmp_path: Path) -> None:
    found = of_readings(tmp_path, values)
    assert [one.verdict for one in found.conformity] == ([] if why else ["pass"])
    assert [why in " ".join(one.reasons) for one in found.withheld] == ([True] if why else [])
    assert any(why in one for one in found.warnings) or not why
    assert not why or any("V: " in one.sentence for one in found.notices)


def test_law_what_is_accepted_or_has_a_resolution_is_judged(tmp_path: Path) -> None:
    accepted = ", accepted: {reason: a step of the room, by: A. Smith}"
    found = of_readings(tmp_path, DRIFT, accepted)
    assert [(one.verdict, "Accepted by A. Smith" in " ".join(one.accepted)) for one in found.conformity] == [
        ("pass", True)
    ]
    known = ", uncertainty: {V: [{half_width: 1 mV, distribution: rectangular}]}"
    assert [one.verdict for one in of_readings(tmp_path, np.full(8, 5.1), known).conformity] == ["pass"]


def test_planted_groups_that_are_copies_of_one_are_not_judged(tmp_path: Path) -> None:
    text = 'ensembles: {e: {readings: v.csv, columns: {V: "V / V"}, nested: [day]}}\n'
    for values, why in ((np.tile(NORMAL[:4], 5), "do not scatter"), (np.tile(NORMAL[:10], 2), "more than once")):
        rows = "".join(f"d{at // 4},{value:.5f}\n" for at, value in enumerate(values))
        found = evaluated(tmp_path, text + REQUIRED.format(name="V", upper="99999 V"), v="day,V / V\n" + rows)
        assert not found.conformity
        assert why in " ".join(found.withheld[0].reasons)


@pytest.mark.long
@pytest.mark.parametrize("drift", [0.0, 0.002])
def test_planted_a_drift_of_which_the_groups_take_turns(drift: float, tmp_path: Path) -> None:
    """Their means hardly differ, while all of them are off."""
    values = np.random.default_rng(12).normal(5.0, 0.01, 60) + drift * np.arange(60)
    rows = "".join(f"o{at % 3},{value:.5f}\n" for at, value in enumerate(values))
    text = 'ensembles: {e: {readings: v.csv, columns: {V: "V / V"}, nested: [operator]}}\n'
    found = evaluated(tmp_path, text + REQUIRED.format(name="V", upper="99999 V"), v="operator,V / V\n" + rows)
    assert [one.verdict for one in found.conformity] == ([] if drift else ["pass"])
    assert not drift or "readings that follow each other" in found.withheld[0].reasons[0]


X = np.linspace(0.0, 10.0, 11)
LINE = (1 + 0.5 * X + np.random.default_rng(5).normal(0.0, 0.01, 11)).round(5)

AGAIN = (1 + 0.5 * np.repeat(X[::5], 3) + np.random.default_rng(9).normal(0.0, 0.01, 9)).round(5)


@pytest.mark.long
@pytest.mark.parametrize(
    ("x", "y", "at", "why"),
    [
        pytest.param(X, LINE, "8 mm", "", id="line"),
        pytest.param(np.tile(X, 6), np.tile(LINE, 6), "8 mm", "is among them more than once", id="copied"),
        pytest.param(X, 1 + 0.5 * X + 0.02 * X**2, "8 mm", "do not follow the model", id="bowed"),
        pytest.param(X[::2], LINE[::2] + 0.03 * X[::2] ** 2, "8 mm", "do not follow the model", id="six, bowed"),
        pytest.param(X, np.where(X > 4.5, 1.05, 1) * LINE, "8 mm", "do not follow the model", id="two ranges"),
        pytest.param(np.tile(X[:3], 3), np.tile(LINE[:3], 3), "1 mm", "do not follow the model", id="three, copied"),
        pytest.param(np.repeat(X[::5], 3), AGAIN, "8 mm", "", id="three levels"),
        pytest.param(X[:3], 1 + 0.5 * X[:3], "1 mm", "do not scatter", id="exact"),
        pytest.param(X, LINE, "80 mm", "is an extrapolation", id="beyond"),
    ],
)
def test_planted_a_fit_whose_scatter_is_no_measure_is_not_judged(x, y, at: str, why: str, tmp_path: Path) -> None:
    rows = "x / mm,y / V\n" + "".join(f"{a:.5f},{b:.5f}\n" for a, b in zip(x, y, strict=True))
    text = 'fits: {c: {readings: f.csv, x: "x / mm", y: "y / V", predict: [{name: p, x: %s}]}}\n' % at  # noqa: UP031
    found = evaluated(tmp_path, text + REQUIRED.format(name="c.p", upper="99 V"), f=rows)
    assert [one.verdict for one in found.conformity] == ([] if why else ["pass"])
    assert not why or why in " ".join(found.withheld[0].reasons)


@pytest.mark.long
@pytest.mark.parametrize("law", ["normal", "t of three"])
@pytest.mark.parametrize("x", [np.linspace(0.0, 1.0, 6), np.repeat([0.0, 0.3, 1.0], 4), np.linspace(0.0, 1.0, 40) ** 3])
def test_planted_nothing_points_about_a_line_do_not_leave_it(law: str, x) -> None:
    """Also where each point has an uncertainty of its own, the largest four times the smallest."""
    rng = np.random.default_rng(21)
    u = 0.25 + 0.75 * rng.random(len(x))
    design = np.column_stack([np.ones(len(x)), x]) / u[:, None]
    basis = np.linalg.qr(design)[0]
    noise = rng.standard_normal((len(x), 400)) if law == "normal" else rng.standard_t(3, (len(x), 400))
    rest = (noise - basis @ (basis.T @ noise)).T
    for found in ([points.bent(x, one, design, u) for one in rest],
                  [points.repeated(x, one, design) for one in rest]):  # fmt: skip
        # The limit is one third of 0.1 %: of a binomial of 400 at that 0.04 % are more than two.
        assert np.count_nonzero(3 * np.array(found) < 1e-3) <= 2


@pytest.mark.long
def test_planted_the_order_of_independent_readings_is_chance(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    drawn = rng.normal(size=(200, 12))
    seen = [independence.ordered(one - one.mean(), np.ones((12, 1))) for one in drawn]
    assert min(seen) > 1e-3
    assert 0.01 < np.mean(np.array(seen) < 0.05) < 0.1


@pytest.mark.long
@pytest.mark.parametrize(("start", "judged"), [("24.5 1/s", True), ("28 1/s", False), ("40 1/s", False)])
def test_planted_a_curve_that_did_not_end_at_its_best_values_is_not_judged(start, judged, tmp_path: Path) -> None:
    """A sine of 25 1/s: from elsewhere the search ends in another minimum, and was 5.7 u off without a failed check."""
    t = np.arange(40) * 0.1
    y = 3 * np.sin(25 * t) + np.random.default_rng(8).normal(0.0, 0.02, 40)
    rows = "x / s,y / V\n" + "".join(f"{a:.1f},{b:.4f}\n" for a, b in zip(t, y, strict=True))
    model = '{expression: "a*sin(w*x)", start: {a: 2 V, w: %s}}' % start  # noqa: UP031
    text = f'fits: {{c: {{readings: f.csv, x: "x / s", y: "y / V", model: {model}}}}}\n'
    found = evaluated(tmp_path, text + REQUIRED.format(name="c.w", upper="99 1/s"), f=rows)
    assert [one.verdict for one in found.conformity] == (["pass"] if judged else [])
    assert judged or "periodic function of x" in " ".join(found.withheld[0].reasons)


def test_planted_a_line_between_two_frequencies_is_periodic_and_noise_is_not() -> None:
    rng = np.random.default_rng(9)
    noise = rng.normal(size=(2000, 40))
    noise -= noise.mean(axis=1, keepdims=True)
    assert np.mean([points.periodic(one, 1) < 1e-2 for one in noise]) <= 0.01
    line = 2 * np.sin(2 * np.pi * 7.5 * np.arange(40) / 40)
    assert max(points.periodic(one + line, 1) for one in noise[:100]) < 1e-2


def test_limit_the_ratio_of_many_readings_is_normal() -> None:
    rest = np.random.default_rng(7).normal(size=independence.MOST)
    rest += 0.1 * np.sin(np.arange(rest.size) / 20.0)
    ones = np.ones((rest.size, 1))
    drawn = independence.ordered(rest - rest.mean(), ones)
    longer = np.append(rest, rest[:1])
    assert independence.ordered(longer - longer.mean(), np.ones((longer.size, 1))) == pytest.approx(drawn, abs=0.03)


def test_closed_form_of_readings_apart() -> None:
    """Four readings from 0 to 3 and four from 100: on either side ((w + 1)/(w + L))³ = (4/100)³; n·log₂n = 24."""
    values = np.array([0.0, 1, 2, 3, 100, 101, 102, 103])
    count, p = independence.apart(values)
    assert count == 4
    assert p == pytest.approx((4 / 100) ** 3 * 8 * 3, rel=1e-12)


@pytest.mark.parametrize("law", ["normal", "t of two", "Cauchy", "exponential", "rectangular", "coarse"])
def test_planted_nothing_no_reading_is_apart_in_a_sample_with_one_peak(law: str) -> None:
    rng = np.random.default_rng(9)
    draw = {
        "normal": rng.standard_normal,
        "t of two": lambda n: rng.standard_t(2, n),
        "Cauchy": rng.standard_cauchy,
        "exponential": rng.standard_exponential,
        "rectangular": rng.random,
        "coarse": lambda n: 3 * np.round(rng.standard_normal(n) / 3),
    }[law]
    assert all(independence.apart(draw(n))[1] >= 1e-3 for n in (4, 10, 40, 200) for _ in range(100))
