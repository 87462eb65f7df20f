"""Free decays as a subject of diagnosis: a mass on a line let go, and what may overlie or shape its decay."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from metrology.decay import DecayTest
from metrology.decay.oscillation import DEGREE
from metrology.decay.separation import Separated, Unusable, guard, is_mains, separate
from metrology.diagnose.candidate import DECAY as TABLE
from metrology.diagnose.candidate import Candidate
from metrology.diagnose.engine import FALSE_ALARM, rank
from metrology.diagnose.envelope import rates, suggested
from metrology.diagnose.mains import HARMONICS, shared
from metrology.diagnose.plain import Plain, Readings, Trial, binned
from metrology.diagnose.plain_pictures import of_decay
from metrology.diagnose.subject import Array, Fit
from metrology.diagnose.swing import FORCES, Swing
from metrology.diagnosis import Diagnosis, Missing, Picture, Value
from metrology.diagnosis import Test as Tested
from metrology.errors import Fault, MetrologyError
from metrology.identify import Unknown
from metrology.identify.covariance import inverse
from metrology.timeseries import Channel, average

PER_PERIOD = 20
"""Samples kept per period: means over whole blocks."""
LONGEST = 300
"""Periods of a record that are looked at, from the release on."""
HORIZONS = (0.15, 0.3, 0.6)
"""Parts of the records to which a poor model is fitted first, so that no swing is taken for the one beside it."""
SLOW, SLOW_BESIDE = 1e-3, 1e-8
"""Chance of as large a slow motion from noise alone, below which it is told; beside another effect, whose own small
error (where dry friction holds the mass) looks like one."""
APART = ("drift", "mains", "other")
"""What is sought in every record by itself, before the fit or under it."""
COARSE = 1e-2
"""Part of the motion to which a coarse look judges."""
ENOUGH = 1 / 9
"""χ² for each reading below which a coarse look seeks nothing more: a third of that part is left."""
FINE = 4e-5
"""Noise over motion below which no effect of the table is right to the noise: a coarse look comes first."""
INF = math.inf


@dataclass(frozen=True)
class Record:
    """One release, cut and averaged: times from its first sample, readings, and the linear decay that fits it.

    `count`: samples of which each reading is the mean; `others`: lines taken out before, as (Hz, m, whether mains).
    """

    name: str
    t: Array
    y: Array
    noise: float
    omega: float
    rate: float
    x0: float
    v0: float
    level: float
    count: int
    others: tuple[tuple[float, float, bool], ...]

    @property
    def u(self) -> Array:
        """Standard uncertainty of every reading / m."""
        return np.full(len(self.t), self.noise)

    def passed(self, omega: float) -> float:
        """Part of its amplitude that averaging leaves to an oscillation of angular frequency `omega` / (rad/s)."""
        angle = 0.5 * omega * float(self.t[1]) / self.count
        return math.sin(self.count * angle) / (self.count * math.sin(angle)) if self.count > 1 else 1.0


class Decay:
    """Records of a free-decay test, cut from the release on and averaged to some forty samples a period."""

    def __init__(self, test: DecayTest) -> None:
        self.test, self.failures = test, []
        self.records: list[Record] = []
        taken_apart: list[Separated] = []
        for record in test.records:
            try:
                parted = separate(record, mains=test.mains, expected=test.expected)
            except Unusable as reason:
                self.failures.append(f"{record.name}: {reason}")
                continue
            taken_apart.append(parted)
            self.records.append(_record(record.name, parted, test.mains))
        self.releases = len(self.records)
        if not self.records:
            raise MetrologyError(Fault(f"{test.name}.records", "no record with a decay", "one at least"))
        without = [
            one
            for one, record in zip(taken_apart, self.records, strict=True)
            if not any(hum for *_, hum in record.others)
        ]
        self.hum = shared(without, test.mains, FALSE_ALARM) if len(without) > 1 else None
        if len(self.records) == 1:
            self.records = _parted(self.records[0])
        mass = test.mass.value
        omegas, falls = (np.array([getattr(one, name) for one in self.records]) for name in ("omega", "rate"))
        self.omega, rate = float(np.mean(omegas)), float(max(np.mean(falls), 0.0))
        self.mass, self.k, self.c = mass, mass * (self.omega**2 + rate**2), 2 * mass * rate
        # From release to release k and c differ by temperature and by how the mass hangs: as far as the records say.
        count = len(self.records)
        self.k_scatter = 2 * self.k * float(omegas.std(ddof=1)) / self.omega if count > 1 else 0.0
        self.c_scatter = 2 * mass * float(falls.std(ddof=1)) if count > 1 else 0.0
        self.swings = [Swing(mass, float(one.t[1]), len(one.t)) for one in self.records]
        self.size = float(np.mean([math.hypot(one.x0, one.v0 / self.omega) for one in self.records]))
        self.length = float(np.mean([one.t[-1] for one in self.records]))
        self.rows = np.concatenate([rates(one.t, one.y, one.u, self.omega) for one in self.records])
        self.band = self._band()
        self.floor = 0.0

    @property
    def is_too_fine(self) -> bool:
        """Whether the noise is so far below the motion, as of smoothed records, that every model is wrong by more."""
        return min(one.noise for one in self.records) < FINE * self.size

    def coarse(self) -> Decay:
        """Return the same with a model that is only asked to be right within a part of the motion."""
        found = copy(self)
        found.floor = COARSE * self.size / math.sqrt(2)
        found.records = [replace(one, noise=math.hypot(one.noise, found.floor)) for one in self.records]
        return found

    def _band(self) -> tuple[float, float]:
        """Frequencies / Hz that are the decay's own: where it moves with the amplitude, and too near to be told apart.

        A second line there would bend the first at will, and take up whatever shapes the decay.
        """
        own, longest = self.omega / (2 * math.pi), max(one.t[-1] for one in self.records)
        seen = np.clip([own, *self.rows[:, 3]], 0.8 * own, 1.2 * own)
        aside = max(3 / longest, 0.9 * self.c / (2 * self.mass))
        return float(seen.min()) - aside, float(seen.max()) + aside

    # ---- model --------------------------------------------------------------------------------------------------
    def predict(self, at: int, values: Mapping[str, float]) -> Array | None:
        """Displacement of one record."""
        return self.sweep(at, [values])[0]

    def sweep(self, at: int, many: Sequence[Mapping[str, float]]) -> list[Array | None]:
        """Displacement of one record for many values at once: only motions that differ are followed."""
        keys = [self._motion(values) for values in many]
        different = list(dict.fromkeys(keys))
        names = ("k", "c", "x0", "v0", *FORCES)
        moved = self.swings[at].follow([dict(zip(names, key, strict=True)) for key in different])
        place = {key: row for row, key in enumerate(different)}
        found: list[Array | None] = []
        for key, values in zip(keys, many, strict=True):
            one = self.records[at]
            y = one.passed(one.omega) * moved[place[key]] + self._overlaid(at, values)
            own = self.band[0] < values.get("other.frequency", 0.0) < self.band[1]
            found.append(y if np.isfinite(y).all() and not own else None)
        return found

    def _motion(self, values: Mapping[str, float]) -> tuple[float, ...]:
        k, c = values["k"] + values.get("dk", 0.0), values["c"] + values.get("dc", 0.0)
        return (max(k, 1e-12), c, values["x0"], values["v0"], *(values.get(name, 0.0) for name in FORCES))

    def _overlaid(self, at: int, values: Mapping[str, float]) -> Array:
        t = self.records[at].t
        slow = [values[f"level{order}"] for order in range(DEGREE + 1)]
        y = np.polynomial.legendre.legval(2 * t / t[-1] - 1, slow)
        for name in ("other", "mains"):
            if f"{name}.frequency" in values:
                turn = 2 * math.pi * values[f"{name}.frequency"] * t
                passed = self.records[at].passed(2 * math.pi * values[f"{name}.frequency"])
                fall = passed * np.exp(np.clip(-values.get(f"{name}.rate", 0.0) * t, -50, 5))
                sine, cosine = values.get(f"{name}.sin", 0.0), values.get(f"{name}.cos", 0.0)
                y = y + fall * (sine * np.sin(turn) + cosine * np.cos(turn))
        return np.asarray(y, dtype=float)

    # ---- candidates ---------------------------------------------------------------------------------------------
    def amounts(self) -> dict[str, float]:
        """Amounts of the forces that are small beside those of spring and damper, whatever the size of the rig."""
        k, A, w = self.k, self.size, self.omega
        c = max(self.c, 1e-3 * self.mass * w)
        return {
            "friction": 1e-4 * k * A, "quadratic drag": 0.01 * c / (w * A), "cubic": 1e-3 * k / A**2,
            "damping": 0.02 * c / A,
        }  # fmt: skip

    def table(self) -> dict[str, Candidate]:
        """Candidates with scales that suit the rig."""
        scaled = {
            name: replace(TABLE[name], parameters=(replace(TABLE[name].size, scale=10 * amount),))
            for name, amount in self.amounts().items()
        }
        return TABLE | scaled

    def trials(self, name: str, fit: Fit) -> Sequence[Trial]:
        """Shapes of a candidate; other oscillations where the residual spectrum shows them."""
        A, amounts = self.size, self.amounts()
        if name in amounts:
            return [Trial(amounts[name])]
        if name in ("setup", "drift"):
            return []
        if name == "mains":
            return [
                Trial(1e-3 * A, {"mains.frequency": frequency}, 4.0) for frequency in self._lines(fit, 0.0, hum=True)
            ]
        # A line that lives long, and one that dies with the decay: what that itself drives.
        return [
            Trial(1e-3 * A, {"other.frequency": frequency, "other.rate": rate}, self.length * self.omega)
            for rate in (0.3 / self.length, max(self.c / (2 * self.mass), 1.0 / self.length))
            for frequency in self._lines(fit, rate, hum=False)
        ]

    def _lines(self, fit: Fit, rate: float, *, hum: bool) -> list[float]:
        """Frequency / Hz of the strongest line of all residuals that decays at a rate, at the mains or elsewhere."""
        longest, step = max(one.t[-1] for one in self.records), self.records[0].t[1]
        size = 4 * 2 ** math.ceil(math.log2(longest / step + 1))
        grid, power = np.fft.rfftfreq(size, step), np.zeros(size // 2 + 1)
        for one, residual in zip(self.records, fit.residuals, strict=True):
            weight = np.exp(-rate * one.t) if rate * one.t[-1] > 1 else np.hanning(len(one.t))
            found = np.abs(np.fft.rfft(weight * residual, size)) ** 2 / float(weight @ weight)
            power += np.interp(grid, np.fft.rfftfreq(size, one.t[1]), found)
        mains, width = self.test.mains, max(1 / longest, 0.3 * rate)
        low, high = self.band
        beside = np.abs(grid / mains - np.maximum(np.round(grid / mains), 1)) * mains < max(0.5, 1.5 / longest)
        own = (grid > low - width) & (grid < high + width)
        allowed = beside if hum else ~beside & ~own
        allowed &= (grid > 2 * width) & (grid < 0.9 * grid[-1])
        return [float(grid[np.flatnonzero(allowed)[np.argmax(power[allowed])]])] if allowed.any() else []

    # ---- as the engine takes it ---------------------------------------------------------------------------------
    def subject(self, sample: str = "") -> Plain:
        """As the engine takes it."""
        common = (
            Unknown("k", self.k, self.k * 1e-3, 1e-9, INF, unit="N/m"),
            Unknown("c", self.c, max(self.c * 0.05, 1e-9), 0.0, INF, unit="N·s/m"),
        )
        blocks = tuple(Readings(one.name, "x", one.y, one.u, _phases(one.t)) for one in self.records)
        own = tuple(self._own(one) for one in self.records)
        reasons = {"setup": f"alone it is exactly a lower k. Needed: {TABLE['setup'].separate}"}
        return Plain(
            sample, "decay", self.table(), blocks, common, own, self.predict, self.trials, reasons, self.gap,
            self.pictures, sweep=self.sweep, horizons=HORIZONS, suggested=self.suggested,
            structure=_within if self.floor else None, enough=ENOUGH if self.floor else 0.0,
        )  # fmt: skip

    def suggested(self, effects: Sequence[str]) -> dict[str, float]:
        """Values that decay rate and frequency against amplitude suggest."""
        return suggested(self.rows, self.mass, effects)

    def _own(self, one: Record) -> tuple[Unknown, ...]:
        """Start, zero, and what a release has of its own in k and c."""
        found = [
            Unknown(f"x0@{one.name}", one.x0, self.size * 0.01, unit="m"),
            Unknown(f"v0@{one.name}", one.v0, self.size * self.omega * 0.01, unit="m/s"),
        ]
        for order in range(DEGREE + 1):
            start = one.level if order == 0 else 0.0
            found.append(Unknown(f"level{order}@{one.name}", start, self.size * 0.01, unit="m"))
        for name, u, unit in (("dk", self.k_scatter, "N/m"), ("dc", self.c_scatter, "N·s/m")):
            if u > 0:
                found.append(Unknown(f"{name}@{one.name}", 0.0, u, mean=0.0, u=u, unit=unit))
        return tuple(found)

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """Decay rate and frequency against amplitude, spectrum and residuals."""
        records = [(one.t, one.y, one.u) for one in self.records]
        return of_decay(records, self.omega, before, after)

    def gap(self, fit: Fit) -> Missing | None:
        """Residual displacement against time and displacement."""
        t = np.concatenate([one.t for one in self.records])
        u = np.concatenate([one.u for one in self.records])
        y = np.concatenate([one.y for one in self.records])
        residual = np.concatenate(fit.residuals) * u
        return binned("missing displacement", "m", {("time", "s"): t, ("displacement", "m"): y}, residual, u)


def _record(name: str, parted: Separated, mains: float) -> Record:
    """Cut and average one release; lines that have nothing to do with the decay are taken out before."""
    main, fit, free = parted.fit.main, parted.fit, parted.free
    taken = [at for at in range(1, len(fit.modes)) if _foreign(fit.modes[at].omega, parted)]
    value = free.value - sum((fit.part(parted.t, at) for at in taken), np.zeros(len(free.value)))
    period = 2 * math.pi / main.omega
    kept = free.time <= free.time[0] + LONGEST * period
    count = max(1, int(period * free.rate / PER_PERIOD))
    thin: Channel = replace(free, time=free.time[kept], value=value[kept])
    thin = average(thin, count) if count > 1 else thin
    a, b = fit.coefficients[0]
    pole = complex(-main.rate, main.omega)
    turned = complex(a, -b) * np.exp(pole * (thin.time[0] - free.time[0]))
    others = tuple((fit.modes[at].frequency, float(fit.amplitudes[at]), is_mains(fit.modes[at], mains)) for at in taken)
    return Record(
        name, thin.time - thin.time[0], thin.value, parted.noise / math.sqrt(count), main.omega, main.rate,
        float(turned.real), float((turned * pole).real), float(np.mean(thin.value[len(thin.value) // 2 :])),
        count, others,
    )  # fmt: skip


def _parted(one: Record) -> list[Record]:
    """First and later part of a single release, so that each can be predicted from the other."""
    at = int(np.searchsorted(one.t, min(0.5 * one.t[-1], 0.7 / max(one.rate, 1e-12))))
    if min(at, len(one.t) - at) < 3 * PER_PERIOD:
        return [one]
    pole = complex(-one.rate, one.omega)
    turned = complex(one.x0, -(one.v0 + one.rate * one.x0) / one.omega) * np.exp(pole * one.t[at])
    first = replace(one, name=f"{one.name}, first part", t=one.t[:at], y=one.y[:at])
    later = replace(
        one, name=f"{one.name}, later part", t=one.t[at:] - one.t[at], y=one.y[at:], x0=float(turned.real),
        v0=float((turned * pole).real),
    )  # fmt: skip
    return [first, later]


def _foreign(omega: float, parted: Separated) -> bool:
    """Whether a line is none that the decay itself makes: near its frequency as that moves, or near a multiple."""
    main = parted.fit.main
    order = max(1, round(omega / main.omega))
    width = (0.2 if order == 1 else 0.04) * main.omega + guard(main, float(parted.t[-1]))
    return order > HARMONICS or abs(omega - order * main.omega) > width


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
    looks = [prepared.coarse(), prepared] if prepared.is_too_fine else [prepared]
    for look in looks:
        posed = look.subject(sample)
        found = rank(posed, rng=rng, test=test.name, false_alarm=false_alarm)
        if found.verdict != "nothing missing":
            break
    if posed.enough and found.verdict in ("explained", "ambiguous"):
        words = (
            f"That holds to {100 * COARSE:g} % of the motion: less is left, and not looked at, though the noise of "
            "the records is far below."
        )
        found = replace(found, sentence=f"{found.sentence} {words}")
    overlays = (*_lines(prepared), *_hum(prepared, found), *_drift(posed, found, look))
    return replace(_with_overlays(_sought_apart(found), overlays), failures=(*prepared.failures, *found.failures))


def _within(fit: Fit, false_alarm: float) -> Tested:
    """Whether what is left is less than the part of the motion to which a coarse look judges it."""
    share = COARSE * math.sqrt(fit.chi_squared / fit.count)
    sentence = f"What is left is {100 * share:.2g} % of the motion; judged to {100 * COARSE:g} %."
    passed = share <= COARSE
    return Tested("residual", share, COARSE, 1.0 if passed else 0.0, false_alarm, passed, sentence)


@dataclass(frozen=True)
class Overlay:
    """Something beside the decay: which candidate, how large, and whether the evaluation leaves it in the records."""

    effect: str
    values: tuple[Value, ...]
    sentence: str
    stays: bool = False


def _lines(prepared: Decay) -> Iterator[Overlay]:
    """Oscillations that were found in at least half of the records."""
    records = prepared.records
    for key, hum in (("mains", True), ("other", False)):
        own = [(one.name, *line) for one in records for line in one.others if line[2] == hum]
        among = len({one[0] for one in own})
        if not own or 2 * among < len(records):
            continue
        largest = max(own, key=lambda one: one[2])
        values = (Value(f"{key}.frequency", largest[1], math.nan, "Hz", None, None),
                  Value(f"{key}.amplitude", largest[2], math.nan, "m", None, None))  # fmt: skip
        # A single release is looked at in two parts.
        where = f"{among} of {len(records)} records" if prepared.releases > 1 else "the record"
        yield Overlay(key, values, f"Found in {where} and taken out before the fit.")


def _hum(prepared: Decay, found: Diagnosis) -> Iterator[Overlay]:
    """Mains that only all records together show, and too few of them one by one."""
    known = (*found.possible, *(one.effect for one in _lines(prepared)))
    if prepared.hum is None or "mains" in known:
        return
    frequency, size = prepared.hum
    values = (Value("mains.frequency", frequency, math.nan, "Hz", None, None),
              Value("mains.amplitude", size, math.nan, "m", None, None))  # fmt: skip
    yield Overlay("mains", values, "Found in the records together, too weak to be taken out of each.", stays=True)


def _drift(posed: Plain, found: Diagnosis, prepared: Decay) -> Iterator[Overlay]:
    """Slow motion under the decay, where the polynomial that every record is given is more than noise makes it."""
    from scipy.special import gammaincc

    model = found.extended_model
    carried = tuple(name for name in found.possible if any(one.name in model for one in TABLE[name].parameters))
    fit = posed.fit(carried, [model])
    if fit is None:
        return
    spread, largest, squares = inverse(fit.information), 0.0, np.zeros(2)
    for one in prepared.records:
        rows = [
            at for at in (fit.index(f"level{order}@{one.name}") for order in range(1, DEGREE + 1)) if at is not None
        ]
        level = fit.theta[rows]
        squares += (
            level[0] ** 2 / spread[rows[0], rows[0]],
            level @ np.linalg.solve(spread[np.ix_(rows, rows)], level),
        )
        largest = max(largest, float(np.ptp(np.polynomial.legendre.legval(np.linspace(-1, 1, 50), [0.0, *level]))))
    ways = len(prepared.records) * np.array([1, DEGREE])
    # A steady drift is sought by itself as well: it has more to show in one way than in four.
    p = 2 * float(gammaincc(ways / 2, squares / 2).min())
    if p < (SLOW_BESIDE if carried else SLOW):
        words = f"Found beyond noise (χ² = {squares[1]:.0f} with {ways[1]} degrees of freedom), taken out with the fit."
        yield Overlay("drift", (Value("drift", largest, math.nan, "m", None, None),), words)


def _sought_apart(found: Diagnosis) -> Diagnosis:
    """Say of what is sought beside the fit, in every record by itself, that it was, where the fit cannot test it."""
    words = "Looked for in every record by itself"
    causes = [
        replace(one, verdict="not supported", sentence=f"{words}, and not found.")
        if one.effect in APART and one.verdict == "not testable" else one for one in found.causes
    ]  # fmt: skip
    sizes = [
        replace(one, sentence=f"{words}: no smallest size is stated beforehand.")
        if one.effect in APART and one.size is None else one for one in found.detectable
    ]  # fmt: skip
    return replace(found, causes=tuple(causes), detectable=tuple(sizes))


def _with_overlays(found: Diagnosis, overlays: Sequence[Overlay]) -> Diagnosis:
    """Name what overlies the decay, whatever shapes it."""
    if not overlays:
        return found
    causes = list(found.causes)
    named: dict[bool, list[str]] = {False: [], True: []}
    for one in overlays:
        at = next(index for index, cause in enumerate(causes) if cause.effect == one.effect)
        if causes[at].verdict in ("supported", "indistinguishable"):
            # Another line than the one that the fit named, which keeps its size and what it is worth.
            sizes = ", ".join(f"{value.name.partition('.')[2]} {value.value:.3g} {value.unit}" for value in one.values)
            causes[at] = replace(causes[at], sentence=f"{causes[at].sentence} Another one ({sizes}): {one.sentence}")
        else:
            causes[at] = replace(
                causes[at], verdict="supported", probability=0.98, parameters=one.values, sentence=one.sentence
            )
        named[one.stays].append(f"{causes[at].title.lower()} ({one.effect})")
    clean = found.verdict == "nothing missing"
    words = {False: "In the records beside the decay, and taken out of them", True: "Too weak to be taken out of each"}
    text = " ".join(f"{words[stays]}: {', '.join(names)}." for stays, names in named.items() if names)
    causes.sort(key=lambda one: one.verdict not in ("supported", "indistinguishable"))
    return replace(
        found, verdict="explained" if clean else found.verdict, causes=tuple(causes),
        sentence=text if clean else f"{text} {found.sentence}",
    )  # fmt: skip
