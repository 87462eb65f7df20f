"""Limits of a requirement as texts: tolerance and acceptance limits, and whether they fit their columns on page 1."""

from __future__ import annotations

from collections.abc import Sequence

from metrology.findings import Conformity, Withheld
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.columns import width
from metrology.language.display import as_stated, rounded
from metrology.report import quality
from metrology.units import unit_text

ROOM_LIMIT, ROOM_BAND = 8.0, 5.4
"""Width in em that the columns of page 1 have for a limit and for the guard band of a requirement."""


def crowded_limits(judged: Sequence[Conformity | Withheld]) -> bool:
    """Whether a limit or a guard band on page 1 is wider than its column."""
    return any(
        max(width(text.partition(" ")[0]) for text in stated_limits(entry)) > ROOM_LIMIT
        or (isinstance(entry, Conformity) and width(quality.band(entry)) > ROOM_BAND)
        for entry in judged
    )


def limits(entry: Conformity | Withheld, language: Language = ENGLISH) -> str:
    """Limits of a requirement."""
    low, high = (language.figures(text) for text in stated_limits(entry))
    if entry.lower is not None and entry.upper is not None:
        return language.say("{low} to {high}", low=low, high=high)
    return f"≥ {low}" if entry.upper is None else f"≤ {high}"


def stated_limits(entry: Conformity | Withheld) -> tuple[str, str]:
    """Tolerance limits as they are stated, in their units; a dash for one that is not there."""
    unit, given = entry.display_unit, ((entry.lower, entry.lower_stated), (entry.upper, entry.upper_stated))
    low, high = ("–" if limit is None else as_stated(limit, text, unit) for limit, text in given)
    return low, high


def _accepted(entry: Conformity, limit: float | None, stated: str) -> str:
    from metrology.units import convert, factor

    if limit is None or not entry.guard_band:
        return "–" if limit is None else stated
    unit = entry.display_unit
    text = rounded(convert(limit, unit), abs(entry.guard_band) / factor(unit))[0]
    return f"{text} {unit_text(unit)}".rstrip()


def acceptance(entry: Conformity, language: Language = ENGLISH) -> str:
    """Acceptance limits of a requirement, to the digits of their guard band; a dash where there are none."""
    limits = (entry.acceptance_lower, entry.acceptance_upper)
    ends = [_accepted(entry, limit, text) for limit, text in zip(limits, stated_limits(entry), strict=True)]
    low, high = map(language.figures, ends)
    if "–" in ends:
        return high if low == "–" else low
    return language.say("{low} to {high}", low=low, high=high)
