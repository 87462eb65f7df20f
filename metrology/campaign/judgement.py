"""Derived quantities, comparisons, requirements and audit of a campaign file: what is made of the results."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology.declaration.acceptance import Acceptance
from metrology.declaration.entry import Entry, Refusal, one_of, refuse
from metrology.declaration.quantity import Stated, ValueOnly
from metrology.declaration.scalars import (
    Day,
    Filled,
    Flag,
    Id,
    Number,
    Positive,
    Reference,
    Symbol,
    SymbolTable,
    Text,
    ranged,
)


class Derived(Entry):
    """A measurement model of the laboratory's own: a quantity by an expression over inputs and results."""

    quantity: Symbol = Field(description="Name of the quantity.", examples=["E"])
    sample: Id | None = Field(
        None,
        description="Sample it belongs to; its properties and the results of its tests are then plain names.",
        examples=["al-1100"],
    )
    expression: Filled = Field(
        description="Arithmetic with + - * / **, parentheses, functions (sqrt, exp, log, sin, …) and the "
        "constants pi and e.",
        examples=["k * L / (w * t)"],
    )
    where: SymbolTable[Reference] = Field(
        {},
        description="Full name of the quantity behind each name of the expression, where it is not the name itself.",
        examples=["{k: al-1100-elongation.k, L: al-1100.length}"],
    )
    unit: Filled = Field("1", description="Unit of display; its dimension is checked.", examples=["GPa"])
    description: Text = Field(
        "", description="What it is, in the words of the report.", examples=["modulus of elasticity"]
    )

    @property
    def name(self) -> str:
        """Full name: ``<sample>.<quantity>``, or the quantity alone."""
        return f"{self.sample}.{self.quantity}" if self.sample else self.quantity


class Side(Entry):
    """One side of a comparison: the name of a quantity, or a value known from elsewhere."""

    quantity: Reference | None = Field(
        None, description="Full name of a quantity; a plain text means this too.", examples=["al-1100.E"]
    )
    value: Stated | None = Field(
        None, description="A value known from elsewhere.", examples=["{value: 69.0(10) GPa, source: handbook}"]
    )

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        if isinstance(data, str):
            return {"quantity": data}
        if isinstance(data, dict) and "quantity" not in data and not isinstance(data.get("value"), dict):
            return {"value": data}
        return data

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Show the two forms in which a side is written."""
        properties = handler.resolve_ref_schema(handler(schema))["properties"]
        return {"anyOf": [properties["quantity"]["anyOf"][0], properties["value"]["anyOf"][0]]}


class Comparison(Entry):
    """Two results, or a result and a value from elsewhere, compared by E_n (ISO 13528 9.7)."""

    title: Text = Field("", description="Title in the report.", examples=["static against dynamic stiffness"])
    between: tuple[Side, Side] = Field(
        description="The two sides: names of quantities, or quantities with a source.",
        examples=["[al-1100-elongation.k, al-1100-decay.k]"],
    )
    accepted: Acceptance | None = Field(
        None,
        description="Why a result is judged although it contradicts the value known from elsewhere, and who says so; "
        "without it there is no verdict.",
        examples=["{reason: the handbook is of another temper, by: A. Smith}"],
    )


class Limits(Entry):
    """Tolerance limits: one or both."""

    lower: Stated | None = Field(None, description="Lower tolerance limit.", examples=["20 kN/m"])
    upper: Stated | None = Field(None, description="Upper tolerance limit.", examples=["30 kN/m"])

    @model_validator(mode="after")
    def _plausible(self) -> Limits:
        given = [(key, limit) for key, limit in (("lower", self.lower), ("upper", self.upper)) if limit is not None]
        if not given:
            raise refuse(Refusal((), "no limit", "'lower', 'upper' or both"))
        for key, limit in given:
            if limit.quantity.u is not None or limit.uncertainty:
                raise refuse(Refusal((key,), f"'{limit.value}', a limit with an uncertainty", "an exact limit"))
        if (
            self.lower
            and self.upper
            and self.lower.dimension == self.upper.dimension
            and self.lower.si >= self.upper.si
        ):
            raise refuse(Refusal(("upper",), f"'{self.upper.value}', not above the lower limit", "lower < upper"))
        return self


class Decision(Entry):
    """The decision rule (JCGM 106; ILAC-G8)."""

    rule: Literal["simple acceptance", "guard band", "specific risk", "global risk"] = Field(
        description="How the uncertainty enters: `simple acceptance`, the value against the limits; `guard band`, "
        "limits moved inwards by w = factor·U; `specific risk`, w such that a result on the acceptance limit is "
        "wrongly accepted with probability `risk`; `global risk`, the same over the items that `prior` describes.",
        examples=["guard band"],
    )
    factor: Positive = Field(
        1.0, description="`guard band`: w in multiples of the expanded uncertainty U.", examples=["1.0"]
    )
    risk: Annotated[Number, ranged(0, 0.5, "a risk above 0 and below 0.5, such as '0.025'")] = Field(
        0.025,
        description="`specific risk`, `global risk`: probability of wrong acceptance. Where draws decide, 100/risk "
        "trials are made, up to `max_trials`; by a risk below 3/trials nothing passes.",
        examples=["0.001"],
    )
    agreed: Day | None = Field(
        None,
        description="Day on which the rule and its risk were agreed with the customer; not after the test.",
        examples=["2026-09-15"],
    )
    k: Positive | None = Field(
        None,
        description="`guard band`: coverage factor of U; by Student's t for the campaign's probability where nothing "
        "is said.",
        examples=["2"],
    )
    binary: Flag = Field(
        False,
        description="All but `simple acceptance`: whether the verdict is pass or fail only, without the conditional "
        "ones inside the guard band.",
        examples=["true"],
    )

    @model_validator(mode="after")
    def _nothing_idle(self) -> Decision:
        idle = [key for key, rules in _RULES_WITH.items() if key in self.model_fields_set and self.rule not in rules]
        if idle:
            expected = {key: f"'{key}' with {' or '.join(_RULES_WITH[key])} only" for key in idle}
            raise refuse(*(Refusal((key,), f"'{key}' under '{self.rule}'", expected[key], of_key=True) for key in idle))
        return self


#: Rules under which a key does something.
_RULES_WITH = {
    "factor": ("guard band",),
    "k": ("guard band",),
    "risk": ("specific risk", "global risk"),
    "binary": ("guard band", "specific risk", "global risk"),
}


class NormalPrior(Entry):
    """What is known about the items before the measurement: a normal distribution."""

    distribution: Literal["normal"] = Field(description="Distribution of the items.", examples=["normal"])
    mean: Annotated[Stated, ValueOnly()] = Field(description="Mean.", examples=["25 kN/m"])
    standard: Annotated[Stated, ValueOnly()] = Field(description="Standard deviation.", examples=["1 kN/m"])


class GammaPrior(Entry):
    """What is known about the items before the measurement: a gamma distribution."""

    distribution: Literal["gamma"] = Field(description="Distribution of the items.", examples=["gamma"])
    shape: Positive = Field(description="Shape parameter.", examples=["4"])
    scale: Annotated[Stated, ValueOnly()] = Field(description="Scale parameter, with unit.", examples=["0.25 um"])


class LognormalPrior(Entry):
    """What is known about the items before the measurement: a lognormal distribution."""

    distribution: Literal["lognormal"] = Field(description="Distribution of the items.", examples=["lognormal"])
    median: Annotated[Stated, ValueOnly()] = Field(description="Median, with unit.", examples=["25 kN/m"])
    sigma: Positive = Field(description="Standard deviation of the natural logarithm.", examples=["0.1"])


class RectangularPrior(Entry):
    """What is known about the items before the measurement: a rectangular distribution."""

    distribution: Literal["rectangular"] = Field(description="Distribution of the items.", examples=["rectangular"])
    low: Annotated[Stated, ValueOnly()] = Field(description="Lower end.", examples=["22 kN/m"])
    high: Annotated[Stated, ValueOnly()] = Field(description="Upper end.", examples=["28 kN/m"])


Prior = Annotated[NormalPrior | GammaPrior | LognormalPrior | RectangularPrior, Field(discriminator="distribution")]


class Requirement(Entry):
    """A requirement on a quantity, with its decision rule; without a rule there is no verdict."""

    id: Id = Field(description="Identification of the requirement.", examples=["R1"])
    text: Text = Field(
        "",
        description="The requirement as the customer wrote it.",
        examples=["The stiffness shall be at least 20 kN/m."],
    )
    source: Text = Field(
        "",
        description="Specification that sets it, with edition and clause, and its entry in the verification control "
        "document where there is one.",
        examples=["TS-04 issue 2, 3.1; VCD 12"],
    )
    close_out: Text = Field(
        "",
        description="Judgement whether the verification of the requirement is closed (ECSS).",
        examples=["closed by this report"],
    )
    quantity: Reference = Field(description="Full name of the quantity.", examples=["al-1100-elongation.k"])
    limits: Limits = Field(description="Tolerance limits.", examples=["{lower: 20 kN/m}"])
    decision: Decision = Field(
        description="Decision rule, agreed with the customer.", examples=["{rule: guard band, factor: 1.0}"]
    )
    prior: Prior | None = Field(
        None,
        description="Distribution of the items before the measurement, for the global risks.",
        examples=["{distribution: gamma, shape: 4, scale: 0.25 um}"],
    )


class Audit(Entry):
    """A published or expected figure, to be compared with the recomputed one."""

    figure: Filled = Field(description="What the figure is.", examples=["k of Al-1100 (Table II)"])
    quantity: Reference | None = Field(
        None, description="Full name of the quantity that recomputes it.", examples=["al-1100-elongation.k"]
    )
    expression: Filled | None = Field(
        None, description="An expression that recomputes it, instead of `quantity`.", examples=["1 - 59.16/69.0"]
    )
    where: SymbolTable[Reference] = Field({}, description="As in `derived`.", examples=["{E: al-1100.E}"])
    published: Stated = Field(description="The figure as published, to its digits.", examples=["24734.25 ± 335.52 N/m"])
    source: Text = Field("", description="Where it is published.", examples=["Table II"])
    remark: Text = Field(
        "", description="Remark that the report prints with it.", examples=["another table gives 48.81"]
    )

    @model_validator(mode="after")
    def _one(self) -> Audit:
        one_of(self, "quantity", "expression", "one of the two")
        return self
