"""The test report: PDF, HTML, JSON and CSV from findings alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.report.attachments import Attachment
    from metrology.report.html import Page
    from metrology.timeseries import Trace

Progress = Callable[[str], None]
PDF = "report.pdf"


def write(
    findings: Findings,
    folder: Path,
    *,
    sources: Mapping[str, bytes] | None = None,
    templates: Path | None = None,
    progress: Progress | None = None,
    traces: Mapping[str, Trace] | None = None,
) -> None:
    """Write `report.pdf`, `report.html`, `results.json` and `results.csv` into `folder`, all or none of them.

    Same findings, sources and templates give the same bytes.

    Parameters
    ----------
    findings : Findings
        All that the report is made of.
    folder : Path
        Made where it is missing. An older report in it stays whole until the new one is complete; other files stay.
    sources : mapping, optional
        The files that `findings.inputs` names, path to content; the PDF carries them. Without them, as when a report is
        made again from `results.json` alone, it says that it lacks them.
    templates : Path, optional
        Folder with templates of the laboratory's own; what is missing there is taken from ours.
    progress : callable, optional
        Told what is being done.
    traces : mapping, optional
        Every sample behind the plots over time, as `chain.traced` returns them, for those that can be zoomed. Without
        them these hold what `results.json` holds, and say so. Nothing else depends on them.

    Raises
    ------
    MetrologyError
        Where the folder cannot be written, a template is wrong, a source is not the file that was evaluated, the PDF
        would lack something, or a signed report of other content is in the way.
    UnprintedError
        Where Pango is missing: everything but the PDF is written, and no older PDF stays.
    """
    from metrology.report.pango import UnprintedError

    try:
        files = make(findings, sources=sources, templates=templates, progress=progress, traces=traces)
    except UnprintedError as error:
        place(error.files, folder)
        raise
    if progress is not None:
        progress("writing")
    place(files, folder)


def place(files: Mapping[str, bytes], folder: Path, *, command: str = "report", campaign: Path | None = None) -> None:
    """Write the files of a report, as `make` returned them, into `folder`, all or none of them.

    The audit trail there gets a line by the name of the command, with the campaign file that was evaluated. An older
    PDF does not stay where `files` has none.

    Raises
    ------
    MetrologyError
        Where the folder cannot be written, a signed report of other content or what another campaign gave is in the
        way, or the trail is damaged.
    """
    from metrology.report import recorded, results, signed, staging

    def settle() -> dict[str, bytes]:
        pdf = signed.kept(folder / PDF, files.get(PDF))
        settled = {} if pdf is None else {PDF: pdf}
        return settled | recorded.line(folder, command, {**files, **settled}, campaign=campaign)

    staging.replace_folder(folder, files, gone=(PDF, *results.SOMETIMES), settle=settle)


def make(
    findings: Findings,
    *,
    sources: Mapping[str, bytes] | None = None,
    templates: Path | None = None,
    allow_code: bool = False,
    progress: Progress | None = None,
    traces: Mapping[str, Trace] | None = None,
) -> dict[str, bytes]:
    """Every file of a report by its name; parameters and errors as for `write`; `allow_code`: templates unconfined."""
    from metrology.report import document, html, pango, pdf

    tell = progress or (lambda _text: None)
    page, files, made = _page(findings, sources, tell, templates=templates, allow_code=allow_code, traces=traces)
    tell("laying out the PDF")
    made = {"report.html": html.standalone(page).encode("utf-8"), **made}
    try:
        return {PDF: pdf.render(page, files, issued=document.issued(findings)), **made}
    except pango.UnprintedError as error:
        error.files = made
        raise


def make_html(
    findings: Findings,
    *,
    sources: Mapping[str, bytes] | None = None,
    progress: Progress | None = None,
    traces: Mapping[str, Trace] | None = None,
) -> bytes:
    """`report.html` alone, as `make` returns it; parameters and errors likewise."""
    from metrology.report import html

    page, _, _ = _page(findings, sources, progress or (lambda _text: None), traces=traces)
    return html.standalone(page).encode("utf-8")


def _page(
    findings: Findings,
    sources: Mapping[str, bytes] | None,
    tell: Progress,
    *,
    templates: Path | None = None,
    allow_code: bool = False,
    traces: Mapping[str, Trace] | None = None,
) -> tuple[Page, tuple[Attachment, ...], dict[str, bytes]]:
    """The page, the files that the PDF carries, and those that lie beside it."""
    from metrology.report import attachments, crate, figures, html, results

    made = results.files(findings)
    made[crate.NAME] = crate.metadata(findings, made)
    files = attachments.gather(findings, made, sources)
    plots = figures.draw(findings, tell, traces=traces or {})
    tell("laying out the HTML")
    return html.render(findings, plots, files, templates=templates, allow_code=allow_code), files, made


def write_results(
    findings: Findings, folder: Path, *, further: Mapping[str, bytes] | None = None, campaign: Path | None = None
) -> None:
    """Write `results.json`, `results.csv` and further files into `folder`, without a report, all or none of them.

    `campaign`: the file that was evaluated.

    Raises
    ------
    MetrologyError
        Where the folder cannot be written, or holds what another campaign gave, or a report of other results.
    """
    from metrology.report import results

    results.write(findings, folder, further or {}, campaign)
