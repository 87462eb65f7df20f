"""Pairs of values that should agree, each with its interval, around the mean of the pair."""

from __future__ import annotations

from metrology.findings import Comparison
from metrology.report.display import estimate, number
from metrology.report.figures.style import BLUE, FULL, GREY, ORANGE, Plot, canvas, finish, place, plain


def draw(comparisons: tuple[Comparison, ...], *, label: str = "") -> Plot:
    """Every comparison as one row: both values as deviation from their weighted mean in per cent, with ±2u."""
    figure = canvas(FULL, 16.0 + 11.0 * len(comparisons), label=label)
    axes = place(figure, (62.0, 9.0, 24.0, 6.0))
    for row, entry in enumerate(comparisons):
        middle = 0.5 * (entry.value_a + entry.value_b) or 1.0
        sides = (
            (entry.value_a, entry.u_a, -0.16, "o", BLUE, "first"),
            (entry.value_b, entry.u_b, 0.16, "s", ORANGE, "second"),
        )
        for value, u, shift, marker, colour, name in sides:
            axes.errorbar(
                [100 * (value / middle - 1)],
                [row + shift],
                xerr=[abs(200 * u / middle)],
                fmt=marker,
                color=colour,
                ms=3.4,
                elinewidth=1.0,
                capsize=2,
                label=name if row == 0 else None,
            )
        verdict = "" if entry.agrees is None else ("agree" if entry.agrees else "differ")
        axes.annotate(
            f"Eₙ = {number(entry.en, 2)}\n{verdict}",
            (1.0, row),
            (4, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            va="center",
            fontsize=6,
        )
    axes.axvline(0.0, color=GREY, lw=0.5)
    axes.set_ylim(len(comparisons) - 0.5, -0.5)
    axes.set_yticks(range(len(comparisons)), [f"{plain(c.a, 44)}\n{plain(c.b, 44)}" for c in comparisons], fontsize=5.5)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("deviation from the mean of the pair / %")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=2)
    return finish(figure, "Comparisons. " + " ".join(_words(entry) for entry in comparisons), _CAPTION)


def _words(entry: Comparison) -> str:
    a = estimate(entry.value_a, entry.u_a, entry.display_unit)
    b = estimate(entry.value_b, entry.u_b, entry.display_unit)
    return f"{plain(entry.title)}: {a.value} ± {a.u} against {b.value} ± {b.u} {a.unit}, E_n = {number(entry.en, 2)}."


_CAPTION = "Both values of each comparison with ±2 standard uncertainties, as deviations from the mean of the pair."
