"""A campaign that is one fit, for tests of fits from the file to the findings."""

from __future__ import annotations

from pathlib import Path

from metrology import chain
from metrology.campaign.load import load
from metrology.findings import Findings

HEAD = "format: metrology-campaign/1\nid: fitted\ntitle: A fit\nfits:\n  cal:\n"


def evaluated(folder: Path, fit: str) -> Findings:
    """Findings of a campaign with the lines of its fit `cal`, each indented by four spaces."""
    (folder / "campaign.yaml").write_text(HEAD + fit, encoding="utf-8")
    return chain.evaluate(load(folder / "campaign.yaml"))
