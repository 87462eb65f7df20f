"""Tension tests as a subject of diagnosis: records of crosshead and extensometer, and what parts them from a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import log

import numpy as np

from metrology.diagnosis import Diagnosis
from metrology.diagnostics.block_trials import Trial
from metrology.diagnostics.blocks import STEP, Readings
from metrology.diagnostics.candidate import TENSION
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.engine import rank
from metrology.diagnostics.plain import Plain
from metrology.diagnostics.plain_reported import sizes_of_blocks
from metrology.diagnostics.subject import Array, Fit
from metrology.diagnostics.tension_candidates import limited, shared
from metrology.diagnostics.tension_laws import unlisted
from metrology.diagnostics.tension_pictures import gap, pictures
from metrology.diagnostics.tension_records import FINER, Read, Record, course, few, length, parts, rate, record, steady
from metrology.diagnostics.tension_seen import unseen
from metrology.estimation import Unknown
from metrology.message import said
from metrology.tension.lines import Lines
from metrology.tension.test import TensionTest

RATES, LEAST = 2.0, 4
"""Rates of force, the largest over the smallest, and specimens from which on a line over the rate can be drawn."""
SCALE = "extensometer scale"
"""Cause that does to the readings what a compliance does that all records share."""
SELDOM = 5e-4
"""Rate at which a chance scatter would be taken for an effect of the rate."""


class Tension:
    """A tension test in numbers: means of the readings over the range, first of the crosshead, then of the strain."""

    def __init__(self, test: TensionTest, drawn: Sequence[Lines]) -> None:
        self.test, self.drawn = test, tuple(drawn)
        self.strain = all(one.strain is not None for one in drawn)
        self.crosshead = all(one.crosshead is not None for one in drawn) and (test.has_lengths or not self.strain)
        self.known = test.setup.value if test.setup is not None and not self.strain else 0.0
        areas = [one.mounting.area_value for one in drawn]
        area = float(np.mean(areas)) if np.isfinite(areas).all() else 0.0
        courses = [course(one, test) for one in drawn]
        self.cycled = any(inside is not None for _, inside in courses)
        halves = [(one, half, inside) for one, (rows, inside) in zip(drawn, courses, strict=True)
                  for half in parts(rows, alone=len(drawn) == 1)]  # fmt: skip
        self.halves = len(halves) // len(drawn)
        most = max(float(one.mounting.force[one.passage.rows].max()) for one in drawn)
        least = min(float(one.mounting.force[one.passage.rows].min()) for one in drawn)
        read = Read(self.crosshead, self.strain, self.known, area, most, (most + least) / 2, len(halves), self.halves)
        self.records = [record(at, one, (rows, inside), read) for at, (one, rows, inside) in enumerate(halves)]
        self.few = few(self.records)
        if self.few:
            self.records = [steady(one) for one in self.records]
        found = np.array([self._own_slope(one) for one in self.records])
        self.slope = float(np.mean(found))
        rates = np.array([rate(one) for one in self.records])
        self.rates = rates - rates.mean()
        self.several_rates = self.halves == 1 and len(found) >= LEAST and float(np.ptp(rates)) >= log(RATES)
        self.scatter = max(self._scatter(found), 1e-4 * self.slope)
        typical = float(np.median(np.concatenate([one.u for one in self.records])))
        first = replace(self.records[0].seen, slope=self.slope * self.records[0].scale, u=typical)
        self.seen = first
        self.records = [
            replace(one, seen=replace(one.seen, slope=self.slope * one.scale, u=typical, rate=float(own)))
            for one, own in zip(self.records, self.rates, strict=True)
        ]
        self.candidates = {name: limited(one, first) for name, one in TENSION.items()}
        if self.halves > 1:
            # The halves of one record are one mounting: what each mounting has of its own they have in common.
            self.candidates = {name: shared(one) for name, one in self.candidates.items()}
        self.withdrawn: dict[str, str] = {}

    def _scatter(self, slopes: Array) -> float:
        """Standard deviation of the slopes, which the specimens differ by.

        Where they were pulled at several rates, about the line over the logarithm of the rate, as wide as a normal
        distribution has to be that is exceeded no more often than Student's.
        """
        if not self.several_rates:
            return float(np.std(slopes, ddof=1))
        from scipy.special import ndtri, stdtrit

        line = np.column_stack([np.ones(len(slopes)), self.rates])
        left, dof = slopes - line @ np.linalg.lstsq(line, slopes)[0], len(slopes) - 2
        return float(np.sqrt(left @ left / dof) * stdtrit(dof, SELDOM) / ndtri(SELDOM))

    def _own_slope(self, one: Record) -> float:
        """Strain by force of one record alone, by the extensometer where there is one."""
        return float(one.polynomial(1)[0]) / one.scale

    def _bows(self) -> float:
        """Standard deviation among the records of their quadratic terms / (m/N²)."""
        found = [one.polynomial(2)[0] for one in self.records]
        return max(float(np.std(found, ddof=1)), 1e-12 * self.slope / self.seen.most)

    @property
    def stated(self) -> float:
        """Mean slope of the stated lines, strain by force / (1/N)."""
        free = [length(one) if self.strain else 1.0 for one in self.drawn]
        moved = [over * one.main.value - self.known for over, one in zip(free, self.drawn, strict=True)]
        found = [value / own.scale for value, own in zip(moved, self.records[:: self.halves], strict=True)]
        return float(np.mean(found))

    # ---- model --------------------------------------------------------------------------------------------------
    def predict(self, at: int, values: Mapping[str, float]) -> Array:
        """Readings of one record."""
        one = self.records[at]
        seen = one.seen
        y = one.scale * (values["slope"] + values.get("deviation", 0.0)) * seen.force
        y = y + np.where(seen.crosshead > 0, values.get("zero", 0.0), values.get("offset", 0.0))
        for name, candidate in self.candidates.items():
            size = values.get(candidate.size.name, 0.0)
            if size != 0.0:
                y = y + size * self.column(name, at, values)
        return np.asarray(y, dtype=float)

    def slopes(self, at: int, values: Mapping[str, float], unknowns: Sequence[Unknown]) -> Array:
        """Derivatives of the readings of one record by its unknowns, shape (p, n)."""
        return np.array([self._slope(at, values, entry) for entry in unknowns])

    def _slope(self, at: int, values: Mapping[str, float], entry: Unknown) -> Array:
        one, plain = self.records[at], entry.name.split("@")[0]
        crosshead = np.asarray(one.seen.crosshead > 0)
        linear = {"slope": one.scale * one.seen.force, "deviation": one.scale * one.seen.force,
                  "zero": crosshead.astype(float), "offset": (~crosshead).astype(float)}  # fmt: skip
        if plain in linear:
            return linear[plain]
        (name, candidate), = ((name, one) for name, one in self.candidates.items()
                              if plain in {size.name for size in one.parameters})  # fmt: skip
        if plain == candidate.size.name:
            return self.column(name, at, values)
        ends = np.clip(values[plain] + STEP * entry.scale * np.array([-1.0, 1.0]), entry.low, entry.high).tolist()
        low, high = (self.column(name, at, {**values, plain: end}) for end in ends)
        return np.asarray(values.get(candidate.size.name, 0.0) * (high - low) / (ends[1] - ends[0]))

    def column(self, name: str, at: int, shapes: Mapping[str, float]) -> Array:
        """What one unit of the size of a candidate does to the readings of a record."""
        candidate = self.candidates[name]
        assert candidate.cause.reading is not None
        values = [shapes[size.name] for size in candidate.parameters[1:]]
        return np.asarray(candidate.cause.reading(self.records[at].seen, *values), dtype=float)

    def trials(self, name: str, fit: Fit | None = None) -> Sequence[Trial]:
        """Shapes of a candidate, with the size that one standard deviation of a reading suggests."""
        candidate = self.candidates[name]
        shapes = candidate.shapes(self.seen, self.candidates)
        held = next((one.name for one in candidate.parameters if one.held), "")
        if fit is not None and len(shapes) == len(self.seen.places):
            shapes = self._likeliest(name, held, fit)
        return [Trial(candidate.amount(self.seen), shape) for shape in shapes]

    def _likeliest(self, name: str, held: str, fit: Fit) -> list[dict[str, float]]:
        """Of neighbouring places of a step the one where the residuals, but for a line, look most like it."""
        best: dict[int, tuple[float, float]] = {}
        for place in map(float, self.seen.places):
            at = int(place) // self.seen.steps
            seen, u = self.records[at].seen, self.records[at].u
            both = np.column_stack([self.column(name, at, {held: place}) / u, fit.residuals[at]])
            for kind in (0.0, 1.0):
                rows = seen.crosshead == kind
                line = np.column_stack([np.ones(rows.sum()), seen.force[rows]])
                both[rows] -= line @ np.linalg.lstsq(line, both[rows])[0]
            left, residual = both.T
            likeness = float(left @ residual) ** 2 / max(float(left @ left), 1e-9)
            best[int(place) // FINER] = max(best.get(int(place) // FINER, (-1.0, 0.0)), (likeness, place))
        return [{held: place} for _, place in best.values()]

    def reasons(self) -> dict[str, str]:
        """Candidates that these records cannot test."""
        found = dict(self.withdrawn)
        for name, one in self.candidates.items():
            if "tether" in one.cause.needs and not (self.crosshead and self.strain):
                found[name] = said("crosshead, extensometer and free length are needed together")
            elif name == "slip" and not self.crosshead:
                found[name] = said("the crosshead was not read, or the free length is not known")
            elif "unloading" in one.cause.needs and not self.cycled:
                text = "the records have one loading, at one rate. Needed: {needed}"
                found[name] = said(text, needed=one.separate)
            elif "time" in one.cause.needs and any(each.time is None for each in self.test.mountings):
                found[name] = said("no time was recorded")
            elif "repeats" in one.cause.needs and self.halves > 1:
                found[name] = said("there is one specimen")
            elif "rates" in one.cause.needs and not self.several_rates:
                text = "fewer than {least} specimens, or all at about one rate. Needed: {needed}"
                found[name] = said(text, least=LEAST, needed=one.separate)
            elif one.cause.alone:
                found[name] = said("{why}. Needed: {needed}", why=one.cause.alone, needed=one.separate)
        return found

    # ---- as the engine takes it ---------------------------------------------------------------------------------
    def subject(self, sample: str = "") -> Plain:
        """As the engine takes it."""
        common = (Unknown("slope", self.slope, 1e-2 * abs(self.slope), unit="1/N"),)
        blocks = tuple(
            Readings(one.name, "", one.y, one.u, channels=[(name, one.count) for name in self._channels()])
            for one in self.records
        )
        own = tuple(tuple(self._own(one)) for one in self.records)
        return Plain(
            sample, "tension", self.candidates, blocks, common, own, self.predict, self.trials, self.reasons(),
            lambda fit: gap(self.records, fit), lambda before, after: pictures(self.records, before, after),
            slopes=self.slopes, forms=self.families, acts_in=self.where, equivalents=self.equivalent,
            scatters={"curvature.uneven": self._bows()}, floor=1.0 if self.few else 0.0,
        )  # fmt: skip

    def _channels(self) -> list[str]:
        return ["crosshead"] * self.crosshead + ["extension"] * self.strain

    def _own(self, one: Record) -> list[Unknown]:
        """Zeros of a record, and what its specimen has of its own in the slope."""
        zeros = [("zero", 1.0)] * self.crosshead + [("offset", 0.0)] * self.strain
        found = [
            Unknown(f"{zero}@{one.name}", float(one.y[one.seen.crosshead == head].min()), float(one.u[0]), unit="m")
            for zero, head in zeros
        ]
        if len(self.test.mountings) > 1:
            u = self.scatter
            found.append(Unknown(f"deviation@{one.name}", 0.0, 0.1 * u, mean=0.0, u=u, unit="1/N"))
        return found

    def equivalent(self, fit: Fit, name: str) -> tuple[str, Mapping[str, float]] | None:
        """Scale of the extensometer in the place of a compliance that all records share, and the reverse.

        Beside one of them nothing of the other can be seen: the crosshead moves by the same part of the force more than
        the extensometer reads.
        """
        whole = "setup" if self.halves > 1 else "constant setup"
        other = {SCALE: whole, whole: SCALE, "setup": SCALE}.get(name)
        if other is None or other in fit.effects or other in self.reasons():
            return None
        by_force = self.slope * float(np.mean([one.scale for one in self.records]))
        own, size = self.candidates[name].size, self.candidates[other].size
        # Compliances that differ between the mountings leave what they have in common.
        found = float(np.mean([value for key, value in fit.values.items() if key.partition("@")[0] == own.name]))
        part = found if name == SCALE else -found / by_force
        value, moved = (-part * by_force, part) if name == SCALE else (part, -part)
        laws = {self.candidates[one].cause.law for one in fit.effects if one != name} - {""}
        if self.candidates[other].cause.law in laws or not size.low <= value <= size.high:
            return None
        return other, {**fit.values, size.name: value, "slope": fit.values["slope"] + moved * self.slope}

    def families(self, _fit: Fit) -> list[Direction]:
        """Extension of any form."""
        return unlisted(self.records, self.seen, crosshead=self.crosshead, strain=self.strain)

    # ---- what is reported ---------------------------------------------------------------------------------------
    def where(self, fit: Fit, name: str, spread: Array) -> str:
        """Sizes of the mountings, where each has its own; the mounting where an effect acts in one alone."""
        candidate = self.candidates[name]
        if candidate.size.own:
            return sizes_of_blocks(fit, candidate.size, [one.name for one in self.records], spread)
        held = next((one.name for one in candidate.parameters if one.held), "")
        if held not in fit.values or len(self.records) == 1:
            return ""
        number = round(fit.values[held]) // self.records[0].seen.steps
        return said("It acts in {blocks:comma}.", blocks=(self.records[number].name,))


def tension(test: TensionTest, drawn: Sequence[Lines], *, rng: np.random.Generator, sample: str = "") -> Diagnosis:
    """Diagnose a tension test: what parts crosshead and extensometer, and what bends or breaks their lines.

    A cause that is named, and that the records do not show by itself, is left out, and the search begins again.

    Parameters
    ----------
    test : TensionTest
        As for `tension.analyse`.
    drawn : sequence of Lines
        Its lines.
    rng : Generator
        For bootstrap intervals.
    sample : str
        Id of the sample, for the result.
    """
    subject = Tension(test, drawn)
    found = rank(subject.subject(sample), rng=rng, test=test.name)
    while not_shown := unseen(found, subject.records, subject.candidates, subject.halves):
        subject.withdrawn |= not_shown
        found = rank(subject.subject(sample), rng=rng, test=test.name)
    return found
