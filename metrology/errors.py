"""The one error of the project: what is wrong with an input, where it stands, and how to fix it."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

_LINE = re.compile(r"\.\w+:\d")
"""A file and a line of it."""
_HINDRANCES = {
    errno.EISDIR: "a folder",
    errno.EEXIST: "a file where a folder should be",
    errno.ENOTDIR: "a file where a folder should be",
    errno.EACCES: "no permission",
    errno.EPERM: "no permission",
}
"""What the system says as a sentence → as a thing, which stands after 'got'."""


def own_text(error: OSError | ValueError) -> str:
    """What an operation on a file met, to stand after 'got'; a text of our own, as that of a reader, stays as it is.

    Examples
    --------
    >>> own_text(IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
    'a folder'
    """
    if not isinstance(error, OSError):
        return " ".join(str(error).split())[:200]
    text = error.strerror or type(error).__name__
    if error.errno is None or text != os.strerror(error.errno):
        return text.lower()
    return _HINDRANCES.get(error.errno, text.lower())


def printable(text: str) -> str:
    r"""Return a text as a terminal may show it: control and direction marks are written out.

    Examples
    --------
    >>> print(printable("a\x1b[31mb"))
    a\x1b[31mb
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


@dataclass(frozen=True)
class Edit:
    """What fixes a fault without a judgement: `new` in place of `old`, which stands at `line` and `column` (from 1)."""

    line: int
    column: int
    old: str
    new: str


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with an input.

    Parameters
    ----------
    where : str
        File, line and column where known, then the path of the entry: ``campaign.yaml:14:9 tests.a.loads[2]``.
    got : str
        What was found there, quoted as the user wrote it.
    expected : str
        What would have been right, with an example.
    fix : str
        How to put it right, where that is not plain from `expected`.
    edit : Edit, optional
        The change of the file that puts it right, where there is only one and no value changes by it.

    Examples
    --------
    >>> print(Fault("campaign.yaml:14:9 loads[2]", "'3.2 kg', a mass", "a force, such as '31.4 N'"))
    campaign.yaml:14:9 loads[2]: got '3.2 kg', a mass; expected a force, such as '31.4 N'
    """

    where: str
    got: str
    expected: str
    fix: str = ""
    edit: Edit | None = None

    def __str__(self) -> str:
        fix = f". Fix: {self.fix}" if self.fix else ""
        return printable(f"{self.where}: got {self.got}; expected {self.expected}{fix}")


@dataclass(frozen=True)
class Notice:
    """Something that was read although it is not as it should be, since nothing is lost by it.

    `where`: as in a `Fault`; `text`: a sentence on what was found and what was made of it.
    """

    where: str
    text: str

    def __str__(self) -> str:
        return printable(f"{self.where}: {self.text}")


def without(package: str, extra: str, what: str) -> MetrologyError:
    """Say that `what` needs a package that is not installed, and which extra brings it."""
    return MetrologyError(
        Fault(what, f"no {package}", f"the extra '{extra}'", f"pip install 'tether-metrology[{extra}]'")
    )


class MetrologyError(Exception):
    """Bad input or usage, told as one or more faults, all of them at once.

    Parameters
    ----------
    *faults : Fault
        In the order in which a reader meets them in the file.
    """

    def __init__(self, *faults: Fault) -> None:
        super().__init__("\n".join(str(fault) for fault in faults))
        self.faults = faults


@contextmanager
def faults_at(place: str) -> Iterator[None]:
    """Faults that are found inside, with the place in the file that they come from, unless they have a line."""
    try:
        yield
    except MetrologyError as error:
        faults = (
            one if _LINE.search(one.where) else replace(one, where=f"{place} {one.where}".strip())
            for one in error.faults
        )
        raise MetrologyError(*faults) from error
