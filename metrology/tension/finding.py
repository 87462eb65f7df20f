"""What the report shows of a tension test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from metrology.check import Check
from metrology.doc import Doc

Floats = tuple[float, ...]


@dataclass(frozen=True)
class Curve:
    """A record, thinned: every extreme is kept. Empty where a channel was not recorded."""

    force: Annotated[Floats, Doc("Force / N.")]
    strain: Annotated[tuple[float | None, ...], Doc("Strain by the extensometer; null where it was off.")]
    crosshead: Annotated[Floats, Doc("Displacement of the crosshead / m.")]


@dataclass(frozen=True)
class Specimen:
    """What the record of one specimen says, in SI; None where the record does not tell it.

    `low` and `high` are the ends of the range in force, `strain_low` and `strain_high` in strain; `slope` is strain by
    force, or displacement of the crosshead by force where there is no extensometer, `slope_u` its standard uncertainty
    by the scatter of the record alone, with `dof` degrees of freedom; `memory` the correlation of neighbouring means.
    `bow` is the deviation of a parabola from its chord over the range of the reading. `k`, `EA`, `E` and `C` are
    results, without an uncertainty here.
    """

    name: Annotated[str, Doc("Specimen, by its name in the campaign file.")]
    count: Annotated[int, Doc("Readings in the range.")]
    low: float
    high: float
    strain_low: float | None
    strain_high: float | None
    intercept: Annotated[float, Doc("Stretch of the line at no force.")]
    slope: float
    slope_u: float
    dof: float
    memory: float
    bow: float
    bow_u: Annotated[float, Doc("Standard uncertainty of the bow.")]
    k: Annotated[float | None, Doc("Stiffness of the free length / (N/m).")]
    EA: Annotated[float | None, Doc("Axial stiffness, force by strain / N.")]
    E: Annotated[float | None, Doc("Modulus of elasticity / Pa.")]
    C: Annotated[float | None, Doc("Compliance of the set-up / (m/N).")]
    C_u: Annotated[float | None, Doc("Its standard uncertainty by the scatter of the record / (m/N).")]
    force_most: Annotated[float, Doc("Largest force / N.")]
    broke: Annotated[bool | None, Doc("Whether the record reaches the strength; null where it was not asked for.")]
    strain_break: Annotated[float | None, Doc("Strain at break.")]
    outlier: Annotated[str, Doc("Why it does not fit with the others; empty where it does.")]
    curve: Annotated[Curve, Doc("The record, thinned.")]


@dataclass(frozen=True)
class Scatter:
    """A result over the specimens, in SI: mean, standard deviation between them, and within one by its record."""

    quantity: Annotated[str, Doc("Result.")]
    unit: Annotated[str, Doc("SI unit.")]
    mean: Annotated[float, Doc("Mean over the specimens.")]
    between: Annotated[float, Doc("Standard deviation between the specimens.")]
    within: Annotated[float, Doc("Standard deviation within one specimen, by its record.")]


@dataclass(frozen=True)
class Loading:
    """One loading of a record that goes up and down, or the part of it below or beyond the highest force so far."""

    specimen: Annotated[str, Doc("Specimen.")]
    number: Annotated[int, Doc("Number of the loading, from 1.")]
    first: Annotated[bool, Doc("Whether it goes beyond the highest force so far; else it is repeated below it.")]
    mean: Annotated[float, Doc("Mean load / N.")]
    amplitude: Annotated[float, Doc("Half of the rise of the load / N.")]
    highest: Annotated[float | None, Doc("Highest force before it / N; null where none was.")]
    seconds: Annotated[float | None, Doc("Time that it takes / s; null without a time.")]
    stiffness: Annotated[float, Doc("Force by strain / N, or by the crosshead as read / (N/m).")]
    u: Annotated[float, Doc("Its standard uncertainty by the record.")]


@dataclass(frozen=True)
class TensionFinding:
    """Everything that the report shows of a tension test, in SI."""

    by: Annotated[str, Doc("How the range was chosen, in words.")]
    basis: Annotated[str, Doc("What the stretch was read by: extensometer or crosshead.")]
    specimens: Annotated[tuple[Specimen, ...], Doc("Each specimen.")]
    scatter: Annotated[tuple[Scatter, ...], Doc("Scatter between and within specimens.")]
    checks: Annotated[tuple[Check, ...], Doc("Checks of the data against what the model supposes.")]
    equations: Annotated[tuple[str, ...], Doc("Equations of the method, as text.")]
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")] = ()
    significance: Annotated[float | None, Doc("Rate at which all checks together may fail by chance.")] = None
    loadings: Annotated[tuple[Loading, ...], Doc("Each loading of records that go up and down.")] = ()
