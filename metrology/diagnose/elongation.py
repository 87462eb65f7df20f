"""Elongation tests as a subject of diagnosis: readings under dead loads, and what may bend the line through them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from metrology.diagnose.candidate import Candidate, Size
from metrology.diagnose.engine import FALSE_ALARM, rank
from metrology.diagnose.finding import Diagnosis, Missing, Picture
from metrology.diagnose.plain import Plain, Readings, Trial, binned
from metrology.diagnose.plain_pictures import of_elongation
from metrology.diagnose.subject import Array, Fit
from metrology.elongation import ElongationTest
from metrology.elongation.line import Layout, average
from metrology.elongation.model import force
from metrology.gum.inputs import Input
from metrology.identify import Unknown

INF = math.inf
CLEAN = 0.7
"""Robust over plain scatter from which on the plain one is taken: the robust one is uncertain by an eighth itself."""


def _candidate(
    name: str, title: str, equation: str, parameters: tuple[Size, ...], words: tuple[str, str, str, str]
) -> Candidate:
    return Candidate(name, title, equation, parameters, *words)


TABLE: dict[str, Candidate] = {
    one.name: one
    for one in (
        _candidate(
            "creep", "Creep under load", "x = … + a·F·ln(1 + j)",
            (Size("creep.rate", "m/N", 0.0, 0.0, INF, 1e-7),),
            ("readings grow from one to the next, the more the larger the load",
            "k comes out too small where loading goes up only",
             "wait the same time at each load; state the time with k",
             "hold one load for an hour and read every minute"),
        ),
        _candidate(
            "slip", "Slip in a clamp", "x = … + Δ from one reading on",
            (Size("slip.set", "m", 0.0, 0.0, INF, 1e-6), Size("slip.after", "1", 0.0, 0.0, INF, 0.0, True)),
            ("one step that stays", "k comes out too small where the step lies among loading",
            "tighten the clamp, mark the sample at it, repeat",
             "marks on the sample at the clamp"),
        ),
        _candidate(
            "toe", "Toe region", "x = … + a·(1 − exp(−F/F₀))",
            (Size("toe.extent", "m", 0.0, 0.0, INF, 1e-6), Size("toe.force", "N", 1.0, 1e-3, 1e5, 1.0, True)),
            ("more extension for the first loads than for later ones", "k comes out too small", "preload the sample",
             "smaller steps at small loads"),
        ),
        _candidate(
            "curvature", "Line that is not straight", "x = … + a·F²",
            (Size("curvature.coefficient", "m/N²", 0.0, -INF, INF, 1e-9),),
            ("residuals bend over the whole range, loading and unloading alike", "k is a mean over the range of loads",
             "state k per range of load", "more loads over the same range"),
        ),
        _candidate(
            "backlash", "Backlash of the indicator, or hysteresis", "x = … + b when unloading",
            (Size("backlash.width", "m", 0.0, -INF, INF, 1e-6),),
            ("unloading readings lie off loading ones by the same amount",
            "k hardly changes where every load is read both ways",
             "read in one direction only, or tap the indicator",
             "indicator on a rigid stand with a gauge block, both ways"),
        ),
        _candidate(
            "frame", "Frame and clamps in series", "x = … + C·F",
            (Size("frame.compliance", "m/N", 0.0, 0.0, INF, 1e-7),),
            ("none: it is exactly a lower k", "k and E come out too small by 1/(1 + C·k)",
            "measure at the specimen, not at the frame",
             "an indicator on the mount, or a specimen of another length: x/F against length has C as its intercept"),
        ),
        _candidate(
            "drift", "Drift of temperature or of the indicator", "x = … + a·j",
            (Size("drift.rate", "m", 0.0, -INF, INF, 1e-7),),
            ("readings move with their order, whatever the load", "k is off where loading goes up only",
            "record temperature; read up and down",
             "an hour of readings at constant load"),
        ),
        _candidate(
            "misread", "A misread reading", "x = … + Δ in one reading",
            (Size("misread.error", "m", 0.0, -INF, INF, 1e-6), Size("misread.reading", "1", 0.0, 0.0, INF, 0.0, True)),
            ("one reading far off, its neighbours well", "k is pulled by one reading",
            "look at the raw sheet; read again",
             "the same load again"),
        ),
    )
}  # fmt: skip
"""Every candidate of an elongation test."""


class Elongation:
    """An elongation test in numbers: force, direction, order and repeat of every reading in use."""

    def __init__(self, test: ElongationTest) -> None:
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
        layout = Layout.of([order[reading.load] for reading in used], [self.names.index(one.repeat) for one in used])
        means = average(values, layout)
        self.at = [np.flatnonzero(layout.repeats == index) for index in range(len(self.names))]
        self.force = np.array([forces[reading.load] for reading in used])
        self.load = layout.loads
        self.back = np.array([reading.direction == "unloading" for reading in used], dtype=float)
        self.values = values
        self.place = np.arange(len(used), dtype=float)
        for rows in self.at:
            self.place[rows] = np.arange(len(rows))
        # Scatter about the means holds slips and misreadings too; the median of it does not.
        spare = np.sqrt(np.maximum(1 - means.leverage, 1e-6))
        robust = 1.4826 * float(np.median(np.abs(means.leftover) / spare))
        plain = math.sqrt(means.variance)
        scatter = plain if robust > CLEAN * plain else max(1.1 * robust, 0.3 * plain)
        self.u = _widened(math.hypot(scatter, 0.3 * test.resolution.u), means.dof)
        self.slope = float(np.polyfit(self.force, values, 1)[0])

    def predict(self, at: int, values: Mapping[str, float]) -> Array:
        """Readings of one repeat."""
        rows = self.at[at]
        F, j = self.force[rows], self.place[rows]
        x = values["zero"] + values["slope"] * F
        for name, column in enumerate(self.loads):
            x = x + values.get(f"indicator.{column}", 0.0) * (self.load[rows] == name)
        x = x + values.get("creep.rate", 0.0) * F * np.log1p(j) + values.get("drift.rate", 0.0) * j
        x = x + values.get("curvature.coefficient", 0.0) * F**2 + values.get("backlash.width", 0.0) * self.back[rows]
        x = x + values.get("frame.compliance", 0.0) * F
        if "toe.force" in values:
            x = x - values["toe.extent"] * np.expm1(-F / values["toe.force"])
        if "slip.after" in values:
            x = x + values["slip.set"] * (rows > values["slip.after"])
        if "misread.reading" in values:
            x = x + values["misread.error"] * (rows == round(values["misread.reading"]))
        return np.asarray(x, dtype=float)

    def trials(self, name: str, _fit: Fit) -> Sequence[Trial]:
        """Shapes of a candidate: every place for a slip or a misreading, several extents of a toe."""
        most, u = float(np.abs(self.force).max()), self.u
        if name == "toe":
            return [Trial(u, {"toe.force": part * most}) for part in (0.05, 0.15, 0.4)]
        if name == "slip":
            inside = [int(row) for rows in self.at for row in rows[:-1]]
            return [Trial(u, {"slip.after": float(row)}) for row in inside]
        if name == "misread":
            return [Trial(u, {"misread.reading": float(row)}) for row in range(len(self.values))]
        amounts = {"creep": u / most, "curvature": u / most**2, "backlash": u, "frame": u / most, "drift": u / 5}
        return [Trial(amounts[name])]

    def subject(self, sample: str = "") -> Plain:
        """As the engine takes it."""
        declared = math.sqrt(sum(one.u**2 for one in self.test.indicator))
        known = [math.hypot(declared, self._of_load(at)) for at in range(len(self.loads))]
        common = [Unknown("slope", self.slope, abs(self.slope) * 1e-2, unit="m/N")]
        common += [
            Unknown(f"indicator.{name}", 0.0, u, mean=0.0, u=u, unit="m")
            for name, u in zip(self.loads, known, strict=True) if u > 0
        ]  # fmt: skip
        blocks = tuple(
            Readings(name, "x", self.values[rows], np.full(len(rows), self.u), self._phases(rows))
            for name, rows in zip(self.names, self.at, strict=True)
        )
        own = tuple((Unknown(f"zero@{name}", float(self.values[rows].min()), self.u, unit="m"),)
                    for name, rows in zip(self.names, self.at, strict=True))  # fmt: skip
        reasons = {"frame": f"it is exactly a lower k. Needed: {TABLE['frame'].separate}"}
        if not 0 < self.back.mean() < 1:
            reasons["backlash"] = "loads were reached from one side only"
        return Plain(
            sample, "elongation", TABLE, blocks, tuple(common), own, self.predict, self.trials, reasons, self.gap,
            self.pictures,
        )  # fmt: skip

    def _of_load(self, at: int) -> float:
        quantity = self.test.loads[at].quantity
        return (
            abs(self.slope)
            * float(np.max(self.force[self.load == at], initial=0.0))
            * quantity.u
            / (quantity.value or 1.0)
        )

    def _phases(
        self, rows: np.ndarray[tuple[int, ...], np.dtype[np.intp]]
    ) -> list[tuple[str, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]]:
        back = self.back[rows] > 0
        return [(name, marks) for name, marks in (("loading", ~back), ("unloading", back)) if marks.any()]

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """Residual against load and in the order of reading."""
        rows = np.concatenate(self.at)
        return of_elongation((self.force[rows], rows.astype(float), self.back[rows] > 0), self.u, before, after)

    def gap(self, fit: Fit) -> Missing | None:
        """Residual extension against force, order and direction."""
        rows = np.concatenate(self.at)
        residual = np.concatenate(fit.residuals) * self.u
        columns = {
            ("force", "N"): self.force[rows],
            ("order", "1"): self.place[rows],
            ("direction", "1"): self.back[rows],
        }
        return binned("missing extension", "m", columns, residual, np.full(len(rows), self.u))


def _widened(scatter: float, dof: int) -> float:
    """Scatter widened so that a normal score test keeps its false-alarm rate with few degrees of freedom."""
    from scipy.special import stdtrit

    return scatter * float(-stdtrit(max(dof, 2), 1e-4)) / 3.719


def _inputs(test: ElongationTest) -> list[Input]:
    named = [test.gravity, test.air_density, test.weight_density, *(load.quantity for load in test.loads)]
    return [item for item in (*named, test.weights, test.scale) if item is not None]


def elongation(
    test: ElongationTest, *, rng: np.random.Generator, sample: str = "", false_alarm: float = FALSE_ALARM
) -> Diagnosis:
    """Diagnose an elongation test: what bends or breaks the line of extension against load.

    Parameters
    ----------
    test : ElongationTest
        As for `elongation.analyse`.
    rng : Generator
        For simulated limits and bootstrap intervals.
    sample : str
        Id of the sample, for the result.
    false_alarm : float
        Rate at which each of the two tests may fail where nothing is missing.
    """
    return rank(Elongation(test).subject(sample), rng=rng, test=test.name, false_alarm=false_alarm)
