"""Kill a command again and again, and tell what it left: a script, so that its children are forks of a quiet process.

``python kills.py COMMAND HOME COUNT SEED``: `HOME` holds the campaigns `a` and `b`, of one id, whose reports differ,
and for `sign` a test authority. Prints JSON: how often the folder held the old set, the new one, or a fault in words.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from metrology import audit_trail
from metrology.cli import main
from metrology.report import staging

Files = dict[str, bytes]
NAME = "bridge"


def content(folder: Path) -> Files:
    """Every file but the audit trail, which states times; its chain has to hold."""
    if not folder.is_dir():
        return {}
    audit_trail.read(folder / audit_trail.NAME)
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != audit_trail.NAME}


def quietly(arguments: Sequence[str]) -> int:
    with (
        Path(os.devnull).open("w", encoding="utf-8") as nowhere,
        contextlib.redirect_stdout(nowhere),
        contextlib.redirect_stderr(nowhere),
    ):
        return main(arguments)


def killed(arguments: Sequence[str], after: float) -> bool:
    """Whether a command was still running when it was killed, so many seconds after its begin."""
    child = os.fork()
    if child == 0:
        os._exit(quietly(arguments))
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def duration(arguments: Sequence[str]) -> float:
    begin = time.monotonic()
    child = os.fork()
    if child == 0:
        os._exit(quietly(arguments))
    os.waitpid(child, 0)
    return time.monotonic() - begin


def moments(whole: float, seed: int) -> Callable[[], float]:
    """Half of them anywhere, half near the end, where files are written."""
    rng = random.Random(seed)
    return lambda: rng.uniform(0, 1.05 * whole) if rng.random() < 0.5 else rng.uniform(0.7, 1.05) * whole


def state(found: Files, old: Files, is_new: Callable[[Files], bool]) -> str:
    """What a folder holds; files staged for one of its own do not count."""
    found = {name: value for name, value in found.items() if not name.startswith(".")}
    if found == old:
        return "old"
    return "new" if is_new(found) else f"neither: {sorted(found)}"


def study(command: str, home: Path, count: int, seed: int) -> Counter[str]:
    """Kill `command` `count` times while it runs, on a folder with the old set."""
    output = home / "out"
    folder, found = output / NAME, Counter[str]()
    old, arguments, is_new = (signing if command == "sign" else making)(command, home, folder)
    staging.replace_folder(folder, old)
    duration(arguments)
    assert state(content(folder), old, is_new) == "new"  # what runs to its end makes the new set
    staging.replace_folder(folder, old)
    when = moments(duration(arguments), seed)  # now that all is imported here, as it is in every child from now on
    while sum(found.values()) < count:
        staging.replace_folder(folder, old)  # what the next run does: it has to clean up as well
        if left := [path.name for path in output.iterdir() if path != folder]:
            return Counter({f"left behind: {left}": 1})
        if left := sorted(content(folder).keys() - old.keys()):
            return Counter({f"left in the folder: {left}": 1})
        if killed(arguments, when()):
            found[state(content(folder), old, is_new)] += 1
    return found


def making(command: str, home: Path, folder: Path) -> tuple[Files, list[str], Callable[[Files], bool]]:
    """The old set, the command that makes the new one, and how the new one is told."""
    sets = []
    for name in "ab":
        quietly([command, str(home / name), "--output", str(home / f"made-{name}")])
        sets.append(content(home / f"made-{name}" / NAME))
    assert sets[0] != sets[1]
    if command == "run":
        assert set(sets[0]) == {"results.json", "results.csv"}
    return sets[0], [command, str(home / "b"), "--output", str(folder.parent)], lambda found: found == sets[1]


def signing(_command: str, home: Path, folder: Path) -> tuple[Files, list[str], Callable[[Files], bool]]:
    """Likewise for a signature, of which no two are the same bytes."""
    from metrology.signoff.opened import open_report
    from metrology.signoff.signatures import read

    quietly(["report", str(home / "a"), "--output", str(home / "made-a")])
    quietly(["authority", str(home / "keys")])
    old = content(home / "made-a" / NAME)
    key = ["--key", str(home / "keys" / "author.p12"), "--password-file", str(home / "keys" / "password.txt")]

    def is_new(found: Files) -> bool:
        (home / "found.pdf").write_bytes(found["report.pdf"])
        given = read(open_report(home / "found.pdf"))
        rest = {**found, "report.pdf": old["report.pdf"]} == old
        return rest and [one.broken for one in given] == [""] and found["report.pdf"].startswith(old["report.pdf"])

    return old, ["sign", str(folder), "--role", "author", *key], is_new


if __name__ == "__main__":
    told = study(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
    print(json.dumps(told))
