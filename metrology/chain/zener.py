"""What a response test finds as Zener relaxation, beside what a held elongation of the same sample shows."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot, isfinite, log
from typing import TYPE_CHECKING

from metrology.chain.across import correlation, loading
from metrology.message import said
from metrology.method import Relaxing

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.gum.evaluation import Evaluation


def pairs(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Iterator[tuple[Relaxing, Relaxing]]:
    """Each Zener element with the relaxation of its sample that is nearest in ln τ, by each held elongation.

    Where the record of this does not resolve such a time, there is nothing to compare: a sentence says so.
    """
    held = [(test.id, known) for test in plan.tests
            if (known := loading(campaign, plan, evaluation, test.id)).resolved is not None]  # fmt: skip
    for test in plan.tests:
        element = _element(evaluation, test.id)
        for name, known in held if element is not None else ():
            if campaign.tests[name].sample != campaign.tests[test.id].sample:
                continue
            assert element is not None
            assert known.resolved is not None
            low, high = known.resolved
            if not low <= element.time <= high:
                text = (
                    "{element} has a relaxation time of {time:.2g} s, and is not compared with {name}: its record "
                    "resolves {low:.2g} s to {high:.2g} s."
                )
                plan.warnings.append(said(text, element=element.name, time=element.time, name=name, low=low, high=high))
            elif not known.relaxing:
                text = "{element} is not compared with {name}, which has no branches."
                plan.warnings.append(said(text, element=element.name, name=name))
            else:
                yield element, min(known.relaxing, key=lambda one: abs(log(one.time / element.time)))


def _element(evaluation: Evaluation, test: str) -> Relaxing | None:
    """Time, and part k₁/(k + k₁), of the Zener element of a test's model; None where it has none that relaxes."""
    names = [f"{test}.{one}" for one in ("k", "zener.stiffness", "zener.time")]
    if any(name not in evaluation.estimates for name in names):
        return None
    (k, u_k), (k_1, u_1), (time, u_time) = (evaluation.estimates[name].reported for name in names)
    if not all(isfinite(one) for one in (k, u_k, k_1, u_1, time, u_time)) or not min(k, k_1, time) > 0:
        return None
    by_k, by_1 = -k_1 / (k + k_1) ** 2 * u_k, k / (k + k_1) ** 2 * u_1
    shared = 2 * correlation(evaluation, names[0], names[1]) * by_k * by_1
    u = max(hypot(by_k, by_1) ** 2 + shared, 0.0) ** 0.5
    return Relaxing(said("Zener element of {test}", test=test), time, u_time, k_1 / (k + k_1), u)
