"""HTML to PDF that lasts, with the bundled fonts; nothing is fetched, and nothing that is missing passes unnoticed."""

from __future__ import annotations

import gc
import logging
import mmap
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError
from metrology.report import archival, fonts, pango

if TYPE_CHECKING:
    from metrology.report.attachments import Attachment
    from metrology.report.figures.style import Plot
    from metrology.report.html import Page

ROOM = 256 << 20
"""Bytes of address space that have to be left to lay out a report."""


class _Listener(logging.Handler):
    """Keeps what WeasyPrint complains about."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.complaints: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.complaints.append(record.getMessage())


class _Picture:
    """A picture as WeasyPrint asks for one: its size, and to be drawn; the operators are ready, nothing is parsed."""

    def __init__(self, plot: Plot) -> None:
        self._plot = plot

    def get_intrinsic_size(self, _resolution: float, _font_size: float) -> tuple[float, float, float]:
        """Width and height in CSS pixels, and their ratio."""
        width, height = self._plot.width / 0.75, self._plot.height / 0.75
        return width, height, width / height

    def draw(self, stream: Any, width: float, height: float, _style: Any) -> None:
        """Paint into a content stream whose y runs downwards."""
        stream.transform(a=width / self._plot.width, d=-height / self._plot.height, f=height)
        stream.stream.append(self._plot.operators)


def render(page: Page, files: Sequence[Attachment] = (), *, issued: str = "") -> bytes:
    """PDF of an HTML page: PDF/A-3a and PDF/UA-1, with files within.

    Parameters
    ----------
    page : Page
        The report.
    files : sequence of Attachment
        What it carries.
    issued : str
        Date of issue, ``2026-11-20``, or empty; no other date enters the file.

    Raises
    ------
    MetrologyError
        On any complaint of WeasyPrint: a missing image would else be a silent gap, an address a leak.
    UnprintedError
        Where Pango is missing.
    MemoryError
        Where there is no room for Pango, which ends the process when it lacks memory.
    """
    _refuse_little_memory()
    with _complaints_are_errors(), no_collection(), warnings.catch_warnings():
        # WeasyPrint opens its colour profile and leaves it to be closed.
        warnings.simplefilter("ignore", ResourceWarning)
        document = laid_out(page)
        archival.prepare(document)
        pdf: bytes = document.write_pdf(
            pdf_variant=archival.VARIANT, finisher=lambda _document, made: archival.finish(made, files, issued)
        )
    return pdf


def laid_out(page: Page) -> Any:
    """The pages of the PDF as WeasyPrint has laid them out, a ``weasyprint.Document``.

    Raises
    ------
    UnprintedError
        Where Pango is missing.
    """
    fonts.isolate()
    with pango.required():
        from weasyprint import HTML
        from weasyprint.text.fonts import FontConfiguration

    pictures = {url: _Picture(plot) for url, plot in page.pictures.items()}
    source = HTML(string=page.text, base_url="about:blank", url_fetcher=_fetcher())
    return source.render(font_config=FontConfiguration(), cache=pictures)


def _refuse_little_memory() -> None:
    try:
        mmap.mmap(-1, ROOM).close()
    except OSError as error:
        raise MemoryError from error


@contextmanager
def no_collection() -> Iterator[None]:
    """Hold the garbage collector: boxes and objects of a PDF live until the end, and searching them costs time."""
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()


def _fetcher() -> Any:
    from weasyprint.urls import URLFetcher

    return URLFetcher(allowed_protocols={"data"}, allow_redirects=False)


@contextmanager
def _complaints_are_errors() -> Iterator[None]:
    logger, listener = logging.getLogger("weasyprint"), _Listener()
    handlers, propagate, level = logger.handlers[:], logger.propagate, logger.level
    logger.handlers, logger.propagate = [listener], False
    logger.setLevel(logging.WARNING)
    try:
        yield
    finally:
        logger.handlers, logger.propagate = handlers, propagate
        logger.setLevel(level)
    if listener.complaints:
        raise MetrologyError(*(_fault(complaint) for complaint in dict.fromkeys(listener.complaints)))


def _fault(complaint: str) -> Fault:
    return Fault(
        "report.pdf",
        complaint if len(complaint) < 300 else complaint[:299] + "…",
        "a page without anything missing, unknown or fetched from elsewhere",
        "correct the template; images are `data:` addresses, and the fonts are those of the report",
    )
