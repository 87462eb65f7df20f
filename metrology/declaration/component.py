"""One component of the uncertainty of a quantity, as a campaign file states it (JCGM 100:2008, 4.2 and 4.3)."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import Annotated, Literal

from pydantic import Field, model_validator

from metrology.declaration.entry import Entry, Refusal, refuse
from metrology.declaration.scalars import Number, Positive, Probability, Text, ranged

DistributionName = Literal[
    "normal",
    "student",
    "rectangular",
    "triangular",
    "trapezoidal",
    "arcsine",
    "curvilinear-trapezoid",
    "exponential",
    "gamma",
    "lognormal",
    "truncated-normal",
    "beta",
    "asymmetric",
]
#: Distributions that a half-width describes, with the parameter that each needs besides.
BOUNDED = {
    "rectangular": "",
    "triangular": "",
    "trapezoidal": "beta",
    "arcsine": "",
    "curvilinear-trapezoid": "limit_half_width",
    "beta": "parameters",
    "asymmetric": "parameters",
}
#: Half-width over u of those whose width follows from u alone, by β of the trapezoid.
WIDTHS: dict[str, Callable[[float], float]] = {
    "rectangular": lambda _: sqrt(3),
    "triangular": lambda _: sqrt(6),
    "trapezoidal": lambda beta: sqrt(6 / (1 + beta**2)),
    "arcsine": lambda _: sqrt(2),
}
#: Distributions with parameters of their own, by how many.
PARAMETERS = {"gamma": 1, "lognormal": 1, "truncated-normal": 1, "beta": 2, "asymmetric": 1}
_ONE_SIDED = ("exponential", "gamma", "lognormal", "truncated-normal")
_RATIOS = (0.02, 50.0)
AMOUNTS = ("standard", "half_width", "expanded", "scale")


Beta = Annotated[Number, ranged(0, 1, "the ratio of the top of the trapezoid to its base, between 0 and 1")]


class Sizes(Entry):
    """Size and distribution of an uncertainty, and where the figure comes from."""

    standard: Text | None = Field(None, description="Standard uncertainty u (1 σ).", examples=["0.05 mm", "5 %"])
    half_width: Text | None = Field(
        None,
        description="Half-width a of the interval value ± a that contains the value; needs `distribution`.",
        examples=["2 mm"],
    )
    expanded: Text | None = Field(
        None,
        description="Expanded uncertainty U, as certificates give it; needs `k`, or `p` with `dof`.",
        examples=["4 um"],
    )
    scale: Text | None = Field(
        None, description="Scale of a `student` distribution, s/√n of n readings.", examples=["0.02 mm"]
    )
    k: Positive | None = Field(None, description="Coverage factor of `expanded`: u = U/k.", examples=["2"])
    p: Probability | None = Field(
        None,
        description="Coverage probability of `expanded` where no `k` is given; k is Student's t for `dof`, "
        "normal without.",
        examples=["0.95"],
    )
    distribution: DistributionName | None = Field(
        None,
        description="What is known about the influence: `normal` where nothing is said (with `dof`, Student's "
        "t), or the shape over the half-width.",
        examples=["rectangular"],
    )
    beta: Beta | None = Field(None, description="`trapezoidal`: ratio of top to base, β.", examples=["0.5"])
    limit_half_width: Text | None = Field(
        None,
        description="`curvilinear-trapezoid`: half-width d of the interval in which the limits ± a themselves "
        "are known.",
        examples=["0.1 mm"],
    )
    parameters: tuple[Positive, ...] = Field(
        (),
        description="`gamma`: [shape k]; `lognormal`: [standard deviation of the logarithm]; `truncated-normal`: [cut, "
        "in standard deviations]; `beta`: [α, β]; `asymmetric`: [distance of the upper limit over that of the lower].",
        examples=["[2, 5]"],
    )
    dof: Positive | None = Field(
        None, description="Degrees of freedom of u; infinite where nothing is said.", examples=["9"]
    )
    type: Literal["A", "B"] = Field(
        "B", description="Type of evaluation: A from readings, B otherwise.", examples=["B"]
    )
    source: Text = Field("", description="Where the figure comes from.", examples=["certificate C-123"])


class StatedCause(Sizes):
    """A cause of uncertainty that several quantities share: one micrometer, one balance, one certificate.

    A component that names it under `cause` takes from here what it does not state itself.
    """

    description: Text = Field("", description="What it is, in the words of the report.", examples=["micrometer no. 7"])


class StatedComponent(Sizes):
    """One cause of uncertainty: its size, its distribution, and where the figure comes from."""

    name: Text = Field(
        "",
        description="What causes it; the row of the budget bears this name, or the source where there is none.",
        examples=["certificate"],
    )
    cause: Text = Field(
        "",
        description="Name under `causes`: all components with this cause are one unknown value, so the quantities are "
        "correlated. What is not stated here is taken from there.",
        examples=["micrometer"],
    )
    direction: Literal["same", "opposite"] = Field(
        "same",
        description="Whether the `cause` makes this quantity greater where it makes others greater, or smaller.",
        examples=["opposite"],
    )

    @property
    def amount(self) -> str:
        """Key that gives the size: ``standard``, ``half_width``, ``expanded`` or ``scale``."""
        return next(key for key in AMOUNTS if getattr(self, key) is not None)

    @property
    def shape(self) -> DistributionName:
        """Name of the distribution."""
        return self.distribution or ("student" if self.amount == "scale" else "normal")

    @model_validator(mode="after")
    def _fit_together(self) -> StatedComponent:
        found = list(self._contradictions())
        if found:
            raise refuse(*found)
        return self

    def _contradictions(self) -> list[Refusal]:
        given = [key for key in AMOUNTS if getattr(self, key) is not None]
        if len(given) != 1:
            got = f"{' and '.join(given)} together" if given else "no size"
            return [Refusal((), got, "one of 'standard', 'half_width' or 'expanded', such as 'standard: 0.05 mm'")]
        rules = {"half_width": self._bounded_rules, "expanded": self._expanded_rules}.get(
            given[0], self._standard_rules
        )
        return rules() + self._own_parameters() + self._stray_keys(given[0])

    def _own_parameters(self) -> list[Refusal]:
        due, got = PARAMETERS.get(self.distribution or "", 0), len(self.parameters)
        if due != got:
            expected = f"{due} with '{self.distribution}'" if due else "none with this distribution"
            return [Refusal(("parameters",) if got else (), f"{got} parameters", expected)]
        if self.distribution == "asymmetric" and not _RATIOS[0] <= self.parameters[0] <= _RATIOS[1]:
            return [Refusal(("parameters", 0), f"{self.parameters[0]:g}", "a ratio from 0.02 to 50")]
        return []

    def _bounded_rules(self) -> list[Refusal]:
        names = ", ".join(BOUNDED)
        if self.distribution is None:
            return [
                Refusal(
                    (),
                    "'half_width' without 'distribution'",
                    f"one of {names}",
                    "'rectangular' where nothing favours the middle",
                )
            ]
        if self.distribution not in BOUNDED:
            fix = "write 'standard' or 'expanded' for a distribution without limits"
            return [Refusal(("distribution",), f"'{self.distribution}' with 'half_width'", f"one of {names}", fix)]
        needed = BOUNDED[self.distribution]
        if needed not in ("", "parameters") and getattr(self, needed) is None:
            return [Refusal((), f"'{self.distribution}' without '{needed}'", f"'{needed}' too")]
        return []

    def _expanded_rules(self) -> list[Refusal]:
        if (self.k is None) == (self.p is None):
            got = "'expanded' without 'k'" if self.k is None else "'k' and 'p' together"
            return [
                Refusal(
                    (), got, "the coverage factor 'k: 2', or the probability 'p: 0.95' (with 'dof' where it is known)"
                )
            ]
        return self._unbounded("expanded")

    def _standard_rules(self) -> list[Refusal]:
        return self._unbounded(self.amount)

    def _unbounded(self, amount: str) -> list[Refusal]:
        if amount == "standard" and self.distribution in WIDTHS:
            if self.distribution == "trapezoidal" and self.beta is None:
                return [Refusal((), "'trapezoidal' without 'beta'", "'beta' too")]
            return []
        if amount != "standard" and self.distribution in _ONE_SIDED:
            return [Refusal((amount,), f"'{amount}' with '{self.distribution}'", "'standard' with it")]
        if self.distribution in BOUNDED:
            fix = "write the half-width of the interval"
            return [
                Refusal(
                    (amount,),
                    f"'{amount}' with '{self.distribution}'",
                    f"'half_width' with '{self.distribution}'",
                    fix,
                )
            ]
        if self.shape == "student" and self.dof is None:
            return [Refusal((), "'student' without 'dof'", "the degrees of freedom, such as 'dof: 4'")]
        if amount == "scale" and self.shape != "student":
            return [Refusal(("scale",), "'scale' with 'normal'", "'standard' with 'normal'")]
        if amount == "standard" and self.distribution == "student" and self.dof is not None and self.dof <= 2:
            fix = "write 'scale'"
            return [
                Refusal(
                    ("dof",),
                    f"{self.dof:g} with 'student' and 'standard'",
                    "more than 2: t has no standard deviation below",
                    fix,
                )
            ]
        return []

    def _stray_keys(self, amount: str) -> list[Refusal]:
        homes = {"k": amount == "expanded", "p": amount == "expanded", "beta": self.distribution == "trapezoidal"}
        homes["limit_half_width"] = self.distribution == "curvilinear-trapezoid"
        belongs = {
            "k": "'expanded'",
            "p": "'expanded'",
            "beta": "'trapezoidal'",
            "limit_half_width": "'curvilinear-trapezoid'",
        }
        return [
            Refusal((key,), f"'{key}' without {belongs[key]}", f"'{key}' with {belongs[key]} only")
            for key, at_home in homes.items()
            if getattr(self, key) is not None and not at_home
        ]
