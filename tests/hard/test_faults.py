"""Kills, full disks, lost folders, runs at once, clocks, locales, little memory: all or nothing, and one message."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from metrology import audit_trail, chain, report, signoff
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.cli.memory import LEAST
from metrology.errors import MetrologyError
from metrology.report import staging
from metrology.report.exchange import exchange
from metrology.signoff.opened import open_report
from metrology.signoff.signatures import read as signatures_of

KILLS = Path(__file__).with_name("kills.py")
CAMPAIGN = """\
format: metrology-campaign/1
id: bridge
title: Resistance of a bridge, {name}
report:
  number: TR-7
  issued: 2026-11-20
  checklists: []
  signatures:
    author: {{name: T. Tester, function: test engineer}}
laboratory: {{name: Tether Laboratory}}
monte_carlo: {{digits: 1, max_trials: 10000}}
ensembles:
  bridge: {{readings: bridge.csv, columns: {{V: V / V, I: I / mA}}}}
derived:
  - {{quantity: R, expression: V/I, unit: ohm}}
"""
READINGS = "V / V,I / mA\n5.007,19.663\n4.994,19.639\n5.005,19.640\n4.990,19.685\n4.999,19.678\n"
OLD = {"report.pdf": b"old", "results.json": b"old"}
NEW = {"report.pdf": b"new", "results.json": b"new"}


def revise(home: Path) -> None:
    """Give the campaign `a` the title of `b`, so that its results are others."""
    (home / "a" / "campaign.yaml").write_text(CAMPAIGN.format(name="b"), encoding="utf-8")


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """Two campaigns of one id, `a` and `b`, whose reports differ."""
    for name in "ab":
        (tmp_path / name).mkdir()
        (tmp_path / name / "campaign.yaml").write_text(CAMPAIGN.format(name=name), encoding="utf-8")
        (tmp_path / name / "bridge.csv").write_text(READINGS, encoding="utf-8")
    return tmp_path


def run(*arguments: str | Path, **further: object) -> subprocess.CompletedProcess[str]:
    """The command line in a process of its own."""
    command = [sys.executable, "-m", "metrology", *map(str, arguments)]
    environment = {**os.environ, **further.pop("env", {})}  # type: ignore[dict-item]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment, **further)  # type: ignore[call-overload, no-any-return]


def content(folder: Path) -> dict[str, bytes]:
    """Every file but the audit trail, which states times; its chain has to hold."""
    audit_trail.read(folder / audit_trail.NAME)
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != audit_trail.NAME}


def refused(done: subprocess.CompletedProcess[str], *words: str) -> None:
    """One message, status 2, no traceback."""
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    for word in words:
        assert word in done.stderr


# -- kills


def at_event(number: int, action: Callable[[], None]) -> bool:
    """Whether a child that kills itself at its `number`-th access to the file system lived to its end."""
    child = os.fork()
    if child == 0:
        left = [number]

        def hook(event: str, _arguments: object) -> None:
            if event.split(".")[0] in ("open", "os", "shutil", "tempfile", "fcntl", "glob", "ctypes"):
                left[0] -= 1
                if left[0] == 0:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(hook)
        action()
        os._exit(0)
    return os.WIFEXITED(os.waitpid(child, 0)[1])


def every_event(action: Callable[[], None]) -> Iterator[int]:
    """Kill at the first access, the second, and so on, until none is left."""
    number = 1
    while not at_event(number, action):
        yield number
        number += 1


@pytest.mark.long
def test_law_kill_at_every_step_of_replacing_a_folder_leaves_one_whole_set(tmp_path: Path) -> None:
    folder, seen = tmp_path / "tapes", []
    staging.replace_folder(folder, OLD)
    for _ in every_event(lambda: staging.replace_folder(folder, NEW)):
        seen.append(content(folder))
        staging.replace_folder(folder, OLD)
        assert [path.name for path in tmp_path.iterdir()] == ["tapes"]
        assert content(folder) == OLD
    assert len(seen) > 20
    assert all(found in (OLD, NEW) for found in seen)
    assert OLD in seen
    assert NEW in seen


def test_law_kill_at_every_step_of_replacing_a_file_leaves_one_whole_file(tmp_path: Path) -> None:
    path, seen = tmp_path / "report.pdf", []
    staging.replace_file(path, b"old")
    for _ in every_event(lambda: staging.replace_file(path, b"new")):
        seen.append(path.read_bytes())
        staging.replace_file(path, b"old")
        assert content(tmp_path) == {"report.pdf": b"old"}
    assert len(seen) > 8
    assert set(seen) == {b"old", b"new"}


def test_law_leftover_of_a_killed_signature_is_not_carried_into_a_new_report(tmp_path: Path) -> None:
    folder = tmp_path / "tapes"
    staging.replace_folder(folder, OLD)
    for _ in every_event(lambda: staging.replace_file(folder / "report.pdf", b"signed")):
        staging.replace_folder(folder, NEW)
        assert content(folder) == NEW


def kill(command: str, home: Path, count: int) -> dict[str, int]:
    done = subprocess.run(
        [sys.executable, KILLS, command, home, str(count), "6"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, int] = json.loads(done.stdout)
    assert set(found) <= {"old", "new"}, found
    assert sum(found.values()) == count
    return found


@pytest.mark.long
@pytest.mark.parametrize(("command", "count"), [("run", 4), ("report", 2), ("sign", 3)])
def test_law_kills_leave_the_old_set_or_the_new_one(command: str, count: int, home: Path) -> None:
    assert kill(command, home, count).get("old", 0) > 0


@pytest.mark.study
@pytest.mark.parametrize("command", ["run", "report", "sign"])
def test_law_seventy_kills_leave_the_old_set_or_the_new_one(command: str, home: Path) -> None:
    """With its three commands 210 kills: at random moments, half of them in the last third of a run."""
    found = kill(command, home, 70)
    assert found.get("old", 0) > 0


# -- signing while the report is made again


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, bytes], signoff.Signer]:
    """Files of a report, and its author's key."""
    place = tmp_path_factory.mktemp("made")
    (place / "campaign.yaml").write_text(CAMPAIGN.format(name="a"), encoding="utf-8")
    (place / "bridge.csv").write_text(READINGS, encoding="utf-8")
    campaign = load(place / "campaign.yaml")
    signoff.create_authority(place / "keys")
    files = report.make(chain.evaluate(campaign), sources=read_sources(campaign))
    return files, signoff.from_file(place / "keys" / "author.p12", None, lambda: b"test")


def roles(folder: Path) -> list[str]:
    return [one.role for one in signatures_of(open_report(folder / "report.pdf")) if not one.broken]


class Meanwhile(dict[str, bytes]):
    """Files during whose writing something else happens."""

    def __init__(self, files: dict[str, bytes], action: Callable[[], object]) -> None:
        super().__init__(files)
        self.action = action

    def items(self):  # type: ignore[no-untyped-def]
        self.action()
        return super().items()


def test_law_signature_given_while_a_report_is_written_stays(made, tmp_path: Path) -> None:
    files, signer = made
    folder = tmp_path / "bridge"
    report.place(files, folder)
    report.place(Meanwhile(files, lambda: signoff.sign(folder / "report.pdf", "author", signer)), folder)
    assert roles(folder) == ["author"]


def test_law_report_waits_for_a_signature_under_way(made, tmp_path: Path) -> None:
    files, signer = made
    folder = tmp_path / "bridge"
    report.place(files, folder)
    again = threading.Thread(target=report.place, args=(files, folder))
    waited = []

    class Slow:
        """The author's key, which takes its time."""

        def __getattr__(self, name: str) -> object:
            if not waited:
                again.start()
                again.join(0.5)
                waited.append(again.is_alive())
            return getattr(signer.pyhanko, name)

    try:
        signoff.sign(folder / "report.pdf", "author", replace(signer, pyhanko=Slow()))
    finally:
        again.join()
    assert waited == [True]
    assert roles(folder) == ["author"]


def test_law_run_that_ends_after_a_report_of_other_results_does_not_mix_with_it(tmp_path: Path) -> None:
    """What a run may write is decided at last: a report may have come meanwhile."""
    folder = tmp_path / "tapes"

    def settle() -> dict[str, bytes]:
        if (folder / "report.pdf").exists():
            raise MetrologyError
        return {}

    files = Meanwhile({"results.json": b"other"}, lambda: staging.replace_folder(folder, NEW))
    with pytest.raises(MetrologyError):
        staging.replace_folder(folder, files, settle=settle)
    assert content(folder) == NEW


# -- disk, folders


def test_limit_exchange_is_one_step_or_told(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").write_text(name, encoding="utf-8")
    swapped = exchange(tmp_path / "a", tmp_path / "b")
    assert (tmp_path / "a" / "file").read_text(encoding="utf-8") == ("b" if swapped else "a")
    with pytest.raises(FileNotFoundError):
        exchange(tmp_path / "a", tmp_path / "none")


@pytest.mark.long
def test_refusal_full_disk(home: Path) -> None:
    """A file system of 128 KiB where we may mount one; it holds one set, and not another beside it."""
    disk = home / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=128k", "none", str(disk)]
    if os.geteuid() != 0 or not shutil.which("mount") or subprocess.run(mount, check=False, stderr=-3).returncode:
        pytest.skip("not root, or no leave to mount a file system")
    try:
        assert run("run", home / "a", "--output", disk / "out").returncode == 0
        before = content(disk / "out" / "bridge")
        revise(home)
        (disk / "filler").write_bytes(b"x" * (os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize))
        refused(
            run("run", home / "a", "--output", disk / "out"),
            "no space left on device",
            "what was there before is whole",
        )
        assert content(disk / "out" / "bridge") == before
        (disk / "filler").unlink()
        assert run("run", home / "a", "--output", disk / "out").returncode == 0
        assert [path.name for path in (disk / "out").iterdir()] == ["bridge"]
    finally:
        subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.long
def test_refusal_limit_on_the_size_of_files(home: Path) -> None:
    limit = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (2000, 2000))
    refused(run("run", home / "a", "--output", home / "out", preexec_fn=limit), "file too large")
    assert list((home / "out").iterdir()) == []


@pytest.mark.long
def test_refusal_read_only_folder(home: Path) -> None:
    (home / "out").mkdir()
    (home / "out").chmod(0o555)
    done = run("run", home / "a", "--output", home / "out")
    (home / "out").chmod(0o755)
    refused(done, "write-protected", "lift the write protection")


def test_limit_folder_removed_while_a_report_is_written_comes_back(tmp_path: Path) -> None:
    folder = tmp_path / "tapes"
    staging.replace_folder(folder, OLD)
    staging.replace_folder(folder, Meanwhile(NEW, lambda: shutil.rmtree(folder)))
    assert content(folder) == NEW


def test_refusal_folder_above_removed_while_a_report_is_written(tmp_path: Path) -> None:
    above = tmp_path / "reports"
    with pytest.raises(MetrologyError, match="no such file or directory"):
        staging.replace_folder(above / "tapes", Meanwhile(NEW, lambda: shutil.rmtree(above)))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_refusal_working_folder_that_is_gone(home: Path) -> None:
    gone = home / "gone"
    gone.mkdir()
    refused(run("run", home / "a", cwd=gone, preexec_fn=partial(shutil.rmtree, gone)), "no such file")


@pytest.mark.long
def test_law_two_runs_of_one_campaign_at_once(home: Path) -> None:
    command = [sys.executable, "-m", "metrology", "run", home / "a", "--output", home / "out"]
    both = [subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) for _ in range(2)]
    assert [each.communicate()[1] for each in both] == [b"", b""]
    assert [each.returncode for each in both] == [0, 0]
    assert set(content(home / "out" / "bridge")) == {"results.json", "results.csv"}
    assert [path.name for path in (home / "out").iterdir()] == ["bridge"]
    trail = audit_trail.read(home / "out" / "bridge" / audit_trail.NAME)
    assert [entry.command for entry in trail] == ["run", "run"]


@pytest.mark.long
def test_law_report_and_signature_at_once_on_one_campaign(home: Path) -> None:
    """Processes that write and sign: each waits for the other, and the trail knows both."""
    assert run("report", home / "a", "--output", home / "out").returncode == 0
    assert run("authority", home / "keys").returncode == 0
    key = ["--key", home / "keys" / "author.p12", "--password-file", home / "keys" / "password.txt"]
    commands = [
        ["report", home / "a", "--output", home / "out"],
        ["sign", home / "out" / "bridge", "--role", "author", *key],
    ]
    both = [subprocess.Popen([sys.executable, "-m", "metrology", *one], stdout=-3, stderr=-1) for one in commands]
    assert [each.communicate()[1] for each in both] == [b"", b""]
    assert roles(home / "out" / "bridge") == ["author"]
    trail = audit_trail.read(home / "out" / "bridge" / audit_trail.NAME)
    assert sorted(entry.command for entry in trail) == ["report", "report", "sign"]


# -- links


@pytest.mark.long
def test_law_links_in_the_place_of_files_lead_nowhere(home: Path) -> None:
    """Whoever may write into the folder cannot have a file elsewhere overwritten."""
    victim, folder = home / "victim", home / "out" / "bridge"
    assert run("run", home / "a", "--output", home / "out").returncode == 0
    revise(home)
    for name in ("results.json", "results.csv"):
        victim.write_bytes(b"mine")
        (folder / name).unlink()
        (folder / name).symlink_to(victim)
        assert run("run", home / "a", "--output", home / "out").returncode == 0
        assert (victim.read_bytes(), (folder / name).is_symlink()) == (b"mine", False)


@pytest.mark.long
def test_refusal_trail_that_is_a_link(home: Path) -> None:
    victim, folder = home / "victim", home / "out" / "bridge"
    assert run("run", home / "a", "--output", home / "out").returncode == 0
    (folder / audit_trail.NAME).rename(victim)
    before = victim.read_bytes()
    (folder / audit_trail.NAME).symlink_to(victim)
    refused(run("run", home / "a", "--output", home / "out"), "got a link; expected the trail itself")
    assert victim.read_bytes() == before


def test_law_links_that_are_exchanged_while_a_report_is_written_lead_nowhere(tmp_path: Path) -> None:
    """A race: a name of the set becomes a link after the folder was looked at, and before it is exchanged."""
    victim, folder = tmp_path / "victim", tmp_path / "tapes"
    victim.write_bytes(b"mine")
    staging.replace_folder(folder, OLD)

    def link() -> None:
        (folder / "report.pdf").unlink()
        (folder / "report.pdf").symlink_to(victim)

    staging.replace_folder(folder, Meanwhile(NEW, link))
    assert victim.read_bytes() == b"mine"
    assert content(folder) == NEW


# -- clock, locale, memory


@pytest.mark.long
def test_law_clock_set_back_locale_and_time_zone_change_nothing(home: Path) -> None:
    """Files that are of the year 2100, a locale that may not be there, and a time zone off by a quarter of an hour."""
    assert run("run", home / "a", "--output", home / "out").returncode == 0
    before = content(home / "out" / "bridge")
    trail = home / "out" / "bridge" / audit_trail.NAME
    future = trail.read_bytes().replace(b'"at": "20', b'"at": "21')
    trail.write_bytes(future)
    for path in (*(home / "a").iterdir(), *(home / "out" / "bridge").iterdir(), home / "out" / "bridge"):
        os.utime(path, (4102444800, 4102444800))
    strange = {"LC_ALL": "C", "LANG": "tr_TR.ISO-8859-9", "TZ": "Asia/Kathmandu", "PYTHONUTF8": "0"}
    strange |= {"PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}
    done = run("run", home / "a", "--output", home / "out", env=strange)
    assert (done.returncode, done.stderr) == (0, "")
    assert content(home / "out" / "bridge") == before
    assert trail.read_bytes().startswith(future)  # a line of an earlier time follows upon it all the same
    assert len(audit_trail.read(trail)) == 2


@pytest.mark.long
@pytest.mark.parametrize("command", ["run", "report"])
@pytest.mark.parametrize("megabytes", [100, 200, 500, 1023])
def test_refusal_limit_of_memory_that_is_too_low_for_any_report(command: str, megabytes: int, home: Path) -> None:
    """At 200 MiB OpenBLAS, as it was loaded, asked for its buffer without end."""
    limit = partial(resource.setrlimit, resource.RLIMIT_AS, (megabytes << 20,) * 2)
    done = run(command, home / "a", "--output", home / "out", preexec_fn=limit, timeout=60)
    refused(done, "ulimit -v", f"{megabytes} MiB", "expected 1024 MiB at least")
    assert not (home / "out").exists()


SHORT = """
import mmap, os, resource, sys
os.environ["OPENBLAS_NUM_THREADS"] = "1"
from metrology.cli import main, memory
resource.setrlimit(resource.RLIMIT_AS, (memory.LEAST,) * 2)
memory.require()
held = []
try:
    while True: held.append(mmap.mmap(-1, 1 << 22))
except OSError:
    del held[-int(sys.argv[1]) // 4:]
sys.exit(main(sys.argv[2:]))
"""


@pytest.mark.long
@pytest.mark.parametrize(("command", "left"), [("run", 40), ("run", 64), ("report", 64), ("report", 300)])
def test_refusal_memory_that_is_used_up_on_the_way(command: str, left: int, home: Path) -> None:
    """What a campaign of long records does to the limit, here by megabytes that are held from the first."""
    program = [sys.executable, "-c", SHORT, str(left), command, str(home / "a"), "--output", str(home / "out")]
    refused(subprocess.run(program, capture_output=True, text=True, check=False, timeout=60), "memory is used up")
    assert not list((home / "out").glob("*"))


@pytest.mark.long
def test_limit_least_memory_is_enough_for_a_small_report(home: Path) -> None:
    limit = partial(resource.setrlimit, resource.RLIMIT_AS, (LEAST,) * 2)
    assert run("report", home / "a", "--output", home / "limited", preexec_fn=limit, timeout=60).returncode == 0
    assert run("report", home / "a", "--output", home / "free").returncode == 0
    assert content(home / "limited" / "bridge") == content(home / "free" / "bridge")
