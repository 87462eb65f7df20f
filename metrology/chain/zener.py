"""What a response test finds as relaxation, beside what a held elongation of the same sample shows."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import isfinite, log
from typing import TYPE_CHECKING

import numpy as np

from metrology.chain.across import correlation, loading
from metrology.message import said
from metrology.method import Relaxing

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.gum.evaluation import Evaluation


def pairs(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Iterator[tuple[Relaxing, Relaxing]]:
    """Each relaxing branch with the relaxation of its sample that is nearest in ln τ, by each held elongation.

    Where the record of this does not resolve such a time, there is nothing to compare: a sentence says so.
    """
    held = [(test.id, known) for test in plan.tests
            if (known := loading(campaign, plan, evaluation, test.id)).resolved is not None]  # fmt: skip
    for test in plan.tests:
        for element, (name, known) in product(_elements(evaluation, test.id), held):
            if campaign.tests[name].sample != campaign.tests[test.id].sample:
                continue
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


def _elements(evaluation: Evaluation, test: str) -> Iterator[Relaxing]:
    """Time, and part k_i/(k + Σ k_j over τ_j ≥ τ_i), of each relaxing branch of a test's model."""
    known = evaluation.estimates
    words = {
        "zener": said("Zener element of {test}", test=test),
        "second_branch": said("second relaxing branch of {test}", test=test),
    }
    found = [name for name in words if {f"{test}.{name}.stiffness", f"{test}.{name}.time"} <= known.keys()]
    names = [f"{test}.k", *(f"{test}.{name}.stiffness" for name in found)]
    if not found or names[0] not in known:
        return
    k, u = np.array([known[name].reported for name in names]).T
    if not (np.isfinite(u).all() and (k > 0).all()):
        return
    r = np.array([[1.0 if a == b else correlation(evaluation, a, b) for b in names] for a in names])
    times = [known[f"{test}.{name}.time"].reported for name in found]
    for at, (name, (time, u_time)) in enumerate(zip(found, times, strict=True), start=1):
        # As of a hold: what is faster has relaxed, and is no part of the stiffness that is left.
        left = np.array([True, *(other >= time for other, _ in times)])
        total = float(k[left].sum())
        slope = u * left * ((np.arange(len(k)) == at) / total - k[at] / total**2)
        if isfinite(u_time) and time > 0:
            part, u_part = float(k[at]) / total, max(float(slope @ r @ slope), 0.0) ** 0.5
            yield Relaxing(words[name], time, u_time, part, u_part)
