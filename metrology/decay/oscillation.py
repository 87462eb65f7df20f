"""Decaying oscillations over a drifting baseline, fitted to a record by variable projection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, pi
from typing import Literal

import numpy as np

from metrology.decay.correlated import degrees_of_freedom, sandwich

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Form = Literal["viscous", "dry", "quadratic"]

DEGREE = 4
"""Degree of the polynomial that stands for offset and drift of the record."""


@dataclass(frozen=True)
class Mode:
    """One oscillation: angular frequency ω (rad/s), decay rate λ (1/s), and the parameter β (1/s) of a further damping.

    Amplitude A(t), relative to A(0), with E = e^{−λt} and φ = (1 − E)/λ:

    - viscous: E;
    - dry: E − β·φ, until it is zero (solution of dA/dt = −λ·A − β·A(0));
    - quadratic: E / (1 + β·φ) (solution of dA/dt = −λ·A − β·A²/A(0)).
    """

    omega: float
    rate: float
    beta: float = 0.0

    @property
    def frequency(self) -> float:
        """Frequency in Hz."""
        return self.omega / (2 * pi)


def _envelope(t: Floats, mode: Mode, form: Form) -> tuple[Floats, Floats, Floats]:
    """Return A(t)/A(0) and its derivatives by λ and by β."""
    exponent = np.clip(-mode.rate * t, -60.0, 6.0)
    decay = np.exp(exponent)
    if form == "viscous":
        return decay, -t * decay, np.zeros_like(t)
    small = abs(mode.rate) * t[-1] < 1e-5
    phi = t - mode.rate * t**2 / 2 if small else -np.expm1(exponent) / mode.rate
    phi_rate = -(t**2) / 2 if small else (t * decay - phi) / mode.rate
    if form == "dry":
        amplitude = decay - mode.beta * phi
        moving = amplitude > 0
        return amplitude * moving, (-t * decay - mode.beta * phi_rate) * moving, -phi * moving
    divisor = np.maximum(1 + mode.beta * phi, 1e-3)
    amplitude = decay / divisor
    return amplitude, (-t * decay - amplitude * mode.beta * phi_rate) / divisor, -amplitude * phi / divisor


def _columns(t: Floats, mode: Mode, form: Form) -> tuple[Floats, list[Floats]]:
    """Return the two columns of a mode, shape (n, 2), and the derivatives of both by ω, λ and (not viscous) β."""
    turn = np.exp(1j * mode.omega * t)
    envelope, by_rate, by_beta = _envelope(t, mode, form)
    parts = [envelope * turn, 1j * t * envelope * turn, by_rate * turn]
    if form != "viscous":
        parts.append(by_beta * turn)
    both = [np.column_stack([part.real, part.imag]) for part in parts]
    return both[0], both[1:]


def baseline(t: Floats, held: Sequence[Mode] = (), degree: int = DEGREE, settling: float = 0.0) -> Floats:
    """Return an orthonormal basis, shape (n, ·), of the drift of the record and of modes whose ω and λ are held.

    `settling`: rate / (1/s) at which the zero settles; 0 where it does not.
    """
    scaled = 2 * t / t[-1] - 1
    columns = [np.vander(scaled, degree + 1)]
    if settling:
        columns.append(np.exp(-settling * t)[:, None])
    columns += [_columns(t, mode, "viscous")[0] for mode in held]
    basis: Floats = np.linalg.qr(np.hstack(columns))[0]
    return basis


def tangent(t: Floats, fitted: Fit) -> Floats:
    """Return what small changes of a fit do at times t, shape (n, ·): polynomial, modes, and their ω, λ (and β)."""
    found = [baseline(t, degree=fitted.degree, settling=fitted.settling)]
    for place, (mode, c) in enumerate(zip(fitted.modes, fitted.coefficients, strict=True)):
        columns, by = _columns(t, mode, fitted.form if place == 0 else "viscous")
        found += [columns, *((d @ c)[:, None] for d in by)]
    return np.hstack(found)


@dataclass(frozen=True)
class Projection:
    """Residual of the best linear combination at given modes, its derivatives (n, p), and coefficients."""

    residual: Floats
    jacobian: Floats
    coefficients: Floats


def project(t: Floats, y: Floats, modes: Sequence[Mode], base: Floats, form: Form = "viscous") -> Projection:
    """Return y less its projection on modes and baseline, with Kaufman's derivative by every ω, λ (and β of the first).

    Golub & Pereyra, Inverse Problems 19 (2003) R1; Kaufman, BIT 15 (1975) 49.
    """
    pairs = [_columns(t, mode, form if i == 0 else "viscous") for i, mode in enumerate(modes)]
    matrix = np.hstack([columns for columns, _ in pairs])
    flat = matrix - base @ (base.T @ matrix)
    q, r = np.linalg.qr(flat)
    level = y - base @ (base.T @ y)
    coefficients = np.linalg.lstsq(r, q.T @ level, rcond=1e-12)[0].reshape(-1, 2)
    slopes = np.column_stack([d @ c for (_, by), c in zip(pairs, coefficients, strict=True) for d in by])
    slopes -= base @ (base.T @ slopes)
    slopes -= q @ (q.T @ slopes)
    return Projection(level - q @ (q.T @ level), -slopes, coefficients)


@dataclass(frozen=True)
class Fit:
    """Modes fitted to a record, the first the longitudinal one; `covariance` of its ω, λ (and β), with `dof`.

    `coefficients[j]` = (a, b): mode j is A(t)·(a·cos ωt + b·sin ωt), t from the first sample fitted. `degree`: of the
    polynomial that stands for offset and drift. `settling`: rate / (1/s) at which the zero settles, or 0.
    """

    modes: tuple[Mode, ...]
    form: Form
    coefficients: Floats
    covariance: Floats
    residual: Floats
    converged: bool
    dof: float
    degree: int = DEGREE
    settling: float = 0.0

    @property
    def slow(self) -> int:
        """Number of columns that stand for offset, drift and settling."""
        return self.degree + 1 + (self.settling > 0)

    @property
    def main(self) -> Mode:
        """The longitudinal mode."""
        return self.modes[0]

    @property
    def amplitudes(self) -> Floats:
        """Amplitude of every mode at the first sample, in the unit of the record."""
        amplitudes: Floats = np.hypot(self.coefficients[:, 0], self.coefficients[:, 1])
        return amplitudes

    @property
    def others(self) -> list[tuple[Mode, float]]:
        """Every further mode, with its amplitude."""
        return list(zip(self.modes, self.amplitudes.tolist(), strict=True))[1:]

    @property
    def squares(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residual @ self.residual)

    def part(self, t: Floats, index: int = 0) -> Floats:
        """Return one mode at times t (s, from the first sample fitted)."""
        columns, _ = _columns(t, self.modes[index], self.form if index == 0 else "viscous")
        value: Floats = columns @ self.coefficients[index]
        return value


def _pack(modes: Sequence[Mode], form: Form) -> Floats:
    first = [modes[0].omega, modes[0].rate] + ([] if form == "viscous" else [modes[0].beta])
    return np.array(first + [x for mode in modes[1:] for x in (mode.omega, mode.rate)])


def _unpack(theta: Floats, form: Form) -> tuple[Mode, ...]:
    own = 2 if form == "viscous" else 3
    rest = theta[own:].reshape(-1, 2)
    return (Mode(*map(float, theta[:own])), *(Mode(float(omega), float(rate)) for omega, rate in rest))


def fit(
    t: Floats,
    y: Floats,
    start: Sequence[Mode],
    *,
    held: Sequence[Mode] = (),
    form: Form = "viscous",
    lags: int,
    degree: int = DEGREE,
    settling: float = 0.0,
) -> Fit:
    """Fit y(t) = Σ_j A_j(t)·(a_j·cos ω_j t + b_j·sin ω_j t) + polynomial by nonlinear least squares.

    Parameters
    ----------
    t, y : ndarray, shape (n,)
        Times in s from the first sample fitted, evenly spaced, and the record.
    start : sequence of Mode
        Where to begin; the first is the longitudinal mode.
    held : sequence of Mode
        Further modes whose ω and λ stay as they are, only their amplitudes are fitted.
    form : {"viscous", "dry", "quadratic"}
        Damping of the first mode; the others decay exponentially.
    lags : int
        Samples over which residuals are taken to be correlated (see `correlated.sandwich`).
    degree : int
        Of the polynomial that stands for offset and drift.
    settling : float
        Rate / (1/s) at which the zero settles; 0 where it does not.
    """
    from scipy.optimize import least_squares

    base = baseline(t, held, degree, settling)
    last: dict[bytes, Projection] = {}

    def at(theta: Floats) -> Projection:
        key = theta.tobytes()
        if key not in last:
            last.clear()
            last[key] = project(t, y, _unpack(theta, form), base, form)
        return last[key]

    def residual(theta: Floats) -> Floats:
        return at(theta).residual

    def jacobian(theta: Floats) -> Floats:
        return at(theta).jacobian

    found = least_squares(
        residual,
        _pack(start, form),
        jac=jacobian,
        method="lm",
        x_scale="jac",
        xtol=1e-9,
        ftol=1e-10,
        max_nfev=40,
    )
    theta = _finished(at, found.x) if found.success else found.x
    modes = tuple(replace(mode, omega=abs(mode.omega)) for mode in _unpack(theta, form))  # the same mode either way
    here = at(_pack(modes, form))
    own = 2 if form == "viscous" else 3
    shapes = [_columns(t, mode, form if place == 0 else "viscous")[0] for place, mode in enumerate(modes)]
    taken = np.linalg.qr(np.hstack([base, *shapes, here.jacobian]))[0]
    covariance = sandwich(here.jacobian, here.residual, lags, taken)
    own_covariance, dof = covariance[:own, :own], degrees_of_freedom(t.size, lags)
    converged = bool(found.success)
    return Fit(modes, form, here.coefficients, own_covariance, here.residual, converged, dof, degree, settling)


MOST_FINISHING = 20
"""Steps of the end; each is at most half as long as the one before, so that these reach 10⁻⁶ of the first."""


def _finished(at: Callable[[Floats], Projection], theta: Floats) -> Floats:
    """Gauss–Newton steps from a minimum on, as long as each is at most half of the one before.

    A sum of squares shows where its minimum lies to half of the digits only; the rest would depend on the order in
    which a processor sums.
    """
    last = inf
    for _ in range(MOST_FINISHING):
        here = at(theta)
        scale = np.linalg.norm(here.jacobian, axis=0)
        scale[scale == 0] = 1.0
        step = np.linalg.lstsq(here.jacobian / scale, -here.residual, rcond=None)[0]
        length = float(np.linalg.norm(step))
        if not length < 0.5 * last:
            break
        theta, last = theta + step / scale, length
    return theta


def at_rate(fitted: Fit, t: Floats, y: Floats, *, held: Sequence[Mode] = ()) -> Fit:
    """Return the fit and the modes held, with coefficients and residuals from another sampling of the record."""
    modes = (*fitted.modes, *held)
    here = project(t, y, modes, baseline(t, degree=fitted.degree, settling=fitted.settling), fitted.form)
    return replace(fitted, modes=modes, coefficients=here.coefficients, residual=here.residual)
