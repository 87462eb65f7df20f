"""Every form fitted to a record in the metric of its own noise, each with its evidence."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import lgamma, log

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.forms import Form, Scene
from metrology.relaxation.noise import Colours, cosines, level
from metrology.relaxation.search import Joint, search

GRID = 22
"""Relaxation times among which the starts of a search are found."""
ROUNDS = 3
"""Searches for one form, each in the metric of the colour that the last one found most probable; the first as white."""


@dataclass(frozen=True)
class Fitted:
    """One form at a record.

    Parameters
    ----------
    form : Form
        What was fitted.
    evidence : float
        ln of the probability of the record under it, but for a constant that all forms share.
    values : ndarray, shape (q,)
        b, d where there is one, r₀, rᵢ, then ln τᵢ or the exponent: means over the colours.
    near : ndarray, shape (q,)
        Values that the search found, about which the form is taken as linear.
    covariance : ndarray, shape (q, q)
        Of the values, over the colours as well.
    model : ndarray, shape (n,)
        Means over the blocks by the values.
    excess : float
        Level of the residuals by their lowest cosines over that by all of them, as variances.
    memory : float
        Correlation time / s of the noise, mean over the colours.
    weights : ndarray, shape (g,)
        Probability of each colour.
    columns : ndarray, shape (n, q)
        Derivatives of the model by the values.
    allowed : bool
        Whether its sizes have the sign that they must have.
    """

    form: Form
    evidence: float
    values: Array
    near: Array
    covariance: Array
    model: Array
    excess: float
    memory: float
    weights: Array
    columns: Array
    allowed: bool


class Fitter:
    """Fits forms to one record, each from the best starts that are known."""

    def __init__(self, scene: Scene, noise: Colours) -> None:
        self.scene, self.noise = scene, noise
        self.y = scene.answer.of.y
        low, high = (log(time) for time in scene.times)
        self.grid = np.linspace(low, high, GRID)
        one = Form(1)
        self.rows = np.column_stack([scene.column(one, shape) for shape in self.grid])
        # Least sum of squares that is no rounding of the arithmetic.
        self.floor = 1e-20 * ((noise.whitening @ self.y) ** 2).sum(axis=1) + 1e-300
        self.best: dict[tuple[int, bool], Array] = {}

    def fit(self, form: Form) -> Fitted:
        """Fit a form: its shapes by a search, everything else and its evidence over all colours."""
        colour, shapes, sizes = 0, np.empty(0), self._elastic(form)
        best: Fitted | None = None
        for _ in range(ROUNDS):
            if form.shapes:
                shapes, sizes = self._search(form, colour, shapes)
            fitted, favourite = self._weigh(form, shapes, sizes)
            if best is None or fitted.evidence > best.evidence:
                best, self.best[form.shapes, form.power] = fitted, shapes
            if favourite == colour or not form.shapes:
                break
            colour = favourite
        assert best is not None
        return best

    # ---- search ---------------------------------------------------------------------------------------------------
    def _search(self, form: Form, colour: int, last: Array) -> tuple[Array, Array]:
        """Most probable shapes in the metric of one colour, and the sizes of what has them."""
        white = self.noise.whitening[colour]
        y = white @ self.y
        start = last if len(last) else self._start(form, white, y)
        level = self._level(white, y, start, form)
        ends = (1e-3, 0.95) if form.power else (self.grid[0] - 1.0, self.grid[-1] + 1.0)
        start = np.clip(start, ends[0] + 1e-3, ends[1] - 1e-3)
        joint = Joint(self.scene, form, white / level, y / level)
        found = np.sort(search(joint, start, ends))
        return found, joint.sizes(found)[0]

    def _elastic(self, form: Form) -> Array:
        """Sizes of a form without shapes."""
        columns = self.scene.columns(Form(0, drift=form.drift), np.empty(0))
        return np.asarray(np.linalg.lstsq(columns, self.y, rcond=None)[0])

    def _level(self, white: Array, y: Array, shapes: Array, form: Form) -> float:
        X = white @ self.scene.columns(form, shapes)
        left = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
        return float(np.sqrt(left @ left / max(len(y) - X.shape[1] - form.shapes, 1))) or 1e-300

    def _start(self, form: Form, white: Array, y: Array) -> Array:
        """Of all sets of times on the grid the one with the least residuals, sizes of the right sign before others."""
        if form.power:
            tried = np.array([0.01, 0.03, 0.1, 0.2, 0.4, 0.7])
            return np.array([min(tried, key=lambda one: self._level(white, y, np.array([one]), form))])
        if form.branches > 3:
            return self._further(form, white, y)
        base = white @ self.scene.columns(Form(0, drift=form.drift), np.empty(0))
        rows, p = np.column_stack([base, white @ self.rows]), base.shape[1]
        sets = np.array(list(combinations(range(p, p + GRID), form.branches)))
        sets = np.column_stack([np.broadcast_to(np.arange(p), (len(sets), p)), sets])
        # By triangular factors: columns of neighbours on the grid are alike but for what normal equations would lose.
        Q, R = np.linalg.qr(rows / np.sqrt((rows**2).sum(axis=0)))
        seen = Q.T @ y
        q, r = np.linalg.qr(np.moveaxis(R[:, sets], 1, 0))
        part = np.einsum("sij,i->sj", q, seen)
        sizes = np.linalg.solve(r, part[..., None])[..., 0]
        left = ((seen - np.einsum("sij,sj->si", q, part)) ** 2).sum(axis=1)
        right_sign = (sizes[:, p:] > 0).all(axis=1)
        order = np.where(right_sign, left, np.inf) if right_sign.any() else left
        return np.asarray(self.grid[sets[int(np.argmin(order)), p:] - p])

    def _further(self, form: Form, white: Array, y: Array) -> Array:
        """The times of one branch less, with the best one of the grid."""
        known = self.best[form.branches - 1, False]
        tried = [np.sort(np.append(known, one)) for one in self.grid]
        return min(tried, key=lambda one: self._level(white, y, one, form))

    # ---- evidence ---------------------------------------------------------------------------------------------------
    def _weigh(self, form: Form, shapes: Array, sizes: Array) -> tuple[Fitted, int]:
        """Means over all colours, by Laplace's approximation about the shapes; number of the most probable colour.

        Each form is linear in its sizes, and taken as linear in its shapes about the best ones. ln of the evidence of a
        colour is that of the residuals at its own level, less the Occam factors of what the form has more than others
        (MacKay 2003, ch. 28). The level of the noise that the covariance takes is that of the lowest cosines.
        """
        from scipy.special import log_ndtr, logsumexp

        scene, n = self.scene, len(self.y)
        linear = scene.columns(form, shapes)
        X = np.column_stack([linear, scene.derivatives(form, shapes)[0] * sizes[len(sizes) - form.shapes :]])
        # About the values that were found: what is whitened is of the size of the noise, and so is its rounding.
        near, found = np.concatenate([sizes, shapes]), linear @ sizes
        y = self.y - found
        unit = np.sqrt((X**2).mean(axis=0)) + 1e-300
        means, widths = scene.prior(form)
        means, widths, near = means * unit, widths * unit, near * unit
        white = self.noise.whitening @ np.column_stack([X / unit, y])
        W, Y = white[..., :-1], white[..., -1]
        q = X.shape[1]
        proper = np.isfinite(widths)
        known = np.diag(1.0 / widths)
        expected = np.where(proper, (means - near) / widths, 0.0)
        # By triangular factors: normal equations would lose half of the digits.
        Q, R = np.linalg.qr(W)
        seen = np.einsum("gni,gn->gi", Q, Y)
        squares = np.maximum(((Y - np.einsum("gni,gi->gn", Q, seen)) ** 2).sum(axis=1), self.floor)
        s2 = squares / (n - q)
        both, factor = _joined(R, known, s2)
        right = np.concatenate([seen / np.sqrt(s2)[:, None], np.broadcast_to(expected, seen.shape)], axis=1)
        values = np.linalg.solve(factor, np.einsum("gni,gn->gi", both, right)[..., None])[..., 0]
        rest = Y - np.einsum("gni,gi->gn", W, values)
        away = np.where(proper, (values + near - means) / widths, 0.0)
        low = np.maximum(level(rest, W, _inverse(factor) / s2[:, None, None], cosines(n, q)), self.floor / n)
        covariance = _inverse(_joined(R, known, low)[1])
        log_det = 2 * np.log(np.abs(np.diagonal(factor, axis1=1, axis2=2))).sum(axis=1)
        logs = (
            -0.5 * self.noise.log_det - 0.5 * n * np.log(s2) - 0.5 * (rest**2).sum(axis=1) / s2
            - 0.5 * (away**2).sum(axis=1) - np.log(widths[proper]).sum() - 0.5 * log_det
            + lgamma(form.branches + 1) + 0.5 * np.log(2 * np.pi) * np.sum(~proper) + np.log(self.noise.prior)
        )  # fmt: skip
        values, held = values + near, scene.amplitudes(form)
        u = np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 1e-300))
        signed = log_ndtr(values[:, held] / u[:, held])
        # Half of a normal distribution has twice the density.
        logs = logs + signed.sum(axis=1) + log(2) * int(proper[held].sum())
        weights = np.exp(logs - logs.max())
        weights /= weights.sum()
        mean = weights @ values
        apart = values - mean
        total = np.einsum("g,gij->ij", weights, covariance) + np.einsum("g,gi,gj->ij", weights, apart, apart)
        # The unit of the common parameters is that of their columns: taken out, so that forms compare.
        evidence = float(logsumexp(logs) - np.log(unit[~proper]).sum())
        mean, total = mean / unit, total / np.outer(unit, unit)
        excess = float(weights @ (low / s2))
        allowed = bool((mean[held] > 0).all()) and (form.power or scene.final(form, mean) > 0)
        fitted = Fitted(
            form, evidence, mean, near / unit, total, found + X @ (mean - near / unit), excess,
            float(weights @ self.noise.memory), weights, X, allowed,
        )  # fmt: skip
        return fitted, int(np.argmax(logs))


def _joined(R: Array, known: Array, level: Array) -> tuple[Array, Array]:
    """Orthogonal and triangular factor of what the readings say at a level of the noise, with what is known before."""
    own = np.broadcast_to(known, R.shape)
    Q, factor = np.linalg.qr(np.concatenate([R / np.sqrt(level)[:, None, None], own], axis=1))
    return np.asarray(Q), np.asarray(factor)


def _inverse(factor: Array) -> Array:
    """(RᵀR)⁻¹ of a triangular factor."""
    inverse = np.linalg.solve(factor, np.broadcast_to(np.eye(factor.shape[-1]), factor.shape))
    return np.asarray(inverse @ np.swapaxes(inverse, 1, 2))
