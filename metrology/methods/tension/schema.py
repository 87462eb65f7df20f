"""How a campaign file declares a test by method `tension`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, TypeVar

from pydantic import Field, model_validator

from metrology.declaration.conduct import Test
from metrology.declaration.entry import Entry, Refusal, refuse
from metrology.declaration.quantity import Compliance, Density, Force, Length, Ratio, ValueOnly
from metrology.declaration.readings import Readings
from metrology.declaration.samples import Section
from metrology.declaration.scalars import Flag, Id, Integer, Text
from metrology.declaration.scalars import Table as Named

Point = TypeVar("Point")


class TensionInstruments(Entry):
    """Instruments of a tension test."""

    force: Id = Field(
        description="The load cell; its `class` to ISO 7500-1 (0.5, 1, 2, 3) or its certificate is used.",
        examples=["cell"],
    )
    crosshead: Id | None = Field(None, description="What reads the crosshead.", examples=["encoder"])
    extension: Id | None = Field(
        None,
        description="Extensometer that reads a displacement over `gauge_length`; its `class` to ISO 9513 (0.2, 0.5, 1, "
        "2) or its certificate is used.",
        examples=["extensometer"],
    )
    strain: Id | None = Field(
        None,
        description="Instrument that reads a strain: extensometer, strain gauge, image correlation; its `class` to ISO "
        "9513 or its certificate is used.",
        examples=["video"],
    )

    @model_validator(mode="after")
    def _one(self) -> TensionInstruments:
        if self.crosshead is None and self.extension is None and self.strain is None:
            raise refuse(Refusal((), "a force alone", "'crosshead', 'extension' or 'strain', which reads the stretch"))
        if self.extension is not None and self.strain is not None:
            raise refuse(Refusal((), "'extension' and 'strain' together", "one of the two"))
        return self


class TensionRange(Entry):
    """Over which part of the loading the line is drawn: one of `strain`, `force` and `share`."""

    strain: Annotated[tuple[Ratio, Ratio] | None, ValueOnly()] = Field(
        None, description="From one strain to another.", examples=["[0.05 %, 0.25 %]"]
    )
    force: Annotated[tuple[Force, Force] | None, ValueOnly()] = Field(
        None, description="From one force to another.", examples=["[1 kN, 5 kN]"]
    )
    share: Annotated[tuple[Ratio, Ratio] | None, ValueOnly()] = Field(
        None, description="Parts of the largest force of each record.", examples=["[10 %, 40 %]"]
    )
    loading: Integer = Field(
        1, description="Which loading through the range, where a record has cycles; the first is 1.", examples=["3"]
    )

    @model_validator(mode="after")
    def _one(self) -> TensionRange:
        stated = {key: ends for key in ("strain", "force", "share") if (ends := getattr(self, key)) is not None}
        if len(stated) != 1:
            got = " and ".join(f"'{key}'" for key in stated) or "no range"
            raise refuse(Refusal((), got, "one of 'strain', 'force' and 'share', such as 'strain: [0.05 %, 0.25 %]'"))
        ((key, (low, high)),) = stated.items()
        if not 0 <= low.si < high.si:
            raise refuse(
                Refusal((key,), f"'{low.value}' to '{high.value}'", "the lower end, 0 or more, then the upper")
            )
        if key == "share" and high.si > 1:
            raise refuse(Refusal((key, 1), f"'{high.value}'", "at most 100 % of the largest force"))
        if self.loading < 1:
            raise refuse(Refusal(("loading",), f"'{self.loading}'", "1 for the first loading, or more"))
        return self

    @property
    def ends(self) -> tuple[Literal["strain", "force", "share"], float, float]:
        """What it is stated in, and its ends in SI."""
        if self.strain is not None:
            return "strain", self.strain[0].si, self.strain[1].si
        if self.force is not None:
            return "force", self.force[0].si, self.force[1].si
        assert self.share is not None
        return "share", self.share[0].si, self.share[1].si


class TensionSecant(Entry):
    """Two points of a record between which a secant is drawn: in `strain` or in `force`."""

    strain: Annotated[tuple[Ratio, Ratio] | None, ValueOnly()] = Field(
        None, description="From one strain to another.", examples=["[0.05 %, 0.25 %]"]
    )
    force: Annotated[tuple[Force, Force] | None, ValueOnly()] = Field(
        None, description="From one force to another.", examples=["[1 kN, 5 kN]"]
    )

    @model_validator(mode="after")
    def _one(self) -> TensionSecant:
        key, (low, high) = _chosen({"strain": self.strain, "force": self.force}, "strain: [0.05 %, 0.25 %]")
        if not 0 <= low.si < high.si:
            got = f"'{low.value}' to '{high.value}'"
            raise refuse(Refusal((key,), got, "the lower point, 0 or more, then the upper"))
        return self

    @property
    def ends(self) -> tuple[Literal["strain", "force"], float, float]:
        """What the points are stated in, and both in SI."""
        if self.strain is not None:
            return "strain", self.strain[0].si, self.strain[1].si
        assert self.force is not None
        return "force", self.force[0].si, self.force[1].si


class TensionTangent(Entry):
    """A point of a record at which a tangent is drawn: in `strain` or in `force`."""

    strain: Annotated[Ratio | None, ValueOnly()] = Field(None, description="At a strain.", examples=["0.1 %"])
    force: Annotated[Force | None, ValueOnly()] = Field(None, description="At a force.", examples=["2 kN"])

    @model_validator(mode="after")
    def _one(self) -> TensionTangent:
        _chosen({"strain": self.strain, "force": self.force}, "strain: 0.1 %")
        return self

    @property
    def ends(self) -> tuple[Literal["strain", "force"], float, float]:
        """What the point is stated in, and twice the point in SI."""
        if self.strain is not None:
            return "strain", self.strain.si, self.strain.si
        assert self.force is not None
        return "force", self.force.si, self.force.si


def _chosen(stated: Mapping[str, Point | None], example: str) -> tuple[str, Point]:
    """Key and value of the one that is stated."""
    found = {key: point for key, point in stated.items() if point is not None}
    if len(found) != 1:
        got = " and ".join(f"'{key}'" for key in found) or "no point"
        names = " and ".join(f"'{key}'" for key in stated)
        raise refuse(Refusal((), got, f"one of {names}, such as '{example}'"))
    return next(iter(found.items()))


class TensionSpecimen(Entry):
    """A specimen in the grips, with its record."""

    readings: Readings = Field(
        description="File, a name or a mapping (`Readings`), with the columns `force / N`, `time / s` (optional), and "
        "those of the instruments that are stated: `crosshead / mm`, `extension / um`, `strain / %`; a second "
        "extensometer has `extension 2 / um` or `strain 2 / %`.",
        examples=["specimen-1.csv"],
    )
    section: Section | None = Field(
        None,
        description="Its section, where it differs from that of the sample.",
        examples=["{shape: round, diameter: 7.13(1) mm}"],
    )
    length: Length | None = Field(
        None, description="Its free length, where it differs from that of the sample.", examples=["60.0(2) mm"]
    )
    remark: Text = Field("", description="What is particular of it.", examples=["chamber at 50 °C"])


class TensionTest(Test):
    """Pull in a testing machine: EA, k and E by the line through strain and force, set-up compliance, strength."""

    method: Literal["tension"] = Field(description="Method.", examples=["tension"])
    instruments: TensionInstruments = Field(
        description="Names of the instruments used.",
        examples=["{force: cell, crosshead: encoder, extension: extensometer}"],
    )
    specimens: Named[TensionSpecimen] = Field(
        description="The specimens by name, one for each mounting.",
        examples=["{s1: {readings: s1.csv}, s2: {readings: s2.csv}, s3: {readings: s3.csv}}"],
    )
    range: TensionRange | None = Field(
        None,
        description="Over which part of the loading the line is drawn; the longest straight part where nothing is "
        "said.",
        examples=["{strain: [0.05 %, 0.25 %]}"],
    )
    secant: TensionSecant | None = Field(
        None,
        description="Two points between which the secant `EA_sec`, `k_sec` and `E_sec` is drawn.",
        examples=["{strain: [0.05 %, 0.25 %]}"],
    )
    tangent: TensionTangent | None = Field(
        None,
        description="At which point of the range the tangent `EA_tan`, `k_tan` and `E_tan` is drawn.",
        examples=["{strain: 0.1 %}", "{force: 2 kN}"],
    )
    gauge_length: Length | None = Field(
        None, description="Gauge length of the extensometer that reads `extension`.", examples=["25.4(1) mm"]
    )
    setup_compliance: Compliance | None = Field(
        None,
        description="Compliance of grips, cell and frame by a calibration, where the crosshead alone was read.",
        examples=["0.12(2) um/N"],
    )
    density: Density | None = Field(
        None,
        description="Density of the material: with the sample's `linear_density` it gives the section of a fibre.",
        examples=["1.44(1) g/cm^3"],
    )
    to_break: Flag = Field(
        False, description="Whether the specimens were pulled until they broke: strength and strain at break follow.",
        examples=["true"],
    )  # fmt: skip
