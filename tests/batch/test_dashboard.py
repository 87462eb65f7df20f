"""The dashboard of a batch: what its cards say, what changed since, and its use in a real browser."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import findings_sample
import pytest

from metrology.batch import card, index, outcome, stamp
from metrology.batch.card import Card
from metrology.cli import main

CHROMIUM = shutil.which("chromium")
CAMPAIGN = """\
format: metrology-campaign/1
id: {id}
title: '{title}'
report: {{issued: 2026-0{month}-01}}
quantities:
  oil: {{value: {value} mm^2/s, uncertainty: [{{standard: 1.8 mm^2/s}}]}}
derived:
  - {{quantity: nu, expression: oil, unit: mm^2/s}}
requirements:
  - {{id: R1, quantity: nu, limits: {{lower: 12 mm^2/s}}, decision: {{rule: simple acceptance}}}}
"""


def write(lab: Path, name: str, *, value: float = 13.6, month: int = 1) -> None:
    (lab / name).mkdir(parents=True, exist_ok=True)
    text = CAMPAIGN.format(id=name, title=f"Oil {name}", value=value, month=month)
    (lab / name / "campaign.yaml").write_text(text, encoding="utf-8")


def make(lab: Path, reports: Path) -> int:
    return main(["batch", str(lab), "--output", str(reports), "--workers", "1", "--quiet"])


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five campaigns made, one of which fails; then two of them changed, one so that it cannot be read."""
    place = tmp_path_factory.mktemp("dashboard")
    for number, value in enumerate((13.6, 13.9, 11.0, 13.5, 13.7), 1):
        write(place / "lab", f"oil-{number}", value=value, month=number)
    assert make(place / "lab", place / "reports") == 1
    write(place / "lab", "oil-1", value=14.6)
    (place / "lab" / "oil-5" / "campaign.yaml").write_text("id: [", encoding="utf-8")
    assert make(place / "lab", place / "reports") == 1
    return place / "reports"


@pytest.fixture(scope="module")
def sample() -> Card:
    return card.make(findings_sample.build(1, records=1))


@pytest.mark.long
def test_law_a_stamp_tells_what_changed_and_the_page_says_it(made: Path) -> None:
    assert stamp.news(made / "oil-1") == ("nu: 13.6 ± 3.5 mm²/s, now 14.6 ± 3.5 mm²/s.",)
    assert stamp.news(made / "oil-2") is None
    text = (made / index.NAME).read_text(encoding="utf-8")
    assert "nu: 13.6 ± 3.5 mm²/s, now 14.6 ± 3.5 mm²/s." in text
    assert text.count("First report, or none to compare with") == 3


@pytest.mark.long
def test_law_results_that_campaigns_repeat_have_a_control_chart(made: Path) -> None:
    charts = (made / index.NAME).read_text(encoding="utf-8").partition('id="charts"')[2]
    assert re.search(r'aria-label="Control chart of nu [^"]*"', charts)
    assert "action" in charts


def test_twice_a_card_reads_as_it_was_written(sample: Card) -> None:
    assert card.parse(card.to_json(sample)) == sample
    assert card.parse(b'{"number": "TR-1"}') is None


def test_law_a_card_has_the_results_of_page_1(sample: Card) -> None:
    made = findings_sample.build(1, records=1)
    assert [one.name for one in sample.results] == [one.name for one in made.results if one.headline]
    assert sample.results[0].text == "24730 ± 740 N/m"
    assert sample.picture is not None
    assert "RECONSTRUCTED" in sample.picture.svg


def test_law_what_differs_between_two_cards_is_told(sample: Card) -> None:
    assert list(card.changes(sample, sample)) == []
    one, *others = sample.results
    now = replace(sample, state="Draft", results=(replace(one, value="24800"), *others[1:]), verdicts=(("R9", "fail"),))
    told = list(card.changes(sample, now))
    assert f"{one.name}: {one.text}, now 24800 ± 740 N/m." in told
    assert f"{others[0].name}: no longer a main result." in told
    assert "Requirement R9: none, now fail." in told
    assert any(sentence.startswith("State: ") for sentence in told)


def test_limit_a_card_of_another_version_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "oil-1").mkdir()
    (tmp_path / "oil-1" / card.NAME).write_text("{}", encoding="utf-8")
    lone = outcome.Outcome(Path("oil-1/campaign.yaml"), "up to date", "oil-1", "Oil")
    assert "Oil" in index.page([lone], tmp_path).decode()


@pytest.fixture(scope="module")
def page(made: Path) -> Iterator[Any]:
    """The dashboard in a browser without a net."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        context = browser.new_context(offline=True, viewport={"width": 1280, "height": 900})
        opened, told = context.new_page(), []
        opened.on("console", lambda message: told.append(message.text))
        opened.on("pageerror", lambda error: told.append(str(error)))
        opened.goto((made / index.NAME).as_uri())
        yield opened
        browser.close()
        assert told == []


in_browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")


def titles(page: Any) -> list[str]:
    return list(page.locator(".board li:visible h3").all_inner_texts())


@in_browser
@pytest.mark.long
def test_law_cards_can_be_searched_chosen_and_sorted(page: Any) -> None:
    assert len(titles(page)) == 5
    page.get_by_label("Search").fill("oil-3")
    assert titles(page) == ["Oil oil-3"]
    assert page.locator("#choice output").inner_text() == "1 of 5 shown"
    page.get_by_label("Search").fill("")
    page.get_by_label("Show").select_option("news")
    assert titles(page) == ["Oil oil-1"]
    page.get_by_label("Show").select_option("attention")
    page.get_by_label("Sort by").select_option("gravity")
    found = titles(page)
    assert len(found) == 2
    assert found[0].endswith("oil-5/campaign.yaml")
    assert found[1] == "Oil oil-3"
    page.get_by_label("Show").select_option("")
    page.get_by_label("Sort by").select_option("date")
    assert [title for title in titles(page) if title.startswith("Oil")] == [f"Oil oil-{n}" for n in (4, 3, 2, 1)]


@in_browser
@pytest.mark.long
def test_law_one_quantity_of_all_campaigns_stands_on_one_scale(page: Any) -> None:
    rows = page.locator("#measured tbody tr:visible")
    assert rows.count() == 4
    where = [float(row.locator("circle").get_attribute("cx").rstrip("%")) for row in rows.all()]
    sizes = [float(row.get_attribute("data-size")) for row in rows.all()]
    assert sorted(range(4), key=where.__getitem__) == sorted(range(4), key=sizes.__getitem__)
    assert (where[0] - where[1]) / (where[2] - where[1]) == pytest.approx(
        (sizes[0] - sizes[1]) / (sizes[2] - sizes[1]), rel=0.01
    )


@in_browser
@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_law_axe_finds_nothing_and_a_phone_scrolls_one_way(page: Any, made: Path, scheme: str, width: int) -> None:
    from axe_playwright_python.sync_playwright import Axe

    context = page.context.browser.new_context(
        offline=True, bypass_csp=True, viewport={"width": width, "height": 844}, color_scheme=scheme
    )
    opened = context.new_page()
    opened.goto((made / index.NAME).as_uri())
    found = {one["id"]: one["nodes"][0]["html"][:200] for one in Axe().run(opened).response["violations"]}
    wide = opened.evaluate("document.documentElement.scrollWidth")
    context.close()
    assert found == {}
    assert wide <= width
