"""Decision rules and the guard bands that they set (JCGM 106:2012; ILAC-G8:09/2019)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from metrology.gum.conformity_probability import probability_outside
from metrology.gum.output import Output, reach
from metrology.gum.risk import Limits, Prior, global_guard_band
from metrology.message import said

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
    >>> from metrology.gum.output import Analytic
    >>> round(rule_risk(Rule("guard band", coverage_factor=2.0), Analytic(0.0, 1.0)), 4)
    0.0228
    """
    if rule.kind == "global risk":
        return None
    if rule.kind == "specific risk":
        return rule.risk
    if output.u == 0:
        return 0.0
    bands = guard_bands(output, Limits(output.value, output.value), rule, None)
    assert bands is not None
    if limits is None or (accepted := limits.shrunk(*bands)).empty:
        return float(max(output.below(output.value - bands[0]), output.above(output.value + bands[1])))
    edges = [edge for edge in (accepted.lower, accepted.upper) if edge is not None]
    # A result that lies inside may be wrong more often than one on the edge: under a prior, or of a density with a dip.
    places = [*edges, output.value] if accepted.holds(output.value) else edges
    # A result where the prior has no probability is none that could pass.
    met = [at for at in places if prior is None or sum(output.posterior(prior, limits, at - output.value)) > 0]
    return float(max((probability_outside(output, limits, prior, at) for at in met), default=0.0))


def widest(bands: Bands, limits: Limits) -> float:
    """Guard band as one number: the wider one of the limits that there are."""
    lower, upper = bands
    return max(lower if limits.lower is not None else 0.0, upper if limits.upper is not None else 0.0)


def guard_bands(output: Output, limits: Limits, rule: Rule, prior: Prior | None) -> Bands | None:
    """Widths of the guard bands at the lower and the upper limit; None where none keeps the stated risk."""
    if rule.kind == "simple acceptance" or output.u == 0:
        return 0.0, 0.0
    if rule.kind == "guard band":
        if rule.coverage_factor is not None:
            return (rule.factor * rule.coverage_factor * output.u,) * 2
        # Towards a lower limit counts how far the interval reaches below the result, towards an upper one above it.
        below, above = reach(output, rule.probability)
        return rule.factor * below, rule.factor * above
    if not shows(output, rule.risk):
        return None
    if rule.kind == "global risk" and prior is not None:
        return (global_guard_band(prior, output, limits=limits, risk=rule.risk),) * 2
    return _specific_bands(output, limits, rule.risk, prior)


def shows(output: Output, risk: float) -> bool:
    """Whether a risk can be told from none: by draws one that would show in some of them."""
    return risk >= output.resolution


def _specific_bands(output: Output, limits: Limits, risk: float, prior: Prior | None) -> Bands | None:
    """Distances from the limits at which the probability to lie outside both falls to the stated risk."""
    safest = _safest(output, limits, risk, prior)
    if safest is not None and probability_outside(output, limits, prior, safest) > risk:
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
    if probability_outside(output, limits, prior, middle) <= risk:
        return middle
    places = [limits.lower + share * (limits.upper - limits.lower) for share in np.linspace(0.0, 1.0, _PLACES)]
    return float(min([middle, *places], key=lambda value: probability_outside(output, limits, prior, value)))


def _specific_band(
    output: Output, limits: Limits, risk: float, prior: Prior | None, *, edge: tuple[float, float], safest: float | None
) -> float:
    from scipy.optimize import brentq

    limit, sign = edge

    def excess(w: float) -> float:
        return probability_outside(output, limits, prior, limit + sign * w) - risk

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
