"""Attained coverage of the main results, where their tests can be made again by simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from metrology.gum.attained import attained
from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.chain.standing import Standing
    from metrology.findings import Result
    from metrology.gum.attained import Attained
    from metrology.gum.evaluation import Evaluation

SIMULATED = frozenset({"elongation", "decay"})
"""Methods whose results follow from readings by sums and means. The fits of the others are not made again: draws by the
covariance of a fit would only repeat what it says of itself."""


def coverage(campaign: Campaign, plan: Plan, evaluation: Evaluation, stands: Standing) -> Mapping[str, Attained]:
    """Attained coverage by the name of the result: of the main ones, and of the parameters of fits."""
    wanted = {
        name: estimate.monte_carlo.law_valid
        for name, estimate in evaluation.estimates.items()
        if (plan.identities[name].headline or plan.identities[name].test in campaign.fits)
        and all(campaign.tests[test].method in SIMULATED for test in stands.tests[name])
        and estimate.output is not None
    }
    return attained(
        plan.measurands, plan.knowledge, wanted, probability=campaign.coverage_probability, seed=campaign.seed
    )


def too_narrow(results: Sequence[Result], probability: float) -> Iterator[str]:
    """Say of each interval that held too seldom what it should hold."""
    for result in results:
        if result.attained is not None and result.attained.is_short_of(probability):
            yield said(
                "{name}: the {percent:g} % interval is too narrow: it held the value that {count} simulated "
                "repetitions of the test were drawn with in only {share:.0f} %.",
                name=result.name,
                percent=100 * probability,
                count=result.attained.repetitions,
                share=100 * result.attained.share,
            )
