"""Which form a test supports, and what all forms together say of each specimen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.fit import Fitted, Fitter
from metrology.relaxation.forms import Form
from metrology.relaxation.noise import cosines

CLEAR = 7.0
"""ln of the odds by which two forms with more branches have to be less probable to end the search."""
HALF = 0.5
"""Probability from which on a form counts as supported."""
SURE = 0.95
"""Probability from which on the readings decide between two things."""
COVERED, HALVINGS = 0.95, 60
"""Probability of the interval that gives u, and how often the bracket of its half width is halved: to rounding."""
TINY = 1e-30
"""Imaginary step, as part of a value: its square vanishes beside 1."""


@dataclass(frozen=True)
class Supported:
    """The forms of a test with their probabilities, and their fits to each specimen.

    Parameters
    ----------
    forms : tuple of Form
        All that were weighed.
    probability : ndarray, shape (forms,)
        Of each, alike for all specimens.
    fits : tuple of tuple of Fitted
        By specimen, then by form.
    """

    forms: tuple[Form, ...]
    probability: Array
    fits: tuple[tuple[Fitted, ...], ...]

    @property
    def best(self) -> int:
        """Number of the most probable form."""
        return int(np.argmax(self.probability))

    @property
    def power(self) -> float:
        """Probability of a power law."""
        return float(sum(p for p, form in zip(self.probability, self.forms, strict=True) if form.power))

    @property
    def drift(self) -> float:
        """Probability of a drift."""
        return float(sum(p for p, form in zip(self.probability, self.forms, strict=True) if form.drift))


def supported(fitters: Sequence[Fitter], most: int) -> Supported:
    """Weigh every form on all specimens of a test: they are of one material, and have one form.

    All numbers of branches are as probable beforehand as one another and as a power law, with a drift of what was read
    as without one. Branches are added until two in a row are clearly less probable.
    """
    forms: list[Form] = []
    rows: list[list[Fitted]] = []
    evidence: list[float] = []

    def weigh(form: Form) -> float:
        fits = [fitter.fit(form) for fitter in fitters]
        found = sum(one.evidence for one in fits) if all(one.allowed for one in fits) else -np.inf
        forms.append(form)
        rows.append(fits)
        evidence.append(found)
        return found

    reached = 0
    best = last = weigh(Form(0))
    for m in range(1, most + 1):
        reached, found = m, weigh(Form(m))
        # One branch too few may explain less than none, where slow noise takes its place.
        if max(found, last) < best - CLEAR:
            break
        best, last = max(best, found), found
    weigh(Form(0, power=True))
    for m in range(reached + 1):
        weigh(Form(m, drift=True))
    weigh(Form(0, power=True, drift=True))
    logs = np.array(evidence)
    if not np.isfinite(logs).any():
        # What answered runs against what was imposed: no form holds, and the checks say so.
        logs[0] = 0.0
    weights = np.exp(logs - logs.max())
    return Supported(tuple(forms), weights / weights.sum(), tuple(zip(*rows, strict=True)))


@dataclass(frozen=True)
class Said:
    """Numbers that all forms together say of a specimen: mean, covariance, degrees of freedom.

    The covariance gives the 95 % intervals of Student's distribution with these degrees of freedom.
    """

    values: Array
    covariance: Array
    dof: float

    @property
    def u(self) -> Array:
        """Standard uncertainties."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def said(
    found: Supported, specimen: int, of: Callable[[Form, Array], Array], *, which: Callable[[Form], bool] | None = None
) -> Said:
    """Mean over the forms of what each says, with its covariance and that between them.

    Each form says a number with Student's distribution, all of them together a mixture of these. Its standard deviation
    is no measure of its intervals: a form of 3 % that says nothing of k_∞ would make them several times as wide as need
    be. u is therefore that of the Student's distribution which has the 95 % interval of the mixture about its mean
    (JCGM 100, 4.3.4); correlations are those of the mixture.

    Parameters
    ----------
    found : Supported
        The forms.
    specimen : int
        Number of the specimen.
    of : callable
        Numbers, shape (m,), by a form and its values; analytic, see `jacobian`.
    which : callable
        Which forms have such numbers, all where it is None; the probabilities of the others are left out.
    """
    rows = [(p, one) for p, one in zip(found.probability, found.fits[specimen], strict=True)
            if p > 1e-9 and (which is None or which(one.form))]  # fmt: skip
    weights = np.array([p for p, _ in rows]) / sum(p for p, _ in rows)
    means, covariances = [], []
    for _, one in rows:
        number, J = numbers(one, of)
        means.append(number)
        covariances.append(J @ one.covariance @ J.T)
    mean = weights @ np.array(means)
    away = np.array(means) - mean
    covariance = np.einsum("m,mij->ij", weights, np.array(covariances)) + np.einsum("m,mi,mj->ij", weights, away, away)
    # Rounding leaves it less symmetric than a covariance may be, where all numbers are one, as of an elastic specimen.
    covariance = (covariance + covariance.T) / 2
    n = len(rows[0][1].model)
    dof = float(cosines(n, max(len(one.values) for _, one in rows)))
    own = np.sqrt(np.maximum(np.diagonal(np.array(covariances), axis1=1, axis2=2), 0.0))
    half = [_half(weights, away[:, at], own[:, at], dof) for at in range(len(mean))]
    scale = np.array(half) / np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return Said(mean, covariance * np.outer(scale, scale), dof)


def _half(weights: Array, away: Array, u: Array, dof: float) -> float:
    """Standard uncertainty whose 95 % interval is that of a mixture of Student's distributions about its mean."""
    from scipy.special import stdtr, stdtrit

    reach = float(stdtrit(dof, (1 + COVERED) / 2))
    u = np.maximum(u, 1e-300)
    low, high = 0.0, float((np.abs(away) + reach * u).max())
    found = high
    for _ in range(HALVINGS):
        with np.errstate(over="ignore"):  # an end infinitely many u away has all on one side
            inside = float(weights @ (stdtr(dof, (found - away) / u) - stdtr(dof, (-found - away) / u)))
        low, high = (found, high) if inside < COVERED else (low, found)
        found = (low + high) / 2
    return found / reach


def numbers(one: Fitted, of: Callable[[Form, Array], Array]) -> tuple[Array, Array]:
    """Numbers by the values of a fit, shape (m,), and their derivatives by these, shape (m, q).

    Linear about what the search found, as the fit itself: where branches are nearly one another, or one is longer than
    the record, values far from there describe the readings as well only so. The derivatives are by an imaginary step,
    exact to rounding: Im f(x + ih)/h has no difference that rounding could enlarge (Squire & Trapp, SIAM Rev. 40 (1998)
    110); `of` takes complex values, and is analytic.
    """
    found = []
    for at, size in enumerate(np.abs(one.near).tolist()):
        step = np.zeros(len(one.near), dtype=complex)
        step[at] = 1j * TINY * (size or 1.0)
        found.append(of(one.form, one.near + step).imag / step[at].imag)
    J = np.column_stack(found)
    return np.real(of(one.form, one.near)) + J @ (one.values - one.near), J
