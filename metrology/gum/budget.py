"""Uncertainty budget: what each component of each input contributes to u of an output (JCGM 100:2008, Table H.1)."""

from __future__ import annotations

from math import inf, isfinite

from metrology.gum.evaluation import BudgetRow
from metrology.gum.law import Law


def budget(law: Law, row: int) -> tuple[BudgetRow, ...]:
    """One row for each component of each input that the measurand reads, in the order of the inputs.

    The share of component a in u² is c_a u_a Σ_b r_ab c_b u_b / u²: shares add up to one, and the cross terms of a
    correlated pair are split evenly between its two rows. All are zero where u is zero or undefined.
    """
    line = law.linear[row]
    variance = law.variances[row]
    scale = variance if variance > 0 else inf
    together = zip(law.joint.terms, law.joint.u, law.contributions[row], law.products[row], strict=True)
    return tuple(
        [
            BudgetRow(  # in the order of its fields: by their names a row takes twice as long
                item.name,
                component.name,
                item.description,
                item.value,
                u,
                item.unit,
                component.drawn.name,
                component.kind,
                component.dof if isfinite(component.dof) else None,
                line.sensitivities.get(item.name, 0.0),
                part,
                part * whole / scale,
                component.source,
                component.cause,
                component.opposite,
            )
            for (item, component, _), u, part, whole in together
            if item.name in line.reads
        ]
    )
