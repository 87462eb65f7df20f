"""Pairs of values that should agree, each with its interval, around the mean of the pair."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from metrology.findings import Comparison
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import estimate, normalised
from metrology.message import said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BLUE, FULL, GREY, ORANGE, Plot, plain

_SIDES = ((-0.16, Mark("o", BLUE, 3.6)), (0.16, Mark("s", ORANGE, 3.6)))


def draw(
    comparisons: tuple[Comparison, ...], *, label: str = "", names: Mapping[str, str] = MappingProxyType({}),
    language: Language = ENGLISH,
) -> Plot:  # fmt: skip
    """Every comparison as one row: both values as deviation from their mean in per cent, with ±2u.

    `names`: what a reader calls the sides.
    """
    plot = Sketch((FULL, 17.0 + 9.5 * len(comparisons)), (70.0, 9.5, 20.0, 6.0), label=label, language=language)
    rows = [_row(entry) for entry in comparisons]
    reach = 1.08 * max([abs(value) + half for row in rows for value, half in row] + [1e-9])
    plot.window((-reach, reach), (0.5 - len(comparisons), 0.5))
    plot.upright(0.0, Pen(stroke=GREY, width=0.5))
    for index, (entry, row) in enumerate(zip(comparisons, rows, strict=True)):
        for (value, half), (shift, mark) in zip(row, _SIDES, strict=True):
            at = -(index + shift)
            plot.interval(value - half, value + half, at, Pen(stroke=mark.colour, width=1.0))
            plot.dots((value,), (at,), mark)
        verdict = "" if entry.agrees is None else (said("agree") if entry.agrees else said("differ"))
        left, right = -1.03 * reach, 1.03 * reach
        for shift, words in (
            (0.15, plain(names.get(entry.a, entry.a), 40)),
            (-0.2, plain(names.get(entry.b, entry.b), 40)),
        ):
            plot.text(words, (left, shift - index), align=1.0)
        for shift, words in ((0.15, said("Eₙ = {size:figures}", size=normalised(entry.en))), (-0.2, verdict)):
            plot.text(words, (right, shift - index))
    plot.x_axis(said("deviation from the mean of the pair / %"), 6)
    plot.legend(((said("first"), _SIDES[0][1]), (said("second"), _SIDES[1][1])))
    rows_said = tuple(_words(entry) for entry in comparisons)
    return plot.finish(said("Comparisons. {rows:space}", rows=rows_said), said(_CAPTION))


def _row(entry: Comparison) -> list[tuple[float, float]]:
    """Both values and their 2u, in per cent of their mean."""
    middle = 0.5 * (entry.value_a + entry.value_b) or 1.0
    sides = ((entry.value_a, entry.u_a), (entry.value_b, entry.u_b))
    return [(100 * (value / middle - 1), abs(200 * u / middle)) for value, u in sides]


def _words(entry: Comparison) -> str:
    a = estimate(entry.value_a, entry.u_a, entry.display_unit)
    b = estimate(entry.value_b, entry.u_b, entry.display_unit)
    first, second = (
        said("{value:figures} ± {u:figures}", value=one.value, u=one.u)
        if one.u != "0"
        else said("{value:figures} (without uncertainty)", value=one.value)
        for one in (a, b)
    )
    return said(
        "{title}: {first} against {second} {unit}, E_n = {size:figures}.", title=plain(entry.title), first=first,
        second=second, unit=a.unit, size=normalised(entry.en),
    )  # fmt: skip


_CAPTION = "Both values of each comparison with ±2 standard uncertainties, as deviations from the mean of the pair."
