"""What the dashboard says of a campaign: made where its report is made, kept beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.export.collect import Row

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.report.figures.style import Plot
    from metrology.report.lines import Line

NAME = "card.json"


@dataclass(frozen=True)
class Main:
    """A main result as page 1 prints it: `extent` is U, or the interval where that is not symmetric."""

    name: str
    item: str
    quantity: str
    method: str
    value: str
    extent: str
    unit: str

    @property
    def text(self) -> str:
        """Value and extent in one line."""
        return f"{self.value}{f' {self.extent}' if self.extent else ''} {self.unit}".rstrip()


@dataclass(frozen=True)
class Picture:
    """The picture of page 1."""

    svg: str
    width: float
    height: float
    alt: str


@dataclass(frozen=True)
class Card:
    """One campaign.

    Parameters
    ----------
    number, issued, tested, state, overall : str
        Of the report: its number, its date, that of the last test, whether it is a draft, and the worst verdict.
    reconstructed : bool
        Whether its readings were reconstructed.
    results : tuple of Main
        Its main results.
    verdicts : tuple
        Requirement and verdict of each that was judged.
    models : tuple
        Test and verdict of its diagnosis.
    rows : tuple of Row
        All results at full precision, for charts over campaigns.
    picture : Picture, optional
        That of page 1.
    """

    number: str
    issued: str
    tested: str
    state: str
    overall: str
    reconstructed: bool
    results: tuple[Main, ...]
    verdicts: tuple[tuple[str, str], ...]
    models: tuple[tuple[str, str], ...]
    rows: tuple[Row, ...]
    picture: Picture | None

    @property
    def date(self) -> str:
        """Day of the last test, or of issue."""
        return self.tested or self.issued


def make(findings: Findings) -> Card:
    """Return the card of a campaign."""
    from metrology.export import collect
    from metrology.language import done
    from metrology.report import figures, quality
    from metrology.report.lines import main_results

    called = done.called(findings)
    story = figures.jobs(findings).get("story")
    return Card(
        number=findings.campaign.report_number,
        issued=findings.campaign.issued,
        tested=max((test.date for test in findings.tests), default=""),
        state=quality.stated(findings),
        overall=quality.overall(findings),
        reconstructed=bool(findings.campaign.reconstructed),
        results=tuple(_main(line) for line in main_results(findings)),
        verdicts=tuple((entry.requirement, entry.verdict) for entry in findings.conformity),
        models=tuple((called.get(one.test, one.test), one.verdict) for one in findings.diagnosis),
        rows=tuple(collect.results(findings, f"{findings.campaign.id}/{collect.NAME}")),
        picture=None if story is None else _picture(story()),
    )


def _main(line: Line) -> Main:
    leads = line.leads
    interval = f"({leads.low} … {leads.high})" if leads.low not in ("", "–") else ""
    extent = interval if line.expanded == "–" else f"± {line.expanded}"
    result = line.result
    return Main(result.name, line.sample, result.quantity, result.method, line.value, extent, line.shown.unit)


def _picture(plot: Plot) -> Picture:
    return Picture(plot.svg, plot.width, plot.height, plot.alt)


def changes(before: Card, now: Card) -> Iterator[str]:
    """Yield what differs from an older card, each a sentence."""
    old, new = ({one.name: one for one in card.results} for card in (before, now))
    for name, one in new.items():
        if name not in old:
            yield f"{name}: new, {one.text}."
        elif one.text != old[name].text:
            yield f"{name}: {old[name].text}, now {one.text}."
    yield from (f"{name}: no longer a main result." for name in old if name not in new)
    for word, was, found in (
        ("Requirement", before.verdicts, now.verdicts),
        ("Model of", before.models, now.models),
    ):
        earlier, later = dict(was), dict(found)
        for name in (name for name in {**earlier, **later} if earlier.get(name) != later.get(name)):
            yield f"{word} {name}: {earlier.get(name, 'none')}, now {later.get(name, 'none')}."
    if before.state != now.state:
        yield f"State: {before.state}, now {now.state}."


@cache
def _adapter() -> Any:
    from pydantic import ConfigDict, TypeAdapter

    Card.__pydantic_config__ = ConfigDict(ser_json_inf_nan="strings")  # type: ignore[attr-defined]
    return TypeAdapter(Card)


def to_json(card: Card) -> bytes:
    """Write a card as it lies beside the report."""
    return bytes(_adapter().dump_json(card)) + b"\n"


def parse(content: bytes) -> Card | None:
    """Read a card; None for one of another version."""
    try:
        found: Card = _adapter().validate_json(content)
    except ValueError:
        return None
    return found


def read(folder: Path) -> Card | None:
    """Read the card in a report's folder; None where there is none of this version."""
    try:
        return parse((folder / NAME).read_bytes())
    except OSError:
        return None
