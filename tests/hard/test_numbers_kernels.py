"""Starter campaigns give the same results.json by the arithmetic of other processors, of which readings are coarse.

Their loads are of one class and their readings whole divisions: what is equal by design differs by last digits there,
which chose another of three causes. `scripts/kernels.py` does the same with the shipped campaigns.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from metrology.cli import main
from metrology.signoff.agreement import compare

OLDER = ("Prescott", "Nehalem")
"""Kernels of OpenBLAS that every processor with 64 bits of this family has had since 2008; others take no notice."""


@pytest.mark.long
@pytest.mark.parametrize("method", ["elongation", "relaxation"])
def test_law_starter_campaigns_agree_between_processors(method: str, tmp_path: Path) -> None:
    assert main(["new", "one", "--method", method, "--folder", str(tmp_path)]) == 0
    made = []
    for kernel in (None, *OLDER):
        chosen = {} if kernel is None else {"OPENBLAS_CORETYPE": kernel}
        command = [
            sys.executable,
            "-m",
            "metrology",
            "run",
            str(tmp_path / "one"),
            "--output",
            str(tmp_path / str(kernel)),
        ]
        subprocess.run(command, env={**os.environ, **chosen}, check=True, capture_output=True)
        made.append((tmp_path / str(kernel) / "one" / "results.json").read_bytes())
    for kernel, other in zip(OLDER, made[1:], strict=True):
        assert compare(made[0], other).differences == (), kernel
