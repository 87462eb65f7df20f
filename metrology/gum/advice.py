"""What to measure better: the input that dominates u of an output, and what it takes to halve u."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, sqrt

from metrology.gum.evaluation import BudgetRow
from metrology.gum.inputs import Knowledge
from metrology.gum.rounding import readable


@dataclass(frozen=True)
class Lever:
    """A cause that can be measured better: an input, a set of simultaneous readings, or the points of a fit.

    `u` is None where several inputs share the cause, and `remedy` then how it falls. `own` is its variance by itself
    and `share` its part of u² with cross terms, both relative to u².
    """

    name: str
    u: float | None
    unit: str
    mainly: str
    own: float
    share: float
    remedy: str = ""

    @property
    def opening(self) -> str:
        """The name at the start of a sentence; names of inputs keep their case."""
        return self.name[0].upper() + self.name[1:] if self.name.startswith("the ") else self.name

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
    levers = sorted(_levers(rows, knowledge, u), key=lambda lever: -lever.share)
    first = levers[0]
    opening = f"{first.opening} has the largest part in u({name}), {first.share:.0%} of u²{first.mainly}"
    s = first.scaling(0.25)
    if s is not None:
        return f"{opening}; for u({name}) to halve to {readable(u / 2, unit)}, {_demand(first, s)}."
    best = readable(u * sqrt(first.rest), unit)
    closing = f"even without it u({name}) would only fall from {readable(u, unit)} to {best}"
    second = f"next comes {levers[1].name} with {levers[1].share:.0%}"  # a cause alone would be all of u
    return f"{opening}, but improving it alone cannot halve u({name}): {closing}; {second}."


def _demand(lever: Lever, s: float) -> str:
    if lever.u is None:
        return f"it would have to fall to {s:.0%} of what it is{lever.remedy.format(1 / s**2)}"
    return f"its u would have to fall from {readable(lever.u, lever.unit)} to {readable(s * lever.u, lever.unit)}"


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
        *(_together((f"the uncertainty of {name}, shared by ", ","), group) for name, group in causes.items()),
        *(_of_readings(name, group) for name, group in sets.items()),
    ]


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
        return _together((f"the uncertainty of the points of {name} (", ")"), group)
    own = (hypot(*(row.contribution for row in group)) / u) ** 2
    share = sum(row.share for row in group)
    largest = max(group, key=lambda row: abs(row.contribution))
    mainly = f" (mainly by its component {largest.component!r})" if len(group) > 1 else ""
    return Lever(name, hypot(*(row.u for row in group)), group[0].unit, mainly, own, share)


def _of_readings(name: str, group: Sequence[BudgetRow]) -> Lever:
    named = "the readings" if name == "readings" else f"the readings {name}"
    return _together((f"the scatter of {named} (", ")"), group, ", as by {:.2g} times as many readings")


def _together(around: tuple[str, str], group: Sequence[BudgetRow], remedy: str = "") -> Lever:
    # Readings, points or a cause that inputs share get better together: the cross terms belong to their own variance.
    share = sum(row.share for row in group)
    members = ", ".join(dict.fromkeys(row.input for row in group))
    return Lever(members.join(around), None, "1", "", share, share, remedy)
