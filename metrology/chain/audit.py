"""Audit of published and expected figures: each with the recomputed one, digit by digit."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from metrology.chain.comparisons import known_value
from metrology.chain.conformity import exists
from metrology.chain.derived import over
from metrology.chain.plan import Plan
from metrology.findings import AuditRow
from metrology.message import said
from metrology.units import convert

if TYPE_CHECKING:
    from metrology.campaign.judgement import Audit
    from metrology.campaign.schema import Campaign
    from metrology.gum.evaluation import Evaluation

_SLACK = 1e-9  # of the last printed place: what binary fractions may lack at a tie


def audit(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> tuple[AuditRow, ...]:
    """Return each published figure with the recomputed one; a figure that needs a failed result is left out with it."""
    rows = []
    for index, entry in enumerate(campaign.audit):
        recomputed = _recomputed(campaign, plan, evaluation, index)
        if recomputed is None:
            plan.failures.append(said("{name} cannot be recomputed.", name=entry.figure))
        else:
            estimate = evaluation.estimates.get(entry.quantity or "")
            rows.append(_audit_row(entry, *recomputed, estimate.reported if estimate is not None else recomputed))
    return tuple(rows)


def _recomputed(campaign: Campaign, plan: Plan, evaluation: Evaluation, index: int) -> tuple[float, float] | None:
    entry = campaign.audit[index]
    if entry.quantity is not None:
        estimate = evaluation.estimates.get(entry.quantity)
        if estimate is not None:
            # A publication evaluates the equation at the estimates, as the GUM uncertainty framework does.
            return (estimate.value, estimate.u) if exists(estimate) else None
        known = known_value(entry.quantity, plan, evaluation)
        return known[1:3] if known else None
    values = {name: stated.value for name, stated in plan.inputs.items()}
    values |= {name: estimate.value for name, estimate in evaluation.estimates.items() if isfinite(estimate.value)}
    meaning = campaign.names.meanings["audit", index]
    if set(meaning.values()) - values.keys():
        return None
    assert entry.expression is not None
    try:
        return float(over(entry.expression, meaning)(values)), 0.0
    except ValueError:
        return None


def _audit_row(entry: Audit, value: float, u: float, reported: tuple[float, float]) -> AuditRow:
    published = entry.published.quantity
    differs_by = abs(value - published.value)
    agrees = differs_by <= published.resolution * (0.5 + _SLACK)
    text, result = (_text(convert(one, published.unit), published.digits) for one in (value, reported[0]))
    shown = _text(convert(published.value, published.unit), published.digits)
    # An expression recomputes the value alone: a published uncertainty beside it is shown nowhere and judged by nobody.
    if entry.quantity is not None and published.u is not None and published.u_digits is not None:
        place = published.factor * 10.0**-published.u_digits
        agrees = agrees and abs(u - published.u) <= place * (0.5 + _SLACK)
        text += f" ± {_text(u / published.factor, published.u_digits)}"
        result += f" ± {_text(reported[1] / published.factor, published.u_digits)}"
        shown += f" ± {_text(published.u / published.factor, published.u_digits)}"
    unit = "" if published.unit == "1" else f" {published.unit}"
    sentence = _audit_sentence(entry.remark, text + unit, shown + unit, agrees=agrees)
    if result != text:
        # Both stand in one report: which is which must be said.
        other = "{sentence}; by the GUM framework, Monte Carlo {result:figures}"
        sentence = said(other, sentence=sentence, result=result + unit)
    return AuditRow(
        figure=entry.figure,
        source=entry.source,
        published=shown + unit,
        recomputed=text + unit,
        difference=_difference(value, published.value, published.factor, published.digits, unit),
        agrees=agrees,
        sentence=sentence,
    )


def _text(value: float, digits: int) -> str:
    return f"{round(value, digits):.{max(digits, 0)}f}"


def _difference(value: float, published: float, factor: float, digits: int, unit: str) -> str:
    difference = (value - published) / factor
    relative = f" ({(value - published) / published:+.2%})" if published else ""
    return f"{difference:+.{max(digits, 0) + 1}f}{unit}{relative}"


def _audit_sentence(remark: str, recomputed: str, published: str, *, agrees: bool) -> str:
    differs = "recomputed {recomputed:figures}, published {published:figures}"
    verdict = (
        said("agrees to every published digit") if agrees else said(differs, recomputed=recomputed, published=published)
    )
    return said("{verdict}; {remark}", verdict=verdict, remark=remark) if remark else verdict
