"""A draft of a free decay: a file a release."""

from __future__ import annotations

from collections.abc import Iterator

from metrology.draft.parts import Writer, stretch, times
from metrology.draft.recognition import moved


def write(writer: Writer) -> Iterator[str]:
    """Lines of the draft."""
    seen = moved(writer.surveys[0])
    assert seen is not None
    quantity = seen.role if seen.role in ("velocity", "acceleration") else "displacement"
    turns = seen.role == "angle" or seen.unit.startswith(("rad", "deg", "°"))
    inert = "inertia" if turns else "mass"
    asked = (
        "moment of inertia that swings, such as 0.0120(1) kg*m^2" if turns else "mass that swings, such as 1.196(1) kg"
    )
    yield "instruments:"
    yield from writer.instrument("sensor", f"{quantity} sensor", stretch(quantity, seen))
    yield from writer.sample()
    yield "tests:"
    yield "  decay:"
    yield "    method: decay"
    yield "    sample: sample"
    yield from writer.conduct()
    yield f"    instruments: {{{quantity}: sensor}}"
    yield f"    {inert}: {writer.ask(inert, asked)}"
    yield "    readings:"
    for one in writer.surveys:
        found = moved(one)
        assert found is not None
        due = "angle" if found.role == "angle" else quantity
        lines = list(writer.readings(one, [*times(one, found), stretch(due, found)], indent=8))
        yield "      - " + lines[0].strip()
        yield from lines[1:]
