"""Evidence of every set of effects along a straight line, in closed form."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from metrology.diagnostics.candidate import Candidate

Set = frozenset[str]
NONE: Set = frozenset()
NEGLIGIBLE = 1e-3
"""Probability over that of the best model below which another one moves no mean that is printed."""


def without(effects: Set, name: str, beside: Mapping[str, str]) -> Set:
    """Return a set without an effect, and without those that are tried beside it alone (`Cause.beside`)."""
    return frozenset(one for one in effects if name not in (one, beside.get(one)))


def is_whole(effects: Set, beside: Mapping[str, str]) -> bool:
    """Whether every effect of a set that is tried beside another alone has that there (`Cause.beside`)."""
    return all(beside.get(one, "") in ("", *effects) for one in effects)


def log_prior(size: int, among: int) -> float:
    """Ln probability beforehand of one set of so many effects.

    Every number of effects is equally probable, and so is every set of that number: more candidates make each less
    probable (Scott & Berger, Ann. Statist. 38 (2010) 2587).
    """
    return float(-math.log(among + 1) - math.log(math.comb(among, min(size, among))))


def price(candidate: Candidate, count: int, blocks: int) -> float:
    """Ln of what the parameters of an effect cost: each has a prior as wide as one reading determines it.

    Unit information, ½·ln n a parameter (Kass & Wasserman, J. Am. Stat. Assoc. 90 (1995) 928); 3/2·ln n for the
    frequency of a line, whose information grows with n³ (Djurić, IEEE Trans. Signal Process. 44 (1996) 1744): one of n,
    or of fewer where it may lie in some bands only; ln of the number of places for a shape that is tried place by
    place, or of which readings distinguish few values.

    Parameters
    ----------
    candidate : Candidate
        The effect.
    count : int
        Readings.
    blocks : int
        Blocks of readings, each of which has sizes of its own where the effect says so.
    """
    total, one = 0.0, 0.5 * math.log(max(count, 2))
    for size in candidate.parameters:
        if size.held:
            total += math.log(max(min(size.high - size.low, count), 1.0))
        elif size.own:
            total += 0.5 * blocks * math.log(max(count / blocks, 2.0))
        elif size.unit == "Hz":
            total += one + math.log(size.apart or max(count, 2))
        else:
            total += min(math.log(size.apart), one) if size.apart else one
    return total


def ways(candidate: Candidate, blocks: int) -> int:
    """How many parameters of an effect are sought: sizes and shapes, those that each block has for itself in each."""
    return sum(blocks if size.own else 1 for size in candidate.parameters if not size.held)


@dataclass(frozen=True)
class Scarce:
    """Few readings, whose noise is estimated with the rest.

    Parameters
    ----------
    free : float
        Degrees of freedom of the model without effects.
    scatter : float
        Cost that the scatter of the readings leaves: as many times its square.
    """

    free: float
    scatter: float

    def log_likelihood(self, cost: float, ways: float) -> float:
        """Ln likelihood of a cost, up to a constant: −½·ν·ln of it; every size of the noise is equally probable before.

        So many parameters of effects have a prior as wide as one reading determines them (`price`), in the scatter of
        the readings, if that is more than what they leave: in the noise that they leave alone, a model with as many
        parameters as there are readings would have evidence without end, whatever is read, for it leaves none.
        """
        left = math.log(max(cost, 1e-300))
        return -0.5 * max(self.free, 1) * left - 0.5 * ways * max(math.log(max(self.scatter, 1e-300)) - left, 0.0)


def log_likelihood(cost: float, scarce: Scarce | None, ways: float) -> float:
    """Ln likelihood of a cost, up to a constant: −½ of it where the noise is known, else that of few readings."""
    return -0.5 * cost if scarce is None else scarce.log_likelihood(cost, ways)
