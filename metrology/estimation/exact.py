"""What a fit holds exactly because nobody stated how well it is known: how far the estimates would follow it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from metrology.estimation.covariance import inverse
from metrology.estimation.identification import Identification
from metrology.estimation.priors import Prior, lay_out
from metrology.estimation.problem import Array, evaluate, slope
from metrology.estimation.response import View, masks, problem


def followed(found: Identification, names: Sequence[str]) -> dict[str, Array]:
    """Derivative of the estimates that all runs share by each parameter that the fit holds exactly.

    One linearisation at the solution: ∂θ̂/∂X = −H⁻¹·JᵀJ_X, H the information on everything that is fitted.

    Parameters
    ----------
    found : Identification
        With status 'ok'.
    names : sequence of str
        Parameters of the rig that are no unknowns of the fit.

    Returns
    -------
    dict of str to ndarray
        By parameter, in the order of ``found.joint.names``; empty where the motion has no answer.
    """
    common = found.layout.unknowns[: found.layout.common]
    free = [entry.name for entry in common if entry.u is None]
    sought = [Prior(name, common=found.rig.parameters[name].scale) for name in names]
    layout = lay_out(found.rig, [run.name for run in found.runs], free, (*found.priors, *sought))
    known = dict(zip((entry.name for entry in found.layout.unknowns), found.theta, strict=True))
    theta = np.array([known.get(entry.name, entry.start) for entry in layout.unknowns])
    use = masks(found.rig, found.runs, layout, theta, View())
    point = evaluate(posed := problem(found.rig, found.runs, layout, use, View()), theta) if use else None
    here = slope(posed, point) if point else None
    if here is None:
        return {}
    order = [entry.name for entry in layout.unknowns]
    fitted = [order.index(entry.name) for entry in found.layout.unknowns]
    held = [order.index(name) for name in names]
    moved = -inverse(here.information[np.ix_(fitted, fitted)]) @ here.information[np.ix_(fitted, held)]
    return {name: moved[: len(common), column] for column, name in enumerate(names)}
