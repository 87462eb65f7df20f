"""What is known of every campaign that is watched; who waits for news of them is woken."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Condition
from time import monotonic
from typing import Any, Literal

from metrology.errors import Fault, MetrologyError

State = Literal["waiting", "computing", "done", "refused"]


@dataclass(frozen=True)
class Page:
    """A report as HTML, and what a card says of it.

    Parameters
    ----------
    html : bytes
    whole : bool
        False for page 1 by the GUM uncertainty framework alone.
    title : str
        Of the campaign.
    results : tuple
        Of each main result: sample, quantity, value ± U, unit.
    verdicts : mapping
        How many requirements got which verdict.
    failures : tuple of str
        What could not be evaluated.
    """

    html: bytes
    whole: bool
    title: str
    results: tuple[tuple[str, str, str, str], ...]
    verdicts: Mapping[str, int]
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class Watched:
    """One campaign: `page` is its last good report, the `count`-th; `files` stands for the content of its files.

    `began`: when the last change was seen; `seconds`: from then to each page that followed.
    """

    path: Path
    files: str = ""
    state: State = "waiting"
    doing: str = ""
    faults: tuple[Fault, ...] = ()
    page: Page | None = None
    count: int = 0
    began: float = 0.0
    seconds: tuple[float, ...] = ()

    @property
    def title(self) -> str:
        """Of the campaign, or where its file lies as long as that is not known."""
        return self.page.title if self.page is not None else self.path.as_posix()


@dataclass
class Board:
    """All that is watched, by number. Everything is changed and read while `changed` is held."""

    campaigns: dict[int, Watched] = field(default_factory=dict)
    changed: Condition = field(default_factory=Condition)
    version: int = 0

    def add(self, path: Path) -> int:
        """Enter a campaign, and return its number."""
        with self.changed:
            number = len(self.campaigns)
            self.campaigns[number] = Watched(path)
            return number

    def note(self, number: int, **news: Any) -> None:
        """Change what is known of a campaign, and wake who waits."""
        with self.changed:
            self.campaigns[number] = replace(self.campaigns[number], **news)
            self.version += 1
            self.changed.notify_all()

    def enter(self, number: int, page: Page) -> None:
        """Put a report in the place of the one before."""
        with self.changed:
            known = self.campaigns[number]
            seconds = (*known.seconds, monotonic() - known.began)
            self.note(number, page=page, count=known.count + 1, seconds=seconds, faults=())

    def stale(self) -> Iterator[int]:
        """Numbers of the campaigns whose files are no longer what they were."""
        for number, known in list(self.campaigns.items()):
            files = content(known.path)
            if files != known.files:
                self.note(number, files=files, state="waiting", doing="", began=monotonic(), seconds=())
                yield number

    def wait(self, seen: int, timeout: float) -> int:
        """Wait for news after the version `seen`, no longer than `timeout` in seconds; return the version there is."""
        with self.changed:
            self.changed.wait_for(lambda: self.version != seen, timeout)
            return self.version


def content(path: Path) -> str:
    """A hash of all files that a campaign can read; what is wrong with them where they cannot be read."""
    from metrology.batch import bundle, stamp

    try:
        return stamp.content(bundle.pack(path, path.parent))
    except MetrologyError as error:
        return str(error)
