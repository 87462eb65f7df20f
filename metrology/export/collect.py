"""Results of many campaigns in one table: one row a result, for trends over campaigns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from metrology.errors import Fault, MetrologyError
from metrology.export import kept
from metrology.findings import Findings, Result
from metrology.judged import is_on
from metrology.report import staging

NAME = "results.json"


@dataclass(frozen=True)
class Row:
    """One result of one campaign; value, u and the ends of the interval that the report leads with in SI.

    `doubts`: what forbids in its own report that a requirement passes on it; empty where nothing does. `replaces`:
    number of the report that its own one amends.
    """

    campaign: str
    report: str
    issued: str
    date: str
    sample: str
    test: str
    method: str
    quantity: str
    name: str
    value: float
    u: float
    unit: str
    unit_dsi: str
    p: float
    low: float | None
    high: float | None
    law_valid: bool
    verdicts: str
    reconstructed: bool
    software: str
    file: str
    doubts: str = ""
    replaces: str = ""


@dataclass(frozen=True)
class Collection:
    """Rows of all files that could be read, by date, and of the others what was wrong."""

    rows: tuple[Row, ...]
    unreadable: tuple[Fault, ...]


def collect(folder: Path) -> Collection:
    """Return the results of every `results.json` below a folder.

    A file that cannot be read, or is not what the audit trail beside it knows, is listed.

    Raises
    ------
    MetrologyError
        Where there is no such folder, or no such file in it.
    """
    paths = sorted(path for path in folder.rglob(NAME) if not any(part.startswith(".") for part in path.parts))
    if not paths:
        expected = f"a folder with reports, of which each has a {NAME}"
        raise MetrologyError(Fault(str(folder), f"no {NAME}" if folder.is_dir() else "no such folder", expected))
    rows: list[Row] = []
    unreadable: list[Fault] = []
    for path in paths:
        try:
            rows += results(kept.findings(path), path.relative_to(folder).as_posix())
        except MetrologyError as error:
            unreadable += error.faults
    return Collection(tuple(sorted(rows, key=lambda row: (row.date, row.report, row.file))), tuple(unreadable))


def results(findings: Findings, file: str) -> Iterator[Row]:
    """Yield a row for every result of a campaign; `file` is where they are kept."""
    campaign = findings.campaign
    dates = {test.id: test.date for test in findings.tests}
    for result in findings.results:
        low, high = result.interval
        yield Row(
            campaign=campaign.id,
            report=campaign.report_number,
            issued=campaign.issued,
            date=dates.get(result.test, "") or campaign.issued,
            sample=result.sample,
            test=result.test,
            method=result.method,
            quantity=result.quantity,
            name=result.name,
            value=result.value,
            u=result.u,
            unit=result.unit,
            unit_dsi=result.unit_dsi,
            p=result.coverage.p,
            low=low,
            high=high,
            law_valid=result.monte_carlo.law_valid,
            verdicts=_verdicts(findings, result),
            reconstructed=bool(campaign.reconstructed),
            software=findings.software.get("metrology", ""),
            file=file,
            doubts="; ".join(_doubts(findings, result)),
            replaces=campaign.replaces.number if campaign.replaces else "",
        )


def _verdicts(findings: Findings, result: Result) -> str:
    given = [f"{v.requirement}: {v.verdict}" for v in findings.conformity if is_on(v.result, result.name)]
    return "; ".join(
        given + [f"{w.requirement}: not judged" for w in findings.withheld if is_on(w.result, result.name)]
    )


def _doubts(findings: Findings, result: Result) -> tuple[str, ...]:
    """What forbids a pass; of a version that does not write it with the result, why verdicts on it were withheld."""
    withheld = (reason for entry in findings.withheld if is_on(entry.result, result.name) for reason in entry.reasons)
    return tuple(dict.fromkeys((*result.doubts, *withheld)))


def table(rows: tuple[Row, ...]) -> Any:
    """Return the rows as one pandas table, with dates as dates.

    Raises
    ------
    MetrologyError
        Where the package `pandas` is missing.
    """
    try:
        import pandas as pd
    except ImportError:
        fix = "install the extra 'export'"
        raise MetrologyError(Fault("collect", "no package 'pandas'", "the package that makes tables", fix)) from None
    frame = pd.DataFrame([asdict(row) for row in rows], columns=list(Row.__dataclass_fields__))
    for column in ("issued", "date"):
        frame[column] = pd.to_datetime(frame[column], errors="coerce")
    return frame


def write(rows: tuple[Row, ...], path: Path) -> None:
    """Write the table as CSV or Parquet, by the end of the file's name.

    Raises
    ------
    MetrologyError
        For another end, where a package is missing, or where it cannot be written; an older table then stays.
    """
    if path.suffix not in (".csv", ".parquet"):
        raise MetrologyError(Fault(str(path), f"'{path.suffix}'", "a file that ends with .csv or .parquet"))
    frame = table(rows)
    staging.replace_file(path, _parquet(frame) if path.suffix == ".parquet" else _csv(frame))


def _parquet(frame: Any) -> bytes:
    content = BytesIO()
    frame.to_parquet(content, index=False)
    return content.getvalue()


def _csv(frame: Any) -> bytes:
    texts = frame.select_dtypes(include=["object", "string"]).columns
    frame[texts] = frame[texts].map(_harmless)
    return bytes(frame.to_csv(index=False, date_format="%Y-%m-%d").encode())


def _harmless(cell: Any) -> Any:
    """Quote a text that a spreadsheet would run as a formula."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(("=", "+", "-", "@", "\t", "\r")) else cell
