"""What the report shows of an elongation test."""

from __future__ import annotations

from dataclasses import dataclass

from metrology.check import Check

Floats = tuple[float, ...]


@dataclass(frozen=True)
class LoadLevel:
    """What the readings at one load say, in SI.

    `extension` is the mean of the readings used, freed of zero shifts between repeats; `standard_deviation` the
    scatter of the `count` readings about it; `residual` the mean less the line. `stiffness` is the secant from the
    line's zero, F / (x − x₀), with the standard uncertainty of repeatability, resolution and indicator; None at a load
    of zero.
    """

    load: str
    force: float
    extension: float
    standard_deviation: float
    count: int
    stiffness: float | None
    stiffness_u: float | None
    residual: float


@dataclass(frozen=True)
class RepeatLine:
    """The line through the readings of one run alone: stiffness N/m, and shift m of its zero against the first run's.

    `stiffness_u` holds the repeatability of the readings only.
    """

    repeat: str
    direction: str
    stiffness: float
    stiffness_u: float
    zero_shift: float


@dataclass(frozen=True)
class ElongationFinding:
    """Everything that the report shows of one elongation test, in SI.

    `force`, `extension`, `residual` (extension less line), `repeat`, `direction` ("loading" or "unloading") and
    `excluded` (a reason, or "") have one entry a reading; the line is extension = intercept + slope·force. `extension`
    is the reading, corrected where the indicator has a correction, less the zero shift of its repeat. `slope_u` holds
    all components. `significance`: rate at which each check may fail on data with nothing wrong in them.
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
    significance: float | None = None
