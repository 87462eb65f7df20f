"""The wheel stands alone: installed outside the checkout, it makes the report of the README."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

import metrology

ROOT = Path(__file__).parents[1]


def run(*command: str | Path, folder: Path) -> str:
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [*map(str, command)], cwd=folder, env=clean, capture_output=True, text=True, timeout=180, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def installed(folder: Path) -> Path:
    """A fresh environment with the wheel: what it depends on is that of this one, but not the package itself."""
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, folder=ROOT)
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "env", with_pip=False, symlinks=True)
    home = Path(sysconfig.get_path("purelib", vars={"base": str(folder / "env")}))
    run(sys.executable, "-m", "zipfile", "-e", wheel, home, folder=folder)
    # Of the packages here, all but what makes the checkout importable: its .pth files are not followed from there.
    (home / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return folder / "env" / "bin" / "python"


@pytest.mark.long
def test_reference_the_wheel_makes_the_report_of_the_readme_outside_the_checkout(tmp_path: Path) -> None:
    python = installed(tmp_path)
    where = run(python, "-c", "import metrology; print(metrology.__file__, metrology.__version__)", folder=tmp_path)
    assert where.split() == [str(python.parents[1] / where.split("/env/")[1].split()[0]), metrology.__version__]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (tmp_path / "wire").mkdir()
    for kind, name in (("yaml", "campaign.yaml"), ("csv", "wire.csv")):
        (text,) = re.findall(rf"```{kind}\n(.*?)```", readme, re.DOTALL)
        (tmp_path / "wire" / name).write_text(text, encoding="utf-8")
    shown = run(python, "-m", "metrology", "report", "wire", folder=tmp_path)
    assert "20010 │ 140 │ N/m" in shown
    assert (tmp_path / "reports" / "wire" / "report.pdf").read_bytes().startswith(b"%PDF-1.7")
    assert "metrology" in run(python, "-m", "metrology", "doctor", folder=tmp_path)
