"""How a campaign file declares a test by method `elongation`."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field, model_validator

from metrology.declaration.conduct import Test
from metrology.declaration.entry import Entry, one_of
from metrology.declaration.quantity import Acceleration, Density, HangingForce, HangingMass
from metrology.declaration.readings import Readings
from metrology.declaration.scalars import Id
from metrology.declaration.scalars import Table as Named


class Load(Entry):
    """A dead load: a mass, or a force."""

    mass: HangingMass | None = Field(
        None, description="Mass that hangs, or a sum of `masses`.", examples=["2.0000(2) kg"]
    )
    force: HangingForce | None = Field(None, description="Force, where it is known directly.", examples=["19.60(1) N"])

    @model_validator(mode="after")
    def _one(self) -> Load:
        one_of(self, "mass", "force", "either a mass, '{mass: 2.000 kg}', or a force, '{force: 19.6 N}'")
        return self


class ElongationInstruments(Entry):
    """Instruments of an elongation test."""

    CORRECTED: ClassVar = ("extension",)
    """Those whose `correction` the method adds to their readings; other methods take none."""
    extension: Id = Field(
        description="The indicator that reads the extension; its resolution and certificate are used.",
        examples=["indicator"],
    )
    load: Id | None = Field(None, description="The weights.", examples=["weights"])


class ElongationTest(Test):
    """Extension under dead loads: k by the line through load and extension, E = k·L/A."""

    method: Literal["elongation"] = Field(description="Method.", examples=["elongation"])
    instruments: ElongationInstruments = Field(
        description="Names of the instruments used.", examples=["{extension: indicator, load: weights}"]
    )
    gravity: Acceleration | None = Field(
        None,
        description="Local acceleration of free fall; needed where loads are masses.",
        examples=["9.8060(5) m/s^2"],
    )
    air_density: Density | None = Field(
        None,
        description="Density of the air; 1.20 kg/m^3 ± 0.10 kg/m^3 (rectangular) where nothing is said.",
        examples=["1.20(5) kg/m^3"],
    )
    weight_density: Density | None = Field(
        None,
        description="Density of the weights, for buoyancy; 8000 kg/m^3 ± 170 kg/m^3 (rectangular) where nothing is "
        "said.",
        examples=["8000(100) kg/m^3"],
    )
    loads: Named[Load] = Field(
        description="The dead loads by name, at least three.",
        examples=["{A: {mass: 2.0000(2) kg}, B: {mass: 4.0000(4) kg}, C: {mass: 6.0000(6) kg}}"],
    )
    readings: Readings = Field(
        description="File, a name or a mapping (`Readings`), with the columns `load` and `reading / mm`; `repeat` "
        "where loads were read more than once, and `direction` (loading or unloading).",
        examples=["al-1100-elongation.csv"],
    )
