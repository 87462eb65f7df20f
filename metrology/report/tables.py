"""`results.csv`: one row a result and one a consensus, at full precision, for a spreadsheet."""

from __future__ import annotations

import csv
from io import StringIO

from metrology.consensus import Consensus
from metrology.findings import Findings, Result

HEADER = (
    *("report", "sample", "test", "method", "quantity", "value", "u", "unit", "dof", "p", "k", "low", "high"),
    *("monte_carlo_mean", "monte_carlo_u", "monte_carlo_low", "monte_carlo_high", "shortest_low", "shortest_high"),
    *("trials", "law_valid", "interval_low", "interval_high", "reconstructed"),
)


def results_csv(findings: Findings) -> bytes:
    """Results in SI; `interval_low` and `interval_high` end the interval that the report leads with."""
    stream = StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\r\n")
    writer.writerow(HEADER)
    reconstructed = "yes" if findings.campaign.reconstructed else "no"
    for result in findings.results:
        writer.writerow([_cell(value) for value in (findings.campaign.report_number, *_row(result), reconstructed)])
    for entry in findings.consensus:
        if entry.consistent:
            writer.writerow(
                [_cell(value) for value in (findings.campaign.report_number, *_agreed(entry), reconstructed)]
            )
    return stream.getvalue().encode("utf-8")


def _row(result: Result) -> tuple[object, ...]:
    law, trials = result.coverage, result.monte_carlo
    return (
        *(result.sample, result.test, result.method, result.quantity, result.value, result.u, result.unit, result.dof),
        *(law.p, law.k, law.low, law.high, trials.mean, trials.u, trials.low, trials.high),
        *(
            trials.shortest_low,
            trials.shortest_high,
            trials.trials,
            "yes" if trials.law_valid else "no",
            *result.interval,
        ),
    )


def _agreed(entry: Consensus) -> tuple[object, ...]:
    """A consensus as a row: without a test, and without columns of the Monte Carlo method."""
    interval = (entry.low, entry.high)
    moments = (entry.value, entry.u, entry.unit, entry.dof, entry.p, None, *interval)
    return (entry.sample, "", "consensus", entry.quantity, *moments, *(None,) * 8, *interval)


def _cell(value: object) -> str:
    """A text that a spreadsheet would run as a formula is quoted as text."""
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value)
    text = str(value)
    return "'" + text if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text
