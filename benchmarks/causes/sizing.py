"""How far an effect moves the readings once the model without it is refitted, and the size for a distance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

SMALL = 0.3
"""Distance at which the rate is taken. Contacts that come late make readings bend in the size long before the distance,
which is a small difference of large changes, does."""


def distance(moved: np.ndarray, jacobian: np.ndarray, priors: np.ndarray) -> float:
    """Root of least χ²: ‖moved − J·θ‖² + Σ (θ_j/u_j)² over θ, in noise units.

    `moved` in noise units, shape (n,); `jacobian` (n, p); `priors` u_j, infinite where nothing is known, (p,).
    """
    return float(np.linalg.norm(remainder(moved, jacobian, priors)))


def remainder(moved: np.ndarray, jacobian: np.ndarray, priors: np.ndarray) -> np.ndarray:
    """What is left of a change of the readings, and of the priors, by the refit."""
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    rows = np.vstack([jacobian / scale, np.diag(1 / (priors * scale))])
    aim = np.concatenate([moved, np.zeros(len(priors))])
    theta = np.linalg.lstsq(rows, aim, rcond=1e-12)[0]
    return aim - rows @ theta


def size_for(wanted: float, first: float, measure: Callable[[float], float]) -> float:
    """Size with that distance, in proportion to a small one."""
    size, found = first, measure(first)
    for _ in range(3):
        if found <= 0 or 0.1 * SMALL < found < 2 * SMALL:
            break
        size *= SMALL / found
        found = measure(size)
    if found <= 0:
        raise ArithmeticError("an effect that moves nothing")
    return size * wanted / found
