"""Oscillations that one record of a test shows, sought in its other records: one rig makes them all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import log, pi

from metrology.decay.modes import guard, is_sound, spectrum
from metrology.decay.oscillation import Mode
from metrology.decay.separated import Separated
from metrology.decay.separation import refitted, release_before

_PLACES = 3  # frequencies that a record tells apart within one of its widths, 1/T, of a frequency that another tells


def with_shared(found: Sequence[Separated]) -> list[Separated]:
    """Records of one test, each with the oscillations of the others of which it has evidence too.

    By itself a record has to show an oscillation that noise does at no frequency at all (`modes`). Where another one
    tells the frequency, it has to outweigh amplitude and phase alone, of which each costs ½·ln n (unit information;
    Kass & Wasserman, J. Am. Stat. Assoc. 90 (1995) 928): else of one oscillation, a little above the limit in one
    record and a little below it in the next, only the first would be separated. Of rounded readings the fit is another
    one (`rounding`); they keep what they show by themselves.

    Parameters
    ----------
    found : sequence of Separated
        Each taken apart by itself.

    Returns
    -------
    list of Separated
        In the same order.
    """
    return [_with(one, list(_of_others(found, at))) if one.rounded is None else one for at, one in enumerate(found)]


def _of_others(found: Sequence[Separated], at: int) -> Iterator[Mode]:
    """Oscillations of the other records, the largest beside its noise first."""
    others = ((size / max(one.noise, 1e-300), mode) for place, one in enumerate(found) if place != at
              for mode, size in one.fit.others)  # fmt: skip
    return (mode for _, mode in sorted(others, key=lambda entry: -entry[0]))


def _with(one: Separated, modes: Sequence[Mode]) -> Separated:
    duration = float(one.t[-1])
    width = 2 * pi / duration
    for mode in modes:
        main, own = one.fit.main, one.fit.modes
        if any(abs(mode.omega - known.omega) < 1.5 * width for known in own):
            continue
        if abs(mode.omega - main.omega) < guard(main, duration):
            continue
        omega, power, level = spectrum(one.t, one.fit.residual)
        near, height = abs(omega - mode.omega) <= width, power / level
        if not near.any() or height[near].max() < log(_PLACES * one.t.size):
            continue
        start = replace(mode, omega=float(omega[near][height[near].argmax()]))
        again = refitted(one.free, one.fit, degree=one.fit.degree, more=[start])
        if is_sound(again, one.fit, duration):
            one = replace(one, fit=again, release=float(one.free.time[0]) + release_before(again))
    return one
