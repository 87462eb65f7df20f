"""`metrology watch`, run as a user runs it: saved, broken, fixed and deleted files; in Chromium where there is one."""

from __future__ import annotations

import http.client
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from time import monotonic, sleep
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest
from test_lsp import READINGS, WIRE

from metrology.watch import job
from metrology.watch.board import Page
from metrology.watch.kept import Kept

pytest.importorskip("watchfiles")
pytestmark = pytest.mark.long
CHROMIUM = shutil.which("chromium")
WAIT = 90.0


class Answer(NamedTuple):
    status: int
    headers: dict[str, str]
    body: bytes


def _heeds() -> None:
    """A shell in the background ignores Ctrl-C, nohup the end of a terminal, and so would what they start."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


class Watch:
    """A running `metrology watch`, and what it told of one of its pages."""

    def __init__(self, *arguments: str, folder: Path) -> None:
        command = [sys.executable, "-m", "metrology", "watch", *arguments]
        self.process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=_heeds
        )
        assert self.process.stdout is not None
        self.url = re.search(r"http://127\.0\.0\.1:\d+/", self.process.stdout.readline())[0]
        self.port = int(self.url.rstrip("/").rpartition(":")[2])
        self.told: list[tuple[float, dict[str, Any]]] = []
        self.listen("/events")

    def listen(self, path: str) -> None:
        def read() -> None:
            with closing(http.client.HTTPConnection("127.0.0.1", self.port, timeout=WAIT)) as connection:
                connection.request("GET", path)
                with connection.getresponse() as answer:
                    for line in answer:
                        if line.startswith(b"data:"):
                            self.told.append((monotonic(), json.loads(line[5:])))

        self.listener = Thread(target=read, daemon=True)
        self.listener.start()

    def ask(self, path: str, **headers: str) -> Answer:
        with closing(http.client.HTTPConnection("127.0.0.1", self.port, timeout=WAIT)) as connection:
            connection.request("GET", path, headers=headers)
            with connection.getresponse() as answer:
                return Answer(
                    answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()
                )

    def until(self, holds: Callable[[dict[str, Any]], bool], since: int = 0) -> float:
        """Wait for a state, and return when it was told."""
        ends = monotonic() + WAIT
        while monotonic() < ends:
            for when, state in self.told[since:]:
                if holds(state):
                    return when
            sleep(0.01)
        raise AssertionError(self.told[-1:] and self.told[-1][1]["panel"])

    def whole(self, since: int = 0) -> float:
        return self.until(lambda state: "complete" in state["panel"], since)

    def end(self, number: int = signal.SIGINT) -> tuple[int, str]:
        self.process.send_signal(number)
        _, error = self.process.communicate(timeout=WAIT)
        self.listener.join()
        return self.process.returncode, error


@contextmanager
def watching(*arguments: str, folder: Path) -> Iterator[Watch]:
    watch = Watch(*arguments, folder=folder)
    try:
        yield watch
    finally:
        if watch.process.poll() is None:
            watch.end()


def wire(folder: Path, identity: str = "wire") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "wire.csv").write_text(READINGS)
    path = folder / "campaign.yaml"
    path.write_text(WIRE.replace("id: wire", f"id: {identity}"))
    return path


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="module")
def running(home: Path) -> Iterator[Watch]:
    wire(home / "wire")
    with watching("wire", folder=home) as watch:
        watch.whole()
        yield watch


@pytest.fixture
def saved(running: Watch, home: Path) -> Iterator[Callable[[str], int]]:
    """Saves the campaign; returns how much had been told before."""
    path = home / "wire" / "campaign.yaml"

    def save(text: str) -> int:
        told = len(running.told)
        path.write_text(text)
        return told

    yield save
    (home / "wire" / "wire.csv").write_text(READINGS)
    if path.exists() and path.read_text() == WIRE:
        return
    running.whole(save(WIRE))


def test_law_page_one_is_there_first_and_the_whole_report_follows(running: Watch, saved: Callable[[str], int]):
    told = saved(WIRE.replace("0.500(2)", "0.504(2)"))
    first = running.until(lambda state: "framework alone" in state["panel"], told)
    assert running.whole(told) > first
    page = running.ask("/report").body.decode()
    assert "0.504" in page
    assert 'id="trials"' in page


def test_law_page_one_does_not_claim_what_follows(tmp_path: Path):
    told: list[Any] = []
    sender = SimpleNamespace(send=told.append)
    job._evaluate(wire(tmp_path), sender, None, once=Kept(tmp_path / "kept"), allow_code=False)
    first, whole = (one for one in told if isinstance(one, Page))
    assert (first.whole, whole.whole) == (False, True)
    assert b'id="trials"' in whole.html
    assert b'id="trials"' not in first.html
    assert not re.search(r"Monte Carlo|diagnos|nan", first.html.decode().split("<body")[1], re.IGNORECASE)


def test_planted_faults_stand_above_the_last_good_report(running: Watch, saved: Callable[[str], int]):
    before = running.ask("/report").body
    told = saved(WIRE.replace("    length:", "    <b>lenght:"))
    running.until(lambda state: "campaign.yaml:10:5" in state["panel"] and "&lt;b&gt;" in state["panel"], told)
    assert running.told[-1][1]["title"].startswith("(1) ")
    assert running.ask("/report").body == before
    half = saved(WIRE[: WIRE.index("0.500")])
    running.until(lambda state: "campaign.yaml:9" in state["panel"], half)
    running.whole(saved(WIRE))


def test_planted_change_of_readings_and_deleted_file_are_seen(running: Watch, home: Path, saved: Callable[[str], int]):
    told = len(running.told)
    (home / "wire" / "wire.csv").write_text(READINGS.replace("0.50", "0.51", 1))
    running.whole(told)
    told = len(running.told)
    (home / "wire" / "campaign.yaml").unlink()
    running.until(lambda state: "no such file" in state["panel"], told)
    assert running.ask("/report").status == 200
    running.whole(saved(WIRE))


def test_law_a_save_supersedes_what_is_under_way(running: Watch, saved: Callable[[str], int]):
    for digit in (1, 2, 3):
        told = saved(WIRE.replace("0.500(2)", f"0.51{digit}(2)"))
        running.until(lambda state: "was saved" in state["panel"] or "alone" in state["panel"], told)
    running.whole(told)
    assert "0.513" in running.ask("/report").body.decode()


def test_limit_a_save_of_the_same_content_computes_nothing(running: Watch, home: Path):
    told = len(running.told)
    (home / "wire" / "campaign.yaml").write_text(WIRE)
    sleep(1.0)
    assert len(running.told) == told


def test_limit_another_file_disturbs_no_computation(running: Watch, home: Path, saved: Callable[[str], int]):
    told = saved(WIRE.replace("0.500(2)", "0.507(2)"))
    running.until(lambda state: "reading" in state["panel"] or "alone" in state["panel"], told)
    (home / "wire" / "notes.txt").write_text("not read by the campaign")
    running.whole(told)
    (home / "wire" / "notes.txt").unlink()
    panels = [state["panel"] for _, state in running.told[told:]]
    assert len([at for at, panel in enumerate(panels[1:]) if "reading" in panel and "reading" not in panels[at]]) <= 1


def test_law_nothing_is_written(running: Watch, home: Path):
    assert sorted(path.name for path in home.rglob("*")) == ["campaign.yaml", "wire", "wire.csv"]


def test_refusal_pages_from_elsewhere_can_neither_read_nor_frame_it(running: Watch):
    for host in ("attacker.example", f"attacker.example:{running.port}", ""):
        assert running.ask("/report", Host=host).status == 403
    assert running.ask("/", Host=f"localhost:{running.port}").status == 200
    answer = running.ask("/report", Origin="https://attacker.example")
    assert not any(name.startswith("access-control") for name in answer.headers)
    assert answer.headers["cross-origin-resource-policy"] == "same-origin"
    assert "frame-ancestors 'self'" in answer.headers["content-security-policy"]
    assert "frame-ancestors 'none'" in running.ask("/").headers["content-security-policy"]
    assert running.ask("/../../etc/passwd").status == 404


def test_law_it_listens_on_loopback_alone(running: Watch):
    rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    local = {row[1] for row in rows if row[3] == "0A"}
    assert {one for one in local if one.endswith(f":{running.port:04X}")} == {f"0100007F:{running.port:04X}"}


def test_twice_two_watch_one_campaign_and_end_cleanly(home: Path, running: Watch):
    with watching("wire/campaign.yaml", folder=home) as second:
        second.whole()
        assert second.port != running.port
        assert second.end() == (0, "")
    assert running.ask("/").status == 200


def below(process: int) -> list[int]:
    """Processes that a process started, and those that these started."""
    own = []
    for status in Path("/proc").glob("[0-9]*/status"):
        with suppress(OSError):  # It has ended meanwhile.
            if f"\nPPid:\t{process}\n" in status.read_text():
                own.append(int(status.parent.name))
    return [*own, *(one for child in own for one in below(child))]


def lives(process: int) -> bool:
    """Whether a process runs; one that has ended and was not asked for its status has no command line any more."""
    try:
        return bool(Path(f"/proc/{process}/cmdline").read_bytes())
    except OSError:
        return False


def wait_for_the_end(processes: list[int]) -> None:
    ends = monotonic() + WAIT
    while alive := [one for one in processes if lives(one)]:
        assert monotonic() < ends, alive
        sleep(0.1)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder for temporary files, of its own and with a short path: sockets lie in it."""
    with TemporaryDirectory(prefix="m-") as folder:
        monkeypatch.setenv("TMPDIR", folder)
        yield Path(folder)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_law_a_request_to_end_in_the_midst_of_a_computation_leaves_no_process_and_no_file(
    tmp_path: Path, short: Path, number: int
):
    """SIGHUP is what a terminal that is closed sends."""
    path = wire(tmp_path / "wire")
    with watching("wire", "--output", "made", folder=tmp_path) as watch:
        watch.whole()
        told = len(watch.told)
        path.write_text(WIRE.replace("0.500(2)", "0.501(2)"))
        watch.until(lambda state: "framework alone" in state["panel"] or "complete" in state["panel"], told)
        left = below(watch.process.pid)
        assert left
        assert watch.end(number) == (0, "")
    wait_for_the_end(left)
    assert list(short.glob("metrology-*")) == []


def test_limit_a_computation_that_cannot_begin_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The path of a socket has 107 bytes at most."""
    long = tmp_path / ("t" * 100)
    long.mkdir()
    monkeypatch.setenv("TMPDIR", str(long))
    wire(tmp_path / "wire")
    with watching("wire", folder=tmp_path) as watch:
        watch.until(lambda state: "a process that computes" in state["panel"])
        assert watch.end() == (0, "")


ASKING = """
import pickle, sys
from metrology.readings import apart

class Slow:
    def __reduce__(self):
        return exec, (f"import pathlib, time; pathlib.Path({sys.argv[1]!r}).touch(); time.sleep(600)",)

apart._in_a_process(pickle.dumps(Slow()))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a reader ends by its own alarm alone")
@pytest.mark.parametrize("hangs", [False, True])
def test_law_a_reader_ends_with_the_process_that_asked(hangs: bool, tmp_path: Path):
    reads = tmp_path / "reads"
    with subprocess.Popen([sys.executable, "-c", ASKING, str(reads)]) as asking:
        ends = monotonic() + WAIT
        while not (readers := below(asking.pid)):
            assert monotonic() < ends
            sleep(0.01)
        while hangs and not reads.exists():  # before it reads it may not be asked yet to end with the other
            assert monotonic() < ends
            sleep(0.01)
        for reader in readers if hangs else ():
            os.kill(reader, signal.SIGSTOP)
        asking.kill()
    wait_for_the_end(readers)


def test_refusal_of_a_taken_port_and_a_missing_file(running: Watch, home: Path):
    for arguments in (["wire", "--port", str(running.port)], ["none.yaml"], ["wire", "--port", "99999"]):
        command = [sys.executable, "-m", "metrology", "watch", *arguments]
        done = subprocess.run(command, cwd=home, capture_output=True, text=True, timeout=WAIT)
        assert (done.returncode, done.stdout) == (2, "")
        assert "expected" in done.stderr
        assert "Traceback" not in done.stderr


def test_planted_save_of_readings_that_an_extended_campaign_takes_from_another_folder_is_seen(tmp_path: Path):
    wire(tmp_path / "base")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "campaign.yaml").write_text(f"{WIRE}extends: ../base/campaign.yaml\n")
    with watching("mine", folder=tmp_path) as watch:
        watch.whole()
        told = len(watch.told)
        (tmp_path / "base" / "wire.csv").write_text(f"{READINGS}\n")
        watch.whole(told)


def test_planted_save_in_a_folder_that_a_campaign_extends_only_since_is_seen(tmp_path: Path):
    wire(tmp_path / "base")
    mine = wire(tmp_path / "mine", "mine")
    with watching("mine", folder=tmp_path) as watch:
        watch.whole()
        told = len(watch.told)
        mine.write_text(f"{mine.read_text()}extends: ../base/campaign.yaml\n")
        watch.whole(told)
        sleep(1.5)  # until the watcher looks at other folders; a save before that is seen then
        told = len(watch.told)
        (tmp_path / "base" / "wire.csv").write_text(f"{READINGS}\n")
        watch.whole(told)


def test_law_a_folder_has_a_card_for_each_campaign(tmp_path: Path):
    wire(tmp_path / "all" / "one", "one")
    broken = wire(tmp_path / "all" / "two", "two")
    broken.write_text(broken.read_text().replace("    length:", "    lenght:"))
    with watching("all", "--output", "made", folder=tmp_path) as watch:
        watch.until(lambda state: 'class="done"' in state["panel"] and 'class="refused"' in state["panel"])
        panel = watch.told[-1][1]["panel"]
        assert re.search(r"<td>k</td><td class=\"number\">[\d.]+ ± [\d.]+</td><td>N/m</td>", panel)
        assert "two/campaign.yaml:10:5" in panel
        assert "campaign/0/" in panel
        assert watch.ask("/campaign/0/report").status == 200
        assert watch.ask("/campaign/7/").status == 404
        told = len(watch.told)
        wire(tmp_path / "all" / "three", "three")
        broken.write_text(broken.read_text().replace("    lenght:", "    length:"))
        watch.until(lambda state: state["panel"].count('class="done"') == 3, told)
    assert {path.parent.name for path in (tmp_path / "made").rglob("report.pdf")} == {"one", "two", "three"}


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
def test_law_the_browser_follows_and_keeps_its_place(running: Watch, saved: Callable[[str], int]):
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        page, said = browser.new_page(viewport={"width": 1100, "height": 700}), []
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(running.url)
        report = page.frame_locator("#report")
        report.locator("#budgets").wait_for()
        page.frames[1].evaluate("scrollTo(0, 1500)")
        told = saved(WIRE.replace("0.500(2)", "0.520(2)"))
        running.whole(told)
        report.get_by_text("0.520").first.wait_for(state="attached")
        page.wait_for_function("document.querySelector('#report').contentWindow.scrollY === 1500")
        assert page.title() == "Stiffness of a steel wire"
        saved(WIRE.replace("    length:", "    lenght:"))
        page.locator(".faults").get_by_text("samples.wire.lenght").wait_for()
        assert report.locator("#budgets").count() == 1
        assert said == []
        other = browser.new_page()
        other.goto("about:blank")
        read = f"fetch('{running.url}report').then(() => 'read', () => 'refused')"
        assert other.evaluate(read) == "refused"
        browser.close()
    # The browser is gone: the next save is computed all the same.
    running.whole(saved(WIRE))
