"""Nodes, integrals and weights of the collocation along which derivatives of a motion are followed."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np

from metrology.rig.run import Array, frozen

NODES = 8
"""Nodes of the collocation: over the longest step, 2 rad of the line, it errs by less than 1e-7."""
ROUNDED = 14
"""Decimal places of the nodes: LAPACK finds them to 15, its last digit by the processor."""


@lru_cache(maxsize=1)
def rule() -> tuple[Array, Array, Array]:
    """Nodes of Lobatto's quadrature in (0, 1), integrals of their Lagrange polynomials, barycentric weights.

    Integrals and weights are exact for the nodes as rounded, so that derivatives have the same bits on every processor:
    along what the readings hardly determine, 1e-15 here moves the optimum by 1e-4 standard uncertainties.
    """
    from numpy.polynomial import Legendre

    inner = Legendre.basis(NODES - 1).deriv().roots().real
    nodes = np.round(0.5 * (1.0 + np.concatenate([[-1.0], np.sort(inner), [1.0]])), ROUNDED)
    exact = [Fraction(node) for node in nodes.tolist()]
    integrals, weights = np.empty((NODES, NODES)), np.empty(NODES)
    for at, node in enumerate(exact):
        product, scale = [Fraction(1)], Fraction(1)
        for other in (one for one in exact if one is not node):
            product = [
                lower - other * upper
                for lower, upper in zip([Fraction(0), *product], [*product, Fraction(0)], strict=True)
            ]
            scale *= node - other
        integral = [coefficient / (power + 1) / scale for power, coefficient in enumerate(product)]
        weights[at] = float(1 / scale)
        integrals[:, at] = [float(sum(one * end ** (power + 1) for power, one in enumerate(integral))) for end in exact]
    return frozen(nodes), frozen(integrals), frozen(weights)
