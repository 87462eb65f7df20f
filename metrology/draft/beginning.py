"""Where a line is taut, its stiffness, and where a run begins: what the readings tell, and within what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.declaration.columns import Floats
from metrology.draft.recognition import FEWEST, driven, moved, pull
from metrology.draft.seen import Seen
from metrology.draft.survey import Survey

TAUT = 0.3
"""Part of the largest tension from which on a line is taken to be taut throughout. A choice: below it a sagging line
and the zero of the cell bend the record, above it most readings of a pull are left for the line through them."""
APART = 5
"""Readings before and after one over which its speed is taken, where none was read: enough to bring the noise of a
motion capture below the speed of a pull. A speed that is too small by one factor changes neither k nor taut."""


@dataclass(frozen=True)
class Line:
    """Where a line is just taut, within what standard uncertainty, and its stiffness: texts with units."""

    taut: str
    spread: str
    k: str


@dataclass(frozen=True)
class Beginning:
    """Where a run begins: the text of the position, its unit, the scatter of one reading in that unit, and why."""

    text: str
    unit: str
    scatter: float
    why: str


def tension(one: Survey) -> Seen | None:
    """The column of the tension; one of another file at the times of the motion."""
    if (own := pull(one)) or not one.beside:
        return own
    other = next((each for each in one.beside if pull(each)), None)
    force = pull(other) if other else None
    time, at = one.first("time"), other.first("time") if other else None
    if force is None or time is None or at is None or force.values is None or time.unit != at.unit:
        return force
    if time.values is None or at.values is None:
        return replace(force, values=None)
    known = np.isfinite(force.values) & np.isfinite(at.values)
    values = np.interp(time.values, at.values[known], force.values[known], left=np.nan, right=np.nan)
    return replace(force, values=values)


def begin_of(one: Survey, thrust: Seen) -> str:
    """Time until which there is no thrust; nothing where it is there from the beginning."""
    time, pushed = one.first("time"), _pushed(thrust)
    if time is None or time.values is None or not pushed:
        return ""
    # The last reading without thrust: a thrust that was measured rises between two readings.
    return f"{time.values[pushed - 1]:.6g} {time.unit or 's'}"


def _pushed(thrust: Seen) -> int:
    """Index of the first reading with thrust; 0 where there is none, or from the beginning."""
    if thrust.values is None:
        return 0
    found = np.flatnonzero(np.abs(thrust.values) > 0.5 * np.nanmax(np.abs(thrust.values)))
    return int(found[0]) if len(found) and found[0] > 1 else 0


def rest_of(one: Survey) -> Beginning | None:
    """The mean of the positions before the thrust, where it is read in the same file; None where they are too few."""
    x, thrust = moved(one), driven(one)
    if x is None or x.values is None or thrust is None or not x.unit:
        return None
    rest = x.values[: _pushed(thrust)]
    rest = rest[np.isfinite(rest)]
    scatter = float(np.std(rest, ddof=1)) if len(rest) >= FEWEST else 0.0
    if not scatter > 0:
        return None
    return Beginning(f"{np.mean(rest):.6g} {x.unit}", x.unit, scatter, "the mean of the rest before the thrust")


def beginning(x: Seen) -> Beginning:
    """The first reading of a position."""
    first = next(value for value in x.values if np.isfinite(value)) if x.values is not None else 0.0
    unit = x.unit or "m"
    return Beginning(f"{first:.6g} {unit}", unit, 0.0, "the first reading")


def line_of(runs: Sequence[Survey]) -> Line | None:
    """The line through tension against position and speed of all runs; None where no run has one."""
    x, pulled = moved(runs[0]), tension(runs[0])
    if x is None or pulled is None or not (x.unit and pulled.unit):
        return None
    found = [line for one in runs if _alike(one, x, pulled) and (line := _line(one))]
    if not found:
        return None
    taut, spread, k = (np.array(part) for part in zip(*found, strict=True))
    between = float(np.std(taut, ddof=1)) if len(taut) > 1 else 0.0
    within = float(np.hypot(between, np.median(spread)))
    # As many decimal places as the uncertainty has.
    places = max(0, 1 - int(np.floor(np.log10(within)))) if within > 0 else 6
    return Line(
        f"{np.mean(taut):.{places}f} {x.unit}", f"{within:.2g} {x.unit}", f"{np.mean(k):.3g} {pulled.unit}/{x.unit}"
    )


def _alike(one: Survey, x: Seen, pulled: Seen) -> bool:
    other, force = moved(one), tension(one)
    return other is not None and force is not None and (other.unit, force.unit) == (x.unit, pulled.unit)


def _line(one: Survey) -> tuple[float, float, float] | None:
    """Position at which the line is taut, its standard uncertainty, and the stiffness, while the line pulls."""
    x, pulled = moved(one), tension(one)
    if x is None or pulled is None or x.values is None or pulled.values is None:
        return None
    speed = _speed(one, x)
    both = np.isfinite(x.values) & np.isfinite(pulled.values)
    both &= True if speed is None else np.isfinite(speed)
    position, force = x.values[both], pulled.values[both]
    taut = force > TAUT * np.max(force, initial=0.0)
    if np.count_nonzero(taut) < FEWEST or not np.ptp(position[taut]) > 0:
        return None
    terms = [position[taut], np.ones(np.count_nonzero(taut))]
    if speed is not None and np.ptp(speed[both][taut]) > 0:
        terms.append(speed[both][taut])
    design = np.column_stack(terms)
    found = np.linalg.lstsq(design, force[taut], rcond=None)[0]
    slope, zero = float(found[0]), float(found[1])
    if not slope > 0 or np.linalg.matrix_rank(design) < design.shape[1]:
        return None
    left = force[taut] - design @ found
    variance = np.linalg.inv(design.T @ design) * (left @ left) / (len(left) - design.shape[1])
    along = np.array([zero / slope**2, -1 / slope] + [0.0] * (len(terms) - 2))
    return -zero / slope, float(np.sqrt(along @ variance @ along)), slope


def _speed(one: Survey, x: Seen) -> Floats | None:
    """Speed at each reading, as it was read, or by the positions before and after it; NaN at the ends."""
    read, time = one.first("velocity"), one.first("time")
    if read is not None:
        return None if read.values is None else np.nan_to_num(read.values)
    if x.values is None or time is None or time.values is None or len(x.values) <= 2 * APART:
        return None
    speed = np.full(len(x.values), np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        moved_by = x.values[2 * APART :] - x.values[: -2 * APART]
        speed[APART:-APART] = moved_by / (time.values[2 * APART :] - time.values[: -2 * APART])
    return speed
