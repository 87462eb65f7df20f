"""Motions from a rig and a run: one, thousands, and their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from metrology.rig.model import Array, Motion, Rig, Run


@dataclass(frozen=True)
class Motions:
    """Many motions of one run.

    Parameters
    ----------
    x, v, T : ndarray or None
        Shape (n, samples), one row for each set of values; NaN from a failure on; None where not asked for.
    valid : ndarray of bool, shape (n,)
        Which of them reached the end.
    messages : tuple of str, length n
        Empty where valid.
    """

    x: Array | None
    v: Array | None
    T: Array | None
    valid: Array
    messages: tuple[str, ...]


@dataclass(frozen=True)
class Jacobian:
    """Derivatives of the channels by parameters.

    Parameters
    ----------
    names : tuple of str, length p
        The parameters.
    x, v, T : ndarray or None
        Shape (samples, p), in unit of the channel per unit of the parameter.
    valid : bool
        False where a motion that the differences need did not reach the end.
    """

    names: tuple[str, ...]
    x: Array | None
    v: Array | None
    T: Array | None
    valid: bool


def simulate(rig: Rig, run: Run, *, engine: str = "auto") -> Motion:
    """Motion of the rig in one run, exact between events where the equation is linear.

    Parameters
    ----------
    rig, run : Rig, Run
        Numbers of the equation, start, thrust and time stamps.
    engine : {'auto', 'compiled', 'numpy', 'interpreted'}
        How to integrate; 'auto' takes the fastest at hand.
    """
    raise NotImplementedError


def simulate_many(rig: Rig, run: Run, names: Sequence[str], values: Array, *, threads: int = 1) -> Motions:
    """Motions for many sets of values at once (Monte Carlo bands, derivatives).

    Parameters
    ----------
    rig, run : Rig, Run
        As for `simulate`.
    names : sequence of str, length p
        Parameters that vary, any of `NAMES`.
    values : ndarray, shape (n, p)
        Their values.
    threads : int
        Threads to share the work.
    """
    raise NotImplementedError


def jacobian(rig: Rig, run: Run, names: Sequence[str]) -> Jacobian:
    """Derivatives of every channel by these parameters, by central differences of fourth order on the exact motion.

    At the edge of a parameter's range (friction at its null) the differences are one-sided, of third order. Samples
    beside a change of contact jump with the parameter: their derivative is that of one side.
    """
    raise NotImplementedError
