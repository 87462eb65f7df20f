"""Elongation tests as a subject of diagnosis: readings under dead loads, and what may bend the line through them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from metrology import effect
from metrology.diagnosis import Diagnosis, Missing, Picture
from metrology.diagnostics.block_trials import Trial
from metrology.diagnostics.blocks import STEP, Readings
from metrology.diagnostics.candidate import ELONGATION, Candidate, untested
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.elongation_laws import unlisted
from metrology.diagnostics.engine import rank
from metrology.diagnostics.own import added, declared
from metrology.diagnostics.plain import Plain
from metrology.diagnostics.plain_pictures import of_elongation
from metrology.diagnostics.plain_reported import binned, sizes_of_blocks
from metrology.diagnostics.scatter import scatter
from metrology.diagnostics.subject import Array, Fit
from metrology.elongation import ElongationTest
from metrology.elongation.model import force
from metrology.estimation import Unknown
from metrology.gum.inputs import Input
from metrology.message import counted, said
from metrology.rig.own import OwnEffect

Rows = np.ndarray[tuple[int, ...], np.dtype[np.intp]]
Marks = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

MANY = 10
"""Loads from which a knee is distinguished from a curvature, twice as many as both have parameters with the line. At
seven a periodic error of the indicator had it together with three other faults."""
ROUNDED = 1e-9
"""Part of the slope up to which those of the repeats differ by rounding alone."""


class Elongation:
    """An elongation test in numbers: force, direction, order and repeat of every reading in use."""

    def __init__(self, test: ElongationTest, own: Sequence[OwnEffect] = ()) -> None:
        used = test.used
        namespace = {item.name: item.value for item in _inputs(test)}
        forces = {load.name: float(force(test, load, namespace)) for load in test.loads}
        self.test = test
        self.names = tuple(dict.fromkeys(reading.repeat for reading in used))
        self.loads = tuple(load.name for load in test.loads)
        values = np.array([reading.value for reading in used])
        if test.correction is not None:
            given = {item.name: item.value for item in test.correction.inputs}
            values = np.asarray(test.correction.function(given, values), dtype=float)
        order = {name: at for at, name in enumerate(self.loads)}
        self.load = np.array([order[reading.load] for reading in used], dtype=np.intp)
        repeat = np.array([self.names.index(reading.repeat) for reading in used], dtype=np.intp)
        self.at: list[Rows] = [np.flatnonzero(repeat == index) for index in range(len(self.names))]
        self.force = np.array([forces[reading.load] for reading in used])
        self.back = np.array([reading.direction == "unloading" for reading in used], dtype=float)
        self.values = values
        self.place = np.arange(len(used), dtype=float)
        for rows in self.at:
            self.place[rows] = np.arange(len(rows))
        self.slope = float(np.polyfit(self.force, values, 1)[0])
        slopes = [float(np.polyfit(self.force[rows], values[rows], 1)[0]) for rows in self.at
                  if np.ptp(self.force[rows]) > 0]  # fmt: skip
        between = float(np.std(slopes, ddof=1)) if len(slopes) == len(self.at) > 1 else 0.0
        self.between = between if between > ROUNDED * abs(self.slope) else 0.0
        self.seen = effect.Readings(self.force, self.place, self.back, repeat)
        self.own = {one.name: one for one in own if one.reading}
        table = {name: _limited(one, self.seen) for name, one in ELONGATION.items()}
        self.candidates = table | {name: declared(one) for name, one in self.own.items()}
        self.known = self._known()
        self.u = self._scatter()

    # ---- what each candidate does -------------------------------------------------------------------------------
    def column(self, name: str, shapes: Mapping[str, float]) -> Array:
        """What one unit of the size of a candidate does to every reading."""
        if name in self.own:
            return added(self.own[name], (self.force, self.place, self.back), shapes)
        candidate = self.candidates[name]
        assert candidate.cause.reading is not None
        values = [shapes[size.name] for size in candidate.parameters[1:]]
        return np.asarray(candidate.cause.reading(self.seen, *values), dtype=float)

    def predict(self, at: int, values: Mapping[str, float]) -> Array:
        """Readings of one repeat."""
        rows = self.at[at]
        x = values["zero"] + values["slope"] * self.force[rows]
        for load, column in enumerate(self.loads):
            x = x + values.get(f"indicator.{column}", 0.0) * (self.load[rows] == load)
        for name, one in self.candidates.items():
            size = values.get(one.size.name, 0.0)
            if size != 0.0:
                x = x + size * self.column(name, values)[rows]
        return np.asarray(x, dtype=float)

    def slopes(self, at: int, values: Mapping[str, float], unknowns: Sequence[Unknown]) -> Array | None:
        """Derivatives of the readings of one repeat by its unknowns, shape (p, n); exact but for sought shapes.

        Differences would have noise of 1e-8 of themselves, another one on every processor.
        """
        rows = self.at[at]
        plain = {"slope": self.force[rows], "zero": np.ones(len(rows))}
        plain |= {
            f"indicator.{name}": np.asarray(self.load[rows] == load, float) for load, name in enumerate(self.loads)
        }
        sizes = {one.size.name: name for name, one in self.candidates.items()}
        found = []
        for entry in unknowns:
            name = entry.name.split("@")[0]
            if name in plain:
                found.append(plain[name])
            elif name in sizes:
                found.append(self.column(sizes[name], values)[rows])
            else:
                low, high = (
                    float(np.clip(values[name] + way * STEP * entry.scale, entry.low, entry.high)) for way in (-1, 1)
                )
                if low == high:
                    return None
                apart = self.predict(at, {**values, name: high}) - self.predict(at, {**values, name: low})
                found.append(apart / (high - low))
        return np.array(found)

    def trials(self, name: str, _fit: Fit | None = None) -> Sequence[Trial]:
        """Shapes of a candidate, with the size that one standard deviation of a reading suggests."""
        candidate, seen = self.candidates[name], replace(self.seen, u=self.u)
        return [Trial(candidate.amount(seen), shape) for shape in candidate.shapes(seen, self.candidates)]

    # ---- what is known beforehand -------------------------------------------------------------------------------
    def _known(self) -> list[float]:
        """Standard uncertainty of the mean at each load that is not scatter: indicator and mass."""
        declared = math.sqrt(sum(one.u**2 for one in self.test.indicator))
        return [math.hypot(declared, self._of_load(at)) for at in range(len(self.loads))]

    def _of_load(self, at: int) -> float:
        quantity = self.test.loads[at].quantity
        largest = float(np.max(self.force[self.load == at], initial=0.0))
        return abs(self.slope) * largest * quantity.u / (quantity.value or 1.0)

    def _scatter(self) -> float:
        """Scatter of one reading, whatever candidates may hide in it; never less than rounding leaves of it."""
        floor = 0.3 * self.test.resolution.u
        self.u = 1.0
        columns = [
            (self.candidates[name].signed, self.column(name, trial.shapes))
            for name in self.candidates
            if name not in self.reasons()
            for trial in self.trials(name)
        ]
        # Where slopes differ between repeats that is no scatter of the readings.
        slopes = len(self.at) if self.between > 0 else 1
        base = np.zeros((len(self.values), slopes + len(self.at)))
        for at, rows in enumerate(self.at):
            base[rows, min(at, slopes - 1)] = self.force[rows]
            base[rows, slopes + at] = 1.0
        loads = np.eye(len(self.loads))[self.load]
        return math.hypot(scatter(self.values, base, (loads, np.array(self.known)), columns), floor)

    def reasons(self) -> dict[str, str]:
        """Candidates that these readings cannot test."""
        found = untested(self.candidates)
        lacking: dict[str, str] = {}
        if not 0 < self.back.mean() < 1:
            lacking["unloading"] = said("loads were reached from one side only")
        steps = np.diff(self.force)
        if len(self.at) == 1 and ((steps > 0).all() or (steps < 0).all()):
            text = "loads only rise, or only fall, in the order of reading: a drift is a curve of load as well"
            lacking["order"] = said(text)
        if len(np.unique(self.force)) < MANY:
            lacking["loads"] = said("it takes {count} loads at least", count=MANY)
        if self.between == 0:
            lacking["repeats"] = said("it takes two repeats at least, each with two loads, whose slopes differ")
        return found | {
            name: lacking[need] for name, one in self.candidates.items() for need in one.cause.needs if need in lacking
        }

    # ---- as the engine takes it ---------------------------------------------------------------------------------
    def subject(self, sample: str = "") -> Plain:
        """As the engine takes it."""
        # A line that is pulled gets longer: the compliance has the sign that all readings together give it.
        low, high = (0.0, math.inf) if self.slope > 0 else (-math.inf, 0.0)
        common = [Unknown("slope", self.slope, abs(self.slope) * 1e-2, low, high, unit="m/N")]
        common += [
            Unknown(f"indicator.{name}", 0.0, u, mean=0.0, u=u, unit="m")
            for name, u in zip(self.loads, self.known, strict=True) if u > 0
        ]  # fmt: skip
        blocks = tuple(
            Readings(name, "x", self.values[rows], np.full(len(rows), self.u), self._phases(rows))
            for name, rows in zip(self.names, self.at, strict=True)
        )
        own = tuple((Unknown(f"zero@{name}", float(self.values[rows].min()), self.u, unit="m"),)
                    for name, rows in zip(self.names, self.at, strict=True))  # fmt: skip
        return Plain(
            sample, "elongation", self.candidates, blocks, tuple(common), own, self.predict, self.trials,
            self.reasons(), self.gap, self.pictures, slopes=self.slopes,
            floor=self.test.resolution.u / self.u, is_scarce=True, acts_in=self.where,
            scatters={"mounting.compliance": self.between} if self.between > 0 else {}, forms=self.families,
        )  # fmt: skip

    def families(self, _fit: Fit) -> list[Direction]:
        """Extension of any form: of load, of load and direction, of these in each repeat; of the order of reading."""
        return unlisted(self.at, self.force, self.back, self.u)

    def _phases(self, rows: Rows) -> list[tuple[str, Marks]]:
        back = self.back[rows] > 0
        return [(name, marks) for name, marks in (("loading", ~back), ("unloading", back)) if marks.any()]

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """Residual against load and in the order of reading."""
        rows = np.concatenate(self.at)
        return of_elongation((self.force[rows], rows.astype(float), self.back[rows] > 0), self.u, before, after)

    def where(self, fit: Fit, name: str, spread: Array) -> str:
        """Loads or readings at which an effect acts that was sought place by place; its size in each repeat."""
        candidate = self.candidates[name]
        if candidate.size.own:
            return sizes_of_blocks(fit, candidate.size, self.names, spread)
        places = candidate.limits(self.seen)
        if not any(size.held and size.name in places for size in candidate.parameters):
            return ""
        acts = self.column(name, fit.values) != 0
        first = self.test.used[int(np.argmax(acts))]
        reading = {"load": first.load, "repeat": first.repeat, "direction": said(first.direction)}
        if acts.sum() == 1:
            return said("It acts in the reading of load {load} in repeat {repeat}, {direction}.", **reading)
        loads = np.unique(self.load[acts])
        if (acts == np.isin(self.load, loads)).all():
            one, many = "It acts at load {loads:comma}.", "It acts at the loads {loads:comma}."
            return counted(one, many, len(loads), loads=tuple(self.loads[load] for load in loads))
        return said("It acts from the reading of load {load} in repeat {repeat}, {direction}, on.", **reading)

    def gap(self, fit: Fit) -> Missing | None:
        """Residual extension against force, order and direction."""
        rows = np.concatenate(self.at)
        residual = np.concatenate(fit.residuals) * self.u
        columns = {
            ("force", "N"): self.force[rows],
            ("order", "1"): self.place[rows],
            ("direction", "1"): self.back[rows],
        }
        return binned(said("missing {what}", what="extension"), "m", columns, residual, np.full(len(rows), self.u))


def _limited(one: Candidate, seen: effect.Readings) -> Candidate:
    """Candidate with as many choices as there are readings, and shapes within what the loads can show."""
    limits = one.limits(seen)
    sizes = (
        replace(
            size, low=limits[size.name][0], high=limits[size.name][1], null=max(size.null, limits[size.name][0]),
            scale=size.scale and 0.05 * seen.most,
        )
        if size.name in limits
        else size
        for size in one.parameters
    )  # fmt: skip
    return replace(one, parameters=tuple(sizes))


def _inputs(test: ElongationTest) -> list[Input]:
    named = [test.gravity, test.air_density, test.weight_density, *(load.quantity for load in test.loads)]
    return [item for item in (*named, test.weights, test.scale) if item is not None]


def elongation(
    test: ElongationTest, *, rng: np.random.Generator, sample: str = "",
    own: Sequence[OwnEffect] = (),
) -> Diagnosis:  # fmt: skip
    """Diagnose an elongation test: what bends or breaks the line of extension against load.

    Parameters
    ----------
    test : ElongationTest
        As for `elongation.analyse`.
    rng : Generator
        For simulated limits and bootstrap intervals.
    sample : str
        Id of the sample, for the result.
    own : sequence of OwnEffect
        Effects of the laboratory's own; those with a `reading` are tried like all others.
    """
    return rank(Elongation(test, own).subject(sample), rng=rng, test=test.name)
