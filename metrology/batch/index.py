"""The index page of a batch: one row a campaign, and what was not made with the reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from metrology.batch.outcome import Outcome
from metrology.method.discovery import templates
from metrology.report import html

if TYPE_CHECKING:
    from jinja2 import Environment

NAME = "index.html"
SHEETS = {"report.css": "all", "screen.css": "all"}


def page(outcomes: Sequence[Outcome]) -> bytes:
    """Return the page; it needs nothing but the folders of the reports beside it."""
    sheets = style_sheets(SHEETS)
    text = (
        environment()
        .get_template("batch.html")
        .render(
            outcomes=outcomes,
            counts=Counter(one.state for one in outcomes),
            attention=[one for one in outcomes if one.failed],
            sheets=sheets,
            policy=html.policy(sheets),
        )
    )
    return text.encode("utf-8")


def environment() -> Environment:
    """Where the templates of pages that list campaigns are found and filled in."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(templates()),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=html.visible,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def style_sheets(names: Mapping[str, str]) -> list[tuple[str, str]]:
    """Style sheets, each with the medium that it is for."""
    return [((templates() / name).read_text(encoding="utf-8"), medium) for name, medium in names.items()]
