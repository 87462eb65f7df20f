"""The budget as bars: the part of u² that each component carries."""

from __future__ import annotations

from metrology.findings import Result
from metrology.gum.evaluation import BudgetRow
from metrology.report.display import percent, symbol
from metrology.report.figures.style import BLUE, GREY, HALF, ORANGE, Plot, canvas, finish, place, plain

MOST = 8
"""Rows drawn; the rest is one bar, since the table has them all."""


def draw(result: Result, *, label: str = "") -> Plot:
    """Shares of u², largest first; to the left where correlation takes away."""
    rows = sorted(result.budget, key=lambda row: -abs(row.share))
    names = [f"{plain(row.input, 32)}\n{plain(row.component, 32)}" for row in rows[:MOST]]
    shares = [row.share for row in rows[:MOST]]
    if len(rows) > MOST:
        names.append(f"{len(rows) - MOST} more")
        shares.append(sum(row.share for row in rows[MOST:]))
    figure = canvas(HALF, 50.0, label=label)
    axes = place(figure, (36.0, 9.0, 10.0, 1.0))
    places = range(len(names))
    axes.barh(places, [100 * s for s in shares], height=0.62, color=[BLUE if s >= 0 else ORANGE for s in shares])
    for at, share in zip(places, shares, strict=True):
        axes.annotate(
            percent(share), (100 * max(share, 0.0), at), (2, 0), textcoords="offset points", va="center", fontsize=6
        )
    axes.set_yticks(places, names, fontsize=5.2, linespacing=1.1)
    axes.set_ylim(max(MOST - 0.4, len(names) - 0.4), -0.6)
    axes.axvline(0.0, color=GREY, lw=0.5)
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(
        min(0.0, *(110 * s for s in shares)) if shares else 0.0, max([100 * s for s in shares] + [1.0]) * 1.02
    )
    axes.set_xlabel("share of u² / %")
    return finish(
        figure, _alt(result, rows), "Share of each component in u²" + (", largest first." if len(rows) > 1 else ".")
    )


def _alt(result: Result, rows: list[BudgetRow]) -> str:
    first = "; ".join(f"{plain(row.input)} ({plain(row.component)}) {percent(row.share)}" for row in rows[:3])
    name = plain(symbol(result.quantity).replace("_n", "ₙ"))
    return f"Budget of {name}: bars of the shares in u², {len(rows)} components. The largest: {first}."
