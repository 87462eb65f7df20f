"""What results are held against: requirements with their verdicts, other results, published figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.doc import Doc


def judged_name(name: str) -> str:
    """Name that an input has as a result, where a requirement or a comparison is on it."""
    return f"{name} (as stated)"


def is_on(judged: str, result: str) -> bool:
    """Whether what is judged is a result: a requirement names an input by the name that the campaign gives it."""
    return result in (judged, judged_name(judged))


@dataclass(frozen=True)
class Conformity:
    """A requirement, its decision rule, and the verdict (JCGM 106, ILAC-G8)."""

    requirement: Annotated[str, Doc("Identification of the requirement.")]
    text: Annotated[str, Doc("The requirement as the customer wrote it.")]
    result: Annotated[str, Doc("Result that is judged, by its full name.")]
    quantity: Annotated[str, Doc("Symbol: k, E, c, zeta, omega_n, or the name that the campaign gives.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    display_unit: Annotated[str, Doc("Unit in which the report prints it.")]
    lower: Annotated[float | None, Doc("Lower tolerance limit; null where there is none.")]
    upper: Annotated[float | None, Doc("Upper tolerance limit; null where there is none.")]
    rule: Annotated[str, Doc("The rule of the decision, in words.")]
    guard_band: Annotated[float, Doc("Guard band w.")]
    acceptance_lower: Annotated[float | None, Doc("Lower acceptance limit.")]
    acceptance_upper: Annotated[float | None, Doc("Upper acceptance limit.")]
    probability: Annotated[float, Doc("Probability of conformity, given the result.")]
    verdict: Annotated[Literal["pass", "conditional pass", "conditional fail", "fail"], Doc("The verdict.")]
    specific_risk: Annotated[float, Doc("Probability that the verdict is wrong for this item.")]
    global_consumer_risk: Annotated[
        float | None, Doc("Probability that an item of the prior is wrongly accepted; null without a prior.")
    ]
    global_producer_risk: Annotated[
        float | None, Doc("Probability that an item of the prior is wrongly rejected; null without a prior.")
    ]
    sentence: Annotated[str, Doc("The same in words.")]
    rule_risk: Annotated[
        float | None, Doc("Largest specific risk of a wrong pass that the rule allows; null where it bounds none.")
    ] = None
    agreed: Annotated[str, Doc("Day on which the rule was agreed.")] = ""
    source: Annotated[str, Doc("Specification that sets the requirement.")] = ""
    close_out: Annotated[str, Doc("Judgement whether the verification is closed.")] = ""
    accepted: Annotated[tuple[str, ...], Doc("Failed checks that were accepted, each with reason and person.")] = ()
    lower_stated: Annotated[str, Doc("Lower tolerance limit as the campaign states it; empty where none.")] = ""
    upper_stated: Annotated[str, Doc("Upper tolerance limit as the campaign states it; empty where none.")] = ""
    low: Annotated[float | None, Doc("Lower end of the interval of the result, in SI.")] = None
    high: Annotated[float | None, Doc("Upper end of the interval of the result, in SI.")] = None
    resolution: Annotated[
        float, Doc("Smallest probability that the draws tell from zero; 0 where probabilities are those of a law.")
    ] = 0.0


@dataclass(frozen=True)
class Withheld:
    """A requirement on a result that exists, but past a failed check: no verdict is given."""

    requirement: Annotated[str, Doc("Identification of the requirement.")]
    text: Annotated[str, Doc("The requirement as the customer wrote it.")]
    result: Annotated[str, Doc("Result that would be judged, by its full name.")]
    reasons: Annotated[tuple[str, ...], Doc("What forbids the verdict, each a sentence.")]
    agreed: Annotated[str, Doc("Day on which the rule was agreed.")] = ""
    source: Annotated[str, Doc("Specification that sets the requirement.")] = ""
    close_out: Annotated[str, Doc("Judgement whether the verification is closed.")] = ""
    quantity: Annotated[str, Doc("Symbol: k, E, c, zeta, omega_n, or the name that the campaign gives.")] = ""
    display_unit: Annotated[str, Doc("Unit in which the report prints it.")] = ""
    lower: Annotated[float | None, Doc("Lower tolerance limit; null where there is none.")] = None
    upper: Annotated[float | None, Doc("Upper tolerance limit; null where there is none.")] = None
    lower_stated: Annotated[str, Doc("Lower tolerance limit as the campaign states it; empty where none.")] = ""
    upper_stated: Annotated[str, Doc("Upper tolerance limit as the campaign states it; empty where none.")] = ""


@dataclass(frozen=True)
class Comparison:
    """Two results, or a result and a reference value, compared by E_n (ISO 13528 9.7; ISO/IEC 17043 B.3)."""

    title: Annotated[str, Doc("Title as the report prints it.")]
    a: Annotated[str, Doc("First side, by name.")]
    b: Annotated[str, Doc("Second side, by name.")]
    value_a: Annotated[float, Doc("Value of the first side.")]
    u_a: Annotated[float, Doc("Standard uncertainty of the first side.")]
    value_b: Annotated[float, Doc("Value of the second side.")]
    u_b: Annotated[float, Doc("Standard uncertainty of the second side.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    display_unit: Annotated[str, Doc("Unit in which the report prints it.")]
    difference: Annotated[float, Doc("First less second; in an audit recomputed less published, as text.")]
    u_difference: Annotated[float, Doc("Standard uncertainty of the difference, with the correlation.")]
    en: Annotated[float | None, Doc("E_n, the difference over its expanded uncertainty; null where that is zero.")]
    agrees: Annotated[bool | None, Doc("Whether the two agree.")]
    sentence: Annotated[str, Doc("The same in words.")]


@dataclass(frozen=True)
class AuditRow:
    """A published or expected figure, the recomputed one, and whether they agree."""

    figure: Annotated[str, Doc("What the figure is.")]
    source: Annotated[str, Doc("Where it comes from.")]
    published: Annotated[str, Doc("The figure as published, as text.")]
    recomputed: Annotated[str, Doc("The recomputed figure, as text.")]
    difference: Annotated[str, Doc("First less second; in an audit recomputed less published, as text.")]
    agrees: Annotated[bool, Doc("Whether the two agree.")]
    sentence: Annotated[str, Doc("The same in words.")]
