"""What several tests give for one quantity of one sample, as values: consensus, and what explains a disagreement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.doc import Doc

Verdict = Literal["explained", "ambiguous", "not explained"]


@dataclass(frozen=True)
class Member:
    """One result of the quantity."""

    result: Annotated[str, Doc("Result, by its full name.")]
    test: Annotated[str, Doc("Test, by its name in the campaign file.")]
    method: Annotated[str, Doc("Method of the test, as at the result.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    seconds: Annotated[float | None, Doc("Time in which the sample answers / s; null where it is not known.")]
    weight: Annotated[float | None, Doc("Weight in the consensus; null where the result does not count.")]
    en: Annotated[float | None, Doc("E_n against the consensus of the others; null where there is none.")]
    why_not: Annotated[str, Doc("Why it does not count; empty where it does.")] = ""


@dataclass(frozen=True)
class Consensus:
    """One quantity of one sample by several tests: an entry of `consensus` in `results.json`.

    `value`, `u`, `low` and `high` are null where fewer than two results count.
    """

    sample: Annotated[str, Doc("Sample, by its name in the campaign file.")]
    quantity: Annotated[str, Doc("Symbol: k, E or c.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    display_unit: Annotated[str, Doc("Unit in which the report prints it.")]
    members: Annotated[tuple[Member, ...], Doc("Every result of it.")]
    value: Annotated[float | None, Doc("Consensus value, in SI.")]
    u: Annotated[float | None, Doc("Its standard uncertainty, in SI.")]
    p: Annotated[float, Doc("Coverage probability.")]
    low: Annotated[float | None, Doc("Lower end of the coverage interval.")]
    high: Annotated[float | None, Doc("Upper end of the coverage interval.")]
    dof: Annotated[int | None, Doc("Degrees of freedom of the interval; null where it is normal.")]
    consistent: Annotated[bool | None, Doc("Whether the χ² test is passed; null where there is none.")]
    statistic: Annotated[float | None, Doc("χ² of the weighted mean.")]
    p_value: Annotated[
        float | None, Doc("Probability of a statistic at least as large by chance; null where there is none.")
    ]
    birge: Annotated[float | None, Doc("Birge ratio, the root of χ² for each degree of freedom.")]
    between: Annotated[float | None, Doc("Between-method standard deviation, relative to the value.")]
    sentence: Annotated[str, Doc("The same in words.")]


@dataclass(frozen=True)
class Candidate:
    """What could explain a disagreement, with its one parameter."""

    kind: Annotated[str, Doc("chance, scatter, set-up, instrument, rate, one test or sample changed.")]
    title: Annotated[str, Doc("The same in words.")]
    probability: Annotated[float, Doc("Probability given these results, among all that were tried.")]
    evidence: Annotated[float, Doc("ln Bayes factor against a scatter between the tests.")]
    parameter: Annotated[str, Doc("Symbol of its parameter; empty where it has none.")]
    value: Annotated[float | None, Doc("Mean of its parameter; null where it has none.")]
    u: Annotated[float | None, Doc("Standard uncertainty of its parameter; null where it has none.")]
    unit: Annotated[str, Doc("SI unit of its parameter.")]
    p_value: Annotated[float | None, Doc("Probability of the χ² that it leaves; null where it leaves none.")]


@dataclass(frozen=True)
class Disagreement:
    """Results that do not agree, and which single effect explains all of them: an entry of `disagreements`."""

    quantity: Annotated[str, Doc("Symbol: k, E or c.")]
    samples: Annotated[tuple[str, ...], Doc("Samples whose results were taken together.")]
    verdict: Annotated[Verdict, Doc("The verdict.")]
    sentence: Annotated[str, Doc("The same in words.")]
    candidates: Annotated[tuple[Candidate, ...], Doc("What was tried, the most probable first.")]
