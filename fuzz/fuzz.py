"""Coverage-guided fuzzing of one target: ``python fuzz/fuzz.py TARGET SECONDS [SEED_FOLDER]``.

Ends with an error at the first input that raises anything but a refusal, takes over 2 s (10 s in a fork, 30 s an
evaluation) or 700 MB (2 GB an evaluation), opens a file elsewhere or a socket; the input is kept as
`build/fuzz/TARGET/crash-…`.
"""

from __future__ import annotations

import gzip
import os
import sys
from collections.abc import Callable
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from shutil import rmtree
from zipfile import ZipFile

import atheris

os.environ["OPENBLAS_NUM_THREADS"] = "1"
ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), *(str(ROOT / "tests" / name) for name in ("", "readings", "draft", "campaign", "safety"))]

METHODS = ("elongation", "decay", "response", "tension", "relaxation")
WATCHED = {
    "campaign": ["metrology.campaign", "metrology.declaration", "metrology.methods", "metrology.units"],
    "quantity": ["metrology.units"],
    "expression": ["metrology.expression"],
    "readings": ["metrology.readings"],
    "packed": ["metrology.readings"],
    "certificate": ["metrology.campaign.calibration", "metrology.units"],
    "unknown": ["metrology.draft", "metrology.readings"],
    "tdms": ["metrology.readings", "nptdms"],
    "uff58": ["metrology.readings", "pyuff"],
    "results": ["metrology.jsontext"],
    "pdf": ["metrology.signoff", "pyhanko.pdf_utils"],
    # Without the rig, whose code is compiled.
    "evaluation": [f"metrology.{name}" for name in ("chain", *METHODS, "gum", "raw")],
}
"""What guides the search; to watch everything takes a minute to start."""

BUILD = ROOT.resolve() / "build" / "fuzz" / sys.argv[1]
# Emptied at the start: libFuzzer ends the process without a word to Python.
rmtree(BUILD / "temporary", ignore_errors=True)
(BUILD / "temporary").mkdir(parents=True)
os.environ["TMPDIR"] = str(BUILD / "temporary")

with atheris.instrument_imports(include=WATCHED.get(sys.argv[1], ["metrology.readings"])):
    from fuzz import targets
    from fuzz.guard import Find, guard

SEEDS: dict[str, list[bytes]] = {
    "quantity": [b"25.00(5) mm", "1.2 ± 0.1 kN/m^2".encode(), b"(1.0 +/- 0.2)e-3 1/K"],
    "expression": [b"k * L / A", b"sqrt(p) + max(1, 2**p) - atan2(L, L)"],
    "readings": [
        b"load,repeat,direction,reading / mm\nA,1,loading,0.49\n",
        b"# n\ntime / s,displacement / m\n0,1\n1,2\n",
    ],
    "results": [b'{"schema": "metrology-results/1", "campaign": {}, "results": [{"value": 1.0}]}'],
}


def _seeded(name: str, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    seeds = SEEDS.get(name, [])
    if name == "campaign":
        seeds = [path.read_bytes() for path in sorted((ROOT / "tests" / "reference").glob("*/campaign.yaml"))]
    if name == "packed":
        seeds = [*SEEDS["readings"], *(gzip.compress(content) for content in SEEDS["readings"])]
    if name == "certificate":
        from certificates import WHOLE, listed

        seeds = [WHOLE.encode(), listed("3.2.1").encode(), listed("3.3.0").encode()]
    if name == "unknown":
        seeds = _exports(folder)
    if name in targets.FORMATS:
        targets.warm(name)
        seeds = _files(folder, name)
    if name == "evaluation":
        targets.warm(name)
        from mutation import CAMPAIGNS

        # By the campaign, one change, and its kind; what Hypothesis makes of the bytes is its own matter.
        seeds = [bytes((base, 1, kind, *range(1, 9))) for base in range(len(CAMPAIGNS)) for kind in range(6)]
    if name == "pdf":
        from fuzz import reports

        seeds = reports.seeds()
    for index, content in enumerate(seeds):
        (folder / f"seed-{index}").write_bytes(content)
    return folder


def _written(folder: Path, write: Callable[..., None], *more: object) -> bytes:
    write(folder / "seed", *more)
    content = (folder / "seed").read_bytes()
    (folder / "seed").unlink()
    return content


def _files(folder: Path, name: str) -> list[bytes]:
    """Files of a format, of some rows; of an archive also the part that holds the readings."""
    import writers

    columns = {"time / s": [0.0, 0.001, 0.002], "displacement / um": [1.0, 2.5, 2.0]}
    found = [_written(folder, write, columns) for write in writers.BY_FORMAT[name]]
    for content in found:
        if content.startswith(b"PK"):
            part = PARTS[name]
            targets.WITHIN[name] = (content, part)
            with ZipFile(BytesIO(content)) as archive:
                return [*found, archive.read(part)]
    return found


PARTS = {"xlsx": "xl/worksheets/sheet1.xml", "ods": "content.xml", "numpy": "time.npy"}


def _exports(folder: Path) -> list[bytes]:
    import exports

    return [b"\n".join(_written(folder, write).split(b"\n")[:25]) for write in exports.TEXTS]


def _keeping(target: Callable[[bytes], None]) -> Callable[[bytes], None]:
    """Keep what raises at once: on a busy machine libFuzzer's own clock ends the process before it writes the input."""

    def run(data: bytes) -> None:
        try:
            target(data)
        except (Exception, Find):
            (BUILD / f"crash-{sha256(data).hexdigest()[:40]}").write_bytes(data)
            raise

    return run


if __name__ == "__main__":
    name, seconds, *given = sys.argv[1:]
    corpus = _seeded(name, BUILD / "corpus")
    longest = max(4096, 2 * max(path.stat().st_size for path in corpus.iterdir()))
    seconds_each = 10 if name in targets.LIBRARIES else 2
    limits = [f"-timeout={seconds_each}", "-rss_limit_mb=700", f"-max_len={longest}", f"-max_total_time={seconds}"]
    if name == "evaluation":
        # On the clock; `mutation.PATIENCE` is its CPU time. A change is a few bytes: no need to grow slowly.
        limits += ["-timeout=120", "-rss_limit_mb=2000", "-max_len=100", "-len_control=0"]
    atheris.Setup(
        [sys.argv[0], *limits, f"-artifact_prefix={BUILD}/", "-print_final_stats=1", str(corpus), *given],
        _keeping(targets.TARGETS[name]),
    )
    sys.addaudithook(guard(targets.HOME, BUILD))
    atheris.Fuzz()
