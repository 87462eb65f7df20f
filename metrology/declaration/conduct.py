"""What every test of a campaign file has, whatever its method: who, when, under which conditions, what was left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import Field, model_validator

from metrology.declaration.acceptance import Acceptance
from metrology.declaration.declared import Listed
from metrology.declaration.entry import Entry, Refusal, refuse
from metrology.declaration.quantity import Pressure, Ratio, Temperature
from metrology.declaration.scalars import Day, Filled, Id, Integer, Text


class Environment(Entry):
    """Conditions during a test."""

    temperature: Temperature | None = Field(
        None, description="Air temperature, from -90 degC to 100 degC.", examples=["21.3(5) degC"]
    )
    humidity: Ratio | None = Field(None, description="Relative humidity, from 0 % to 100 %.", examples=["45(5) %"])
    pressure: Pressure | None = Field(None, description="Air pressure.", examples=["1013(3) hPa"])

    @model_validator(mode="after")
    def _possible(self) -> Environment:
        found = [
            Refusal((key,), f"'{stated.value}'", expected)
            for key, low, high, expected in _POSSIBLE
            if (stated := getattr(self, key)) is not None and not low <= stated.si <= high
        ]
        if found:
            raise refuse(*found)
        return self


_POSSIBLE = (
    ("temperature", 183.15, 373.15, "a temperature of the air from -90 degC to 100 degC"),
    ("humidity", 0.0, 1.0, "a relative humidity from 0 % to 100 %"),
)


class Exclusion(Entry):
    """A reading that is shown but not used, or a whole release of a free decay, with the reason."""

    file: Filled | None = Field(
        None, description="Readings file, where the test has several.", examples=["decay-1.csv"]
    )
    line: Integer | None = Field(
        None,
        description="Line of the file; the heading is line 1. Only a release of a free decay, or a specimen of a "
        "testing machine, goes as a whole.",
        examples=["14"],
    )
    reason: Filled = Field(description="Why the reading is not used.", examples=["indicator knocked"])


class Accepted(Acceptance):
    """A failed check in spite of which results are judged: why, and who says so; printed with the verdict."""

    check: Filled = Field(
        description="Name of the check as the report prints it, `diagnosis` or `verification`.",
        examples=["loading against unloading"],
    )


class Test(Entry):
    """What every test has; each method adds `method`, its own word, `instruments`, and keys of its own."""

    __test__ = False

    @property
    def kind(self) -> str:
        """What the test is called beside its results, where the word of its method does not say it."""
        return ""

    if TYPE_CHECKING:

        @property
        def method(self) -> str:
            """Word of the method."""

        @property
        def instruments(self) -> Entry:
            """Names of the instruments used, by what they do."""

    sample: Id = Field(description="Name of the sample.", examples=["al-1100"])
    title: Text = Field(
        "",
        description="Title in the report; made from method and sample where nothing is said.",
        examples=["Elongation of the tape"],
    )
    date: Day | None = Field(None, description="Date of the test.", examples=["2026-10-05"])
    procedure: Text = Field(
        "", description="Procedure that was followed, with its edition.", examples=["SP-12, edition 3 (2026)"]
    )
    specification: Text = Field(
        "", description="Test specification, with its issue (ECSS).", examples=["TS-04, issue 2"]
    )
    as_run: Text = Field(
        "", description="Procedure as it was run, with every change made on the way (ECSS).", examples=["SP-12-AR-017"]
    )
    setup: Text = Field(
        "", description="Configuration of the set-up.", examples=["frame 2, upper clamp fixed, pan on lower clamp"]
    )
    operator: Text = Field("", description="Who carried it out.", examples=["A. Smith"])
    environment: Environment = Field(
        default_factory=lambda: Environment.model_validate({}),
        description="Conditions.",
        examples=["{temperature: 21.3(5) degC, humidity: 45(5) %}"],
    )
    exclusions: tuple[Exclusion, ...] = Field(
        (), description="Readings not used, each with a reason.", examples=["[{line: 14, reason: indicator knocked}]"]
    )
    accepted: tuple[Accepted, ...] = Field(
        (),
        description="Failed checks in spite of which results are judged, each with a reason and a person.",
        examples=["[{check: loading against unloading, reason: below 1 % of k, by: A. Smith}]"],
    )
    deviations: Listed[Filled] = Field(
        None,
        description="Additions to, deviations and exclusions from the method, in words; or `none`.",
        examples=["[Two repeats only at load A]"],
    )
