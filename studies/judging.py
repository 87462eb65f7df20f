"""From judged campaigns to the bars that diagnosis has to meet, a table, and two pictures."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from planting import EVERY

from metrology import __version__
from metrology.diagnostics.candidate import RESPONSE as TABLE

Row = dict[str, Any]
SMALL, MEDIUM = 5.0, 9.0
REACHED = 0.7
"""Part of its distance that an effect has to reach to be counted."""
MISSED = 6.0
"""Distance that a listed cause has to leave of another, to be told from it."""
KINDS = {
    "nothing": "with nothing planted", "one": "with one effect", "two": "with two",
    "unlisted": "with one that is in nobody's table",
}  # fmt: skip


@dataclass(frozen=True)
class Bar:
    """A share of campaigns that has to reach `at_least` (a fraction)."""

    name: str
    right: int
    of: int
    at_least: float
    at_most: float = 1.0

    @property
    def met(self) -> bool:
        """Whether the share itself lies where it has to."""
        return self.of == 0 or self.at_least <= self.right / self.of <= self.at_most

    @property
    def possible(self) -> bool:
        """Whether a true share as required would give a count like this in more than one study of a hundred."""
        from scipy.stats import binom

        low = binom.cdf(self.right, self.of, self.at_least)
        return self.of == 0 or bool(low > 0.01)


def first(row: Row) -> bool:
    """Whether the planted effect, or the group with it, is named first."""
    possible, planted = row["possible"], row["planted"][0]
    return bool(possible) and (
        possible[0] == planted or any(planted in group and possible[0] in group for group in row["groups"])
    )


def _bar(name: str, at_least: float, rows: Sequence[Any], right: Callable[[Any], Any], at_most: float = 1.0) -> Bar:
    return Bar(name, sum(bool(right(row)) for row in rows), len(rows), at_least, at_most)


def causes(row: Row) -> int:
    """Number of causes or groups reported as possible: a group counts each of its members."""
    return len(row["possible"])


def inside(interval: Sequence[Any]) -> bool:
    """Whether a 95 % interval (name, truth, value, low, high) holds the truth."""
    _, truth, _, low, high = interval
    return (low is None or low <= truth) and (high is None or truth <= high)


def reached(row: Row) -> bool:
    """Whether the planted sizes move the data about as far as they should: some cannot, as a toe without stiffness."""
    return all(one > REACHED * row["d"] for one in row["reached"])


def bars(rows: Sequence[Row]) -> list[Bar]:
    """All bars that are shares."""
    rows = [row for row in rows if reached(row)]
    by = {kind: [row for row in rows if row["kind"] == kind] for kind in ("nothing", "one", "two", "unlisted")}
    one = by["one"]
    # Two effects may take each other back: what then is left shows no more than one of them.
    two = [row for row in by["two"] if row.get("together", row["d"]) >= row["d"]]
    small, medium = ([row for row in one if row["d"] == d] for d in (SMALL, MEDIUM))
    large = [row for row in one if row["d"] > MEDIUM]
    right = [row for row in one if row["named"] == row["planted"]]
    apart = [row for row in by["unlisted"] if row["left"] > MISSED]
    single = [part for row in right if len(row["intervals"]) == 1 for part in row["intervals"]]
    several = [part for row in right if len(row["intervals"]) > 1 for part in row["intervals"]]
    base = [shift for row in right for shift in row["shifts"]]
    sure = [name in row["planted"] for row in rows for name, p in row["probability"] if p > 0.9]
    return [
        _bar("nothing planted: nothing missing", 0.98, by["nothing"], lambda row: row["verdict"] == "nothing missing"),
        _bar("one effect, d = 9: named first, or its group", 0.95, medium, first),
        _bar("one effect, d = 40: named first, or its group", 0.97, large, first),
        _bar("d ≥ 6: among those possible", 0.97, medium + large, lambda row: row["planted"][0] in row["possible"]),
        _bar("d = 5: named or missed, not misnamed", 0.95, small, lambda row: not row["possible"] or first(row)),
        _bar("two effects, d = 15 each: both named", 0.85, two, lambda row: set(row["planted"]) <= _all(row)),
        _bar("two effects: exactly these", 0.75, two, _exactly),
        _bar("two effects: at least one", 0.98, two, lambda row: set(row["planted"]) & _all(row)),
        _bar("in nobody's table: unexplained", 0.90, by["unlisted"], _unexplained),
        _bar(
            f"of these, where none of the four likeliest causes takes up all but {MISSED:g} σ",
            0.90,
            apart,
            _unexplained,
        ),
        _bar("in nobody's table: no name with p > 0.5", 0.90, by["unlisted"], lambda row: not _sure(row)),
        _bar("95 % intervals, effects of one parameter", 0.92, single, inside, 0.98),
        _bar("95 % intervals, effects of several parameters", 0.92, several, inside, 0.98),
        _bar("95 % intervals of k, c after extension", 0.92, base, _kept, 0.98),
        _bar("causes given more than 90 %: right", 0.90, sure, bool),
    ]


def _exactly(row: Row) -> bool:
    """Whether each planted effect, and nothing else, is named or in a group of causes that stand for one."""
    places = [{name} for name in row["named"]] + [set(group) for group in row["groups"]]
    one, other = row["planted"]
    return len(places) == 2 and any(one in places[at] and other in places[1 - at] for at in (0, 1))


def _unexplained(row: Row) -> bool:
    return bool(row["verdict"] == "unexplained")


def _all(row: Row) -> set[str]:
    return set(row["possible"])


def _sure(row: Row) -> bool:
    return bool(row["named"]) or any(p > 0.5 for _, p in row["probability"])


def _kept(shift: Sequence[Any]) -> bool:
    _, truth, _, _, after, u = shift
    return abs(after - truth) < 1.96 * u


def figures(rows: Sequence[Row]) -> list[tuple[str, str, str]]:
    """Bars that are no shares: name, what is required, what was found."""
    one = [row for row in rows if row["kind"] == "one"]
    big = [row for row in one if row["d"] >= 6]
    right = [row for row in one if row["named"] == row["planted"]]
    held = [part for row in right for part in row["held"]] or [0.0]
    biased = [shift for row in right if row["d"] > MEDIUM for shift in row["shifts"] if _biased(shift)]
    bias = [abs(after - truth) / abs(before - truth) for _, truth, before, _, after, _ in biased] or [0.0]
    seconds = {kind: [row["seconds"] for row in rows if row["kind"] == kind] or [0.0] for kind in ("nothing", "one")}
    return [
        ("d ≥ 6: possible, on average", "≤ 1.5", f"{np.mean([causes(row) for row in big] or [0]):.2f}"),
        ("held-out RMS over noise: median, 95 %", "≤ 1.05", f"{np.median(held):.3f}, {np.quantile(held, 0.95):.3f}"),
        (f"bias of k, c after over before, median of {len(biased)}", "≤ 0.1", f"{np.median(bias):.3f}"),
        ("CPU of a campaign with nothing: median, largest / s", "", _two(seconds["nothing"])),
        ("CPU of a campaign with an effect: median, largest / s", "", _two(seconds["one"])),
    ]


def _biased(shift: Sequence[Any]) -> bool:
    """Whether leaving the effect out moved the parameter visibly: by more than five of its standard uncertainties."""
    _, truth, before, u, _, u_after = shift
    return abs(before - truth) > 5 * max(u, u_after)


def _two(values: Sequence[float]) -> str:
    return f"{np.median(values):.1f}, {max(values):.1f}"


def document(rows: Sequence[Row]) -> str:
    """Return the study as Markdown."""
    kinds = Counter(row["kind"] for row in rows)
    counted = ", ".join(f"{kinds[kind]} {words}" for kind, words in KINDS.items())
    made = f"Version {__version__}, {datetime.now(UTC):%Y-%m-%d}, {len(rows)} campaigns of 4 runs: {counted}."
    spent = sum(row["seconds"] for row in rows) / 60
    lines = [
        "# What diagnosis names", "",
        made, "",
        "Effects are planted by `tests/truth_full.py`, which shares no code with the package, at a",
        "distance of d standard deviations with all known inputs marginalised (`studies/planting.py`), for all four",
        "materials.",
        f"CPU time of the diagnoses: {spent:.0f} min. Repeat: `python studies/diagnosis.py`.", "",
        "| bar | at least | found | |", "|---|---|---|---|",
    ]  # fmt: skip
    for bar in bars(rows):
        share = f"{bar.right} of {bar.of} ({100 * bar.right / max(bar.of, 1):.0f} %)"
        wanted = f"{100 * bar.at_least:.0f} %" + (f" to {100 * bar.at_most:.0f} %" if bar.at_most < 1 else "")
        lines.append(
            f"| {bar.name} | {wanted} | {share} | {'not tried' if not bar.of else 'met' if bar.met else 'missed'} |"
        )
    lines += [f"| {name} | {wanted} | {found} | |" for name, wanted, found in figures(rows)]
    lines += ["", "![Share found against size](diagnosis-power.svg) ![Calibration](diagnosis-calibration.svg)", ""]
    return "\n".join([*lines, *_missed(rows), *_confusion(rows), *_claims(rows)]) + "\n"


def _missed(rows: Sequence[Row]) -> list[str]:
    """Every campaign that was judged wrong, with what repeats it."""
    wrong = [row for row in rows if reached(row) and not _right(row)]
    lines = [f"## Judged wrong: {len(wrong)} of {len(rows)}", ""]
    lines += ["| planted | d | material | known inputs | seed | verdict | possible |", "|---|---|---|---|---|---|---|"]
    for row in sorted(wrong, key=_order):
        _, material, plan, _, d, seed = row["task"]
        told = ", ".join(row["possible"]) or "none"
        planted = " + ".join(row["planted"]) or "nothing"
        lines.append(f"| {planted} | {d:g} | {material} | {plan} | {seed} | {row['verdict']} | {told} |")
    return [*lines, ""]


def _right(row: Row) -> bool:
    if row["kind"] == "nothing":
        return bool(row["verdict"] == "nothing missing")
    if row["kind"] == "unlisted":
        return bool(row["verdict"] == "unexplained")
    if row["kind"] == "two":
        return set(row["planted"]) <= _all(row)
    return first(row) or (row["d"] <= SMALL and not row["possible"])


def _confusion(rows: Sequence[Row]) -> list[str]:
    lines = ["## Verdicts by what was planted", "", "| planted | d | reported as possible |", "|---|---|---|"]
    for key in dict.fromkeys((tuple(row["planted"]), row["d"]) for row in sorted(rows, key=_order)):
        own = [row for row in rows if (tuple(row["planted"]), row["d"]) == key]
        count = Counter(", ".join(row["possible"]) or row["verdict"] for row in own)
        words = "; ".join(f"{name}: {number}" for name, number in count.most_common())
        lines.append(f"| {' + '.join(key[0]) or 'nothing'} | {key[1]:g} | {words} |")
    return lines


def _order(row: Row) -> tuple[str, str, float]:
    return row["kind"], "+".join(row["planted"]), row["d"]


def _claims(rows: Sequence[Row]) -> list[str]:
    """Smallest sizes that were told beforehand (5 σ): how often effects beside them were found."""
    told = [row for row in rows if row["kind"] == "one" and row["smallest"] and row["smallest"][0]]
    lines = ["", "## Smallest sizes told before the test", "", "| size over the one told | found |", "|---|---|"]
    for low, high in ((0.0, 0.7), (0.7, 1.0), (1.0, 1.5), (1.5, 3.0), (3.0, 1e9)):
        own = [row for row in told if low <= claim(row) < high]
        found = sum(row["planted"][0] in row["possible"] for row in own)
        lines.append(f"| {low:g} to {high:g} | {found} of {len(own)} |")
    return lines


def claim(row: Row) -> float:
    """Planted size over the smallest one that the diagnosis says would show in nine of ten such campaigns."""
    name = row["planted"][0]
    size = TABLE[name].size
    value = EVERY[name].values.get(size.name)
    return math.nan if value is None else abs(value(row["fields"]) - size.null) / row["smallest"][0]


def pictures(rows: Sequence[Row], folder: Path) -> None:
    """Power against size, and how often what is given a probability is right."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "diagnosis"
    from matplotlib import pyplot as plt

    one = [row for row in rows if row["kind"] == "one"]
    figure, axes = plt.subplots(figsize=(4.2, 3.0))
    sizes = sorted({row["d"] for row in one})
    for label, right in (("in the report", _reported), ("named first, or its group", first)):
        shares = [np.mean([right(row) for row in one if row["d"] == d]) for d in sizes]
        axes.plot(sizes, shares, "o-", label=label)
    axes.set(xscale="log", xlabel="distance d / σ", ylabel="share of campaigns", ylim=(0, 1.02))
    axes.legend(loc="lower right")
    _save(figure, folder / "diagnosis-power.svg")
    figure, axes = plt.subplots(figsize=(3.2, 3.0))
    given = np.array([p for row in rows for _, p in row["probability"]])
    right = np.array([name in row["planted"] for row in rows for name, _ in row["probability"]])
    for low in np.arange(0.0, 1.0, 0.2):
        own = (given >= low) & (given < low + 0.2)
        if own.sum() > 4:
            axes.errorbar(given[own].mean(), right[own].mean(), math.sqrt(0.25 / own.sum()), fmt="o", color="C0")
    axes.plot([0, 1], [0, 1], color="0.6", lw=0.8)
    axes.set(xlabel="probability given", ylabel="share that was right")
    _save(figure, folder / "diagnosis-calibration.svg")


def _reported(row: Row) -> bool:
    return row["planted"][0] in row["possible"]


def _save(figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
