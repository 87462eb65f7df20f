"""Tests of a campaign file, one class a method; `METHODS` lists them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from metrology.campaign.conduct import Environment, Exclusion, Test
from metrology.campaign.entry import Entry, one_of
from metrology.campaign.quantity import Acceleration, Density, Force, Frequency, Mass, Stated
from metrology.campaign.response import Inertia, ResponseTest
from metrology.campaign.scalars import Filled, Id, Table

__all__ = [
    "METHODS",
    "AnyTest",
    "DecayTest",
    "ElongationTest",
    "Environment",
    "Exclusion",
    "Load",
    "ResponseTest",
    "Test",
]


class Load(Entry):
    """A dead load: a mass, or a force."""

    mass: Mass | None = Field(None, description="Mass that hangs.", examples=["2.0000(2) kg"])
    force: Force | None = Field(None, description="Force, where it is known directly.", examples=["19.60(1) N"])

    @model_validator(mode="after")
    def _one(self) -> Load:
        one_of(self, "mass", "force", "either a mass, '{mass: 2.000 kg}', or a force, '{force: 19.6 N}'")
        return self


class ElongationInstruments(Entry):
    """Instruments of an elongation test."""

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
    loads: Table[Load] = Field(
        description="The dead loads by name, at least three.",
        examples=["{A: {mass: 2.0000(2) kg}, B: {mass: 4.0000(4) kg}, C: {mass: 6.0000(6) kg}}"],
    )
    readings: Filled = Field(
        description="CSV file with the columns `load`, `repeat`, `direction` (loading or unloading) and "
        "`reading / mm`.",
        examples=["al-1100-elongation.csv"],
    )


class DecayInstruments(Entry):
    """Instruments of a free-decay test."""

    displacement: Id = Field(description="The instrument that reads the displacement.", examples=["vibrometer"])


class DecayTest(Test):
    """Free decay of a mass on the sample: ω_n, ζ, and c = 2·ζ·√(k·m)."""

    method: Literal["decay"] = Field(description="Method.", examples=["decay"])
    instruments: DecayInstruments = Field(
        description="Names of the instruments used.", examples=["{displacement: vibrometer}"]
    )
    mass: Mass | None = Field(None, description="Mass that swings.", examples=["1.196(1) kg"])
    inertia: Inertia | None = Field(
        None,
        description="Moment of inertia, in place of a mass: a body that turns, whose readings are angles; k is then in "
        "N·m/rad and c in N·m·s/rad.",
        examples=["0.0200(1) kg*m^2"],
    )
    stiffness: Id | None = Field(
        None,
        description="Elongation test whose k goes into c = 2·ζ·√(k·m); the oscillation's own k where nothing is said.",
        examples=["al-1100-elongation"],
    )
    mains: Frequency = Field(
        Stated.model_validate({"value": "50 Hz"}),
        description="Frequency of the mains, which is taken out of the records.",
        examples=["60 Hz"],
    )
    expected: Frequency | None = Field(
        None,
        description="About where the longitudinal mode lies, where it is not the strongest that decays.",
        examples=["23 Hz"],
    )
    readings: tuple[Filled, ...] = Field(
        description="CSV files, one a release, with the columns `time / s` and `displacement / um`, or `angle / deg` "
        "where an inertia is stated; stamps need not be even, cells may be empty. `.csv.gz` is read too.",
        examples=["[decay-1.csv, decay-2.csv]"],
    )

    @model_validator(mode="after")
    def _one(self) -> DecayTest:
        one_of(self, "mass", "inertia", "a mass, 'mass: 1.196(1) kg', or a moment of inertia, 'inertia: 0.02 kg*m^2'")
        return self

    @property
    def inert(self) -> Stated:
        """Mass, or moment of inertia."""
        stated = self.mass or self.inertia
        assert stated is not None
        return stated

    @property
    def column(self) -> tuple[str, str]:
        """Heading of the readings without its unit, and their SI unit."""
        return ("displacement", "m") if self.inertia is None else ("angle", "rad")


#: Methods by the word in the file. Another one is an entry here, in `AnyTest`, and in `names.RESULTS`.
METHODS: dict[str, type[Test]] = {"elongation": ElongationTest, "decay": DecayTest, "response": ResponseTest}
AnyTest = Annotated[ElongationTest | DecayTest | ResponseTest, Field(discriminator="method")]
