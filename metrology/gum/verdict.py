"""Judging the law of propagation by Monte Carlo (JCGM 101:2008, clause 8), and when there are trials enough for it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite, isinf, nan
from statistics import median

from metrology.gum.distributions import MeanSquare, Student
from metrology.gum.evaluation import Coverage, MonteCarlo
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
    histogram,
    moments,
    scatter,
)
from metrology.gum.rounding import readable, tolerance
from metrology.message import said

_SURE = 3.0


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
        """The law's u where it can serve as the measure of δ, else NaN."""
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
        max(_stability(claim, batches[:, row], digits), _certainty(claim, batches[:, row], digits))
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
            _choice(claim, trials.batches[:, row], intervals(trials.outputs[row].copy(), plan.probability), plan.digits)
            for row, claim in enumerate(claims)
            if not trials.invalid[row] and _contradicted(claim, trials.batches[:, row], plan.digits)
        ),
        default=0.0,
    )


def _contradicted(claim: Claim, batches: Floats, digits: int) -> bool:
    """Whether an end of the law's interval lies beyond δ, so that an interval of the draws is the one to report."""
    if claim.coverage.low is None or claim.coverage.high is None or not isfinite(claim.reference):
        return True
    low, high = float(batches[:, LOW].mean()), float(batches[:, HIGH].mean())
    return max(abs(claim.coverage.low - low), abs(claim.coverage.high - high)) > tolerance(claim.u, digits)


def _choice(claim: Claim, batches: Floats, found: Intervals, digits: int) -> float:
    """(2s/gap)² for the choice between the intervals, and (2s/δ)² for the ends of the shortest one where it is chosen.

    The stability of the ends of the symmetric one is in `_stability`. 0 where nothing scatters.
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


def _stability(claim: Claim, batches: Floats, digits: int) -> float:
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


def _certainty(claim: Claim, batches: Floats, digits: int) -> float:
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
        sure = (_SURE / 2 * twice / gap) ** 2 if gap else inf
        if sure <= 1 and abs(end - float(batches[:, column].mean())) > delta:
            return 0.0
        factors.append(min(sure, (5 * twice / delta) ** 2))
    return max(factors)


def judge(claim: Claim, trials: Trials, row: int, plan: Plan) -> MonteCarlo:
    """Monte Carlo result of one output with the verdict on the law; the draws are left in another order.

    The law holds where both ends of its interval lie within δ of those of the symmetric Monte Carlo interval. Where the
    trials allowed are too few to tell a difference from δ, it stands uncontradicted as long as it agrees to one digit,
    and the verdict says so: an exact law with few degrees of freedom would otherwise fail by chance.

    Source: JCGM 101:2008 8.1.
    """
    if trials.invalid[row]:
        return _invalid(claim, trials, row, plan)
    batches, values = trials.batches[:, row], trials.outputs[row]
    mean, u = moments(batches, plan.block)
    edges, density = histogram(values, plan.probability)
    found = intervals(values, plan.probability)
    if isfinite(claim.heavy):
        mean, u = (mean, inf) if claim.heavy > 1 else (nan, inf)
    elif boundless(batches):
        mean, u = nan, inf
    delta = _tolerance(claim.reference if claim.reference > 0 else u, plan.digits)
    d_low, d_high = _distance(claim.coverage.low, found.low), _distance(claim.coverage.high, found.high)
    valid = d_low is not None and d_high is not None and _holds(d_low, d_high, batches, delta, claim.reference)
    steady = _stability(claim, batches, plan.digits) <= 1
    if not valid and batches.shape[1] > SHORTEST_LOW:
        steady = steady and _choice(claim, batches, found, plan.digits) <= 1
    result = MonteCarlo(
        mean=mean,
        u=u if u > abs(claim.value) * 1e-15 else 0.0,
        low=found.low,
        high=found.high,
        shortest_low=found.shortest_low,
        shortest_high=found.shortest_high,
        p=plan.probability,
        trials=trials.number,
        converged=steady,
        law_valid=valid,
        verdict="",
        tolerance=delta,
        d_low=d_low,
        d_high=d_high,
        edges=edges,
        density=density,
        reported=found.kind,
    )
    sure = _certainty(claim, batches, plan.digits) <= 1
    return replace(result, verdict=_sentences(claim, result, sure))


def _tolerance(u: float, digits: int) -> float:
    """δ for an u; 0 where nothing scatters, NaN where the standard deviation does not exist."""
    if not isfinite(u):
        return nan
    return tolerance(u, digits) if u > 0 else 0.0


def _holds(d_low: float, d_high: float, batches: Floats, delta: float, u: float) -> bool:
    most = max(d_low, d_high)
    if most <= delta or not u > 0:
        return most <= delta
    doubled = scatter(batches)
    sure = _SURE / 2
    contradicted = d_low - delta > sure * doubled[LOW] or d_high - delta > sure * doubled[HIGH]
    return not contradicted and most <= tolerance(u, 1)


def _distance(end: float | None, found: float) -> float | None:
    return None if end is None else abs(end - found)


def _sentences(claim: Claim, result: MonteCarlo, sure: bool) -> str:
    sentences = [_judgement(claim, result)]
    if claim.reference > 0 and result.d_low is not None and not sure:
        text = "The scatter of {trials} trials makes this verdict inconclusive; more trials may decide it."
        sentences.append(said(text, trials=result.trials))
    if isfinite(claim.heavy):
        text = (
            "Readings with ν = {dof:g} enter, for which the standard deviation of the draws does not exist (JCGM 101, "
            "6.4.9.4); the intervals do."
        )
        sentences.append(said(text, dof=float(claim.heavy)))
    elif isinf(result.u):
        stable = "The draws have no stable standard deviation; their median and intervals are stable."
        sentences.append(said(stable if result.converged else "The draws have no stable standard deviation."))
    if not result.converged:
        text = "After {trials} trials the Monte Carlo figures are not stable to the digits asked for."
        sentences.append(said(text, trials=result.trials))
    return said("{texts:space}", texts=tuple(sentences)) if len(sentences) > 1 else sentences[0]


def _judgement(claim: Claim, result: MonteCarlo) -> str:
    if claim.failure:
        text = "The GUM uncertainty framework fails: {failure} The Monte Carlo result stands alone."
        return said(text, failure=claim.failure)
    if result.u == 0:
        return said("Nothing uncertain enters: u = 0 by the GUM uncertainty framework and by Monte Carlo.")
    if claim.u <= (1e-9 * result.u if isfinite(result.u) else 0.0):
        return said(
            "The GUM uncertainty framework is not valid here: every sensitivity is zero at the estimates, so its "
            "first order gives u = 0, while the draws scatter. The Monte Carlo result holds."
        )
    if result.d_low is None or result.d_high is None:
        text = "The GUM uncertainty framework gives no interval to compare; degrees of freedom are {note}."
        return said(text, note=claim.note)
    most = max(result.d_low, result.d_high) / result.tolerance
    kind = "not contradicted" if most > 1 else "confirmed"
    return said(
        JUDGED[kind if result.law_valid else "not confirmed"],
        low=readable(result.d_low, claim.unit),
        high=readable(result.d_high, claim.unit),
        tolerance=readable(result.tolerance, claim.unit, 1),
        times=float(most),
        trials=result.trials,
    )


JUDGED = {
    "confirmed": "The GUM uncertainty framework is confirmed: its interval differs from the Monte Carlo one by "
    "{low:figures} below and {high:figures} above, within the tolerance δ = {tolerance:figures} (JCGM 101, clause 8).",
    "not contradicted": "The GUM uncertainty framework is not contradicted: its interval differs from the Monte Carlo "
    "one by {low:figures} below and {high:figures} above, which {trials} trials cannot tell from the tolerance δ = "
    "{tolerance:figures} (JCGM 101, clause 8).",
    "not confirmed": "The GUM uncertainty framework is not confirmed: its interval differs from the Monte Carlo one by "
    "{low:figures} below and {high:figures} above, up to {times:.2g} times the tolerance δ = {tolerance:figures} (JCGM "
    "101, clause 8). The Monte Carlo interval holds.",
}


def _invalid(claim: Claim, trials: Trials, row: int, plan: Plan) -> MonteCarlo:
    verdict = said(
        "{invalid} of {trials} trials gave no finite number: the equation has no value over the whole range of its "
        "inputs. A distribution that leaves out impossible values, or a smaller uncertainty of the input in a "
        "denominator, root or logarithm, may fix it. There is no Monte Carlo result, and the law is not confirmed.",
        invalid=int(trials.invalid[row]),
        trials=trials.number,
    )
    if claim.failure:
        verdict = said("{texts:space}", texts=(claim.failure, verdict))
    return MonteCarlo(*(nan,) * 6, plan.probability, trials.number, False, False, verdict, nan, None, None, (nan,), ())
