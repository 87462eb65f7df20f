"""Gaussian copula: latent correlation that gives two drawn components exactly the correlation stated for them.

A component is drawn as f(z) = F⁻¹(Φ(z)) with z normal. With the expansion f = Σ a_k h_k in normalised Hermite
polynomials the correlation of two of them is r(ρ) = Σ a_k b_k ρᵏ / (σ_a σ_b) (Mehler), which grows with the latent ρ.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from metrology.gum.distributions import Normal
from metrology.gum.influence import Distribution
from metrology.gum.inputs import Floats

_ORDERS = 81
_REACH = 14.0
_NODES = 5601


def transform(distribution: Distribution, z: Floats) -> Floats:
    """Draws of `distribution` from standard normal `z`, precise in both tails."""
    if isinstance(distribution, Normal):
        return distribution.u * z
    from scipy.special import ndtr

    tail = ndtr(-np.abs(z))
    return np.where(z > 0, distribution.upper(tail), distribution.lower(tail))


def expansion(distribution: Distribution) -> Floats:
    """Coefficients a_0 … a_81 over the standard deviation; the last takes the remainder."""
    z = np.linspace(0.0, _REACH, _NODES)
    weight = np.exp(-(z**2) / 2) * sqrt(2 / np.pi) * (z[1] - z[0])
    weight[0] /= 2
    above, below = (transform(distribution, side) / distribution.deviation * weight / 2 for side in (z, -z))
    odd, even = above - below, above + below
    coefficients = np.zeros(_ORDERS + 1)
    before, here = np.zeros_like(z), np.ones_like(z)
    for order in range(1, _ORDERS):
        before, here = here, (z * here - sqrt(order - 1) * before) / sqrt(order)
        coefficients[order] = float((odd if order % 2 else even) @ here)
    coefficients[_ORDERS] = sqrt(max(0.0, 1.0 - float(coefficients @ coefficients)))
    return coefficients


def latent(a: Distribution, b: Distribution, r: float) -> float | None:
    """Correlation of the latent normals for which draws of `a` and `b` have Pearson's r; None where r is out of reach.

    Between rectangular components it is 2 sin(πr/6).

    Examples
    --------
    >>> from metrology.gum.bounded import Rectangular
    >>> round(latent(Rectangular(1.0), Rectangular(2.0), 0.5), 6)
    0.517638
    """
    if r == 0 or (isinstance(a, Normal) and isinstance(b, Normal)):
        return r
    product = expansion(a) * expansion(b)
    orders = np.arange(product.size)
    most = abs(float(product @ np.sign(r) ** orders))
    if abs(r) >= most:
        return float(np.sign(r)) if abs(r) < most + 1e-7 else None
    from scipy.optimize import brentq

    return float(brentq(lambda rho: float(product @ rho**orders) - r, -1.0, 1.0, xtol=1e-13))
