"""When Monte Carlo trials are enough: for stable figures, and to be sure of the law and of the interval chosen."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, nan
from statistics import median

from metrology.gum.distributions import MeanSquare, Student
from metrology.gum.evaluation import Coverage
from metrology.gum.inputs import Floats
from metrology.gum.intervals import Intervals, intervals
from metrology.gum.law import Law
from metrology.gum.monte_carlo import (
    DEVIATION,
    HIGH,
    LOW,
    SHORTEST_HIGH,
    SHORTEST_LOW,
    Plan,
    Trials,
    scatter,
)
from metrology.gum.rounding import tolerance

SURE = 3.0
"""Standard deviations of a figure of Monte Carlo by which it is clear of a limit: beyond by chance in 1 of 370."""


@dataclass(frozen=True)
class Claim:
    """What the law says about one output, for Monte Carlo to judge.

    `heavy` is the smallest ν of readings whose mean or scatter the output depends on where that is at most 2: the
    standard deviation of the output does not exist then, for ν ≤ 1 neither does its mean. It is infinite otherwise.
    """

    value: float
    u: float
    coverage: Coverage
    note: str
    failure: str
    unit: str
    heavy: float

    @property
    def reference(self) -> float:
        """The u of the GUM uncertainty framework where it can be the measure of δ, else NaN."""
        return self.u if isfinite(self.u) and self.u > 0 else nan


def claims(law: Law, probability: float) -> tuple[Claim, ...]:
    """The claims of the law about every output."""
    return tuple(
        Claim(
            line.value,
            law.u(row),
            law.coverage(row, probability),
            law.dof(row)[1],
            line.failure,
            line.measurand.unit,
            _heavy(law, row),
        )
        for row, line in enumerate(law.linear)
    )


def _heavy(law: Law, row: int) -> float:
    drawn = (t.component.drawn for t in law.joint.terms if t.input.name in law.linear[row].reads)
    smallest = min((d.dof for d in drawn if isinstance(d, Student | MeanSquare) and d.scale > 0), default=inf)
    return smallest if smallest <= 2 else inf


def shortfall(claims: tuple[Claim, ...], batches: Floats, digits: int) -> float:
    """Factor by which trials fall short of the tolerance of 7.9 and of a sure verdict of clause 8; 1 when enough."""
    return max(
        max(stability(claim, batches[:, row], digits), certainty(claim, batches[:, row], digits))
        for row, claim in enumerate(claims)
    )


def chosen(claims: tuple[Claim, ...], trials: Trials, plan: Plan) -> float:
    """Factor by which trials fall short of a sure choice of the interval where the law is not the one reported.

    Parameters
    ----------
    claims : tuple of Claim
        One an output.
    trials : Trials
        Made so far.
    plan : Plan
        Coverage probability and digits.

    Returns
    -------
    float
        At most 1 where the trials are enough.
    """
    return max(
        (
            choice(claim, trials.batches[:, row], intervals(trials.outputs[row].copy(), plan.probability), plan.digits)
            for row, claim in enumerate(claims)
            if not trials.invalid[row] and _contradicted(claim, trials.batches[:, row], plan.digits)
        ),
        default=0.0,
    )


def _contradicted(claim: Claim, batches: Floats, digits: int) -> bool:
    """Whether an end of the framework's interval lies beyond δ, so that an interval of the draws is reported."""
    if claim.coverage.low is None or claim.coverage.high is None or not isfinite(claim.reference):
        return True
    low, high = float(batches[:, LOW].mean()), float(batches[:, HIGH].mean())
    return max(abs(claim.coverage.low - low), abs(claim.coverage.high - high)) > tolerance(claim.u, digits)


def choice(claim: Claim, batches: Floats, found: Intervals, digits: int) -> float:
    """(2s/gap)² for the choice between the intervals, and (2s/δ)² for the ends of the shortest one where it is chosen.

    The stability of the ends of the symmetric one is in `stability`. 0 where nothing scatters.
    """
    low, high = batches[:, SHORTEST_LOW], batches[:, SHORTEST_HIGH]
    widths = batches[:, HIGH] - batches[:, LOW]
    delta = _delta(claim, claim.reference if boundless(batches) else float(batches[:, DEVIATION].mean()), digits)
    if not (delta > 0 and (widths > 0).all()):
        return 0.0
    gains = (1 - (high - low) / widths)[:, None]
    gap = abs(found.gain - found.least)
    sure = float(scatter(gains)[0] / gap) ** 2 if gap else inf
    if found.kind == "symmetric":
        return sure
    return max(sure, float((scatter(batches)[SHORTEST_LOW:] / delta).max()) ** 2)


def stability(claim: Claim, batches: Floats, digits: int) -> float:
    """(2s/δ)², the largest over mean, u and both ends (7.9.4); moments that do not exist are left out."""
    no_moments = isfinite(claim.heavy) or boundless(batches)
    delta = _delta(claim, claim.reference if no_moments else float(batches[:, DEVIATION].mean()), digits)
    if not delta > 0:
        return 0.0
    doubled = scatter(batches)[LOW if no_moments else 0 : SHORTEST_LOW]
    return float((doubled / delta).max() ** 2)


def boundless(batches: Floats) -> bool:
    """Whether three times the scatter of u reaches u itself, or most blocks have less than half of it.

    So it is where none exists: a block then has the standard deviation of its own most extreme draw, and few blocks
    make the mean. Not one digit of it would ever be stable.
    """
    deviations = batches[:, DEVIATION]
    u = float(deviations.mean())
    if not (isfinite(u) and u > 0):
        return False
    return float(scatter(batches)[DEVIATION]) > u / 3 or float(median(deviations)) < u / 2


def _delta(claim: Claim, deviation: float, digits: int) -> float:
    """Numerical tolerance δ for the Monte Carlo figures; NaN or zero where nothing scatters or nothing is a number."""
    u = claim.reference if isfinite(claim.heavy) else deviation
    return tolerance(u, digits) if isfinite(u) and u > abs(claim.value) * 1e-15 else nan


def certainty(claim: Claim, batches: Floats, digits: int) -> float:
    """Factor by which trials fall short of the law being surely confirmed, or surely not; 1 at most when it is sure.

    Clause 8.2 asks for end points to δ/5. That is more than needed where the difference d is far from δ.
    """
    if claim.coverage.low is None or claim.coverage.high is None or not isfinite(claim.reference):
        return 0.0
    delta = tolerance(claim.u, digits)
    doubled = scatter(batches)
    factors = []
    for end, column in ((claim.coverage.low, LOW), (claim.coverage.high, HIGH)):
        gap = abs(abs(end - float(batches[:, column].mean())) - delta)
        twice = float(doubled[column])
        if not isfinite(twice):
            return 0.0
        sure = (SURE / 2 * twice / gap) ** 2 if gap else inf
        if sure <= 1 and abs(end - float(batches[:, column].mean())) > delta:
            return 0.0
        factors.append(min(sure, (5 * twice / delta) ** 2))
    return max(factors)
