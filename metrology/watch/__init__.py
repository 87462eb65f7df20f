"""Campaigns computed again on every save, and their reports in a browser of this machine."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

from metrology.report import fonts
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
    if output is not None:
        # Here: a process that is ended in the midst of a report leaves no fonts behind.
        fonts.isolate()
    with (
        TemporaryDirectory(prefix="metrology-") as kept,
        Server(board, Pages(board, overview=overview), port) as server,
        _interrupted(),
        suppress(KeyboardInterrupt),
    ):
        Thread(target=server.serve_forever, daemon=True).start()
        runner = Runner(board, output=output, kept=Path(kept), allow_code=allow_code)
        runner.start()
        try:
            ready(server.url)
            runner.submit(list(board.stale()))
            for _ in _saves(board, path if path.is_dir() else path.parent):
                if overview:
                    _enter_new(board, path)
                runner.submit(list(board.stale()))
        finally:
            runner.stop()
            server.shutdown()


def _campaigns(path: Path) -> list[Path]:
    """The campaign file itself, the one in a folder, or all below it."""
    from metrology.batch import find
    from metrology.declaration import source_text

    if not path.is_dir():
        source_text.read_raw(path)
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


def _saves(board: Board, folder: Path) -> Iterator[None]:
    """Yield whenever something changed in a folder that the campaigns read from; these are others when one is saved."""
    from watchfiles import watch as changes

    while True:
        folders = _folders(board) | {folder}
        sure = False
        for moved in changes(
            *sorted(folders), step=20, rust_timeout=1000, yield_on_timeout=True, ignore_permission_denied=True
        ):
            if moved or not sure:
                # Once without a change: it may have come before the folders were looked at.
                sure = True
                yield
                if not _folders(board) <= folders:
                    break


def _folders(board: Board) -> set[Path]:
    """Folders that the campaigns read from.

    A file may be a link, or extend another: what it stands for, or begins from, is then changed elsewhere.
    """
    from metrology.batch import bundle

    found = {folder for one in board.campaigns.values() for folder in bundle.folders(one.path)}
    return {folder for folder in found if folder.is_dir()}


@contextmanager
def _interrupted() -> Iterator[None]:
    """Let a request to end, and a terminal that is closed, do what Ctrl-C does."""

    def interrupt(_number: int, _frame: Any) -> None:
        raise KeyboardInterrupt

    numbers = [signal.SIGTERM]
    # What `nohup` starts heeds no closed terminal; Windows has no such signal.
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    before = {number: signal.signal(number, interrupt) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
