"""Campaigns computed again on every save, and their reports in a browser of this machine."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

from metrology.watch.board import Board
from metrology.watch.pages import Pages
from metrology.watch.runner import Runner
from metrology.watch.server import Server

__all__ = ["watch"]


def watch(
    path: Path,
    *,
    port: int = 0,
    output: Path | None = None,
    allow_code: bool = False,
    ready: Callable[[str], None] = lambda _url: None,
) -> None:
    """Serve the report of a campaign, or an overview of all below a folder, until interrupted.

    Parameters
    ----------
    path : Path
        A campaign file, a folder that holds ``campaign.yaml``, or one with such folders below it.
    port : int
        Of 127.0.0.1; 0 for a free one.
    output : Path, optional
        Where the reports are written too; without it none is.
    allow_code : bool
        Run the Python files that campaigns name under ``diagnosis``.
    ready : callable
        Told the address, as soon as the pages are served.

    Raises
    ------
    MetrologyError
        Where there is no campaign, or the port is taken.
    """
    board = Board()
    found = _campaigns(path)
    for one in found:
        board.add(one)
    overview = path.is_dir() and found != [path / "campaign.yaml"]
    with (
        TemporaryDirectory(prefix="metrology-") as kept,
        Server(board, Pages(board, overview=overview), port) as server,
        _interrupted_by_term(),
        suppress(KeyboardInterrupt),
    ):
        Thread(target=server.serve_forever, daemon=True).start()
        runner = Runner(board, output=output, kept=Path(kept), allow_code=allow_code)
        runner.start()
        try:
            ready(server.url)
            runner.submit(list(board.stale()))
            for _ in _saves(path, found):
                if overview:
                    _enter_new(board, path)
                runner.submit(list(board.stale()))
        finally:
            runner.stop()
            server.shutdown()


def _campaigns(path: Path) -> list[Path]:
    """The campaign file itself, the one in a folder, or all below it."""
    from metrology.batch import find
    from metrology.declaration import document

    if not path.is_dir():
        document.read_raw(path)
        return [path]
    return [path / "campaign.yaml"] if (path / "campaign.yaml").is_file() else find(path)


def _enter_new(board: Board, folder: Path) -> None:
    """Add campaigns that came into the folder since."""
    from metrology.batch import find
    from metrology.errors import MetrologyError

    known = {one.path for one in board.campaigns.values()}
    # One that was removed stays on its card, with its fault; none that is left is no reason to end.
    with suppress(MetrologyError):
        for path in find(folder):
            if path not in known:
                board.add(path)


def _saves(path: Path, found: Sequence[Path]) -> Iterator[Any]:
    """Yield whenever something changed in a folder that the campaigns read from."""
    from watchfiles import watch as changes

    from metrology.batch import bundle

    folders = {path} if path.is_dir() else {one.parent for one in found}
    # A file may be a link, or extend another: what it stands for, or begins from, is then changed elsewhere.
    folders |= {folder for one in found for folder in bundle.folders(one)}
    yield from changes(*sorted(folders), step=20, rust_timeout=1000, ignore_permission_denied=True)


@contextmanager
def _interrupted_by_term() -> Iterator[None]:
    """Let a request to end do what Ctrl-C does."""

    def interrupt(_number: int, _frame: Any) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
