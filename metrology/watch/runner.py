"""Campaigns evaluated one after the other, each in a process of its own, which a newer save ends.

A process can be ended at any moment, a thread cannot. The processes branch off one that has loaded everything that a
report needs, so that none of them waits for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from threading import Thread

from metrology.errors import Fault, own_text
from metrology.watch.board import Board, Page
from metrology.watch.job import Refused, work


class Runner(Thread):
    """Takes campaigns from a queue: the one that was saved last comes first."""

    def __init__(self, board: Board, *, output: Path | None, kept: Path, allow_code: bool) -> None:
        super().__init__(daemon=True)
        self.board, self.output, self.kept, self.allow_code = board, output, kept, allow_code
        self._queue: list[int] = []
        self._running: tuple[int, ForkServerProcess] | None = None
        self._ended = False
        self._context = get_context("forkserver")
        self._context.set_forkserver_preload(["metrology.watch.loaded"])

    def submit(self, numbers: Sequence[int]) -> None:
        """Put campaigns in front of the queue; what runs gives way to them, and is begun anew after them."""
        if not numbers:
            return
        with self.board.changed:
            behind = [number for number in self._queue if number not in numbers]
            if self._running is not None and self._running[0] not in (*numbers, *behind):
                behind.insert(0, self._running[0])
            self._queue = [*numbers, *behind]
            self._give_up()
            self.board.changed.notify_all()

    def stop(self) -> None:
        """End what runs, and begin nothing more."""
        with self.board.changed:
            self._ended, self._queue = True, []
            self._give_up()
            self.board.changed.notify_all()
        self.join()

    def _give_up(self) -> None:
        if self._running is not None:
            self._running[1].kill()
            self._running = None

    def run(self) -> None:
        """Evaluate what stands first in the queue, until it is stopped."""
        while True:
            with self.board.changed:
                self.board.changed.wait_for(lambda: self._queue or self._ended)
                if self._ended:
                    return
                number = self._queue.pop(0)
                try:
                    receiver, process = self._begin(number)
                except OSError as error:
                    self._refuse(number, own_text(error), "a process that computes", "is the path of TMPDIR too long?")
                    continue
            with receiver:
                self._follow(number, receiver, process)
            process.join()

    def _begin(self, number: int) -> tuple[Connection, ForkServerProcess]:
        receiver, sender = self._context.Pipe(duplex=False)
        arguments = (self.board.campaigns[number].path, sender, self.output)
        named = {"kept": self.kept / str(number), "allow_code": self.allow_code}
        process = self._context.Process(target=work, args=arguments, kwargs=named, daemon=True)
        process.start()
        sender.close()
        self._running = number, process
        self.board.note(number, state="computing", doing="reading")
        return receiver, process

    def _follow(self, number: int, receiver: Connection, process: ForkServerProcess) -> None:
        """Enter what a process tells until it ends; of one that was given up nothing any more."""
        message: object = None
        with suppress(EOFError, OSError):
            while True:
                message = receiver.recv()
                if not self._enter(number, process, message):
                    return
        process.join()
        with self.board.changed:
            if self._running != (number, process):
                return
            self._running = None
            if not isinstance(message, Page | Refused) or (isinstance(message, Page) and not message.whole):
                got = f"its computation ended by itself (exit status {process.exitcode})"
                self._refuse(number, got, "a report", "is there memory enough?")

    def _refuse(self, number: int, got: str, expected: str, fix: str) -> None:
        fault = Fault(str(self.board.campaigns[number].path), got, expected, fix)
        self.board.note(number, state="refused", doing="", faults=(fault,))

    def _enter(self, number: int, process: ForkServerProcess, message: object) -> bool:
        with self.board.changed:
            if self._running != (number, process):
                return False
            if isinstance(message, Page):
                self.board.note(number, state="done" if message.whole else "computing", doing="")
                self.board.enter(number, message)
            elif isinstance(message, Refused):
                self.board.note(number, state="refused", doing="", faults=message.faults)
            else:
                self.board.note(number, doing=message)
            return True
