"""What overlies a free decay and is sought in every record by itself: lines, mains, slow motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from metrology.decay.oscillation import DEGREE
from metrology.diagnose.candidate import DECAY as TABLE
from metrology.diagnose.plain import Plain
from metrology.diagnosis import Diagnosis, Value
from metrology.identify.covariance import inverse

if TYPE_CHECKING:
    from metrology.diagnose.decay import Decay

SLOW, SLOW_BESIDE = 1e-3, 1e-8
"""Chance of as large a slow motion from noise alone, below which it is reported; together with another effect, whose
own small error (where dry friction holds the mass) looks like one."""
APART = ("drift", "mains", "other")
"""What is sought in every record by itself, before the fit or under it."""


@dataclass(frozen=True)
class Overlay:
    """Something beside the decay: which candidate, how large, and whether the evaluation leaves it in the records."""

    effect: str
    values: tuple[Value, ...]
    sentence: str
    stays: bool = False


def lines(prepared: Decay) -> Iterator[Overlay]:
    """Oscillations that were found in at least half of the records."""
    records = prepared.records
    for key, is_mains in (("mains", True), ("other", False)):
        own = [(one.name, *line) for one in records for line in one.others if line[2] == is_mains]
        among = len({one[0] for one in own})
        if not own or 2 * among < len(records):
            continue
        largest = max(own, key=lambda one: one[2])
        values = (Value(f"{key}.frequency", largest[1], math.nan, "Hz", None, None),
                  Value(f"{key}.amplitude", largest[2], math.nan, prepared.unit, None, None))  # fmt: skip
        # A single release is looked at in two parts.
        where = f"{among} of {len(records)} records" if prepared.releases > 1 else "the record"
        yield Overlay(key, values, f"Found in {where} and taken out before the fit.")


def hum(prepared: Decay, found: Diagnosis) -> Iterator[Overlay]:
    """Mains that only all records together show, and too few of them one by one."""
    known = (*found.possible, *(one.effect for one in lines(prepared)))
    if prepared.hum is None or "mains" in known:
        return
    frequency, size = prepared.hum
    values = (Value("mains.frequency", frequency, math.nan, "Hz", None, None),
              Value("mains.amplitude", size, math.nan, prepared.unit, None, None))  # fmt: skip
    yield Overlay("mains", values, "Found in the records together, too weak to be taken out of each.", stays=True)


def drift(posed: Plain, found: Diagnosis, prepared: Decay) -> Iterator[Overlay]:
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
        yield Overlay("drift", (Value("drift", largest, math.nan, prepared.unit, None, None),), words)


def sought_apart(found: Diagnosis) -> Diagnosis:
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


def with_overlays(found: Diagnosis, overlays: Sequence[Overlay]) -> Diagnosis:
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
