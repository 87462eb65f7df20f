"""Response tests as a subject of diagnosis: runs on the rig, with any of its effects."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from metrology.diagnose.candidate import Candidate, Size
from metrology.diagnose.engine import FALSE_ALARM, rank
from metrology.diagnose.finding import Diagnosis, Missing
from metrology.diagnose.force import missing_force
from metrology.diagnose.response_table import TABLE
from metrology.diagnose.subject import Array, Direction, Fit, Marks
from metrology.errors import Fault, MetrologyError
from metrology.identify import Layout, MeasuredRun, Prior, Problem, Solution, inspection, lay_out, solve
from metrology.identify.problem import evaluate, slope
from metrology.identify.response import View, masks, motion, problem, values_of
from metrology.rig import Rig, engines
from metrology.verify.phases import phases

WIDER = 15.0
"""How many of its own standard uncertainties a stated input may be off where that is tried as a cause."""
SURE = 8.0
"""Distance in standard deviations by which a trial should move the data."""
SETTLE = ((View(temper=4.0, beside=0.02), 0.3, 12), (View(beside=0.005), 0.05, 15), (View(), 1e-3, 15))
"""View, how closely it is followed, and derivatives taken at most, one after the other."""


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
    patience : float
        Time after which one descent is given up, s, for few readings; more for many.
    """

    rig: Rig
    runs: tuple[MeasuredRun, ...]
    free: tuple[str, ...]
    priors: tuple[Prior, ...]
    sample: str = ""
    start: Mapping[str, float] = field(default_factory=dict)
    method: str = "response"
    patience: float = 2.5
    candidates: Mapping[str, Candidate] = field(default_factory=lambda: dict(TABLE))

    # ---- fits ---------------------------------------------------------------------------------------------------
    def layout(self, effects: Sequence[str], values: Mapping[str, float]) -> tuple[Rig, Layout]:
        """Rig with the shapes given and unknowns of the model with these effects."""
        wanted = [size for name in effects for size in self.candidates[name].parameters]
        rig = self.rig.with_values({size.name: values.get(size.name, self.null(size)) for size in wanted})
        free, priors = list(self.free), {prior.name: prior for prior in self.priors}
        bounds = {}
        for size in wanted:
            prior = priors.get(size.name)
            if prior is not None and prior.common > 0:
                priors[size.name] = replace(prior, common=prior.common * WIDER)
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
            found = self._settled(effects, {**self.start, **values})
            if found is not None and (best is None or found.cost / found.count < best.cost / best.count):
                best = found
        return best

    def _settled(self, effects: tuple[str, ...], values: Mapping[str, float]) -> Fit | None:
        rig, layout = self.layout(effects, values)
        theta = np.array([values.get(entry.name, entry.start) for entry in layout.unknowns])
        low = np.array([entry.low for entry in layout.unknowns])
        high = np.array([entry.high for entry in layout.unknowns])
        theta, solution, posed = np.clip(theta, low, high), None, None
        readings = sum(len(run.stamps(name)) for run in self.runs for name in run.channels)
        stop = time.monotonic() + self.patience * (1 + readings / 40_000)
        for view, close, steps in SETTLE:
            use = masks(rig, self.runs, layout, theta, view)
            if use is None:
                return None
            posed = _until(stop, problem(rig, self.runs, layout, use, view))
            solution = solve(posed, theta, close=close, steps=steps)
            if solution.point is None:
                return None
            theta = solution.point.theta
        if posed is None or solution is None:
            return None
        return self._fitted(effects, (rig, layout), posed, solution)

    def _fitted(
        self, effects: tuple[str, ...], model: tuple[Rig, Layout], posed: Problem, solution: Solution
    ) -> Fit | None:
        rig, layout = model
        assert solution.point is not None
        posed = _until(math.inf, posed)
        point = evaluate(posed, solution.point.theta)
        here = slope(posed, point) if point is not None else None
        if point is None or here is None:
            return None
        everything = [{name: run.used(name) for name in run.channels} for run in self.runs]
        whole = evaluate(problem(rig, self.runs, layout, everything, View()), point.theta)
        used = tuple(part != 0.0 for part in point.residuals)
        full = point.residuals if whole is None else whole.residuals
        return Fit(
            effects, posed, point.theta, point.residuals, here.blocks, here.information, point.penalty, full, used
        )

    # ---- directions ---------------------------------------------------------------------------------------------
    def directions(self, fit: Fit, effects: Sequence[str]) -> Sequence[Direction]:
        """Every candidate in the shapes that the motion suggests, at a size that can just be seen."""
        rig, layout = self.layout(fit.effects, fit.values)
        base = self._model(rig, layout, fit)
        if base is None:
            return []
        found: list[Direction] = []
        untestable = self.untestable()
        scales = self.scales
        for name in effects:
            if name in untestable or name in fit.effects:
                continue
            if name.startswith("hum"):
                found += self._hum(fit, name)
                continue
            for shape in self._shapes(name, scales):
                trial = self._trial((rig, layout, fit, base), name, shape, scales)
                found += [trial] if trial is not None else []
        return found

    def _model(self, rig: Rig, layout: Layout, fit: Fit) -> list[Array] | None:
        rows = []
        for at, measured in enumerate(self.runs):
            moved = motion(rig, measured.run, values_of(layout, at, fit.theta))
            if moved is None:
                return None
            rows.append(np.concatenate([getattr(moved, name) for name in measured.channels]))
        return rows

    def _trial(
        self, model: tuple[Rig, Layout, Fit, list[Array]], name: str, shape: Mapping[str, float], scales: Mapping[str, float]
    ) -> Direction | None:
        rig, layout, fit, base = model
        size = self.candidates[name].size
        amount = _guess(size.name, scales)
        for _ in range(3):
            rows = self._moved(model, {**shape, size.name: amount}, size)
            if rows is None:
                amount *= 0.1
                continue
            d = math.sqrt(sum(float(part @ part) for part in rows))
            if d == 0.0:
                amount *= 30.0
                continue
            if 0.3 * SURE <= d / 4 <= 10 * SURE:
                break
            amount = amount * min(max(4 * SURE / d, 1e-4), 1e4)
            rows = None
        if rows is None:
            rows = self._moved(model, {**shape, size.name: amount}, size)
        return None if rows is None else Direction(name, {**shape, size.name: amount}, amount, rows)

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
            rows.append(-(row - base[at]) * self._weights(measured) * fit.used[at])
        return tuple(rows)

    def _weights(self, measured: MeasuredRun) -> Array:
        return np.concatenate(
            [np.full(len(measured.stamps(name)), 1.0 / measured.noise[name]) for name in measured.channels]
        )

    def _hum(self, fit: Fit, name: str) -> list[Direction]:
        """Strongest line of the residual spectrum of a channel, above three natural frequencies."""
        channel = name.split()[1]
        natural = 3.0 * self.scales["omega"] / (2 * math.pi)
        spectrum, looks, grid = 0.0, 0.0, None
        longest = max(run.run.end - run.run.t0 for run in self.runs)
        for at, run in enumerate(self.runs):
            if channel not in run.channels:
                continue
            segment = next(one for one in fit.problem.blocks[at].segments if one.name == channel)
            t, r = run.stamps(channel), fit.residuals[at][segment.first : segment.last]
            step = float(np.median(np.diff(t)))
            count = round(longest / step) * 2
            grid = np.fft.rfftfreq(count, step)
            even = np.zeros(count)
            places = np.round((t - run.run.t0) / step).astype(int)
            fine = (places >= 0) & (places < count)
            even[places[fine]] = r[fine]
            power = np.abs(np.fft.rfft(even)) ** 2 / max(int((r != 0).sum()), 1)
            if isinstance(spectrum, float) or len(power) == len(spectrum):
                spectrum = spectrum + power
                looks = len(power) / 2
        if grid is None or isinstance(spectrum, float):
            return []
        inside = np.flatnonzero((grid > max(natural, 3.0 / longest)) & (grid < 0.95 * grid[-1]))
        if not inside.size:
            return []
        frequency = float(grid[inside[np.argmax(spectrum[inside])]])
        return [self._line(fit, channel, frequency, looks)]

    def _line(self, fit: Fit, channel: str, frequency: float, looks: float) -> Direction:
        rows, amount = [], 0.0
        for at, run in enumerate(self.runs):
            part = np.zeros((len(fit.residuals[at]), 2))
            segment = next((one for one in fit.problem.blocks[at].segments if one.name == channel), None)
            if segment is not None:
                amount = 0.1 * run.noise[channel]
                turn = 2 * math.pi * frequency * run.stamps(channel)
                own = fit.used[at][segment.first : segment.last, None]
                part[segment.first : segment.last] = -0.1 * np.column_stack([np.sin(turn), np.cos(turn)]) * own
            rows.append(part)
        values = {f"hum.{channel}": amount, "hum.frequency": frequency, "hum.phase": 0.0}
        return Direction(f"hum {channel}", values, amount, tuple(rows), looks)

    # ---- what the motion suggests -------------------------------------------------------------------------------
    @cached_property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Ranges that make sense for this motion: beyond them an effect is another one, or none."""
        known = self.scales
        e, omega, k = known["e"], known["omega"], known["k"]
        highest = self._highest()
        return {
            "hysteresis.yield": (0.01 * e, 3 * e), "hysteresis.stiffness": (0.0, 3 * k), "zener.stiffness": (0.0, 5 * k),
            "zener.time": (0.02 / omega, 100 / omega), "frame.compliance": (0.0, 3 / k),
            "frame.frequency": (1.1 * omega, max(highest, 1.2 * omega)), "frame.damping": (0.0, 0.5),
            "toe.extent": (0.01 * e, 1.5 * e), "yaw.frequency": (0.1 * omega, 10 * omega),
            "yaw.inertia": (0.002 * known["m"], 2 * known["m"]), "yaw.arm": (0.0, 0.5),
            "hum.frequency": (0.1, highest), "drag.quadratic": (0.0, 10 * known["force"] / known["v"] ** 2),
            "drag.viscous": (0.0, 10 * known["force"] / known["v"]),
        }  # fmt: skip

    def _highest(self) -> float:
        return 0.8 * math.pi * max(1 / float(np.median(np.diff(run.stamps(c)))) for run in self.runs for c in run.channels)

    @cached_property
    def scales(self) -> dict[str, float]:
        """Sizes of the motion: thrust, largest elongation, speed, natural frequency."""
        rig = self.rig.with_values({name: value for name, value in self.start.items() if name in ("k", "c")})
        pushes = [np.abs(run.run.force.values).max() for run in self.runs if run.run.force is not None]
        omega = math.sqrt(max(rig.k, 1e-12) / rig.m)
        length, speed = [], []
        for run in self.runs:
            moved = motion(rig, run.run, {})
            if moved is not None and moved.x is not None:
                length.append(float(np.max(moved.x - rig.taut)) if rig.attachment == "tether" else float(np.ptp(moved.x)) / 2)
            if moved is not None and moved.v is not None:
                speed.append(float(np.abs(moved.v).max()))
        e = max(max(length, default=1e-3), 1e-6)
        v = max(max(speed, default=e * omega), 1e-9)
        force = max(pushes, default=0.0) or rig.k * e
        return {"force": float(force), "e": e, "v": v, "omega": omega, "k": rig.k, "c": rig.c, "m": rig.m}

    def _shapes(self, name: str, scales: Mapping[str, float]) -> list[dict[str, float]]:
        omega, e = scales["omega"], scales["e"]
        if name == "frame":
            highest = self._highest()
            ratios = [ratio for ratio in (1.5, 3.0, 6.0, 12.0, 25.0) if ratio * omega < highest]
            return [{"frame.frequency": ratio * omega, "frame.damping": 0.03} for ratio in ratios]
        if name == "toe":
            return [{"toe.extent": part * e} for part in (0.1, 0.3, 0.6)]
        if name == "zener":
            return [{"zener.time": factor / omega} for factor in (0.15, 0.5, 1.5, 5.0, 20.0)]
        if name == "hysteresis":
            return [{"hysteresis.yield": part * e} for part in (0.05, 0.2, 0.5)]
        if name == "yaw":
            return [{"yaw.frequency": ratio * omega, "yaw.inertia": 0.05 * scales["m"]} for ratio in (0.4, 1.5, 4.0)]
        return [{}]

    def untestable(self) -> Mapping[str, str]:
        """Candidates for which these runs have no channel, no line, no thrust or no friction to show."""
        found: dict[str, str] = {}
        channels = {name for run in self.runs for name in run.channels}
        for letter, words in (("x", "position"), ("v", "velocity"), ("T", "tension")):
            if letter not in channels:
                found |= {f"hum {letter}": f"no {words} was measured", f"clock {letter}": f"no {words} was measured"}
        if "T" not in channels:
            found |= dict.fromkeys(("cell gain", "cell zero", "cell drift"), "no tension was measured")
        if not channels & {"x", "v"}:
            found["motion scale"] = "no motion was measured"
        if not any(run.run.force is not None for run in self.runs):
            found |= dict.fromkeys(("thrust gain", "thrust lag", "thrust delay"), "no thrust acts in these runs")
        if self.rig.attachment != "tether":
            found |= dict.fromkeys(("sag", "slip", "toe"), "the line pushes as well as it pulls")
        if not self.rig.length > 0:
            found["sag"] = "the free length of the line is not stated"
        return found

    # ---- what is reported ---------------------------------------------------------------------------------------
    def missing(self, fit: Fit) -> Missing | None:
        """Force that the base model lacks, from the balance of forces."""
        rig, layout = self.layout(fit.effects, fit.values)
        return missing_force(rig, self.runs, [values_of(layout, at, fit.theta) for at in range(len(self.runs))])

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
        names = [size.name for name in fit.effects for size in self.candidates[name].parameters]
        return {name: fit.values.get(name, self.rig.value(name)) for name in names}


def _until(stop: float, posed: Problem) -> Problem:
    """Return the problem with blocks that have no answer any more after a time: some values take for ever."""

    def timed(function: Callable[[Array], Array | None]) -> Callable[[Array], Array | None]:
        plain = getattr(function, "plain", function)

        def answer(local: Array) -> Array | None:
            return None if time.monotonic() > stop else plain(local)

        answer.plain = plain  # type: ignore[attr-defined]
        return answer

    blocks = [
        replace(block, residuals=timed(block.residuals), derivatives=timed(block.derivatives)) for block in posed.blocks
    ]
    return replace(posed, blocks=tuple(blocks))


def _guess(size: str, scales: Mapping[str, float]) -> float:
    """First trial size of an effect, small against the motion."""
    force, e, v, omega, k = (scales[name] for name in ("force", "e", "v", "omega", "k"))
    guesses = {
        "friction.force": 0.005 * force, "drag.viscous": 0.005 * force / v, "drag.quadratic": 0.005 * force / v**2,
        "tilt.angle": 0.003 * force / (9.8 * scales["m"]), "setup.compliance": 0.01 / max(k, 1.0),
        "frame.compliance": 0.02 / max(k, 1.0), "cubic.stiffness": 0.02 * k / e**2, "toe.ratio": -0.05,
        "zener.stiffness": 0.02 * k, "damping.amplitude": 0.1 * max(scales["c"], 0.01 * k / omega) / e,
        "hysteresis.stiffness": 0.01 * k, "sag.weight": 1e-4, "slip.set": 0.005 * e, "yaw.arm": 0.02,
        "thrust.lag": 2e-3, "thrust.gain": 3e-3, "thrust.delay": 2e-3, "mass.factor": 3e-3, "free_length.shift": 3e-4,
        "cell.gain": 3e-3, "cell.zero": 1e-3 * force, "cell.drift": 1e-5 * force, "motion.scale": 3e-3,
        "clock.x": 5e-4, "clock.v": 5e-4, "clock.T": 5e-4,
    }  # fmt: skip
    return guesses[size]


def response(
    rig: Rig, runs: Sequence[MeasuredRun], *, rng: np.random.Generator, free: Sequence[str] = ("k", "c"),
    priors: Sequence[Prior] = (), settings: Settings | None = None,
) -> Diagnosis:  # fmt: skip
    """Diagnose response tests: what the model of the rig lacks, why, and what an extension gains.

    Parameters
    ----------
    rig : Rig
        As the laboratory states it; effects that it carries already belong to the base model.
    runs : sequence of MeasuredRun
        All of the test, whatever their purpose: each is left out once.
    rng : Generator
        For simulated limits and bootstrap intervals.
    free : sequence of str
        Parameters of which nothing is known.
    priors : sequence of Prior
        What is known within an uncertainty, with a common part and a part per run.
    settings : Settings, optional
        Names, start values, false-alarm rate.

    Raises
    ------
    MetrologyError
        Fewer than two runs, runs that cannot be what they claim, or names that the rig does not have.
    """
    settings = settings or Settings()
    faults = inspection.faults(rig, runs)
    if len(runs) < 2:
        faults.append(Fault("diagnose.runs", f"{len(runs)} run(s)", "at least two, so that one can be left out"))
    if faults:
        raise MetrologyError(*faults)
    engines.compiled()
    cleaned = tuple(inspection.without_saturation(run)[0] for run in runs)
    subject = Response(rig, cleaned, tuple(free), tuple(priors), settings.sample, dict(settings.start))
    subject, notes = _without_outliers(subject)
    candidates = {name: one for name, one in subject.candidates.items() if name not in settings.without}
    found = rank(
        replace(subject, candidates=candidates), rng=rng, test=settings.test, false_alarm=settings.false_alarm,
        workers=settings.workers, progress=settings.progress,
    )  # fmt: skip
    return replace(found, notes=(*found.notes, *notes))


@dataclass(frozen=True)
class Settings:
    """How a diagnosis is done.

    Parameters
    ----------
    sample, test : str
        Ids, for the result.
    start : mapping of str to float
        Where the base fit begins, by name of unknown: `common_values` of an `Identification` spares a search.
    without : tuple of str
        Candidates that are not to be tried.
    false_alarm : float
        Rate at which each of the two tests may fail where nothing is missing.
    workers : int
        Fits at a time.
    progress : callable, optional
        Takes one line of text now and then.
    """

    sample: str = ""
    test: str = ""
    start: Mapping[str, float] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    false_alarm: float = FALSE_ALARM
    workers: int = 2
    progress: Callable[[str], None] | None = None


OUTLYING = 7.0
"""Distance in standard uncertainties from which a single reading among good neighbours is an outlier."""


def _without_outliers(subject: Response) -> tuple[Response, list[str]]:
    """Leave out single readings far off among good neighbours, and say so."""
    fit = subject.fit((), [{}])
    if fit is None:
        return subject, []
    runs, notes = [], []
    for at, run in enumerate(subject.runs):
        marks = {}
        for segment in fit.problem.blocks[at].segments:
            residual = np.abs(fit.residuals[at][segment.first : segment.last])
            beside = np.maximum(np.roll(residual, 1), np.roll(residual, -1))
            far = (residual > OUTLYING) & (beside < 0.5 * residual)
            if far.any():
                marks[segment.name] = run.used(segment.name) & ~far
                notes.append(
                    f"{run.name}, {segment.name}: {int(far.sum())} outlier(s), single readings more than {OUTLYING:g} "
                    "standard uncertainties off among good neighbours, are left out (drop-outs, reflections, interference)"
                )
        runs.append(replace(run, use={**run.use, **marks}) if marks else run)
    begun = {**subject.start, **fit.values}
    return replace(subject, runs=tuple(runs), start=begun), notes
