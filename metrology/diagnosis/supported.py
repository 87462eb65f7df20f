"""What the data support of what all blocks share: values, and their covariance by cause."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Annotated, Literal

from metrology.doc import Doc

Floats = tuple[float, ...]


@dataclass(frozen=True)
class Source:
    """A part of the covariance of several values with one cause: columns·columnsᵀ.

    `kind`: scatter of the readings; what is not known of the effects; a stated input, which acts on all blocks alike
    and whose sign is kept; one that varies from run to run; what no model explains; the difference between models
    that cannot be distinguished.
    """

    name: Annotated[str, Doc("Name: the readings, or a stated input.")]
    kind: Literal["readings", "effects", "common", "per run", "inadequacy", "models"]
    columns: Annotated[tuple[Floats, ...], Doc("A row for each value; their products are its covariance.")]
    mean: Annotated[float, Doc("What is stated of a stated input, in SI.")] = 0.0
    u: Annotated[float, Doc("Standard uncertainty of a stated input, in SI.")] = 0.0
    unit: Annotated[str, Doc("SI unit of a stated input.")] = "1"
    dof: Annotated[float | None, Doc("Degrees of freedom; null where infinite.")] = None


@dataclass(frozen=True)
class Supported:
    """Joint distribution of what all blocks share, under the models that the data support.

    One model, or the mean over those that the data cannot tell apart, each as probable as its evidence says. `stated`:
    the same by the model as stated, on the same data with the same noise; NaN where that does not have it.
    """

    names: Annotated[tuple[str, ...], Doc("Parameters, by name.")]
    units: Annotated[tuple[str, ...], Doc("Their SI units.")]
    values: Annotated[Floats, Doc("Estimates.")]
    sources: Annotated[tuple[Source, ...], Doc("Their covariance, by cause.")]
    stated: Annotated[Floats, Doc("Estimates by the model as stated.")]
    stated_u: Annotated[Floats, Doc("Their standard uncertainties.")]

    @property
    def u(self) -> Floats:
        """Standard uncertainty of every value."""
        squares = [[x * x for part in self.sources for x in part.columns[at]] for at in range(len(self.names))]
        return tuple(sqrt(sum(row)) for row in squares)
