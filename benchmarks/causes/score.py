"""The score card: one method over many cases."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from .answers import Answer
from .names import NAMES

NOTABLE = 0.05
"""Smallest probability that counts towards the calibration error: names at 0 are many, and would hide all others."""


@dataclass(frozen=True)
class Judged:
    """One case, judged. A figure is None where its question does not arise."""

    case: str
    method: str
    kind: str
    named: bool | None
    within: bool | None
    exact: bool | None
    one: bool | None
    abstained: bool | None
    misnamed: bool
    verdict: bool
    answered: bool
    events: tuple[tuple[float, bool], ...]
    k: bool | None
    c: bool | None
    held_out: tuple[float, float] | None
    cpu: float
    said: str


def judge(expected: dict[str, Any], answer: Answer, cpu: float) -> Judged:
    """Compare an answer with the right one."""
    causes, groups = list(expected["causes"]), [set(group) for group in expected["group"]]
    accepted = {cause: {cause}.union(*(group for group in groups if cause in group)) for cause in causes}
    right = set().union(*accepted.values())
    hit = [bool(accepted[cause] & answer.possible) for cause in causes]
    wrong = set(answer.named) & set(expected["must_not"])
    wrong_groups = [group for group in answer.groups if not set(group) & right]
    clean = not wrong and not wrong_groups
    answered = not answer.failure and answer.verdict != "not finished"
    verdict = answered and answer.verdict in expected["verdict"]
    return Judged(
        case=expected["case"],
        method=expected["method"],
        kind=expected["kind"],
        named=answer.top in right if causes else None,
        within=all(hit) if causes else None,
        exact=(all(hit) and clean) if causes else None,
        one=any(hit) if causes else None,
        abstained=(not answer.possible and verdict) if not causes else None,
        misnamed=not clean,
        verdict=verdict,
        answered=answered,
        events=tuple(events(expected["method"], accepted, answer)),
        k=_covers(expected["k"], answer.k),
        c=_covers(expected["c"], answer.c),
        held_out=answer.held_out,
        cpu=cpu,
        said=_said(answer),
    )


def events(method: str, accepted: dict[str, set[str]], answer: Answer) -> Iterable[tuple[float, bool]]:
    """Probability and truth of every name; names that no data of this kind tell apart are one event."""
    p, seen = answer.probabilities, set()
    for names in accepted.values():
        seen |= names
        yield min(1.0, sum(p.get(name, 0.0) for name in names)), True
    for name in NAMES[method]:
        if name not in seen:
            yield p.get(name, 0.0), False


def _covers(true: dict[str, Any] | None, found: tuple[float, float, float] | None) -> bool | None:
    if true is None or found is None:
        return None
    return found[1] <= true["value"] <= found[2]


def _said(answer: Answer) -> str:
    names = ", ".join([*answer.named, *("/".join(group) for group in answer.groups)])
    return answer.failure or f"{answer.verdict}: {names}" if names or answer.failure else answer.verdict


def card(judged: list[Judged]) -> dict[str, Any]:
    """Figures over cases. Shares are [how many, of how many]."""
    listed = [one for one in judged if one.kind in ("one", "remainder")]
    pairs = [one for one in judged if one.kind == "pair"]
    every = [event for one in judged for event in one.events]
    return {
        "cases": len(judged),
        "named (top-1)": _share(one.named for one in listed),
        "in set": _share(one.within for one in listed + pairs),
        "pairs: both": _share(one.within for one in pairs),
        "pairs: exact": _share(one.exact for one in pairs),
        "pairs: one": _share(one.one for one in pairs),
        "abstained rightly": _share(one.abstained for one in judged),
        "of these, nothing planted": _share(one.abstained for one in judged if one.kind == "nothing"),
        "of these, unlisted": _share(one.abstained for one in judged if one.kind == "unlisted"),
        "misnamed": _share(one.misnamed for one in judged),
        "verdict allowed": _share(one.verdict for one in judged),
        "answered": _share(one.answered for one in judged),
        "Brier": _brier(every),
        "calibration error": calibration_error(every),
        "coverage of k": _share(one.k for one in judged),
        "coverage of c": _share(one.c for one in judged),
        **_held_out([one.held_out for one in judged if one.held_out]),
        "CPU per case / s": _spread([one.cpu for one in judged]),
    }


def _share(values: Iterable[bool | None]) -> list[int]:
    found = [value for value in values if value is not None]
    return [sum(found), len(found)]


def _brier(every: list[tuple[float, bool]]) -> float | None:
    """Σ (p − truth)² over the number of true events and of notable probabilities."""
    notable = [(p, true) for p, true in every if true or p >= NOTABLE]
    return sum((p - true) ** 2 for p, true in notable) / len(notable) if notable else None


def calibration_error(every: list[tuple[float, bool]], bins: int = 10) -> float | None:
    """ECE = Σ_b n_b/n·|share of true events − mean probability| over bins of equal width, of notable probabilities."""
    notable = [(p, true) for p, true in every if p >= NOTABLE]
    if not notable:
        return None
    error = 0.0
    for b in range(bins):
        inside = [(p, true) for p, true in notable if min(int(p * bins), bins - 1) == b]
        if inside:
            error += abs(sum(true for _, true in inside) - sum(p for p, _ in inside))
    return error / len(notable)


def _held_out(found: list[tuple[float, float]]) -> dict[str, Any]:
    """Residuals over noise with the causes, and gain: geometric mean of as stated over with the causes."""
    if not found:
        return {"held out / noise": None, "held-out gain": None}
    gain = math.exp(sum(math.log(before / after) for before, after in found) / len(found))
    return {"held out / noise": _spread([after for _, after in found]), "held-out gain": gain}


def _spread(values: list[float]) -> list[float] | None:
    """Median and largest."""
    ordered = sorted(values)
    return [ordered[len(ordered) // 2], ordered[-1]] if ordered else None


def printed(name: str, cards: dict[str, dict[str, Any]]) -> str:
    """Score card as text: a column for each kind of test, and for all."""
    lines = [f"{name:28s}" + "".join(f"{head:>18s}" for head in cards)]
    for row in next(iter(cards.values())):
        lines += [f"{row:28s}" + "".join(f"{_cell(one[row]):>18s}" for one in cards.values())]
    return "\n".join(lines)


def _cell(value: Any) -> str:
    if value is None or value == [0, 0]:
        return "–"
    if isinstance(value, list) and isinstance(value[0], int):
        return f"{value[0]} of {value[1]}"
    if isinstance(value, list):
        return f"{value[0]:.3g}, max {value[1]:.3g}"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
