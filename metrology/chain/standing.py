"""How far the data support a result: the model as stated beside the one reported, and what forbids a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING

from metrology.findings import AsStated

if TYPE_CHECKING:
    from metrology.chain.plan import Plan
    from metrology.diagnosis import Diagnosis
    from metrology.gum.evaluation import Evaluation

SAME = 1e-9
"""Relative difference below which two values are the same but for rounding."""


@dataclass(frozen=True)
class Standing:
    """What a result rests on.

    Parameters
    ----------
    stated : mapping of str to AsStated
        By result: what the model as stated gives, where the data support another one.
    tests : mapping of str to tuple of str
        By result: the tests that it depends on.
    """

    stated: Mapping[str, AsStated] = field(default_factory=dict)
    tests: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def standing(plan: Plan, evaluation: Evaluation) -> Standing:
    """Evaluate the model as stated by the law of propagation, beside the evaluation of what the data support."""
    from metrology.gum.law import propagate

    names = [test.id for test in plan.tests]
    by_test = {found.test: found for found in plan.diagnosis}
    before = copy(plan)
    for old, new in plan.corrected.values():
        before.exchange(new, old)
    law = propagate(before.measurands, before.knowledge)
    stated, tests = {}, {}
    for row, line in enumerate(law.linear):
        name, u = line.measurand.name, law.u(row)
        own = {line.measurand.name, *line.reads}
        tests[name] = tuple(test for test in names if any(one.startswith(f"{test}.") for one in own))
        after = evaluation.estimates.get(name)
        changed = [test for test in tests[name] if test in plan.corrected]
        if after is None or not changed or not isfinite(line.value):
            continue
        if abs(after.value - line.value) > SAME * abs(line.value) or abs(after.u - u) > SAME * u:
            why = "; ".join(reason(by_test[test]) for test in changed)
            stated[name] = AsStated(line.value, u, why)
    return Standing(stated, tests)


def reason(found: Diagnosis) -> str:
    """Why the results of a test are not those of the model as stated."""
    titles = {cause.effect: cause.title for cause in found.causes}
    named = ", ".join(titles[name] for name in found.named)
    match found.verdict:
        case "explained":
            return f"the model is extended: {named}"
        case "explained in the main":
            return f"the model is extended: {named}; what it does not explain is in u"
        case "ambiguous":
            groups = ", ".join(" or ".join(titles[name] for name in group) for group in found.groups)
            return f"the mean over models that these data cannot tell apart: {groups}"
        case _:
            return "what no known cause explains is in u"
