"""Checks of the records against what the measurement model supposes, and the words that go with them."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from metrology.check import Check
from metrology.coordinate import SENSED
from metrology.decay.decrement import Decrement
from metrology.decay.finding import DampingShape
from metrology.decay.release import Release, fitted_zeta_u
from metrology.gum.inputs import Input
from metrology.message import said
from metrology.noise import FEW, colour

SEEN = 1e-12
"""Relative change of ζ by a filter below which it is rounding."""
LEVEL = 0.01
"""Probability below which a check is said to fail."""


def checks(releases: Sequence[Release], shape: DampingShape) -> tuple[Check, ...]:
    """Return the checks of a free-decay test, in the order of the evaluation."""
    return (_residuals(releases), _filter(releases), _two_ways(releases), _scatter(releases), _shape(shape))


def _residuals(releases: Sequence[Release]) -> Check:
    """Return whether the direct fit leaves noise, white or of a colour of short memory.

    Neighbouring readings are alike in coloured noise, and show less of it than there is; systematic residuals of a
    motion stand in few bands of the spectrum, and hardly change the noise of its colour.
    """
    left = [(one.separated.fit.residual, one.separated.noise) for one in releases]
    ratios = [
        float(rest.std()) / max(noise, colour([rest]).deviation if len(rest) >= FEW else 0.0, 1e-300)
        for rest, noise in left
    ]
    worst = max(ratios)
    passed = worst < 1.3
    text = (
        "The direct fit leaves {worst:.2f} times the noise of the sensor (worst record): nothing of size is left over."
        if passed
        else "The direct fit leaves {worst:.2f} times the noise of the sensor (worst record): something in the record "
        "is not in the model."
    )
    return Check("residuals of the direct fit", worst, None, passed, said(text, worst=worst))


def _filter(releases: Sequence[Release]) -> Check:
    """Return what filter and peaks do to ζ of the fitted clean decay."""
    found = [(one.bias, one.decrement.zeta_u) for one in releases if one.decrement is not None]
    if not found:
        text = said("No record was filtered: by direct fit alone.")
        return Check("effect of the filter on ζ", None, None, None, text)
    worst, u = max(found, key=lambda one: abs(one[0]))
    ratio = abs(worst) / max(u, 1e-300)
    differs = said(
        "by {worst:+.1e} (worst record), {ratio:.1g} of the standard uncertainty of one record",
        worst=float(worst),
        ratio=float(ratio),
    )
    if abs(worst) < SEEN:
        differs = said("by less than {least:.0e}", least=SEEN)
    words = (
        "The fitted clean decay, passed through the same filter and peaks, comes out with a ζ that differs {differs}."
        if ratio < 0.1
        else "The fitted clean decay, passed through the same filter and peaks, comes out with a ζ that differs "
        "{differs}: too much."
    )
    return Check("effect of the filter on ζ", worst, None, ratio < 0.1, said(words, differs=differs))


def _apart(releases: Sequence[Release]) -> tuple[float, float, float]:
    """Return the mean difference of ζ between both ways, its u and its p-value, over the records with peaks."""
    from scipy.special import ndtr, stdtr

    both: list[tuple[Decrement, Release]] = [(one.decrement, one) for one in releases if one.decrement is not None]
    apart = np.array([peaks.zeta - one.fitted_zeta for peaks, one in both])
    mean, count = float(apart.mean()), len(apart)
    if count > 1:
        u = max(float(apart.std(ddof=1)) / sqrt(count), 1e-300)
        return mean, u, 2 * float(stdtr(count - 1, -abs(mean) / u))
    peaks, one = both[0]
    u = max(sqrt(peaks.zeta_u**2 + fitted_zeta_u(one.separated.fit) ** 2), 1e-300)
    return mean, u, 2 * float(ndtr(-abs(mean) / u))


def agree(releases: Sequence[Release]) -> bool:
    """Whether log decrement and direct fit give the same ζ, by the differences within each record."""
    return _apart(releases)[2] >= LEVEL


def _two_ways(releases: Sequence[Release]) -> Check:
    """Return whether log decrement and direct fit agree."""
    if all(release.decrement is None for release in releases):
        text = said("No record has the peaks that a log decrement takes: there is one way only, the direct fit.")
        return Check("log decrement against direct fit", None, None, None, text)
    mean, u, p = _apart(releases)
    words = (
        "ζ by the log decrement less ζ by the direct fit is {mean:+.1e} ± {u:.1e} (standard uncertainty): the two "
        "methods disagree. The difference is a component of the uncertainty."
        if p < LEVEL
        else "ζ by the log decrement less ζ by the direct fit is {mean:+.1e} ± {u:.1e} (standard uncertainty): the two "
        "methods agree. The difference is within their noise."
        if is_noise(releases)
        else "ζ by the log decrement less ζ by the direct fit is {mean:+.1e} ± {u:.1e} (standard uncertainty): the two "
        "methods agree. The difference is a component of the uncertainty."
    )
    text = said(words, mean=mean, u=u)
    return Check("log decrement against direct fit", mean / u, p, p >= LEVEL, text, covered=True)


def is_noise(releases: Sequence[Release]) -> bool:
    """Whether the noise within the releases explains how they scatter, ζ and ω_d by direct fit."""
    from scipy.special import chdtrc

    if len(releases) < 2:
        return True
    zeta = [(one.fitted_zeta, fitted_zeta_u(one.separated.fit)) for one in releases]
    omega = [(one.fitted[0][1], sqrt(one.fitted[1][1, 1])) for one in releases]
    chances = []
    for value, u in (np.array(zeta).T, np.array(omega).T):
        spread = np.maximum(u, 1e-150)
        squares = float((((value - np.average(value, weights=spread**-2.0)) / spread) ** 2).sum())
        chances.append(float(chdtrc(len(releases) - 1, squares)))
    return min(chances) >= LEVEL


def _scatter(releases: Sequence[Release]) -> Check:
    """Return whether the releases scatter by more than the noise within them explains."""
    from scipy.special import chdtrc

    if len(releases) < 2:
        text = said("One release only: nothing is known of the repeatability.")
        return Check("scatter between releases", None, None, None, text)
    peaks = [one.decrement for one in releases if one.decrement is not None]
    by_peaks = len(peaks) == len(releases)
    zeta = np.array([one.zeta for one in peaks] if by_peaks else [one.fitted_zeta for one in releases])
    found = [one.zeta_u for one in peaks] if by_peaks else [fitted_zeta_u(one.separated.fit) for one in releases]
    u = np.maximum(found, 1e-300)
    chi_squared = float((((zeta - np.average(zeta, weights=u**-2.0)) / u) ** 2).sum())
    p = float(chdtrc(len(releases) - 1, chi_squared))
    words = (
        "Over {count} releases ζ has a standard deviation of {spread:.1e}, where noise gives {noise:.1e}: noise "
        "explains it."
        if p >= LEVEL
        else "Over {count} releases ζ has a standard deviation of {spread:.1e}, where noise gives {noise:.1e}: the "
        "releases differ in more than noise. The Type A uncertainty, taken from the scatter, contains that."
    )
    text = said(words, count=len(releases), spread=float(zeta.std(ddof=1)), noise=float(np.median(u)))
    return Check("scatter between releases", chi_squared, p, p >= LEVEL, text, covered=True)


def _shape(shape: DampingShape) -> Check:
    z = max(shape.dry_z, shape.quadratic_z)
    return Check("viscous damping", z, None, shape.verdict == "viscous", shape.sentence)


def filter_words(releases: Sequence[Release]) -> str:
    """Say what was removed from the records, how, and what that does to ζ."""
    lengths = [2e3 * one.filter.half * one.separated.free.step for one in releases if one.filter is not None]
    if not lengths:
        return said("No record was filtered: every result is that of the direct fit.")
    worst = max(abs(release.bias) for release in releases)
    low, high = f"{min(lengths):.3g}", f"{max(lengths):.3g}"
    text = (
        "Symmetric (zero-phase) FIR filter of {low:figures} ms: of each record the minimum-variance filter, which "
        "passes the longitudinal oscillation with gain one and lets through least of drift, noise and the other "
        "oscillations found in the record. It changes ζ of the fitted clean decay by {worst:.0e} at most."
        if low == high
        else "Symmetric (zero-phase) FIR filter of {low:figures} to {high:figures} ms: of each record the "
        "minimum-variance filter, which passes the longitudinal oscillation with gain one and lets through least of "
        "drift, noise and the other oscillations found in the record. It changes ζ of the fitted clean decay by "
        "{worst:.0e} at most."
    )
    return said(text, low=low, high=high, worst=float(max(worst, SEEN)))


def notes(releases: Sequence[Release], *, scale: Input | None) -> tuple[str, ...]:
    """Return what the reader must know of how the result came about."""
    found = [
        said(
            "The scatter between releases contains the noise within each record, which is not added a second time. "
            "Where it is no larger than that noise explains, the noise is the uncertainty."
            if len(releases) > 1
            else "One release only: its noise is all there is of Type A, and repeatability is not known. Release again."
        ),
        said(
            "The moment of inertia is that of all that turns."
            if SENSED[releases[0].record.unit].coordinate == "angle"
            else "The mass is that which oscillates: plate, released mass and a third of the mass of the sample."
        ),
    ]
    if scale is not None and scale.u > 0:
        found.append(
            said(
                "The scale of the sensor (relative standard uncertainty {u:.1e}) cancels in every ratio of amplitudes: "
                "it enters neither δ, ζ nor ω_n.",
                u=float(scale.u),
            )
        )
    if 1 < len(releases) < 4:
        text = "With {count} releases the scatter has {dof} degree(s) of freedom: more would pay."
        found.append(said(text, count=len(releases), dof=len(releases) - 1))
    return tuple(found)
