"""What the campaign names keeps its name and is described by nobody else; what has no value has no figures."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.chain import conformity
from metrology.findings import Findings
from metrology.language import notices, wording
from metrology.language.catalogue import Language
from metrology.language.display import chance
from metrology.report import html, lines, quality
from metrology.summary import print_summary

CAMPAIGN = """
format: metrology-campaign/1
id: own
title: Names of the laboratory's own
quantities:
  en: {value: 5.00 J, uncertainty: [{standard: 0.02 J, source: s}]}
  n: {value: 0.001 mm, uncertainty: [{standard: 5 um, dof: 3, type: A, source: repeat}]}
  one: 1.0(1) N
  nil: 0.0(1) N
derived:
  - {quantity: E, expression: 1*en, unit: J}
  - {quantity: c, expression: 1*en, unit: J}
  - {quantity: inv, expression: 1/n, unit: 1/mm}
  - {quantity: s, expression: one/nil}
  - {quantity: r, expression: sqrt(nil/one)}
requirements:
  - {id: R1, quantity: E, limits: {lower: 4.975 J}, decision: {rule: simple acceptance}}
  - {id: R2, quantity: E, limits: {lower: 4.9 J}, decision: {rule: specific risk, risk: 0.01}}
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Findings:
    path = tmp_path_factory.mktemp("own") / "campaign.yaml"
    path.write_text(CAMPAIGN, encoding="utf-8")
    return chain.evaluate(load(path))


def test_law_only_what_a_method_gives_is_called_by_its_word(own: Findings, findings: Findings) -> None:
    assert {line.name for line in lines.main_results(own)} == {""}
    assert "stiffness" in {line.name for line in lines.main_results(findings)}


@pytest.mark.parametrize("name", ["ind", "inv", "bad"])
def test_law_no_name_of_a_campaign_gets_a_capital(name: str) -> None:
    assert wording.opening(f"{name}: not calibrated.", {name}) == f"{name}: not calibrated."
    assert wording.opening(f"{name} has u = 0", {name}) == f"{name} has u = 0"
    assert wording.opening(f"{name}icator: not calibrated.", {name}).startswith(name.capitalize())


def test_law_page_1_keeps_names_and_the_figure_of_a_narrow_interval(own: Findings) -> None:
    text = re.sub(r"</?span[^>]*>", "", html.render(own, {}).text)
    assert re.search(r"</b>inv: the 95 % interval is too narrow: it held the value .* in only \d+ %", text)
    assert not re.search(r"\bInv\b", text)


def test_law_a_result_that_is_called_by_its_symbol_stands_once_in_its_table(own: Findings) -> None:
    page = html.render(own, {}).text
    cell = re.search(r"<td>[^\n]*5\.000 ± 0\.020 J(.*?)</td>", page)
    assert cell is not None
    assert "E" not in cell[1]


@pytest.mark.parametrize(("code", "words"), [
    ("de", "spezifisches Risiko von 0,01"), ("fr", "risque spécifique de 0,01"), ("it", "rischio specifico di 0,01"),
    ("es", "riesgo específico de 0,01"),
])  # fmt: skip
def test_law_the_rule_of_a_requirement_is_said_in_the_language_of_the_report(
    code: str, words: str, own: Findings
) -> None:
    assert quality.rule_name(own.conformity[1], Language(code, comma=True)) == words


def test_law_a_probability_in_a_sentence_has_no_digit_that_its_table_denies(own: Findings) -> None:
    entry = own.conformity[0]
    said = float(re.search(r"all the same is ([\d.]+) %", wording.prose(entry.sentence))[1])  # type: ignore[index]
    shown = float(chance(entry.specific_risk).removesuffix(" %"))
    assert abs(said - shown) <= 0.5
    assert said != shown
    assert "all the same is 8.5 %." in wording.prose("conforming all the same is 0.085.")


def test_law_what_has_no_value_has_no_uncertainty_and_no_interval(
    own: Findings, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = {line.result.quantity: line for line in lines.main_results(own)}
    for name in ("s", "r"):
        line = shown[name]
        assert (line.u, line.expanded, line.leads.low, line.leads.high) == ("–", "–", "–", "–")
    notes = [sentence for _, sentence in notices.brief(own)]
    assert not any("u = 0" in one for one in notes)
    assert not any("is not confirmed for" in one and re.search(r"for [^(]*\b[sr]\b", one) for one in own.warnings)
    monkeypatch.setenv("COLUMNS", "160")
    print_summary(own, tmp_path)
    row = next(line for line in capsys.readouterr().out.splitlines() if " s " in line)
    assert "undefined" in row
    assert "0.0" not in row


def test_law_a_reason_against_a_verdict_is_given_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "campaign.yaml").write_text(CAMPAIGN, encoding="utf-8")
    original = conformity.conformity
    doubt = SimpleNamespace(
        sentence="Two results contradict each other.", acceptance="", bars=lambda _: True, shape=False
    )
    monkeypatch.setattr(conformity, "conformity", lambda *given: original(*given[:3], {"E": (doubt, doubt)}))
    withheld = chain.evaluate(load(tmp_path / "campaign.yaml")).withheld
    assert [one.reasons for one in withheld] == 2 * [("Two results contradict each other.",)]
