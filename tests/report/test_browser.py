"""The HTML in a real browser, offline: it draws, zooms, sorts, shows what the PDF shows, and can be used by keys."""

from __future__ import annotations

import json
import re
import shutil
from base64 import b64decode
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from itertools import pairwise
from math import ceil, log2
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import response_sample
from pypdf import PdfReader

from metrology.findings import Findings
from metrology.report import document, html, make_html, write

CHROMIUM = shutil.which("chromium")
pytestmark = [pytest.mark.skipif(CHROMIUM is None, reason="no Chromium"), pytest.mark.long]
LONG = 5000
"""Samples of the held-out run; its findings keep fewer."""
COLUMNS = ("measured", "simulated", "low", "high", "error", "twice_u_val", "closed")
CLOSED_RMS = 1.07
"""Residual of the held-out run over its noise, as the sample has it."""
WIDE, NARROW = {"width": 1280, "height": 900}, {"width": 420, "height": 800}


@pytest.fixture(scope="module")
def both(findings: Findings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report with everything that tapes and nylon have: elongation, decay, and a response with a held-out run."""
    folder = tmp_path_factory.mktemp("reports") / "both"
    first = findings.results[0]
    small = replace(first.budget[0], input="small", share=1e-5)
    results = (replace(first, budget=(*first.budget, small)), *findings.results[1:])
    added = response_sample.add(replace(findings, results=results))
    longer = {"time": np.linspace(0.0, 9.95, LONG), **{key: np.sin(np.arange(LONG)) for key in COLUMNS}}
    longer |= {
        "low": longer["simulated"] - 0.06,
        "high": longer["simulated"] + 0.06,
        "twice_u_val": np.full(LONG, 0.08),
    }
    series = [{**one, "count": 2 * LONG} for one in added.verification[0]["runs"][0]["series"]]
    series[0]["closed_residual"] = [0.02 * CLOSED_RMS for _ in series[0]["time"]]
    run = {**added.verification[0]["runs"][0], "series": series}
    verification = ({**added.verification[0], "runs": [run]},)
    traces = {f"verification/nylon-response/{run['run']}/{one}": longer for one in ("x", "T")}
    write(replace(added, tests=(*findings.tests, *added.tests), verification=verification), folder, traces=traces)
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        yield running
        running.close()


@pytest.fixture(scope="module")
def visit(browser: Any, both: Path) -> Iterator[tuple[Any, list[str]]]:
    """The page, opened once, and whatever it complained of or asked for."""
    context = browser.new_context(offline=True, viewport=WIDE)
    page, told = context.new_page(), []
    page.on("console", lambda message: told.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: told.append(f"error: {error}"))
    page.on("request", lambda request: told.append(f"request: {request.url}"))
    page.goto((both / "report.html").as_uri())
    yield page, told
    context.close()


@pytest.fixture
def page(visit: tuple[Any, list[str]]) -> Any:
    """The page at its beginning, all chapters open, all of every plot shown."""
    opened, _ = visit
    opened.get_by_role("button", name="Open all chapters").click()
    for button in opened.get_by_role("button", name="Show all").all():
        button.click()
    opened.evaluate("document.activeElement.blur(); scrollTo(0, 0)")
    return opened


def held_out(page: Any) -> Any:
    """The zoomable plot of the held-out run."""
    return page.locator("figure.live .zoom")


def seen(zoom: Any) -> tuple[float, float]:
    """Ends of the time axis as the page tells them."""
    found = re.match(r"([\d.−e-]+) s to ([\d.−e-]+) s", zoom.locator(".seen").inner_text())
    assert found is not None
    return float(found[1].replace("−", "-")), float(found[2].replace("−", "-"))


def test_law_the_page_asks_for_nothing_and_complains_of_nothing(visit: tuple[Any, list[str]], both: Path) -> None:
    _, told = visit
    assert told == [f"request: {(both / 'report.html').as_uri()}"]


def test_planted_script_that_the_policy_does_not_name_does_not_run(browser: Any, both: Path, tmp_path: Path) -> None:
    text = (both / "report.html").read_text("utf-8")
    changed = tmp_path / "changed.html"
    changed.write_text(text.replace("</body>", "<script>document.title = 'taken over'</script></body>"), "utf-8")
    opened = browser.new_page(offline=True)
    opened.goto(changed.as_uri())
    assert opened.title().startswith("Test report")
    opened.close()


def test_law_headline_values_of_the_pdf_stand_on_the_page(page: Any, both: Path, findings: Findings) -> None:
    paper = re.sub(r"\s+", " ", PdfReader(both / "report.pdf").pages[0].extract_text())
    screen = re.sub(r"\s+", " ", page.locator("#summary").inner_text())
    lines = document.context(findings, {})["headlines"]
    assert len(lines) >= 5
    for line in lines:
        for value in (line.shown.value, line.shown.u, line.leads.low, line.leads.high):
            assert value in paper, value
            assert value in screen, value
    for entry in findings.conformity:
        assert entry.verdict in screen
        assert entry.verdict in paper


def words(zoom: Any) -> str:
    return str(zoom.locator(".seen").inner_text())


def changed(zoom: Any, before: str) -> None:
    """Wait until the plot tells another stretch of time than before; the policy lets no test wait by a script."""
    from playwright.sync_api import expect

    expect(zoom.locator(".seen")).not_to_have_text(before)


def test_law_dragging_zooms_every_channel_of_a_run_and_a_double_click_shows_all(page: Any) -> None:
    zoom = held_out(page)
    first = zoom.locator(".u-over").first
    first.scroll_into_view_if_needed()
    whole = seen(zoom)
    box = first.bounding_box()
    x = [box["x"] + share * box["width"] for share in (0.25, 0.75)]
    y = box["y"] + 0.5 * box["height"]
    page.mouse.move(x[0], y)
    page.mouse.down()
    page.mouse.move(x[1], y, steps=3)
    before = words(zoom)
    page.mouse.up()
    changed(zoom, before)
    low, high = seen(zoom)
    span = whole[1] - whole[0]
    assert low == pytest.approx(whole[0] + 0.25 * span, abs=0.02 * span)
    assert high == pytest.approx(whole[0] + 0.75 * span, abs=0.02 * span)
    before = words(zoom)
    first.dblclick()
    changed(zoom, before)
    assert seen(zoom) == whole


def test_law_cursor_tells_x_and_tension_of_one_moment_with_their_units(page: Any) -> None:
    from playwright.sync_api import expect

    zoom = held_out(page)
    first = zoom.locator(".u-over").first
    first.scroll_into_view_if_needed()
    box = first.bounding_box()
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
    for value in zoom.locator("tr:first-child > .u-value").all():
        expect(value).to_have_text(re.compile(r"\d s$"))
    legends = [legend.locator(".u-value").all_inner_texts() for legend in zoom.locator(".u-legend").all()]
    assert len(legends) == 4
    assert len({values[0] for values in legends}) == 1
    for values, unit in zip(legends, ("mm", "mm", "mN", "mN"), strict=True):
        assert all(value.endswith(f" {unit}") for value in values[1:]), values


def test_law_every_sample_that_the_page_was_given_is_in_its_plot(page: Any, findings: Findings) -> None:
    held = json.loads(page.locator("figure.live script[data-series]").text_content())
    times = np.frombuffer(b64decode(held["panels"][0]["time"]), "<f4").tolist()
    assert len(times) == LONG
    zoom = held_out(page)
    step = min(b - a for a, b in pairwise(times))
    for _ in range(ceil(log2((times[-1] - times[0]) / step)) + 1):
        zoom.get_by_role("button", name="Zoom in").click()
    low, high = seen(zoom)
    assert high - low < step
    zoom.get_by_role("button", name="Show all").click()
    assert f"{LONG} samples a line" in words(zoom)
    assert zoom.locator(".held").inner_text().startswith(f"{LONG} of {2 * LONG} readings are here")
    decays = [record for test in findings.tests if test.decay for record in test.decay.records]
    counts = [len(record.time) for record in decays]
    beneath = page.locator("figure:not(.live) > .zoom .seen").all_inner_texts()
    assert any(f"{counts[0]} samples a line" in text for text in beneath)


def test_law_keys_zoom_and_move_the_cursor_and_what_it_stands_on_is_told(page: Any) -> None:
    zoom = held_out(page)
    whole = seen(zoom)
    zoom.locator(".area").focus()
    before = words(zoom)
    page.keyboard.press("+")
    changed(zoom, before)
    low, high = seen(zoom)
    assert high - low == pytest.approx(0.5 * (whole[1] - whole[0]), rel=1e-3)
    page.keyboard.press("ArrowRight")
    assert re.search(r"^time [\d.]+ s, .*measured −?[\d.]+ ± [\d.]+ mm", zoom.locator(".spoken").text_content())
    before = words(zoom)
    page.keyboard.press("0")
    changed(zoom, before)
    assert seen(zoom) == whole


def test_law_cursor_tells_u_of_a_reading_of_the_model_and_of_their_difference(page: Any) -> None:
    zoom = held_out(page)
    zoom.locator(".area").focus()
    page.keyboard.press("ArrowRight")
    position = zoom.locator(".spoken").text_content().partition("N")[0]
    shown = re.findall(r"(measured|simulated|E) −?[\d.]+ ± ([\d.]+) mm", position)
    assert shown == [("measured", "20"), ("simulated", "31"), ("E", "40")]


def column(table: Any, at: int) -> list[str]:
    return [row.locator("th, td").nth(at).inner_text().strip() for row in table.locator("tbody tr").all()]


def test_law_a_table_sorts_by_keys_both_ways_and_back(page: Any) -> None:
    table = page.locator("table.results")
    before = column(table, 1)
    head = table.locator("th[data-sort]").nth(1)
    head.locator("button").focus()
    page.keyboard.press("Enter")
    assert head.get_attribute("aria-sort") == "ascending"
    assert column(table, 1) == sorted(before, key=str.casefold) != before
    page.keyboard.press("Enter")
    assert head.get_attribute("aria-sort") == "descending"
    assert column(table, 1) == sorted(before, key=str.casefold, reverse=True)
    page.keyboard.press("Enter")
    assert head.get_attribute("aria-sort") is None
    assert column(table, 1) == before


def test_law_numbers_sort_by_size_and_the_rest_of_a_budget_stays_last(page: Any) -> None:
    table = page.locator("table.budget").first
    contribution = table.locator("th[data-sort=number]").first
    at = 4
    last = table.locator("tbody tr").last.inner_text()
    assert last.startswith("Combined standard uncertainty with 1 further component")
    contribution.locator("button").click()
    rows = [row for row in table.locator("tbody tr").all() if row.locator("[colspan]").count() == 0]
    values = [float(row.locator("th, td").nth(at).inner_text().strip().replace("−", "-")) for row in rows]
    assert len(values) >= 3
    assert values == sorted(values)
    assert table.locator("tbody tr").last.inner_text() == last


def test_law_contents_follow_the_reader_and_fold_on_a_narrow_screen(page: Any) -> None:
    from playwright.sync_api import expect

    current = page.locator("#contents a[aria-current]")
    expect(current).to_have_attribute("href", "#summary")
    page.locator("#budgets").evaluate("part => part.scrollIntoView()")
    expect(current).to_have_attribute("href", "#budgets")
    assert current.count() == 1
    page.set_viewport_size(NARROW)
    entries = page.locator("#contents ol")
    fold = page.locator("#contents button")
    assert not entries.is_visible()
    fold.click()
    assert entries.is_visible()
    assert fold.get_attribute("aria-expanded") == "true"
    fold.click()
    page.set_viewport_size(WIDE)


def test_law_every_control_can_be_reached_by_the_tab_key(page: Any) -> None:
    wanted = page.evaluate(
        "[...document.querySelectorAll('a[href], button, .area')].filter((one) => one.checkVisibility()).length"
    )
    reached = set()
    for _ in range(wanted + 5):
        page.keyboard.press("Tab")
        reached.add(
            page.evaluate("[...document.querySelectorAll('a[href], button, .area')].indexOf(document.activeElement)")
        )
    assert len(reached - {-1}) == wanted


def test_law_on_a_phone_every_value_of_a_row_stands_behind_the_head_of_its_column(browser: Any, both: Path) -> None:
    context = browser.new_context(offline=True, viewport={"width": 390, "height": 800})
    opened = context.new_page()
    opened.goto((both / "report.html").as_uri())
    table = opened.locator("table.results")
    heads = [text.strip() for text in table.locator("thead th").all_text_contents()]
    row = table.locator("tbody tr").first
    assert [cell.get_attribute("data-label") for cell in row.locator("th, td").all()] == heads
    boxes = [cell.bounding_box() for cell in row.locator("th, td").all()]
    assert all(above["y"] + above["height"] <= below["y"] + 0.5 for above, below in pairwise(boxes))
    assert opened.locator("#summary").evaluate("part => part.scrollWidth - part.clientWidth") <= 1
    context.close()


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["wide", "narrow"])
def test_law_axe_finds_nothing_serious(browser: Any, both: Path, size: dict[str, int]) -> None:
    from axe_playwright_python.sync_playwright import Axe

    context = browser.new_context(offline=True, bypass_csp=True, viewport=size)
    opened = context.new_page()
    opened.goto((both / "report.html").as_uri())
    found = Axe().run(opened).response["violations"]
    opened.get_by_role("button", name="Open all chapters").click()
    found += Axe().run(opened).response["violations"]
    grave = {one["id"]: one["nodes"][0]["html"][:200] for one in found if one["impact"] in ("serious", "critical")}
    context.close()
    assert not grave


def test_law_a_reader_who_prefers_dark_pages_has_light_words_on_a_dark_ground(browser: Any, both: Path) -> None:
    context = browser.new_context(offline=True, viewport=WIDE, color_scheme="dark")
    opened = context.new_page()
    opened.goto((both / "report.html").as_uri())
    for selector in ("body", "h2", "caption", "tbody td", ".pass", ".note"):
        colour, ground = opened.locator(selector).first.evaluate(
            "one => [getComputedStyle(one).color, getComputedStyle(document.body).backgroundColor]"
        )
        assert contrast(colour, ground) > 4.5, selector
    context.close()


def test_law_on_a_phone_captions_and_pairs_have_the_width_of_the_page(browser: Any, both: Path) -> None:
    opened = browser.new_page(offline=True, viewport={"width": 390, "height": 844})
    opened.goto((both / "report.html").as_uri())
    opened.get_by_role("button", name="Open all chapters").click()
    assert opened.evaluate("document.documentElement.scrollWidth") <= 390
    widths = opened.locator("table.cards > caption, table.pairs tbody th, table.pairs tbody td").evaluate_all(
        "all => all.map(one => one.getBoundingClientRect().width)"
    )
    assert widths
    assert min(widths) > 300
    opened.close()


def test_law_printed_by_the_browser_no_head_of_a_column_is_a_button(browser: Any, both: Path) -> None:
    opened = browser.new_page(offline=True, viewport=WIDE)
    opened.goto((both / "report.html").as_uri())
    opened.emulate_media(media="print")
    looks = opened.locator("th button").evaluate_all(
        "all => all.map(one => [getComputedStyle(one).backgroundColor, getComputedStyle(one).borderTopWidth])"
    )
    assert looks
    assert {tuple(one) for one in looks} == {("rgba(0, 0, 0, 0)", "0px")}
    assert not opened.locator("#contents button").is_visible()
    opened.close()


def test_law_printed_by_the_browser_caption_and_head_of_a_table_stay_with_its_first_row(browser: Any) -> None:
    """Wherever on the page a table begins, and however high its rows are."""
    sheet = (html.ours() / "print.css").read_text(encoding="utf-8")
    row = "<tr><td>row<br>" + "row<br>" * 6 + "</td></tr>"
    table = f"<table><caption>caption<br>caption</caption><thead><tr><th>head</th></tr></thead><tbody>{row * 3}</tbody>"
    places = range(560, 1000, 20)
    parts = [f'<div style="break-after: page"><div style="height: {place}px"></div>{table}</table></div>'
             for place in places]  # fmt: skip
    opened = browser.new_page(offline=True)
    opened.set_content(f"<style>{sheet}</style>{''.join(parts)}")
    texts = [page.extract_text().split() for page in PdfReader(BytesIO(opened.pdf(prefer_css_page_size=True))).pages]
    opened.close()
    begins = [words for words in texts if "caption" in words]
    assert len(begins) == len(places)
    assert [words for words in begins if words.count("caption") != 2 or "head" not in words or "row" not in words] == []


@pytest.fixture
def folded(browser: Any, both: Path) -> Iterator[Any]:
    """A page of its own, just opened."""
    opened = browser.new_page(offline=True, viewport=WIDE)
    opened.goto((both / "report.html").as_uri())
    yield opened
    opened.close()


def chapter(page: Any, name: str) -> tuple[Any, Any]:
    """Button of a chapter and what it opens."""
    return page.locator(f"#{name} > h2 > button"), page.locator(f"#{name}-chapter")


def test_law_the_certificate_is_open_and_a_chapter_shows_its_conclusion_until_it_is_opened(folded: Any) -> None:
    assert folded.locator("#summary table.results").is_visible()
    button, body = chapter(folded, "budgets")
    assert button.get_attribute("aria-expanded") == "false"
    assert folded.locator("#budgets > .conclusion").is_visible()
    table = body.locator("table").first
    assert not table.evaluate("one => one.checkVisibility()")
    button.focus()
    folded.keyboard.press("Enter")
    assert button.get_attribute("aria-expanded") == "true"
    assert table.evaluate("one => one.checkVisibility()")
    assert chapter(folded, "provenance")[0].get_attribute("aria-expanded") == "false"


def test_law_a_link_opens_the_chapter_that_it_leads_into(folded: Any, both: Path) -> None:
    link = folded.locator("#summary table.results a[href^='#']").first
    target = folded.locator(link.get_attribute("href"))
    link.click()
    assert target.evaluate("one => one.checkVisibility()")
    assert 0 <= target.bounding_box()["y"] < WIDE["height"]
    folded.goto("about:blank")
    folded.goto((both / "report.html").as_uri() + "#provenance")
    assert chapter(folded, "provenance")[0].get_attribute("aria-expanded") == "true"
    assert chapter(folded, "budgets")[0].get_attribute("aria-expanded") == "false"


def test_law_a_search_finds_the_words_of_a_folded_chapter(folded: Any) -> None:
    _, body = chapter(folded, "budgets")
    assert body.get_attribute("hidden") == "until-found"
    body.evaluate("one => one.dispatchEvent(new Event('beforematch'))")
    assert chapter(folded, "budgets")[0].get_attribute("aria-expanded") == "true"


def test_law_printed_by_the_browser_all_chapters_are_open_and_afterwards_those_that_were(
    folded: Any, tmp_path: Path
) -> None:
    words = "Combined standard uncertainty with 1 further component"
    chapter(folded, "provenance")[0].click()
    folded.pdf(path=tmp_path / "printed.pdf", format="A4")
    text = " ".join(page.extract_text() for page in PdfReader(tmp_path / "printed.pdf").pages)
    assert words in re.sub(r"\s+", " ", text)
    assert "Open all chapters" not in text
    states = [one.get_attribute("aria-expanded") for one in folded.locator("h2 > button").all()]
    assert states.count("true") == 1


@pytest.fixture
def two_models(browser: Any, findings: Findings, tmp_path: Path) -> Iterator[Any]:
    """A page with one held-out run by the model as stated and by an extended one."""
    added = response_sample.add(findings)
    stated = {**added.verification[0], "basis": "stated"}
    both_models = replace(added, verification=(stated, {**stated, "basis": "extended"}))
    (tmp_path / "report.html").write_bytes(make_html(both_models))
    opened = browser.new_page(offline=True, viewport=WIDE)
    opened.goto((tmp_path / "report.html").as_uri())
    opened.get_by_role("button", name="Open all chapters").click()
    yield opened
    opened.close()


def test_law_buttons_choose_which_of_two_models_every_plot_of_a_run_shows(two_models: Any) -> None:
    zoom = two_models.locator("figure.live .zoom").first

    def shown() -> set[str]:
        rows = zoom.locator(".u-series:not(.u-off) > th").all_inner_texts()
        return {
            name for row in rows for name in ("model as stated", "extended model", "measured", "band") if name in row
        }

    every = {"model as stated", "extended model", "measured", "band"}
    assert shown() == every
    zoom.get_by_role("button", name="As stated").click()
    assert shown() == {"model as stated", "measured"}
    assert zoom.get_by_role("button", name="As stated").get_attribute("aria-pressed") == "true"
    zoom.get_by_role("button", name="Extended").click()
    assert shown() == every - {"model as stated"}
    zoom.get_by_role("button", name="Both models").click()
    assert shown() == every


def contrast(one: str, other: str) -> float:
    """Contrast ratio of two colours (WCAG 2.2, 1.4.3)."""

    def luminance(colour: str) -> float:
        parts = [int(part) / 255 for part in re.findall(r"\d+", colour)[:3]]
        r, g, b = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_law_without_script_values_pictures_and_contents_are_there(browser: Any, both: Path) -> None:
    context = browser.new_context(offline=True, java_script_enabled=False, viewport=WIDE)
    opened = context.new_page()
    opened.goto((both / "report.html").as_uri())
    assert opened.locator("#contents ol").is_visible()
    figures = opened.locator("figure > svg")
    assert figures.count() > 10
    assert figures.first.is_visible()
    assert "24730" in opened.locator("#summary").inner_text()
    context.close()


@pytest.mark.parametrize("size", [WIDE, NARROW])
def test_limit_a_word_longer_than_the_page_is_broken(browser: Any, findings: Findings, tmp_path: Path, size) -> None:
    laboratory = replace(findings.campaign.laboratory, name="Laboratory" + 20 * "measurement")
    named = replace(findings, campaign=replace(findings.campaign, laboratory=laboratory))
    (tmp_path / "report.html").write_text(html.render(named, {}).text, encoding="utf-8")
    opened = browser.new_page(viewport=size)
    opened.goto((tmp_path / "report.html").as_uri())
    line = opened.locator("p.laboratory strong").first
    within = "one => { const all = document.createRange(); all.selectNodeContents(one); return all"
    right = line.evaluate(f"{within}.getBoundingClientRect().right; }}")
    opened.close()
    assert right <= size["width"]
