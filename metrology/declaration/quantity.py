"""A quantity as a campaign file states it: value, unit, and components of uncertainty (JCGM 100:2008, clause 4)."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, Field, GetJsonSchemaHandler, PrivateAttr, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology import units
from metrology.declaration.component import StatedComponent
from metrology.declaration.entry import Entry, Refusal, from_text, refuse, show
from metrology.declaration.scalars import Text
from metrology.declaration.sized import Sized, size_alone
from metrology.units.dimensions import Dimension, TextError, quoted

if TYPE_CHECKING:
    from metrology.gum.inputs import Component, Input

_RELATIVE = ("%", "‰", "ppm", "ppb")


class Stated(Entry):
    """A quantity: value and unit in one text, or a mapping with the components of its uncertainty.

    `quantity` is the parsed text, `si` the value in SI, `unit` as written; `input(name)` makes the `gum.Input`.
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
            fix = "write 'standard: …', 'half_width: …' with a distribution, or 'expanded: …' with k"
            raise refuse(
                Refusal(
                    ("uncertainty",), quoted(data["uncertainty"]), "a list of components, each saying what it is", fix
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
            fix = "keep one of the two"
            raise refuse(
                Refusal(("value",), f"{quoted(self.value)} together with 'uncertainty'", "the uncertainty once", fix)
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
        """Size of a component in SI: in a unit of the value's dimension, or in % of a value that is no mere number."""
        amount = size_alone(text)
        if amount.unit not in _RELATIVE:
            return units.parse(text, expected=self._quantity.unit, difference=True).value
        return self._relative(text, amount.value)

    def _relative(self, text: str, share: float) -> float:
        if self._quantity.dimension.dimensionless:
            fix = f"write it as '{self.value}' is written, '14.0(2) %', or as a number without a unit"
            raise units.UnitError(f"{quoted(text)} of a number, absolute or relative", "an absolute uncertainty", fix)
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

            return (Component(self.source or "stated", Normal(self._quantity.u), source=self.source),)
        return tuple(sized.component(sized.stated.shape) for sized in self._sized)

    @property
    def is_exact(self) -> bool:
        """Whether no uncertainty is stated."""
        return self._quantity.u is None and not self.uncertainty

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

        return Input(name, self.si, self.components, self.si_unit, self.description or description, is_stated=True)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Allow the text form beside the mapping."""
        mapping = handler.resolve_ref_schema(handler(schema))
        text = {
            "type": ["string", "number"],
            "description": "Value with unit: '25.00 mm', '25.00(5) mm', '25.00 ± 0.05 mm'.",
        }
        imported = {
            "type": "object",
            "description": "A result of another campaign, with its budget, from its `results.json`.",
            "properties": {key: {"type": "string", **_described(*words)} for key, words in _IMPORTED.items()},
            "required": ["from", "result", "sha256"],
            "additionalProperties": False,
        }
        return {"anyOf": [text, mapping, imported]}


_IMPORTED = {
    "from": ("The `results.json`, in the campaign's folder.", "calibration/results.json"),
    "result": ("Result, by its full name.", "cell.sensitivity"),
    "sha256": ("SHA-256 of the file.", "3fc9…"),
    "description": ("What it is, in the words of the report.", "sensitivity of the cell"),
}


def _described(description: str, example: str) -> dict[str, Any]:
    return {"description": description, "examples": [example]}


@dataclass(frozen=True)
class Expect:
    """Checks that a quantity has the dimension of `unit`, or of `other`, and its sign; `zero` lets zero through."""

    unit: str
    positive: bool = False
    other: str = ""
    zero: bool = False

    def __call__(self, stated: Stated) -> Stated:
        """Return the quantity as it is, or refuse it."""
        try:
            units.parse(stated.value, expected=self.unit)
        except TextError as error:
            if not self._is_other(stated):
                raise refuse(from_text(error, "value")) from None
        if self.positive and not (stated.si > 0 or (self.zero and stated.si == 0)):
            least = "of zero or more" if self.zero else "greater than zero"
            raise refuse(Refusal(("value",), quoted(stated.value), f"{stated.dimension.name} {least}"))
        return stated

    def _is_other(self, stated: Stated) -> bool:
        if not self.other:
            return False
        try:
            units.parse(stated.value, expected=self.other)
        except TextError:
            return False
        return True


@dataclass(frozen=True)
class ValueOnly:
    """Marks a field of which the value alone is used; `instead`: where its uncertainty is stated, if anywhere."""

    instead: str = ""


def of(unit: str, *, positive: bool = True, other: str = "", zero: bool = False) -> Any:
    """Metadata for ``Annotated[Stated, *of("N")]``: the dimension of `unit` is checked, and shown in the schema.

    A quantity of `other` is let through as well; which of the two is due is for the checks between entries to say.
    """
    shown = f"{unit} or {other}" if other else unit
    return AfterValidator(Expect(unit, positive, other, zero)), Field(json_schema_extra={"x-unit": shown})


Length = Annotated[Stated, *of("m")]
Mass = Annotated[Stated, *of("kg")]
Inertia = Annotated[Stated, *of("kg*m^2")]
Force = Annotated[Stated, *of("N")]
HangingMass = Annotated[Stated, *of("kg", zero=True)]
HangingForce = Annotated[Stated, *of("N", zero=True)]
Area = Annotated[Stated, *of("m^2")]
Acceleration = Annotated[Stated, *of("m/s^2")]
Density = Annotated[Stated, *of("kg/m^3")]
LinearDensity = Annotated[Stated, *of("kg/m")]
Temperature = Annotated[Stated, *of("K")]
Frequency = Annotated[Stated, *of("Hz")]
Pressure = Annotated[Stated, *of("Pa")]
Compliance = Annotated[Stated, *of("m/N", zero=True)]
Ratio = Annotated[Stated, *of("1", positive=False)]
