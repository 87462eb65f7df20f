"""Pango, the library of the system that lays out the PDF: how to get it, and what is left where it is missing."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from io import StringIO

from metrology.errors import Fault, MetrologyError

HOW = {
    "Linux": "apt-get install libpangoft2-1.0-0 libharfbuzz-subset0 (Debian), or the pango of your distribution",
    "Darwin": "brew install pango",
    "Windows": "install MSYS2 with mingw-w64-x86_64-pango, and put its bin folder on PATH",
}
_OF_MEMORY = ("map segment", "allocate memory")
"""What the system says of a library that is there, and for which no memory is left."""


class UnprintedError(MetrologyError):
    """There is no PDF, since Pango is missing; `files` holds what else belongs to the report."""

    files: Mapping[str, bytes] = {}


def how() -> str:
    """How Pango is installed on this system."""
    return HOW.get(platform.system(), "install the library of that name")


@contextmanager
def required() -> Iterator[None]:
    """Say what to install where the libraries that are loaded within cannot be found.

    Raises
    ------
    UnprintedError
        Pango, or a library that it needs, is missing.
    """
    try:
        # WeasyPrint prints a page about its installation where it finds no Pango; stdout may be for a program.
        with redirect_stdout(StringIO()):
            yield
    except OSError as error:
        if any(words in str(error) for words in _OF_MEMORY):
            raise
        expected = "Pango, which lays out report.pdf; report.html and the results need none"
        raise UnprintedError(Fault("report.pdf", "no library Pango on this system", expected, how())) from error
