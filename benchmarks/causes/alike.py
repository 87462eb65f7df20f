"""Which names the data of a kind of test do not tell apart at a distance: from a table of how alike their misfits are."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

NOTICED = 3.0
"""Distance from which on two causes count as told apart: χ² differs by 9 between their best fits."""
EQUAL = {"response": (("frame", "yaw"),), "decay": (), "elongation": ()}
"""Names with the same equations, whatever their size."""


@cache
def _table() -> dict[str, dict[str, dict[str, float]]]:
    file = Path(__file__).parent / "alike.json"
    return json.loads(file.read_text()) if file.exists() else {}


def group(method: str, specimen: str, cause: str, distance: float) -> tuple[str, ...]:
    """Names, the cause itself first, with which less than a noticed distance is left; empty where there is no other."""
    found = [cause, *(name for pair in EQUAL[method] if cause in pair for name in pair if name != cause)]
    for name, share in _table().get(f"{method} {specimen}", {}).get(cause, {}).items():
        if distance * share < NOTICED and name not in found:
            found.append(name)
    return tuple(found) if len(found) > 1 else ()
