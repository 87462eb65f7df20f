"""What overlies a free decay and is sought in every record by itself: lines, mains, slow motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from metrology.decay.oscillation import DEGREE
from metrology.decay.separation import Separated
from metrology.diagnosis import Diagnosis, Value
from metrology.diagnostics.candidate import DECAY as TABLE
from metrology.diagnostics.intervals import NORMAL_95
from metrology.diagnostics.judgement import LIKELY, logistic
from metrology.diagnostics.likelihood import estimated, noise
from metrology.diagnostics.plain import Plain
from metrology.diagnostics.verdict import followed
from metrology.message import said

if TYPE_CHECKING:
    from metrology.diagnostics.decay import Decay
    from metrology.diagnostics.release import Line, Record

MOST = 690.0
"""Ln of the largest Bayes factor that is given, as of the causes that were fitted."""
APART = ("drift", "hop", "mains", "other")
"""What is sought in every record by itself, before the fit or under it."""


@dataclass(frozen=True)
class Overlay:
    """Something that overlies the decay: which candidate, how large, and the ln evidence for it over none."""

    effect: str
    values: tuple[Value, ...]
    sentence: str
    log_bayes: float

    @property
    def probability(self) -> float:
        """As probable beforehand as not."""
        return logistic(self.log_bayes)


def lines(prepared: Decay) -> Iterator[Overlay]:
    """Oscillations that were found in at least half of the records."""
    records = prepared.records
    for key, is_mains in (("mains", True), ("other", False)):
        own = [(one, line) for one in records for line in one.lines if line.is_mains == is_mains]
        among = len({one.name for one, _ in own})
        if not own or 2 * among < len(records):
            continue
        largest = max((line for _, line in own), key=lambda one: one.amplitude)
        values = (Value(f"{key}.frequency", largest.frequency, math.nan, "Hz", None, None),
                  Value(f"{key}.amplitude", largest.amplitude, math.nan, prepared.unit, None, None))  # fmt: skip
        # A single release is looked at in two parts.
        where = f"{among} of {len(records)} records" if prepared.releases > 1 else "the record"
        found = Overlay(
            key, values, f"Found in {where} and removed before the fit.", sum(_of_line(*one) for one in own)
        )
        if found.probability > LIKELY:
            yield found


def hops(prepared: Decay) -> Iterator[Overlay]:
    """Steps that were taken out of any record."""
    test = prepared.test
    found = [(record.name, hop) for record, parted in zip(test.records, test.separated, strict=True)
             if isinstance(parted, Separated) for hop in parted.hops]  # fmt: skip
    if found:
        largest = max((hop for _, hop in found), key=lambda one: abs(one.size))
        wide = NORMAL_95 * largest.u
        ends = (largest.size - wide, largest.size + wide) if math.isfinite(wide) else (None, None)
        values = (Value("hop", largest.size, largest.u, prepared.unit, *ends),)
        words = "; ".join(f"{1e6 * hop.size:.3g} µ{prepared.unit} at {hop.time:.4g} s in {name}" for name, hop in found)
        evidence = sum(hop.log_bayes for _, hop in found)
        yield Overlay("hop", values, f"Found and taken out before the fit: {words}.", evidence)


def _of_line(record: Record, line: Line) -> float:
    """Ln evidence of a line over the noise beside it; amplitude, phase and frequency have a price (`sets.price`)."""
    count = len(record.t) * float(np.median((record.noise / record.u) ** 2))
    return 0.25 * count * (line.amplitude / line.noise) ** 2 - 1.5 * math.log(count) - math.log(count / 2)


def drift(posed: Plain, found: Diagnosis, prepared: Decay) -> Iterator[Overlay]:
    """Slow motion under the decay, where the polynomial that every record is given has more evidence than none."""
    if found.verdict not in ("nothing missing", "explained", "ambiguous"):
        # What no listed effect explains moves the mean of the motion as well as anything.
        return
    model = found.extended_model
    carried = tuple(name for name in found.possible if any(one.name in model for one in TABLE[name].parameters))
    fit = posed.fit(carried, [model])
    if fit is None:
        return
    misfit = next((one.statistic for one in found.tests if one.name == "misfit"), 1.0)
    theta, spread = estimated(fit, replace(noise(fit, fit.full), misfit=misfit), fit.used)
    largest, evidence = 0.0, np.zeros(2)
    for one in prepared.records:
        rows = [
            at for at in (fit.index(f"level{order}@{one.name}") for order in range(1, DEGREE + 1)) if at is not None
        ]
        level, price = theta[rows], 0.5 * math.log(len(one.t))
        within = spread[np.ix_(rows, rows)] + one.rounding**2 * np.eye(len(rows))
        # A steady drift is looked for by itself as well: it has one coefficient in place of four.
        evidence += (
            0.5 * level[0] ** 2 / within[0, 0] - price,
            0.5 * level @ np.linalg.solve(within, level) - len(rows) * price,
        )
        largest = max(largest, float(np.ptp(np.polynomial.legendre.legval(np.linspace(-1, 1, 50), [0.0, *level]))))
    overlay = Overlay(
        "drift", (Value("drift", largest, math.nan, prepared.unit, None, None),),
        "Found in the records, and fitted together with the decay.", float(evidence.max()),
    )  # fmt: skip
    if overlay.probability > LIKELY:
        yield overlay


def sought_apart(found: Diagnosis) -> Diagnosis:
    """Say of what is sought beside the fit, in every record by itself, that it was, where the fit cannot test it."""
    words = "Tested in every record by itself"
    causes = [
        replace(one, verdict="not supported", sentence=f"{words}, and not found.")
        if one.effect in APART and one.verdict == "not testable" else one for one in found.causes
    ]  # fmt: skip
    sizes = [
        replace(one, sentence=f"{words}: no smallest size is stated beforehand.")
        if one.effect in APART and one.size is None else one for one in found.detectable
    ]  # fmt: skip
    return replace(found, causes=tuple(causes), detectable=tuple(sizes))


def with_overlays(found: Diagnosis, overlays: Sequence[Overlay]) -> Diagnosis:
    """Name what overlies the decay, whatever shapes it."""
    causes = list(found.causes)
    # A diagnosis that failed lists no causes.
    overlays = [one for one in overlays if one.effect in {cause.effect for cause in causes}]
    if not overlays:
        return found
    named: list[str] = []
    for one in overlays:
        at = next(index for index, cause in enumerate(causes) if cause.effect == one.effect)
        if causes[at].verdict in ("supported", "indistinguishable"):
            # Another line than the one that the fit named, which keeps its size and what it is worth.
            sizes = ", ".join(f"{value.name.partition('.')[2]} {value.value:.3g} {value.unit}" for value in one.values)
            causes[at] = replace(causes[at], sentence=f"{causes[at].sentence} Another one ({sizes}): {one.sentence}")
        else:
            causes[at] = replace(
                causes[at], verdict="supported", probability=one.probability, parameters=one.values,
                log_bayes=min(one.log_bayes, MOST), sentence=one.sentence,
            )  # fmt: skip
        named.append(said("{title:lowered} ({name})", title=causes[at].title, name=one.effect))
    clean = found.verdict == "nothing missing"
    text = said(
        "Found in the records in addition to the decay, and separated from it: {named:comma}.", named=tuple(named)
    )
    causes.sort(key=lambda one: one.verdict not in ("supported", "indistinguishable"))
    return replace(
        found, verdict="explained" if clean else found.verdict, causes=tuple(causes),
        sentence=text if clean else followed(text, found.sentence),
    )  # fmt: skip
