"""Conformity with limits: probability, guard band, verdict, risk of being wrong (JCGM 106:2012, ILAC-G8:09/2019)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Literal

from metrology.errors import Fault, MetrologyError
from metrology.gum.risk import Limits, Prior, global_guard_band, global_risks, tails

__all__ = ["Decision", "Limits", "Prior", "Rule", "decide", "global_risks", "probability_of_conformity", "rule_risk"]

Verdict = Literal["pass", "conditional pass", "conditional fail", "fail"]


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
            return "simple acceptance (w = 0)"
        kinds = "pass or fail" if self.binary else "pass, conditional pass, conditional fail or fail"
        width = f"w = {self.factor:g}·U" if self.kind == "guard band" else f"w for a {self.kind} of {self.risk:g}"
        return f"guard band, {width}; {kinds}"


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
    rule: str
    sentence: str


def rule_risk(rule: Rule, dof: float = inf) -> float | None:
    """Return the largest specific risk of a wrong pass that a rule allows; None for a global risk, which bounds none.

    It is that of a result on one acceptance limit, the other being far: F(−w/u), with F as in
    `probability_of_conformity`; a half without a guard band (ILAC-G8 4.2).

    Examples
    --------
    >>> round(rule_risk(Rule("guard band", factor=1.0, coverage_factor=2.0)), 4), rule_risk(Rule("simple acceptance"))
    (0.0228, 0.5)
    """
    if rule.kind == "global risk":
        return None
    if rule.kind == "specific risk":
        return rule.risk
    if rule.kind == "simple acceptance":
        return 0.5
    k = rule.coverage_factor or _quantile((1 + rule.probability) / 2, dof)
    return float(tails(-rule.factor * k, dof))


def probability_of_conformity(value: float, u: float, *, limits: Limits, dof: float = inf) -> tuple[float, float]:
    """Probability that the true value lies within the limits, and that it does not; both exact in their tails.

    p_c = F((T_U − y)/u) − F((T_L − y)/u), with F of the normal distribution, or of Student's with `dof`.

    Parameters
    ----------
    value, u : float
        Result and standard uncertainty.
    limits : Limits
    dof : float

    Notes
    -----
    JCGM 106:2012, 7.2 to 7.4.

    Examples
    --------
    >>> p, _ = probability_of_conformity(13.6, 1.8, limits=Limits(12.5, 16.3))
    >>> round(p, 2)
    0.66
    """
    if u == 0:
        inside = limits.holds(value)
        return float(inside), float(not inside)
    below = -inf if limits.lower is None else (limits.lower - value) / u
    above = inf if limits.upper is None else (limits.upper - value) / u
    outside = tails(below, dof) + tails(-above, dof)
    inside_p = tails(-below, dof) - tails(-above, dof) if below > 0 else tails(above, dof) - tails(below, dof)
    return max(float(inside_p), 0.0), min(float(outside), 1.0)


def decide(
    value: float, u: float, *, limits: Limits, rule: Rule, dof: float = inf, prior: Prior | None = None
) -> Decision:
    """Verdict on a requirement, with the risks that it carries.

    Parameters
    ----------
    value, u : float
        Result and standard uncertainty.
    limits : Limits
        Tolerance limits, one or both.
    rule : Rule
    dof : float
        Degrees of freedom of `u`.
    prior : Prior
        What is known of such items before the measurement; for the global risks.

    Raises
    ------
    MetrologyError
        For numbers that are not finite, u < 0, a rule that does not make sense, a global risk without a prior.

    Notes
    -----
    JCGM 106:2012 clauses 7 to 9; ILAC-G8:09/2019, 4.2.
    """
    _check(value, u, limits, rule, dof, prior)
    w = _guard_band(u, limits, rule, dof, prior)
    accepted = limits.shrunk(w if w is not None else inf)
    verdict: Verdict = _verdict(value, limits, w, binary=rule.binary)
    inside, outside = probability_of_conformity(value, u, limits=limits, dof=dof)
    consumer, producer = (None, None)
    if prior is not None and w is not None and not accepted.empty:
        consumer, producer = global_risks(prior, u, limits=limits, acceptance=accepted)
    decision = Decision(
        verdict=verdict,
        probability=inside,
        specific_risk=outside if verdict in ("pass", "conditional pass") else inside,
        guard_band=w if w is not None else limits.half_width,
        acceptance_lower=None if w is None else accepted.lower,
        acceptance_upper=None if w is None else accepted.upper,
        global_consumer_risk=consumer,
        global_producer_risk=producer,
        rule=rule.text,
        sentence="",
    )
    return replace(decision, sentence=_sentence(decision, u, nothing_passes=w is None or accepted.empty))


def _check(value: float, u: float, limits: Limits, rule: Rule, dof: float, prior: Prior | None) -> None:
    tests = [
        (not limits.empty, "limits", f"{limits.lower} to {limits.upper}", "a lower limit below the upper one"),
        (isfinite(value), "value", f"{value}", "a finite number"),
        (isfinite(u) and u >= 0, "u", f"{u}", "a standard uncertainty, finite and not below zero"),
        (dof > 0, "dof", f"{dof}", "degrees of freedom above zero"),
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


def _guard_band(u: float, limits: Limits, rule: Rule, dof: float, prior: Prior | None) -> float | None:
    """Width w; None where no w keeps the stated risk."""
    if rule.kind == "simple acceptance" or u == 0:
        return 0.0
    if rule.kind == "guard band":
        return rule.factor * u * (rule.coverage_factor or _quantile((1 + rule.probability) / 2, dof))
    if rule.kind == "global risk" and prior is not None:
        return global_guard_band(prior, u, limits=limits, risk=rule.risk)
    return _specific_guard_band(u, limits, rule.risk, dof)


def _quantile(p: float, dof: float) -> float:
    from scipy.special import ndtri, stdtrit

    return float(ndtri(p) if dof == inf else stdtrit(dof, p))


def _specific_guard_band(u: float, limits: Limits, risk: float, dof: float) -> float | None:
    """Distance from a limit at which the probability to lie outside both limits falls to the stated risk."""
    one_sided = u * _quantile(1 - risk, dof)
    upper, widest = limits.upper, limits.half_width
    if upper is None or widest == inf:
        return one_sided

    def excess(w: float) -> float:
        return probability_of_conformity(upper - w, u, limits=limits, dof=dof)[1] - risk

    if excess(widest) > 0:
        return None
    if excess(one_sided) <= 0:
        return one_sided
    from scipy.optimize import brentq

    return float(brentq(excess, one_sided, widest, xtol=1e-12 * u, rtol=1e-14))


def _verdict(value: float, limits: Limits, w: float | None, *, binary: bool) -> Verdict:
    inside = limits.holds(value)
    if w is not None and limits.shrunk(w).holds(value):
        return "pass"
    if binary:
        return "fail"
    if inside:
        return "conditional pass"
    return "conditional fail" if w is not None and limits.shrunk(-w).holds(value) else "fail"


def _sentence(decision: Decision, u: float, *, nothing_passes: bool) -> str:
    where = {
        "pass": "The result lies within the acceptance limits",
        "conditional pass": "The result lies within the limits, but no further inside than the guard band",
        "conditional fail": "The result lies outside the limits, but no further than the guard band",
        "fail": "The result lies outside the acceptance limits",
    }[decision.verdict]
    passed = decision.verdict in ("pass", "conditional pass")
    risk = (
        f"the probability that it is {'not ' if passed else ''}conforming all the same is {decision.specific_risk:.2g}"
    )
    words = f"{where}; {risk}."
    if nothing_passes:
        words += " The uncertainty is too large for these limits: no result would pass without condition."
    if u == 0:
        words += " No uncertainty is stated, so the decision takes the value as exact."
    return words
