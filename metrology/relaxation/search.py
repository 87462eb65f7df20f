"""Search for the most probable sizes and shapes of a form, until the gradient vanishes but for rounding."""

from __future__ import annotations

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.forms import Form, Scene

ITERATIONS = 60
"""Steps of a search at most; all but degenerate forms take fewer than ten from where the first search ends."""
SMALL = 1e-6
"""Step in ln τ, or in an exponent, below which further ones are kept only while they shrink: Newton's are then those of
the rounding within three."""


class Joint:
    """−ln of the probability of all values of a form in the metric of one colour.

    Half of |y − C(x)·s|² + Σ ((s − means)/widths)² + Σ ((x − means)/widths)², with the sizes s and the shapes x;
    `white` whitens to unit variance, and `y` is white already.
    """

    def __init__(self, scene: Scene, form: Form, white: Array, y: Array) -> None:
        self.scene, self.form, self.white, self.y = scene, form, white, y
        self.means, self.widths = scene.prior(form)
        self.terms = len(self.means) - form.shapes

    def sizes(self, shapes: Array) -> tuple[Array, Array]:
        """Most probable sizes, and all weighted residuals: of the record, of the sizes, of the shapes."""
        X = self.white @ self.scene.columns(self.form, shapes)
        known = np.diag(1.0 / self.widths[: self.terms])
        expected = np.where(np.isfinite(self.widths), self.means / self.widths, 0.0)
        rows = np.concatenate([X, known])
        right = np.concatenate([self.y, expected[: self.terms]])
        # Columns of unit length: what lstsq takes for rounding does not depend on their units.
        unit = np.sqrt((rows**2).sum(axis=0)) + 1e-300
        sizes = np.linalg.lstsq(rows / unit, right, rcond=None)[0] / unit
        away = shapes / self.widths[self.terms :] - expected[self.terms :]
        return sizes, np.concatenate([right - rows @ sizes, away])

    def newton(self, shapes: Array) -> tuple[Array, bool]:
        """Newton's step of the shapes, the sizes being the most probable ones throughout; whether it leads downhill."""
        sizes, rest = self.sizes(shapes)
        left = rest[: len(self.y)]
        X = self.white @ self.scene.columns(self.form, shapes)
        first, second = (self.white @ one for one in self.scene.derivatives(self.form, shapes))
        acting = sizes[self.terms - len(shapes) :]
        J = np.column_stack([X, first * acting])
        H = J.T @ J + np.diag(1.0 / self.widths**2)
        shape = np.arange(self.terms, len(H))
        size = shape - len(shapes)
        H[shape, shape] -= left @ second * acting
        H[shape, size] -= left @ first
        H[size, shape] -= left @ first
        gradient = -J.T @ left
        gradient[: self.terms] = 0.0
        gradient[self.terms :] += rest[len(rest) - len(shapes) :] / self.widths[self.terms :]
        unit = 1 / np.sqrt(np.abs(np.diag(H)) + 1e-300)
        values, vectors = np.linalg.eigh(H * np.outer(unit, unit))
        if values[0] <= 0:
            return np.zeros(len(shapes)), False
        step = -unit * (vectors @ ((vectors.T @ (unit * gradient)) / values))
        return step[self.terms :], True


def search(of: Joint, start: Array, ends: tuple[float, float]) -> Array:
    """Shapes at which the gradient vanishes: by least squares near to them, then by Newton's steps while these shrink.

    What ends by a tolerance ends elsewhere on another processor, by that tolerance.
    """
    from scipy.optimize import least_squares

    scale, steps = 0.1 if of.form.power else 1.0, [1e-4] * len(start)

    def rest(shapes: Array) -> Array:
        return of.sizes(shapes)[1]

    found = least_squares(rest, start, bounds=ends, x_scale=scale, diff_step=steps, xtol=1e-8,
                          ftol=1e-12, gtol=1e-12, max_nfev=40).x  # fmt: skip
    last = np.inf
    for _ in range(ITERATIONS):
        step, downhill = of.newton(found)
        size = float(np.abs(step).max())
        if not downhill or not (found + step > ends[0]).all() or not (found + step < ends[1]).all():
            break
        if size >= last and last < SMALL:
            break
        found, last = found + step, size
    return np.asarray(found)
