"""What no input may bring about: a file written elsewhere, a socket, an error of our own that passes for a refusal."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable
from pathlib import Path

from metrology.errors import MetrologyError

OURS = Path(__file__).parents[1] / "metrology"


class Find(BaseException):
    """A find: no `Exception`, since what reads a damaged file turns every exception into a refusal."""


def guard(*places: Path) -> Callable[[str, tuple[object, ...]], None]:
    """A hook for `sys.addaudithook` that lets files be written in some places alone, and no connection be made."""
    allowed = [place.absolute() for place in (*places, Path(os.devnull))]

    def hook(event: str, arguments: tuple[object, ...]) -> None:
        if event == "socket.connect":
            raise Find(f"network: {arguments[1:]}")
        if event != "open" or not isinstance(arguments[0], str) or not isinstance(arguments[1], str):
            return
        path = Path(arguments[0]).absolute()
        if set(arguments[1]) & set("wax+") and not any(path.is_relative_to(place) for place in allowed):
            raise Find(f"a file written outside: {path}")

    return hook


def watched(function: Callable[..., object]) -> Callable[..., object]:
    """The same function, whose errors are finds where our own code raised them, by an operator or a built-in function.

    What a library raises at a damaged file is its way to refuse it.
    """

    def call(*arguments: object, **named: object) -> object:
        try:
            return function(*arguments, **named)
        except (MetrologyError, MemoryError):
            raise
        except Exception as error:
            innermost = traceback.extract_tb(error.__traceback__)[-1].filename
            if type(error).__module__ == "builtins" and Path(innermost).is_relative_to(OURS):
                raise Find("".join(traceback.format_exception(error))) from error
            raise

    return call
