"""Fits of a campaign file, with the correlation of quantities: lines and curves through declared data."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, Literal

from pydantic import Field, GetJsonSchemaHandler, PlainValidator, TypeAdapter, WithJsonSchema, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology.declaration.acceptance import Acceptance
from metrology.declaration.entry import Entry, Refusal, refuse, show
from metrology.declaration.quantity import Stated, ValueOnly
from metrology.declaration.readings import Readings
from metrology.declaration.scalars import Coefficient, Filled, Number, Reference, Symbol, SymbolTable, Text, ranged


class Correlation(Entry):
    """Correlation between the estimates of two quantities."""

    between: tuple[Reference, Reference] = Field(description="Names of the two quantities.", examples=["[ls, d]"])
    coefficient: Coefficient = Field(description="Correlation coefficient r, -1 < r < 1.", examples=["0.9"])
    source: Text = Field("", description="Where the coefficient comes from.", examples=["same standard"])


class Axis(Entry):
    """One axis of a fit: a column of the readings file, or values written here."""

    column: Filled | None = Field(
        None, description="Heading of the column; a plain text means this too.", examples=["indication / mm"]
    )
    values: tuple[Number, ...] | None = Field(None, description="Values, in `unit`.", examples=["[1, 2, 3]"])
    unit: Text = Field("1", description="Unit of `values`.", examples=["mm"])

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        if isinstance(data, str):
            return {"column": data}
        return {"values": data} if isinstance(data, list) else data

    @model_validator(mode="after")
    def _one(self) -> Axis:
        if (self.column is None) == (self.values is None):
            raise refuse(
                Refusal((), "'column' and 'values' together" if self.column else "neither", "'column' or 'values'")
            )
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Allow a heading, and a list of values, beside the mapping."""
        values = {"type": "array", "items": {"type": "number"}}
        return {"anyOf": [{"type": "string"}, values, handler.resolve_ref_schema(handler(schema))]}


class Scatter(Axis):
    """Standard uncertainty of the points of an axis: one for all, a column, or values written here."""

    value: Annotated[Stated | None, ValueOnly()] = Field(
        None, description="Standard uncertainty of every point.", examples=["0.5 um"]
    )

    @model_validator(mode="after")
    def _one(self) -> Scatter:
        given = [key for key in ("column", "values", "value") if getattr(self, key) is not None]
        if len(given) != 1:
            raise refuse(Refusal((), " and ".join(given) or "no size", "one of 'value', 'column' or 'values'"))
        return self


@cache
def _coefficient() -> TypeAdapter[float]:
    """Of an entry of a matrix, which has ones in its diagonal."""
    return TypeAdapter(
        Annotated[Number, ranged(-1, 1, "a correlation coefficient from -1 to 1, such as '0.9'", closed=True)]
    )


def _coefficients(data: Any) -> Any:
    """One coefficient, a list of them, or a square matrix, as nested tuples."""
    if isinstance(data, list):
        return tuple(_coefficients(item) for item in data)
    if isinstance(data, str):
        return _coefficient().validate_python(data)
    raise refuse(Refusal((), show(data), "a correlation coefficient, such as '0.5', or a matrix of them"))


_NUMBERS = {"anyOf": [{"type": "number"}, {"type": "array"}]}
Vector = float | tuple[float, ...]
Matrix = float | tuple[tuple[float, ...], ...]


class PointCorrelation(Entry):
    """Correlation between the points of a fit."""

    x: Annotated[Matrix | None, PlainValidator(_coefficients), WithJsonSchema(_NUMBERS)] = Field(
        None, description="Between the x of any two points: one coefficient, or the matrix.", examples=["0.5"]
    )
    y: Annotated[Matrix | None, PlainValidator(_coefficients), WithJsonSchema(_NUMBERS)] = Field(
        None, description="Between the y of any two points: one coefficient, or the matrix.", examples=["0.5"]
    )
    xy: Annotated[Vector | None, PlainValidator(_coefficients), WithJsonSchema(_NUMBERS)] = Field(
        None, description="Between x and y of the same point: one coefficient, or one a point.", examples=["0.2"]
    )


class Model(Entry):
    """The function that is fitted: the word ``line``, or an expression in x and its parameters."""

    expression: Filled | None = Field(
        None, description="y as an expression in x and the parameters.", examples=["b1*(1 - exp(-b2*x))"]
    )
    start: Annotated[SymbolTable[Stated], ValueOnly()] = Field(
        {}, description="Start values of the parameters, with units.", examples=["{b1: 250, b2: 0.0005}"]
    )

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        if data == "line":
            return {}
        if isinstance(data, dict | Model):
            return data
        raise refuse(Refusal((), show(data), "'line', or '{expression: …, start: {…}}'"))

    @model_validator(mode="after")
    def _whole(self) -> Model:
        if (self.expression is None) != (not self.start):
            got = "'start' without 'expression'" if self.start else "'expression' without 'start'"
            raise refuse(Refusal((), got, "both: '{expression: 'b1*x', start: {b1: 2}}'"))
        return self

    @property
    def is_line(self) -> bool:
        """Whether it is y = intercept + slope·(x − origin)."""
        return self.expression is None

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Allow the word beside the mapping."""
        return {"anyOf": [{"const": "line"}, handler.resolve_ref_schema(handler(schema))]}


class Prediction(Entry):
    """A point at which the fit is used: y at a stated x, or x at a stated y."""

    name: Symbol = Field(description="Name of the result: `<fit>.<name>`.", examples=["b30"])
    x: Stated | None = Field(None, description="Where to predict y.", examples=["30 degC"])
    y: Stated | None = Field(
        None,
        description="Where to find x (inverse prediction): on a line, or on a curve within the range of its data.",
        examples=["10.5(5)"],
    )
    readings: tuple[Number, ...] | None = Field(
        None,
        description="New readings of y in place of `y`, two or more, in `unit`: their mean, with their scatter s/√m "
        "and m - 1 degrees of freedom.",
        examples=["[10.4, 10.6, 10.5]"],
    )
    unit: Text = Field("1", description="Unit of `readings`.", examples=["um"])

    @model_validator(mode="after")
    def _one(self) -> Prediction:
        given = [key for key in ("x", "y", "readings") if getattr(self, key) is not None]
        if len(given) != 1:
            raise refuse(Refusal((), " and ".join(given) or "no place", "one of 'x', 'y' or 'readings'"))
        if self.readings is None and self.unit != "1":
            fix = "write the unit with the quantity, or state 'readings'"
            raise refuse(Refusal(("unit",), f"{self.unit!r} without 'readings'", "'readings' in that unit", fix))
        if self.readings is not None and len(self.readings) < 2:
            fix = "state a single one as 'y', with its uncertainty"
            raise refuse(Refusal(("readings",), f"{len(self.readings)} reading", "two or more", fix))
        return self


class Fit(Entry):
    """A line or a curve fitted to declared data: ordinary, weighted, or with errors in both axes."""

    readings: Readings | None = Field(
        None,
        description="File of the data, a name or a mapping (`Readings`); not needed where the axes hold `values`.",
        examples=["cal.csv"],
    )
    x: Axis = Field(
        description="Abscissa: heading of a column, or `{values: […], unit: …}`.", examples=["indication / mm"]
    )
    y: Axis = Field(description="Ordinate: heading of a column, or `{values: […], unit: …}`.", examples=["error / um"])
    u_x: Scatter | None = Field(
        None, description="Standard uncertainty of x; none where nothing is said.", examples=["{value: 0.5 um}"]
    )
    u_y: Scatter | None = Field(
        None,
        description="Standard uncertainty of y; from the residuals where nothing is said (ordinary least squares).",
        examples=["{value: 0.5 um}"],
    )
    correlation: PointCorrelation | None = Field(
        None, description="Correlation between the points.", examples=["{y: 0.5}"]
    )
    scatter: Literal["scaled", "stated"] = Field(
        "scaled",
        description="Where χ² refutes the stated uncertainties: `scaled`, the uncertainties of the parameters grow by "
        "√(χ²/ν), or `stated`, they stay.",
        examples=["stated"],
    )
    covariance: Literal["propagated", "iso28037"] = Field(
        "propagated",
        description="Errors in x and y: covariance of the parameters by propagation through the estimator (JCGM 100, "
        "5.2), or by the information matrix of ISO/TS 28037, which neglects the residuals; of a line or a curve.",
        examples=["iso28037"],
    )
    model: Model = Field(
        default_factory=lambda: Model.model_validate({}),
        description="`line`, y = intercept + slope·(x − origin), or `{expression, start}`.",
        examples=["{expression: 'b1*(1 - exp(-b2*x))', start: {b1: 250, b2: 0.0005}}"],
    )
    origin: Annotated[Stated | None, ValueOnly()] = Field(
        None,
        description="`line`: the x at which the intercept is taken; zero where nothing is said.",
        examples=["20 degC"],
    )
    predict: tuple[Prediction, ...] = Field(
        (), description="Points at which the fit gives results.", examples=["[{name: b30, x: 30 degC}]"]
    )
    source: Text = Field("", description="Where the data come from.", examples=["certificate C-123"])
    accepted: Acceptance | None = Field(
        None,
        description="Why what follows from the fit is judged although χ² refutes it with `scatter: stated`, its "
        "points are copies or do not follow the model, it is used beyond them, or its slope is not significant where "
        "an x is found from it, and who says so; without it there is no verdict.",
        examples=["{reason: one point of a worn gauge, by: A. Smith}"],
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the result."""
        return ("intercept", "slope") if self.model.is_line else tuple(self.model.start)
