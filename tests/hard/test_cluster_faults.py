"""A cluster whose scheduler dies, and one that is reached over TLS: one message each, no traceback."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from forging import issued

from metrology.batch import workers
from metrology.errors import MetrologyError

REFERENCE = Path(__file__).parents[1] / "reference" / "gum-h2-resistance-reactance"
# A scheduler that does not answer is given up after three seconds instead of thirty.
ALONE = os.environ | {"OPENBLAS_NUM_THREADS": "1", "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "3s"}
HERE = ("--host", "127.0.0.1", "--no-dashboard")


def started(*command: str | Path, log: Path) -> subprocess.Popen[bytes]:
    with log.open("wb") as file:
        return subprocess.Popen(
            [sys.executable, "-m", *map(str, command)], stdout=file, stderr=subprocess.STDOUT, env=ALONE
        )


def told(log: Path, pattern: str) -> str:
    """What a process says, once it does."""
    for _ in range(600):
        if found := re.search(pattern, log.read_text()):
            return found[1]
        time.sleep(0.1)
    raise AssertionError(log.read_text())


def campaigns(folder: Path, count: int) -> Path:
    for number in range(count):
        shutil.copytree(REFERENCE, folder / f"x{number}")
        path = folder / f"x{number}" / "campaign.yaml"
        path.write_text(re.sub(r"(?m)^id: .*", f"id: x{number}", path.read_text("utf-8")), encoding="utf-8")
    return folder


@pytest.mark.long
def test_refusal_scheduler_that_is_killed_on_the_way(tmp_path: Path) -> None:
    """What was made stays, what was under way is named, and the batch ends."""
    scheduler = started("dask", "scheduler", *HERE, "--port", "0", log=tmp_path / "scheduler.log")
    processes = [scheduler]
    try:
        place = told(tmp_path / "scheduler.log", r"Scheduler at:\s+(tcp://127\.0\.0\.1:\d+)")
        options = ("--nthreads", "1", "--no-nanny", "--local-directory", tmp_path)
        processes.append(started("dask", "worker", place, *HERE, *options, log=tmp_path / "worker.log"))
        folder = campaigns(tmp_path / "campaigns", 6)
        output = ("--output", tmp_path / "out", "--scheduler", place)
        batch = started("metrology", "batch", folder, *output, log=tmp_path / "batch.log")
        processes.append(batch)
        for _ in range(600):
            if list((tmp_path / "out").glob("x*/report.pdf")):
                break
            time.sleep(0.1)
        scheduler.kill()
        assert batch.wait(timeout=120) == 1
    finally:
        for process in processes:
            process.kill()
            process.wait()
    text = (tmp_path / "batch.log").read_text()
    assert "Traceback" not in text, text
    assert "its scheduler cannot be reached any more: start it again, and the batch" in text
    assert list((tmp_path / "out").glob("x*/report.pdf"))


def test_refusal_scheduler_on_another_machine_without_tls() -> None:
    with pytest.raises(MetrologyError, match="which is another machine without TLS; expected tls://"):
        workers.cluster("tcp://192.0.2.7:8786").__enter__()


def test_refusal_certificate_that_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(MetrologyError, match="no such file"):
        workers.cluster("tls://127.0.0.1:1", workers.Tls(tmp_path / "none.pem")).__enter__()


def certified(folder: Path, name: str) -> dict[str, Path]:
    """Files of an authority and of what it certifies."""
    folder.mkdir()
    root = issued(f"{name} CA")
    key, certificate = issued(name, root)
    files = {"ca": folder / "ca.pem", "cert": folder / "cert.pem", "key": folder / "key.pem"}
    files["ca"].write_bytes(root[1].public_bytes(Encoding.PEM))
    files["cert"].write_bytes(certificate.public_bytes(Encoding.PEM))
    files["key"].write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    return files


@pytest.mark.long
def test_law_tls_serves_whom_it_knows_and_refuses_others(tmp_path: Path) -> None:
    own, other = certified(tmp_path / "own", "lab"), certified(tmp_path / "other", "somebody")
    files = ("--tls-ca-file", own["ca"], "--tls-cert", own["cert"], "--tls-key", own["key"])
    server = ("--protocol", "tls", "--port", "0")
    processes = [started("dask", "scheduler", *HERE, *server, *files, log=tmp_path / "scheduler.log")]
    try:
        place = told(tmp_path / "scheduler.log", r"Scheduler at:\s+(tls://127\.0\.0\.1:\d+)")
        options = ("--nthreads", "1", "--no-nanny", "--local-directory", tmp_path)
        processes.append(started("dask", "worker", place, *HERE, *options, *files, log=tmp_path / "worker.log"))
        with workers.cluster(place, workers.Tls(own["ca"], own["cert"], own["key"])) as found:
            assert found.executor.submit(abs, -2).result(timeout=60) == 2
        stranger = workers.Tls(other["ca"], other["cert"], other["key"])
        with pytest.raises(MetrologyError, match="where no scheduler answers"):
            workers.cluster(place, stranger).__enter__()
    finally:
        for process in processes:
            process.kill()
            process.wait()
