"""Shipped campaigns for tests of their results alone: a diagnosis would take most of the time."""

from __future__ import annotations

from pathlib import Path

from metrology.campaign.diagnosis import Diagnose
from metrology.campaign.load import load
from metrology.campaign.schema import Campaign


def undiagnosed(path: Path) -> Campaign:
    """The campaign as if its file said ``diagnosis: {off: true}``."""
    return load(path).model_copy(update={"diagnosis": Diagnose.model_validate({"off": "true"})})
