"""Conformity with limits: probability, guard band, verdict, risk of being wrong (JCGM 106:2012, ILAC-G8:09/2019)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Literal

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.output import Analytic, Empirical, Output, probability, reach
from metrology.gum.risk import Limits, Prior, global_guard_band, global_risks
from metrology.message import said

__all__ = ["Analytic", "Decision", "Empirical", "Limits", "Prior", "Rule", "decide", "global_risks",
           "probability_of_conformity", "rule_risk"]  # fmt: skip

Verdict = Literal["pass", "conditional pass", "conditional fail", "fail"]
WIDTHS = {
    "guard band": "w = {factor:g}·U",
    "guard band by k": "w = {factor:g}·{k:g}·u",
    "specific risk": "w for a specific risk of {risk:g}",
    "global risk": "w for a global risk of {risk:g}",
}
"""Kind of rule → how wide its guard band is."""
Bands = tuple[float, float]
"""Widths of the guard bands at the lower and at the upper limit."""
_PLACES = 201
"""Results between two limits of which the one with the least risk is sought, where the distribution is skewed."""


@dataclass(frozen=True)
class Rule:
    """How measurement uncertainty is taken into account in the decision (ISO/IEC 17025:2017, 3.7).

    Parameters
    ----------
    kind : {"simple acceptance", "guard band", "specific risk", "global risk"}
        Simple acceptance: w = 0 (ILAC-G8 4.2.1). Guard band: w = factor·U. Specific risk: w such that a result on the
        acceptance limit is wrongly accepted with probability `risk`. Global risk: w such that items of the prior are
        wrongly accepted with probability `risk`.
    factor : float
        w / U of the guard band; 1 in ILAC-G8 and ISO 14253-1.
    risk : float
        Between 0 and 0.5.
    binary : bool
        Whether there is only pass and fail (ILAC-G8 4.2.2); else a result inside the guard band passes or fails
        conditionally (4.2.3).
    coverage_factor : float
        k of U = k·u; by the t distribution for `probability` where None.
    probability : float
        Coverage probability of U.
    """

    kind: Literal["simple acceptance", "guard band", "specific risk", "global risk"] = "guard band"
    factor: float = 1.0
    risk: float = 0.025
    binary: bool = False
    coverage_factor: float | None = None
    probability: float = 0.95

    @property
    def text(self) -> str:
        """The rule in words."""
        if self.kind == "simple acceptance":
            return said("simple acceptance (w = 0)")
        kinds = said("pass or fail" if self.binary else "pass, conditional pass, conditional fail or fail")
        # U of a k of its own is not the U that the report prints of the result.
        kind = "guard band by k" if self.kind == "guard band" and self.coverage_factor is not None else self.kind
        k = float(self.coverage_factor or 0.0)
        width = said(WIDTHS[kind], factor=float(self.factor), risk=float(self.risk), k=k)
        return said("guard band, {width}; {verdicts}", width=width, verdicts=kinds)


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
        Limits of the results that pass, lower + w and upper − w.
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


def rule_risk(rule: Rule, output: Output, limits: Limits | None = None, prior: Prior | None = None) -> float | None:
    """Return the largest specific risk of a wrong pass that a rule allows; None for a global risk, which bounds none.

    It is that of a result of this distribution on one acceptance limit: a half without a guard band where the
    distribution is symmetric and the other limit far (ILAC-G8 4.2). What lies beyond the other limit counts as well.

    Parameters
    ----------
    rule : Rule
        Decision rule.
    output : Output
        Distribution of the result.
    limits : Limits, optional
        Tolerance limits; without them, or where no result could pass, the risk is that of one limit alone.
    prior : Prior, optional
        What is known of such items before the measurement.

    Returns
    -------
    float or None
        Probability, 0 to 1.

    Notes
    -----
    ILAC-G8:09/2019 4.2; JCGM 106:2012 8.3.

    Examples
    --------
    >>> round(rule_risk(Rule("guard band", coverage_factor=2.0), Analytic(0.0, 1.0)), 4)
    0.0228
    """
    if rule.kind == "global risk":
        return None
    if rule.kind == "specific risk":
        return rule.risk
    if output.u == 0:
        return 0.0
    bands = _bands(output, Limits(output.value, output.value), rule, None)
    assert bands is not None
    if limits is None or (accepted := limits.shrunk(*bands)).empty:
        return float(max(output.below(output.value - bands[0]), output.above(output.value + bands[1])))
    edges = [edge for edge in (accepted.lower, accepted.upper) if edge is not None]
    # A result that lies inside may be wrong more often than one on the edge: under a prior, or of a density with a dip.
    places = [*edges, output.value] if accepted.holds(output.value) else edges
    # A result where the prior has no probability is none that could pass.
    met = [at for at in places if prior is None or sum(output.posterior(prior, limits, at - output.value)) > 0]
    return float(max((_outside(output, limits, prior, at) for at in met), default=0.0))


def probability_of_conformity(output: Output, limits: Limits, prior: Prior | None = None) -> tuple[float, float]:
    """Probability that the true value lies within the limits, and that it does not.

    p_c = ∫ g(η) dη between the limits. Where a prior is stated g is the posterior, ∝ prior · likelihood; what was known
    of the items before the measurement counts then (JCGM 106:2012, 6.2).

    Parameters
    ----------
    output : Output
        What the measurement says; the likelihood where there is a prior.
    limits : Limits
    prior : Prior, optional

    Notes
    -----
    JCGM 106:2012, 7.2 to 7.4.

    Examples
    --------
    >>> p, _ = probability_of_conformity(Analytic(13.6, 1.8), Limits(12.5, 16.3))
    >>> round(p, 2)
    0.66
    """
    return _conforming(output, limits, prior, 0.0)


def _conforming(output: Output, limits: Limits, prior: Prior | None, shift: float) -> tuple[float, float]:
    """`probability_of_conformity` of a result that lies by `shift` beside the one that was found."""
    if output.u == 0:
        inside = limits.holds(output.value + shift)
        return float(inside), float(not inside)
    if prior is not None:
        return _posterior(output, limits, prior, shift)
    below = 0.0 if limits.lower is None else output.below(limits.lower - shift)
    above = 0.0 if limits.upper is None else output.above(limits.upper - shift)
    # In the tail the complement would lose its digits.
    if below > 0.5 and limits.lower is not None:
        over = 0.0 if limits.upper is None else above
        return max(output.above(limits.lower - shift) - over, 0.0), min(below + above, 1.0)
    if above > 0.5 and limits.upper is not None:
        return max(output.below(limits.upper - shift) - below, 0.0), min(below + above, 1.0)
    return max(1.0 - (below + above), 0.0), min(below + above, 1.0)


def _posterior(output: Output, limits: Limits, prior: Prior, shift: float) -> tuple[float, float]:
    inside, outside = output.posterior(prior, limits, shift)
    if not inside + outside > 0:
        got, expected = "a result where the prior has no probability", "a prior that allows the result"
        raise MetrologyError(Fault("prior", got, expected, "look at both"))
    return inside / (inside + outside), outside / (inside + outside)


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
    bands = _bands(output, limits, rule, prior)
    accepted = Limits(0.0, -1.0) if bands is None else limits.shrunk(*bands)
    verdict: Verdict = _verdict(output.value, limits, bands, binary=rule.binary)
    inside, outside = probability_of_conformity(output, limits, prior)
    consumer, producer = (None, None)
    if prior is not None and not accepted.empty and isfinite(output.u):
        consumer, producer = global_risks(prior, output, limits=limits, acceptance=accepted)
    decision = Decision(
        verdict=verdict,
        probability=inside,
        specific_risk=outside if verdict in ("pass", "conditional pass") else inside,
        guard_band=limits.half_width if bands is None else _widest(bands, limits),
        resolution=output.resolution,
        acceptance_lower=None if bands is None else accepted.lower,
        acceptance_upper=None if bands is None else accepted.upper,
        global_consumer_risk=consumer,
        global_producer_risk=producer,
        rule=rule.text,
        sentence="",
    )
    return replace(decision, sentence=_sentence(decision, output, accepted, rule))


def _widest(bands: Bands, limits: Limits) -> float:
    """Guard band as one number: the wider one of the limits that there are."""
    lower, upper = bands
    return max(lower if limits.lower is not None else 0.0, upper if limits.upper is not None else 0.0)


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


def _bands(output: Output, limits: Limits, rule: Rule, prior: Prior | None) -> Bands | None:
    """Widths of the guard bands at the lower and the upper limit; None where none keeps the stated risk."""
    if rule.kind == "simple acceptance" or output.u == 0:
        return 0.0, 0.0
    if rule.kind == "guard band":
        if rule.coverage_factor is not None:
            return (rule.factor * rule.coverage_factor * output.u,) * 2
        # Towards a lower limit counts how far the interval reaches below the result, towards an upper one above it.
        below, above = reach(output, rule.probability)
        return rule.factor * below, rule.factor * above
    if not _shows(output, rule.risk):
        return None
    if rule.kind == "global risk" and prior is not None:
        return (global_guard_band(prior, output, limits=limits, risk=rule.risk),) * 2
    return _specific_bands(output, limits, rule.risk, prior)


def _shows(output: Output, risk: float) -> bool:
    """Whether a risk can be told from none: by draws one that would show in some of them."""
    return risk >= output.resolution


def _specific_bands(output: Output, limits: Limits, risk: float, prior: Prior | None) -> Bands | None:
    """Distances from the limits at which the probability to lie outside both falls to the stated risk."""
    safest = _safest(output, limits, risk, prior)
    if safest is not None and _outside(output, limits, prior, safest) > risk:
        return None
    return tuple(  # type: ignore[return-value]
        0.0 if limit is None else _specific_band(output, limits, risk, prior, edge=(limit, sign), safest=safest)
        for limit, sign in ((limits.lower, 1.0), (limits.upper, -1.0))
    )


def _safest(output: Output, limits: Limits, risk: float, prior: Prior | None) -> float | None:
    """Result that lies outside both limits with the least probability; None with one limit.

    It is the middle between them where the distribution is symmetric, and taken as that where it keeps the risk.
    """
    if limits.lower is None or limits.upper is None:
        return None
    middle = (limits.lower + limits.upper) / 2
    if _outside(output, limits, prior, middle) <= risk:
        return middle
    places = [limits.lower + share * (limits.upper - limits.lower) for share in np.linspace(0.0, 1.0, _PLACES)]
    return float(min([middle, *places], key=lambda value: _outside(output, limits, prior, value)))


def _outside(output: Output, limits: Limits, prior: Prior | None, value: float) -> float:
    """Probability that the quantity lies outside the limits, had the result this value."""
    return _conforming(output, limits, prior, value - output.value)[1]


def _specific_band(
    output: Output, limits: Limits, risk: float, prior: Prior | None, *, edge: tuple[float, float], safest: float | None
) -> float:
    from scipy.optimize import brentq

    limit, sign = edge

    def excess(w: float) -> float:
        return _outside(output, limits, prior, limit + sign * w) - risk

    if excess(0.0) <= 0:
        return 0.0
    if safest is None:
        low, high = output.quantile(risk), output.quantile(1 - risk)
        widest = max(high - output.value, output.value - low, 1e-12 * (high - low))
        while excess(widest) > 0:
            widest *= 2.0
    else:
        widest = abs(safest - limit)
    scale = output.quantile(0.75) - output.quantile(0.25)
    return float(brentq(excess, 0.0, widest, xtol=1e-13 * scale, rtol=1e-14))


def _verdict(value: float, limits: Limits, bands: Bands | None, *, binary: bool) -> Verdict:
    inside = limits.holds(value)
    if bands is not None and limits.shrunk(*bands).holds(value):
        return "pass"
    if binary:
        return "fail"
    if inside:
        return "conditional pass"
    outwards = None if bands is None else limits.shrunk(*(-w for w in bands))
    return "conditional fail" if outwards is not None and outwards.holds(value) else "fail"


def _sentence(decision: Decision, output: Output, accepted: Limits, rule: Rule) -> str:
    size = "0" if output.u == 0 else probability(decision.specific_risk, output.resolution)
    sentences = [said(WORDS[decision.verdict], risk=size)]
    if output.resolution > 0:
        text = "The probabilities are those of the Monte Carlo draws: the GUM framework is not confirmed here."
        sentences.append(said(text))
    if rule.kind in ("specific risk", "global risk") and output.u > 0 and not _shows(output, rule.risk):
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
        sentences.append(said("No uncertainty is stated, so the decision takes the value as exact."))
    return said("{texts:space}", texts=tuple(sentences)) if len(sentences) > 1 else sentences[0]


WORDS = {
    "pass": "The result lies within the acceptance limits; the probability that it is not conforming all the same is "
    "{risk:figures}.",
    "conditional pass": "The result lies within the limits, but no further inside than the guard band; the probability "
    "that it is not conforming all the same is {risk:figures}.",
    "conditional fail": "The result lies outside the limits, but no further than the guard band; the probability that "
    "it is conforming all the same is {risk:figures}.",
    "fail": "The result lies outside the acceptance limits; the probability that it is conforming all the same is "
    "{risk:figures}.",
}
