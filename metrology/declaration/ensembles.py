"""Ensembles of a campaign file: quantities read simultaneously, in the columns of one file."""

from __future__ import annotations

from pydantic import Field, model_validator

from metrology.declaration.acceptance import Acceptance
from metrology.declaration.component import StatedComponent
from metrology.declaration.entry import Entry, Refusal, refuse
from metrology.declaration.readings import Readings
from metrology.declaration.scalars import Filled, Symbol, SymbolTable, Text


class Ensemble(Entry):
    """Quantities read simultaneously: means, covariance S/n and ν = n − 1 come from the columns of one file."""

    readings: Readings = Field(
        description="File, one row a simultaneous reading; a name, or a mapping (`Readings`).", examples=["bridge.csv"]
    )
    columns: SymbolTable[Filled] = Field(
        description="Heading of each quantity's column by the name of the quantity; a single column is a plain "
        "Type A evaluation.",
        examples=['{V: "V / V", I: "I / mA", phi: "phi / rad"}'],
    )
    uncertainty: SymbolTable[tuple[StatedComponent, ...]] = Field(
        {},
        description="Further components by the name of the quantity, in addition to the readings.",
        examples=["{V: [{half_width: 1 mV, distribution: rectangular, source: voltmeter}]}"],
    )
    descriptions: SymbolTable[Text] = Field({}, description="What each quantity is.", examples=["{V: voltage}"])
    nested: tuple[Symbol, ...] = Field(
        (),
        description="Of a single column: headings of the columns with the groups of each reading, the outermost first; "
        "u is that between the outermost groups (JCGM 100, H.5). Groups may differ in size.",
        examples=["[day]", "[day, mounting]"],
    )
    crossed: tuple[Symbol, ...] = Field(
        (),
        description="Of a single column: headings of two columns with groups, each of the one met by each of the "
        "other, as in a study of a gauge by parts and operators.",
        examples=["[operator, part]"],
    )
    source: Text = Field("", description="Where the readings come from.", examples=["laboratory book 7, page 12"])
    accepted: Acceptance | None = Field(
        None,
        description="Why what follows from readings that are copies, alike or not independent is judged all the same, "
        "and who says so; without it there is no verdict.",
        examples=["{reason: a counter without noise, by: A. Smith}"],
    )

    @model_validator(mode="after")
    def _one_layout(self) -> Ensemble:
        if self.nested and self.crossed:
            raise refuse(Refusal(("crossed",), "'nested' and 'crossed' together", "one of the two"))
        if self.factors and len(self.columns) > 1:
            raise refuse(
                Refusal((), f"groups with {len(self.columns)} columns", "a single column", "one entry for each")
            )
        if self.crossed and len(self.crossed) != 2:
            raise refuse(Refusal(("crossed",), f"{len(self.crossed)} factors", "two factors"))
        if len({*self.factors}) < len(self.factors) or "within" in self.factors:
            raise refuse(Refusal((), f"{', '.join(self.factors)}", "every factor once, and none of the name 'within'"))
        return self

    @property
    def factors(self) -> tuple[str, ...]:
        """Headings of the columns with groups."""
        return self.nested or self.crossed

    @property
    def strata(self) -> tuple[str, ...]:
        """Sources of scatter that an analysis of variance tells, all but that within the groups."""
        return (*self.crossed, "_".join(self.crossed)) if self.crossed else self.nested
