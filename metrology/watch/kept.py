"""What long calls returned, kept from one save of a campaign to the next: what did not change is not computed again."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import ParamSpec, TypeVar

import cloudpickle

P = ParamSpec("P")
R = TypeVar("R")
UNKEPT = (pickle.PicklingError, TypeError, AttributeError)
"""What pickling raises for a value that has no other form than that in memory."""


class Kept:
    """Calls functions (`metrology.method.model.Memo`), and keeps what they returned in a folder of one campaign.

    Files, since a process that a newer save ends leaves what it had done.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(exist_ok=True)
        self.folder = folder
        self._used: set[str] = set()

    def __call__(self, function: Callable[P, R], /, *inputs: P.args, **named: P.kwargs) -> R:
        """Return what the function returns for these inputs, or returned before."""
        try:
            # Functions of a laboratory's own file are pickled by their code: another text is another key.
            key = sha256(cloudpickle.dumps((function, inputs, {**named, "progress": None}))).hexdigest()
        except UNKEPT:
            return function(*inputs, **named)
        self._used.add(key)
        path = self.folder / key
        if not path.is_file():
            returned = function(*inputs, **named)
            try:
                _write(path, cloudpickle.dumps(returned))
            except UNKEPT:
                return returned
        # Read also where it was made now: a value that was pickled once makes the same key whenever it is an input.
        read: R = pickle.loads(path.read_bytes())  # noqa: S301 - written by this program, in a folder of its own
        return read

    def tidy(self) -> None:
        """Remove what this evaluation did not use."""
        for path in self.folder.iterdir():
            if path.name not in self._used:
                path.unlink()


def _write(path: Path, data: bytes) -> None:
    # Under another name first: whoever is ended while writing leaves no half of a value.
    half = path.with_suffix(".half")
    half.write_bytes(data)
    half.replace(path)
