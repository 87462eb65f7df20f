"""The checklists by the word that the campaign file and the command line have for them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from metrology.checklist import ecss, iso17025
from metrology.checklist.item import Item

CHECKLISTS: Mapping[str, tuple[Item, ...]] = MappingProxyType({"17025": iso17025.ITEMS, "ecss": ecss.ITEMS})
"""Word → items, in the order of the standard."""
TITLES: Mapping[str, str] = MappingProxyType(
    {
        "17025": "ISO/IEC 17025:2017, clause 7.8: reporting of results",
        "ecss": "ECSS-E-ST-10-02C, Annex C: test report",
    }
)
"""Word → what the checklist is of."""
