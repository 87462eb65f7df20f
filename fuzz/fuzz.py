"""Coverage-guided fuzzing of one target: ``python fuzz/fuzz.py TARGET SECONDS [SEED_FOLDER]``.

Ends with an error at the first input that raises anything but a refusal, takes over 2 s or 500 MB, opens a file
elsewhere or a socket; the input is kept as `build/fuzz/TARGET/crash-…`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import atheris

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parents[1]))

WATCHED = {
    "campaign": ["metrology.campaign", "metrology.declaration", "metrology.methods", "metrology.units"],
    "quantity": ["metrology.units"],
    "expression": ["metrology.expression"],
    "readings": ["metrology.readings"],
    "packed": ["metrology.readings"],
    "formats": ["metrology.readings", "nptdms", "pyuff"],
    "results": ["metrology.jsontext"],
    "pdf": ["metrology.signoff", "pyhanko.pdf_utils"],
}
"""What guides the search; to watch everything takes a minute to start."""

with atheris.instrument_imports(include=WATCHED[sys.argv[1]]):
    from fuzz import targets

BUILD = Path(__file__).resolve().parents[1] / "build" / "fuzz" / sys.argv[1]

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
    root = Path(__file__).parents[1]
    seeds = SEEDS.get(name, [])
    if name == "campaign":
        seeds = [path.read_bytes() for path in sorted((root / "tests" / "reference").glob("*/campaign.yaml"))]
    if name == "packed":
        seeds = SEEDS["readings"]
    if name == "formats":
        seeds = _files(folder)
    if name == "pdf":
        from fuzz import reports

        seeds = reports.seeds()
    for index, content in enumerate(seeds):
        (folder / f"seed-{index}").write_bytes(content)
    return folder


def _files(folder: Path) -> list[bytes]:
    """A file of each format, of some rows."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "readings"))
    import writers

    columns = {"time / s": [0.0, 0.001, 0.002], "displacement / um": [1.0, 2.5, 2.0]}
    found = []
    for write in (
        writers.xlsx,
        writers.ods,
        writers.tdms,
        writers.uff,
        writers.parquet,
        writers.npy,
        writers.npz,
        writers.lvm,
    ):
        write(folder / "seed", columns)
        found.append((folder / "seed").read_bytes())
    (folder / "seed").unlink()
    return found


def _keeping(target: Callable[[bytes], None]) -> Callable[[bytes], None]:
    """Keep what raises at once: on a busy machine libFuzzer's own clock ends the process before it writes the input."""

    def run(data: bytes) -> None:
        try:
            target(data)
        except Exception:
            (BUILD / f"crash-{sha256(data).hexdigest()[:40]}").write_bytes(data)
            raise

    return run


def _guard(event: str, arguments: tuple[object, ...]) -> None:
    if event == "socket.connect":
        raise AssertionError(f"network: {arguments[1:]}")
    if event == "open" and isinstance(arguments[0], str) and isinstance(arguments[1], str):
        path = Path(arguments[0]).absolute()
        ours = any(path.is_relative_to(place) for place in (targets.HOME, BUILD, Path(os.devnull)))
        if "w" in arguments[1] and not ours:
            raise AssertionError(f"a file written outside: {path}")


if __name__ == "__main__":
    name, seconds, *given = sys.argv[1:]
    corpus = _seeded(name, BUILD / "corpus")
    longest = 32_768 if name == "pdf" else 4096  # two signatures are 16 kB
    limits = ["-timeout=2", "-rss_limit_mb=700", f"-max_len={longest}", f"-max_total_time={seconds}"]
    atheris.Setup(
        [sys.argv[0], *limits, f"-artifact_prefix={BUILD}/", "-print_final_stats=1", str(corpus), *given],
        _keeping(targets.TARGETS[name]),
    )
    sys.addaudithook(_guard)
    atheris.Fuzz()
