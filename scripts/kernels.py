"""Run tests and campaigns under every arithmetic that this processor offers, each in a fresh process.

OpenBLAS chooses its kernel, and NumPy its loops, by the processor: last digits differ. A program that needs one of them
works on one machine and fails on the next.

python scripts/kernels.py list
    name what can be run here
python scripts/kernels.py test [--others [N]] [-- ARGUMENTS OF PYTEST]
    run the numerical tests under each, or under those (at most N) that are not this machine's own
python scripts/kernels.py campaigns [FOLDER…]
    evaluate the shipped campaigns under each; their results have to agree
python scripts/kernels.py verify [FOLDER…]
    make reports under the first, and verify them under each: results, numbers and pages have to be good

Exit status: 0 all passed, 1 one did not.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).parents[1]
KERNELS = ("Prescott", "Haswell", "SkylakeX", "Nehalem", "Sandybridge")
"""What OPENBLAS_CORETYPE can name: from SSE3 to AVX-512, the ones least alike first."""
NUMERICAL = (
    "tests/gum", "tests/reference", "tests/estimation", "tests/rig", "tests/verify", "tests/diagnostics",
    "tests/hard/test_numbers_light.py", "tests/hard/test_numbers_scales.py", "tests/hard/test_numbers_search.py",
    "tests/hard/test_numbers_strd.py", "tests/test_chain.py", "tests/test_decay.py", "tests/test_decay_evidence.py",
    "tests/test_decay_parts.py", "tests/test_decay_results.py", "tests/test_decay_separation.py",
    "tests/test_elongation.py", "tests/test_elongation_evidence.py", "tests/test_independence.py",
    "tests/test_relaxation.py", "tests/test_response_door.py", "tests/test_rotary_door.py", "tests/test_tapes.py",
    "tests/test_tension.py", "tests/test_timeseries.py",
)  # fmt: skip

MADE_AGAIN = ("results", "numbers", "pages")
"""What `verify` makes again from the attachments of a report."""


@dataclass(frozen=True)
class Arithmetic:
    """One way to compute: a name, the settings of a process that bring it, and what OpenBLAS then calls its core."""

    name: str
    settings: dict[str, str] = field(hash=False)
    core: str

    def run(self, command: Sequence[str], **options: object) -> subprocess.CompletedProcess:
        """Run a command of this environment's Python in a process of its own."""
        # One thread: pytest gives every core a process of its own, and threads that wait would only spin.
        environment = {**_bare(), "OPENBLAS_NUM_THREADS": "1", **self.settings}
        return subprocess.run([sys.executable, *command], check=False, cwd=HERE, env=environment, **options)  # noqa: S603


def _bare() -> dict[str, str]:
    """Environment without settings that choose an arithmetic."""
    chosen = re.compile(r"OPENBLAS_(CORETYPE|L2_SIZE|VERBOSE)|NPY_.*")
    return {name: value for name, value in os.environ.items() if not chosen.fullmatch(name)}


def _core(settings: dict[str, str]) -> str:
    """Core that OpenBLAS takes with these settings; empty where it has none such, or cannot run it here."""
    probe = "import numpy as np; a = np.ones((40, 40)); assert (a @ a == 40).all()"
    environment = {**_bare(), **settings, "OPENBLAS_VERBOSE": "2"}
    found = subprocess.run(  # noqa: S603
        [sys.executable, "-c", probe], check=False, env=environment, capture_output=True, text=True
    )
    names = re.findall(r"Core: (\w+)", found.stdout + found.stderr)
    return "" if found.returncode or "Core not found" in found.stdout + found.stderr or not names else names[-1]


def _dispatched() -> str:
    """Features beyond NumPy's baseline that it uses on this processor, as NPY_DISABLE_CPU_FEATURES takes them."""
    from numpy import show_config

    features = show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    return " ".join(features)


def arithmetics() -> list[Arithmetic]:
    """Return what this processor can run: its own choice first, then the others, each core once."""
    found = [Arithmetic("the processor's own", {}, _core({}))]
    for name in KERNELS:
        core = _core({"OPENBLAS_CORETYPE": name})
        if core and core not in [one.core for one in found]:
            found.append(Arithmetic(name, {"OPENBLAS_CORETYPE": name}, core))
        elif core:
            _say(f"{name} is computed as {core} by this OpenBLAS")
    if features := _dispatched():
        found.append(
            Arithmetic("NumPy's baseline", {"NPY_DISABLE_CPU_FEATURES": features}, f"{found[0].core}, {features} off")
        )
    return found


def _say(text: str) -> None:
    print(text, flush=True)


def test(others: int | None, arguments: Sequence[str]) -> bool:
    """Run the numerical tests under each arithmetic; True where all pass."""
    every = arithmetics()
    chosen = every if others is None else every[1 : 1 + others]
    passed = True
    for one in chosen:
        _say(f"== numerical tests, {one.name} ({one.core})")
        outcome = one.run(
            [
                "-W",
                "error::SyntaxWarning",
                "-m",
                "pytest",
                "-n",
                "auto",
                "--dist",
                "loadgroup",
                "-q",
                "-m",
                "not study",
                *arguments,
                *NUMERICAL,
            ]
        )
        passed &= outcome.returncode == 0
    return passed


def campaigns(folders: Sequence[str]) -> bool:
    """Evaluate campaigns under each arithmetic and compare with the first; True where all agree."""
    every, passed = arithmetics(), True
    with TemporaryDirectory(prefix="metrology-") as home, ThreadPoolExecutor(os.cpu_count()) as pool:
        outs = [Path(home) / one.core.replace(" ", "-") for one in every]

        def evaluated(one: Arithmetic, out: Path) -> int:
            command = ["-m", "metrology", "run", *folders, "--output", str(out)]
            return one.run(command, stdout=subprocess.DEVNULL).returncode

        for one, out, status in zip(every, outs, pool.map(evaluated, every, outs), strict=True):
            _say(f"== campaigns, {one.name} ({one.core})")
            # A campaign may fail a requirement of its own (1), but not be refused (2).
            passed &= status in (0, 1)
            for sentence in _compared(out, outs[0]) if one is not every[0] else ():
                _say(sentence)
                passed &= not sentence.startswith("differs")
    return passed


def verify(folders: Sequence[str]) -> bool:
    """Verify reports, made under the first arithmetic, under each; True where what the inputs give is good in all."""
    every, passed = arithmetics(), True
    with TemporaryDirectory(prefix="metrology-") as home, ThreadPoolExecutor(os.cpu_count()) as pool:
        every[0].run(["-m", "metrology", "report", *folders, "--output", home], stdout=subprocess.DEVNULL)
        reports = sorted(Path(home).glob("*/report.pdf"))
        passed &= len(reports) == len(folders)

        def verified(one: Arithmetic) -> list[dict]:
            commands = (["-m", "metrology", "verify", str(path), "--json"] for path in reports)
            return [json.loads(one.run(command, capture_output=True, text=True).stdout) for command in commands]

        for one, found in zip(every, pool.map(verified, every), strict=True):
            _say(f"== verify, {one.name} ({one.core})")
            for path, report in zip(reports, found, strict=True):
                checks = {check["subject"]: check for check in report["checks"]}
                for subject in MADE_AGAIN:
                    passed &= checks[subject]["state"] == "good"
                    _say(f"{checks[subject]['state']}: {path.parent.name}: {checks[subject]['sentence']}")
    return passed


def _compared(made: Path, first: Path) -> Iterator[str]:
    from metrology.signoff.agreement import compare

    for path in sorted(first.glob("*/results.json")):
        other = made / path.relative_to(first)
        found = compare(path.read_bytes(), other.read_bytes() if other.is_file() else b"{}")
        yield f"{'agrees' if found.agrees else 'differs'}: {path.parent.name}: {found.sentence}"


def main() -> int:
    """Parse the command line and do it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("list", "test", "campaigns", "verify"))
    parser.add_argument(
        "--others", type=int, nargs="?", const=len(KERNELS) + 1, help="at most N but this machine's own"
    )
    parser.add_argument("rest", nargs="*")
    stated, arguments = parser.parse_known_args()
    if stated.what != "test" and arguments:
        parser.error(f"unrecognized arguments: {' '.join(arguments)}")
    if stated.what == "list":
        for one in arithmetics():
            _say(f"{one.name}: {one.core}")
        return 0
    shipped = sorted(str(path.parent) for path in (HERE / "campaigns").glob("*/campaign.yaml"))
    match stated.what:
        case "test":
            passed = test(stated.others, [*stated.rest, *(one for one in arguments if one != "--")])
        case "campaigns":
            passed = campaigns(stated.rest or shipped)
        case _:
            passed = verify(stated.rest or shipped)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
