"""The forms that a relaxation or a creep may have: their columns, their moduli, what they say of a specimen."""

from __future__ import annotations

from dataclasses import dataclass
from math import log, sqrt
from typing import Any, Literal

import numpy as np

from metrology.message import counted
from metrology.relaxation.blocks import Array
from metrology.relaxation.kernel import Answer

Held = Literal["elongation", "load"]
DRIFT = 0.1
"""Standard deviation of a drift beforehand: over the record a tenth of the range of the answer."""
EXPONENT = (0.25, 0.25)
"""Mean and standard deviation of an exponent beforehand."""


@dataclass(frozen=True)
class Form:
    """One form: so many branches, or a power law; with or without a drift of what was read.

    The answer is b + d·t + r₀·u ∓ Σ rᵢ·∫(1 − exp(−(t − s)/τᵢ))·u′ ds, minus for a held elongation (rᵢ lessen the
    stiffness), plus for a held load (rᵢ add to the compliance). The power law is r₁·(t/t₀)^(−α) of a held elongation,
    and r₀ + r₁·(t/t₀)^n of a held load (Findley).
    """

    branches: int
    power: bool = False
    drift: bool = False

    @property
    def name(self) -> str:
        """What it is called."""
        if self.power or not self.branches:
            return "power law" if self.power else "elastic"
        return counted("{count} branch", "{count} branches", self.branches)

    @property
    def shapes(self) -> int:
        """Parameters in which it is not linear: times, or the exponent."""
        return 1 if self.power else self.branches


@dataclass(frozen=True)
class Scene:
    """What the forms of one record share.

    Parameters
    ----------
    answer : Answer
        To the input of the record.
    held : {"elongation", "load"}
        What was held.
    unit : float
        Time t₀ of the power law / s, in the middle of the decades of the record.
    times : (float, float)
        Shortest and longest relaxation time / s that is looked for.
    scale : float
        Range of the answer over that of the input.
    """

    answer: Answer
    held: Held
    unit: float
    times: tuple[float, float]
    scale: float

    @property
    def sign(self) -> float:
        """Of the branches in the answer."""
        return -1.0 if self.held == "elongation" else 1.0

    def column(self, form: Form, shape: float) -> Array:
        """Answer of one branch (`shape` is ln τ) or of the power law (its exponent)."""
        if form.power:
            return self.answer.power(self.sign * shape, self.unit)
        return self.sign * self.answer.branch(float(np.exp(shape)))

    def columns(self, form: Form, shapes: Array) -> Array:
        """Columns of everything that is linear: b, d, r₀, then the branches; shape (n, terms)."""
        of = self.answer.of
        away = of.u - self.answer.first
        duration = of.time[-1] - of.time[0]
        found = [np.ones_like(away)]
        found += [(of.time - of.time[0]) / duration] * form.drift
        found += [away] * self.elastic(form)
        found += [self.column(form, shape) for shape in shapes]
        return np.column_stack(found)

    def elastic(self, form: Form) -> bool:
        """Whether it has a part that answers at once: all but the power law of a held elongation."""
        return not form.power or self.held == "load"

    def derivatives(self, form: Form, shapes: Array) -> tuple[Array, Array]:
        """First and second derivatives of the columns of the branches by their shapes, shape (n, shapes) each."""
        # Wide enough for what rounding leaves of a difference; its own error is 1e-4 of the derivative.
        step = 2e-2 if not form.power else 2e-3
        first, second = [], []
        for shape in shapes:
            before, now, after = (self.column(form, shape + side * step) for side in (-1, 0, 1))
            first.append((after - before) / (2 * step))
            second.append((after - 2 * now + before) / step**2)
        if not first:
            return (np.empty((len(self.answer.of.time), 0)),) * 2
        return np.column_stack(first), np.column_stack(second)

    def prior(self, form: Form) -> tuple[Array, Array]:
        """Means and standard deviations beforehand, of the linear parameters, then of the shapes.

        Infinite where all forms share a parameter. A branch has as much as all of the answer; ln τ is even over what is
        looked for, taken as a normal distribution of the same width.
        """
        span = self.scale * float(np.ptp(self.answer.of.u))
        means, widths = [0.0], [np.inf]
        if form.drift:
            means, widths = [*means, 0.0], [*widths, DRIFT * span]
        if not form.power:
            low, high = (log(time) for time in self.times)
            means += [0.0] * (1 + form.branches) + [(low + high) / 2] * form.branches
            widths += [np.inf] + [self.scale] * form.branches + [(high - low) / sqrt(12)] * form.branches
        else:
            linear = [np.inf] if self.held == "elongation" else [np.inf, self.scale]
            means, widths = [*means, *([0.0] * len(linear)), EXPONENT[0]], [*widths, *linear, EXPONENT[1]]
        return np.array(means), np.array(widths)

    def amplitudes(self, form: Form) -> slice:
        """Where in the parameters the sizes stand that cannot be negative, r₀ among them."""
        first = 1 + form.drift
        return slice(first, first + self.elastic(form) + form.shapes)

    # ---- what a form says -------------------------------------------------------------------------------------------
    def at(self, form: Form, values: Array, times: Array) -> Array:
        """r(t) after a unit step, shape (times,)."""
        first = 1 + form.drift
        if form.power:
            size, exponent = values[-2], values[-1]
            grown = size * (times / self.unit) ** (self.sign * exponent)
            return np.asarray(grown + (values[first] if self.elastic(form) else 0.0))
        m = form.branches
        sizes, taus = values[first + 1 : first + 1 + m], np.exp(values[first + 1 + m :])
        risen = -np.expm1(-times[:, None] / taus) if m else np.zeros((len(times), 0))
        return np.asarray(values[first] + self.sign * risen @ sizes)

    def at_time(self, form: Form, values: Array, time: float) -> list[Any]:
        """r(t), and by how much the stiffness falls with the logarithm of time, α = −d ln k/d ln t."""
        now, first = self.at(form, values, np.array([time]))[0], 1 + form.drift
        if form.power:
            slope = self.sign * values[-1] * values[-2] * (time / self.unit) ** (self.sign * values[-1])
        else:
            m = form.branches
            sizes, past = values[first + 1 : first + 1 + m], time / np.exp(values[first + 1 + m :])
            slope = self.sign * (sizes @ (past * np.exp(-past)))
        return [now, self.sign * slope / now]

    def initial(self, form: Form, values: Array) -> Any:
        """r₀, where there is one."""
        return values[1 + form.drift]

    def final(self, form: Form, values: Array) -> Any:
        """r∞ = r₀ ∓ Σ rᵢ."""
        first = 1 + form.drift
        return values[first] + self.sign * values[first + 1 : first + 1 + form.branches].sum()

    def moduli(self, form: Form, values: Array, frequencies: Array) -> Array:
        """Storage k′ and loss k″ at frequencies / Hz, shape (2, f); of a held load of 1/J* (Ferry 1980, ch. 3).

        k* = r₀ − Σ rᵢ/(1 + iωτᵢ), J* = r₀ + Σ rᵢ/(1 + iωτᵢ); power laws r₁·Γ(1 ± n)·(iω·t₀)^(∓n) (Tschoegl 1989,
        ch. 4, 6). In real terms, which stay analytic where the values are complex.
        """
        from scipy.special import gamma

        first, omega = 1 + form.drift, 2 * np.pi * frequencies
        if form.power:
            exponent = self.sign * values[-1]
            size = values[-2] * gamma(1 + exponent) * (omega * self.unit) ** (-exponent)
            real, imaginary = size * np.cos(exponent * np.pi / 2), -size * np.sin(exponent * np.pi / 2)
            real = real + (values[first] if self.elastic(form) else 0.0)
        else:
            m = form.branches
            sizes, past = values[first + 1 : first + 1 + m], omega[:, None] * np.exp(values[first + 1 + m :])
            each = self.sign * sizes / (1 + past**2)
            real, imaginary = values[first] + each.sum(axis=1), -(each * past).sum(axis=1)
        found = np.array([real, imaginary])
        return found if self.held == "elongation" else np.array([real, -imaginary]) / (real**2 + imaginary**2)
