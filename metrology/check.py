"""One check of data against what their model supposes, as a value; every method reports its checks so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from metrology.doc import Doc


@dataclass(frozen=True)
class Check:
    """One check of the data against what the model supposes: statistic, its p-value, verdict and a sentence."""

    name: Annotated[str, Doc("Name.")]
    statistic: Annotated[float | None, Doc("Test statistic; null where the check could not be made.")]
    p_value: Annotated[
        float | None, Doc("Probability of a statistic at least as large by chance; null where there is none.")
    ]
    passed: Annotated[bool | None, Doc("Whether it passed; null where it was not made.")]
    sentence: Annotated[str, Doc("The same in words.")]
    covered: Annotated[bool, Doc("Whether model and uncertainty of the result cover what fails it.")] = False
    effects: Annotated[
        tuple[str, ...] | None,
        Doc("Listed effects that can be what fails it; null where any of them can, empty where none."),
    ] = None
    concerns: Annotated[tuple[str, ...], Doc("Quantities that it says something of; empty where it is all.")] = ()
