"""What overlies a motion and is sought in every record by itself: lines, mains, slow motion, steps of a reading."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import logsumexp

from metrology.decay.hop import Hop, jumps
from metrology.diagnosis import Cause, Diagnosis, Value, Verdict
from metrology.diagnostics.candidate import DECAY as TABLE
from metrology.diagnostics.intervals import NORMAL_95
from metrology.diagnostics.judged import FAR, LIKELY
from metrology.diagnostics.likelihood import Noise, noise, slow_motion, spread_out
from metrology.diagnostics.plain import Plain
from metrology.diagnostics.probability import logistic
from metrology.diagnostics.release import STEPS
from metrology.diagnostics.span import orthonormal
from metrology.diagnostics.subject import Array, Fit
from metrology.diagnostics.supported import spread
from metrology.diagnostics.verdict_sentences import EITHER, followed
from metrology.message import said

if TYPE_CHECKING:
    from metrology.diagnostics.decay import Decay
    from metrology.diagnostics.release import Line, Record
    from metrology.estimation.step import Step

MOST = 690.0
"""Ln of the largest Bayes factor that is given, as of the causes that were fitted."""
ALIKE = 2.0
"""Frequencies within so many 1/T of the longest record are one: as near as two lines can be told apart."""
TURNS = 2.0
"""Turns below which an oscillation is slow motion: what drifts or steps has such lines."""
PLACES = 100
"""Places of a record at which a step of the reading is tried."""
APART = ("drift", "hop", "mains", "other")
"""What is sought in every record by itself, before the fit or under it."""


@dataclass(frozen=True)
class Overlay:
    """Something that overlies the motion: which candidate, how large, and the ln evidence for it over none."""

    effect: str
    values: tuple[Value, ...]
    sentence: str
    log_bayes: float
    alike: tuple[Overlay, ...] = ()
    """What does nearly as well in its place."""

    @property
    def probability(self) -> float:
        """As probable beforehand as not, and as each of those in its place."""
        return logistic(self.log_bayes - float(logsumexp([0.0, *(one.log_bayes for one in self.alike)])))

    @property
    def group(self) -> tuple[str, ...]:
        """Names of those that do as well, the most probable first."""
        return (self.effect, *(one.effect for one in self.alike))


def overlying(posed: Plain, found: Diagnosis, prepared: Decay) -> Iterator[Overlay]:
    """What overlies the decays, beside all effects that may be there where these explain the readings."""
    yield from lines(prepared)
    fit = None
    if found.verdict in ("nothing missing", "explained", "ambiguous"):
        model = found.extended_model
        carried = tuple(name for name in found.possible if any(one.name in model for one in TABLE[name].parameters))
        fit = posed.fit(carried, [model])
    if fit is None:
        # What no listed effect explains moves the mean of the motion as well as anything: no slow motion is sought.
        yield from hops(prepared, None)
        return
    misfit = next((one.statistic for one in found.tests if one.name == "misfit"), 1.0)
    columns = np.vstack([part * used[:, None] for part, used in zip(spread_out(fit), fit.used, strict=True)])
    # Noise that lies along the slow motion is not in what the fit leaves: a quiet of its own making shows no drift.
    by = replace(noise(fit, fit.full, posed.floor, orthonormal(columns)), misfit=misfit)
    yield from hops(prepared, (fit, spread(fit, by)))
    yield from slow(fit, by, posed, prepared)


def lines(prepared: Decay) -> Iterator[Overlay]:
    """Oscillations of one frequency that were found in at least half of the records."""
    records = prepared.records
    for key, is_mains in (("mains", True), ("other", False)):
        every = [(one, line) for one in records for line in one.lines
                 if line.is_mains == is_mains and line.turns >= TURNS]  # fmt: skip
        # What has another frequency in every record is no oscillation, but what something else leaves in its spectrum.
        alike = [_near(every, line.frequency, ALIKE / prepared.longest) for _, line in every]
        own = max(alike, key=lambda near: (_among(near), sum(_of_line(*one) for one in near)), default=[])
        among = _among(own)
        if not own or 2 * among < len(records):
            continue
        largest = max((line for _, line in own), key=lambda one: one.amplitude)
        values = (Value(f"{key}.frequency", largest.frequency, math.nan, "Hz", None, None),
                  Value(f"{key}.amplitude", largest.amplitude, math.nan, prepared.unit, None, None))  # fmt: skip
        # A single release is looked at in two parts.
        text = "Found in {among} of {records} records and removed before the fit."
        words = said(text, among=among, records=len(records))
        if prepared.releases <= 1:
            words = said("Found in the record and removed before the fit.")
        found = Overlay(key, values, words, sum(_of_line(*one) for one in own))
        if found.probability > LIKELY:
            yield found


def _near(every: Sequence[tuple[Record, Line]], frequency: float, width: float) -> list[tuple[Record, Line]]:
    return [(one, line) for one, line in every if abs(line.frequency - frequency) <= width]


def _among(own: Sequence[tuple[Record, Line]]) -> int:
    return len({one.name for one, _ in own})


def hops(prepared: Decay, fitted: tuple[Fit, Array] | None) -> Iterator[Overlay]:
    """Steps that were taken out of any record, where they are there in the fit, too; with it standard uncertainties.

    Lines beside the decay, as of a line that goes slack for a part of each period, are a step before they have a name.
    """
    every = [(one, name, hop) for one in prepared.records for name, (hop, _) in zip(STEPS, one.steps, strict=False)]
    found = [(one.name, hop if fitted is None else _again(hop, f"{name}@{one.name}", one, *fitted))
             for one, name, hop in every]  # fmt: skip
    found = [(name, hop) for name, hop in found if hop.log_bayes > 0]
    if found:
        values = (largest_step([hop for _, hop in found], prepared.unit),)
        text = "{size:.3g} µ{unit} at {time:.4g} s in {record}"
        words = tuple(
            said(text, size=float(1e6 * hop.size), unit=prepared.unit, time=float(hop.time), record=name)
            for name, hop in found
        )
        evidence = sum(hop.log_bayes for _, hop in found)
        yield Overlay("hop", values, said("Found and taken out before the fit: {hops}.", hops=words), evidence)


def _again(hop: Hop, name: str, record: Record, fit: Fit, u: Array) -> Hop:
    """A step that was taken out, as large as a fit says: `name` is what it is more."""
    at = fit.index(name)
    assert at is not None
    size, wide = hop.size + float(fit.theta[at]), math.hypot(float(u[at]), record.rounding)
    return Hop(hop.time, size, 0.5 * (size / wide) ** 2 - 1.5 * math.log(len(record.t) * record.per_block), wide)


def largest_step(steps: Sequence[Hop | Step], unit: str) -> Value:
    """Size of the largest step of a reading, with its 95 % interval where its u is known."""
    largest = max(steps, key=lambda one: abs(one.size))
    wide = NORMAL_95 * largest.u
    ends = (largest.size - wide, largest.size + wide) if math.isfinite(wide) else (None, None)
    return Value("hop", largest.size, largest.u, unit, *ends)


def _of_line(record: Record, line: Line) -> float:
    """Ln evidence of a line over the noise beside it; amplitude, phase and frequency have a price (`sets.price`)."""
    count = len(record.t) * record.per_block
    return 0.25 * count * line.lasts * (line.amplitude / line.noise) ** 2 - 1.5 * math.log(count) - math.log(count / 2)


def slow(fit: Fit, by: Noise, posed: Plain, prepared: Decay) -> Iterator[Overlay]:
    """Slow motion under the decay, where the polynomial that every record is given has more evidence than none.

    A step of the reading that was too small to be taken out is followed by the polynomial as well, in part: it is
    slow motion where steps do far worse, steps where these do far better, and else one of the two.
    """
    drift, stepped = _drift(fit, by, posed, prepared), _stepped(fit, by, posed, prepared)
    best, other = sorted((drift, stepped), key=lambda one: -one.log_bayes)
    if best.log_bayes > FAR:
        yield best if best.log_bayes > other.log_bayes + FAR else replace(best, alike=(other,))


def _drift(fit: Fit, by: Noise, posed: Plain, prepared: Decay) -> Overlay:
    """Slow motion by the coefficients of the polynomial, and of what settles."""
    evidence, motions = slow_motion(fit, by, fit.used, posed.slow)
    largest = max(float(np.ptp(motion @ one.slow[1:]))
                  for one, motion in zip(prepared.records, motions, strict=True))  # fmt: skip
    return Overlay(
        "drift", (Value("drift", largest, math.nan, prepared.unit, None, None),),
        said("Found in the records, and fitted together with the decay."), float(evidence.max()),
    )  # fmt: skip


def _stepped(fit: Fit, by: Noise, posed: Plain, prepared: Decay) -> Overlay:
    """Steps of the reading in the place of the polynomial: in each record one or none, as probable beforehand.

    A step has a size, with the price of unit information, and a place: every one is as probable beforehand, and of a
    small step many are nearly as good as the best.
    """
    root, precision = 1.0 / math.sqrt(by.misfit), np.sqrt(fit.problem.precision)
    moving = [at for one in posed.slow for at in one.places(fit)]
    rest = [at for at in range(len(fit.theta)) if at not in moving]
    J = np.vstack([root * by.whitened(fit, spread_out(fit), fit.used), np.diag(precision)])
    r = np.concatenate([root * by.whitened(fit, fit.full, fit.used), precision * (fit.theta - fit.problem.mean)])
    r, taken = r - J[:, moving] @ fit.theta[moving], orthonormal(J[:, rest])
    r = r - taken @ (taken.T @ r)
    largest, evidence = (0.0, 0.0), 0.0
    for at, one in enumerate(prepared.records):
        places = np.linspace(0, len(one.t), PLACES + 2)[1:-1].astype(int)
        rows = [np.zeros((len(part), len(places))) for part in fit.residuals]
        rows[at] = -1.0 * (np.arange(len(one.t))[:, None] >= places) / one.u[:, None]
        columns = np.vstack([root * by.whitened(fit, tuple(rows), fit.used), np.zeros((len(precision), len(places)))])
        columns = columns - taken @ (taken.T @ columns)
        information = np.maximum(np.sum(columns**2, axis=0), 1e-300)
        size = -(columns.T @ r) / information
        gains = size**2 / (1.0 / information + one.rounding**2)
        best = int(np.argmax(gains))
        found = float(logsumexp(0.5 * gains)) - math.log(len(places)) - 0.5 * math.log(len(one.t))
        gap = len(one.t) // PLACES
        near = range(places[best] - gap, places[best] + gap + 1)
        there = jumps(fit.residuals[at] * one.u, near, float(size[best]))
        evidence += float(np.logaddexp(0.0, found if there else -math.inf)) - math.log(2)
        if there and found > 0:
            largest = max(largest, (abs(float(size[best])), 1.0 / math.sqrt(float(information[best]))))
    value, u = largest
    ends = (value - NORMAL_95 * u, value + NORMAL_95 * u)
    return Overlay(
        "hop", (Value("hop", value, u, prepared.unit, *ends),),
        said("Found in the records in the place of slow motion; the largest of them is stated."), evidence,
    )  # fmt: skip


def _step(found: Diagnosis, groups: Sequence[tuple[str, ...]]) -> Verdict:
    """Step of the ladder with what overlies the motion."""
    if found.verdict not in ("nothing missing", "explained"):
        return found.verdict
    return "ambiguous" if groups else "explained"


def sought_apart(found: Diagnosis) -> Diagnosis:
    """Say of what is sought beside the fit, in every record by itself, that it was, where the fit cannot test it."""
    not_found = said("Tested in every record by itself, and not found.")
    unsized = said("Tested in every record by itself: no smallest size is stated beforehand.")
    causes = [
        replace(one, verdict="not supported", sentence=not_found)
        if one.effect in APART and one.verdict == "not testable" else one for one in found.causes
    ]  # fmt: skip
    sizes = [
        replace(one, sentence=unsized)
        if one.effect in APART and one.size is None else one for one in found.detectable
    ]  # fmt: skip
    return replace(found, causes=tuple(causes), detectable=tuple(sizes))


def _found(cause: Cause, one: Overlay) -> Cause:
    """Cause of which an overlay was found."""
    return replace(
        cause, verdict="indistinguishable" if one.alike else "supported", probability=one.probability,
        parameters=one.values, log_bayes=min(one.log_bayes, MOST), sentence=one.sentence,
    )  # fmt: skip


def with_overlays(found: Diagnosis, overlays: Sequence[Overlay]) -> Diagnosis:
    """Name what overlies the motion, whatever shapes it."""
    causes = list(found.causes)
    # A diagnosis that failed lists no causes.
    certain = {one.effect for one in overlays if not one.alike}
    overlays = [one for one in overlays if one.effect in {cause.effect for cause in causes}
                and not (one.alike and certain & {*one.group})]  # fmt: skip
    if not overlays:
        return found
    named: list[str] = []
    groups = tuple(one.group for one in overlays if one.alike)
    places = {cause.effect: at for at, cause in enumerate(causes)}
    titles = {cause.effect: said("{title:lowered} ({name})", title=cause.title, name=cause.effect) for cause in causes}
    for one in overlays:
        at = places[one.effect]
        if causes[at].verdict in ("supported", "indistinguishable"):
            # Another line than the one that the fit named, which keeps its size and what it is worth.
            sizes = ", ".join(f"{value.name.partition('.')[2]} {value.value:.3g} {value.unit}" for value in one.values)
            words = said("Another one ({sizes:figures}): {sentence}", sizes=sizes, sentence=one.sentence)
            causes[at] = replace(causes[at], sentence=followed(causes[at].sentence, words))
        else:
            causes[at] = _found(causes[at], one)
        text = titles[one.effect]
        if one.alike:
            text = said(EITHER, titles=tuple(titles[name] for name in one.group))
            for other in one.alike:
                at = places[other.effect]
                causes[at] = _found(causes[at], replace(other, alike=(replace(one, alike=()),)))
        named += [text] if text not in named else []
    clean = found.verdict == "nothing missing"
    text = said(
        "Found in the records in addition to the motion, and separated from it: {named:comma}.", named=tuple(named)
    )
    causes.sort(key=lambda one: one.verdict not in ("supported", "indistinguishable"))
    return replace(
        found, verdict=_step(found, groups), causes=tuple(causes), groups=(*found.groups, *groups),
        sentence=text if clean else followed(text, found.sentence),
    )  # fmt: skip
