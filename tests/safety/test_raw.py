"""Checks of raw records: what each finds, and that sound records of all kinds stay silent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import plain_cases
import pytest
import truth_decay
import truth_elongation
import truth_response

from metrology import raw
from metrology.elongation import analyse
from metrology.timeseries import Channel

RNG = np.random.default_rng


def swinging(seed: int, *, noise: float = 4e-7, digit: float = 1e-7) -> Channel:
    """A plate that swings out."""
    eye = truth_decay.Vibrometer(noise=noise, rounding=digit)
    t, x = truth_decay.releases(truth_decay.MATERIALS["spectra"], eye, 1, RNG(seed))[0]
    return Channel("release", t, x, "m")


def spoiled(channel: Channel, value: np.ndarray) -> list[str]:
    return list(raw.faults(Channel(channel.name, np.arange(len(value)) * channel.step, value, channel.unit)))


@pytest.mark.parametrize("noise", [0.0, 2e-8, 1e-7, 4e-7, 5e-6])
@pytest.mark.parametrize("digit", [1e-9, 1e-7, 2e-6])
def test_law_a_sound_record_is_silent_at_any_noise_and_digit(noise, digit):
    for seed in range(7):
        assert list(raw.faults(swinging(seed, noise=noise, digit=digit))) == []


def test_law_sound_runs_of_a_module_are_silent():
    truth = truth_response.Truth(m=25.0, k=167.64, c=8.0, taut=0.1, friction=0.05)
    test = truth_response.Test("step", ((1.0, 0.62), (6.0, 0.0)), 12.0, x0=0.05)
    for noise in ((0.0, 0.0, 0.0), (2e-4, 2e-3, 5e-3), (1e-6, 1e-5, 1e-4)):
        for seed in range(4):
            one = truth_response.measure(truth, test, truth_response.Instruments(noise=noise), RNG(seed))
            for name in "xvT":
                assert list(raw.faults(Channel(name, one.t[name], one.readings[name]))) == []


def test_limit_a_rounded_ramp_is_not_held():
    ramp = np.floor(np.arange(4000) / 6) * 1e-5
    assert list(raw.faults(Channel("crosshead", np.arange(4000.0), ramp, "m"))) == []


@pytest.mark.parametrize("every", [2, 3, 10])
def test_planted_a_slow_update_is_found(every):
    sound = swinging(1)
    (found,) = spoiled(sound, sound.value[every * (np.arange(len(sound)) // every)])
    assert f"stands {every} times in a row" in found


def test_planted_a_record_that_stopped_is_found():
    sound = swinging(2)
    value = sound.value.copy()
    value[600:1100] = value[600]
    assert any("500 readings in a row are alike" in one for one in spoiled(sound, value))


def test_limit_a_slack_line_that_snaps_taut_has_not_stopped():
    """A cell that rounds by five of its noise rests at zero, with a step below now and then, until the line is taut."""
    t = np.arange(2400) / 80
    pull = np.maximum(4 * np.sin(2 * np.pi * t / 5 - 1.0) - 3.0, 0.0) + np.where((t % 5) > 4.0, 1.5, 0.0)
    value = 0.01 * np.round((pull + 0.002 * RNG(3).standard_normal(len(t))) / 0.01)
    value[::97] -= np.where(value[::97] == 0, 0.01, 0.0)
    assert list(raw.faults(Channel("T", t, value, "N"))) == []


@pytest.mark.parametrize("again", [True, False])
@pytest.mark.parametrize("seed", [2, 3, 5])
def test_limit_a_slack_line_of_which_the_cell_shows_some_digits_has_not_stopped(seed, again):
    """A cell with noise of a digit rests at one level and another; the line snaps taut after nine readings at one."""
    rng, t = RNG(seed), np.arange(2400) / 200
    value = 0.0048 * np.round(((0.003 if again else -0.002) + 0.0042 * rng.standard_normal(len(t))) / 0.0048)
    value[1000:] += np.maximum(4 * np.sin(2 * np.pi * (t[1000:] - 5.0) / 3), 0.0) + np.where(t[1000:] < 6.5, 1.0, 0.0)
    value[991:1000] = 0.0
    if again:
        value[300:309] = 0.0048
    assert list(raw.faults(Channel("T", t, value, "N"))) == []
    value[1240:1300] = value[1240]
    assert any("60 readings in a row are alike" in one for one in raw.faults(Channel("T", t, value, "N")))


def test_limit_a_gap_after_a_turning_point_is_no_stop():
    """A coarse recorder without noise rests at the turning point; over missing readings the motion goes on."""
    t = np.arange(0.0, 40.0, 0.02)
    value = 1e-3 * np.round(0.1 * np.exp(-0.01 * t) * np.cos(2 * np.pi * t / 6.3) / 1e-3)
    kept = (t < 6.36) | (t > 7.9)
    assert list(raw.faults(Channel("x", t[kept], value[kept], "m"))) == []
    stays = np.where(kept, value, value[t < 6.36][-1])
    assert any("the record stopped" in one for one in raw.faults(Channel("x", t, stays, "m")))


def test_limit_a_spike_on_a_module_at_rest_is_no_stop():
    """A module waits for its thrust without noise that dithers its reading; of one reading the camera lost a marker."""
    t = np.arange(1200) / 50
    x = 1e-4 * np.round((0.3 - 0.1 * np.maximum(t - 0.24, 0.0)) / 1e-4)
    x[13] += 0.05
    assert list(raw.faults(Channel("x", t, x, "m"))) == []
    x[14:] += 0.05
    assert any("the record stopped" in one for one in raw.faults(Channel("x", t, x, "m")))


@pytest.mark.parametrize("sign", [1, -1])
def test_planted_clipped_peaks_are_found(sign):
    sound = swinging(3)
    level = 0.7 * float((sign * sound.value).max())
    found = spoiled(sound, sign * np.minimum(sign * sound.value, level))
    assert any("clipped" in one for one in found)


def test_planted_readings_once_more_are_found():
    sound = swinging(4)
    rows = np.sort(np.concatenate([np.arange(len(sound)), RNG(0).choice(len(sound), len(sound) // 20, replace=False)]))
    assert any("once more" in one for one in spoiled(sound, sound.value[rows]))


def test_planted_a_stretch_that_stands_twice_is_found():
    sound = swinging(5)
    rows = np.concatenate([np.arange(2000), np.arange(1800, len(sound))])
    assert any("200 readings in a row stand in it twice" in one for one in spoiled(sound, sound.value[rows]))


def test_planted_time_in_the_column_of_a_reading_is_found():
    t = np.arange(600) / 50.0
    force = 20 * t + 0.05 * RNG(9).standard_normal(600)
    (found,) = raw.faults(Channel("force", force, t, "N"))
    assert "time stands in its column" in found
    assert list(raw.faults(Channel("force", t, force, "N"))) == []


def test_planted_readings_coarser_than_the_stated_resolution_are_found():
    assert list(raw.faults(swinging(8), 1e-7)) == []
    (found,) = raw.faults(swinging(8, digit=2e-7), 1e-7)
    assert "a resolution of 1e-07 is stated" in found


def records(material: str, seed: int, planted: dict[str, float], wrong: dict[int, float]) -> bool:
    """Whether an elongation test passes the check of its raw records; some readings are off by that many spans."""
    test = plain_cases.stretched(material, seed, planted)
    values = np.array([one.value for one in test.readings])
    span = float(np.ptp(values))
    readings = [replace(one, value=one.value + span * wrong.get(at, 0.0)) for at, one in enumerate(test.readings)]
    checks = analyse(replace(test, readings=tuple(readings))).finding.checks
    return next(one.passed for one in checks if one.name == raw.NAME)


@pytest.mark.parametrize("material", truth_elongation.MATERIALS)
@pytest.mark.parametrize(
    "planted", [{}, {"slip": 5e-5}, {"toe": 1e-4}, {"creep": 0.02}, {"misread": 2e-4}, {"drift": 2e-6}]
)
def test_law_readings_with_any_effect_of_the_table_are_no_failed_record(material, planted):
    for seed in range(4):
        assert records(material, seed, planted, {})


def test_planted_readings_that_no_load_gives_are_found():
    assert not records("al-1100", 1, {}, {5: 30.0, 11: -30.0, 20: 30.0})


def test_limit_a_few_stray_readings_are_no_repeated_ones():
    sound = swinging(6)
    value = sound.value.copy()
    value[[500, 900]] += 1.2345678e-3
    assert spoiled(sound, value) == []


def test_law_an_encoder_with_uneven_lines_repeats_by_its_lines_alone():
    """Lines 42, 158 and 200 µm apart, and a flutter of some lines: readings repeat, as in a public record of a disk."""
    lines = np.cumsum(np.tile([42.0, 158.0, 200.0, 200.0], 16)) - 4800.0
    t = np.arange(25000) * 0.005
    for seed in range(3):
        moved = 4500 * np.exp(-t / 40) * np.cos(2 * np.pi * 1.3 * t) + 150 * RNG(seed).standard_normal(t.size)
        seen = lines[np.abs(moved[:, None] - lines).argmin(axis=1)]
        assert list(raw.faults(Channel("angle", t, seen, "um"))) == []


def test_planted_a_record_that_ends_at_its_largest_reading_is_clipped():
    rng = np.random.default_rng(5)
    force = np.linspace(0.0, 4500.0, 900) + rng.normal(0.0, 0.5, 900)
    clipped = np.round(np.minimum(force, 4000.0), 2)
    assert any("cut off at the end" in one for one in raw.faults(Channel("force", np.arange(900.0), clipped, "N")))
    assert not list(raw.faults(Channel("force", np.arange(900.0), np.round(force, 2), "N")))
    held = np.minimum(np.linspace(0.0, 9e-3, 900), 8e-3)  # A crosshead that stands at the end of its ramp has no noise.
    assert not list(raw.faults(Channel("crosshead", np.arange(900.0), np.round(held, 6), "m")))


def test_limit_a_coarse_record_that_rests_at_its_last_reading_is_not_cut_off():
    """A module that coasts: steps of 3.75 mm/s over noise of a fifth of that, the last of which lasts."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        speed = -0.03 * np.minimum(np.arange(600.0) / 500.0, 1.0) - 0.0148 + 7.5e-4 * rng.standard_normal(600)
        read = 3.75e-3 * np.round(speed / 3.75e-3)
        assert not any("cut off" in one for one in raw.faults(Channel("v", np.arange(600.0), read, "m/s")))


def test_limit_coarse_readings_of_any_number_of_levels_have_a_step():
    assert raw.coarse(np.arange(4000.0), 1e-3) == pytest.approx(1.0)
