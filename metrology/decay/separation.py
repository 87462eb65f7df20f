"""Find in a record the longitudinal oscillation, its start and its other modes, and refuse what has none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import hypot, log, pi, sqrt

import numpy as np

from metrology.decay.hop import CLEAR, Hop, is_sharp, sought, step_at, without
from metrology.decay.jump import Jump, jumped
from metrology.decay.modes import is_mains, longitudinal, per_mean
from metrology.decay.oscillation import DEGREE, Fit, Floats, Mode, at_rate, fit
from metrology.decay.outliers import is_last_off, masked
from metrology.decay.rounding import by_likelihood, rounded
from metrology.decay.separated import Separated, baseline
from metrology.decay.settling import settled
from metrology.decay.start import Unusable, free_motion, heavy, refuse_clipped, refuse_short, until_rest
from metrology.message import said
from metrology.timeseries import Channel, average
from metrology.timeseries.white_noise import noise

HOPS = 3
"""Most steps of one record: what seems to have more, such as a step of the gain, has another fault."""

_FAR = 25.0  # times the mean square of the rest, beyond which what comes before the first crossing is not looked at
_LARGEST = 700.0  # logarithm of nearly the largest number
_MOVES = 5.0  # standard deviations of a rest, beyond which what a fit has there is none of it
_ROUNDS = 3  # of taking away what rounding is expected to do, each with the modes that the one before left
_PLAIN = 0.05  # chance below which the fit leaves more before the first crossing than after it
_DRIFT = 0.05  # chance of as large a drift from noise alone below which it is taken for one
_ELSEWHERE = 4.0  # times the first guess of ω_n, beyond which a fit of a heavily damped motion is of something else


def separate(record: Channel, *, mains: float, expected: float | None = None) -> Separated:
    """Find the free decay in a record, and fit the longitudinal mode together with all that overlies it.

    Parameters
    ----------
    record : Channel
        Displacement in m, angle in rad, or a derivative of one by time, with or without samples from before release.
        Steps need not be even, and readings may be missing: the fit stands at the stamps.
    mains : float
        Frequency of the mains in Hz.
    expected : float, optional
        Where the longitudinal mode is expected, √(k/m) in rad/s; without it, it is the strongest that is not mains.

    Raises
    ------
    Unusable
        When the record has no decay that can be evaluated.
    """
    whole, outliers = masked(record)
    found = _separated(whole, mains, expected)
    if float(found.free.time[-1]) == float(whole.time[-1]) and is_last_off(found.fit.residual):
        outliers = np.append(outliers, whole.time[-1])
        found = _separated(replace(whole, time=whole.time[:-1], value=whole.value[:-1]), mains, expected)
    found = _less_rounding(whole, found, mains)
    start = float(found.free.time[0])
    return replace(found, outliers=tuple(outliers[outliers > start].tolist()))


def _less_rounding(whole: Channel, found: Separated, mains: float) -> Separated:
    """Return the same of a record less what its rounding is expected to do, where no noise dithers it.

    Rounding makes multiples of the frequency, which the first fit takes for modes: the next has those that are left.
    """
    others: tuple[Mode, ...] = ()
    for _ in range(_ROUNDS):
        free = found.free
        raw = whole.value[np.searchsorted(whole.time, free.time)]
        of = rounded(without(replace(free, value=raw), found.hops), raw, found.fit, others)
        if of is None:
            break
        try:
            parted, fitted, hops, rest = _apart(replace(free, value=of.value), found.fit.main, of.noise)
            fitted = _without_drift(parted, fitted)
            _refuse_weak(fitted, parted, mains=mains)
        except Unusable:
            break
        if fitted.main.omega <= 2 * sqrt(fitted.covariance[0, 0]):
            break
        of = of.part(len(parted))
        fitted, near = by_likelihood(parted.time - parted.time[0], parted.value, fitted, of)
        parted, of = replace(parted, value=parted.value + near.value - of.value), near
        release = float(parted.time[0]) + release_before(fitted)
        found = replace(found, free=parted, fit=fitted, noise=of.noise, hops=hops, release=release, rounded=of,
                        rest=found.rest if rest is None else rest)  # fmt: skip
        if len(fitted.modes) == 1 + len(others):
            break
        others = fitted.modes[1:]
    return found


def _separated(whole: Channel, mains: float, expected: float | None) -> Separated:
    """Find the decay in a record without outliers."""
    refuse_short(whole)
    free, is_heavy = free_motion(whole, expected)
    level = noise(free)
    refuse_clipped(free)
    first = heavy(free) if is_heavy else None
    first = first or longitudinal(free, level, mains=mains, expected=expected)
    free, fitted, hops, rest = _apart(free, first, level)
    jumps: list[Jump] = []
    while len(jumps) < HOPS and not is_heavy and (jump := jumped(free, fitted, level)) is not None:
        whole, part = (_beside(one, jump) for one in (whole, free))
        refuse_short(part)
        jumps.append(jump)
        free, fitted, hops, rest = _apart(part, longitudinal(part, level, mains=mains, expected=expected), level)
    if is_heavy and fitted.main.omega > _ELSEWHERE * hypot(first.omega, first.rate):
        # The fit left the motion for a part of the noise.
        raise _returned()
    whole = without(whole.part(float(whole.time[0]), float(free.time[-1])), hops)
    _refuse_weak(fitted, free, mains=mains)
    crossed = float(free.time[0])
    free, fitted = _from_release(whole, free, fitted)
    fitted = _without_drift(free, fitted)
    if fitted.main.omega <= 2 * sqrt(fitted.covariance[0, 0]):
        raise _returned()
    start = float(free.time[0])
    return Separated(
        free,
        fitted,
        start + release_before(fitted),
        level,
        crossed=crossed - start,
        hops=hops,
        rest=rest,
        jumps=tuple(jumps),
    )


def _beside(record: Channel, jump: Jump) -> Channel:
    """Return the part of a record before or after a jump that tells more of the decay."""
    if jump.keeps_later:
        return record.part(jump.time)
    return record.part(float(record.time[0]), jump.time - 0.5 * record.step)


def _returned() -> Unusable:
    """Refusal of a motion whose ω_d cannot be distinguished from zero.

    Near critical damping ω_d goes to zero as a square root: no slope there says how well ω_n and k are known.
    """
    return Unusable(
        said(
            "The record shows no oscillation: what follows the release returns to rest at critical damping or beyond, "
            "or too near to it for these readings to tell, so that ω_n, k and c do not follow. Reduce the damping or "
            "the noise."
        )
    )


def _apart(free: Channel, first: Mode, level: float) -> tuple[Channel, Fit, tuple[Hop, ...], float | None]:
    """Return a record less its steps, its fit, the steps, and from when on nothing moves.

    Where a mode of the fit is larger then than the rest, others end it, and where a step comes after it, nothing needs
    one: a motion that stops, as by dry friction, is no sum of what decays. The record is then cut at twice that time.
    """
    found = _without_hops(free, first, level)
    part, rest = until_rest(free, first)
    if rest is None:
        return *found, rest
    _, fitted, hops = found
    # A mode that grows, as one of noise may, is beyond the largest number at the end of a long rest.
    grown = [min(-mode.rate * (rest - float(free.time[0])), _LARGEST) for mode in fitted.modes]
    left = np.exp(grown) * fitted.amplitudes
    if left.max() > _MOVES * free.value[free.time >= rest].std() or any(one.time >= rest for one in hops):
        found = _without_hops(part, first, level)
    return *found, rest


def _without_hops(free: Channel, first: Mode, level: float) -> tuple[Channel, Fit, tuple[Hop, ...]]:
    """Return a record less its steps, and its fit; a step stays where its fit explains no more with fewer modes."""
    hops: tuple[Hop, ...] = ()
    fitted = settled(free, first, level)
    given = free, fitted
    while (hop := sought(free, fitted, level)) is not None:
        if len(hops) == HOPS:
            return *given, ()
        less = without(free, [hop])
        again = settled(less, first, level)
        # What is fitted with it now says what its size is.
        more, u = step_at(less, again, hop.time)
        hop = replace(hop, size=hop.size + more, u=u)
        if not is_sharp(free, again, hop, level):
            break
        less = without(free, [hop])
        again = settled(less, first, level)
        plain, stepped = _without_drift(free, fitted), _without_drift(less, again)
        fewer = 4 * (len(plain.modes) - len(stepped.modes)) + plain.slow - stepped.slow - 3
        gain = 0.5 * (plain.squares - stepped.squares) / max(level**2, stepped.squares / len(free))
        if gain + 0.5 * fewer * log(len(free)) < CLEAR:
            break
        hops, free, fitted = (*hops, hop), less, again
    return free, fitted, hops


def _from_release(whole: Channel, free: Channel, fitted: Fit) -> tuple[Channel, Fit]:
    """Return the record from the release itself on, and its fit, where it moves freely before the first crossing too.

    It is where the fit leaves no more of it than of the rest (F test): there the amplitude is largest, and a response
    test of the same record has it as well. A magnet whose pull dies away fails the test.
    """
    from scipy.special import fdtrc

    start, rest = float(free.time[0]) + release_before(fitted), float(np.mean(fitted.residual**2))
    for early in (0.5, 0.0):  # the release is known to half a step at best, and its own reading is the largest of all
        longer = whole.part(start - early * free.step)
        count = len(longer) - len(free)
        before = longer.value[:count] - _at(free, fitted, longer.time[:count])
        if count < 1 or np.mean(before**2) > _FAR * rest:
            continue
        again = refitted(longer, fitted)
        ratio = float(np.mean(again.residual[:count] ** 2) / np.mean(again.residual[count:] ** 2))
        if again.converged and fdtrc(count, len(free), ratio) >= _PLAIN:
            return longer, again
    return free, fitted


def _at(free: Channel, fitted: Fit, time: Floats) -> Floats:
    """Return the fit, baseline and all modes, at times of the record."""
    t = time - free.time[0]
    value: Floats = baseline(free, fitted)(t) + sum(fitted.part(t, i) for i in range(len(fitted.modes)))
    return value


def _without_drift(free: Channel, fitted: Fit) -> Fit:
    """Return the fit over a constant zero where the record shows no drift (F test): what is not there costs nothing."""
    from scipy.special import fdtrc

    plain = refitted(free, fitted, degree=0)
    left = len(free) - DEGREE - 4 * len(fitted.modes) - 1
    ratio = (plain.squares - fitted.squares) / DEGREE / (max(fitted.squares, 1e-300) / left)
    return plain if plain.converged and fdtrc(DEGREE, left, max(ratio, 0.0)) >= _DRIFT else fitted


def refitted(free: Channel, fitted: Fit, degree: int = DEGREE, more: Sequence[Mode] = ()) -> Fit:
    """Return the fit of the same modes and of some `more`, to a longer part of a record or over another polynomial."""
    coarse = average(free, per_mean(free, fitted.main))
    fast = 0.6 * pi / coarse.step
    others = [*fitted.modes[1:], *more]
    slow, held = ([mode for mode in others if (mode.omega > fast) == is_fast] for is_fast in (False, True))
    slow.insert(0, fitted.main)
    lags = int(2 / coarse.step / fitted.main.frequency)
    t, settling = coarse.time - coarse.time[0], fitted.settling
    again = fit(t, coarse.value, slow, held=held, lags=lags, degree=degree, settling=settling)
    return at_rate(again, free.time - free.time[0], free.value, held=held)


def _refuse_weak(fitted: Fit, free: Channel, *, mains: float) -> None:
    """Refuse a fit whose first mode does not decay, drowns in mains, or is sampled too slowly."""
    main, size = fitted.main, float(fitted.amplitudes[0])
    u = float(np.sqrt(fitted.covariance[1, 1]))
    unit = f"µ{free.unit}"
    hum = sum(other for mode, other in fitted.others if is_mains(mode, mains))
    steady = not fitted.converged or not main.rate > 2 * u
    if hum > 2 * size or (steady and is_mains(main, mains)):
        raise Unusable(
            said(
                "Mains dominates: {size:.3g} {unit} at multiples of {mains:g} Hz, over twice any decay. Part the "
                "sensor's supply and earth from the rest of the set-up, and repeat.",
                size=float(1e6 * max(hum, size)),
                unit=unit,
                mains=float(mains),
            )
        )
    if steady:
        raise Unusable(
            said(
                "No decay is seen: the rate of the strongest oscillation ({frequency:.4g} Hz) is {rate:.3g} 1/s with a "
                "standard uncertainty of {u:.2g} 1/s. Something may drive it, or it is not the longitudinal mode; "
                "state where that is expected.",
                frequency=float(main.frequency),
                rate=float(main.rate),
                u=float(u),
            )
        )
    if 1 / free.step < 8 * main.frequency * (1 - 1e-9):
        raise Unusable(
            said(
                "Sampled too slowly: {rate:.4g} Hz for an oscillation at {frequency:.4g} Hz; eight samples a period "
                "are needed at least.",
                rate=float(1 / free.step),
                frequency=float(main.frequency),
            )
        )


def release_before(fitted: Fit) -> float:
    """Return the time (s, not positive) of the last extremum of the longitudinal mode before the first sample."""
    a, b = fitted.coefficients[0]
    slope = complex(-fitted.main.rate, fitted.main.omega) * complex(a, -b)
    phase = (np.angle(slope) - pi / 2) % pi
    return float(-phase / fitted.main.omega)
