"""Uncertainty budget: what each component of each input contributes to u of an output (JCGM 100:2008, Table H.1)."""

from __future__ import annotations

from math import inf, isfinite

from metrology.gum.evaluation import BudgetRow
from metrology.gum.joint import Term
from metrology.gum.law import Law


def budget(law: Law, row: int) -> tuple[BudgetRow, ...]:
    """One row for each component of each input that the measurand reads, in the order of the inputs.

    The share of component a in u² is c_a u_a Σ_b r_ab c_b u_b / u²: shares add up to one, and the cross terms of a
    correlated pair are split evenly between its two rows. All are zero where u is zero or undefined.
    """
    line = law.linear[row]
    parts = law.contributions[row]
    variance = float(law.covariance[row, row])
    scale = variance if variance > 0 else inf
    together = zip(law.joint.terms, parts.tolist(), law.joint.times(parts).tolist(), strict=True)
    return tuple(
        _row(term, line.sensitivities.get(term.input.name, 0.0), part, part * whole / scale)
        for term, part, whole in together
        if term.input.name in line.reads
    )


def _row(term: Term, sensitivity: float, contribution: float, share: float) -> BudgetRow:
    item, component = term.input, term.component
    return BudgetRow(
        input=item.name,
        component=component.name,
        description=item.description,
        value=item.value,
        u=component.u,
        unit=item.unit,
        distribution=component.drawn.name,
        kind=component.kind,
        dof=component.dof if isfinite(component.dof) else None,
        sensitivity=sensitivity,
        contribution=contribution,
        share=share,
        source=component.source,
        cause=component.cause,
        opposite=component.opposite,
    )
