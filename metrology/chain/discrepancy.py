"""Elongation tests whose stiffness or modulus disagrees with what was expected: which causes could part the two."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

from metrology.diagnostics.discrepancy_setting import Known, Other, Setting
from metrology.methods import METHODS

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.diagnosis import Diagnosis, Discrepancy
    from metrology.findings import Comparison
    from metrology.gum.evaluation import Evaluation

LINEAR = ("width", "thickness", "height")
"""Dimensions of a section in proportion to which its area is."""


def explained(
    campaign: Campaign, plan: Plan, evaluation: Evaluation, comparisons: Sequence[Comparison]
) -> tuple[Diagnosis, ...]:
    """Return the diagnoses, those of elongation tests that disagree with a reference with what could part the two."""
    found = []
    for one in plan.diagnosis:
        parted = _discrepancy(campaign, plan, evaluation, comparisons, one.test)
        found.append(one if parted is None else replace(one, discrepancy=parted))
    return tuple(found)


def _discrepancy(
    campaign: Campaign, plan: Plan, evaluation: Evaluation, comparisons: Sequence[Comparison], name: str
) -> Discrepancy | None:
    explain = METHODS[campaign.tests[name].method].explain
    if explain is None:
        return None
    # Another test of the sample, or another sample, is no reference: which of the two is off, no one knows.
    others = evaluation.estimates.keys() - {f"{name}.E", f"{name}.k"}
    stated = [row for row in comparisons if not {row.a, row.b} & others]
    setting = _setting(campaign, evaluation, stated, name)
    return None if setting is None else explain(plan.ready[name], setting)


def _setting(
    campaign: Campaign, evaluation: Evaluation, comparisons: Sequence[Comparison], name: str
) -> Setting | None:
    """What is known around a test that disagrees with its reference; None where it agrees, or E is not known."""
    k, E = (_estimate(evaluation, f"{name}.{quantity}") for quantity in ("k", "E"))
    sample = campaign.samples[campaign.tests[name].sample]
    if k is None or E is None or sample.length is None:
        return None
    # E is named where it differs itself; where k alone does, what E takes besides is no cause of it.
    beyond = [row for row in comparisons if not row.agrees]
    for quantity in ("E", "k"):
        full = f"{name}.{quantity}"
        reference = next((known for row in beyond if (known := _other_side(row, full)) is not None), None)
        if reference is None:
            continue
        en = next(row.en for row in beyond if full in (row.a, row.b))
        return Setting(
            k, E, Known(sample.length.si, sample.length.u), reference, _section(campaign, evaluation, name),
            _dynamic(campaign, evaluation, name), tuple(_others(campaign, evaluation, comparisons, name)), en, quantity,
        )  # fmt: skip
    return None


def _other_side(row: Comparison, name: str) -> Known | None:
    """What a result is compared with; None where it is not in the comparison, or with nothing above zero."""
    sides = ((row.a, row.b, row.value_b, row.u_b), (row.b, row.a, row.value_a, row.u_a))
    return next((Known(value, u or None, label) for own, label, value, u in sides if own == name and value > 0), None)


def _estimate(evaluation: Evaluation, name: str) -> Known | None:
    found = evaluation.estimates.get(name)
    if found is None:
        return None
    # As reported: the chapter then argues with the values of page 1.
    value, u = found.reported
    return Known(value, u, name) if isfinite(value) and isfinite(u) and value > 0 else None


def _reference(comparisons: Sequence[Comparison], name: str, k: Known, E: Known) -> Known | None:
    """Reference modulus of a test; one of k stands for the modulus that it would mean for the same section."""
    for row in comparisons:
        for full, factor in ((f"{name}.E", 1.0), (f"{name}.k", E.value / k.value)):
            if (found := _other_side(row, full)) is not None:
                return Known(found.value * factor, (found.u or 0.0) * factor or None, found.source)
    return None


def _section(campaign: Campaign, evaluation: Evaluation, name: str) -> dict[str, Known]:
    """Stated dimensions to which the area is in proportion; the area itself where there is none."""
    sample = campaign.tests[name].sample
    section = campaign.samples[sample].section
    found = {
        word: Known(stated.si, stated.u) for word in LINEAR if (stated := getattr(section, word, None)) is not None
    }
    area = _estimate(evaluation, f"{sample}.A")
    return found or ({"area": area} if area is not None else {})


def _dynamic(campaign: Campaign, evaluation: Evaluation, name: str) -> Known | None:
    """Stiffness of the same sample by a free decay."""
    sample = campaign.tests[name].sample
    names = [key for key, test in campaign.tests.items() if test.method == "decay" and test.sample == sample]
    # A body that turns has a stiffness of another kind.
    straight = [f"{key}.k" for key in names if (known := evaluation.estimates.get(f"{key}.k")) and known.unit == "N/m"]
    return next(filter(None, (_estimate(evaluation, name) for name in straight)), None)


def _others(
    campaign: Campaign, evaluation: Evaluation, comparisons: Sequence[Comparison], name: str
) -> Iterator[Other]:
    """Other samples that the same instruments read: the rig is taken to be the same."""
    own = campaign.tests[name]
    for key, test in campaign.tests.items():
        if test.method != own.method or test.sample == own.sample or test.instruments != own.instruments:
            continue
        k, E = (_estimate(evaluation, f"{key}.{quantity}") for quantity in ("k", "E"))
        if k is not None and E is not None:
            yield Other(campaign.samples[test.sample].name or test.sample, k, E, _reference(comparisons, key, k, E))
