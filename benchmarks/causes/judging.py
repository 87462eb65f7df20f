"""Runs a method over the folders of cases, each in a process of its own that does not see the right answer."""

from __future__ import annotations

import os
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import yaml

from .answers import Answer, read
from .score import Judged, judge

ROOT = Path(__file__).resolve().parents[2]
ENTRIES = {
    name: [sys.executable, "-m", f"benchmarks.causes.entries.{module}", "{folder}"]
    for name, module in (
        ("ours", "ours"),
        ("least-squares", "least_squares"),
        ("sindy", "sindy"),
        ("gp", "gaussian_process"),
    )
}


def cases(place: Path) -> list[Path]:
    """Folders with an answer below a folder."""
    return sorted(file.parent for file in place.rglob("expected.yaml"))


def command(entry: str) -> list[str]:
    """Command of a known entry, or the words of another one; `{folder}` stands for that of a case."""
    found = ENTRIES.get(entry) or shlex.split(entry)
    return found if any("{folder}" in word for word in found) else [*found, "{folder}"]


def run(entry: str, folders: list[Path], limit: int, jobs: int) -> list[tuple[Judged, Answer]]:
    """Judge an entry on cases; `limit` of CPU time / s for each, after which it has not answered."""

    def one(folder: Path) -> tuple[Judged, Answer]:
        expected = yaml.safe_load((folder / "expected.yaml").read_text(encoding="utf-8"))
        answer, cpu = _asked(command(entry), folder, expected["method"], limit)
        found = judge(expected, answer, cpu)
        print(f"{found.case:32s} {cpu:6.1f} s  {found.said}", file=sys.stderr, flush=True)
        return found, answer

    with ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(one, folders))


def _asked(words: list[str], folder: Path, method: str, limit: int) -> tuple[Answer, float]:
    with tempfile.TemporaryDirectory() as place:
        seen = Path(place) / "case"
        shutil.copytree(folder, seen, ignore=shutil.ignore_patterns("expected.yaml"))
        return _ended([word.replace("{folder}", str(seen)) for word in words], Path(place), method, limit)


def _ended(words: list[str], place: Path, method: str, limit: int) -> tuple[Answer, float]:
    """Answer and CPU time of a process and of all that it waits for."""

    # A limit for each process; a program may wait for others, hence the clock as well.
    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))

    with (place / "out").open("w+b") as out, (place / "err").open("w+b") as err:
        begun = subprocess.Popen(words, stdout=out, stderr=err, cwd=ROOT, preexec_fn=limited, start_new_session=True)
        status, usage = _waited(begun, 4 * limit)
    cpu = usage.ru_utime + usage.ru_stime
    if status != 0:
        tail = (place / "err").read_text(errors="replace").strip().splitlines()[-1:]
        spent = status in (None, -signal.SIGXCPU, -signal.SIGKILL) or cpu >= 0.95 * limit
        why = f"no answer within {limit} s of CPU time" if spent else f"status {status}: {' '.join(tail)}"
        return Answer("not finished", failure=why), cpu
    try:
        return read((place / "out").read_text(encoding="utf-8"), method), cpu
    except ValueError as reason:
        return Answer("not finished", failure=f"not an answer: {reason}"), cpu


def _waited(process: subprocess.Popen[bytes], seconds: float) -> tuple[int | None, resource.struct_rusage]:
    end = time.monotonic() + seconds
    while True:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            process.returncode = os.waitstatus_to_exitcode(status)
            return process.returncode, usage
        if time.monotonic() > end:
            os.killpg(process.pid, 9)
            _, _, usage = os.wait4(process.pid, 0)
            process.returncode = -9
            return None, usage
        time.sleep(0.02)
