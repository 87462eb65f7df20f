"""The index page of a batch: one row a campaign, and what was not made with the reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from metrology.batch.outcome import Outcome
from metrology.method.discovery import templates
from metrology.report import html

NAME = "index.html"
SHEETS = {"report.css": "all", "screen.css": "all"}


def page(outcomes: Sequence[Outcome]) -> bytes:
    """Return the page; it needs nothing but the folders of the reports beside it."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(templates()),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=html.visible,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    sheets = [((templates() / name).read_text(encoding="utf-8"), medium) for name, medium in SHEETS.items()]
    text = environment.get_template("batch.html").render(
        outcomes=outcomes,
        counts=Counter(one.state for one in outcomes),
        attention=[one for one in outcomes if one.failed],
        sheets=sheets,
        policy=html.policy(sheets),
    )
    return text.encode("utf-8")
