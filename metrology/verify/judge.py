"""The verdict on a run, and the rule behind it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from metrology.message import Sentence, said
from metrology.verify.finding import PhaseScore, Verdict

Array = NDArray[np.float64]

SHARE, RATIO, EXCESS, REACH, COARSE = 0.90, 1.05, 5.0, 4.0, 0.5
FEWEST = 5
"""Readings below which nothing is said of residuals."""
ESTIMATED = 0.02
"""Relative standard uncertainty of the variance of the noise, which is estimated."""
BLOCKS = (5, 20, 80, 320)
"""Lengths, in readings, over which residuals are averaged to find what noise cannot do."""

RULE = said(
    "The run's own inputs (thrust, start, taut position …) are re-estimated within their priors. Validated within "
    "u_val when the residuals are then noise in every channel and phase (RMS at most 1.05 times the noise, or not "
    "significantly more, and no slow part beyond 5 standard deviations of noise, white or of its colour) and those "
    "inputs lie within 4 of their standard uncertainties; where nothing can be re-estimated, when |E| ≤ 2·u_val for "
    "at least 90 % of the readings of every channel (ASME V&V 20). The share of the predicted readings with "
    "|E| ≤ 2·u_val is stated too: errors of one thrust or start are the same over a whole run, so that one run in "
    "twenty lies outside for most of its length though the model is right. Not testable where u_val exceeds half of "
    "the signal in every channel, or the line never pulls. No metric decides alone, and none is averaged with another."
)


def excess(whitened: Array) -> float:
    """Largest slow part of white residuals of unit size, in standard deviations of what noise does.

    For blocks of L readings, z = (Σ_blocks L·r̄² − n)/√(2·n), n blocks; the largest over several L; 0 for too few.
    """
    found = [0.0]
    for length in BLOCKS:
        count = len(whitened) // length
        if count < 3:
            continue
        means = whitened[: count * length].reshape(count, length).mean(axis=1)
        found.append((length * float(means @ means) - count) / math.sqrt(2.0 * count))
    return max(found)


def above(residuals: Array, alike: float) -> float:
    """How far the mean square of residuals of unit size is above the noise, in standard deviations of what noise does.

    The variance of a mean square of n readings is 2·Σρ²/n, with ρ their autocorrelation; 2 % are for the noise itself
    being estimated.

    Parameters
    ----------
    residuals : ndarray, shape (n,)
        Over the noise.
    alike : float
        Σρ² over all lags.
    """
    if len(residuals) < FEWEST:
        return 0.0
    return (float(np.mean(residuals**2)) - 1.0) / math.hypot(math.sqrt(2.0 * alike / len(residuals)), ESTIMATED)


def judge(scores: Sequence[PhaseScore], own: Sequence[tuple[str, float, float]], pulls: bool) -> tuple[Verdict, str]:
    """Verdict on one run and the sentence that gives its reason; the rule is `RULE`."""
    whole = [score for score in scores if score.name == "all"]
    if not pulls:
        return "not testable", said("not testable: the line never pulls in this run")
    testable = [score for score in whole if score.testable]
    if not testable:
        return "not testable", said("not testable: u_val exceeds half of the signal in every channel")
    closed = any(score.closed_rms is not None for score in scores)
    for reason in (_structured(scores), _far(own)) if closed else (_outside(testable),):
        if reason:
            return "not validated", said("not validated: {reason}", reason=reason)
    share = min(score.share or 0.0 for score in testable)
    return "validated within u_val", _validated(100 * share, closed, own if share < SHARE else ())


def _validated(share: float, closed: bool, blamed: Sequence[tuple[str, float, float]]) -> Sentence:
    """Why a run validates the model, and which of its own inputs makes it lie outside where many readings do."""
    if not closed:
        text = (
            "validated within u_val: in prediction, |E| ≤ 2·u_val for at least {share:.0f} % of the readings of every "
            "channel"
        )
        return said(text, share=share)
    if not blamed:
        text = (
            "validated within u_val: with the run's own inputs re-estimated nothing but noise is left in any phase; in "
            "prediction, |E| ≤ 2·u_val for at least {share:.0f} % of the readings of every channel"
        )
        return said(text, share=share)
    name, _, distance = max(blamed, key=lambda entry: abs(entry[2]))
    text = (
        "validated within u_val: with the run's own inputs re-estimated nothing but noise is left in any phase; in "
        "prediction, |E| ≤ 2·u_val for at least {share:.0f} % of the readings of every channel, since its {name} lies "
        "{distance:.1f} standard uncertainties from what is stated"
    )
    return said(text, share=share, name=name, distance=float(abs(distance)))


def _outside(whole: Sequence[PhaseScore]) -> str:
    worst = min(whole, key=lambda score: score.share if score.share is not None else 1.0)
    if worst.share is None or worst.share >= SHARE:
        return ""
    text = "{channel} has |E| ≤ 2·u_val for only {share:.0f} % of its readings"
    return said(text, channel=worst.channel, share=100 * worst.share)


def _structured(scores: Sequence[PhaseScore]) -> str:
    def size(score: PhaseScore) -> float:
        return max(score.closed_excess or 0.0, score.closed_above or 0.0)

    bad = [score for score in scores if score.closed_rms is not None and size(score) > EXCESS]
    bad = [score for score in bad if (score.closed_excess or 0) > EXCESS or (score.closed_rms or 0) > RATIO]
    if not bad:
        return ""
    worst = max((score for score in bad if score.name != "all"), key=size, default=max(bad, key=size))
    slow = (worst.closed_excess or 0.0) > (worst.closed_above or 0.0)
    text = (
        "with the run's own inputs re-estimated, the residuals of {channel} in the phase '{phase}' have a slow part, "
        "{size:.0f} standard deviations more than noise does"
        if slow
        else "with the run's own inputs re-estimated, the residuals of {channel} in the phase '{phase}' are "
        "{rms:.2f} times the noise, {size:.0f} standard deviations more than noise does"
    )
    rms = worst.closed_rms or 0.0
    return said(text, channel=worst.channel, phase=worst.name, rms=rms, size=float(size(worst)))


def _far(own: Sequence[tuple[str, float, float]]) -> str:
    far = [entry for entry in own if abs(entry[2]) > REACH]
    if not far:
        return ""
    name, value, distance = max(far, key=lambda entry: abs(entry[2]))
    text = "it takes {name} = {value:.4g}, {distance:.1f} standard uncertainties from what is stated"
    return said(text, name=name, value=float(value), distance=float(abs(distance)))


def overall(verdicts: Sequence[tuple[str, Verdict]]) -> tuple[Verdict, str]:
    """Verdict on a sample: not validated where any run is not; validated where the rest are, one at least."""
    by = {verdict: [name for name, one in verdicts if one == verdict] for _, verdict in verdicts}
    if failed := by.get("not validated"):
        text = "not validated: {count} of {whole} held-out runs ({names:comma})"
        return "not validated", said(text, count=len(failed), whole=len(verdicts), names=tuple(failed))
    if passed := by.get("validated within u_val"):
        text = "validated within u_val on {count} of {whole} held-out runs"
        return "validated within u_val", said(text, count=len(passed), whole=len(verdicts))
    return "not testable", said("not testable: no held-out run can tell")
