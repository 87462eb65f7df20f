"""Whether two `results.json` hold the same results: to the last bit, or but for what processors round differently."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

RELATIVE = 1e-9
"""Largest relative difference that is rounding: OpenBLAS and NumPy sum in another order on another processor, with
2.2e-16 a step, and a fit whose unknowns correlate to 1 − 1e-6 multiplies that by 1e6."""
OF_U = 1e-7
"""Largest difference, over the standard uncertainty of a number, that is rounding: five digits beyond those printed."""
SAME_UNIT = frozenset(
    {"value", "u", "mean", "low", "high", "shortest_low", "shortest_high", "tolerance", "difference", "u_difference"}
)
"""Numbers of one entry that have its unit: what is rounding to one of them is so to ``u`` beside it."""
SPREAD = frozenset({"u", "size", "dof", "level", "memory"})
"""Standard uncertainties, their degrees of freedom, level and correlation time of a noise: as exact as u."""
COUNTED = frozenset({"probability", "specific_risk", "rule_risk"})
"""Parts of Monte Carlo draws: known to the ``resolution`` beside them, as a draw at a limit falls on either side."""
OF_ONE = frozenset(
    {"probability", "p_value", "share", "coefficient", "filter_bias", "statistic", "log_bayes", "shift", "en",
     "tension", "magnitude", "phase", "combined", "peak_error", "closed_above", "closed_excess"}
)  # fmt: skip
"""Pure numbers, known to one: parts of a whole, logarithms of odds, differences in standard uncertainties."""
TRIED, OF_TRIAL = frozenset({"score"}), 1e-6
"""What a small trial of an effect says in standard deviations, and what is rounding of it: the difference of two
motions, of which the other unknowns explain most, has a digit less than what comes from one."""
ENDS = frozenset({"d_low", "d_high"})
"""Differences of ends of intervals, as exact as these ends are."""
DRAWN, DIGIT = frozenset({"series", "curves", "channels", "density"}), 1e-5
"""What holds points of pictures, which are kept to six digits, and one unit of the last over such a number."""
BARRED = 1e-2
"""Largest difference of a point drawn with its standard uncertainty, over this: no bar shows it. What is drawn is what
a fit leaves, and a fit ends where its last step is 3e-3 of its standard uncertainties (`diagnostics.plain.CLOSE`)."""
OWN, NUMERICAL, LITTLE = frozenset({"own", "shares"}), "u_num", 1e-13
"""What holds numbers that are known to one: inputs of a run in their standard uncertainties, parts of a variance; what
holds uncertainties of the numerical solution, and what rounding alone makes of these, in SI."""
MOST = 1e-2
"""Largest relative difference of a row of a budget, however little it changes the u that it is part of."""
MIXED = frozenset({"units", "names", "parameters"})
"""What stands beside lists whose numbers have units of their own."""
NOTHING = 1e-15
"""A number in SI below which nothing is meant: a correlation or a probability that is zero but for rounding."""
OTHERS = ("software",)
"""What tells of the program, not of the results."""


@dataclass(frozen=True)
class Agreement:
    """How two files agree.

    Parameters
    ----------
    differences : tuple of str
        Each place where they differ by more than rounding, with both values; empty where they agree.
    largest : float
        Largest relative difference of two numbers that agree; 0 where all are the same to the last bit.
    """

    differences: tuple[str, ...]
    largest: float

    @property
    def agrees(self) -> bool:
        """Whether nothing differs by more than rounding."""
        return not self.differences

    @property
    def exact(self) -> bool:
        """Whether nothing differs at all."""
        return self.agrees and self.largest == 0.0

    @property
    def sentence(self) -> str:
        """Result in words."""
        if self.differences:
            count = len(self.differences)
            return f"{count} {'entry differs' if count == 1 else 'entries differ'}, the first: {self.differences[0]}"
        return "to the last bit" if self.exact else f"within {RELATIVE:g}, or {OF_U:g} u, all texts the same"


def compare(one: bytes, other: bytes) -> Agreement:
    """Compare two `results.json`: all is to be the same but for rounding of numbers that are no counts.

    A number is compared relative to itself and to the largest number of the list that it stands in; an estimate with
    its standard uncertainty, a part of a standard uncertainty with the whole, a pure number with one.

    Raises
    ------
    ValueError
        For what is not JSON.
    """
    read = [{key: part for key, part in json.loads(text).items() if key not in OTHERS} for text in (one, other)]
    found = list(_walk(read[0], read[1], "", dict(_known(read[0], ""))))
    differences = tuple(f"{path}: {words}" for path, words, _ in found if words)
    return Agreement(differences, max((by for _, words, by in found if not words), default=0.0))


def _walk(one: Any, other: Any, path: str, known: Mapping[str, float]) -> Iterator[tuple[str, str, float]]:
    """Every difference: where, in words where it is more than rounding, size over what the number is known to."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        for key in one:
            yield from _walk(one[key], other[key], f"{path}.{key}".lstrip("."), known)
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for at, (a, b) in enumerate(zip(one, other, strict=True)):
            yield from _walk(a, b, f"{path}[{at}]", known)
    elif _is_number(one) and _is_number(other) and not (isinstance(one, int) and isinstance(other, int)):
        by = abs(one - other) / max(abs(one), abs(other), known.get(path, 0.0), NOTHING / RELATIVE)
        if by > 0:
            yield path, "" if by <= RELATIVE else f"{one!r} for {other!r}", by
    elif one != other or type(one) is not type(other):
        yield path, f"{_short(one)} for {_short(other)}", math.inf


def _known(node: Any, path: str, within: str = "") -> Iterator[tuple[str, float]]:
    """Sizes of which `RELATIVE` is rounding, of the numbers for which their own size is not the measure."""
    if isinstance(node, list):
        size = max(_size(node), (OF_U if within in OWN else LITTLE if within == NUMERICAL else 0.0) / RELATIVE)
        for at, one in enumerate(node):
            if _is_number(one):
                yield f"{path}[{at}]", max(size, abs(one) * 1.1 * DIGIT / RELATIVE) if within in DRAWN else size
            else:
                yield from _known(one, f"{path}[{at}]", within)
    elif isinstance(node, dict):
        for key, one in node.items():
            place = f"{path}.{key}".lstrip(".")
            if MIXED & node.keys() and isinstance(one, list) and all(map(_is_number, one)):
                continue  # one number has nothing to do with the next: each is compared with itself
            if key == "y" and within in DRAWN and _pairs(one, node.get("u")):
                for at, (y, u) in enumerate(zip(one, node["u"], strict=True)):
                    yield f"{place}[{at}]", max(1.1 * DIGIT * abs(y), BARRED * u) / RELATIVE
                continue
            if _is_number(one):
                yield place, _measure(key, one, node)
            else:
                yield from _known(one, place, key if key in {*DRAWN, *OWN, NUMERICAL} else within)
        inside = f"{path}.".lstrip(".")
        yield from _of_budget(node, inside)
        yield from _of_sources(node, inside)


def _measure(key: str, value: float, beside: Mapping[str, Any]) -> float:
    """Size of which `RELATIVE` is rounding, of one number of an entry; 0 where its own size is the measure."""
    if key in ENDS:
        return _size([beside.get("low"), beside.get("high")])
    if key in COUNTED and beside.get("resolution"):
        return float(beside["resolution"]) / RELATIVE
    if key in OF_ONE | TRIED:
        return max(abs(value), 1.0) * (OF_TRIAL if key in TRIED else OF_U) / RELATIVE
    if key in SPREAD or key.startswith("u_") or key.endswith("_u"):
        return abs(value) * OF_U / RELATIVE
    own = (beside.get("u"), _width(beside)) if key in SAME_UNIT else ()
    return _size([beside.get(f"{key}_u"), beside.get(f"u_{key}"), *own]) * OF_U / RELATIVE


def _width(beside: Mapping[str, Any]) -> float | None:
    """Width of an interval, where both of its ends are known."""
    ends = [beside[key] for key in ("low", "high") if _is_number(beside.get(key))]
    return ends[1] - ends[0] if len(ends) == 2 else None


def _of_budget(node: Mapping[str, Any], path: str) -> Iterator[tuple[str, float]]:
    """Rows of a budget: what changes the u that they add up to."""
    if "budget" in node and "framework" in node:
        u = node["framework"]["u"]
        for at, row in enumerate(node["budget"]):
            part = abs(row["contribution"]) or u or 1.0
            for key in ("contribution", "u", "sensitivity"):
                loose = min(max(OF_U * u / part, OF_U), MOST if part > RELATIVE * u else math.inf)
                yield f"{path}budget[{at}].{key}", abs(row.get(key) or 0.0) * loose / RELATIVE


def _of_sources(node: Mapping[str, Any], path: str) -> Iterator[tuple[str, float]]:
    """Parts of covariances by their causes: what changes the u of an unknown."""
    columns = [one["columns"] for one in node.get("sources", ()) if isinstance(one, dict) and "columns" in one]
    for row, own in enumerate(zip(*columns, strict=True)):
        u = math.hypot(*(entry for part in own for entry in part))
        yield f"{path}values[{row}]", u * OF_U / RELATIVE
        for key in ("stated", "stated_u"):
            yield f"{path}{key}[{row}]", _size(node.get("stated_u", ())[row : row + 1]) * OF_U / RELATIVE
        for source, part in enumerate(own):
            for at in range(len(part)):
                yield f"{path}sources[{source}].columns[{row}][{at}]", u * OF_U / RELATIVE


def _pairs(one: Any, other: Any) -> bool:
    """Whether both are lists of as many numbers."""
    return (
        isinstance(one, list)
        and isinstance(other, list)
        and len(one) == len(other)
        and all(map(_is_number, one + other))
    )


def _size(numbers: Sequence[Any]) -> float:
    return max((abs(one) for one in numbers if _is_number(one)), default=0.0)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 120 else f"{text[:117]}…"
