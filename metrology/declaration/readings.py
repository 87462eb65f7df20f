"""Where readings are: a file by its name alone, or a mapping that says how it is to be read."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology.declaration.entry import Entry, Refusal, refuse, show
from metrology.declaration.quantity import Frequency, Stated, ValueOnly, of
from metrology.declaration.scalars import Filled, Integer, Text

FORMATS = ("text", "xlsx", "ods", "tdms", "uff58", "mat", "hdf5", "parquet", "mdf4", "lvm", "numpy")
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": " "}
Instant = Annotated[Stated, *of("s", positive=False)]
Step = Annotated[Stated, *of("s")]


class ColumnOf(Entry):
    """Where a column stands in the file, and what the file does not say of it."""

    column: Filled = Field(
        description="Heading in the file, with or without its unit; or the number of the column, from 1.",
        examples=["Kraft", "2"],
    )
    unit: Filled | None = Field(
        None, description="Unit, where neither the heading nor the file has it.", examples=["mm"]
    )
    words: Mapping[str, Filled] | None = Field(
        None,
        description="What the words of a column of texts stand for.",
        examples=["{Belastung: loading, Entlastung: unloading}"],
    )

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        return {"column": data} if isinstance(data, str) else data

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Allow a heading beside the mapping."""
        return {"anyOf": [{"type": ["string", "integer"]}, handler.resolve_ref_schema(handler(schema))]}


class Sampling(Entry):
    """Time stamps of a file that has none: one of `rate` and `step`."""

    rate: Annotated[Frequency | None, ValueOnly()] = Field(
        None, description="Samples in a second.", examples=["200 Hz"]
    )
    step: Annotated[Step | None, ValueOnly()] = Field(None, description="Time between two samples.", examples=["5 ms"])
    start: Annotated[Instant, ValueOnly()] = Field(
        default_factory=lambda: Stated.model_validate("0 s"), description="Time of the first sample.", examples=["0 s"]
    )

    @model_validator(mode="after")
    def _one(self) -> Sampling:
        if (self.rate is None) == (self.step is None):
            got = "'rate' and 'step' together" if self.rate else "neither 'rate' nor 'step'"
            raise refuse(Refusal((), got, "one of the two, such as 'rate: 200 Hz'"))
        return self


class Readings(Entry):
    """A file of readings: what it is, and how it is read; what is not stated is found in the file itself."""

    file: Filled = Field(description="Path from the campaign's folder.", examples=["messung.xlsx"])
    format: Literal[FORMATS] | None = Field(  # type: ignore[valid-type]
        None, description="Format of the file; by its content where nothing is said.", examples=["tdms"]
    )
    member: Filled | None = Field(
        None, description="File within a .zip that holds several.", examples=["export/run-1.csv"]
    )
    sheet: Filled | None = Field(
        None, description="Sheet of a workbook; the only one, or the one with the columns, else.", examples=["Messung"]
    )
    group: Filled | None = Field(None, description="Group of a TDMS, HDF5 or MDF4 file.", examples=["Run 1"])
    dataset: Filled | None = Field(
        None,
        description="Dataset of an HDF5 file, variable of a MAT file, array of an .npz file.",
        examples=["/data/x"],
    )
    channel: Filled | None = Field(
        None, description="Record of a UFF file, by its number from 1 or its name.", examples=["1"]
    )
    columns: Mapping[str, ColumnOf] | None = Field(
        None,
        description="Column of the file for each column that is due; others are then passed over.",
        examples=['{load: Last, reading: "Ablesung [mm]"}'],
    )
    decimal: Literal["point", "comma"] | None = Field(None, description="Decimal mark of a text.", examples=["comma"])
    separator: Literal["comma", "semicolon", "tab", "bar", "space"] | None = Field(
        None, description="What stands between the cells of a text.", examples=["semicolon"]
    )
    header: Integer | None = Field(
        None, description="Lines above the line with the headings; found where nothing is said.", examples=["12"]
    )
    encoding: Text | None = Field(
        None, description="Encoding of a text; UTF-8 where nothing is said.", examples=["cp1252"]
    )
    time: Sampling | None = Field(
        None, description="Time stamps, where the file has none.", examples=["{rate: 200 Hz}"]
    )
    rows: tuple[Integer, Integer] | None = Field(
        None, description="First and last line that is used, both included.", examples=["[14, 512]"]
    )

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        if isinstance(data, str):
            return {"file": data}
        if not isinstance(data, dict | Readings):
            raise refuse(Refusal((), show(data), "a file, such as 'run-1.csv', or a mapping, '{file: run-1.csv, …}'"))
        return data

    @model_validator(mode="after")
    def _ordered(self) -> Readings:
        if self.rows is not None and self.rows[0] > self.rows[1]:
            raise refuse(Refusal(("rows",), f"{self.rows[0]} after {self.rows[1]}", "the first line, then the last"))
        return self

    @property
    def part(self) -> str:
        """What of the file is read, where it is not the whole of it."""
        named = [one for one in (self.member, self.sheet, self.group, self.dataset, self.channel) if one]
        named += [f"rows {self.rows[0]} to {self.rows[1]}"] if self.rows else []
        return ", ".join(named)

    @property
    def name(self) -> str:
        """What campaign files and reports call these readings: the file, and the part of it that is read."""
        return f"{self.file} [{self.part}]" if self.part else self.file

    @property
    def stated(self) -> Mapping[str, ColumnOf]:
        """The columns that are stated, by the names that are due."""
        return self.columns or MappingProxyType({})

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Allow the name of a file beside the mapping."""
        return {"anyOf": [{"type": "string"}, handler.resolve_ref_schema(handler(schema))]}
