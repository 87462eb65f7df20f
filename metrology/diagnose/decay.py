"""Free decays as a subject of diagnosis: a mass on a line let go, and what may overlie or shape its decay."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from metrology.decay import DecayTest
from metrology.decay.oscillation import DEGREE
from metrology.decay.separation import Separated, Unusable, is_mains, separate
from metrology.diagnose.candidate import Candidate, Size
from metrology.diagnose.engine import FALSE_ALARM, rank
from metrology.diagnose.finding import Diagnosis, Missing, Picture, Value
from metrology.diagnose.plain import Plain, Readings, Trial, binned
from metrology.diagnose.plain_pictures import of_decay
from metrology.diagnose.response_table import TABLE as RESPONSE
from metrology.diagnose.subject import Array, Fit
from metrology.errors import Fault, MetrologyError
from metrology.identify import Unknown
from metrology.identify.response import motion
from metrology.rig import Rig, Run
from metrology.timeseries import average

PER_PERIOD = 40
"""Samples kept per period: means over whole blocks."""
INF = math.inf


def _overlay(name: str, title: str, words: tuple[str, str, str, str], *, decays: bool) -> Candidate:
    rate = (Size(f"{name}.rate", "1/s", 0.0, -1.0, 1e3, 0.1, True),) if decays else ()
    return Candidate(
        name, title,
        "y = … + e^{−λt}·(a·sin 2πft + b·cos 2πft)" if decays else "y = … + a·sin 2πft + b·cos 2πft",
        (
            Size(f"{name}.sin", "m", 0.0, -INF, INF, 1e-6, own=True),
            Size(f"{name}.cos", "m", 0.0, -INF, INF, 1e-6, own=True),
            Size(f"{name}.frequency", "Hz", 1.0, 1e-3, 1e5, 0.01, True), *rate,
        ),
        *words,
    )  # fmt: skip


TABLE: dict[str, Candidate] = {
    "friction": RESPONSE["friction"],
    "quadratic drag": RESPONSE["quadratic drag"],
    "cubic": RESPONSE["cubic"],
    "damping": RESPONSE["damping"],
    "setup": RESPONSE["setup"],
    "other": _overlay(
        "other", "Transverse or pendulum motion",
        ("a beat, or a second line in the spectrum", "ζ from peaks is biased where the beat is slow",
        "release straight, on the axis",
         "a second vibrometer across the axis"),
        decays=True,
    ),
    "mains": _overlay(
        "mains", "Mains in the record",
        ("a line at a multiple of the mains frequency that does not decay", "biases small peaks",
        "part supply and earth of the vibrometer",
         "a record at rest"),
        decays=False,
    ),
}  # fmt: skip
"""Every candidate of a free-decay test."""

CARRIED = ("friction.force", "drag.quadratic", "cubic.stiffness", "damping.amplitude")


class Decay:
    """Records of a free-decay test, cut from the release on and averaged to some forty samples a period."""

    def __init__(self, test: DecayTest) -> None:
        self.test, self.failures = test, []
        self.found: list[tuple[str, float, float, bool]] = []
        self.blocks: list[Readings] = []
        self.starts: list[tuple[float, float, float]] = []
        self.runs: list[Run] = []
        omegas, rates = [], []
        for record in test.records:
            try:
                parted = separate(record, mains=test.mains, expected=test.expected)
            except Unusable as reason:
                self.failures.append(f"{record.name}: {reason}")
                continue
            main, free = parted.fit.main, parted.free
            count = max(1, int(2 * math.pi / main.omega * free.rate / PER_PERIOD))
            free = replace(free, value=free.value - _others(parted))
            self.found += [(record.name, mode.frequency, float(size), is_mains(mode, test.mains))
                           for mode, size in zip(parted.fit.modes[1:], parted.fit.amplitudes[1:],
                           strict=True)]  # fmt: skip
            thin = average(free, count) if count > 1 else free
            t = thin.time - thin.time[0]
            level = parted.noise / math.sqrt(count)
            noise = max(level, float(np.std(np.diff(thin.value, 3)[-len(t) // 4 :])) / math.sqrt(20) * 0.5)
            self.blocks.append(Readings(record.name, "x", thin.value, np.full(len(t), noise), _phases(t)))
            a, b = parted.fit.coefficients[0]
            turned = complex(a, -b) * np.exp(complex(-main.rate, main.omega) * (thin.time[0] - free.time[0]))
            speed = (turned * complex(-main.rate, main.omega)).real
            self.starts.append((float(turned.real), float(speed), float(np.mean(thin.value[len(t) // 2 :]))))
            self.runs.append(Run(0.0, t_x=t))
            omegas.append(main.omega)
            rates.append(main.rate)
        if not self.blocks:
            raise MetrologyError(Fault(f"{test.name}.records", "no record with a decay", "one at least"))
        mass = test.mass.value
        self.omega, rate = float(np.mean(omegas)), float(np.mean(rates))
        self.rig = Rig(mass, mass * (self.omega**2 + rate**2), 2 * mass * max(rate, 0.0), attachment="both ways")
        self.length = sum(run.end for run in self.runs)
        self.size = float(np.mean([math.hypot(x, v / self.omega) for x, v, _ in self.starts]))

    def predict(self, at: int, values: Mapping[str, float]) -> Array | None:
        """Displacement of one record."""
        own = {"k": values["k"], "c": values["c"], "start.x": values["x0"], "start.v": values["v0"]}
        own |= {name: values[name] for name in CARRIED if name in values}
        moved = motion(self.rig, self.runs[at], own)
        if moved is None or moved.x is None:
            return None
        t = self.runs[at].t_x
        assert t is not None
        level = [values[f"level{order}"] for order in range(DEGREE + 1)]
        y = moved.x + np.polynomial.legendre.legval(2 * t / t[-1] - 1, level)
        for name in ("other", "mains"):
            if f"{name}.frequency" in values:
                turn = 2 * math.pi * values[f"{name}.frequency"] * t
                fall = np.exp(np.clip(-values.get(f"{name}.rate", 0.0) * t, -50, 5))
                y = y + fall * (
                    values.get(f"{name}.sin", 0.0) * np.sin(turn) + values.get(f"{name}.cos", 0.0) * np.cos(turn)
                )
        return np.asarray(y, dtype=float)

    def trials(self, name: str, fit: Fit) -> Sequence[Trial]:
        """Shapes of a candidate; other oscillations where the residual spectrum shows them."""
        k, m, A, w = self.rig.k, self.rig.m, self.size, self.omega
        c = max(self.rig.c, 1e-3 * m * w)
        amounts = {
            "friction": 1e-4 * k * A, "quadratic drag": 0.01 * c / (w * A), "cubic": 1e-3 * k / A**2,
            "damping": 0.02 * c / A,
        }  # fmt: skip
        if name in amounts:
            return [Trial(amounts[name])]
        if name == "setup":
            return []
        return [
            Trial(1e-3 * A, {f"{name}.frequency": frequency, f"{name}.rate": 0.3 * len(self.runs) / self.length}, looks)
            if name == "other" else Trial(1e-3 * A, {f"{name}.frequency": frequency}, looks)
            for frequency, looks in self._lines(fit, name)
        ]  # fmt: skip

    def _lines(self, fit: Fit, name: str) -> list[tuple[float, float]]:
        """Strongest line of the residuals, at the mains or elsewhere."""
        t = self.runs[0].t_x
        assert t is not None
        size = 4 * len(t)
        power = np.abs(np.fft.rfft(fit.residuals[0] * np.hanning(len(t)), size)) ** 2
        grid = np.fft.rfftfreq(size, float(t[1] - t[0]))
        mains = self.test.mains
        beside = np.abs(grid / mains - np.maximum(np.round(grid / mains), 1)) * mains < max(0.5, 1.5 / t[-1])
        own = np.abs(grid - self.omega / (2 * math.pi)) < 3 / t[-1]
        allowed = beside if name == "mains" else ~beside & ~own
        allowed &= (grid > 2 / t[-1]) & (grid < 0.9 * grid[-1])
        if not allowed.any():
            return []
        at = np.flatnonzero(allowed)[np.argmax(power[allowed])]
        return [(float(grid[at]), 4.0 if name == "mains" else len(t) / 2)]

    def subject(self, sample: str = "") -> Plain:
        """As the engine takes it."""
        k, c = self.rig.k, self.rig.c
        common = (
            Unknown("k", k, k * 1e-3, 1e-9, INF, unit="N/m"),
            Unknown("c", c, max(c * 0.05, 1e-9), 0.0, INF, unit="N·s/m"),
        )
        own = tuple(
            (
                Unknown(f"x0@{block.name}", x, self.size * 0.01, unit="m"),
                Unknown(f"v0@{block.name}", v, self.size * self.omega * 0.01, unit="m/s"),
                *(
                    Unknown(f"level{order}@{block.name}", level if order == 0 else 0.0, self.size * 0.01, unit="m")
                    for order in range(DEGREE + 1)
                ),
            )
            for block, (x, v, level) in zip(self.blocks, self.starts, strict=True)
        )
        reasons = {"setup": f"alone it is exactly a lower k. Needed: {TABLE['setup'].separate}"}
        return Plain(
            sample, "decay", TABLE, tuple(self.blocks), common, own, self.predict, self.trials, reasons, self.gap,
            self.pictures,
        )  # fmt: skip

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """Decay rate and frequency against amplitude, spectrum and residuals."""
        times = [run.t_x for run in self.runs if run.t_x is not None]
        records = [(t, block.y, block.u) for t, block in zip(times, self.blocks, strict=True)]
        return of_decay(records, self.omega, before, after)

    def gap(self, fit: Fit) -> Missing | None:
        """Residual displacement against time and displacement."""
        t = np.concatenate([run.t_x for run in self.runs if run.t_x is not None])
        u = np.concatenate([block.u for block in self.blocks])
        y = np.concatenate([block.y for block in self.blocks])
        residual = np.concatenate(fit.residuals) * u
        return binned("missing displacement", "m", {("time", "s"): t, ("displacement", "m"): y}, residual, u)


def _others(parted: Separated) -> Array:
    """Further oscillations that the record was found to hold."""
    found = np.zeros(len(parted.t))
    for index in range(1, len(parted.fit.modes)):
        found = found + parted.fit.part(parted.t, index)
    return found


def _phases(t: Array) -> list[tuple[str, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]]:
    middle = 0.4 * float(t[-1])
    return [("early decay", t < middle), ("late decay", t >= middle)]


def decay(
    test: DecayTest, *, rng: np.random.Generator, sample: str = "", false_alarm: float = FALSE_ALARM
) -> Diagnosis:
    """Diagnose a free-decay test: what beside viscous damping and a linear spring shapes the decay, or overlies it.

    Parameters
    ----------
    test : DecayTest
        As for `decay.analyse`.
    rng : Generator
        For simulated limits and bootstrap intervals.
    sample : str
        Id of the sample, for the result.
    false_alarm : float
        Rate at which each of the two tests may fail where nothing is missing.

    Raises
    ------
    MetrologyError
        Where no record holds a decay.
    """
    prepared = Decay(test)
    found = rank(prepared.subject(sample), rng=rng, test=test.name, false_alarm=false_alarm)
    return replace(
        _with_overlays(found, prepared.found, len(prepared.blocks)), failures=(*prepared.failures, *found.failures)
    )


def _with_overlays(found: Diagnosis, overlays: Sequence[tuple[str, float, float, bool]], records: int) -> Diagnosis:
    """Name the oscillations that were found in at least half of the records and taken out before."""
    causes, named = list(found.causes), []
    for key, hum in (("mains", True), ("other", False)):
        own = [one for one in overlays if one[3] == hum]
        if 2 * len({one[0] for one in own}) < records:
            continue
        largest = max(own, key=lambda one: one[2])
        values = (Value(f"{key}.frequency", largest[1], math.nan, "Hz", None, None),
                  Value(f"{key}.amplitude", largest[2], math.nan, "m", None, None))  # fmt: skip
        at = next(index for index, cause in enumerate(causes) if cause.effect == key)
        sentence = f"Found in {len({one[0] for one in own})} of {records} records and taken out before the fit."
        causes[at] = replace(causes[at], verdict="supported", probability=0.98, parameters=values, sentence=sentence)
        named.append(f"{causes[at].title.lower()} ({key}), taken out before the fit")
    if not named:
        return found
    verdict = "explained" if found.verdict == "nothing missing" else found.verdict
    text = f"In the records beside the decay: {' and '.join(named)}."
    rest = "" if found.verdict == "nothing missing" else f" {found.sentence}"
    causes.sort(key=lambda one: one.verdict not in ("supported", "indistinguishable"))
    return replace(found, verdict=verdict, causes=tuple(causes), sentence=text + rest)
