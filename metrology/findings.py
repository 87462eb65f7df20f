"""Every result of a campaign as values: what the report prints, and what `results.json` keeps for good.

The report is made from `Findings` alone, so that it can be made again, years later, from `results.json`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, make_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from metrology import jsontext
from metrology.diagnosis import Diagnosis
from metrology.doc import Doc
from metrology.gum.evaluation import BudgetRow, Coverage, MonteCarlo
from metrology.identification import (
    Anomaly,
    CampaignItem,
    Document,
    InstrumentState,
    Opinion,
    Party,
    Provided,
    Replaced,
    SampleItem,
    Signatory,
)
from metrology.method import Finding
from metrology.methods import METHODS

__all__ = [
    "SCHEMA",
    "Anomaly",
    "AuditRow",
    "CampaignItem",
    "Comparison",
    "Conformity",
    "Correlation",
    "Document",
    "Findings",
    "Fit",
    "InputFile",
    "InstrumentState",
    "Opinion",
    "Party",
    "Provided",
    "Replaced",
    "Result",
    "SampleItem",
    "Signatory",
    "TestItem",
    "from_json",
    "json_schema",
    "to_json",
]

SCHEMA = "metrology-results/1"


@dataclass(frozen=True)
class Fit:
    """A calibration line or curve fitted to declared data: y = f(x; parameters), with the data for its plot."""

    name: str
    model: str
    parameters: tuple[str, ...]
    values: tuple[float, ...]
    u: tuple[float, ...]
    units: tuple[str, ...]
    correlation: tuple[tuple[float, ...], ...]
    dof: float | None
    residual_standard_deviation: float | None
    chi_squared: float | None
    p_value: float | None
    sentence: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    x_unit: str
    y_unit: str
    curve_x: tuple[float, ...]
    curve_y: tuple[float, ...]
    curve_u: tuple[float, ...]


@dataclass(frozen=True)
class _CarriedOut:
    """How a test was carried out."""

    id: str
    method: str
    title: str
    standard: str
    sample: str
    date: str
    operator: str
    environment: tuple[str, ...]
    instruments: tuple[str, ...]
    deviations: tuple[str, ...]
    exclusions: tuple[str, ...]


@dataclass(frozen=True)
class _Documented:
    """What a test was carried out by."""

    procedure: str = ""
    specification: str = ""
    as_run: str = ""
    setup: str = ""
    deviations_stated: bool = False


_SHOWN = [(name, Annotated[method.finding | None, Doc(method.shown)], None) for name, method in METHODS.items()]
_Shown: Any = make_dataclass("_Shown", _SHOWN, frozen=True)
"""A field for each method: what a test by it showed."""


@dataclass(frozen=True)
class TestItem(_Documented, _Shown, _CarriedOut):  # type: ignore[misc]
    """A test as carried out: what, when, by whom, with what, under which conditions, and what it showed."""

    __test__ = False

    @property
    def finding(self) -> Finding | None:
        """What the test showed, by its method."""
        return getattr(self, self.method) if self.method in METHODS else None

    def showing(self, finding: Finding) -> TestItem:
        """Return the test with what it showed."""
        shown: dict[str, Any] = {self.method: finding}
        return replace(self, **shown)


@dataclass(frozen=True)
class Result:
    """One quantity with its uncertainty: an entry of `results` in `results.json`."""

    name: str
    sample: str
    test: str
    method: str
    quantity: str
    value: float
    u: float
    unit: str
    dof: float | None
    dof_note: str
    display_unit: str
    coverage: Coverage
    monte_carlo: MonteCarlo
    budget: tuple[BudgetRow, ...]
    advice: str
    equation: str
    headline: bool = True
    unit_dsi: str = ""
    unit_qudt: str = ""

    @property
    def interval(self) -> tuple[float | None, float | None]:
        """The interval to report: the law's where JCGM 101 clause 8 confirms it, else the shortest Monte Carlo one."""
        if self.monte_carlo.law_valid:
            return self.coverage.low, self.coverage.high
        return self.monte_carlo.shortest_low, self.monte_carlo.shortest_high


@dataclass(frozen=True)
class Correlation:
    """Correlation coefficient between two results."""

    a: str
    b: str
    coefficient: float


@dataclass(frozen=True)
class Conformity:
    """A requirement, its decision rule, and the verdict (JCGM 106, ILAC-G8)."""

    requirement: str
    text: str
    result: str
    quantity: str
    value: float
    u: float
    unit: str
    display_unit: str
    lower: float | None
    upper: float | None
    rule: str
    guard_band: float
    acceptance_lower: float | None
    acceptance_upper: float | None
    probability: float
    verdict: Literal["pass", "conditional pass", "conditional fail", "fail"]
    specific_risk: float
    global_consumer_risk: float | None
    global_producer_risk: float | None
    sentence: str
    rule_risk: float | None = None
    agreed: str = ""
    source: str = ""
    close_out: str = ""


@dataclass(frozen=True)
class Comparison:
    """Two results, or a result and a reference value, compared by E_n (ISO 13528 9.7; ISO/IEC 17043 B.3)."""

    title: str
    a: str
    b: str
    value_a: float
    u_a: float
    value_b: float
    u_b: float
    unit: str
    display_unit: str
    difference: float
    u_difference: float
    en: float | None
    agrees: bool | None
    sentence: str


@dataclass(frozen=True)
class AuditRow:
    """A published or expected figure, the recomputed one, and whether they agree."""

    figure: str
    source: str
    published: str
    recomputed: str
    difference: str
    agrees: bool
    sentence: str


@dataclass(frozen=True)
class InputFile:
    """A file that went in, with its hash."""

    path: str
    sha256: str
    bytes: int


@dataclass(frozen=True)
class Findings:
    """Every result of one campaign.

    `warnings`: what the reader must know before he uses a number (overdue instrument, law of propagation not valid).
    `failures`: numerical failures, each a sentence: what happened, what it may mean, what to try.
    `unjudged`: requirements that could not be judged, for want of a result.
    """

    schema: str
    campaign: CampaignItem
    software: Mapping[str, str]
    inputs: tuple[InputFile, ...]
    seed: int
    samples: tuple[SampleItem, ...]
    instruments: tuple[InstrumentState, ...]
    tests: tuple[TestItem, ...]
    fits: tuple[Fit, ...]
    results: tuple[Result, ...]
    correlations: tuple[Correlation, ...]
    conformity: tuple[Conformity, ...]
    comparisons: tuple[Comparison, ...]
    audit: tuple[AuditRow, ...]
    warnings: tuple[str, ...]
    failures: tuple[str, ...]
    references: tuple[str, ...]
    verification: tuple[dict[str, Any], ...] = ()
    diagnosis: tuple[Diagnosis, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict)
    unjudged: tuple[str, ...] = ()


@cache
def _adapter() -> Any:
    from pydantic import ConfigDict, TypeAdapter

    Findings.__pydantic_config__ = ConfigDict(extra="forbid", ser_json_inf_nan="strings")  # type: ignore[attr-defined]
    return TypeAdapter(Findings)


@cache
def _validator() -> Any:
    return jsontext.validator(_adapter().core_schema)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of what `to_json` writes, as the classes alone give it."""
    schema: dict[str, Any] = _adapter().json_schema(mode="serialization")
    return schema


def to_json(findings: Findings) -> bytes:
    """Write findings as `results.json`: UTF-8, full precision, infinite degrees of freedom as ``null``.

    JSON has no word for a number that does not exist: it is the text ``"NaN"``, an infinite u ``"Infinity"``.
    """
    return bytes(_adapter().dump_json(findings, indent=1)) + b"\n"


def from_json(data: bytes | Path) -> Findings:
    """Read `results.json` back; ``from_json(to_json(f)) == f``.

    Raises
    ------
    ValueError
        In one line: what is no JSON, is too large or too deep, or not what this version writes.
    OSError
        Where the file cannot be read.
    """
    raw = jsontext.read(data) if isinstance(data, Path) else data
    result: Findings = jsontext.validated(raw, _validator())
    return result
