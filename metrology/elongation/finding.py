"""What the report shows of an elongation test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from metrology.check import Check
from metrology.doc import Doc

Floats = tuple[float, ...]


@dataclass(frozen=True)
class LoadLevel:
    """What the readings at one load say, in SI.

    `extension` is the mean of the readings used, freed of zero shifts between repeats; `standard_deviation` the
    scatter of the `count` readings about it; `residual` the mean less the line. `stiffness` is the secant from the
    line's zero, F / (x − x₀), with the standard uncertainty of repeatability, resolution and indicator; None at a load
    of zero.
    """

    load: Annotated[str, Doc("Load, by its name in the campaign file.")]
    force: Annotated[float, Doc("Force / N.")]
    extension: float
    standard_deviation: float
    count: int
    stiffness: float | None
    stiffness_u: Annotated[float | None, Doc("Its standard uncertainty / (N/m).")]
    residual: float


@dataclass(frozen=True)
class RepeatLine:
    """The line through the readings of one run alone: stiffness N/m, and shift m of its zero against the first run's.

    `stiffness_u` holds the repeatability of the readings only.
    """

    repeat: Annotated[str, Doc("Repeat, as in the readings.")]
    direction: Annotated[str, Doc("loading or unloading.")]
    stiffness: Annotated[float, Doc("Stiffness / (N/m).")]
    stiffness_u: float
    zero_shift: Annotated[float, Doc("Shift of the zero against the first run / m.")]


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
    intercept: Annotated[float, Doc("Extension of the line at no force / m.")]
    slope: Annotated[float, Doc("Compliance, the slope of the line / (m/N).")]
    slope_u: float
    levels: Annotated[tuple[LoadLevel, ...], Doc("What the readings at each load say.")]
    repeats: Annotated[tuple[RepeatLine, ...], Doc("The line through each run alone.")]
    checks: Annotated[tuple[Check, ...], Doc("Checks of the data against what the model supposes.")]
    equations: Annotated[tuple[str, ...], Doc("Equations of the method, as text.")]
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")] = ()
    significance: float | None = None
