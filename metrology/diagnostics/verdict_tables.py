"""Tables of a diagnosis: tests of effects, what would show, shifts of k and c, parts of the records."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from metrology.diagnosis import Detectable, Part, Remainder, Shift, Supported, Test
from metrology.diagnostics.fits import COARSE
from metrology.diagnostics.judged import LIKELY, Judged
from metrology.diagnostics.subject import Fit, Subject
from metrology.diagnostics.verdict_sentences import law_words
from metrology.message import said

SHOWS = 5.0
"""Distance in standard deviations at which an effect is found nine times in ten at the usual prices."""


def tests_of(judged: Judged) -> tuple[Test, ...]:
    """What the two judgements rest on: whether a listed effect is missing, and whether something unlisted is."""
    none = judged.nothing
    nothing = not judged.last.effects
    text = (
        "The probability that no listed effect is missing is {p:figures}."
        if nothing
        else "The probability that a listed effect is missing is {p:figures}."
    )
    misfit = (
        "Where the unknowns act, the mean square of what no listed effect explains is {times:.3g} times that of the "
        "noise (limit {limit:g}); uncertainties are larger by the root of that."
    )
    unlisted = "The probability of an unlisted {law} in addition to the model is {p:figures}."
    found = [
        Test(
            said("listed effects"), 1.0 - none, LIKELY, none, LIKELY, nothing,
            said(text, p=_probability(none if nothing else 1 - none)),
        ),
        Test(
            said("misfit"), judged.misfit, COARSE, math.nan, math.nan, judged.misfit <= COARSE,
            said(misfit, times=float(judged.misfit), limit=COARSE),
        ),
    ]  # fmt: skip
    if judged.heavy > LIKELY:
        normal = said("The probability that the noise has heavy tails is {p:figures}.", p=_probability(judged.heavy))
        found.append(Test(said("normal noise"), judged.heavy, LIKELY, 1.0 - judged.heavy, LIKELY, False, normal))
    if judged.law is not None:
        found.append(
            Test(
                said("unlisted law"), judged.unlisted, LIKELY, 1.0 - judged.unlisted, LIKELY, judged.unlisted <= LIKELY,
                said(unlisted, law=law_words(judged.law.family), p=_probability(judged.unlisted)),
            )
        )  # fmt: skip
    return tuple(found)


def _probability(p: float) -> str:
    if p < 1e-6:
        return "< 10⁻⁶"
    return f"{p:.3f}" if p <= 0.9995 else "> 0.999"


def remainder_of(judged: Judged, subject: Subject) -> Remainder | None:
    """What no listed effect explains."""
    if judged.verdict not in ("unexplained", "explained in the main"):
        return None
    law = judged.law if judged.unlisted > LIKELY else None
    unit = "" if law is None else subject.unit_of(law.family)
    return Remainder(
        1.0 - judged.share, None if law is None else law.size, unit, "" if law is None else law_words(law.family)
    )


def detectable(judged: Judged, subject: Subject) -> Iterator[Detectable]:
    """Smallest size of every candidate that shows, by the Fisher information of these runs: needs no reading."""
    for name, candidate in subject.candidates.items():
        found = judged.first.scores.get(name)
        unit = candidate.size.unit
        if found is None and not candidate.is_sought:
            continue
        if found is None or not found.d > 0:
            words = said("Would not show at any size.")
            yield Detectable(name, candidate.title, candidate.size.name, None, unit, words)
            continue
        size = candidate.size.amount(abs(found.amount), SHOWS / found.d)
        null = candidate.size.null
        text = (
            "{name} that differs from {null:g} by {size:.2g}{unit} would show ({times:g} standard deviations); less "
            "would not."
            if null
            else "{name} of {size:.2g}{unit} would show ({times:g} standard deviations); less would not."
        )
        words = said(
            text, name=candidate.size.name, null=float(null), size=float(size),
            unit="" if unit == "1" else f" {unit}", times=SHOWS,
        )  # fmt: skip
        yield Detectable(name, candidate.title, candidate.size.name, size, unit, words)


def shifts_of(judged: Judged, found: Supported | None) -> tuple[Shift, ...]:
    """What the extension does to the common unknowns that have no prior, and to k and c also where they are given."""
    if found is None:
        return ()
    rows = []
    for name, unit, after, u_after, before, u in zip(
        found.names, found.units, found.values, found.u, found.stated, found.stated_u, strict=True
    ):
        at = judged.base.index(name)
        entry = None if at is None else judged.base.problem.unknowns[at]
        if entry is None or (entry.u is not None and name not in ("k", "c")):
            continue
        if entry.mean is not None and entry.u is not None:
            # What was given is what the model as it stands works with, not where its fit was drawn to.
            before, u = entry.mean, entry.u
        rows.append(Shift(name, unit, before, u, after, u_after, (after - before) / max(u, 1e-300)))
    return tuple(rows)


def parts_of(judged: Judged, subject: Subject) -> tuple[Part, ...]:
    """Residuals over noise by run, channel and phase."""
    spans = subject.parts(judged.last)
    found = []
    for at, block in enumerate(judged.base.problem.blocks):
        for segment in block.segments:
            own = slice(segment.first, segment.last)
            used = judged.base.used[at][own] & judged.last.used[at][own]
            for phase, marks in spans.get((block.name, segment.name), ()):
                chosen = used & marks
                if chosen.any():
                    sizes = [_rms(one, at, own, chosen) for one in (judged.base, judged.last)]
                    found.append(Part(block.name, segment.name, phase, int(chosen.sum()), *sizes))
    return tuple(found)


def _rms(fit: Fit, at: int, own: slice, chosen: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> float:
    return float(np.sqrt(np.mean(fit.full[at][own][chosen] ** 2)))
