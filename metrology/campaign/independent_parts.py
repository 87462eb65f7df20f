"""The budget of an imported result in independent parts, and what of its distribution they do not carry over."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf, isfinite, log10, sqrt
from typing import Any

from metrology.campaign.results_file import KEPT, Drawn, Result
from metrology.gum.bounded import Arcsine, Rectangular, Triangular
from metrology.gum.distributions import Normal, Student
from metrology.gum.influence import Distribution
from metrology.gum.rounding import readable
from metrology.message import said

_SHAPES = ("rectangular", "triangular", "arcsine")
"""Distributions that their standard uncertainty describes; others enter as normal ones of the same u."""
_LEAST = 1e-9
"""Part of u² below which a difference is rounding."""
_DRAWS = 200_000
"""Draws by which that is seen: they place the end of a 95 % interval to a hundredth of u."""


@dataclass(frozen=True)
class Part:
    """One cause of the uncertainty of an imported result: its contribution with its sign, and what it is.

    `key` says which unknown it is, so that two results of one file share what both depend on; `cause` is the name that
    the other campaign gives it.
    """

    key: str
    name: str
    contribution: float
    distribution: str
    dof: float | None
    kind: str
    source: str
    cause: str


def lost(result: Result, found: list[Part]) -> str:
    """What an interval says that the parts, each as it is entered, do not: of a skewed distribution or equation."""
    import numpy as np

    known, u = result.monte_carlo, result.framework.u
    if known.law_valid or not all(map(isfinite, (known.low, known.high, known.tolerance))):
        return ""
    u = u or (known.high - known.low) / 2
    if not u > 0:
        return ""
    low, high = result.value + np.quantile(_drawn(found), _tails(known))
    if max(abs(low - known.low), abs(high - known.high)) <= max(known.tolerance, KEPT * u):
        return ""
    text = (
        "its symmetric {percent:g} % interval there is {low:figures} to {high:figures}, here {here_low:figures} to "
        "{here_high:figures}: its distribution is not carried over"
    )
    ends = {"low": known.low, "high": known.high, "here_low": float(low), "here_high": float(high)}
    digits = 2 + max(1, ceil(log10(max(map(abs, ends.values())) / u)))
    sizes = {name: readable(end, result.unit, digits) for name, end in ends.items()}
    return said(text, percent=100 * known.p, **sizes)


def rest(result: Result, found: list[Part]) -> Part | None:
    """What the reported u has beyond the parts: of an equation whose first order says less than its draws.

    The rows of a square at zero all have a sensitivity of zero; its u would be lost.
    """
    import numpy as np

    if not isfinite(result.u):
        return None
    variance = sum(_distribution(part).deviation ** 2 for part in found)
    if variance == inf:
        low, high = np.quantile(_drawn(found), _tails(result.monte_carlo))
        variance = float((high - low) / (2 * Normal(1.0).quantile(_tails(result.monte_carlo)[1]))) ** 2
    if result.u <= (1 + KEPT) * sqrt(variance):
        return None
    name = "what its budget does not show"
    return Part(f"{result.name}: {name}", name, sqrt(result.u**2 - variance), "normal", None, "B", "", "")


def _drawn(found: list[Part]) -> Any:
    """Draws of the parts together, each as it is entered."""
    import numpy as np

    generator = np.random.default_rng(1)
    return sum((_distribution(part).draw(generator, _DRAWS) for part in found), np.zeros(1))


def _tails(known: Drawn) -> tuple[float, float]:
    """Probabilities below the two ends of a symmetric interval."""
    tail = (1 - known.p) / 2
    return tail, 1 - tail


def _distribution(part: Part) -> Distribution:
    """Distribution of a part as it is entered."""
    size = abs(part.contribution)
    match part.distribution:
        case "rectangular":
            return Rectangular(sqrt(3) * size)
        case "triangular":
            return Triangular(sqrt(6) * size)
        case "arcsine":
            return Arcsine(sqrt(2) * size)
    return Normal(size) if part.dof is None else Student(size, part.dof)


def parts(result: Result) -> list[Part]:
    """Budget of a result in independent parts, whose squares add up to u² by the GUM uncertainty framework.

    Rows of one cause are one part; rows that are correlated otherwise (readings taken together, parameters of one fit)
    are one part too, with what their covariance leaves of u². Draws of the parts, each by its distribution and its
    degrees of freedom, have what Monte Carlo made of them there.
    """
    u = result.framework.u
    if not u > 0:
        return []
    found, joined = list[Part](), list[Any]()
    alike: dict[Any, list[Any]] = {}
    for at, row in enumerate(result.budget):
        alike.setdefault(row.cause or at, []).append(row)
    for rows in alike.values():
        size = sum(row.moved for row in rows)
        # A file of a version that does not write the direction of a cause has what the rows make together all the same.
        if abs(u**2 * sum(row.share for row in rows) - size**2) > _LEAST * u**2:
            joined += rows
        else:
            found.append(_part(rows[0], size))
    sets: dict[str, list[Any]] = {}
    for row in joined:
        sets.setdefault(row.component, []).append(row)
    variances = {name: u**2 * sum(row.share for row in rows) for name, rows in sets.items()}
    if any(variance < 0 for variance in variances.values()):
        sets, variances = {"correlated inputs": joined}, {"correlated inputs": sum(variances.values())}
    for name, rows in sets.items():
        size = sqrt(max(variances[name], 0.0))
        dof = rows[0].dof if len({row.dof for row in rows}) == 1 else None
        # Its own of this result: its size does not say what it does to another one.
        key = f"{result.name}: {name}"
        found.append(Part(key, name, size, "normal", dof, rows[0].kind, rows[0].source, ""))
    return [part for part in found if part.contribution]


def _part(row: Any, contribution: float) -> Part:
    name = f"{row.input}, {row.component}" if row.component else row.input
    shape = row.distribution if row.distribution in _SHAPES else "normal"
    return Part(row.cause or name, name, contribution, shape, row.dof, row.kind, row.source, row.cause)
