"""A draft of a straight line through force and extension."""

from __future__ import annotations

from collections.abc import Iterator

from metrology.draft.recognition import STRETCHES, pull
from metrology.draft.writer import Bound, Writer, quote


def write(writer: Writer) -> Iterator[str]:
    """Lines of the draft."""
    one = writer.surveys[0]
    force, moved = pull(one), one.first(*STRETCHES)
    assert force is not None
    assert moved is not None
    yield "# The slope of force against extension; 'rows: [first, last]' below 'readings' leaves the rest out."
    yield "fits:"
    yield "  force-extension:"
    yield "    readings:"
    names = [f"{column.name} / {column.unit}" if column.unit else column.name for column in (moved, force)]
    columns = [Bound(name, column) for name, column in zip(names, (moved, force), strict=True)]
    yield from writer.readings(one, columns, indent=6)
    yield f"    x: {quote(names[0])}"
    yield f"    y: {quote(names[1])}"
    yield ""
    yield "derived:"
    yield "  - quantity: k"
    yield "    description: slope of force against extension"
    yield "    expression: slope"
    yield "    where: {slope: force-extension.slope}"
    yield f"    unit: {force.unit or '1'}/{moved.unit or '1'}"
