"""Staying light: what the package, its command line and `check` load, each in an interpreter of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
CAMPAIGN = TESTS.parent / "campaigns" / "tapes" / "campaign.yaml"

HEAVY = {"dask", "distributed", "matplotlib", "numba", "pandas", "pyarrow", "pyhanko", "scipy", "weasyprint"}
"""What takes from a tenth of a second to several seconds to load, and is needed by some commands only."""

SMALLER = {"numpy", "pydantic", "yaml", "uncertainties", "jinja2"}
"""What a campaign needs, and the help does not."""

PROGRAMS = {
    "the package": ("import metrology", HEAVY | SMALLER),
    "the command line": ("import metrology.cli", HEAVY | SMALLER),
    "--version": ("from metrology.cli import main\ntry: main(['--version'])\nexcept SystemExit: pass", HEAVY | SMALLER),
    "--help": ("from metrology.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass", HEAVY | SMALLER),
    "check --help": (
        "from metrology.cli import main\ntry: main(['check', '--help'])\nexcept SystemExit: pass",
        HEAVY | SMALLER,
    ),
    "check": (f"from metrology.cli import main\nassert main(['check', {str(CAMPAIGN)!r}]) == 0", HEAVY),
    "the room of uncertainty": ("import metrology.gum", HEAVY),
    "an elongation and its diagnosis": (
        f"import sys; sys.path.insert(0, {str(TESTS)!r})\n"
        "import numpy as np, metrology\n"
        "from metrology.diagnostics.elongation import elongation\n"
        "from metrology.elongation import analyse\n"
        "from plain_cases import stretched\n"
        "test = stretched('peek', 1, {})\n"
        "assert analyse(test) and elongation(test, rng=np.random.default_rng(1)).verdict == 'nothing missing'",
        (HEAVY - {"scipy"}) | {"scipy.ndimage", "scipy.signal", "scipy.stats"},
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", PROGRAMS)
def test_law_nothing_is_loaded_that_is_not_needed(name: str) -> None:
    program, without = PROGRAMS[name]
    told = f"{program}\nimport json, sys\nprint()\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", told], check=True, capture_output=True, text=True)
    loaded = set(json.loads(done.stdout.splitlines()[-1]))
    assert "metrology" in loaded
    assert not without & loaded
