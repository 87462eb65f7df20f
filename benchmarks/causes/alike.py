"""Which names the data of a kind of test do not tell apart at a distance: from `alike.json`, which `likeness` makes."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

NOTICED = 3.0
"""Distance from which on two causes count as told apart: χ² differs by 9 between their best fits."""
EQUAL = {
    "response": (("frame", "yaw"),),
    "decay": (("quadratic drag", "line damping"),),
    "elongation": (),
}
"""Names with the same equations in such data, whatever their size."""
FILE = Path(__file__).parent / "alike.json"


@cache
def _table() -> dict[str, dict[str, dict[str, float]]]:
    return json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}


def group(method: str, specimen: str, cause: str, size: float, distance: float) -> tuple[str, ...]:
    """Names, the cause itself first, with which less than a noticed distance is left; empty where there is no other."""
    rows = _table().get(f"{method} {specimen}", {})
    shares = rows.get(f"{cause} {'+' if size >= 0 else '-'}", {})
    found = [cause, *(name for name, share in shares.items() if distance * share < NOTICED)]
    found += [
        other for pair in EQUAL[method] for name in found for other in pair if name in pair and other not in found
    ]
    return tuple(dict.fromkeys(found)) if len(set(found)) > 1 else ()


def groups(
    method: str, specimen: str, sizes: dict[str, float], distances: dict[str, float]
) -> tuple[tuple[str, ...], ...]:
    """Group of every planted cause that has one."""
    found = (group(method, specimen, cause, sizes[cause], d) for cause, d in distances.items())
    return tuple(one for one in found if one)
