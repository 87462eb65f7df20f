from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from metrology import chain, signoff
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.report import write
from metrology.signoff.authority import ROLES

CAMPAIGN = """\
format: metrology-campaign/1
id: bridge
title: Resistance of a bridge
report:
  number: TR-7
  issued: 2026-11-20
  checklists: []
  signatures:
    author: {name: T. Tester, function: test engineer}
    reviewer: {name: Q. Officer, function: quality officer}
    approver: {name: J. Doe, function: head of laboratory}
laboratory: {name: Tether Laboratory}
monte_carlo: {digits: 1, max_trials: 10000}
ensembles:
  bridge: {readings: readings/bridge.csv, columns: {V: V / V, I: I / mA}}
derived:
  - {quantity: R, expression: V/I, unit: ohm}
"""
READINGS = "V / V,I / mA\n5.007,19.663\n4.994,19.639\n5.005,19.640\n4.990,19.685\n4.999,19.678\n"


@pytest.fixture(scope="session")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign file with one file of readings beside it, quick to evaluate."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "readings").mkdir()
    (folder / "readings" / "bridge.csv").write_text(READINGS, encoding="utf-8")
    (folder / "campaign.yaml").write_text(CAMPAIGN, encoding="utf-8")
    return folder / "campaign.yaml"


@pytest.fixture(scope="session")
def written(campaign: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its report, unsigned."""
    folder = tmp_path_factory.mktemp("report") / "bridge"
    loaded = load(campaign)
    write(chain.evaluate(loaded), folder, sources=read_sources(loaded))
    return folder / "report.pdf"


@pytest.fixture(scope="session")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys") / "authority"
    signoff.create_authority(folder)
    return folder


@pytest.fixture(scope="session")
def signer(authority: Path) -> Callable[[str], signoff.Signer]:
    """Signer of a role, by the test authority."""
    return lambda role: signoff.from_file(authority / f"{role}.p12", None, lambda: b"test")


@pytest.fixture(scope="session")
def stages(
    written: Path, signer: Callable[[str], signoff.Signer], tmp_path_factory: pytest.TempPathFactory
) -> tuple[bytes, ...]:
    """The report unsigned, and after each signature."""
    path = tmp_path_factory.mktemp("stages") / "report.pdf"
    shutil.copy(written, path)
    found = [path.read_bytes()]
    for role in ROLES:
        signoff.sign(path, role, signer(role))
        found.append(path.read_bytes())
    return tuple(found)


@pytest.fixture
def report(written: Path, tmp_path: Path) -> Path:
    """A copy of the unsigned report."""
    return Path(shutil.copy(written, tmp_path / "report.pdf"))
