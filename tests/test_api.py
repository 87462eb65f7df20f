"""The public interface of Python: light to import, typed, and the same numbers as the command line."""

from __future__ import annotations

import ast
import copy
import pickle
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import metrology
from metrology import chain
from metrology.findings import to_json

CAMPAIGN = {
    "format": "metrology-campaign/1",
    "id": "bar",
    "title": "A bar <b>and</b> a weight",
    "monte_carlo": {"max_trials": 20000},
    "diagnosis": {"off": True},
    "instruments": {"gauge": {"kind": "gauge", "resolution": "0.01 mm"}},
    "samples": {"bar": {"material": "steel"}},
    "tests": {
        "pull": {
            "method": "elongation",
            "sample": "bar",
            "date": "2026-10-05",
            "instruments": {"extension": "gauge"},
            "loads": {"A": {"force": "10.0(1) N"}, "B": {"force": "20.0(1) N"}, "C": {"force": "30.0(1) N"}},
            "readings": "pull.csv",
        }
    },
    "derived": [{"quantity": "x_max", "expression": "F / k", "where": {"k": "pull.k"}, "unit": "mm"}],
    "quantities": {"F": "100(2) N"},
    "requirements": [
        {
            "id": "R1",
            "text": "stiff",
            "quantity": "pull.k",
            "limits": {"lower": "20 kN/m"},
            "decision": {"rule": "simple acceptance"},
        }
    ],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("api")
    rows = [
        f"{load},{repeat},{direction},{0.4 * step + 0.01 * ((repeat * step) % 2):.2f}"
        for repeat in (1, 2, 3)
        for direction in ("loading", "unloading")
        for step, load in enumerate("ABC", start=1)
    ]
    (path / "pull.csv").write_text("\n".join(["load,repeat,direction,reading / mm", *rows]) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def results(folder) -> metrology.Results:
    return metrology.run(CAMPAIGN, folder=folder)


def test_law_importing_loads_no_numpy_and_no_scipy():
    code = "import sys, metrology; print(*sorted({'numpy', 'scipy', 'pydantic', 'yaml', 'numba'} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_law_every_public_name_is_there_and_documented():
    for name in metrology.__all__:
        assert getattr(metrology, name).__doc__
    assert set(dir(metrology)) == set(metrology.__all__)
    with pytest.raises(AttributeError, match="module 'metrology' has no attribute 'nothing'"):
        metrology.nothing  # noqa: B018


def test_law_the_stub_names_what_the_package_has():
    """Type checkers read the stub, programs the package: the same names from the same modules."""
    stub = ast.parse(Path(metrology.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    homes = {
        alias.asname: node.module for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    stated = next(ast.literal_eval(node.value) for node in stub.body if isinstance(node, ast.Assign))
    assert stated == metrology.__all__ == sorted(metrology.__all__)
    assert homes == metrology._HOMES
    assert {*homes, "__version__"} == set(stated)


@pytest.mark.long
def test_law_functions_keep_their_names_when_their_packages_are_loaded():
    code = (
        "import metrology, metrology.chain, metrology.diagnostics, metrology.estimation\n"
        "print(callable(metrology.identify) and callable(metrology.diagnose) and callable(metrology.run))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True"


def test_twice_a_dictionary_gives_what_its_file_gives(folder, results):
    import yaml

    (folder / "campaign.yaml").write_text(yaml.safe_dump(CAMPAIGN, sort_keys=False, width=1000), encoding="utf-8")
    assert metrology.run(folder).to_json() == results.to_json()
    assert metrology.run(metrology.load(folder)).to_json() == results.to_json()
    assert to_json(chain.evaluate(metrology.load(folder / "campaign.yaml"))) == results.to_json()


def test_law_numbers_are_those_of_the_findings(results):
    k = results.k
    assert k is results["pull.k"] or k == results["pull.k"]
    assert float(k) == k.value == results.findings.results[0].value
    assert sum(row.share for row in k.budget()) == pytest.approx(1.0)
    assert results.verdicts[0].verdict == "pass"
    assert list(results) == ["pull.k", "x_max"]
    assert (k.unit, results.x_max.unit) == ("N/m", "m")


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_twice_results_that_are_copied_or_pickled_are_the_same(results, again):
    other = again(results)
    assert other.to_json() == results.to_json()
    assert [(one.name, one.value, one.u) for one in other.values()] == [
        (one.name, one.value, one.u) for one in results.values()
    ]
    assert np.array_equal(other.draws["pull.k"], results.draws["pull.k"])
    assert {name: list(curve) for name, curve in other.curves.items()} == {
        name: list(curve) for name, curve in results.curves.items()
    }
    assert len({results, other, results}) == 2
    assert results != other
    assert other.campaign.tests.keys() == results.campaign.tests.keys()


def test_twice_draws_have_the_moments_of_the_report(results):
    for name, quantity in results.items():
        stated = quantity.result.monte_carlo
        assert len(results.draws[name]) == stated.trials
        assert np.mean(quantity.draws) == pytest.approx(stated.mean, rel=1e-12)
        assert np.std(quantity.draws, ddof=1) == pytest.approx(stated.u, rel=1e-6)
    together = np.corrcoef(results.draws["pull.k"], results.draws["x_max"])[0, 1]
    assert together == pytest.approx(results.findings.correlations[0].coefficient, abs=0.03)


def test_closed_form_ufloats_keep_correlations(results):
    """x_max·k is F, whose uncertainty is stated: only with the correlation does it come out."""
    found = results.ufloats()
    force = found["x_max"] * found["pull.k"]
    assert (force.n, force.s) == pytest.approx((100.0, 2.0), rel=1e-6)


def test_twice_ufloats_of_a_quotient_have_the_u_of_the_budget(folder):
    """u of x_max/(1/k) and of ln(x_max·k²) by `uncertainties` against the same expression by the package."""
    import uncertainties.umath as um

    more = [
        {"quantity": "quotient", "expression": "x / (1 / k)", "where": {"x": "x_max", "k": "pull.k"}, "unit": "N"},
        {"quantity": "level", "expression": "log(x * k**2 / F0)", "where": {"x": "x_max", "k": "pull.k"}, "unit": "1"},
    ]
    stated = {**CAMPAIGN, "derived": [*CAMPAIGN["derived"], *more]}
    stated["quantities"] = CAMPAIGN["quantities"] | {"F0": "1 N**2/m"}
    found = metrology.run(stated, folder=folder)
    u = found.ufloats()
    x, k = u["x_max"], u["pull.k"]
    assert (x / (1 / k)).s == pytest.approx(found.quotient.result.framework.u, rel=1e-6)
    assert um.log(x * k**2).s == pytest.approx(found.level.result.framework.u, rel=1e-6)
    assert (x / (1 / k)).s < 0.9 * np.hypot(x.s * k.n, k.s * x.n)


def test_law_tables_of_pandas_have_every_result(results):
    assert results.to_pandas().loc["pull.k", "u"] == results.k.u
    assert len(results.k.budget().to_pandas()) == len(results.k.budget())


def test_law_a_notebook_shows_tables_in_which_text_is_text(results):
    shown = results._repr_html_()
    assert "A bar &lt;b&gt;and&lt;/b&gt; a weight" in shown
    assert shown.count("<table>") == shown.count("</table>") == 2
    assert str(results.k) in results._repr_html_() or str(results.k).split(" ±")[0] in shown
    assert "Uncertainty budget of pull.k" in results.k.budget()._repr_html_()


def test_law_plots_are_those_of_the_report_and_stand_alone(results):
    plots = results.plot()
    assert [one.name for one in plots] == ["elongation/pull", "density/pull.k", "density/x_max", "conformity/R1"]
    assert [one.name for one in results.plot("pull")] == ["elongation/pull"]
    assert results.k.plot() == plots[1]
    drawn = ET.fromstring(plots[0].svg)
    assert drawn.tag == "{http://www.w3.org/2000/svg}svg"
    assert drawn.get("font-family")
    assert drawn.get("aria-label") == plots[0].alt
    assert float(drawn.get("width").removesuffix("pt")) == pytest.approx(float(drawn.get("viewBox").split()[2]), abs=1)
    assert plots._repr_html_().count("<svg ") == plots._repr_html_().count("<figcaption>") == 4
    assert "k = 25" in plots[0].alt
    with pytest.raises(KeyError, match="no test 'pulling'; there are pull"):
        results.plot("pulling")


def test_law_a_plot_of_reconstructed_readings_says_so(folder):
    found = metrology.run({**CAMPAIGN, "reconstructed": "Made up."}, folder=folder)
    assert "RECONSTRUCTED READINGS" in found.k.plot().svg
    assert "RECONSTRUCTED READINGS" in found.plot("pull")[0].svg


def test_refusal_of_an_ambiguous_or_unknown_quantity(folder, results):
    with pytest.raises(AttributeError, match=r"no result 'zeta'; there are pull\.k, x_max"):
        results.zeta  # noqa: B018
    with pytest.raises(KeyError, match=r"which of pull\.k, x_max"):
        results.budget()


PULL = CAMPAIGN["tests"]["pull"]


def test_refusal_of_a_dictionary_with_faults_names_them(folder):
    with pytest.raises(metrology.MetrologyError, match="got '3 kg', a mass; expected a force"):
        metrology.run({**CAMPAIGN, "tests": {"pull": {**PULL, "loads": {"A": {"force": "3 kg"}}}}}, folder=folder)
    with pytest.raises(metrology.MetrologyError, match="got a value that no campaign file can hold"):
        metrology.run({**CAMPAIGN, "seed": object()}, folder=folder)


@pytest.mark.long
def test_law_a_report_is_written(folder, results, tmp_path):
    pdf = results.report(tmp_path / "report")
    assert pdf.read_bytes().startswith(b"%PDF")
    assert (tmp_path / "report" / "results.json").read_bytes() == results.to_json()


def test_law_notices_hold_the_checks_that_failed(folder):
    """The third load reads a millimetre high: not on the line, in the notices as on page 1."""
    rows = (folder / "pull.csv").read_text(encoding="utf-8").splitlines()
    moved = [row.rsplit(",", 1) for row in rows[1:]]
    high = [f"{head},{float(value) + head.startswith('C'):.2f}" for head, value in moved]
    (folder / "bent.csv").write_text("\n".join([rows[0], *high]) + "\n", encoding="utf-8")
    pull = {**CAMPAIGN["tests"]["pull"], "readings": "bent.csv"}
    found = metrology.run({**CAMPAIGN, "tests": {"pull": pull}}, folder=folder)
    assert [one.name for one in found.findings.tests[0].finding.checks if one.passed is False]
    assert any(one.startswith("Check: ") and "linearity" in one for one in found.notices)


@pytest.mark.long
def test_law_the_examples_of_the_page_run():
    """All blocks of docs/python.md but the first, which evaluates a whole campaign."""
    page = (Path(__file__).parents[1] / "docs" / "python.md").read_text(encoding="utf-8")
    _, *blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, object] = {"metrology": metrology}
    for block in blocks:
        exec(block, names)
    assert names["found"].k.value == pytest.approx(1.196 * 1e4, rel=1e-3)
    assert names["results"].R.value == pytest.approx(4.999 / 19.66e-3, rel=1e-9)
    named = {name for name in metrology.__all__ if not name.startswith("__")} - {"Budget", "MetrologyError", "Plots"}
    assert all(re.search(rf"\b{name}\b", page) for name in named)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: metrology.run(None), "run: got None; expected a campaign that 'load' returned"),
        (lambda: metrology.load(None), "load: got None; expected the path of a campaign file"),
        (lambda: metrology.identify("decay", instruments="x"), "decay.instruments: got 'x'; expected a dictionary"),
        (lambda: metrology.Rig(m="25 kg", k=1.0), "rig.m: got '25 kg'; expected a number"),
        (lambda: metrology.Rig(m=1.0, k=np.array([1.0, 2.0])), "rig.k: got array([1., 2.]); expected a number"),
        (lambda: metrology.Rig(1.0, 1.0, effects={"friction.force": "a"}), "rig.effects.friction.force: got 'a'"),
        (lambda: metrology.Run.sampled(np.zeros((2, 2)), 0.0), "run.t_x: got shape (2, 2)"),
        (lambda: metrology.Run.sampled([0.0, 1.0], "a"), "run.x0: got 'a'; expected a finite number"),
        (lambda: metrology.Run.sampled([0.0, 1.0], 0.0, force=0.38), "run.force: got 0.38; expected a Force"),
        (lambda: metrology.simulate(1, 2), "simulate: got 1; expected a Rig"),
        (
            lambda: metrology.identify("elongation", loads={"A": 3}, readings={"load": ["A"], "reading / mm": [1.0]}),
            "tests.elongation.",
        ),
    ],
)
def test_refusal_of_arguments_of_another_kind(call, told):
    with pytest.raises(metrology.MetrologyError) as caught:
        call()
    assert str(caught.value).startswith(told)


def test_closed_form_a_step_of_thrust_stretches_a_line_by_f_over_k():
    rig = metrology.Rig(m=2.0, k=50.0, c=20.0, taut=1.0)
    run = metrology.Run.sampled([0.0, 30.0], 1.0, force=metrology.Force.step(0.5))
    assert metrology.simulate(rig, run).x[-1] == pytest.approx(1.0 + 0.5 / 50.0, rel=1e-9)


def test_refusal_of_a_name_that_is_no_result_lists_those_that_are(results):
    with pytest.raises(KeyError, match=r"no result 'nope'; there are pull\.k"):
        results["nope"]
    assert results.budget("k").name == "pull.k"


def test_refusal_of_a_table_of_pandas_without_pandas_names_the_extra(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for call in (results.to_pandas, results.budget("k").to_pandas):
        with pytest.raises(metrology.MetrologyError, match=r"tether-metrology\[export\]"):
            call()
