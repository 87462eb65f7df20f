"""The test report: PDF, HTML, JSON and CSV from findings alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from metrology.findings import Findings

Progress = Callable[[str], None]


def write(findings: Findings, folder: Path, *, templates: Path | None = None, progress: Progress | None = None) -> None:
    """Write `report.pdf`, `report.html`, `results.json` and `results.csv` into `folder`, all or none of them.

    Same findings and templates give the same bytes.

    Parameters
    ----------
    findings : Findings
        All that the report is made of.
    folder : Path
        Made where it is missing. An older report in it stays whole until the new one is complete; other files stay.
    templates : Path, optional
        Folder with templates of the laboratory's own; what is missing there is taken from ours.
    progress : callable, optional
        Told what is being done.

    Raises
    ------
    MetrologyError
        Where the folder cannot be written, a template is wrong, or the PDF would lack something.
    """
    from metrology.report import figures, html, pdf, results, staging

    tell = progress or (lambda _text: None)
    plots = figures.draw(findings, tell)
    tell("laying out the HTML")
    page = html.render(findings, plots, templates=templates)
    tell("laying out the PDF")
    files = {
        "report.pdf": pdf.render(page),
        "report.html": html.standalone(page).encode("utf-8"),
        **results.files(findings),
    }
    tell("writing")
    staging.replace_folder(folder, files)


def write_results(findings: Findings, folder: Path) -> None:
    """Write `results.json` and `results.csv` alone into `folder`, all or none of them.

    Raises
    ------
    MetrologyError
        Where the folder cannot be written, or holds a report that was made from other results.
    """
    from metrology.report import results

    results.write(findings, folder)
