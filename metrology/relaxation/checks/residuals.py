"""Check of what the most probable form leaves of the records: slow residuals, a misfit, a slip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from metrology.check import Check
from metrology.message import said
from metrology.relaxation.checks.done import Done
from metrology.relaxation.noise import cosines
from metrology.relaxation.slips import Slip, slip
from metrology.relaxation.test import RelaxationTest

RESIDUALS = "residuals"
SLOW = 2.0
"""Variance of slow residuals over that of all that passes: the colour of a noise is known to about a factor of two."""
LARGE, PARTS, ALIKE = 5.0, 1e-3, 0.5
"""Residuals over what the scatter from reading to reading leaves of the same means, their part of the range of the
answer, and the correlation of neighbours, that together are a misfit. A sound cell wanders by less than 0.1 % of its
reading. Noise with a memory of seconds is 5 to 50 times the white noise of such means, but has forgotten itself from
one to the next: 0.3 at most, where a slip, or levels of unlike stiffness, leave 0.6 to 0.9."""


def residuals(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Slow residuals of the most probable form, against all of them: Fisher's F of their variances, over `SLOW`."""
    from scipy.special import fdtrc

    worst, name, p_least = 0.0, "", 1.0
    for one in done:
        n, q = len(one.best.model), len(one.best.values)
        low = cosines(n, q)
        p = float(fdtrc(low, n - q, one.best.excess / SLOW))
        if p <= p_least:
            worst, name, p_least = one.best.excess, one.mounting.name, p
    p_least = test.adjusted(p_least, len(done))
    causes = said(
        "the specimen is not linear viscoelastic over its levels, a grip slips, the crosshead has backlash, or the "
        "noise has a colour of its own"
    )
    slipped = _slipped(test, done)
    if p_least < test.significance:
        sentence = said(
            "The most probable form leaves slow residuals in {specimen}, {times:.2g} times the variance of its noise: "
            "{causes}. Intervals are wider by that.",
            specimen=name,
            times=float(worst),
            causes=causes,
        )
        return Check(RESIDUALS, worst, p_least, False, _both(sentence, slipped))
    # The colour of the noise is found with the form, and takes what no form explains: newtons do not follow it.
    for one in done:
        part, ratio, alike = _misfit(test, one)
        if part > PARTS and ratio > LARGE and alike > ALIKE:
            sentence = said(
                "The most probable form misses {specimen} by {part:.2g} % of the range of the answer, {ratio:.2g} "
                "times what the scatter from reading to reading leaves, and alike from one mean to the next: {causes}. "
                "It is taken for slow noise.",
                specimen=one.mounting.name,
                part=100 * part,
                ratio=ratio,
                causes=causes,
            )
            return Check(RESIDUALS, part, None, False, _both(sentence, slipped))
    if slipped:
        return Check(RESIDUALS, worst, p_least, False, slipped)
    return Check(RESIDUALS, worst, p_least, True, said("What the most probable form leaves is noise."))


def _both(sentence: str, slipped: str) -> str:
    return said("{texts:space}", texts=(sentence, slipped)) if slipped else sentence


def _slipped(test: RelaxationTest, done: Sequence[Done]) -> str:
    """Sentence of the most probable slip; empty where none is.

    Odds that none makes as large as 1/p have at most the probability p (Markov's inequality: their mean is 1).
    """
    force = test.held == "elongation"
    unit = "N" if force else "" if test.by_strain else "m"
    found: list[tuple[Slip, str]] = []
    for one in done:
        of = one.scene.answer.of
        seen = slip(one.best, one.noise, one.levels, of.y, of.begin)
        if seen is not None and test.adjusted(float(np.exp(-seen.odds)), len(done)) < test.significance:
            found.append((seen, one.mounting.name))
    if not found:
        return ""
    worst, name = max(found, key=lambda each: each[0].odds)
    strain = (
        "What answered steps by {size:+.3g} within a hold, at about {time:.4g} s ({specimen}): a grip or a mark "
        "slipped, or the cell was knocked."
    )
    step = (
        "What answered steps by {size:+.3g} {unit} within a hold, at about {time:.4g} s ({specimen}): a grip or a mark "
        "slipped, or the cell was knocked."
    )
    return said(step if unit else strain, size=worst.size, unit=unit, time=worst.time, specimen=name)


def _misfit(test: RelaxationTest, one: Done) -> tuple[float, float, float]:
    """Residuals over the range of the answer, over white noise as from reading to reading, correlation of neighbours.

    Root mean squares over time: means over blocks count by their readings.
    """
    of = one.scene.answer.of
    readings = one.mounting.force if test.held == "elongation" else one.mounting.stretch
    # The median of |difference| of two readings is 0.954 standard deviations of one.
    white = float(np.median(np.abs(np.diff(readings)))) / 0.9539
    rest, count = of.y - one.best.model, of.count.astype(float)
    size = float(np.sqrt((count * rest**2).sum() / count.sum()))
    expected = max(white * float(np.sqrt(len(count) / count.sum())), 1e-300)
    weighed = np.sqrt(count) * rest
    alike = float(weighed[1:] @ weighed[:-1] / max(weighed @ weighed, 1e-300))
    return size / (float(np.ptp(of.y)) or 1.0), size / expected, alike
