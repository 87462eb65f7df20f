"""Free decays as a subject of diagnosis: a mass on a line let go, and what may overlie or shape its decay."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from metrology.coordinate import QUANTITIES
from metrology.decay import DecayTest
from metrology.decay.envelope import rates, suggested
from metrology.decay.separated import Separated
from metrology.diagnosis import Diagnosis, Missing, Picture
from metrology.diagnostics.block_trials import Trial
from metrology.diagnostics.blocks import Readings, plain_values
from metrology.diagnostics.candidate import DECAY as TABLE
from metrology.diagnostics.candidate import Candidate, untested
from metrology.diagnostics.decay_laws import unlisted
from metrology.diagnostics.decay_lines import Bands
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.engine import rank
from metrology.diagnostics.overlays import overlying, sought_apart, with_overlays
from metrology.diagnostics.plain import Plain
from metrology.diagnostics.plain_pictures import of_decay
from metrology.diagnostics.plain_reported import binned
from metrology.diagnostics.release import BENDS, BENT, FORCES, LEVELS, LINES, MOTION, STEPS, Record
from metrology.diagnostics.release_cut import cut, parts, phases
from metrology.diagnostics.release_overlay import overlaid, overlaid_slope
from metrology.diagnostics.subject import Array, Fit, Slow
from metrology.errors import Fault, MetrologyError
from metrology.estimation import Unknown
from metrology.message import said
from metrology.rig import Rig

BEGINNINGS = (0.15, 0.3, 0.6)
"""Parts of the records to which a poor model is fitted first, so that no swing is taken for the one beside it."""
INF = math.inf
USUAL = 1500
"""Readings of a motion with forces that take as long as a usual test of response, with their derivatives and the trial
motions of a search between them: 60 ms."""
OFF = 4.0
"""Ratio to m·ω² within which k lies: a law that bends a spring so far moves the frequency by half, which is seen."""


class Decay:
    """Records of a free-decay test, cut from the release on and averaged to some forty samples a period."""

    def __init__(self, test: DecayTest) -> None:
        self.test, self.failures = test, []
        self.records: list[Record] = []
        for record, parted in zip(test.records, test.separated, strict=True):
            if not isinstance(parted, Separated):
                self.failures.append(said("{name}: {sentence:quoted}", name=record.name, sentence=parted.args[0]))
                continue
            self.records.append(cut(record.name, parted, test.mains))
        self.releases = len(self.records)
        if not self.records:
            raise MetrologyError(Fault(f"{test.name}.records", "no record with a decay", "one at least"))
        # What can be told from the decay by its frequency follows from whole releases, not from the parts of one.
        self.whole, self.longest = tuple(self.records), max(float(one.t[-1]) for one in self.records)
        if len(self.records) == 1:
            self.records = parts(self.records[0])
        mass = test.mass.value
        omegas, falls = (np.array([getattr(one, name) for one in self.records]) for name in ("omega", "rate"))
        self.omega, rate = float(np.mean(omegas)), float(max(np.mean(falls), 0.0))
        self.mass, self.k, self.c = mass, mass * (self.omega**2 + rate**2), 2 * mass * rate
        # From release to release k and c differ by temperature and by how the mass hangs: as far as the records say.
        count = len(self.records)
        self.k_scatter = 2 * self.k * float(omegas.std(ddof=1)) / self.omega if count > 1 else 0.0
        self.c_scatter = 2 * mass * float(falls.std(ddof=1)) if count > 1 else 0.0
        self.rig = Rig(mass, self.k, self.c, attachment="both ways", coordinate=test.coordinate)
        self.unit = test.records[0].unit
        self.units = {name: self.rig.parameters[name].unit for name in ("k", "c")}
        self.size = float(np.mean([math.hypot(one.x0, one.v0 / self.omega) for one in self.records]))
        self.length = float(np.mean([one.t[-1] for one in self.records]))
        # What a reading is over the position that it is of.
        self.gain = self.omega**test.sensed.order
        # Of a reading that is not linear by parts of its largest amplitude: factors of its square and of its cube.
        largest = self.gain * max(math.hypot(one.x0, one.v0 / self.omega) for one in self.records)
        self.over = tuple(largest ** -(1.0 + at) for at in range(len(BENDS)))
        self.rows = np.concatenate([rates(one.t, one.y, one.u, self.omega) for one in self.records])
        self.rows[:, 0] /= self.gain
        self.bands = Bands(self.omega, self.c / (2 * self.mass), self.rows[:, 3], self.longest, test.mains)

    # ---- model --------------------------------------------------------------------------------------------------
    def predict(self, at: int, values: Mapping[str, float]) -> Array | None:
        """Readings of one record."""
        return self.sweep(at, [values])[0]

    def sweep(self, at: int, many: Sequence[Mapping[str, float]]) -> list[Array | None]:
        """Readings of one record for many values at once: only motions that differ are followed."""
        keys = [self._motion(values) for values in many]
        different = list(dict.fromkeys(keys))
        one = self.records[at]
        moved = dict(zip(different, one.follow(self.rig, different), strict=True))
        found: list[Array | None] = []
        for key, values in zip(keys, many, strict=True):
            y = moved[key] + overlaid(one, values)
            line = np.array(values.get("other.frequency", math.nan))
            own = bool(self.bands.is_own(line, values.get("other.rate", 0.0)) | self.bands.makes(line))
            found.append(y if np.isfinite(y).all() and not own else None)
        return found

    def _motion(self, values: Mapping[str, float]) -> tuple[float, ...]:
        k, c = values["k"] + values.get("dk", 0.0), values["c"] + values.get("dc", 0.0)
        bends = (values.get(name, 0.0) * self.over[at] for at, name in enumerate(BENDS))
        return (k, c, values["x0"], values["v0"], *(values.get(name, null) for name, null in FORCES.items()), *bends)

    def slopes(self, at: int, values: Mapping[str, float], unknowns: Sequence[Unknown]) -> Array | None:
        """Derivatives of the readings of one record by its unknowns, shape (p, n); None where there are none.

        k and c have the same derivative as what a record has of its own in them.
        """
        one = self.records[at]
        places = {entry.name: _place(entry.name) for entry in unknowns}
        moving = [place for place in dict.fromkeys(places.values()) if place is not None]
        moved = one.slopes(self.rig, self._motion(values), moving)
        moved *= np.array([self.over[place - BENT] if place >= BENT else 1.0 for place in moving])[:, None]
        found = []
        for entry in unknowns:
            place = places[entry.name]
            own = entry.name.split("@")[0]
            found.append(overlaid_slope(one, own, values) if place is None else moved[moving.index(place)])
        slopes = np.array(found)
        return slopes if np.isfinite(slopes).all() else None

    # ---- candidates ---------------------------------------------------------------------------------------------
    def scales(self) -> dict[str, float]:
        """Sizes of the motion, by which the candidates scale what they try."""
        w = self.omega
        return {"k": self.k, "c": max(self.c, 1e-3 * self.mass * w), "e": self.size, "v": w * self.size, "omega": w}

    def table(self) -> dict[str, Candidate]:
        """Candidates with scales that suit the rig."""
        found, scales = dict(TABLE), self.scales()
        for name, one in TABLE.items():
            if one.size.name in FORCES:
                size, *shapes = (replace(each, unit=self.rig.parameters[each.name].unit) for each in one.parameters)
                known, limits = self.rig.parameters[size.name], one.limits(scales)
                low, high = limits.get(size.name, (known.low, known.high))
                size = replace(size, low=low, high=high, scale=10 * one.amount(scales))
                shapes = [replace(each, low=limits[each.name][0], high=limits[each.name][1]) for each in shapes]
                found[name] = replace(one, parameters=(size, *shapes))
        if self.test.coordinate == "angle":
            # A stop as well; but that a hardening is named in its place, k with it, shows in a fit of it.
            law = TABLE["cubic"].cause.law
            found["stop"] = replace(found["stop"], instead=True, cause=replace(found["stop"].cause, law=law))
        for name in LINES:
            sizes = [replace(one, unit=self.unit) if one.own else one for one in TABLE[name].parameters]
            found[name] = replace(TABLE[name], parameters=tuple(sizes))
        *sizes, frequency = found["mains"].parameters
        frequency = replace(frequency, apart=self.bands.apart_at_mains(self.records[0].step))
        found["mains"] = replace(found["mains"], parameters=(*sizes, frequency))
        return found

    def trials(self, name: str, fit: Fit) -> Sequence[Trial]:
        """Shapes of a candidate; other oscillations where the residual spectrum shows them."""
        A, one = self.gain * self.size, TABLE[name]
        if one.size.name in (*FORCES, *BENDS):
            return [Trial(one.amount(self.scales()), shape) for shape in one.shapes(self.scales())]
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
        residuals = [np.concatenate(fit.residuals)] if self.releases == 1 else fit.residuals
        return self.bands.strongest(self.whole, residuals, self.records[0].step, rate, hum=hum)

    def families(self, fit: Fit) -> list[Direction]:
        """Unlisted laws along the fitted motion."""
        own = [self._motion({**fit.shapes, **plain_values(fit.values, one.name)}) for one in self.records]
        return unlisted(self.rig, self.records, own, unit=1e-4 * self.k * self.size)

    # ---- as the engine takes it ---------------------------------------------------------------------------------
    def subject(self, sample: str = "") -> Plain:
        """As the engine takes it."""
        return replace(
            self._posed(sample), beginnings=tuple(self._beginning(part)._posed(sample) for part in BEGINNINGS)
        )

    def _beginning(self, part: float) -> Decay:
        """The same test on a first part of every record."""
        found = copy(self)
        found.records = [one.beginning(part) for one in self.records]
        return found

    def _posed(self, sample: str) -> Plain:
        common = (
            Unknown("k", self.k, self.k * 1e-3, self.k / OFF, self.k * OFF, unit=self.units["k"]),
            Unknown(
                "c", self.c, max(self.c * 0.05, 1e-9), 0.0, 2 * math.sqrt(self.k * self.mass), unit=self.units["c"]
            ),
        )
        blocks = tuple(Readings(one.name, "x", one.y, one.u, phases(one.t)) for one in self.records)
        own = tuple(self._own(one) for one in self.records)
        reasons = untested(TABLE)
        if self.test.coordinate == "position":
            reasons["pendulum"] = said("the records are of a position; a pendulum is recorded as an angle")
        else:
            # Beside it the noise of swings that a camera reads askew is taken for less, and the sine loses its name.
            reasons["slack"] = said("the records are of an angle; a slack line is sought in a position")
        return Plain(
            sample, "decay", self.table(), blocks, common, own, self.predict, self.trials, reasons, self.gap,
            self.pictures, sweep=self.sweep, slopes=self.slopes, suggested=self.suggested,
            dear=self.dear, has_repeats=self.releases > 1, forms=self.families, floor=self.floor,
            slow=tuple(Slow(tuple(f"{level}@{one.name}" for level in one.levels[1:]), len(one.t), one.rounding)
                       for one in self.records),
        )  # fmt: skip

    @property
    def dear(self) -> float:
        """What a derivative costs over one of a usual test of response: by its readings."""
        return max(1.0, sum(len(one.t) for one in self.records) / USUAL)

    @property
    def floor(self) -> float:
        """Level of the noise, over that of the readings, that rounding leaves at least.

        What has come to rest reads the same for as long as the record goes on. By those readings the noise would be
        nothing, and whatever the motion before them leaves certain, a thousand times over. Where the readings are those
        of a coarse instrument with what each of them says, most say nothing and lie on the motion.
        """
        return min(1.0, *(1.0 if one.is_known else one.rounding / float(np.median(one.u)) for one in self.records))

    def suggested(self, effects: Sequence[str]) -> dict[str, float]:
        """Values that decay rate and frequency against amplitude suggest."""
        return suggested(self.rows, self.mass, effects)

    def _own(self, one: Record) -> tuple[Unknown, ...]:
        """Start, zero, and what a release has of its own in k and c."""
        words, read = QUANTITIES[self.test.coordinate], 0.01 * self.gain * self.size
        found = [
            Unknown(f"x0@{one.name}", one.x0, self.size * 0.01, unit=words["x"].unit),
            Unknown(f"v0@{one.name}", one.v0, self.size * self.omega * 0.01, unit=words["v"].unit),
        ]
        for name in one.levels:
            start = one.level if name == LEVELS[0] else 0.0
            found.append(Unknown(f"{name}@{one.name}", start, read, unit=self.unit))
        for name, _ in zip(STEPS, one.steps, strict=False):
            found.append(Unknown(f"{name}@{one.name}", 0.0, read, unit=self.unit))
        for name, u, unit in (("dk", self.k_scatter, self.units["k"]), ("dc", self.c_scatter, self.units["c"])):
            if u > 0:
                found.append(Unknown(f"{name}@{one.name}", 0.0, u, mean=0.0, u=u, unit=unit))
        return tuple(found)

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """Decay rate and frequency against amplitude, spectrum and residuals."""
        records = [(one.t, one.y, one.u) for one in self.records]
        return of_decay(records, self.omega, before, after, self.unit)

    def gap(self, fit: Fit) -> Missing | None:
        """Residual against time and reading."""
        t, y, u = (np.concatenate([getattr(one, name) for one in self.records]) for name in "tyu")
        residual = np.concatenate(fit.residuals) * u
        word = self.test.sensed.word
        return binned(
            said("missing {what}", what=word), self.unit, {("time", "s"): t, (word, self.unit): y}, residual, u
        )


def _place(name: str) -> int | None:
    """Place among the values of `MOTION` that an unknown moves; None for what overlies the motion."""
    plain = {"dk": "k", "dc": "c"}.get(name.split("@")[0], name.split("@")[0])
    return MOTION.index(plain) if plain in MOTION else None


def decay(test: DecayTest, *, rng: np.random.Generator, sample: str = "") -> Diagnosis:
    """Diagnose a free-decay test: what beside viscous damping and a linear spring shapes the decay, or overlies it.

    Parameters
    ----------
    test : DecayTest
        As for `decay.analyse`.
    rng : Generator
        For bootstrap intervals.
    sample : str
        Id of the sample, for the result.

    Raises
    ------
    MetrologyError
        Where no record holds a decay.
    """
    prepared = Decay(test)
    posed = prepared.subject(sample)
    found = rank(posed, rng=rng, test=test.name)
    overlays = tuple(overlying(posed, found, prepared))
    return replace(with_overlays(sought_apart(found), overlays), failures=(*prepared.failures, *found.failures))
