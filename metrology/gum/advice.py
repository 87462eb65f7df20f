"""What to measure better: the input that dominates u of an output, and what it takes to halve u."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, sqrt

from metrology import ties
from metrology.gum.evaluation import BudgetRow
from metrology.gum.inputs import NAMELESS, Knowledge
from metrology.gum.rounding import readable
from metrology.message import said


@dataclass(frozen=True)
class Lever:
    """A cause that can be measured better: an input, a set of simultaneous readings, or the points of a fit.

    `u` is None where several inputs share the cause. `own` is its variance by itself and `share` its part of u² with
    cross terms, both relative to u². `mainly` is its component, where it has several, `begun` its name at the start of
    a sentence, where that differs, and `read` whether it falls by reading more often.
    """

    name: str
    u: float | None
    unit: str
    mainly: str
    own: float
    share: float
    begun: str = ""
    read: bool = False

    @property
    def rest(self) -> float:
        """What is left of u², relative to it, without this cause: 1 − own − cross, with cross = 2(share − own)."""
        return max(1 - 2 * self.share + self.own, 0.0)

    def scaling(self, target: float) -> float | None:
        """Factor on the cause's uncertainty that brings u² down to `target`·u²; None where that cannot be reached.

        Solves own·s² + cross·s + rest = target for the largest s in [0, 1].
        """
        cross = 2 * (self.share - self.own)
        discriminant = cross**2 - 4 * self.own * (self.rest - target)
        if self.own <= 0 or discriminant < 0:
            return None
        s = (-cross + sqrt(discriminant)) / (2 * self.own)
        return s if 0 < s < 1 else None


def advise(name: str, u: float, unit: str, rows: Sequence[BudgetRow], knowledge: Knowledge) -> str:
    """One sentence: the cause with the largest part in u, and the uncertainty it would need for u to halve.

    Where improving it alone cannot halve u, the sentence says so, with the u that is left without it and the next
    cause. Empty where u is zero or undefined.

    Parameters
    ----------
    name, unit : str
        Of the output.
    u : float
        Its standard uncertainty, in SI.
    rows : sequence of BudgetRow
        Its budget.
    knowledge : Knowledge
        Which inputs can only be improved together: members of simultaneous readings, the parameters of one fit.
    """
    if not u > 0:
        return ""
    levers = sorted(_levers(rows, knowledge, u), key=lambda lever: -ties.level(lever.share))
    first = levers[0]
    known: dict[str, str | float] = {
        "cause": first.begun or first.name, "name": name, "share": float(first.share), "component": first.mainly,
    }  # fmt: skip
    s = first.scaling(0.25)
    if s is not None:
        return said(HALVED[_kind(first)], **known, half=readable(u / 2, unit), **_demand(first, s))
    return said(
        NOT_HALVED[bool(first.mainly)],
        **known,
        u=readable(u, unit),
        best=readable(u * sqrt(first.rest), unit),
        other=levers[1].name,  # a cause alone would be all of u
        rest=float(levers[1].share),
    )


HALVED = {
    "input": "{cause} has the largest part in u({name}), {share:.0%} of u²; for u({name}) to halve to {half:figures}, "
    "its u would have to fall from {u:figures} to {needed:figures}.",
    "component": "{cause} has the largest part in u({name}), {share:.0%} of u² (mainly by its component "
    "'{component}'); for u({name}) to halve to {half:figures}, its u would have to fall from {u:figures} to "
    "{needed:figures}.",
    "shared": "{cause} has the largest part in u({name}), {share:.0%} of u²; for u({name}) to halve to {half:figures}, "
    "it would have to fall to {part:.0%} of what it is.",
    "readings": "{cause} has the largest part in u({name}), {share:.0%} of u²; for u({name}) to halve to "
    "{half:figures}, it would have to fall to {part:.0%} of what it is, as by {times:.2g} times as many readings.",
}
NOT_HALVED = {
    False: "{cause} has the largest part in u({name}), {share:.0%} of u², but improving it alone cannot halve "
    "u({name}): even without it u({name}) would only fall from {u:figures} to {best:figures}; next comes {other} with "
    "{rest:.0%}.",
    True: "{cause} has the largest part in u({name}), {share:.0%} of u² (mainly by its component '{component}'), but "
    "improving it alone cannot halve u({name}): even without it u({name}) would only fall from {u:figures} to "
    "{best:figures}; next comes {other} with {rest:.0%}.",
}


def _kind(lever: Lever) -> str:
    if lever.u is None:
        return "readings" if lever.read else "shared"
    return "component" if lever.mainly else "input"


def _demand(lever: Lever, s: float) -> dict[str, str | float]:
    if lever.u is None:
        return {"part": float(s), "times": float(1 / s**2)}
    return {"u": readable(lever.u, lever.unit), "needed": readable(s * lever.u, lever.unit)}


def _levers(rows: Sequence[BudgetRow], knowledge: Knowledge, u: float) -> list[Lever]:
    together = {(one.name, member): one.name for one in knowledge.ensembles for member in one.members}
    joined = _joined(knowledge)
    shared = Counter(row.cause for row in rows if row.cause)
    inputs: dict[str, list[BudgetRow]] = {}
    sets: dict[str, list[BudgetRow]] = {}
    causes: dict[str, list[BudgetRow]] = {}
    for row in rows:
        ensemble = together.get((row.component, row.input))
        key = joined.get(row.input, row.input)
        if shared[row.cause] > 1:
            group = causes.setdefault(row.cause, [])
        else:
            group = inputs.setdefault(key, []) if ensemble is None else sets.setdefault(ensemble, [])
        group.append(row)
    return [
        *(_of_input(name, group, u) for name, group in inputs.items()),
        *(_together("cause", _called(name, group), group) for name, group in causes.items()),
        *(_of_readings(name, group) for name, group in sets.items()),
    ]


def _called(cause: str, group: Sequence[BudgetRow]) -> str:
    """A cause as a reader knows it: one that no person named by its components."""
    return group[0].component if cause.startswith(NAMELESS) else cause


def _joined(knowledge: Knowledge) -> dict[str, str]:
    """Correlated inputs that have one source in common, such as the parameters of one fit → that source."""
    joined: dict[str, str] = {}
    for pair, r in knowledge.correlations.items():
        sources = {component.source for name in pair for component in knowledge.inputs[name].components}
        if r and len(sources) == 1 and (source := sources.pop()):
            joined |= dict.fromkeys(pair, source)
    return joined


def _of_input(name: str, group: Sequence[BudgetRow], u: float) -> Lever:
    if len({row.input for row in group}) > 1:
        return _together("points", name, group)
    own = (hypot(*(row.contribution for row in group)) / u) ** 2
    share = sum(row.share for row in group)
    largest = max(group, key=lambda row: ties.level(abs(row.contribution)))
    mainly = largest.component if len(group) > 1 else ""
    return Lever(name, hypot(*(row.u for row in group)), group[0].unit, mainly, own, share)


def _of_readings(name: str, group: Sequence[BudgetRow]) -> Lever:
    return _together("readings" if name == "readings" else "named readings", name, group)


BEGUN = {
    "cause": "The uncertainty of {name}, shared by {members:comma},",
    "points": "The uncertainty of the points of {name} ({members:comma})",
    "readings": "The scatter of the readings ({members:comma})",
    "named readings": "The scatter of the readings {name} ({members:comma})",
}
WITHIN = {
    "cause": "the uncertainty of {name}, shared by {members:comma},",
    "points": "the uncertainty of the points of {name} ({members:comma})",
    "readings": "the scatter of the readings ({members:comma})",
    "named readings": "the scatter of the readings {name} ({members:comma})",
}
"""A cause of several inputs, at the start of a sentence and within one."""


def _together(kind: str, name: str, group: Sequence[BudgetRow]) -> Lever:
    # Readings, points or a cause that inputs share get better together: the cross terms belong to their own variance.
    share = sum(row.share for row in group)
    members = tuple(dict.fromkeys(row.input for row in group))
    named, begun = said(WITHIN[kind], name=name, members=members), said(BEGUN[kind], name=name, members=members)
    return Lever(named, None, "1", "", share, share, begun, read=kind.endswith("readings"))
