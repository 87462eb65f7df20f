"""The guard of fuzzing: what is hidden in a reader is a find, in this process and in a fork; good files are read."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import writers

ROOT = Path(__file__).parents[2]
COLUMNS = {"time / s": [i / 1000 for i in range(50)], "displacement / um": [float(i % 7) for i in range(50)]}
TASK = """
import sys
from pathlib import Path
from fuzz import targets
from fuzz.guard import Find, guard
from metrology.declaration.columns import Column

name, file, hidden = sys.argv[1:]
sys.addaudithook(guard(targets.HOME))
exec(hidden)
try:
    targets.TARGETS[name](Path(file).read_bytes())
    print("missed" if hidden else "read", len(targets.read(Path(file), targets.DECAY)), targets.HOME)
except Find as find:
    print("found", str(find).strip().splitlines()[-1])
"""
SPOILED = "import metrology.readings.{0} as one; old = one.of_columns; one.of_columns = lambda *a, **k: {1}"
WRITES = SPOILED.replace("{1}", "(open('/tmp/metrology-elsewhere', 'w'), old(*a, **k))[1]")
"""A reader whose last step writes a file, or fails by a fault of ours."""
OURS = (
    "import metrology.readings.tables as one; one.check_size = lambda *a: None; one.MAX_COLUMNS = None; del one.Heading"
)


def told(name: str, path: Path, hidden: str = "") -> str:
    command = [sys.executable, "-c", TASK, name, str(path), hidden]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=100)
    return done.stdout.strip()


@pytest.mark.long
@pytest.mark.parametrize(("name", "module"), [("uff58", "uff"), ("tdms", "tdms"), ("hdf5", "hdf5")])
def test_planted_faults_of_a_reader_are_found(name: str, module: str, tmp_path: Path) -> None:
    writers.BY_FORMAT[name][0](tmp_path / "a", COLUMNS)
    word, count, home = told(name, tmp_path / "a").split()
    assert (word, count) == ("read", "50")
    assert not Path(home).exists()
    assert told(name, tmp_path / "a", WRITES.replace("{0}", module)) == (
        "found a file written outside: /tmp/metrology-elsewhere"
    )
    assert told(name, tmp_path / "a", OURS) == "found NameError: name 'Heading' is not defined"
    assert not Path("/tmp/metrology-elsewhere").exists()
