"""A result beside its reference, and what could part them, as values that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.doc import Doc

Judgement = Literal["allowed", "against what is stated", "against these data"]


@dataclass(frozen=True)
class Explanation:
    """One cause that could part a result from its reference: what it would have to be, and whether that can be.

    `needed` in `unit`, with its standard uncertainty; `tension`: that over what is known, in standard uncertainties,
    None where nothing is known; `measurement`, `power`: what would decide, and how far it would show the needed size.
    """

    cause: Annotated[str, Doc("The cause, by its name in the table.")]
    title: Annotated[str, Doc("Title as the report prints it.")]
    needed: float
    needed_u: Annotated[float, Doc("Standard uncertainty of the needed size.")]
    unit: str
    judgement: Annotated[Judgement, Doc("Whether it can be the cause.")]
    tension: float | None
    evidence: Annotated[tuple[str, ...], Doc("What speaks for or against it, each a sentence.")]
    measurement: str
    power: str
    sentence: Annotated[str, Doc("The same in words.")]


@dataclass(frozen=True)
class Discrepancy:
    """A result beside its reference, and every cause that could part them, those that can be first.

    `ratio`: result over reference, with its standard uncertainty; `normalised`: E_n of ISO 13528, with U = 2u, None
    where nothing was stated of either.
    """

    quantity: Annotated[str, Doc("Symbol: k, E, c, zeta, omega_n, or the name that the campaign gives.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    reference: Annotated[float, Doc("The reference value.")]
    reference_u: Annotated[float | None, Doc("Its standard uncertainty; null where none is stated.")]
    source: Annotated[str, Doc("Where it comes from.")]
    ratio: float
    ratio_u: Annotated[float, Doc("Standard uncertainty of the ratio.")]
    normalised: float | None
    explanations: Annotated[tuple[Explanation, ...], Doc("Every cause that could part them, those that can be first.")]
    sentence: Annotated[str, Doc("The same in words.")]
