"""Elongation under dead loads: stiffness k of a sample from load and extension."""

from __future__ import annotations

from dataclasses import dataclass

Floats = tuple[float, ...]


@dataclass(frozen=True)
class LoadLevel:
    """What the readings at one load say: `force` N, `extension` m (mean of the readings used), scatter, secant stiffness N/m."""

    load: str
    force: float
    extension: float
    standard_deviation: float
    count: int
    stiffness: float
    stiffness_u: float
    residual: float


@dataclass(frozen=True)
class RepeatLine:
    """The line through the readings of one repeat alone: its stiffness N/m and zero shift m against the first repeat."""

    repeat: str
    direction: str
    stiffness: float
    stiffness_u: float
    zero_shift: float


@dataclass(frozen=True)
class Check:
    """One check of the data against what the measurement model supposes: statistic, its p-value, verdict and a sentence."""

    name: str
    statistic: float | None
    p_value: float | None
    passed: bool | None
    sentence: str


@dataclass(frozen=True)
class ElongationFinding:
    """Everything that the report shows of one elongation test, in SI.

    `force`, `extension`, `residual` (extension less line), `repeat`, `direction` ("loading" or "unloading") and `excluded`
    (a reason, or "") have one entry a reading; the line is extension = intercept + slope·force.
    """

    force: Floats
    extension: Floats
    residual: Floats
    repeat: tuple[str, ...]
    direction: tuple[str, ...]
    excluded: tuple[str, ...]
    intercept: float
    slope: float
    slope_u: float
    levels: tuple[LoadLevel, ...]
    repeats: tuple[RepeatLine, ...]
    checks: tuple[Check, ...]
    equations: tuple[str, ...]
    notes: tuple[str, ...] = ()
