"""What a report by ISO/IEC 17025 or ECSS-E-ST-10-02 says beside the results: opinions, anomalies, data from others."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from metrology.declaration.entry import Entry, refuse, unknown
from metrology.declaration.scalars import Day, Filled, Id, Text
from metrology.effects import EFFECTS

T = TypeVar("T")
NONE = "none"


class _OrNone:
    """Reads the word ``none`` as an empty list: that there is nothing is a statement, an absent key is none."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"anyOf": [handler(schema), {"const": NONE}]}

    @staticmethod
    def _read(value: Any) -> Any:
        return [] if isinstance(value, str) and value.strip() == NONE else value


Listed = Annotated[tuple[T, ...] | None, _OrNone()]
"""A list, the word ``none``, or not stated."""


class Replaces(Entry):
    """The report that this one amends (ISO/IEC 17025:2017, 7.8.8)."""

    number: Filled = Field(description="Number of the replaced report.", examples=["TR-2026-001"])
    date: Day = Field(description="Its date of issue.", examples=["2026-11-20"])
    reason: Filled = Field(
        description="What was changed, and why.", examples=["mass of the plate corrected in section 3"]
    )


class Provided(Entry):
    """Data or work of others that a result rests on."""

    what: Filled = Field(description="What was provided.", examples=["length of the tape"])
    by: Filled = Field(description="Who provided it.", examples=["Space Systems"])
    role: Literal["customer", "external provider"] = Field(
        description="As what: data of the `customer` carry a disclaimer, results of an `external provider` a mark.",
        examples=["customer"],
    )


class Assumption(Entry):
    """An assumption or a constraint, and the effects that would refute it."""

    text: Filled = Field(description="The assumption.", examples=["Clamps and frame are stiff against the line"])
    excludes: tuple[Filled, ...] = Field(
        (),
        description="Effects that it excludes, by their names in a diagnosis; the report strikes it where a diagnosis "
        "finds one of them.",
        examples=["[setup, frame]"],
    )

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        return {"text": data} if isinstance(data, str) else data

    @model_validator(mode="after")
    def _known(self) -> Assumption:
        names = sorted({cause.name for effect in EFFECTS for cause in effect.causes})
        found = [one for at, name in enumerate(self.excludes) for one in unknown(name, names, "effect", "excludes", at)]
        if found:
            raise refuse(*found)
        return self


class Opinion(Entry):
    """An opinion or an interpretation, distinguished from the results (ISO/IEC 17025:2017, 7.8.7)."""

    text: Filled = Field(description="The opinion.", examples=["The tape is fit for a second deployment."])
    by: Filled = Field(description="Who holds it, with function.", examples=["J. Doe, head of laboratory"])
    basis: Filled = Field(description="What it rests on.", examples=["modulus and creep of tests 1 to 3"])


class Anomaly(Entry):
    """A nonconformance, failure or problem that was met (ECSS-E-ST-10-02, Annex C)."""

    id: Id = Field(description="Number of the nonconformance report.", examples=["NCR-17"])
    text: Filled = Field(description="What happened.", examples=["clamp slipped at load C, repeat 2"])
    state: Literal["open", "closed"] = Field(description="Whether it is closed.", examples=["open"])
    disposition: Text = Field("", description="What was decided.", examples=["repeat used after re-clamping"])


class StatedDocument(Entry):
    """A document that the tests follow or that the report refers to."""

    number: Filled = Field(description="Number of the document.", examples=["SP-12"])
    title: Filled = Field(description="Title.", examples=["Elongation of tapes under dead loads"])
    edition: Text = Field("", description="Edition or issue.", examples=["3"])
    role: Literal["applicable", "reference"] = Field(
        description="`applicable` documents are binding, `reference` ones support.", examples=["applicable"]
    )
