"""Conformity with limits: the verdict on a requirement and its risk of being wrong (JCGM 106:2012, ILAC-G8:09/2019)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Literal

from metrology.errors import Fault, MetrologyError
from metrology.gum.conformity_probability import probability_of_conformity
from metrology.gum.guard_bands import Bands, Rule, guard_bands, shows, widest
from metrology.gum.output import Output
from metrology.gum.printed_probability import probability
from metrology.gum.risk import Limits, Prior, global_risks
from metrology.message import said

Verdict = Literal["pass", "conditional pass", "conditional fail", "fail"]


@dataclass(frozen=True)
class Decision:
    """A decision on conformity.

    Parameters
    ----------
    verdict : {"pass", "conditional pass", "conditional fail", "fail"}
    probability : float
        That the true value lies within the limits, given the result.
    specific_risk : float
        That the decision on this item is wrong: 1 − `probability` for a (conditional) pass, else `probability`.
    guard_band : float
        w, in the unit of the result.
    acceptance_lower, acceptance_upper : float
        Limits of the results that pass, lower + w and upper − w; None where the two cross, so that none passes.
    global_consumer_risk, global_producer_risk : float
        That an item of the prior is wrongly accepted, wrongly rejected, by these acceptance limits; else None.
    resolution : float
        Smallest probability that is told from zero; 0 where there is no limit.
    rule, sentence : str
    """

    verdict: Verdict
    probability: float
    specific_risk: float
    guard_band: float
    acceptance_lower: float | None
    acceptance_upper: float | None
    global_consumer_risk: float | None
    global_producer_risk: float | None
    resolution: float
    rule: str
    sentence: str


def decide(output: Output, *, limits: Limits, rule: Rule, prior: Prior | None = None) -> Decision:
    """Verdict on a requirement, with the risks that it carries, all from the one distribution of the result.

    Parameters
    ----------
    output : Output
        Distribution of the result.
    limits : Limits
        Tolerance limits, one or both, in the unit of the result.
    rule : Rule
        Simple acceptance, guard band, or a bound on a risk.
    prior : Prior, optional
        What is known of such items before the measurement; for the posterior probability and the global risks.

    Returns
    -------
    Decision
        Verdict, probability of conformity, risks, acceptance limits, and a sentence.

    Raises
    ------
    MetrologyError
        For numbers that are not finite, u < 0, a rule that does not make sense, a global risk without a prior.

    Notes
    -----
    JCGM 106:2012 clauses 7 to 9; ILAC-G8:09/2019, 4.2.
    """
    _check(output, limits, rule, prior)
    bands = guard_bands(output, limits, rule, prior)
    accepted = Limits(0.0, -1.0) if bands is None else limits.shrunk(*bands)
    inside, outside = probability_of_conformity(output, limits, prior)
    verdict: Verdict = _verdict(output.value, limits, bands, rule, conforming=inside)
    consumer, producer = (None, None)
    if prior is not None and not accepted.empty and isfinite(output.u):
        consumer, producer = global_risks(prior, output, limits=limits, acceptance=accepted)
    decision = Decision(
        verdict=verdict,
        probability=inside,
        specific_risk=outside if verdict in ("pass", "conditional pass") else inside,
        guard_band=limits.half_width if bands is None else widest(bands, limits),
        resolution=output.resolution,
        acceptance_lower=None if accepted.empty else accepted.lower,
        acceptance_upper=None if accepted.empty else accepted.upper,
        global_consumer_risk=consumer,
        global_producer_risk=producer,
        rule=rule.text,
        sentence="",
    )
    return replace(decision, sentence=_sentence(decision, output, accepted, rule))


def _check(output: Output, limits: Limits, rule: Rule, prior: Prior | None) -> None:
    u = output.u
    tests = [
        (not limits.empty, "limits", f"{limits.lower} to {limits.upper}", "a lower limit below the upper one"),
        (isfinite(output.value), "value", f"{output.value}", "a finite number"),
        (u >= 0 and (isfinite(u) or output.resolution > 0), "u", f"{u}", "a standard uncertainty, not below zero"),
        (output.dof > 0, "dof", f"{output.dof}", "degrees of freedom above zero"),
        (isfinite(rule.factor) and rule.factor >= 0, "rule.factor", f"{rule.factor}", "a factor of U, not below zero"),
        (0 < rule.risk <= 0.5, "rule.risk", f"{rule.risk}", "a probability above 0 and up to 0.5"),
        (0 < rule.probability < 1, "rule.probability", f"{rule.probability}", "a probability between 0 and 1"),
        (
            rule.coverage_factor is None or 0 < rule.coverage_factor < inf,
            "rule.coverage_factor",
            f"{rule.coverage_factor}",
            "k > 0",
        ),
        (rule.kind != "global risk" or prior is not None, "prior", "none", "a prior, which a global risk needs"),
    ]
    faults = [Fault(where, got, expected) for met, where, got, expected in tests if not met]
    if faults:
        raise MetrologyError(*faults)


def _verdict(value: float, limits: Limits, bands: Bands | None, rule: Rule, *, conforming: float) -> Verdict:
    if bands is not None and limits.shrunk(*bands).holds(value):
        return "pass"
    if rule.binary:
        return "fail"
    if limits.holds(value):
        return "conditional pass"
    if rule.kind == "specific risk":
        return "conditional fail" if conforming > rule.risk else "fail"
    # What fails a lower limit is how far the interval reaches above the result, an upper one how far below it.
    outwards = None if bands is None else limits.shrunk(-bands[1], -bands[0])
    return "conditional fail" if outwards is not None and outwards.holds(value) else "fail"


def _sentence(decision: Decision, output: Output, accepted: Limits, rule: Rule) -> str:
    size = "0" if output.u == 0 else probability(decision.specific_risk, output.resolution)
    sentences = [said(WORDS[decision.verdict], risk=size)]
    if output.resolution > 0:
        text = "The probabilities are those of the Monte Carlo draws: the GUM framework is not confirmed here."
        sentences.append(said(text))
    if rule.kind in ("specific risk", "global risk") and output.u > 0 and not shows(output, rule.risk):
        text = (
            "The draws cannot show the agreed risk of {risk:figures}: none of them beyond a limit shows a risk "
            "{least:figures}. No result passes without condition; more trials (max_trials) may decide it."
        )
        least = probability(0.0, output.resolution)
        sentences.append(said(text, risk=probability(rule.risk), least=least))
    elif accepted.empty:
        text = "The uncertainty is too large for these limits: no result would pass without condition."
        sentences.append(said(text))
    if output.u == 0:
        sentences.append(said("The result has no uncertainty, so the decision takes the value as exact."))
    return said("{texts:space}", texts=tuple(sentences)) if len(sentences) > 1 else sentences[0]


WORDS = {
    "pass": "The result lies within the acceptance limits; the probability that it is not conforming all the same is "
    "{risk:figures}.",
    "conditional pass": "The result lies within the limits, but no further inside than the guard band; the probability "
    "that it is not conforming all the same is {risk:figures}.",
    "conditional fail": "The result lies outside the limits, but not as far as the rule asks of a fail; the "
    "probability that it is conforming all the same is {risk:figures}.",
    "fail": "The result lies outside the acceptance limits; the probability that it is conforming all the same is "
    "{risk:figures}.",
}
