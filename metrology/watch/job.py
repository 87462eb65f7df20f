"""What a process of its own does: one campaign, page 1 by the GUM law at once, then the whole report."""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError
from metrology.watch.board import Page
from metrology.watch.kept import Kept

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from metrology.campaign.schema import Campaign
    from metrology.findings import Findings


@dataclass(frozen=True)
class Refused:
    """Why there is no report."""

    faults: tuple[Fault, ...]


def work(path: Path, sender: Connection, output: Path | None, *, kept: Path, allow_code: bool) -> None:
    """Evaluate a campaign; tell what is being done (a text), each `Page` as it is there, or why there is none.

    With `output` the whole report is written there too, as `metrology report` does. `kept`: folder of what is kept for
    the next evaluation of this campaign.
    """
    # Ctrl-C reaches every process of a terminal: the one that watches ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        _evaluate(path, sender, output, once=Kept(kept), allow_code=allow_code)
    except MetrologyError as error:
        sender.send(Refused(error.faults))
    except BrokenPipeError:
        # Nobody watches any more.
        return
    except Exception as error:  # noqa: BLE001
        # A fault of this program ends neither the watching nor in a traceback.
        got = f"{type(error).__name__}: {' '.join(str(error).split())}"
        sender.send(Refused((Fault(str(path), got, "a report", "this is a fault of metrology: please report it"),)))


def _evaluate(path: Path, sender: Connection, output: Path | None, *, once: Kept, allow_code: bool) -> None:
    from metrology import chain, report
    from metrology.campaign.load import load
    from metrology.campaign.sources import read_sources

    campaign = load(path, allow_code=allow_code)
    sources = read_sources(campaign)
    findings, traces = chain.by_law(campaign, once=once)
    sender.send(_page(findings, report.make_html(findings, traces=traces), whole=False))
    findings, traces = chain.traced(campaign, progress=sender.send, once=once)
    if output is None:
        html = report.make_html(findings, sources=sources, progress=sender.send, traces=traces)
    else:
        html = _written(campaign, findings, output, sources=sources, progress=sender.send, traces=traces)
    sender.send(_page(findings, html, whole=True))
    once.tidy()


def _written(campaign: Campaign, findings: Findings, output: Path, **rest: Any) -> bytes:
    """Write the report into its folder, and return its HTML."""
    from metrology import report
    from metrology.chain.diagnosis import extended

    folder = output / findings.campaign.id
    files: Mapping[str, bytes] = report.make(findings, **rest) | extended(campaign, findings, folder)
    report.place(files, folder, command="watch")
    return files["report.html"]


def _page(findings: Findings, html: bytes, *, whole: bool) -> Page:
    from metrology.report.lines import main_results

    lines = main_results(findings)
    results = ((one.sample, one.result.quantity, f"{one.value} ± {one.expanded}", one.shown.unit) for one in lines)
    verdicts = Counter[str](entry.verdict for entry in findings.conformity)
    return Page(html, whole, findings.campaign.title, tuple(results), dict(verdicts), findings.failures)
