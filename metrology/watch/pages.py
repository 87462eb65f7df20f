"""What a browser is sent: a page around each report, and an overview where a folder is watched."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from metrology.method.discovery import templates
from metrology.report import html
from metrology.watch.board import Board, Watched

if TYPE_CHECKING:
    from jinja2 import Environment

SHEETS = {"report.css": "all", "screen.css": "all", "watch.css": "all"}
SCRIPT = "watch.js"


class Pages:
    """Fills in the templates; `first` is the campaign on the first page, None where that is the overview."""

    def __init__(self, board: Board, *, overview: bool) -> None:
        self.board = board
        self.first = None if overview else 0

    @cached_property
    def environment(self) -> Environment:
        """Where the templates come from."""
        from metrology.batch import index

        return index.environment()

    @cached_property
    def _fixed(self) -> tuple[dict[str, Any], str]:
        """Style sheets and script, and the policy that lets these and no others into the page."""
        from metrology.batch import index

        sheets = index.style_sheets(SHEETS)
        script = (templates() / SCRIPT).read_text(encoding="utf-8")
        policy = (
            f"{html.policy(sheets)}; script-src 'sha256-{html.digest(script)}'; connect-src 'self'; frame-src 'self'"
        )
        return {"sheets": sheets, "script": script}, f"{policy}; frame-ancestors 'none'"

    def page(self, number: int | None) -> tuple[str, str]:
        """Return the page of a campaign, or the overview, and its Content-Security-Policy."""
        fixed, policy = self._fixed
        text = self.environment.get_template("watch.html").render(
            fixed, state=self.state(number), framed=number is not None, back=number is not None and self.first is None
        )
        return text, policy

    def state(self, number: int | None) -> dict[str, Any]:
        """Return what changes on a page: its title, its upper part, and the number of the report below."""
        with self.board.changed:
            campaigns = dict(self.board.campaigns)
        if number is None:
            panel = self.environment.get_template("overview.html").render(campaigns=campaigns)
            return {"title": _heading(*campaigns.values()), "panel": panel, "report": 0}
        one = campaigns[number]
        panel = self.environment.get_template("watched.html").render(one=one)
        return {"title": _heading(one), "panel": panel, "report": one.count}


def _heading(*campaigns: Watched) -> str:
    """What the browser shows above the page: faults first."""
    faults = sum(len(one.faults) for one in campaigns)
    name = campaigns[0].title if len(campaigns) == 1 else f"{len(campaigns)} campaigns"
    return f"({faults}) {name}" if faults else name
