"""Runs on the rig as a subject of diagnosis, with any of its effects."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from metrology.coordinate import QUANTITIES
from metrology.diagnosis import Missing, Picture
from metrology.diagnostics import flexible, free_force, settling
from metrology.diagnostics.candidate import RESPONSE, Candidate, untested
from metrology.diagnostics.following import followed
from metrology.diagnostics.force import missing_force
from metrology.diagnostics.pictures import of_response
from metrology.diagnostics.plain import FAR
from metrology.diagnostics.scale import scales as sizes_of
from metrology.diagnostics.settling import Model
from metrology.diagnostics.spectrum import strongest
from metrology.diagnostics.subject import LOST, Array, Direction, Fit, Marks, Slow, rounded
from metrology.diagnostics.wander import WANDER, wanders
from metrology.effect import Size
from metrology.estimation import Layout, MeasuredRun, Prior, lay_out
from metrology.estimation.priors import WIDER
from metrology.estimation.problem import Point, evaluate, slope
from metrology.estimation.response import motion, problem, values_of
from metrology.message import said
from metrology.rig import Rig, sensitivities
from metrology.verify.phases import phases

TURN = math.pi
"""Standard deviation of a phase of which nothing is known."""
PLAIN = 80
"""Steps of an integration that cost as much as a motion without any."""
EXACT = 12
"""States, squared, of a linear motion that costs as much as the base model's: a third of what others do."""
SURE = 8.0
"""Distance in standard deviations by which a trial should move the data."""


@dataclass(frozen=True)
class Response:
    """Runs on the rig, what the laboratory states of them, and the causes that may be tried.

    Parameters
    ----------
    rig : Rig
        As stated, with start values for what is free.
    runs : tuple of MeasuredRun
        All that may be used.
    free : tuple of str
        Parameters of which nothing is known.
    priors : tuple of Prior
        What is known within an uncertainty.
    sample : str
        Name of the sample.
    start : mapping of str to float
        Values by name of unknown where the base fit begins, such as those of an earlier fit.
    workers : int
        Motions at a time.
    amounts : dict
        Trial amounts that moved the data visibly, by effect and shape: where the next screen begins.
    floor : float
        Level, over that stated with the readings, below which their noise is not estimated.
    is_scarce : bool
        Whether readings are so few that their noise is white and its size estimated with the rest.
    has_repeats : bool
        Whether the blocks are repeats: runs are.
    scatters : mapping of str to float
        Of what every run has for itself, by the readings: none.
    formed : dict
        Families of forms by fit, which is kept with them so that its identity stays its own.
    """

    rig: Rig
    runs: tuple[MeasuredRun, ...]
    free: tuple[str, ...]
    priors: tuple[Prior, ...]
    sample: str = ""
    start: Mapping[str, float] = field(default_factory=dict)
    method: str = "response"
    candidates: Mapping[str, Candidate] = field(default_factory=lambda: dict(RESPONSE))
    workers: int = 2
    amounts: dict[tuple[str, ...], float] = field(default_factory=dict, repr=False, compare=False)
    floor: float = 0.0
    is_scarce: bool = False
    has_repeats: bool = True
    scatters: Mapping[str, float] = field(default_factory=dict)
    formed: dict[int, tuple[Fit, Sequence[Direction]]] = field(default_factory=dict, repr=False, compare=False)

    # ---- fits ---------------------------------------------------------------------------------------------------
    def layout(self, effects: Sequence[str], values: Mapping[str, float]) -> tuple[Rig, Layout]:
        """Rig with the shapes given and unknowns of the model with these effects."""
        wanted = [size for name in effects for size in self.candidates[name].parameters]
        rig = self.rig.with_values({size.name: values.get(size.name, self.null(size)) for size in wanted})
        free, priors = list(self.free), {prior.name: prior for prior in self.priors}
        bounds = {}
        for size in wanted:
            if size.own:
                priors[size.name] = Prior(size.name, 0.0, TURN, mean=0.0)
                continue
            prior = priors.get(size.name)
            if prior is not None and prior.common > 0:
                mean = self.rig.value(size.name) if prior.mean is None else prior.mean
                priors[size.name] = replace(prior, common=prior.common * WIDER, mean=mean)
            elif size.name not in free:
                free.append(size.name)
            low, high = self.limits.get(size.name, (size.low, size.high))
            rig = rig.with_values({size.name: float(np.clip(rig.value(size.name), low, high))})
            if math.isfinite(low) or math.isfinite(high):
                bounds[size.name] = (low, high)
        return rig, lay_out(rig, [run.name for run in self.runs], free, tuple(priors.values()), bounds)

    def null(self, size: Size) -> float:
        """Value of a parameter in the model without the effect: what the campaign's own model says, if it does."""
        return self.rig.value(size.name) if size.name in self.rig.effects else size.null

    def fit(self, effects: tuple[str, ...], starts: Sequence[Mapping[str, float]]) -> Fit | None:
        """Best of the optima from these starts."""
        best: Fit | None = None
        for values in starts or ({},):
            found = self._settled(effects, {**self.start, **rounded(values)})
            if found is not None and (best is None or found.mean_cost < best.mean_cost):
                best = found
        return best

    def is_far(self, effects: tuple[str, ...], values: Mapping[str, float]) -> bool:
        """Whether the motion has nothing to do with the readings there."""
        rig, layout = self.layout(effects, values)
        model = Model(rig, self.runs, layout)
        return settling.is_far(model, self._begun(model, {**self.start, **values}))

    def glance(self, effects: tuple[str, ...], values: Mapping[str, float]) -> tuple[float, float]:
        """Cost for each reading of the first moments after contact, fitted from the stated values."""
        rig, layout = self.layout(effects, values)
        model = Model(rig, self.runs, layout)
        return settling.glanced(model, self._led(effects, model, values))

    def _settled(self, effects: tuple[str, ...], values: Mapping[str, float]) -> Fit | None:
        rig, layout = self.layout(effects, values)
        model = Model(rig, self.runs, layout)
        theta = self._begun(model, values)
        known = not effects and values == self.start and all(entry.name in self.start for entry in layout.unknowns)
        if settling.is_far(model, theta):
            found = settling.led(model, self._led(effects, model, values), theta)
        else:
            found = settling.settled(model, theta, known=known)
        return self._fitted(effects, model, found)

    def _begun(self, model: Model, values: Mapping[str, float]) -> Array:
        """Values to begin from, within their bounds."""
        found = np.array([values.get(entry.name, entry.start) for entry in model.layout.unknowns])
        low, high = (np.array([getattr(entry, side) for entry in model.layout.unknowns]) for side in ("low", "high"))
        clipped: Array = np.clip(found, low, high)
        return clipped

    def _led(self, effects: tuple[str, ...], model: Model, values: Mapping[str, float]) -> Array:
        """Values to be led in from: the stated ones, with a little of each effect; nothing else is known there."""
        sizes = [size for name in effects for size in self.candidates[name].parameters]
        own = {size.name: values[size.name] for size in sizes if size.shape and size.name in values}
        for name in effects:
            size = self.candidates[name].size
            # A line is found in the spectrum, not in the motion: it is where it was found.
            spectral = self.candidates[name].cause.spectral
            amount = self.candidates[name].amount(self.scales)
            own[size.name] = values.get(size.name, 0.0) if spectral else self.null(size) + amount
        return self._begun(model, own)

    def _fitted(self, effects: tuple[str, ...], model: Model, found: settling.Settled) -> Fit | None:
        theta = found.theta
        seen = model.seen(theta, settling.WHOLE)
        if seen is None:
            return None
        posed, use = seen
        point = evaluate(posed, theta)
        here = slope(posed, point) if point is not None else None
        if point is None or here is None:
            return None
        # By the masks, not by residuals that are zero: a slack cell often reads exactly what the model says.
        used = tuple(
            np.concatenate([marks[name] for name in run.channels]) for run, marks in zip(self.runs, use, strict=True)
        )
        full = self._full(model, point)
        return Fit(
            effects, posed, point.theta, point.residuals, here.blocks, here.information, point.penalty, full, used,
            spent=found.spent, steps=found.steps, dear=self._dear(model, theta),
        )  # fmt: skip

    def _dear(self, model: Model, theta: Array) -> float:
        """What a motion with its derivatives costs there, over one of the base model: by its matrices or its steps."""
        moved = [motion(model.rig, run.run, values_of(model.layout, at, theta)) for at, run in enumerate(self.runs)]
        known = [one for one in moved if one is not None]
        steps = sum(one.steps for one in known) / max(len(known), 1)
        states = max((one.states for one in known), default=2)
        more = len(model.layout.unknowns) / max(len(self.start), 1)
        return max(1.0, 1.0 + steps / PLAIN, states**2 * more / (4 if steps else EXACT))

    def finished(self, fit: Fit) -> Fit:
        """Return a fit carried on to its last digit, with the weights that its readings have."""
        rig, layout = self.layout(fit.effects, fit.values)
        return fit.finished(lambda point: self._full(Model(rig, self.runs, layout), point))

    def _full(self, model: Model, point: Point) -> tuple[Array, ...]:
        """Residuals of all readings at a point, those without weight as well."""
        everything = [{name: run.used(name) for name in run.channels} for run in self.runs]
        whole = evaluate(problem(model.rig, self.runs, model.layout, everything, settling.WHOLE), point.theta)
        return point.residuals if whole is None else whole.residuals

    @property
    def slow(self) -> Sequence[Slow]:
        """A drift of the sensors is a cause of its own here."""
        return ()

    def equivalent(self, fit: Fit, name: str) -> tuple[str, Mapping[str, float]] | None:
        """Second mode behind the contact by its other name: a frame is a yaw with r²/J = ω²·C.

        None for any other effect, where the other's range does not hold it, and beside a mode of the stated model.
        """
        found = self.candidates[name].cause.equivalent
        if found is None or found[0] not in self.candidates or found[0] in fit.effects:
            return None
        other, values_of_other = found
        modes = {self.candidates[one].size.name for one in (name, other)}
        if self.rig.effects.keys() & modes or fit.index("yaw.inertia") is not None:
            return None
        own = values_of_other(fit.values, self.scales)
        ranges = {size.name: (size.low, size.high) for size in self.candidates[other].parameters} | self.limits
        if not all(ranges[one][0] <= value <= ranges[one][1] for one, value in own.items()):
            return None
        return other, {**fit.values, **own}

    def where(self, _fit: Fit, _name: str, _spread: Array) -> str:
        """In no run alone: what a run has for itself is a nuisance."""
        return ""

    def unit_of(self, family: str) -> str:
        """SI unit of an unlisted law."""
        kind, _, of = family.removeprefix("fine ").partition(" of ")
        return flexible.UNITS[of if kind in (flexible.CURVED, WANDER, "oscillation") else kind]

    def loses(self, fit: Fit) -> bool:
        """Whether a fit is so far from the readings that a straight line through it says nothing."""
        for at, run in enumerate(self.runs):
            for segment in fit.problem.blocks[at].segments:
                rows = slice(segment.first, segment.last)
                marks, noise = fit.used[at][rows], run.noise[segment.name]
                y = run.readings(segment.name)[marks]
                left = float(np.sum((fit.full[at][rows][marks] * noise) ** 2))
                motion_of = float(np.sum((y - y.mean()) ** 2)) if marks.any() else 0.0
                if left > max(FAR**2 * motion_of, LOST * marks.sum() * noise**2):
                    return True
        return False

    # ---- directions ---------------------------------------------------------------------------------------------
    def directions(self, fit: Fit, effects: Sequence[str]) -> Sequence[Direction]:
        """Every candidate in the shapes that the motion suggests, at a size that can just be seen."""
        rig, layout = self.layout(fit.effects, fit.values)
        base = self._model(rig, layout, fit)
        if base is None:
            return []
        found: list[Direction] = []
        untestable, scales = self.untestable(), self.scales
        trials: list[tuple[str, Mapping[str, float]]] = []
        for name in effects:
            if name in untestable or name in fit.effects:
                continue
            if self.candidates[name].cause.spectral:
                found += strongest(fit, self.runs, self.candidates[name], 3.0 * scales["omega"] / (2 * math.pi))
                continue
            known = self._stated(fit, name)
            if known is not None:
                found.append(known)
                continue
            trials += [(name, shape) for shape in self.candidates[name].shapes(scales, self.candidates)]
        with ThreadPoolExecutor(self.workers) as pool:
            tried = list(pool.map(lambda one: self._trial((rig, layout, fit, base), one[0], one[1], scales), trials))
        return [*found, *(one for one in tried if one is not None)]

    def _stated(self, fit: Fit, name: str) -> Direction | None:
        """Direction of an input that is sought within what the laboratory states of it."""
        size = self.candidates[name].size
        at = fit.index(size.name)
        if at is None or fit.problem.unknowns[at].u is None:
            return None
        amount, rows = float(fit.problem.unknowns[at].u or 0.0), []
        for block, part in zip(fit.problem.blocks, fit.slopes, strict=True):
            own = [column for column, unknown in enumerate(block.uses) if unknown == at]
            rows.append(amount * part[:, own].sum(axis=1))
        return Direction(name, {size.name: amount}, amount, tuple(rows), stated=at)

    def _model(self, rig: Rig, layout: Layout, fit: Fit) -> list[Array] | None:
        rows = []
        for at, measured in enumerate(self.runs):
            moved = motion(rig, measured.run, values_of(layout, at, fit.theta))
            if moved is None:
                return None
            rows.append(np.concatenate([getattr(moved, name) for name in measured.channels]))
        return rows

    def _trial(
        self,
        model: tuple[Rig, Layout, Fit, list[Array]],
        name: str,
        shape: Mapping[str, float],
        scales: Mapping[str, float],
    ) -> Direction | None:
        size = self.candidates[name].size
        key = (name, *map(str, shape.values()))
        amount = self.amounts.get(key) or self.candidates[name].amount(scales)
        for _ in range(3):
            rows = self._moved(model, {**shape, size.name: amount}, size)
            if rows is None:
                amount *= 0.1
                continue
            d = math.sqrt(sum(float(part @ part) for part in rows))
            if d == 0.0:
                amount *= 30.0
                continue
            there = size.amount(amount, min(max(4 * SURE / d, 1e-4), 1e4))
            if 0.3 * SURE <= d / 4 <= 10 * SURE:
                self.amounts[key] = amount
                break
            amount, rows = there, None
        if rows is None:
            rows = self._moved(model, {**shape, size.name: amount}, size)
        if rows is None:
            return None
        exact = self._derivative(model, size.name) if self.candidates[name].cause.exact else None
        if exact is not None:
            rows = tuple(amount * part for part in exact)
        return Direction(name, {**shape, size.name: amount}, amount, rows, exact=exact is not None)

    def _derivative(self, model: tuple[Rig, Layout, Fit, list[Array]], name: str) -> tuple[Array, ...] | None:
        """Derivative of the residuals by a size at its null; None where the motion has none."""
        rig, layout, fit, _ = model
        rows = []
        for at, measured in enumerate(self.runs):
            found = sensitivities(rig.with_values(values_of(layout, at, fit.theta)), measured.run, [name])
            if not found.valid:
                return None
            row = np.concatenate([getattr(found, channel)[:, 0] for channel in measured.channels])
            rows.append(-row * measured.weights * fit.used[at])
        return tuple(rows)

    def _moved(
        self, model: tuple[Rig, Layout, Fit, list[Array]], values: Mapping[str, float], size: Size
    ) -> tuple[Array, ...] | None:
        rig, layout, fit, base = model
        rows = []
        for at, measured in enumerate(self.runs):
            own = values_of(layout, at, fit.theta)
            null = own.get(size.name, self.null(size))
            trial = {**own, **values, size.name: null + values[size.name]}
            if not size.low <= trial[size.name] <= size.high:
                return None
            moved = motion(rig, measured.run, trial)
            if moved is None:
                return None
            row = np.concatenate([getattr(moved, channel) for channel in measured.channels])
            rows.append(-(row - base[at]) * measured.weights * fit.used[at])
        return tuple(rows)

    @cached_property
    def scales(self) -> dict[str, float]:
        """Sizes of the motion."""
        begun = {name: value for name, value in self.start.items() if name in ("k", "c")}
        return sizes_of(self.rig.with_values(begun), self.runs)

    @cached_property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Ranges of parameters that make sense for this motion."""
        found: dict[str, tuple[float, float]] = {}
        for one in self.candidates.values():
            found |= one.limits(self.scales)
        return found

    def untestable(self) -> Mapping[str, str]:
        """Candidates for which these runs have no channel, no line, no thrust or no friction to show."""
        channels = {name for run in self.runs for name in run.channels}
        measured = (
            ("x", said("no position was measured")), ("v", said("no velocity was measured")),
            ("T", said("no tension was measured")),
        )  # fmt: skip
        lacking: dict[str, str] = {name: words for name, words in measured if name not in channels}
        if not channels & {"x", "v"}:
            lacking["motion"] = said("no motion was measured")
        if not any(run.run.force is not None for run in self.runs):
            lacking["thrust"] = said("no thrust acts in these runs")
        if self.rig.attachment != "tether":
            lacking["tether"] = said("the line pushes as well as it pulls")
        if self.rig.attachment != "both ways":
            text = "the line does not push: a cubic term, or damping by amplitude, acts alike there"
            lacking["both ways"] = said(text)
        if not self.rig.length > 0:
            lacking["length"] = said("the free length of the line is not stated")
        return untested(self.candidates) | {
            name: lacking[need] for name, one in self.candidates.items() for need in one.cause.needs if need in lacking
        }

    def families(self, fit: Fit) -> Sequence[Direction]:
        """Smooth forces, curved readings and slow errors of any form; found once for each fit."""
        if id(fit) not in self.formed:
            rig, layout = self.layout(fit.effects, fit.values)
            values = [values_of(layout, at, fit.theta) for at in range(len(self.runs))]
            found = flexible.directions(rig, self.runs, values, fit)
            slow = wanders(self.runs, fit, QUANTITIES[self.rig.coordinate])
            self.formed[id(fit)] = (fit, [*found, *slow, *self._lines(fit)])
        return self.formed[id(fit)][1]

    def _forms(self, fit: Fit) -> Sequence[Direction]:
        """Smooth forces and curved readings alone."""
        every = [one for one in self.families(fit) if not (one.is_line or one.neighbours)]
        alone = (flexible.ALONE, flexible.THRUST)
        return [one for one in every if not (one.effect.startswith(WANDER) or one.effect.endswith(alone))]

    def _lines(self, fit: Fit) -> list[Direction]:
        """Strongest line of every channel beside those that a fit carries: a model has one frequency for all."""
        words, found = QUANTITIES[self.rig.coordinate], []
        for one in self.candidates.values():
            if one.cause.spectral and one.name not in self.untestable():
                for line in strongest(fit, self.runs, one, 3.0 * self.scales["omega"] / (2 * math.pi)):
                    places = {f"{way}@0": 0.0 for way in line.ways}
                    word = f"oscillation of {words[one.cause.spectral].word}"
                    found.append(replace(line, effect=word, values=places, is_line=True))
        return found

    # ---- what is reported ---------------------------------------------------------------------------------------
    def missing(self, fit: Fit) -> Missing | None:
        """Force or reading that the base model lacks: what takes up most, else the plain balance of forces."""
        found = free_force.missing(free_force.forms(fit, self._forms(fit)))
        if found is not None:
            return found
        rig, layout = self.layout(fit.effects, fit.values)
        return missing_force(rig, self.runs, [values_of(layout, at, fit.theta) for at in range(len(self.runs))])

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """Missing force, loop, spectra, delays and residuals."""
        ways = []
        for fit in filter(None, (before, after)):
            runs = followed(*self.layout(fit.effects, fit.values), self.runs, fit)
            ways.append((runs, free_force.forms(fit, self._forms(fit))))
        return of_response(ways)

    def parts(self, fit: Fit) -> Mapping[tuple[str, str], Sequence[tuple[str, Marks]]]:
        """Phases of each run by the events of its simulation."""
        rig, layout = self.layout(fit.effects, fit.values)
        found: dict[tuple[str, str], list[tuple[str, Marks]]] = {}
        for at, measured in enumerate(self.runs):
            values = values_of(layout, at, fit.theta)
            moved = motion(rig, measured.run, values)
            if moved is None:
                continue
            spans = phases(rig.with_values(values), measured.run, moved)
            for channel in measured.channels:
                t = measured.stamps(channel)
                found[measured.name, channel] = [(one.name, (t >= one.start) & (t <= one.stop)) for one in spans]
        return found

    def extended(self, fit: Fit) -> Mapping[str, float]:
        """Values of the effects, named as in the rig's table."""
        names = [one.name for name in fit.effects for one in self.candidates[name].parameters if not one.own]
        return {name: fit.values.get(name, self.rig.value(name)) for name in names}
