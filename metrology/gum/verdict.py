"""Judging the law of propagation by Monte Carlo (JCGM 101:2008, clause 8)."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite, isinf, nan

from metrology.gum.evaluation import MonteCarlo
from metrology.gum.inputs import Floats
from metrology.gum.intervals import intervals
from metrology.gum.monte_carlo import (
    HIGH,
    LOW,
    SHORTEST_LOW,
    Plan,
    Trials,
    histogram,
    moments,
    scatter,
)
from metrology.gum.rounding import readable, tolerance
from metrology.gum.sufficiency import SURE, Claim, boundless, certainty, choice, stability
from metrology.message import said


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
    steady = stability(claim, batches, plan.digits) <= 1
    if not valid and batches.shape[1] > SHORTEST_LOW:
        steady = steady and choice(claim, batches, found, plan.digits) <= 1
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
    sure = certainty(claim, batches, plan.digits) <= 1
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
    sure = SURE / 2
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
        return said("The uncertainty is zero by the GUM uncertainty framework and by Monte Carlo.")
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
