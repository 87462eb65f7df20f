"""Elongation tests: k by the line, what is uncertain in it, and the checks beside it."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from metrology import gum, raw, sample
from metrology.elongation import Correction, ElongationAnalysis, ElongationTest, Load, Reading, analyse
from metrology.elongation.checks import LINEARITY
from metrology.errors import MetrologyError
from metrology.gum import Component, Input, Knowledge, Normal, Rectangular

TAPES = Path(__file__).parent.parent / "campaigns" / "tapes"
G, AIR, STEEL = 9.8065, 1.19, 8000.0
GRAVITY = Input("gravity", G, (Component("anomaly", Rectangular(5e-4)),), "m/s²")
AIR_DENSITY = Input("air density", AIR, (Component("usual", Normal(0.02)),), "kg/m³")
WEIGHT_DENSITY = Input("weight density", STEEL, (Component("usual", Normal(100.0)),), "kg/m³")
WEIGHTS = Input("weights.scale", 0.0, (Component("certificate", Normal(5e-5)),))
MASSES = {"A": 0.5, "B": 1.0, "C": 1.5}
Extension = Callable[[float, int, str, np.random.Generator], float]


def build(readings: list[Reading], masses: dict[str, float] = MASSES, **changes: object) -> ElongationTest:
    test = {
        "name": "t",
        "loads": tuple(
            Load(name, Input(f"t.load {name}", mass, (Component("balance", Rectangular(2e-5)),), "kg"))
            for name, mass in masses.items()
        ),
        "readings": tuple(readings),
        "resolution": Component("resolution", Rectangular(5e-6)),
        "gravity": GRAVITY,
        "air_density": AIR_DENSITY,
        "weight_density": WEIGHT_DENSITY,
        "weights": WEIGHTS,
        "indicator": (Component("certificate", Normal(2e-6)),),
    }
    return ElongationTest(**(test | changes))  # type: ignore[arg-type]


def cycle(extension: Extension, seed: int = 1, *, repeats: int = 4, masses: dict[str, float] = MASSES) -> list[Reading]:
    """Readings of full cycles; the extension is told load in N, repeat, direction and the generator."""
    generator = np.random.default_rng(seed)
    found = []
    for repeat in range(repeats):
        for direction, names in (("loading", list(masses)), ("unloading", list(masses)[::-1])):
            for name in names:
                value = extension(masses[name] * G * (1 - AIR / STEEL), repeat, direction, generator)
                found.append(Reading(name, str(repeat + 1), direction, value, line=len(found) + 2))
    return found


def noisy(k: float = 25000.0, scatter: float = 8e-6) -> Extension:
    return lambda force, repeat, direction, generator: 5e-4 + force / k + generator.normal(0, scatter)


def value(analysis: ElongationAnalysis) -> float:
    return float(analysis.measurands[0].function({item.name: item.value for item in analysis.inputs}))


def verdicts(analysis: ElongationAnalysis) -> dict[str, bool | None]:
    return {check.name: check.passed for check in analysis.finding.checks}


def estimate(analysis: ElongationAnalysis, trials: int = 20_000) -> gum.Estimate:
    knowledge = Knowledge({item.name: item for item in analysis.inputs}, analysis.ensembles, analysis.correlations)
    return gum.evaluate(analysis.measurands, knowledge, seed=1, max_trials=trials).estimates["t.k"]


# ---------------------------------------------------------------- k and u(k)


def test_closed_form_k_is_the_reciprocal_of_the_least_squares_slope() -> None:
    readings = cycle(noisy())
    analysis = analyse(build(readings))
    force = [MASSES[reading.load] * G * (1 - AIR / STEEL) for reading in readings]
    line = stats.linregress(force, [reading.value for reading in readings])
    assert value(analysis) == pytest.approx(1 / line.slope, rel=1e-12)
    assert analysis.finding.slope == pytest.approx(line.slope, rel=1e-12)
    assert analysis.finding.intercept == pytest.approx(line.intercept, rel=1e-9)


def test_closed_form_unbalanced_k_is_the_slope_of_a_line_with_a_zero_each_repeat() -> None:
    readings = [r for i, r in enumerate(cycle(noisy())) if i not in (3, 8, 20)]
    force = np.array([MASSES[reading.load] * G * (1 - AIR / STEEL) for reading in readings])
    zeros = np.array([[reading.repeat == str(repeat) for repeat in range(1, 5)] for reading in readings], dtype=float)
    solution = np.linalg.lstsq(np.column_stack([zeros, force]), [r.value for r in readings], rcond=None)[0]
    assert value(analyse(build(readings))) == pytest.approx(1 / solution[-1], rel=1e-11)


def test_closed_form_u_of_repeatability_alone_is_that_of_the_slope() -> None:
    """With one repeat there is one zero; s is the pooled scatter within loads, of n − L degrees of freedom."""
    readings = [replace(reading, repeat="1") for reading in cycle(noisy(scatter=3e-5))]
    exact = Input("gravity", G, (), "m/s²")
    loads = tuple(Load(name, Input(f"t.load {name}", mass, (), "kg")) for name, mass in MASSES.items())
    test = build(
        readings,
        loads=loads,
        gravity=exact,
        air_density=Input("a", AIR),
        weight_density=Input("w", STEEL),
        weights=None,
        indicator=(),
        resolution=Component("resolution", Rectangular(0.0)),
    )
    got = estimate(analyse(test))
    groups = {name: [r.value for r in readings if r.load == name] for name in MASSES}
    s2 = sum(float(np.var(group)) * len(group) for group in groups.values()) / (24 - 3)
    force = np.array([MASSES[reading.load] * G * (1 - AIR / STEEL) for reading in readings])
    k = got.value
    assert got.u == pytest.approx(k**2 * sqrt(s2 / float(((force - force.mean()) ** 2).sum())), rel=1e-9)
    assert got.dof == pytest.approx(21)


def test_law_zero_of_readings_does_not_matter() -> None:
    readings = cycle(noisy())
    moved = [replace(reading, value=reading.value + 3e-3) for reading in readings]
    assert value(analyse(build(moved))) == pytest.approx(value(analyse(build(readings))), rel=1e-10)


def test_law_forces_stated_directly_give_the_same_k() -> None:
    readings = cycle(noisy())
    loads = tuple(
        Load(name, Input(f"t.load {name}", mass * G * (1 - AIR / STEEL), (), "N")) for name, mass in MASSES.items()
    )
    analysis = analyse(build(readings, loads=loads))
    assert value(analysis) == pytest.approx(value(analyse(build(readings))), rel=1e-12)
    assert "gravity" not in {item.name for item in analysis.inputs}


def test_law_relative_errors_common_to_all_loads_go_through_undiminished() -> None:
    readings = cycle(lambda force, *_: force / 25000.0)
    scale = Input("scale", 0.0, (Component("certificate", Normal(0.01)),))
    alone = build(readings, indicator=(), resolution=Component("r", Rectangular(0.0)), scale=scale)
    assert estimate(analyse(alone)).u / 25000.0 == pytest.approx(0.01, rel=1e-3)


def test_limit_readings_without_scatter_keep_the_whole_resolution() -> None:
    analysis = analyse(build(cycle(lambda force, *_: force / 25000.0)))
    assert analysis.ensembles == ()
    (resolution,) = next(item for item in analysis.inputs if item.name == "t.reading.A").components
    assert resolution.u == pytest.approx(5e-6 / sqrt(3))
    by_scatter = {name: passed for name, passed in verdicts(analysis).items() if name not in (raw.NAME, LINEARITY)}
    assert {passed for name, passed in by_scatter.items() if "unloading" not in name} == {None}


@pytest.mark.parametrize(("off", "passed"), [(0.0, True), (6e-6, True), (60e-6, False)])
def test_planted_readings_that_repeat_exactly_and_leave_the_line_fail(off, passed) -> None:
    """What is declared of each load is 5 µm/√3 of the division and 2 µm of the certificate."""
    readings = cycle(lambda force, *_: force / 25000.0 + off * (force > 12.0))
    check = next(one for one in analyse(build(readings)).finding.checks if one.name == LINEARITY)
    assert check.passed is passed
    assert "repeat exactly" in check.sentence


def test_law_exact_readings_rounded_to_their_division_are_seldom_not_linear() -> None:
    """400 stiff samples read to 10 µm without scatter: the rounding of each load is what is declared."""
    rng = np.random.default_rng(20261125)
    wrong = 0
    for k in rng.uniform(2e4, 3e4, 400):
        readings = cycle(lambda force, *_, k=k: 1e-5 * round(1e5 * (force / k + 3e-6)))
        checks = analyse(build(readings)).finding.checks
        wrong += next(one.passed for one in checks if one.name == LINEARITY) is False
    assert wrong <= 12  # of 1 in 100, 12 or fewer in 99.7 of 100 draws


@pytest.mark.parametrize(("steps", "found"), [((1, 2.5, 4.5), 50e-6), ((1, 2, 3), 100e-6), ((1, 2.01, 4), 0.0)])
def test_planted_a_coarse_step_is_the_common_divisor(steps, found) -> None:
    """Readings in steps of 100 µm and 150 µm are multiples of 50 µm; 2.01 is a multiple of 1 µm alone."""
    levels = dict(zip(MASSES, steps, strict=True))
    mass_of = {masses * G * (1 - AIR / STEEL): name for name, masses in MASSES.items()}
    readings = cycle(lambda force, repeat, *_: 1e-4 * (levels[mass_of[force]] + 6 * repeat))
    check = next(one for one in analyse(build(readings)).finding.checks if one.name == raw.NAME)
    assert check.passed is (found == 0.0)
    assert found == 0.0 or f"steps of {1e6 * found:.3g} µm" in check.sentence


def test_planted_even_steps_of_the_loads_are_none_of_the_indicator() -> None:
    """Readings on one line to within the resolution, 0.49 mm apart for each load: the indicator reads 0.01 mm."""
    masses = {name: 0.5 * at for at, name in enumerate("ABCDE", start=1)}
    each = 0.5 * G * (1 - AIR / STEEL)
    readings = cycle(lambda force, *_: 0.49e-3 * round(force / each), masses=masses)
    check = next(one for one in analyse(build(readings, masses)).finding.checks if one.name == raw.NAME)
    assert check.passed


def test_law_readings_of_the_stated_resolution_are_seldom_coarse() -> None:
    rng = np.random.default_rng(20261126)
    stated = Component("resolution", Rectangular(5e-6))
    wrong = []
    for seed in range(400):
        scatter = float(rng.choice([1e-6, 8e-6, 3e-5]))
        line = noisy(float(rng.uniform(1e4, 3e4)), scatter)
        readings = cycle(lambda *given, line=line: 1e-5 * round(1e5 * line(*given)), seed, repeats=2)
        checks = analyse(build(readings, resolution=stated)).finding.checks
        wrong += [one.sentence for one in checks if one.name == raw.NAME and one.passed is False]
    assert wrong == []


def test_limit_rounding_averages_when_readings_scatter_by_more_than_half_a_division() -> None:
    analysis = analyse(build(cycle(noisy(scatter=2e-5))))
    (resolution,) = next(item for item in analysis.inputs if item.name == "t.reading.A").components
    assert resolution.u == pytest.approx(5e-6 / sqrt(3) / sqrt(8))


def test_limit_a_load_of_zero_is_a_load() -> None:
    masses = {"O": 0.0} | MASSES
    analysis = analyse(build(cycle(noisy(), masses=masses), masses))
    assert value(analysis) == pytest.approx(25000.0, rel=0.03)
    assert [level.stiffness is None for level in analysis.finding.levels] == [True, False, False, False]


def test_twice_law_agrees_with_monte_carlo_where_readings_scatter_little() -> None:
    got = estimate(analyse(build(cycle(noisy(scatter=2e-6), repeats=8))), trials=200_000)
    assert got.monte_carlo.u == pytest.approx(got.u, rel=0.03)
    assert got.monte_carlo.mean == pytest.approx(got.value, rel=1e-3)


def test_twice_a_correction_line_acts_as_corrected_readings() -> None:
    readings = cycle(noisy())
    slope = Input("fit.slope", 0.02, (Component("fit", Normal(0.001)),))
    correction = Correction(lambda namespace, x: x * (1 + namespace["fit.slope"]), (slope,))
    corrected = analyse(build(readings, correction=correction))
    namespace = {item.name: item.value for item in (*corrected.inputs, slope)}
    plain = analyse(build([replace(reading, value=1.02 * reading.value) for reading in readings]))
    assert corrected.measurands[0].function(namespace) == pytest.approx(value(plain), rel=1e-12)
    assert corrected.finding.extension == pytest.approx(plain.finding.extension, rel=1e-12)


def test_planted_stiffness_lies_in_its_interval_at_the_stated_rate() -> None:
    """Truth drawn, readings simulated with every declared error and rounding; 95 % intervals are judged."""
    generator = np.random.default_rng(20261120)
    inside, runs = 0, 120
    for _ in range(runs):
        k = float(generator.uniform(20000, 30000))
        error = dict(zip(MASSES, generator.normal(0, 2e-6, 3), strict=True))
        g = float(G + generator.uniform(-5e-4, 5e-4))
        own = {name: mass * (1 + generator.normal(0, 5e-5)) * g * (1 - AIR / STEEL) for name, mass in MASSES.items()}
        zeros, readings = generator.normal(5e-4, 2e-5, 4), []
        for blank in cycle(lambda *_: 0.0):
            x = zeros[int(blank.repeat) - 1] + own[blank.load] / k + error[blank.load] + generator.normal(0, 8e-6)
            readings.append(replace(blank, value=round(x / 1e-5) * 1e-5))
        coverage = estimate(analyse(build(readings)), trials=1000).coverage
        assert coverage.low is not None
        assert coverage.high is not None
        inside += coverage.low <= k <= coverage.high
    # exact limits of a binomial count with p = 0.95 (lower) and of full over-coverage (upper)
    assert stats.binom(runs, 0.95).ppf(0.001) <= inside <= runs


# ---------------------------------------------------------------- checks


def _curved(force: float, repeat: int, direction: str, generator: np.random.Generator) -> float:
    return force / 25000.0 + 1e-6 * force**2 + float(generator.normal(0, 6e-6))


def _loop(force: float, repeat: int, direction: str, generator: np.random.Generator) -> float:
    return force / 25000.0 + (1.5e-5 if direction == "unloading" else 0.0) + float(generator.normal(0, 6e-6))


def _shifting(force: float, repeat: int, direction: str, generator: np.random.Generator) -> float:
    return force / 25000.0 + 2e-5 * repeat + float(generator.normal(0, 6e-6))


def _stiffening(force: float, repeat: int, direction: str, generator: np.random.Generator) -> float:
    return force / (25000.0 * (1 + 0.04 * repeat)) + float(generator.normal(0, 6e-6))


PLANTED = {
    "linearity (lack of fit)": _curved,
    "loading against unloading": _loop,
    "zero shift between repeats": _shifting,
    "stiffness between repeats": _stiffening,
}


@pytest.mark.parametrize("name", PLANTED)
def test_planted_fault_is_found(name: str) -> None:
    found = verdicts(analyse(build(cycle(PLANTED[name]))))
    assert found[name] is False


def test_planted_outlier_is_named_but_used() -> None:
    readings = cycle(noisy(scatter=6e-6))
    readings[7] = replace(readings[7], value=readings[7].value + 6e-5)
    analysis = analyse(build(readings))
    check = next(check for check in analysis.finding.checks if check.name == "outlier")
    assert check.passed is False
    assert "load B, repeat 2, loading (line 9)" in check.sentence
    assert analysis.finding.levels[1].count == 8


def test_planted_a_reading_off_by_one_division_alone_is_no_outlier() -> None:
    """A coarse dial shows the same at a load but for one reading, whose next division is nearer."""
    division = 5e-5

    def coarse(force: float, repeat: int, direction: str, _generator: np.random.Generator) -> float:
        shift = division if force < 7 and repeat == 2 and direction == "loading" else 0.0
        return float(np.round((5e-4 + force / 25000.0) / division)) * division + shift

    readings = cycle(coarse)
    stated, finer = (
        next(one for one in analyse(build(readings, resolution=half)).finding.checks if one.name == "outlier")
        for half in (Component("resolution", Rectangular(division / part)) for part in (2, 20))
    )
    assert stated.passed is True
    assert finer.passed is False


def test_planted_readings_that_hide_each_other_are_found_together() -> None:
    """Each of five is within the scatter that the others of them make."""
    readings = cycle(noisy(scatter=2e-6))
    lines = [3, 4, 8, 15, 21]
    for at, off in zip(lines, (-3e-4, -4e-4, 3.5e-4, 4e-4, -3e-4), strict=True):
        readings[at] = replace(readings[at], value=readings[at].value + off)
    check = next(check for check in analyse(build(readings)).finding.checks if check.name == "outlier")
    assert check.passed is False
    assert f"5 readings (lines {', '.join(str(at + 2) for at in lines[:-1])}" in check.sentence


def test_planted_nothing_is_found_at_no_more_than_the_stated_rate() -> None:
    runs = 300
    alarms = dict.fromkeys([*PLANTED, "outlier", raw.NAME], 0)
    for seed in range(runs):
        for name, passed in verdicts(analyse(build(cycle(noisy(), seed=seed), indicator=()))).items():
            alarms[name] += passed is False
    most = stats.binom(runs, 0.05).ppf(0.999)
    assert max(alarms.values()) <= most, alarms
    assert alarms["zero shift between repeats"] > 0
    assert alarms["loading against unloading"] > 0


def test_planted_error_of_the_indicator_within_its_certificate_is_no_lack_of_fit() -> None:
    def off(force: float, repeat: int, direction: str, generator: np.random.Generator) -> float:
        return force / 25000.0 + (8e-6 if 7 < force < 12 else 0.0) + float(generator.normal(0, 3e-6))

    readings = cycle(off, repeats=8)
    known = analyse(build(readings, indicator=(Component("certificate", Normal(5e-6)),)))
    unknown = analyse(build(readings, indicator=(), resolution=Component("resolution", Rectangular(5e-7))))
    assert known.finding.checks[0].passed is True
    assert "masses may err" in known.finding.checks[0].sentence
    assert unknown.finding.checks[0].passed is False


def test_law_zero_shift_does_not_touch_k() -> None:
    still, moved = (
        analyse(build(cycle(noisy()))),
        analyse(
            build([replace(reading, value=reading.value + 1e-4 * int(reading.repeat)) for reading in cycle(noisy())])
        ),
    )
    assert value(moved) == pytest.approx(value(still), rel=1e-10)
    assert estimate(moved, 1000).u == pytest.approx(estimate(still, 1000).u, rel=1e-9)
    shifts = {line.repeat: line.zero_shift for line in moved.finding.repeats if line.direction == "loading"}
    assert shifts["4"] == pytest.approx(3e-4, abs=2e-5)


def test_limit_repeats_of_one_load_each_share_one_zero() -> None:
    readings = [replace(reading, repeat=f"{reading.load}{reading.repeat}") for reading in cycle(noisy())]
    analysis = analyse(build(readings))
    assert value(analysis) == pytest.approx(value(analyse(build(cycle(noisy())))), rel=1e-12)
    assert verdicts(analysis)["zero shift between repeats"] is None
    assert any("One zero serves all repeats" in note for note in analysis.finding.notes)


def test_law_line_and_residual_add_up_for_every_reading_excluded_or_not() -> None:
    readings = cycle(noisy())
    readings[4] = replace(readings[4], excluded="indicator knocked", value=readings[4].value + 1e-3)
    finding = analyse(build(readings)).finding
    line = finding.intercept + finding.slope * np.array(finding.force)
    assert np.array(finding.extension) - line == pytest.approx(np.array(finding.residual), abs=1e-15)
    assert finding.residual[4] == pytest.approx(1e-3, abs=5e-5)
    assert finding.excluded[4] == "indicator knocked"
    assert finding.levels[1].count == 7


def test_closed_form_levels_are_the_means_of_their_readings() -> None:
    readings = cycle(noisy())
    finding = analyse(build(readings)).finding
    for level in finding.levels:
        own = [reading.value for reading in readings if reading.load == level.load]
        assert level.extension == pytest.approx(np.mean(own), abs=1e-15)
        assert level.residual == pytest.approx(
            level.extension - finding.intercept - finding.slope * level.force, abs=1e-15
        )


def test_planted_scatter_of_the_stiffness_at_a_load_is_its_uncertainty() -> None:
    found = []
    for seed in range(100):
        test = build(
            cycle(noisy(scatter=2e-5), seed), indicator=(), resolution=Component("resolution", Rectangular(0.0))
        )
        found.append(analyse(test).finding.levels)
    for levels in zip(*found, strict=True):
        spread = np.std([level.stiffness for level in levels], ddof=1)
        assert spread == pytest.approx(np.mean([level.stiffness_u for level in levels]), rel=0.25)


def test_closed_form_outlier_by_students_t_of_the_rest() -> None:
    """Studentised by the scatter without it: ν − 1 degrees of freedom, two sides, as many looks as readings."""
    readings = cycle(noisy())
    readings[5] = replace(readings[5], value=readings[5].value + 3e-5)
    test = analyse(build(readings))
    check = next(check for check in test.finding.checks if "outlier" in check.name)
    dof = test.ensembles[0].dof
    assert check.statistic is not None
    expected = 2 * len(readings) * stats.t.sf(abs(check.statistic), dof - 1)
    assert expected < 0.5
    assert check.p_value == pytest.approx(expected, rel=1e-9)


def test_law_inputs_and_results_carry_their_units() -> None:
    analysis = analyse(build(cycle(noisy())))
    assert {measurand.unit for measurand in analysis.measurands} == {"N/m"}
    units = {item.name: item.unit for item in analysis.inputs}
    for load in MASSES:
        assert (units[f"t.load {load}"], units[f"t.indicator.{load}"], units[f"t.reading.{load}"]) == ("kg", "m", "m")


# ---------------------------------------------------------------- refusals


def _refused(readings: list[Reading], masses: dict[str, float] = MASSES) -> Iterator[str]:
    with pytest.raises(MetrologyError) as refused:
        analyse(build(readings, masses))
    return iter(str(refused.value).splitlines())


def test_refusal_two_loads() -> None:
    masses = {"A": 0.5, "B": 1.0}
    (message,) = _refused(cycle(noisy(), masses=masses), masses)
    assert message == "t.loads: got 2 different loads; expected at least 3, without which linearity cannot be checked"


def test_refusal_no_reading_at_a_load() -> None:
    (message,) = _refused([r for r in cycle(noisy()) if r.load != "B"])
    assert message == (
        "t.readings: got no reading in use at load B; expected at least one. "
        "Fix: read the load, or leave it out of 'loads'"
    )


def test_refusal_all_faults_of_the_readings_at_once() -> None:
    readings = cycle(noisy())
    readings[0] = replace(readings[0], load="D")
    readings[1] = replace(readings[1], direction="down")
    readings[2] = replace(readings[2], value=float("nan"))
    first, second, third = _refused(readings)
    assert first == "t.readings line 2: got load 'D'; expected one of A, B, C"
    assert second == "t.readings line 3: got direction 'down'; expected 'loading' or 'unloading'"
    assert third.startswith("t.readings line 4: got reading nan; expected a number")


def test_refusal_readings_that_fall_with_the_load() -> None:
    (message,) = _refused(cycle(lambda force, *_: -force / 25000.0))
    assert message.startswith(
        "t.readings: got readings that change by -40 µm/N; expected readings that grow with the load"
    )


# ---------------------------------------------------------------- the shipped campaign

PUBLISHED = {
    "al-1100": (("0.49664", "0.99297", "1.48991"), 2.990, "24734.25", "335.52", "59.16", "3.29"),
    "peek": (("0.24864", "0.49677", "0.74592"), 3.000, "1810.91", "7.53", "4.35", "0.23"),
}


@pytest.mark.parametrize("tape", PUBLISHED)
def test_reference_table_two_from_the_shipped_readings(tape: str) -> None:
    masses, length, *printed = PUBLISHED[tape]
    rows = csv.DictReader((TAPES / f"{tape}-elongation.csv").read_text(encoding="utf-8").splitlines())
    readings = [Reading(r["load"], r["repeat"], r["direction"], float(r["reading / mm"]) * 1e-3) for r in rows]
    loads = dict(zip("ABC", map(float, masses), strict=True))
    analysis = analyse(build(readings, loads, indicator=(Component("certificate", Normal(2.25e-6)),)))
    section = (
        Input("s.width", 25e-3, (Component("caliper", Rectangular(1e-5)),), "m"),
        Input(
            "s.thickness", 5e-5, (Component("unevenness", Normal(2.5e-6)), Component("micrometer", Normal(1e-6))), "m"
        ),
        Input("s.length", length, (Component("steel tape", Rectangular(1e-3)),), "m"),
    )
    knowledge = Knowledge({item.name: item for item in (*analysis.inputs, *section)}, analysis.ensembles)
    model = (
        *analysis.measurands,
        sample.area("s", "tape"),
        sample.modulus("E", k="t.k", length="s.length", area="s.A"),
    )
    got = gum.evaluate(model, knowledge, seed=1, max_trials=1000).estimates
    k, modulus = got["t.k"], got["E"]
    assert [f"{k.value:.2f}", f"{k.u:.2f}", f"{modulus.value / 1e9:.2f}", f"{modulus.u / 1e9:.2f}"] == printed
    assert all(check.passed for check in analysis.finding.checks)


@pytest.mark.parametrize("tape", PUBLISHED)
def test_law_shipped_readings_are_a_whole_test_in_whole_divisions(tape: str) -> None:
    rows = list(csv.DictReader((TAPES / f"{tape}-elongation.csv").read_text(encoding="utf-8").splitlines()))
    cells = {(r["load"], r["repeat"], r["direction"]) for r in rows}
    assert len(rows) == len(cells) == 24
    assert all(0 <= float(r["reading / mm"]) <= 10 and len(r["reading / mm"].partition(".")[2]) == 2 for r in rows)


@pytest.mark.study
def test_twice_the_script_makes_the_shipped_readings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(TAPES))
    import reconstruct_elongation as script  # type: ignore[import-not-found]

    for tape in script.TAPES:
        readings, masses = script.search(tape)
        assert script.text(readings) == (TAPES / tape.file).read_text(encoding="utf-8")
        assert masses.tolist() == pytest.approx(
            [float(m) for m in PUBLISHED[tape.file.removesuffix("-elongation.csv")][0]]
        )
    del sys.modules["reconstruct_elongation"]


# ---------------------------------------------------------------- readings that are not repeated


def single(values: np.ndarray, masses: dict[str, float]) -> list[Reading]:
    return [
        Reading(name, "1", "loading", float(x), line=at + 2)
        for at, (name, x) in enumerate(zip(masses, values, strict=True))
    ]


SIX = {name: 0.1 * at for at, name in enumerate("ABCDEF")}


def test_closed_form_one_reading_a_load_is_the_regression_of_a_textbook() -> None:
    """Draper & Smith, Applied Regression Analysis (1998), 1.4: s² = Σ(y − ŷ)²/(n − 2), u(b) = s/√Σ(x − x̄)²."""
    forces = np.array([mass * G * (1 - AIR / STEEL) for mass in SIX.values()])
    y = 0.02 + forces / 100 + 1e-4 * np.random.default_rng(4).standard_normal(len(SIX))
    exact = {name: Load(name, Input(f"t.load {name}", mass, (), "kg")) for name, mass in SIX.items()}
    fixed = {
        "loads": tuple(exact.values()), "resolution": Component("resolution", Rectangular(1e-9)), "indicator": (),
        "weights": None, "gravity": replace(GRAVITY, components=()), "air_density": replace(AIR_DENSITY, components=()),
        "weight_density": replace(WEIGHT_DENSITY, components=()),
    }  # fmt: skip
    found = analyse(build(single(y, SIX), SIX, **fixed))
    line = stats.linregress(forces, y)
    law = estimate(found)
    assert value(found) == pytest.approx(1 / line.slope)
    assert law.u == pytest.approx(line.stderr / line.slope**2, rel=1e-6)
    assert law.dof == pytest.approx(len(SIX) - 2)
    assert verdicts(found)["linearity (lack of fit)"] is None
    assert "about the line" in found.finding.notes[-2]


def test_limit_two_repeats_have_a_scatter_of_their_own() -> None:
    found = analyse(build(cycle(noisy(), repeats=2, masses=SIX), SIX))
    assert verdicts(found)["linearity (lack of fit)"] is True
    assert not any("about the line" in note for note in found.finding.notes)


def test_planted_single_readings_hold_the_truth_as_often_as_they_say() -> None:
    """Coverage of the t interval over 300 tests with six readings each."""
    held = 0
    for seed in range(300):
        forces = np.array([mass * G * (1 - AIR / STEEL) for mass in SIX.values()])
        y = 0.02 + forces / 100 + 1e-4 * np.random.default_rng([7, seed]).standard_normal(len(SIX))
        found = analyse(build(single(y, SIX), SIX))
        held += abs(1 / found.finding.slope - 100) < stats.t.ppf(0.975, 4) * found.finding.slope_u * 100**2
    assert 276 <= held <= 297, held


def test_planted_an_outlying_reading_of_one_repeat_is_named() -> None:
    masses = {f"L{at}": 0.1 * at for at in range(10)}
    forces = np.array([mass * G * (1 - AIR / STEEL) for mass in masses.values()])
    y = 0.02 + forces / 100 + 1e-4 * np.random.default_rng(2).standard_normal(10)
    y[6] += 2e-3
    (check,) = [one for one in analyse(build(single(y, masses), masses)).finding.checks if one.name == "outlier"]
    assert check.passed is False
    assert "load L6" in check.sentence
    assert "from the line" in check.sentence


def test_refusal_of_fewer_readings_than_have_a_scatter() -> None:
    masses = {name: SIX[name] for name in "ABCD"}
    (message,) = _refused(single(np.arange(4.0), masses), masses)
    assert message.startswith("t.readings: got 4 readings in 1 repeat; expected at least 5")
