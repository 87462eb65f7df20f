"""The process of its own in which some readers run, as a fork that takes many tasks: a start takes a second."""

from __future__ import annotations

import os
import resource
import signal
from dataclasses import dataclass
from typing import BinaryIO

from fuzz.guard import Find
from metrology.readings import apart

TASKS = 500
"""After so many tasks the fork is replaced: what libraries leave behind adds up."""
CPU_SECONDS = 1.0
"""Of a fork and of the system for it: a library that hangs, or fills gigabytes, is ended; the user's is after 120 s."""
ANSWER, FIND = b"a", b"f"


@dataclass
class Fork:
    """A fork of this process, with a pipe to it and one from it."""

    pid: int
    tasks: BinaryIO
    answers: BinaryIO
    left: int = TASKS

    @classmethod
    def begin(cls) -> Fork:
        """Fork; the child answers until its tasks end."""
        theirs, tasks = os.pipe()
        answers, ours = os.pipe()
        pid = os.fork()
        if not pid:
            os.close(tasks)
            os.close(answers)
            try:
                _serve(theirs, ours)
            finally:
                # What the reader raises ends the fork, as it ends the user's process: it is no find of the parent.
                os._exit(1)
        os.close(theirs)
        os.close(ours)
        return cls(pid, os.fdopen(tasks, "wb"), os.fdopen(answers, "rb"))

    def ask(self, task: bytes) -> tuple[bytes, bytes]:
        """Kind of answer and answer; both are empty where the fork crashed, or was ended."""
        self.left -= 1
        _send(self.tasks, ANSWER, task)
        return _receive(self.answers)

    def end(self) -> None:
        """End it, dead or alive."""
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        self.answers.close()
        self.tasks.close()


def _serve(theirs: int, ours: int) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (apart.MEMORY, apart.MEMORY))
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    # With libFuzzer's handlers a reader that crashes would be kept as a find; it ends this process, and is refused.
    for number in (signal.SIGPROF, signal.SIGSEGV, signal.SIGBUS, signal.SIGABRT, signal.SIGILL, signal.SIGFPE):
        signal.signal(number, signal.SIG_DFL)
    tasks, answers = os.fdopen(theirs, "rb"), os.fdopen(ours, "wb")
    kind, task = _receive(tasks)
    while kind:
        signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
        try:
            _send(answers, ANSWER, apart.answer(task))
        except Find as find:
            _send(answers, FIND, str(find).encode())
        signal.setitimer(signal.ITIMER_PROF, 0)
        kind, task = _receive(tasks)
    os._exit(0)


def _send(pipe: BinaryIO, kind: bytes, content: bytes) -> None:
    pipe.write(kind + len(content).to_bytes(8, "big") + content)
    pipe.flush()


def _receive(pipe: BinaryIO) -> tuple[bytes, bytes]:
    head = pipe.read(9)
    size = int.from_bytes(head[1:], "big")
    content = pipe.read(size)
    return (head[:1], content) if len(head) == 9 and len(content) == size else (b"", b"")


class Forks:
    """One fork at a time, a new one where the last died or has done its part."""

    def __init__(self) -> None:
        self.fork: Fork | None = None

    def __call__(self, task: bytes) -> bytes:
        """What the process of its own answers: nothing where it crashed."""
        self.fork = self.fork or Fork.begin()
        kind, answer = self.fork.ask(task)
        if not kind or not self.fork.left:
            self.fork.end()
            self.fork = None
        if kind == FIND:
            raise Find(answer.decode("utf-8", "replace"))
        return answer
