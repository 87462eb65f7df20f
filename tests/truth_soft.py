"""Records of a testing machine that have no straight part, or are pulled by hand, drawn by equations of their own.

Shares no code with the package.
"""

from __future__ import annotations

import numpy as np


def mooney(
    count: int, rng: np.random.Generator, *, noise: float = 2e-3, longest: float = 0.35
) -> dict[str, np.ndarray]:
    """A soft tape of 10 mm² and 80 mm by Mooney and Rivlin, pulled at a steady rate: F = 2A(λ − λ⁻²)(C₁ + C₂/λ)."""
    stretch = 1 + longest * (np.arange(count) + 1.0) / count
    force = 2 * 10e-6 * (stretch - stretch**-2) * (12e3 + 25e3 / stretch)
    return _read(force + noise * rng.normal(size=count), 0.08 * (stretch - 1), count)


def exponential(count: int, rng: np.random.Generator, *, noise: float = 0.5) -> dict[str, np.ndarray]:
    """F = F₁·(1 − exp(−x/x₁)): it softens evenly, and nothing breaks."""
    x = 2e-3 * (np.arange(count) + 1.0) / count
    return _read(400.0 * (1 - np.exp(-x / 2.5e-3)) + noise * rng.normal(size=count), x, count)


def by_hand(count: int, rng: np.random.Generator, *, k: float = 50.0, lag: float = 0.02) -> dict[str, np.ndarray]:
    """A spring that is pulled by hand: the speed wanders, and the force is read a little later than the position."""
    step = 0.025
    speed = np.empty(count + 8)
    value = 0.0
    for at in range(len(speed)):
        value = 0.85 * value + np.sqrt(1 - 0.85**2) * rng.normal()
        speed[at] = 0.055 * (1 + 0.35 * value)
    x = np.cumsum(speed) * step
    late = np.interp(np.arange(len(x)) * step - lag, np.arange(len(x)) * step, x)
    force = np.round(k * late[8:] + 0.01 * rng.normal(size=count), 2)
    return _read(force, np.round(x[8:] - x[8], 4), count, step)


def broken(
    count: int, rng: np.random.Generator, *, lost: float = 0.05, at: float = 0.5, noise: float = 5e-6
) -> dict[str, np.ndarray]:
    """A bundle of yarns of which a part breaks at an instant: one step of the stretch, and more slope after it."""
    force = 400.0 * (np.arange(count) + 1.0) / count
    left = np.where(np.arange(count) >= at * count, 1.0 - lost, 1.0)
    return _read(force, force / (2e5 * left) + noise * rng.normal(size=count), count)


def toe_and_yield(count: int, rng: np.random.Generator, *, flow: float = 2.5e-8) -> dict[str, np.ndarray]:
    """Strain with a toe up to a tenth of the force and yield beyond nine tenths; dε/dF = 1.2·10⁻⁶ between them."""
    force = 4000.0 * (np.arange(count) + 1.0) / count
    strain = 1.2e-6 * force + 4e-4 * (1 - np.exp(-force / 150.0)) + flow * np.maximum(force - 3700.0, 0.0) ** 1.8
    return {"force": force, "strain": np.round(strain + 2e-6 * rng.normal(size=count), 5)}


def _read(force: np.ndarray, x: np.ndarray, count: int, step: float = 0.1) -> dict[str, np.ndarray]:
    return {"time": step * np.arange(count), "force": force, "crosshead": x}
