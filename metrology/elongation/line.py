"""Least squares for an elongation test: mean readings, freed of the zero of each repeat, and the line through them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
LEAST_DOF = 3
"""Degrees of freedom of a scatter from which on it has a standard uncertainty: that of a t distribution with fewer is
infinite (JCGM 101:2008, 6.4.9.4)."""


@dataclass(frozen=True)
class Means:
    """Mean reading of each load, by least squares of reading = mean[load] + shift[repeat] + scatter.

    Parameters
    ----------
    values : ndarray, shape (L,)
        Means z_i, in m.
    cofactor : ndarray, shape (L, L)
        Covariance of the means for a scatter of unit variance; 1/n_i on the diagonal of a balanced test.
    shifts : ndarray, shape (R,)
        Zero of each repeat against the mean of all, in m; zeros where one zero serves all repeats.
    variance : float
        Variance s² of one reading, in m², with `dof` degrees of freedom: what loads and zeros leave over ("pure
        error"), or what the line leaves over.
    dof : int
        ν = n − L − (R − 1), or n − 2 − (R − 1) about the line.
    information : ndarray, shape (L, L)
        M with M·1 = 0, so that Fᵀ·M·z / (Fᵀ·M·F) is the slope of the line that shares one slope and has a zero a
        repeat; in a balanced test that is the slope of the plain line through all readings.
    leftover : ndarray, shape (n,)
        Readings less the fit that the scatter is about, in m.
    leverage : ndarray, shape (n,)
        Diagonal of the hat matrix.
    zero_each : bool
        Whether each repeat has a zero of its own.
    about_line : bool
        Whether the scatter is that about the line, since too few readings are repeated.
    columns : ndarray, shape (n, p)
        Of the model that the scatter is about: one mean a load, or the line, and the zeros of the repeats.
    """

    values: Floats
    cofactor: Floats
    shifts: Floats
    variance: float
    dof: int
    information: Floats
    leftover: Floats
    leverage: Floats
    zero_each: bool
    about_line: bool
    columns: Floats


@dataclass(frozen=True)
class Layout:
    """Which load and which repeat each reading belongs to, as columns of a linear model.

    Parameters
    ----------
    loads : ndarray of int, shape (n,)
        Index of the load of each reading, 0 … L − 1.
    repeats : ndarray of int, shape (n,)
        Index of the repeat of each reading, 0 … R − 1.
    """

    loads: np.ndarray[tuple[int, ...], np.dtype[np.intp]]
    repeats: np.ndarray[tuple[int, ...], np.dtype[np.intp]]

    @classmethod
    def of(cls, loads: Sequence[int], repeats: Sequence[int]) -> Layout:
        """Layout from plain sequences of indices."""
        return cls(np.asarray(loads, dtype=np.intp), np.asarray(repeats, dtype=np.intp))

    def level_columns(self) -> Floats:
        """One column a load: 1 where the reading was taken at it."""
        return np.eye(int(self.loads.max()) + 1)[self.loads]

    def repeat_columns(self) -> Floats:
        """One column a repeat but the last, so coded that the shifts of all repeats add up to zero."""
        coding = np.eye(int(self.repeats.max()) + 1)
        return (coding[:, :-1] - coding[:, -1:])[self.repeats]

    def mean_columns(self, *, zero_each: bool) -> Floats:
        """Columns of one mean a load and, where the readings show it, one zero a repeat."""
        levels = self.level_columns()
        return np.hstack([levels, self.repeat_columns()]) if zero_each else levels

    def straight_columns(self, forces: Floats, *, zero_each: bool) -> Floats:
        """Columns of one line and, where the readings show it, one zero a repeat."""
        line = np.column_stack([np.ones(len(self.loads)), forces[self.loads]])
        return np.hstack([line, self.repeat_columns()]) if zero_each else line

    def information(self, *, zero_each: bool) -> Floats:
        """M = Nᵀ·Q·N, where Q takes out the mean of each repeat (or of all readings) from the load columns N."""
        columns = self.level_columns()
        groups = self.repeats if zero_each else np.zeros_like(self.repeats)
        for group in np.unique(groups):
            columns[groups == group] -= columns[groups == group].mean(axis=0)
        return np.asarray(columns.T @ columns)

    def connected(self) -> bool:
        """Whether the repeats share loads so that load and zero can be told apart."""
        information = self.information(zero_each=True)
        return int(np.linalg.matrix_rank(information)) == len(information) - 1


def average(readings: Floats, layout: Layout, forces: Floats) -> Means:
    """Means of the readings at each load, freed of the zero of each repeat where the readings show it.

    Parameters
    ----------
    readings : ndarray, shape (n,)
        In m.
    layout : Layout
        Load and repeat of each reading.
    forces : ndarray, shape (L,)
        Force of each load in N.

    Notes
    -----
    Where no repeat holds two loads, or the loads and repeats fall apart into groups, one zero serves all repeats. The
    same holds where a zero for each repeat would leave no degree of freedom for the scatter. Where readings at the same
    load leave fewer than `LEAST_DOF`, the scatter is that about the line: what is not straight is then in it.
    """
    levels, coding = layout.level_columns(), layout.repeat_columns()
    zero_each = layout.connected() and len(readings) > levels.shape[1] + coding.shape[1]
    design = layout.mean_columns(zero_each=zero_each)
    cofactor = np.asarray(np.linalg.inv(design.T @ design), dtype=np.float64)
    offset = float(readings.mean())
    solution = cofactor @ (design.T @ (readings - offset))
    leftover = readings - offset - design @ solution
    count = levels.shape[1]
    shifts = np.append(solution[count:], -solution[count:].sum()) if zero_each else np.zeros(coding.shape[1] + 1)
    about_line = len(readings) - design.shape[1] < LEAST_DOF
    columns = layout.straight_columns(forces, zero_each=zero_each) if about_line else design
    if about_line:
        axes = np.linalg.svd(columns / np.linalg.norm(columns, axis=0), full_matrices=False)[0]
        leftover, leverage = readings - offset - axes @ (axes.T @ (readings - offset)), np.sum(axes**2, axis=1)
    else:
        leverage = np.einsum("ij,jk,ik->i", design, cofactor, design)
    dof = len(readings) - columns.shape[1]
    return Means(
        values=solution[:count] + offset,
        cofactor=cofactor[:count, :count],
        shifts=shifts,
        variance=float(leftover @ leftover) / dof,
        dof=dof,
        information=layout.information(zero_each=zero_each),
        leftover=leftover,
        leverage=leverage,
        zero_each=zero_each,
        about_line=about_line,
        columns=columns,
    )


def slope(forces: Floats, means: Means) -> float:
    """Slope b of extension against load, in m/N: b = Fᵀ·M·z / (Fᵀ·M·F)."""
    return float(slope_weights(forces, means) @ means.values)


def slope_weights(forces: Floats, means: Means) -> Floats:
    """What each mean reading moves the slope by, in 1/N: w = M·F / (Fᵀ·M·F), shape (L,)."""
    weights = means.information @ forces
    return np.asarray(weights / float(weights @ forces))


@dataclass(frozen=True)
class Nested:
    """F test of two linear models, the smaller one within the larger one.

    `statistic` and `p_value` are None where the larger model leaves nothing over, so that there is no scatter to
    compare with.
    """

    statistic: float | None
    p_value: float | None
    extra: int
    dof: int


def compare(readings: Floats, smaller: Floats, larger: Floats, *, floor: float) -> Nested:
    """F test of whether the columns that `larger` has beyond `smaller` are needed.

    Parameters
    ----------
    readings : ndarray, shape (n,)
        In m.
    smaller, larger : ndarray, shape (n, p)
        Columns of the two models; rank-deficient ones are allowed.
    floor : float
        Standard deviation below which scatter counts as rounding of the arithmetic, in m.
    """
    from scipy.special import fdtrc

    rest_small, rank_small = _rest(readings, smaller)
    rest_large, rank_large = _rest(readings, larger)
    extra, dof = rank_large - rank_small, len(readings) - rank_large
    if extra < 1 or dof < 1 or rest_large <= dof * floor**2:
        return Nested(None, None, extra, dof)
    statistic = max(0.0, rest_small - rest_large) / extra / (rest_large / dof)
    return Nested(statistic, float(fdtrc(extra, dof, statistic)), extra, dof)


def _rest(readings: Floats, columns: Floats) -> tuple[float, int]:
    """Sum of squares that the columns leave over, and their rank."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    centred = readings - readings.mean()
    solution, _, rank, _ = np.linalg.lstsq(scaled, centred, rcond=1e-10)
    rest = centred - scaled @ solution
    return float(rest @ rest), int(rank)
