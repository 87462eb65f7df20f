"""Runs on the rig as a subject of diagnosis, with any of its effects."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from metrology.diagnosis import Missing, Picture
from metrology.diagnostics import flexible, free_force, settling
from metrology.diagnostics.candidate import RESPONSE, Candidate, untested
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.following import followed
from metrology.diagnostics.force import missing_force
from metrology.diagnostics.pictures import of_response
from metrology.diagnostics.run_families import families_of, smooth
from metrology.diagnostics.run_fits import begun, fitted, full_residuals, is_lost
from metrology.diagnostics.run_needs import lacking_in
from metrology.diagnostics.scale import scales as sizes_of
from metrology.diagnostics.settling import Model
from metrology.diagnostics.spectrum import strongest
from metrology.diagnostics.subject import Array, Fit, Marks, Slow, rounded
from metrology.diagnostics.trial_motions import null_of, stated, trial, tried
from metrology.diagnostics.wander import WANDER
from metrology.effect import Size
from metrology.estimation import Layout, MeasuredRun, Prior, lay_out
from metrology.estimation.priors import WIDER
from metrology.estimation.response import motion, values_of
from metrology.rig import Rig
from metrology.verify.phases import phases

TURN = math.pi
"""Standard deviation of a phase of which nothing is known."""


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
        return null_of(self.rig, size)

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
        return settling.is_far(model, begun(model, {**self.start, **values}))

    def glance(self, effects: tuple[str, ...], values: Mapping[str, float]) -> tuple[float, float]:
        """Cost for each reading of the first moments after contact, fitted from the stated values."""
        rig, layout = self.layout(effects, values)
        model = Model(rig, self.runs, layout)
        return settling.glanced(model, self._led(effects, model, values))

    def _settled(self, effects: tuple[str, ...], values: Mapping[str, float]) -> Fit | None:
        rig, layout = self.layout(effects, values)
        model = Model(rig, self.runs, layout)
        theta = begun(model, values)
        known = not effects and values == self.start and all(entry.name in self.start for entry in layout.unknowns)
        if settling.is_far(model, theta):
            found = settling.led(model, self._led(effects, model, values), theta)
        else:
            found = settling.settled(model, theta, known=known)
        return fitted(effects, model, found, len(self.start))

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
        return begun(model, own)

    def finished(self, fit: Fit) -> Fit:
        """Return a fit carried on to its last digit, with the weights that its readings have."""
        rig, layout = self.layout(fit.effects, fit.values)
        return fit.finished(lambda point: full_residuals(Model(rig, self.runs, layout), point))

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
        return is_lost(self.runs, fit)

    # ---- directions ---------------------------------------------------------------------------------------------
    def directions(self, fit: Fit, effects: Sequence[str]) -> Sequence[Direction]:
        """Every candidate in the shapes that the motion suggests, at a size that can just be seen."""
        rig, layout = self.layout(fit.effects, fit.values)
        base = tried(self.rig, self.runs, (rig, layout), fit)
        if base is None:
            return []
        found: list[Direction] = []
        untestable, scales = self.untestable(), self.scales
        trials: list[tuple[str, Mapping[str, float]]] = []
        for name in effects:
            if name in untestable or name in fit.effects:
                continue
            if self.candidates[name].cause.spectral:
                found += strongest(fit, self.runs, self.candidates[name], self.lowest)
                continue
            known = stated(fit, self.candidates[name])
            if known is not None:
                found.append(known)
                continue
            trials += [(name, shape) for shape in self.candidates[name].shapes(scales, self.candidates)]
        with ThreadPoolExecutor(self.workers) as pool:
            moved = list(
                pool.map(lambda one: trial(base, self.candidates[one[0]], one[1], scales, self.amounts), trials)
            )
        return [*found, *(one for one in moved if one is not None)]

    @cached_property
    def scales(self) -> dict[str, float]:
        """Sizes of the motion."""
        begun = {name: value for name, value in self.start.items() if name in ("k", "c")}
        return sizes_of(self.rig.with_values(begun), self.runs)

    @property
    def lowest(self) -> float:
        """Lowest frequency / Hz at which a line is sought."""
        return 3.0 * self.scales["omega"] / (2 * math.pi)

    @cached_property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Ranges of parameters that make sense for this motion."""
        found: dict[str, tuple[float, float]] = {}
        for one in self.candidates.values():
            found |= one.limits(self.scales)
        return found

    def untestable(self) -> Mapping[str, str]:
        """Candidates for which these runs have no channel, no line, no thrust or no friction to show."""
        lacking = lacking_in(self.rig, self.runs)
        return untested(self.candidates) | {
            name: lacking[need] for name, one in self.candidates.items() for need in one.cause.needs if need in lacking
        }

    def families(self, fit: Fit) -> Sequence[Direction]:
        """Smooth forces, curved readings and slow errors of any form; found once for each fit."""
        if id(fit) not in self.formed:
            rig, layout = self.layout(fit.effects, fit.values)
            spectral = [
                one for name, one in self.candidates.items() if one.cause.spectral and name not in self.untestable()
            ]
            self.formed[id(fit)] = (fit, families_of(Model(rig, self.runs, layout), fit, spectral, self.lowest))
        return self.formed[id(fit)][1]

    # ---- what is reported ---------------------------------------------------------------------------------------
    def missing(self, fit: Fit) -> Missing | None:
        """Force or reading that the base model lacks: what takes up most, else the plain balance of forces."""
        found = free_force.missing(free_force.forms(fit, smooth(self.families(fit))))
        if found is not None:
            return found
        rig, layout = self.layout(fit.effects, fit.values)
        return missing_force(rig, self.runs, [values_of(layout, at, fit.theta) for at in range(len(self.runs))])

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """Missing force, loop, spectra, delays and residuals."""
        ways = []
        for fit in filter(None, (before, after)):
            runs = followed(*self.layout(fit.effects, fit.values), self.runs, fit)
            ways.append((runs, free_force.forms(fit, smooth(self.families(fit)))))
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
