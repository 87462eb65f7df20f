"""From a save of a campaign file to what its writer sees: page 1 by `metrology watch`, or `metrology report` again.

Of campaign `tapes`, whose title is another at every save, as after any change that leaves its tests as they are.

python benchmarks/watch.py
"""

from __future__ import annotations

import atexit
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from tempfile import mkdtemp

from side_by_side import ROOT, Case, main

PAGE_1, WHOLE = "framework alone", ": complete"


def _campaign() -> Path:
    folder = Path(mkdtemp()) / "tapes"
    shutil.copytree(ROOT / "campaigns" / "tapes", folder)
    return folder / "campaign.yaml"


def _save(path: Path, title: str) -> None:
    text = path.read_text(encoding="utf-8")
    before = next(line for line in text.splitlines() if line.startswith("title: "))
    path.write_text(text.replace(before, f"title: {title}"), encoding="utf-8")


def _news(url: str) -> Iterator[str]:
    connection = HTTPConnection(url.removeprefix("http://").rstrip("/"))
    connection.request("GET", "/events")
    yield from (line.decode() for line in connection.getresponse() if line.startswith(b"data:"))


def _watched(shown: str) -> Case:
    path = _campaign()
    command = [sys.executable, "-m", "metrology", "watch", str(path)]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    atexit.register(process.terminate)
    assert process.stdout is not None
    news = _news(process.stdout.readline().split(": ")[1].split(" ")[0])
    next(line for line in news if WHOLE in line)

    def work(_: int) -> str:
        _save(path, f"Saved at {time.time()}")
        # What is told until then is of the save before.
        next(line for line in news if "was saved" in line)
        next(line for line in news if shown in line)
        return "as HTML"

    return work


def anew() -> Case:
    path = _campaign()

    def work(_: int) -> str:
        _save(path, f"Saved at {time.time()}")
        subprocess.run([sys.executable, "-m", "metrology", "report", str(path)], cwd=path.parent, check=True,
                       capture_output=True)  # fmt: skip
        return "HTML and PDF"

    return work


if __name__ == "__main__":
    main(
        __file__,
        "From a save to the report of a campaign whose tests are as they were",
        {
            "watch, page 1": lambda: _watched(PAGE_1),
            "watch, whole report": lambda: _watched(WHOLE),
            "report": anew,
        },
        1,
        3,
        1,
    )
