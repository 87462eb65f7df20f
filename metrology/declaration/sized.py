"""Sizes of stated components of uncertainty in SI, and the distributions that they describe."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from metrology import units
from metrology.declaration.component import WIDTHS, StatedComponent
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.gum.influence import Distribution
    from metrology.gum.inputs import Component


def size_alone(text: str) -> units.Quantity:
    """Size of a component as written: one amount, or a share, greater than zero.

    Raises
    ------
    UnitError
        For an amount with an uncertainty of its own, for zero and less.
    """
    amount = units.parse(text, difference=True)
    if amount.u is not None:
        raise units.UnitError(quoted(text), "the size of the uncertainty alone, such as '0.05 mm'")
    if amount.value <= 0:
        raise units.UnitError(
            quoted(text), "an uncertainty greater than zero", "leave the component out where there is none"
        )
    return amount


@dataclass(frozen=True)
class Sized:
    """A component with its size in SI: `amount` is what its key says, `limit` the half-width of its limits."""

    stated: StatedComponent
    amount: float
    limit: float = 0.0

    def distribution(self) -> Distribution:
        """Distribution of the influence, in SI."""
        from metrology.gum import bounded, skewed

        stated, a = self.stated, self.amount
        if stated.shape in ("normal", "student"):
            return self._unbounded()
        if stated.shape == "trapezoidal":
            return bounded.Trapezoidal(self._half_width(), stated.beta or 0.0)
        if stated.shape == "curvilinear-trapezoid":
            return bounded.CurvilinearTrapezoid(a, self.limit)
        by_width: dict[str, Callable[[float], Distribution]] = {
            "rectangular": bounded.Rectangular,
            "triangular": bounded.Triangular,
            "arcsine": bounded.Arcsine,
        }
        if stated.shape in by_width:
            return by_width[stated.shape](self._half_width())
        return skewed.SKEWED[stated.shape](a, *stated.parameters)

    def _half_width(self) -> float:
        """Half-width of a shape that may be stated by its standard uncertainty too."""
        stated = self.stated
        known = stated.amount == "standard"
        return self.amount * (WIDTHS[stated.shape](stated.beta or 0.0) if known else 1.0)

    def _unbounded(self) -> Distribution:
        from metrology.gum import distributions as of

        stated, u = self.stated, self.amount
        if stated.amount == "expanded":
            u /= stated.k or self._factor()
        if stated.shape == "normal" or stated.dof is None:
            return of.Normal(u)
        by_deviation = stated.amount == "standard"
        return of.Student.by_deviation(u, stated.dof) if by_deviation else of.Student(u, stated.dof)

    def _factor(self) -> float:
        """Coverage factor of the stated probability: Student's t, or the normal quantile."""
        from metrology.gum import distributions as of

        unit = of.Normal(1.0) if self.stated.dof is None else of.Student(1.0, self.stated.dof)
        return float(unit.quantile((1 + (self.stated.p or 0.95)) / 2))

    def component(self, default: str) -> Component:
        """The same as a component of a `gum.Input`."""
        from metrology.gum.inputs import Component

        stated = self.stated
        dof = inf if stated.dof is None else stated.dof
        name = stated.name or stated.cause or stated.source or default
        return Component(
            name, self.distribution(), dof, stated.type, stated.source, stated.cause, stated.direction == "opposite"
        )
