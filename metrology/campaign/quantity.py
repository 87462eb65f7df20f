"""A quantity as a campaign file states it: value with unit, and every component of its uncertainty (JCGM 100:2008, clause 4)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field, GetJsonSchemaHandler, PrivateAttr, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology import units
from metrology.campaign.entry import (
    Entry,
    Number,
    Positive,
    Probability,
    Refusal,
    Text,
    from_text,
    ranged,
    refuse,
    show,
)
from metrology.dimensions import Dimension, TextError, quoted

if TYPE_CHECKING:
    from metrology.gum.distributions import Distribution
    from metrology.gum.inputs import Component, Input

DistributionName = Literal[
    "normal", "student", "rectangular", "triangular", "trapezoidal", "arcsine", "curvilinear-trapezoid"
]
#: Distributions that a half-width describes, with the parameter that each needs besides.
BOUNDED = {
    "rectangular": "",
    "triangular": "",
    "trapezoidal": "beta",
    "arcsine": "",
    "curvilinear-trapezoid": "limit_half_width",
}
AMOUNTS = ("standard", "half_width", "expanded", "scale")
_RELATIVE = ("%", "‰", "ppm", "ppb")


Beta = Annotated[
    Number, AfterValidator(ranged(0, 1, "the ratio of the top of the trapezoid to its base, between 0 and 1"))
]


class StatedComponent(Entry):
    """One cause of uncertainty: its size, its distribution, and where the figure comes from."""

    name: Text = Field(
        "", description="What causes it; the row of the budget bears this name.", examples=["certificate"]
    )
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
        description="Coverage probability of `expanded` where no `k` is given; k is Student's t for `dof`, normal without.",
        examples=["0.95"],
    )
    distribution: DistributionName | None = Field(
        None,
        description="What is known about the influence: `normal` where nothing is said (with `dof`, Student's t), or the shape over the half-width.",
        examples=["rectangular"],
    )
    beta: Beta | None = Field(None, description="`trapezoidal`: ratio of top to base, β.", examples=["0.5"])
    limit_half_width: Text | None = Field(
        None,
        description="`curvilinear-trapezoid`: half-width d of the interval in which the limits ± a themselves are known.",
        examples=["0.1 mm"],
    )
    dof: Positive | None = Field(
        None, description="Degrees of freedom of u; infinite where nothing is said.", examples=["9"]
    )
    type: Literal["A", "B"] = Field(
        "B", description="Type of evaluation: A from readings, B otherwise.", examples=["B"]
    )
    source: Text = Field("", description="Where the figure comes from.", examples=["certificate C-123"])

    @property
    def amount(self) -> str:
        """Key that gives the size: ``standard``, ``half_width``, ``expanded`` or ``scale``."""
        return next(key for key in AMOUNTS if getattr(self, key) is not None)

    @property
    def shape(self) -> str:
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
        return rules() + self._stray_keys(given[0])

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
            mend = "write 'standard' or 'expanded' for a distribution without limits"
            return [Refusal(("distribution",), f"'{self.distribution}' with 'half_width'", f"one of {names}", mend)]
        needed = BOUNDED[self.distribution]
        if needed and getattr(self, needed) is None:
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
        if self.distribution in BOUNDED:
            mend = "write the half-width of the interval"
            return [
                Refusal(
                    (amount,),
                    f"'{amount}' with '{self.distribution}'",
                    f"'half_width' with '{self.distribution}'",
                    mend,
                )
            ]
        if self.shape == "student" and self.dof is None:
            return [Refusal((), "'student' without 'dof'", "the degrees of freedom, such as 'dof: 4'")]
        if amount == "scale" and self.shape != "student":
            return [Refusal(("scale",), "'scale' with 'normal'", "'standard' with 'normal'")]
        if amount == "standard" and self.distribution == "student" and self.dof is not None and self.dof <= 2:
            mend = "write 'scale'"
            return [
                Refusal(
                    ("dof",),
                    f"{self.dof:g} with 'student' and 'standard'",
                    "more than 2: t has no standard deviation below",
                    mend,
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


@dataclass(frozen=True)
class Sized:
    """A component with its size in SI: `amount` is what the component's key says, `limit` the half-width of its limits."""

    stated: StatedComponent
    amount: float
    limit: float = 0.0

    def distribution(self) -> Distribution:
        """Distribution of the influence, in SI."""
        from metrology.gum import distributions as of

        stated, a = self.stated, self.amount
        if stated.amount == "half_width":
            makers = {
                "rectangular": lambda: of.Rectangular(a),
                "triangular": lambda: of.Triangular(a),
                "trapezoidal": lambda: of.Trapezoidal(a, stated.beta or 0.0),
                "arcsine": lambda: of.Arcsine(a),
                "curvilinear-trapezoid": lambda: of.CurvilinearTrapezoid(a, self.limit),
            }
            return makers[stated.shape]()
        return self._unbounded()

    def _unbounded(self) -> Distribution:
        from metrology.gum import distributions as of

        stated = self.stated
        u = self.amount
        if stated.amount == "expanded":
            u /= stated.k or self._factor()
        return of.Normal(u) if stated.dof is None else of.Student(u, stated.dof)

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
        return Component(stated.name or default, self.distribution(), dof, stated.type, stated.source)


class Stated(Entry):
    """A quantity: value and unit in one text, or a mapping with the components of its uncertainty.

    `quantity` is the parsed text; `si` the value in SI, `unit` as written, `si_unit`; `input(name)` makes the `gum.Input`.
    """

    value: Text = Field(
        description="Value with unit, with or without its standard uncertainty.", examples=["25.00 mm", "25.00(5) mm"]
    )
    uncertainty: tuple[StatedComponent, ...] = Field(
        (),
        description="Components of the uncertainty, independent of one another.",
        examples=["[{half_width: 2 mm, distribution: rectangular, source: steel tape}]"],
    )
    description: Text = Field("", description="What it is, in the words of the report.", examples=["width of the tape"])
    source: Text = Field("", description="Where the value comes from.", examples=["micrometer readings"])
    _quantity: units.Quantity = PrivateAttr()
    _sized: tuple[Sized, ...] = PrivateAttr(())

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        if isinstance(data, str):
            return {"value": data}
        if isinstance(data, dict) and isinstance(data.get("uncertainty"), dict):
            return data | {"uncertainty": [data["uncertainty"]]}
        if isinstance(data, dict) and isinstance(data.get("uncertainty"), str):
            mend = "write 'standard: …', 'half_width: …' with a distribution, or 'expanded: …' with k"
            raise refuse(
                Refusal(
                    ("uncertainty",), quoted(data["uncertainty"]), "a list of components, each saying what it is", mend
                )
            )
        if not isinstance(data, dict | Stated):
            raise refuse(Refusal((), show(data), "a quantity, such as '25.00(5) mm', or 'value' with 'uncertainty'"))
        return data

    @model_validator(mode="after")
    def _resolve(self) -> Stated:
        try:
            self._quantity = units.parse(self.value)
        except TextError as error:
            raise refuse(from_text(error, "value")) from None
        if self._quantity.u is not None and self.uncertainty:
            mend = "keep one of the two"
            raise refuse(
                Refusal(("value",), f"{quoted(self.value)} and 'uncertainty' beside it", "the uncertainty once", mend)
            )
        found: list[Refusal] = []
        self._sized = tuple(self._size(index, component, found) for index, component in enumerate(self.uncertainty))
        if found:
            raise refuse(*found)
        return self

    def _size(self, index: int, component: StatedComponent, found: list[Refusal]) -> Sized:
        sizes = []
        for key in (component.amount, "limit_half_width"):
            text = getattr(component, key)
            try:
                sizes.append(0.0 if text is None else self._amount(text))
            except TextError as error:
                found.append(from_text(error, "uncertainty", index, key))
                sizes.append(1.0)
        if sizes[1] > sizes[0]:
            got = f"{quoted(component.limit_half_width)}, more than the half-width"
            found.append(Refusal(("uncertainty", index, "limit_half_width"), got, "less than 'half_width'"))
        return Sized(component, *sizes)

    def _amount(self, text: str) -> float:
        """Size of a component in SI: in a unit of the value's dimension, or in % of a value that is no number itself."""
        amount = units.parse(text, difference=True)
        if amount.u is not None:
            raise units.UnitError(quoted(text), "the size of the uncertainty alone, such as '0.05 mm'")
        if amount.value <= 0:
            raise units.UnitError(
                quoted(text), "an uncertainty greater than zero", "leave the component out where there is none"
            )
        if amount.unit not in _RELATIVE:
            return units.parse(text, expected=self._quantity.unit, difference=True).value
        return self._relative(text, amount.value)

    def _relative(self, text: str, share: float) -> float:
        if self._quantity.dimension.dimensionless:
            mend = f"write it as '{self.value}' is written, '14.0(2) %', or as a number without a unit"
            raise units.UnitError(f"{quoted(text)} of a number, absolute or relative", "an absolute uncertainty", mend)
        if self._quantity.value == 0 or units.unit(self._quantity.unit).offset:
            raise units.UnitError(
                f"{quoted(text)} of {quoted(self.value)}", "an absolute uncertainty", "write it with a unit"
            )
        return abs(self._quantity.value) * share

    @property
    def quantity(self) -> units.Quantity:
        """Value as parsed, with the unit and the digits in which it is written."""
        return self._quantity

    @property
    def si(self) -> float:
        """Value in SI."""
        return self._quantity.value

    @property
    def unit(self) -> str:
        """Unit as written, in canonical form."""
        return self._quantity.unit

    @property
    def si_unit(self) -> str:
        """Coherent SI unit."""
        return units.si_unit(self._quantity.unit)

    @property
    def dimension(self) -> Dimension:
        """Dimension of the quantity."""
        return self._quantity.dimension

    @property
    def components(self) -> tuple[Component, ...]:
        """Components of the uncertainty in SI, as `gum` takes them."""
        if self._quantity.u is not None:
            from metrology.gum.distributions import Normal
            from metrology.gum.inputs import Component

            return (Component("stated", Normal(self._quantity.u), source=self.source),)
        return tuple(sized.component("stated") for sized in self._sized)

    @property
    def u(self) -> float:
        """Combined standard uncertainty, in SI; zero for a constant."""
        return sqrt(sum(component.u**2 for component in self.components))

    def input(self, name: str, description: str = "") -> Input:
        """The quantity as an input of a measurement model.

        Parameters
        ----------
        name : str
            Unique name within the campaign, such as ``"al-1100.length"``.
        description : str
            In the words of the report; the one of the file goes first.
        """
        from metrology.gum.inputs import Input

        return Input(name, self.si, self.components, self.si_unit, self.description or description)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Allow the text form beside the mapping."""
        mapping = handler.resolve_ref_schema(handler(schema))
        text = {
            "type": ["string", "number"],
            "description": "Value with unit: '25.00 mm', '25.00(5) mm', '25.00 ± 0.05 mm'.",
        }
        return {"anyOf": [text, mapping]}


@dataclass(frozen=True)
class Expect:
    """Checks that a quantity has the dimension of `unit`, and its sign."""

    unit: str
    positive: bool = False

    def __call__(self, stated: Stated) -> Stated:
        """Return the quantity as it is, or refuse it."""
        try:
            units.parse(stated.value, expected=self.unit)
        except TextError as error:
            raise refuse(from_text(error, "value")) from None
        if self.positive and stated.si <= 0:
            raise refuse(Refusal(("value",), quoted(stated.value), f"{stated.dimension.name} greater than zero"))
        return stated


def of(unit: str, *, positive: bool = True) -> Any:
    """Metadata for ``Annotated[Stated, *of("N")]``: the dimension of `unit` is checked, and shown in the schema."""
    return AfterValidator(Expect(unit, positive)), Field(json_schema_extra={"x-unit": unit})


Length = Annotated[Stated, *of("m")]
Mass = Annotated[Stated, *of("kg")]
Force = Annotated[Stated, *of("N")]
Area = Annotated[Stated, *of("m^2")]
Acceleration = Annotated[Stated, *of("m/s^2")]
Density = Annotated[Stated, *of("kg/m^3")]
LinearDensity = Annotated[Stated, *of("kg/m")]
Temperature = Annotated[Stated, *of("K")]
Pressure = Annotated[Stated, *of("Pa")]
Ratio = Annotated[Stated, *of("1")]
