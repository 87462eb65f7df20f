"""The dashboard of a batch: a card for each campaign, its main results on one scale, charts of check standards."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.batch import card, stamp
from metrology.batch.card import Card
from metrology.batch.outcome import Outcome
from metrology.method.discovery import templates
from metrology.report import fonts, html, typesetting

if TYPE_CHECKING:
    from jinja2 import Environment

    from metrology.export.collect import Row
    from metrology.report.figures.style import Plot

NAME = "index.html"
SHEETS = {"report.css": "all", "screen.css": "all", "dashboard.css": "all"}
SCRIPTS = ("page.js", "dashboard.js")
MOST_PICTURES = 200
"""Campaigns from which on cards have no picture: each adds up to 100 kB to the page."""


@dataclass(frozen=True)
class Entry:
    """A campaign on the dashboard; `news`: what changed when its report was last made, None where that is unknown."""

    outcome: Outcome
    card: Card | None
    news: tuple[str, ...] | None
    picture: Plot | None

    @property
    def gravity(self) -> int:
        """What needs attention comes first: no report, failed, not judged, a model that is incomplete."""
        if self.outcome.state == "not made":
            return 0
        if self.outcome.failed:
            return 1
        if self.card is None or self.card.overall not in ("", "pass", "conditional pass"):
            return 2
        return 3 if self.doubted else 4

    @property
    def doubted(self) -> bool:
        """Whether a diagnosis ended without a model that explains the readings."""
        wanting = {"ambiguous", "unexplained", "not finished", "not testable"}
        return self.card is not None and any(verdict in wanting for _, verdict in self.card.models)


@dataclass(frozen=True)
class Measured:
    """A main result on the scale that all of its quantity share; `size`, `low` and `high` are numbers of `scale`."""

    outcome: Outcome
    row: Row
    main: card.Main
    size: float
    low: float
    high: float
    scale: str


def page(outcomes: Sequence[Outcome], folder: Path) -> bytes:
    """Return the page; it needs nothing but the folders of the reports beside it, which lie in `folder`."""
    from metrology.language.display import number

    sheets = style_sheets(SHEETS)
    pictures: dict[str, Plot] = {}

    def address(plot: Plot) -> str:
        url = f"plot:{len(pictures)}"
        pictures[url] = plot
        return url

    entries = [_entry(one, folder, drawn=len(outcomes) <= MOST_PICTURES) for one in outcomes]
    surroundings = environment()
    surroundings.filters |= {"address": address, "symbol": typesetting.symbol, "number": number}
    text = surroundings.get_template("batch.html").render(
        entries=entries,
        counts=Counter(one.state for one in outcomes),
        attention=[one for one in outcomes if one.failed],
        measured=(measured := _measured(entries)),
        quantities=Counter(one.row.quantity for one in measured).most_common(),
        charts=list(_charts(entries)),
        sheets=sheets,
        policy=html.policy(sheets),
    )
    scripts = tuple((templates() / name).read_text(encoding="utf-8") for name in SCRIPTS)
    return html.standalone(html.Page(text, pictures, "", scripts)).encode("utf-8")


def _entry(outcome: Outcome, folder: Path, *, drawn: bool) -> Entry:
    from metrology.report.figures.style import Plot

    known = card.read(folder / outcome.identity) if outcome.identity and outcome.report else None
    picture = known.picture if known is not None and drawn else None
    plot = None if picture is None else Plot(picture.svg, b"", picture.width, picture.height, picture.alt)
    news = stamp.news(folder / outcome.identity) if known is not None else None
    return Entry(outcome, known, news, plot)


def _measured(entries: Sequence[Entry]) -> list[Measured]:
    """Main results by quantity and unit, each group on one scale."""
    from metrology.language.display import scale

    groups: dict[tuple[str, str], list[tuple[Outcome, Row, card.Main]]] = {}
    for outcome, row, main in _main_results(entries):
        groups.setdefault((row.quantity, row.unit), []).append((outcome, row, main))
    found = []
    for (_, unit), members in sorted(groups.items()):
        factor, shown = scale(max(abs(row.value) for _, row, _ in members), unit)
        for outcome, row, main in members:
            low, high = (row.value if end is None else end for end in (row.low, row.high))
            found.append(Measured(outcome, row, main, row.value / factor, low / factor, high / factor, shown))
    return found


def _main_results(entries: Sequence[Entry]) -> Iterator[tuple[Outcome, Row, card.Main]]:
    for entry in entries:
        rows: Mapping[str, Row] = {} if entry.card is None else {row.name: row for row in entry.card.rows}
        for main in () if entry.card is None else entry.card.results:
            if isfinite(rows[main.name].value):
                yield entry.outcome, rows[main.name], main


def _charts(entries: Sequence[Entry]) -> Iterator[tuple[str, Plot]]:
    """Control charts of results that enough campaigns have, of an item of one name by a test of one name."""
    from metrology.export import control, picture

    groups: dict[tuple[str, str], list[Row]] = {}
    for entry in entries:
        for row in () if entry.card is None else entry.card.rows:
            if row.date:
                groups.setdefault((row.sample, row.name), []).append(row)
    for (_, name), rows in sorted(groups.items()):
        chart = control.chart(tuple(sorted(rows, key=lambda row: (row.date, row.report))), name)
        if chart.in_control is not None and len({row.campaign for row in rows}) > 1:
            yield chart.name, picture.draw(chart)


def environment() -> Environment:
    """Where the templates of pages that list campaigns are found and filled in."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(templates()),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=fonts.visible,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def style_sheets(names: Mapping[str, str]) -> list[tuple[str, str]]:
    """Style sheets, each with the medium that it is for."""
    return [((templates() / name).read_text(encoding="utf-8"), medium) for name, medium in names.items()]
