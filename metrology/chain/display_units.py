"""Units in which results are shown: where the usual one is too large or too small for the test, one that fits."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

from metrology import units
from metrology.chain.plan import Plan
from metrology.language.display import scale
from metrology.method.model import Identity

if TYPE_CHECKING:
    from metrology.gum.evaluation import Evaluation


SMALLEST, LARGEST = 0.1, 1e6
"""Numbers between which a result of a method keeps its usual unit: 0.000105 GPa is shown as 0.105 MPa, and a stiffness
of 16180000 N/m as 16.18 MN/m."""


def in_fitting_units(plan: Plan, evaluation: Evaluation) -> dict[str, Identity]:
    """Identities of results whose unit is too large, or too small, for the largest of its kind in the test.

    Those of one test alike. The unit of a derived quantity is the campaign's.
    """
    groups: dict[tuple[str, str, str], list[str]] = {}
    for name, estimate in evaluation.estimates.items():
        one = plan.identities[name]
        if one.method != "derived" and estimate.unit in ("Pa", "N", "N/m") and isfinite(estimate.value):
            groups.setdefault((one.test, estimate.unit, one.display_unit or estimate.unit), []).append(name)
    found: dict[str, Identity] = {}
    for (_, unit, shown), names in groups.items():
        most = max(abs(evaluation.estimates[name].value) for name in names) / units.factor(shown)
        if most >= LARGEST or (0 < most < SMALLEST and unit in ("Pa", "N")):
            display = scale(most * units.factor(shown), unit)[1]
            found |= {name: replace(plan.identities[name], display_unit=display) for name in names}
    return found
