from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import findings_sample
import pytest

from metrology.findings import Correlation, Findings, Result
from metrology.language import display, wording
from metrology.language.catalogue import Language
from metrology.message import said
from metrology.report import budget, document
from metrology.report.equations import draw, mathtext, parted
from metrology.report.figures.ticks import ticks
from metrology.report.typesetting import sentence, worded


@pytest.fixture
def stiffness(findings: Findings) -> Result:
    return next(result for result in findings.results if result.quantity == "k")


def test_law_small_components_are_one_line_and_no_share_is_lost(stiffness: Result) -> None:
    large, rest = stiffness.budget[0], stiffness.budget[1]
    rows = (
        replace(rest, component="small", share=0.0004),
        replace(rest, component="smaller", share=-0.0002),
        replace(large, share=0.9998),
    )
    (shown,) = budget.budgets([replace(stiffness, budget=rows)])
    assert [row.component for row in shown.rows] == [large.component]
    assert shown.rest == "2 further components, together at most 0.1 % of u²"
    assert shown.rows[0].cells[0][1] == "100"


def test_law_shares_that_correlation_takes_away_are_kept(stiffness: Result) -> None:
    rows = (replace(stiffness.budget[0], share=1.3), replace(stiffness.budget[1], share=-0.3))
    (shown,) = budget.budgets([replace(stiffness, budget=rows)])
    assert [row.cells[0][1] for row in shown.rows] == ["130", "−30.0"]


def test_law_inputs_and_components_are_named_in_the_language_of_the_report(stiffness: Result) -> None:
    """A component is known with the name of its test, which a budget leaves out."""
    known = said("record of {specimen}, {test}", specimen="a", test=stiffness.test)
    french = Language("fr", messages={str(known): known})
    largest = stiffness.budget[0]
    rows = (
        replace(largest, input=f"{stiffness.test}.a.r_t", component=str(known)),
        replace(largest, input="cell.scale", component="certificate"),
        replace(largest, input=f"{stiffness.test}.scatter of k_0", component="x"),
    )
    (shown,) = budget.budgets([replace(stiffness, budget=rows)], language=french)
    found = {(row.name, row.component) for row in shown.rows}
    assert ("a r_t", "enregistrement de a") in found
    assert {"facteur d'échelle", "dispersion de k_0"} <= {name for name, _ in found}


def test_law_results_of_one_test_share_a_table_and_a_component_one_line(stiffness: Result) -> None:
    large, other = stiffness.budget[0], stiffness.budget[1]
    modulus = replace(
        stiffness, name="x.E", quantity="E", budget=(replace(large, share=0.2), replace(other, share=0.8))
    )
    alone = replace(stiffness, budget=(replace(large, share=1.0),))
    (shown,) = budget.budgets([alone, modulus])
    assert [result.quantity for result in shown.results] == ["k", "E"]
    cells = {row.component: [share for _, share in row.cells] for row in shown.rows}
    assert cells[large.component] == ["100", "20.0"]
    assert cells[other.component] == ["–", "80.0"]
    five = budget.budgets([replace(alone, name=f"x.{i}") for i in range(5)])
    assert [len(part.results) for part in five] == [4, 1]
    assert len({part.key for part in five}) == 2


def test_law_u_by_monte_carlo_stands_under_the_budget_of_the_framework_where_it_is_another_one(
    stiffness: Result,
) -> None:
    """Few readings: the draws of Student's t have √(ν/(ν − 2)) times s/√n, here √2 of it."""
    u = stiffness.framework.u
    drawn, same = replace(stiffness, u=2**0.5 * u), replace(stiffness, name="x.E", quantity="E", u=u)
    (shown,) = budget.budgets([drawn, same])
    size = {"N/m": 1.0, "kN/m": 1e3}[stiffness.display_unit]
    assert shown.combined[0] == shown.combined[1] == display.rounded(0.0, u / size)[1]
    assert shown.reported == (display.rounded(0.0, 2**0.5 * u / size)[1], "–")
    (alone,) = budget.budgets([same])
    assert alone.reported == ()


def test_law_inputs_that_are_all_correlated_are_named_once(stiffness: Result) -> None:
    names = ("x.a", "x.b", "x.c", "x.d")
    rows = tuple(replace(stiffness.budget[0], input=name, share=0.25) for name in names)
    pairs = [Correlation(a, b, 1.0 - 1e-6) for a, b in combinations(names[:3], 2)] + [Correlation("x.a", "x.d", 0.5)]
    (shown,) = budget.budgets([replace(stiffness, test="x", budget=rows)], pairs)
    assert shown.correlated == "a, b, c, r = +1.00 between every two; a and d, r = +0.50"


def test_law_an_input_of_a_joint_fit_is_called_by_its_component_once(stiffness: Result) -> None:
    row = replace(stiffness.budget[0], input="x.k readings", component="readings of x")
    (shown,) = budget.budgets([replace(stiffness, test="x", budget=(row,))])
    assert (shown.rows[0].name, shown.rows[0].component) == ("k readings", "")


def test_law_names_lose_their_own_test_and_sample_and_no_others(stiffness: Result) -> None:
    result = replace(stiffness, test="tape-elongation", sample="tape")
    text = "tape-elongation.reading.A of tape-elongation, tape.width, other-tape.width, u(omega_n), tape-decay.k"
    assert budget.shortened(text, result) == "reading.A, width, other-tape.width, u(ωₙ), tape-decay.k"


def test_law_sources_name_every_component_once(findings: Findings) -> None:
    stated = {(row.input, row.component) for result in findings.results for row in result.budget}
    sources = budget.sources(findings)
    assert sum(row.inputs.count(", ") + 1 for row in sources) >= len(sources)
    assert len(sources) <= len(stated)
    for name, _ in stated:
        assert any(name.rpartition(".")[2] in row.inputs for row in sources)


def test_law_verdict_of_clause_8_is_told_in_the_unit_of_the_page(stiffness: Result) -> None:
    trials = replace(
        stiffness.monte_carlo,
        law_valid=False,
        d_low=4.94e-11,
        d_high=1.2e-10,
        tolerance=5e-11,
        verdict="The GUM uncertainty framework is not confirmed: its interval differs from the Monte Carlo one by "
        "4.9e-11 m²"
        " below and 1.2e-10 m² above, up to 2.4 times the tolerance δ = 5e-11 m² (JCGM 101, clause 8). The Monte Carlo"
        " interval holds. The scatter of 10000 trials makes this verdict inconclusive; more trials may decide it.",
    )
    area = replace(stiffness, display_unit="mm^2", unit="m^2", monte_carlo=trials)
    assert wording.verdict(area) == (
        "The GUM uncertainty framework is not confirmed (JCGM 101, clause 8): its interval differs from the Monte "
        "Carlo one "
        "by 4.9×10⁻⁵ mm² below and 1.2×10⁻⁴ mm² above; the tolerance is δ = 5×10⁻⁵ mm². The scatter of "
        "10\N{NO-BREAK SPACE}000 trials makes this verdict inconclusive; more trials may decide it."
    )


def test_law_a_verdict_without_a_difference_is_told_as_it_is(stiffness: Result) -> None:
    trials = replace(stiffness.monte_carlo, d_low=None, verdict="Nothing uncertain enters: u = 0.")
    assert wording.verdict(replace(stiffness, monte_carlo=trials)) == "Nothing uncertain enters: u = 0."


@pytest.mark.parametrize(
    ("text", "tex"),
    [
        (
            "k = Σ n_i (F_i − F̄)² / Σ n_i (F_i − F̄) (x_i − x̄)",
            r"k=\dfrac{\sum n_{i}\,{\left(F_{i}-\bar{F} \right)}^{2}}"
            r"{\sum n_{i}\,\left(F_{i}-\bar{F} \right)\,\left(x_{i}-\bar{x} \right)}",
        ),
        ("y = sum(a_i + b) / n", r"y=\dfrac{\sum \left(a_{i}+b\right)}{n}"),
        ("y = sum(a_i b_i) + c", r"y=\sum a_{i}\,b_{i}+c"),
        ("ζ = δ/√(4π² + δ²)", r"ζ=\dfrac{δ}{\sqrt{4\,{π}^{2}+{δ}^{2}}}"),
        ("q = a₀² / a₁", r"q=\dfrac{{a_{0}}^{2}}{a_{1}}"),
    ],
)
def test_reference_equations_are_set_as_they_are_meant(text: str, tex: str) -> None:
    assert mathtext(text) == tex
    assert draw(text) is not None


def test_law_words_after_an_equation_stay_words() -> None:
    assert parted("δ = (2/i)·ln(a₀/a_i), over maxima i = 0, 1, …") == (
        "δ = (2/i)·ln(a₀/a_i)",
        "over maxima i = 0, 1, …",
    )
    assert parted("y = max(a, b)") == ("y = max(a, b)", "")


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("while e = x − x_t > 0", "while <i>e</i> = <i>x</i> − <i>x</i><sub>t</sub> &gt; 0"),
        ("with a_x = 0.1 m, ω_f² = 3 N·m/s", "with <i>a</i><sub>x</sub> = 0.1 m, <i>ω</i><sub>f</sub>² = 3 N·m/s"),
        ("<b>a load of at most ½·a₀</b>", "&lt;<i>b</i>&gt;a load of at most ½·<i>a₀</i>&lt;/<i>b</i>&gt;"),
    ],
)
def test_reference_symbols_among_words_are_set_and_units_are_not(text: str, markup: str) -> None:
    assert str(worded(text)) == markup


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("|E| ≤ 2·u_val, not u_value", "|E| ≤ 2·<i>u</i><sub>val</sub>, not u_value"),
        ("E_n = -1.5: k_1.csv, x_t.csv, <b>", "<i>E</i><sub>n</sub> = −1.5: k_1.csv, x_t.csv, &lt;b&gt;"),
        ("by 0.089 N/m below", 'by <span class="one">0.089 N/m</span> below'),
        ("s = 21.3 µm.", 's = <span class="one">21.3 µm</span>.'),
        ("7.6×10⁻⁵ % of 3 N·m", '<span class="one">7.6×10⁻⁵ %</span> of <span class="one">3 N·m</span>'),
        ("-2.3 ± 2.2 N·s²/m² (4 u)", '−<span class="one">2.3 ± 2.2 N·s²/m²</span> (<span class="one">4 u</span>)'),
        ("24 readings of 3 a.csv", "24 readings of 3 a.csv"),
        ("subtract F_c.", "subtract <i>F</i><sub>c</sub>."),
        ("(limit 5.6, p = 9.9e-305)", "(limit 5.6, p &lt; 10⁻⁶)"),
        ("p = 0.0213", "p = 0.0213"),
        ("\u202ek_dyn", "⟨U+202E⟩<i>k</i><sub>dyn</sub>"),
    ],
)
def test_reference_symbols_of_a_sentence_are_set_and_names_of_the_user_are_not(text: str, markup: str) -> None:
    assert str(sentence(text)) == markup


@pytest.mark.parametrize(
    ("low", "high"), [(23710.0, 25890.0), (-0.003, 0.0021), (143.2, 143.5), (-1e-9, 5e6), (-0.11, 0.11)]
)
def test_law_ticks_are_round_and_lie_within(low: float, high: float) -> None:
    places, decimals = ticks(low, high, 5)
    assert 2 <= len(places) <= 6
    assert all(low <= place <= high for place in places)
    assert all(abs(place - float(f"{place:.{decimals}f}")) < 1e-6 * (high - low) for place in places)


def test_law_more_results_than_a_matrix_has_are_listed_by_their_strongest_pairs() -> None:
    few, many = (findings_sample.build(samples) for samples in (2, 4))
    assert document.matrix(few)
    *main, aside = (result.name for result in many.results)
    results = tuple(replace(result, headline=result.name != aside) for result in many.results)
    every = [Correlation(*names, (-1) ** at * 0.9 / (1 + at)) for at, names in enumerate(combinations(main, 2))]
    many = replace(many, results=results, correlations=(Correlation(main[0], aside, 0.99), *reversed(every)))
    assert not document.matrix(many)
    assert document.pairs(many) == (every[:66], f"{len(every) - 66} further pairs, |r| at most 0.01: see results.json.")
    assert document.pairs(replace(many, correlations=tuple(every[:66]))) == (every[:66], "")
