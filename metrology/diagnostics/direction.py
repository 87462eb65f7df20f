"""What a little of a candidate, or of a law that nobody lists, does to the residuals of a fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from metrology.estimation.problem import Array

STRAIGHT = (0, 1)
"""Powers of a straight line."""


@dataclass(frozen=True)
class Direction:
    """What a little of a candidate does to the residuals of a fit, everything else held.

    Parameters
    ----------
    effect : str
        The candidate.
    values : mapping of str to float
        Values of its parameters.
    amount : float
        Of the size, measured from its null.
    rows : tuple of ndarray, shape (n,) or (n, q)
        Change of the whitened residuals, block by block; with q columns where the effect may act in q ways at once.
    looks : float
        Among how many such directions it was picked for its looks.
    ways : tuple of str
        Unknowns that stand for the columns, where there are several; the amount is that of each.
    stated : int or None
        For an input that the fit seeks within a prior: its place among the unknowns. Nothing but the prior speaks
        against such a direction.
    exact : bool
        Whether the rows are a derivative, not a difference of motions: their residual after a fit is no error then.
    """

    effect: str
    values: Mapping[str, float]
    amount: float
    rows: tuple[Array, ...]
    looks: float = 1.0
    ways: tuple[str, ...] = ()
    stated: int | None = None
    exact: bool = False
    places: Array | None = None
    """Of an unlisted law of several quantities: where each way has its size, shape (q, d)."""
    listed: tuple[int, ...] = ()
    """Powers of what an unlisted law depends on that it has not, since they are listed. `STRAIGHT`: a tilt and a drag,
    a zero and a gain. The first alone: stiffness or damping of the line; such a law is zero at zero, as a line is."""
    straight: Mapping[str, float] = field(default_factory=dict)
    """Unknowns that the straight part of an unlisted law is, and by how much each is off for a slope of one."""
    mimics: str = ""
    """Family of other unlisted laws that do the same to the readings as far as these show one frequency."""
    is_line: bool = False
    """Whether an unlisted law is an oscillation of one frequency: the noise about it is measured beside it."""
    neighbours: bool = False
    """Whether two neighbouring ways alone are such a law as well."""
    rough: bool = False
    """Whether an unlisted law may have any values at its places as well, each at the price of a listed size."""
    sums: tuple[Array, Array] | None = None
    """Where an unlisted law is stated whose ways are not its places, shape (h,), and what each way is there, (h, q)."""
