"""Samples of a campaign file: how each is identified, its section and its properties."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from metrology.declaration.entry import Entry
from metrology.declaration.quantity import Area, Density, Length, LinearDensity, Stated
from metrology.declaration.scalars import Day, SymbolTable, Text


class Round(Entry):
    """A round section, A = π·d²/4."""

    shape: Literal["round"] = Field(description="Shape of the section.", examples=["round"])
    diameter: Length = Field(description="Diameter d.", examples=["0.300(3) mm"])


class Ellipse(Entry):
    """An elliptic section, A = π·w·h/4 with the full axes."""

    shape: Literal["ellipse"] = Field(description="Shape of the section.", examples=["ellipse"])
    width: Length = Field(description="Full axis w.", examples=["2.00(5) mm"])
    height: Length = Field(description="Full axis h.", examples=["1.50(5) mm"])


class Tape(Entry):
    """A rectangular section, A = w·t."""

    shape: Literal["tape"] = Field(description="Shape of the section.", examples=["tape"])
    width: Length = Field(description="Width w.", examples=["25.00(5) mm"])
    thickness: Length = Field(description="Thickness t.", examples=["0.0500(27) mm"])


class GivenArea(Entry):
    """A section of which only the area is known."""

    shape: Literal["area"] = Field(description="Shape of the section.", examples=["area"])
    area: Area = Field(description="Area A.", examples=["1.25(7) mm^2"])


#: Shapes of a section by the word in the file.
SHAPES = {"round": Round, "ellipse": Ellipse, "tape": Tape, "area": GivenArea}
Section = Annotated[Round | Ellipse | Tape | GivenArea, Field(discriminator="shape")]


class Sample(Entry):
    """A sample as it is identified, and its properties."""

    name: Text = Field("", description="Name in the report; the key where nothing is said.", examples=["Al-1100 tape"])
    material: Text = Field("", description="Material.", examples=["aluminium 1100"])
    batch: Text = Field("", description="Batch or heat.", examples=["B-17"])
    condition: Text = Field("", description="Condition on receipt.", examples=["as received"])
    configuration: Text = Field(
        "",
        description="Configuration of the test article: model, build standard, changes.",
        examples=["flight spare, build 2, end loops sewn"],
    )
    received: Day | None = Field(None, description="Date of receipt.", examples=["2026-10-01"])
    section: Section | None = Field(
        None,
        description="Section: `round` (diameter), `ellipse` (width, height: full axes), `tape` (width, "
        "thickness) or `area` (area).",
        examples=["{shape: tape, width: 25.00(5) mm, thickness: 0.0500(27) mm}"],
    )
    length: Length | None = Field(None, description="Length between the clamps, unloaded.", examples=["2.990(1) m"])
    linear_density: LinearDensity | None = Field(None, description="Mass per length.", examples=["3.4 g/m"])
    density: Density | None = Field(
        None,
        description="Density of the material; held against mass per length over section.",
        examples=["1140 kg/m^3"],
    )
    references: SymbolTable[Stated] = Field(
        {},
        description="Values known from elsewhere, by the name of the quantity; compared with the results by E_n; "
        "one without an uncertainty is taken as exact. A modulus is that of the material; any other is of this very "
        "sample, and no requirement passes on a result that it contradicts.",
        examples=["{E: {value: 69.0(10) GPa, source: handbook}}"],
    )

    @property
    def properties(self) -> dict[str, Stated]:
        """Stated properties by name: the section's own, ``length`` and ``linear_density`` where given."""
        section = (
            {} if self.section is None else {key: getattr(self.section, key) for key in type(self.section).model_fields}
        )
        stated = section | {"length": self.length, "linear_density": self.linear_density}
        return {name: value for name, value in stated.items() if isinstance(value, Stated)}
