"""Free decay, taking a record apart: start, first guess, what else swings, drift, and each refusal, by closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, pi, sqrt

import numpy as np
import pytest
from scipy.signal import lfilter

from metrology.decay.correlated import sandwich
from metrology.decay.modes import _level, _others, disentangle, guard, is_sound, longitudinal
from metrology.decay.oscillation import DEGREE, Fit, Form, Mode, at_rate, baseline, fit, project
from metrology.decay.separated import Separated, curvature, drift, without_others
from metrology.decay.separation import _refuse_weak, release_before, separate
from metrology.decay.start import Unusable, free_motion, refuse_clipped
from metrology.raw import _flatter
from metrology.timeseries import Channel
from metrology.timeseries.white_noise import quantum

RATE = 1000.0
T = np.arange(2000) / RATE
MAIN = Mode(2 * pi * 22.9, 8.0)


def swing(mode: Mode, t: np.ndarray = T, a: float = 1.0, b: float = 0.0) -> np.ndarray:
    return np.exp(-mode.rate * t) * (a * np.cos(mode.omega * t) + b * np.sin(mode.omega * t))


def noise(size: float, seed: int = 1, count: int = T.size) -> np.ndarray:
    return size * np.random.default_rng(seed).standard_normal(count)


def channel(value: np.ndarray, t: np.ndarray = T) -> Channel:
    return Channel("r", t, value, "m")


def stated(
    modes: Sequence[Mode] = (MAIN,), sizes: Sequence[float] = (1e-3,), *, u: float = 0.1, converged: bool = True
) -> Fit:
    """A fit that says so much of every mode, and of the main one's rate."""
    coefficients = np.array([[0.6 * size, 0.8 * size] for size in sizes])
    return Fit(tuple(modes), "viscous", coefficients, np.diag([0.0, u**2]), np.ones(4), converged, inf)


# ---------------------------------------------------------------- where the free decay begins


@pytest.mark.parametrize("sign", [1, -1])
def test_closed_form_free_decay_begins_a_quarter_period_after_the_release(sign: int) -> None:
    t = np.arange(-100, 1500) / RATE
    mode = Mode(2 * pi * 5.3, 1.0)
    value = sign * np.where(t < 0, 1.0, swing(mode, np.maximum(t, 0.0)))
    found = free_motion(channel(7.0 + value, t), None)[0]
    assert found.time[0] == pytest.approx(np.ceil(1000 / (4 * 5.3)) / 1000)
    np.testing.assert_array_equal(found.value, 7.0 + value[t >= found.time[0]])


@pytest.mark.parametrize("first", [-0.2, 0.3])
def test_limit_what_never_crosses_its_rest_begins_at_time_zero_or_with_the_record(first: float) -> None:
    t = first + np.arange(600) / RATE
    assert free_motion(channel(np.where(t > t[-1] - 0.05, t, 0.0), t), None)[0].time[0] == pytest.approx(
        max(first, 0.0)
    )


def test_limit_a_crossing_too_late_to_leave_a_record_is_passed_over() -> None:
    t = np.arange(-50, 200) / RATE
    late = np.where(t < 0.16, 1e-3 * (t - 0.16), 1.0)
    late[-30:] = -1.0
    assert free_motion(channel(late, t), None)[0].time[0] == 0.0


def test_limit_a_largest_excursion_at_the_end_of_a_record_is_no_heavy_damping() -> None:
    """Of a swing that grows until the record ends on its way back, two readings were left."""
    t = np.arange(206) / RATE
    found, is_heavy = free_motion(channel((1 + 10 * t) * np.cos(2 * pi * 25 * t), t), None)
    assert not is_heavy
    assert len(found) == len(t)


@pytest.mark.parametrize("count", [59, 60])
def test_refusal_fewer_than_sixty_samples(count: int) -> None:
    t = np.arange(-40, count) / RATE
    short = channel(np.cos(20 * t), t)
    if count == 60:
        assert len(free_motion(short, None)[0]) == 60
        return
    with pytest.raises(Unusable) as refused:
        free_motion(short, None)[0]
    assert str(refused.value) == (
        "The record is too short: fewer than 60 samples after the release. Record three periods at least."
    )


@pytest.mark.parametrize("frequency", [6.2, 22.9])
def test_planted_pendulum_larger_than_the_decay_does_not_move_the_begin_where_that_is_expected(
    frequency: float,
) -> None:
    t = np.arange(-1000, 4000) / RATE
    mode = Mode(2 * pi * frequency, 1.0)
    value = np.where(t < 0, 1.0, swing(mode, np.maximum(t, 0.0)))
    away = channel(value + 20 * np.cos(2 * pi * 0.288 * t + 2.0), t)
    found = free_motion(away, 2 * pi * frequency)[0]
    assert 0 < found.time[0] < 1.5 / frequency
    assert abs(free_motion(away, None)[0].time[0] - found.time[0]) > 0.3


# ---------------------------------------------------------------- flat tops


def test_refusal_clipped_record_tells_how_long_and_where() -> None:
    value = np.sin(2 * pi * 10 * T) * np.exp(-0.5 * T)
    with pytest.raises(Unusable) as refused:
        refuse_clipped(channel(np.minimum(value, 0.9)))
    longest = int((value > 0.9)[:100].sum())
    assert str(refused.value) == (
        f"The record is clipped: {longest} samples in a row stand at 0.9 m. The range of the sensor was too small;"
        " repeat with a larger range or a smaller release."
    )


@pytest.mark.parametrize(("flat", "refused"), [(4, False), (5, True), (9, True)])
def test_limit_five_samples_in_a_row_are_a_flat_top(flat: int, refused: bool) -> None:
    """A tip of slope 1 that is cut off: no rounding of a millionth makes that."""
    x = np.arange(2000.0) - (1000 if flat % 2 else 999.5)
    made = channel(np.minimum(-abs(x) + 1e-3 * np.sin(x), -(flat - 1) / 2 - 0.01))
    if refused:
        with pytest.raises(Unusable, match=f"{flat} samples in a row"):
            refuse_clipped(made)
    else:
        refuse_clipped(made)


def test_limit_rounded_tops_are_not_clipped_where_the_steps_are_no_multiples_of_one() -> None:
    """A sensor rounds to 0.02, moves its zero by 0.0081 in the middle: the top of the wave is flat all the same."""
    value = np.sin(2 * pi * 1.5 * T) * np.exp(-0.1 * T)
    rounded = 0.02 * np.round(value / 0.02) + 0.0081 * (T[-1] / 2 < T)
    assert quantum(channel(rounded)) < 0.01
    refuse_clipped(channel(rounded))
    with pytest.raises(Unusable, match="is clipped"):
        refuse_clipped(channel(np.minimum(rounded, 0.9)))


@pytest.mark.parametrize("longest", [5, 6, 11])
def test_closed_form_a_parabola_rounded_has_a_top_as_long_as_its_step_makes_it(longest: int) -> None:
    """−x²: over half the flat length it falls by (longest/2)²; flatter than that by twice the step is no rounding."""
    x = np.arange(101.0) - 50
    value = -(x**2)
    top = int(np.argmax(value)) - longest // 2
    flat = value.copy()
    flat[top : top + longest] = 0.0
    left, right, share = top - longest, top + 2 * longest - 1, 1 / 9
    drop = -0.5 * (flat[left] + flat[right]) * share
    assert _flatter(flat, top, longest, 0.499 * drop)
    assert not _flatter(flat, top, longest, 0.501 * drop)
    behind = -(-longest // 2)
    near = flat[: top + longest + behind]  # a flank of half its length behind it
    assert _flatter(near, top, longest, 0.0)
    assert not _flatter(near[:-1], top, longest, 0.0)
    assert not _flatter(flat[top - behind + 1 :], behind - 1, longest, 0.0)  # and before it
    steep = np.where(x < 0, 3 * flat, flat)  # the mean of both flanks counts
    both = -0.5 * (steep[left] + steep[right]) * share
    assert _flatter(steep, top, longest, 0.499 * both)
    assert not _flatter(steep, top, longest, 0.501 * both)


# ---------------------------------------------------------------- the first guess


@pytest.mark.parametrize(("frequency", "rate"), [(6.2, 0.3), (22.9, 8.0), (37.0, 15.0), (97.0, 2.0), (110.0, 1.0)])
def test_closed_form_first_guess_lies_within_a_line_of_the_spectrum(frequency: float, rate: float) -> None:
    found = longitudinal(channel(swing(Mode(2 * pi * frequency, rate)) + 3.0 + T), 1e-3, mains=50.0, expected=None)
    assert found.frequency == pytest.approx(frequency, abs=max(0.25, 0.1 * rate / pi))
    assert 0.6 < found.rate / rate < 1.7


def test_law_first_guess_passes_over_mains_and_what_is_not_expected() -> None:
    hum = 5 * np.cos(2 * pi * 50.2 * T) + 0.5 * np.cos(2 * pi * 99.8 * T)
    strong, weak = swing(Mode(2 * pi * 12.9, 3.0)), 0.8 * swing(Mode(2 * pi * 37.0, 3.0))
    made = channel(hum + strong + weak)
    assert longitudinal(made, 1e-3, mains=50.0, expected=None).frequency == pytest.approx(12.9, abs=0.3)
    for frequency in (0.78 * 37.0, 1.4 * 37.0):
        assert longitudinal(made, 1e-3, mains=50.0, expected=2 * pi * frequency).frequency == pytest.approx(37, abs=2)


NOTHING = (
    "Nothing oscillates above the noise: no decaying oscillation takes more from the record than noise would. Check the"
    " release, the focus of the sensor and its range."
)


def test_refusal_nothing_that_oscillates() -> None:
    with pytest.raises(Unusable) as refused:
        longitudinal(channel(noise(1e-6)), 1e-6, mains=50.0, expected=None)
    assert str(refused.value) == NOTHING
    with pytest.raises(Unusable) as refused:
        longitudinal(channel(3.0 + T), 0.0, mains=50.0, expected=None)
    assert str(refused.value) == NOTHING


@pytest.mark.parametrize(("ratio", "refused"), [(8.0, True), (12.0, False)])
def test_limit_energy_fifty_times_that_of_noise(ratio: float, refused: bool) -> None:
    """A decay of amplitude A over a time 1/λ has the energy A²·f_s/(4λ): beside noise of variance σ², that over σ²."""
    mode = Mode(2 * pi * 22.9, 8.0)
    made = channel(swing(mode))
    level = sqrt(RATE / (4 * 8.0) / 50) * sqrt(10 / ratio)
    if refused:
        with pytest.raises(Unusable, match="Nothing oscillates"):
            longitudinal(made, level, mains=50.0, expected=None)
    else:
        assert longitudinal(made, level, mains=50.0, expected=None).frequency == pytest.approx(22.9, abs=0.3)


def test_refusal_no_frequency_left() -> None:
    t = np.arange(24) / RATE
    with pytest.raises(Unusable) as refused:
        longitudinal(channel(np.cos(600 * t), t), 1e-9, mains=50.0, expected=None)
    assert str(refused.value) == (
        "No frequency is left to look for a decay: the record is too short or sampled too slowly."
    )


# ---------------------------------------------------------------- what else swings


def test_closed_form_modes_and_amplitudes_of_a_record_of_known_parts() -> None:
    slow, fast = Mode(2 * pi * 9.6, 0.6), Mode(2 * pi * 401.3, 0.0)
    parts = [(MAIN, 1.0, 0.5), (slow, 0.02, 0.01), (Mode(2 * pi * 50.02, 0.0), 0.0, 0.03), (fast, 0.04, 0.0)]
    value = sum(swing(mode, T, a, b) for mode, a, b in parts) + 0.2 + 0.1 * T + noise(1e-3)
    found = disentangle(channel(value), Mode(2 * pi * 22.7, 7.0))
    assert found.main.omega == pytest.approx(MAIN.omega, rel=1e-4)
    assert found.main.rate == pytest.approx(8.0, rel=2e-3)
    assert found.coefficients[0] == pytest.approx([1.0, 0.5], abs=1e-3)
    others = sorted(zip(found.modes[1:], found.amplitudes[1:], strict=True), key=lambda pair: pair[0].omega)
    expected = sorted(parts[1:], key=lambda part: part[0].omega)
    assert len(others) == 3
    for (mode, size), (true, a, b) in zip(others, expected, strict=True):
        assert mode.frequency == pytest.approx(true.frequency, abs=0.03)
        assert size == pytest.approx(np.hypot(a, b), rel=0.05)
    assert found.residual.std() == pytest.approx(1e-3, rel=0.1)


def test_law_residuals_are_taken_to_be_correlated_over_two_periods() -> None:
    made = channel(swing(MAIN) + noise(1e-3))
    found = disentangle(made, MAIN)
    assert len(found.modes) == 1
    np.testing.assert_allclose(found.covariance, fit(T, made.value, [MAIN], lags=87).covariance, rtol=1e-6)


def test_planted_stronger_oscillation_does_not_draw_the_main_one_away() -> None:
    """Beside a tone ten times as large the fit of the decay alone runs away; with it, it stays."""
    value = swing(MAIN) + 10 * np.cos(2 * pi * 31.7 * T + 1.0) + noise(1e-3)
    found = disentangle(channel(value), MAIN)
    assert found.main.frequency == pytest.approx(22.9, rel=1e-3)
    assert found.main.rate == pytest.approx(8.0, rel=0.02)
    assert found.amplitudes[1:].max() == pytest.approx(10.0, rel=1e-3)


def test_limit_no_more_than_ten_other_oscillations() -> None:
    value = swing(MAIN) + sum(0.1 * np.cos(2 * pi * f * T + f) for f in np.arange(60, 400, 24.3)) + noise(1e-3)
    assert len(disentangle(channel(value), MAIN).modes) == 11


def test_law_a_line_once_refused_is_not_found_again() -> None:
    main = fit(T, 1e3 * swing(MAIN), [MAIN], lags=50)
    tones = [Mode(2 * pi * 97.0, 0.0), Mode(2 * pi * 210.0, 0.0)]
    left = replace(main, residual=noise(1.0) + 0.45 * swing(tones[0]) + 0.4 * swing(tones[1]))
    for refused, expected in (([], [97.0, 210.0]), ([tones[0].omega], [210.0]), ([one.omega for one in tones], [])):
        assert [mode.frequency for mode in _others(T, left, refused)] == pytest.approx(expected, abs=0.1)


def test_closed_form_guard_is_the_rate_or_three_lines() -> None:
    assert guard(Mode(100.0, 8.0), 2.0) == pytest.approx(3 * pi)
    assert guard(Mode(100.0, -20.0), 2.0) == 20.0


def test_closed_form_level_is_the_mean_power_of_noise_and_not_of_a_line() -> None:
    power = np.random.default_rng(2).exponential(3.0, 16_000)
    power[8000:] *= 10
    power[4000] = 1e6
    level = _level(power)
    assert level[:6000] == pytest.approx(3.0, rel=0.15)
    assert level[10_000:] == pytest.approx(30.0, rel=0.15)
    # Between the middles of two blocks the level goes along a straight line.
    assert level[8000] == pytest.approx(0.5 * (level[7500] + level[8500]), rel=1e-3)
    assert (_level(np.zeros(160)) == 1e-300).all()


def fitted(other: Mode, main: Mode = MAIN, squares: float = 1.0, *, converged: bool = True) -> Fit:
    return replace(stated((main, other), (1.0, 0.1), converged=converged), residual=np.array([sqrt(squares)]))


@pytest.mark.parametrize(("trial", "sound"), [
    (fitted(Mode(300.0, 1.0)), True),
    (fitted(Mode(300.0, 1.0), squares=2.0), False),  # no better
    (fitted(Mode(300.0, 1.0), converged=False), False),
    (fitted(Mode(MAIN.omega + 0.69 * 3 * pi, 1.0)), False),  # swallows the main mode
    (fitted(Mode(MAIN.omega - 0.71 * 3 * pi, 1.0)), True),
    (fitted(Mode(0.99 * 2 * pi, 1.0)), False),  # two cycles in the record are drift
    (fitted(Mode(1.01 * 2 * pi, 1.0)), True),
    (fitted(Mode(300.0, 20.1)), False),  # gone at once
    (fitted(Mode(300.0, 19.9)), True),
    (fitted(Mode(300.0, -0.76)), False),  # grows
    (fitted(Mode(300.0, -0.74)), True),
    (fitted(Mode(400.0, 1.0), Mode(1.21 * MAIN.omega, 8.0)), False),  # drawn away
    (fitted(Mode(400.0, 1.0), Mode(0.79 * MAIN.omega, 8.0)), False),
    (fitted(Mode(400.0, 1.0), Mode(1.19 * MAIN.omega, 8.0)), True),
])  # fmt: skip
def test_limit_what_a_sound_fit_is(trial: Fit, sound: bool) -> None:
    assert is_sound(trial, replace(stated(), residual=np.array([sqrt(2.0)])), 2.0) is sound


# ---------------------------------------------------------------- refusals of a fit


def weak(*modes: Mode, sizes: Sequence[float], u: float = 0.1, converged: bool = True, rate: float = RATE) -> str:
    free = Channel("r", np.array([0.0, 1 / rate]), np.zeros(2), "m")
    try:
        _refuse_weak(stated(modes, sizes, u=u, converged=converged), free, mains=50.0)
    except Unusable as reason:
        return str(reason)
    return ""


HUM = Mode(2 * pi * 50.1, 0.0)
MAINS = (
    "Mains dominates: {} µm at multiples of 50 Hz, over twice any decay. Part the sensor's supply and earth from"
    " the rest of the set-up, and repeat."
)


def test_refusal_mains_above_the_decay() -> None:
    second = Mode(2 * pi * 150.3, 0.0)
    assert weak(MAIN, HUM, second, sizes=(1e-3, 1.5e-3, 0.6e-3)) == MAINS.format("2.1e+03")
    assert weak(MAIN, HUM, second, sizes=(1e-3, 1.5e-3, 0.4e-3)) == ""
    assert weak(MAIN, Mode(300.0, 0.0), sizes=(1e-3, 9e-3)) == ""
    assert weak(replace(HUM, rate=0.1), sizes=(1e-5,)) == MAINS.format("10")


def test_refusal_no_decay_and_too_few_samples() -> None:
    steady = (
        "No decay is seen: the rate of the strongest oscillation (22.9 Hz) is {} 1/s with a standard uncertainty of {}"
        " 1/s. Something may drive it, or it is not the longitudinal mode; state where that is expected."
    )
    assert weak(replace(MAIN, rate=0.2), sizes=(1.0,), u=0.1) == steady.format("0.2", "0.1")
    assert weak(replace(MAIN, rate=0.201), sizes=(1.0,), u=0.1) == ""
    assert weak(MAIN, sizes=(1.0,), u=0.25, converged=False) == steady.format("8", "0.25")
    assert weak(MAIN, sizes=(1.0,), rate=8 * 22.9) == ""
    assert weak(MAIN, sizes=(1.0,), rate=183.0) == (
        "Sampled too slowly: 183 Hz for an oscillation at 22.9 Hz; eight samples a period are needed at least."
    )


# ---------------------------------------------------------------- release, drift, what is left


@pytest.mark.parametrize("angle", np.linspace(-3, 3, 9))
@pytest.mark.parametrize("rate", [0.0, 8.0, 60.0])
def test_closed_form_release_is_the_last_extremum_before_the_first_sample(angle: float, rate: float) -> None:
    mode = Mode(100.0, rate)
    found = replace(stated((mode,)), coefficients=np.array([[np.cos(angle), np.sin(angle)]]))
    at = release_before(found)
    assert -pi / 100 < at <= 0
    step = 1e-6
    before, after = (swing(mode, np.array([at + s]), np.cos(angle), np.sin(angle))[0] for s in (-step, step))
    assert after - before == pytest.approx(0.0, abs=1e-9)


def test_closed_form_drift_and_other_modes_are_taken_out() -> None:
    other = Mode(2 * pi * 9.6, 0.6)
    polynomial = np.polynomial.Polynomial([0.3, -0.2, 0.5, 0.1, -0.05])
    rest = noise(1e-4)
    value = swing(MAIN, T, 0.6, 0.8) + swing(other, T, 0.06, 0.08) + polynomial(T)
    exact = replace(stated((MAIN, other), (1.0, 0.1)), residual=rest)
    apart = Separated(channel(value + rest, T + 5.0), exact, 5.0, 1e-4)
    assert polynomial.degree() == DEGREE
    np.testing.assert_allclose(drift(apart)(T), polynomial(T), atol=1e-11)
    bend = polynomial.deriv(2)(T)
    assert curvature(apart) == pytest.approx(sqrt((bend**2).mean()), rel=1e-9)
    early = np.arange(-100, 50) / RATE
    record = channel(swing(MAIN, early, 0.6, 0.8) + swing(other, early, 0.06, 0.08) + polynomial(early), early + 5.0)
    np.testing.assert_allclose(without_others(apart, record), swing(MAIN, early, 0.6, 0.8), atol=1e-10)
    np.testing.assert_array_equal(apart.t, apart.free.time - 5.0)


def test_closed_form_separated_record_of_known_parts() -> None:
    t = np.arange(-50, 2000) / RATE
    late = np.maximum(t, 0.0)
    value = np.where(t < 0, 1.0, swing(MAIN, late, 1.0, MAIN.rate / MAIN.omega)) + 1e-3 * noise(1.0, count=t.size)
    found = separate(channel(value, t), mains=50.0)
    assert found.release == pytest.approx(0.0, abs=2e-4)
    assert found.noise == pytest.approx(1e-3, rel=0.15)
    assert found.fit.main.rate == pytest.approx(8.0, rel=5e-3)


@pytest.mark.parametrize(("cycles", "sought"), [(1.6, False), (2.4, True)])
def test_limit_what_turns_less_than_twice_in_a_record_is_slow_motion_and_no_line(cycles: float, sought: bool) -> None:
    """A polynomial of the fourth degree has two cycles: a slower line and it take up each other at any amplitude."""
    t = np.arange(4000) / RATE
    line = 0.05 * np.sin(2 * pi * cycles / t[-1] * t + 0.4)
    found = separate(channel(swing(MAIN, t, 1.0) + line + 1e-3 * noise(1.0, count=t.size), t), mains=50.0)
    assert bool(found.fit.others) is sought
    assert found.fit.main.rate == pytest.approx(MAIN.rate, rel=5e-3)


# ---------------------------------------------------------------- least squares by variable projection


def test_closed_form_projection_gives_coefficients_residual_and_its_derivatives() -> None:
    t = T[:400]
    modes = (Mode(150.0, 9.0, 3.0), Mode(300.0, 2.0))
    base = baseline(t)
    y = swing(modes[1], t, 0.1, 0.2) + 1 + 2 * t + noise(0.01, count=t.size)
    for form in ("dry", "quadratic", "viscous"):
        at = project(t, y, modes, base, form)
        columns = [_shape(t, modes[0], form), swing(modes[1], t), swing(modes[1], t, 0, 1)]
        matrix = np.column_stack([*columns[0], *columns[1:], *(t**n for n in range(DEGREE + 1))])
        solution, *_ = np.linalg.lstsq(matrix, y, rcond=None)
        np.testing.assert_allclose(at.residual, y - matrix @ solution, atol=1e-9)
        np.testing.assert_allclose(at.coefficients.ravel(), solution[:4], atol=1e-7)


def _shape(t: np.ndarray, mode: Mode, form: str) -> list[np.ndarray]:
    """The two columns of a mode by the printed solutions of its amplitude's differential equation."""
    grown = -np.expm1(-mode.rate * t) / mode.rate if mode.rate else t
    envelope = {
        "viscous": np.exp(-mode.rate * t),
        "dry": np.maximum(np.exp(-mode.rate * t) - mode.beta * grown, 0.0),
        "quadratic": np.exp(-mode.rate * t) / (1 + mode.beta * grown),
    }[form]
    return [envelope * np.cos(mode.omega * t), envelope * np.sin(mode.omega * t)]


@pytest.mark.parametrize("form", ["viscous", "dry", "quadratic"])
@pytest.mark.parametrize("rate", [9.0, 1e-7, 0.0])
def test_twice_slopes_of_the_residual_by_differences_where_nothing_is_left(form: str, rate: float) -> None:
    """Kaufman's derivative leaves out a term in the residual: it is exact where the residual vanishes."""
    t = T[:400]
    modes = (Mode(150.0, rate, 0.5), Mode(300.0, 2.0))
    base = baseline(t)
    true = [*_shape(t, replace(modes[0], rate=rate), form), swing(modes[1], t), swing(modes[1], t, 0, 1)]
    y = np.column_stack(true) @ [0.6, 0.8, 0.3, -0.2] + 1 + t**2
    slopes = project(t, y, modes, base, form).jacobian
    names = ["omega", "rate"] + (["beta"] if form != "viscous" else [])
    moves = [(0, name) for name in names] + [(1, "omega"), (1, "rate")]
    assert slopes.shape == (400, len(moves))
    for column, (index, name) in zip(slopes.T, moves, strict=True):
        h = 1e-5
        ends = []
        for step in (-h, h):
            moved = list(modes)
            moved[index] = replace(modes[index], **{name: getattr(modes[index], name) + step})
            ends.append(project(t, y, moved, base, form).residual)
        np.testing.assert_allclose(column, (ends[1] - ends[0]) / (2 * h), atol=2e-6)


def test_closed_form_fit_at_another_rate_has_its_coefficients_and_residuals() -> None:
    t = T[::4]
    other = Mode(2 * pi * 97.0, 0.0)
    value = swing(MAIN, T, 0.6, 0.8) + swing(other, T, 0.1, 0.0) + 1 + T
    found = fit(t, value[::4] - swing(other, t, 0.1, 0.0), [MAIN], lags=50)
    again = at_rate(found, T, value, held=[other])
    assert again.modes == (found.main, other)
    np.testing.assert_allclose(again.coefficients, [[0.6, 0.8], [0.1, 0.0]], atol=1e-6)
    np.testing.assert_allclose(again.residual, 0.0, atol=1e-6)
    assert again.squares == pytest.approx(float((again.residual**2).sum()))
    np.testing.assert_allclose(again.part(T, 1), swing(other, T, 0.1, 0.0), atol=1e-6)


def test_closed_form_fit_holds_modes_and_tells_its_covariance() -> None:
    """White noise σ on n samples of A·e^{−λt}·cos: u(λ) = u(ω) ≈ σ/A·√(16λ³·Δt) for a decay that ends in the record."""
    other = Mode(2 * pi * 97.0, 0.0)
    value = swing(MAIN, T, 0.6, 0.8) + swing(other, T, 0.1, 0.0) + noise(1e-3)
    found = fit(T, value, [Mode(140.0, 6.0)], held=[other], lags=2)
    assert found.converged
    expected = 1e-3 * sqrt(16 * 8.0**3 / RATE)
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx([expected] * 2, rel=0.15)
    assert [found.main.omega, found.main.rate] == pytest.approx([MAIN.omega, 8.0], abs=4 * expected)


@pytest.mark.parametrize("form", ["dry", "quadratic"])
def test_closed_form_fit_of_a_further_damping_beside_another_mode(form: Form) -> None:
    t, other = T[:800], Mode(2 * pi * 97.0, 1.0)
    envelope, _ = _shape(t, Mode(150.0, 2.0, 0.5), form)
    start = [Mode(150.5, 1.5, 0.3), replace(other, rate=0.5)]
    found = fit(t, envelope + 0.1 * swing(other, t), start, form=form, lags=50)
    assert (found.main.omega, found.main.rate, found.main.beta) == pytest.approx((150.0, 2.0, 0.5), rel=1e-5)
    assert (found.modes[1].omega, found.modes[1].rate) == pytest.approx((other.omega, 1.0), rel=1e-5)
    assert found.amplitudes == pytest.approx([1.0, 0.1], rel=1e-5)


@pytest.mark.parametrize(("periods", "lags"), [(3, 15), (8, 40), (30, 40)])
def test_law_u_of_a_fit_is_right_for_white_noise_however_short_the_record(periods: int, lags: int) -> None:
    """The fit takes the noise out of its residuals where its parameters act: a third of u in three periods."""
    t = np.arange(20 * periods) / 20 / MAIN.frequency
    generator, found = np.random.default_rng(17), []
    for _ in range(60):
        value = swing(MAIN, t) + 1e-3 * generator.standard_normal(t.size)
        found.append(np.diag(fit(t, value, [MAIN], lags=lags).covariance))
    slopes = project(t, swing(MAIN, t), [MAIN], baseline(t)).jacobian
    exact = 1e-6 * np.diag(np.linalg.inv(slopes.T @ slopes))
    # Of each u² with n/lags of at least 4, with 3·n/lags degrees of freedom; three of their standard deviations.
    assert np.mean(found, axis=0) == pytest.approx(exact, rel=3 * sqrt(2 / 12 / 60))


def test_closed_form_sandwich_written_out() -> None:
    """(JᵀJ)⁻¹·JᵀRJ·(JᵀJ)⁻¹ with R_ij = r(|i − j|)·(1 − |i − j|/(lags + 1)), over what it is for 1 − QQᵀ."""
    generator = np.random.default_rng(5)
    jacobian, residual = generator.standard_normal((60, 2)), generator.standard_normal(60)
    taken, lags = np.linalg.qr(np.column_stack([jacobian, generator.standard_normal((60, 3))]))[0], 7
    inverse, apart = np.linalg.inv(jacobian.T @ jacobian), np.subtract.outer(np.arange(60), np.arange(60))
    window = np.maximum(1 - abs(apart) / (lags + 1), 0.0)

    def written(product: np.ndarray) -> np.ndarray:
        r = [np.trace(product, k) / 60 for k in range(60)]
        return inverse @ jacobian.T @ (np.array(r)[abs(apart)] * window) @ jacobian @ inverse

    larger = np.sqrt(np.diag(inverse) / np.diag(written(np.eye(60) - taken @ taken.T)))
    expected = written(np.outer(residual, residual)) * np.outer(larger, larger)
    np.testing.assert_allclose(sandwich(jacobian, residual, lags, taken), expected, rtol=1e-9)
    scaled = sandwich(jacobian * [1e-6, 1e6], residual, lags, taken)
    np.testing.assert_allclose(scaled, expected / np.outer([1e-6, 1e6], [1e-6, 1e6]), rtol=1e-9)
    # No more lags than a quarter of the record, and a column of nothing carries none.
    np.testing.assert_allclose(sandwich(jacobian, residual, 99, taken), sandwich(jacobian, residual, 15, taken))
    empty = sandwich(np.column_stack([jacobian[:, 0], np.zeros(60)]), residual, lags, taken)
    np.testing.assert_allclose(empty[1], 0.0)


@pytest.mark.long
@pytest.mark.parametrize(("memory", "false", "seen"), [(0.0, 0, 19), (0.9, 6, 10)])
def test_noise_with_a_memory_is_no_step_of_the_reading(memory: float, false: int, seen: int) -> None:
    """Ten periods: with the noise of the readings and of what is slow alone, 14 of 60 records had a step at 0.9."""
    t, counts = np.arange(0.0, 7.23, 0.01), []
    for step, records in ((0.0, 60), (3e-4, 20)):
        count = 0
        for seed in range(records):
            rng = np.random.default_rng(seed)
            noise = lfilter([sqrt(1 - memory**2)], [1, -memory], rng.standard_normal(len(t) + 200))[200:]
            x = 1.66e-2 * swing(Mode(8.69, 0.035), t) + 5e-5 * noise + step * (t > t[-1] * rng.uniform(0.15, 0.85))
            count += bool(separate(Channel("x", t, 1e-5 * np.round(x / 1e-5), "m"), mains=50.0).hops)
        counts.append(count)
    assert counts[0] <= false
    assert counts[1] >= seen


@pytest.mark.parametrize(("until", "times", "seed"), [(3.0, 6.0, 19), (3.0, 4.0, 17), (5.0, 4.0, 17)])
def test_limit_noise_while_a_rig_is_let_go_is_no_step_of_the_reading(until: float, times: float, seed: int) -> None:
    """A hand on a slow, damped rig makes several times the noise for some seconds: their mean is off by as much."""
    rng, t, omega, zeta = np.random.default_rng(seed), np.arange(0.0, 50.0, 0.1), 0.7, 0.107
    x = -0.2 * np.exp(-zeta * omega * t) * np.cos(omega * np.sqrt(1 - zeta**2) * t)
    x += 0.005 * np.where(t < until, times, 1.0) * rng.standard_normal(len(t))
    assert separate(Channel("rig", t, 1e-3 * np.round(x / 1e-3), "m"), mains=50.0).hops == ()
