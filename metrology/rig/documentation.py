"""The table of effects in ``docs/model.md``: ``python -m metrology.rig.documentation docs/model.md`` writes it anew."""

from __future__ import annotations

import sys
from pathlib import Path

from metrology.effect import Effect
from metrology.rig.parameters import EFFECTS

HEAD = "| effect | equation | parameters: symbol, unit, null | solved |\n|---|---|---|---|\n"


def row(effect: Effect) -> str:
    """One effect as a line of the table."""
    numbers = "; ".join(f"`{one.name}` {one.symbol} / ({one.unit}), {one.null:.6g}" for one in effect.parameters)
    solved = "exactly" if effect.linear else "numerically"
    cells = (f"{effect.title} (`{effect.name}`)", effect.equation, numbers, solved)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def renewed(text: str) -> str:
    """Text of the page with the table as the effects' files have it."""
    before, _, rest = text.partition(HEAD)
    after = rest[rest.index("\n\n") :]
    return before + HEAD + "".join(map(row, EFFECTS)).rstrip("\n") + after


if __name__ == "__main__":
    page = Path(sys.argv[1])
    page.write_text(renewed(page.read_text(encoding="utf-8")), encoding="utf-8")
