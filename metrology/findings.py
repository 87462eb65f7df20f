"""Every result of a campaign as values: what the report prints, and what `results.json` keeps for good.

The report is made from `Findings` alone, so that it can be made again, years later, from `results.json`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Annotated, Any

from metrology import jsontext
from metrology.consensus import Consensus, Disagreement
from metrology.diagnosis import Diagnosis
from metrology.doc import Doc
from metrology.gum.attained import Attained
from metrology.gum.evaluation import BudgetRow, Coverage, MonteCarlo
from metrology.identification import (
    Anomaly,
    Assumption,
    CampaignItem,
    Document,
    InputFile,
    InstrumentState,
    Opinion,
    Party,
    Provided,
    Replaced,
    SampleItem,
    Signatory,
)
from metrology.judged import AuditRow, Comparison, Conformity, Withheld
from metrology.methods import METHODS
from metrology.tested import TestItem

__all__ = [
    "SCHEMA",
    "Anomaly",
    "AsStated",
    "Assumption",
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
    "Moments",
    "Opinion",
    "Party",
    "Provided",
    "Replaced",
    "Result",
    "SampleItem",
    "Signatory",
    "TestItem",
    "Withheld",
    "from_json",
    "json_schema",
    "to_json",
]

SCHEMA = "metrology-results/1"


@dataclass(frozen=True)
class Fit:
    """A calibration line or curve fitted to declared data: y = f(x; parameters), with the data for its plot."""

    name: Annotated[str, Doc("Name.")]
    model: Annotated[str, Doc("The model in words.")]
    parameters: Annotated[tuple[str, ...], Doc("Parameters, by name.")]
    values: Annotated[tuple[float, ...], Doc("Estimates of the parameters.")]
    u: Annotated[tuple[float, ...], Doc("Standard uncertainty, in SI.")]
    units: Annotated[tuple[str, ...], Doc("Their units.")]
    correlation: Annotated[tuple[tuple[float, ...], ...], Doc("Their correlation coefficients.")]
    dof: Annotated[float | None, Doc("Effective degrees of freedom; null where infinite or undefined.")]
    residual_standard_deviation: Annotated[
        float | None, Doc("Standard deviation of the residuals; null with stated uncertainties.")
    ]
    chi_squared: Annotated[float | None, Doc("Sum of squared weighted residuals; null without stated uncertainties.")]
    p_value: Annotated[
        float | None, Doc("Probability of a statistic at least as large by chance; null where there is none.")
    ]
    sentence: Annotated[str, Doc("The same in words.")]
    x: Annotated[tuple[float, ...], Doc("Values along the abscissa.")]
    y: Annotated[tuple[float, ...], Doc("Values along the ordinate.")]
    x_unit: Annotated[str, Doc("Unit of x.")]
    y_unit: Annotated[str, Doc("Unit of y.")]
    curve_x: Annotated[tuple[float, ...], Doc("Abscissae of the fitted curve.")]
    curve_y: Annotated[tuple[float, ...], Doc("The fitted curve.")]
    curve_u: Annotated[tuple[float, ...], Doc("Standard uncertainties of the fitted curve.")]


@dataclass(frozen=True)
class AsStated:
    """What the model as stated gives, where the data support another one."""

    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI; by the same way as that of the result.")]
    why: Annotated[str, Doc("Why it is not the result.")]


@dataclass(frozen=True)
class Moments:
    """Value and standard uncertainty by the GUM uncertainty framework: those that the budget adds up to."""

    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]


@dataclass(frozen=True)
class Result:
    """One quantity with its uncertainty: an entry of `results` in `results.json`."""

    name: Annotated[str, Doc("Full name, such as al-1100-elongation.k.")]
    sample: Annotated[str, Doc("Sample, by its name in the campaign file.")]
    test: Annotated[str, Doc("Test, by its name in the campaign file.")]
    method: Annotated[str, Doc(f"{', '.join(METHODS)}, creep (of a load that is held) or derived.")]
    quantity: Annotated[str, Doc("Symbol: k, E, c, zeta, omega_n, or the name that the campaign gives.")]
    value: Annotated[
        float,
        Doc(
            "Value, in SI: where clause 8 does not confirm the framework the mean of the draws, or their median where "
            "they have no standard deviation."
        ),
    ]
    u: Annotated[
        float,
        Doc(
            "Standard uncertainty, in SI, by the same way as the value: that of the draws, or half the width of their "
            "interval over the coverage factor of a normal distribution where they have none."
        ),
    ]
    framework: Annotated[Moments, Doc("By the GUM uncertainty framework, as in the budget.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    dof: Annotated[float | None, Doc("Effective degrees of freedom; null where infinite or undefined.")]
    dof_note: Annotated[str, Doc("Why the degrees of freedom are null.")]
    display_unit: Annotated[str, Doc("Unit in which the report prints it.")]
    coverage: Annotated[Coverage, Doc("Coverage interval by the GUM uncertainty framework.")]
    monte_carlo: Annotated[MonteCarlo, Doc("The same by propagation of distributions.")]
    budget: Annotated[tuple[BudgetRow, ...], Doc("Uncertainty budget, one row a component of an input.")]
    advice: Annotated[str, Doc("Which measurement would lower the uncertainty most.")]
    equation: Annotated[str, Doc("Equation of the measurement model, as text.")]
    headline: Annotated[bool, Doc("Whether it stands on page 1.")] = True
    unit_dsi: Annotated[
        str, Doc("The same unit as a D-SI string, such as \\newton\\per\\metre; empty where D-SI has no word.")
    ] = ""
    unit_qudt: Annotated[str, Doc("The same unit by its QUDT identifier; empty where the table has none.")] = ""
    stated: Annotated[AsStated | None, Doc("By the model as stated; null where that is the result.")] = None
    attained: Annotated[
        Attained | None, Doc("What its interval holds in simulated repetitions; null where none were made.")
    ] = None
    doubts: Annotated[
        tuple[str, ...], Doc("What forbids that a requirement passes on it: failed checks, refuted fits and the like.")
    ] = ()
    accepted: Annotated[tuple[str, ...], Doc("What would forbid it and was accepted: with reason and person.")] = ()

    @property
    def interval(self) -> tuple[float | None, float | None]:
        """The interval to report: the law's where JCGM 101 clause 8 confirms it, else the Monte Carlo one."""
        if self.monte_carlo.law_valid:
            return self.coverage.low, self.coverage.high
        return self.monte_carlo.interval


@dataclass(frozen=True)
class Correlation:
    """Correlation coefficient between two results, or between two inputs."""

    a: Annotated[str, Doc("One of the two, by its full name.")]
    b: Annotated[str, Doc("The other one.")]
    coefficient: Annotated[float, Doc("Correlation coefficient.")]


@dataclass(frozen=True)
class TakenAsExact:
    """A number of which no uncertainty is stated, where one could matter."""

    name: Annotated[str, Doc("Full name of the input, or test and parameter of the rig.")]
    description: Annotated[str, Doc("What it is.")]
    value: Annotated[float, Doc("Value, in SI.")]
    unit: Annotated[str, Doc("SI unit.")]
    result: Annotated[str, Doc("Result that it moves most, for that result's u.")]
    u: Annotated[float, Doc("Standard uncertainty of the number that makes u of the result a tenth larger, in SI.")]


@dataclass(frozen=True)
class Notice:
    """One thing that must be known before a number is used."""

    kind: Annotated[str, Doc("Failure, Withheld, Check, Model and so on, the gravest first.")]
    sentence: Annotated[str, Doc("One short sentence.")]


@dataclass(frozen=True)
class Message:
    """What a sentence was made of, so that a certificate can say it in another language with the same numbers."""

    text: Annotated[str, Doc("The sentence, as it stands elsewhere.")]
    message: Annotated[str, Doc("Key of the catalogue, with the names of its values.")]
    plural: Annotated[str, Doc("The same for a count that is not one; empty where there is no count.")]
    values: Annotated[Mapping[str, str | int | float | tuple[str, ...]], Doc("Value by name.")]


@dataclass(frozen=True)
class Findings:
    """Every result of one campaign.

    `warnings`: what speaks against a number or a verdict: overdue instruments, results that Monte Carlo does not
    confirm, failed checks, refuted models, fits and assumptions, |E_n| beyond 1, verdicts withheld, figures of an audit
    that differ; each in the words of page 1 where it says it.
    `notices`: all that must be known as page 1 says it, exclusions, deviations and what others provided too.
    `failures`: numerical failures, each a sentence: what happened, what it may mean, what to try.
    `unjudged`: requirements without a verdict: for want of a result, or for what `withheld` says.
    """

    schema: Annotated[str, Doc("Version of the format; fields are added within a version, none changes its meaning.")]
    campaign: Annotated[CampaignItem, Doc("Identification of the campaign and its report.")]
    software: Annotated[Mapping[str, str], Doc("Version of every program that made the numbers, by name.")]
    inputs: Annotated[tuple[InputFile, ...], Doc("Every file that went in, the campaign file first.")]
    seed: Annotated[int, Doc("Seed of the Monte Carlo draws.")]
    samples: Annotated[tuple[SampleItem, ...], Doc("The items tested.")]
    instruments: Annotated[tuple[InstrumentState, ...], Doc("The instruments with the state of their calibration.")]
    tests: Annotated[tuple[TestItem, ...], Doc("The tests as carried out, with what each showed.")]
    fits: Annotated[tuple[Fit, ...], Doc("Calibration lines and curves.")]
    results: Annotated[tuple[Result, ...], Doc("Every quantity with its uncertainty.")]
    correlations: Annotated[
        tuple[Correlation, ...], Doc("Correlation coefficients between results, those of zero left out.")
    ]
    conformity: Annotated[tuple[Conformity, ...], Doc("Verdict on every requirement that could be judged.")]
    comparisons: Annotated[tuple[Comparison, ...], Doc("Results compared with one another or with reference values.")]
    audit: Annotated[tuple[AuditRow, ...], Doc("Published or expected figures and the recomputed ones.")]
    warnings: tuple[str, ...]
    failures: tuple[str, ...]
    references: Annotated[tuple[str, ...], Doc("What is cited, in full.")]
    verification: Annotated[tuple[dict[str, Any], ...], Doc("Models against runs that their fits have not seen.")] = ()
    diagnosis: Annotated[tuple[Diagnosis, ...], Doc("Where a model is wrong, why, and what an extension gains.")] = ()
    extra: Annotated[Mapping[str, Any], Doc("Further values that this version has no field for.")] = field(
        default_factory=dict
    )
    unjudged: tuple[str, ...] = ()
    withheld: Annotated[tuple[Withheld, ...], Doc("Requirements on results past a failed check.")] = ()
    exact: Annotated[tuple[TakenAsExact, ...], Doc("Numbers of which no uncertainty is stated.")] = ()
    consensus: Annotated[tuple[Consensus, ...], Doc("Quantities of one sample that several tests give.")] = ()
    disagreements: Annotated[tuple[Disagreement, ...], Doc("What explains that results of one quantity differ.")] = ()
    input_correlations: Annotated[
        tuple[Correlation, ...],
        Doc("Correlation coefficients between inputs: stated, by simultaneous readings, by fits, by shared causes."),
    ] = ()
    notices: Annotated[tuple[Notice, ...], Doc("What must be known before a number is used, as page 1 says it.")] = ()
    messages: Annotated[tuple[Message, ...], Doc("What sentences of the certificate were made of.")] = ()


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
