"""`results.json` and `results.csv` alone, for a run without a report; never beside a report that they do not fit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.errors import Fault, MetrologyError
from metrology.report import recorded, staging, tables

if TYPE_CHECKING:
    from metrology.findings import Findings

REPORTS = ("report.pdf", "report.html")
SOMETIMES = ("extended.yaml",)
"""Files that not every run makes: one of an older run must not stay beside newer results."""


def files(findings: Findings) -> dict[str, bytes]:
    """Both files by name."""
    from metrology.findings import to_json

    return {"results.json": to_json(findings), "results.csv": tables.results_csv(findings)}


def write(findings: Findings, folder: Path, further: Mapping[str, bytes], campaign: Path | None = None) -> None:
    """Write both files and further ones into `folder`, all or none; other files in it stay.

    `campaign`: the file that was evaluated.

    Raises
    ------
    MetrologyError
        Where the folder cannot be written, or holds what another campaign gave, or a report of other results.
    """
    made = files(findings)

    def settle() -> dict[str, bytes]:
        _refuse_other(folder, made["results.json"])
        return recorded.line(folder, "run", {**made, **further}, campaign=campaign)

    staging.replace_folder(folder, {**made, **further}, gone=SOMETIMES, settle=settle)


def _refuse_other(folder: Path, results: bytes) -> None:
    older = [name for name in REPORTS if (folder / name).exists()]
    if older and _read(folder / "results.json") != results:
        raise MetrologyError(
            Fault(
                str(folder),
                f"{older[0]} of other results",
                "a folder without a report, or with the report of these very results",
                "make the report anew with `metrology report`, or write elsewhere with --output",
            )
        )


def _read(path: Path) -> bytes | None:
    return path.read_bytes() if path.is_file() else None
