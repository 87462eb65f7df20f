"""Probability that a quantity lies within its limits, given the result and what was known before (JCGM 106:2012)."""

from __future__ import annotations

from metrology.errors import Fault, MetrologyError
from metrology.gum.output import Output
from metrology.gum.risk import Limits, Prior


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
    >>> from metrology.gum.output import Analytic
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
        got = f"a result of {output.value:.6g} in SI units, where the prior has no probability"
        fix = "correct the one that is wrong: the prior, the limits or the readings"
        raise MetrologyError(Fault("prior", got, "a prior that allows the result", fix))
    return inside / (inside + outside), outside / (inside + outside)


def probability_outside(output: Output, limits: Limits, prior: Prior | None, value: float) -> float:
    """Probability that the quantity lies outside the limits, had the result this value."""
    return _conforming(output, limits, prior, value - output.value)[1]
