"""Readings as arrays: the same numbers as from files, in every container; what is no table is refused by its place."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import metrology
from metrology.api.arrays import taken_out

TIME = np.arange(0, 2, 1 / 500)
MOTION = 1e-3 * np.exp(-2 * TIME) * np.cos(100 * TIME) + 2e-7 * np.random.default_rng(5).standard_normal(TIME.size)
SWING = {"mass": "1.196(1) kg", "instruments": {"displacement": {"resolution": "0.1 um"}}}
LOADS = {"A": {"force": "10.0(1) N"}, "B": {"force": "20.0(1) N"}, "C": {"force": "30.0(1) N"}}
READ = {
    "load": [*"ABCABC"],
    "repeat": [1, 1, 1, 2, 2, 2],
    "reading / mm": np.array([0.41, 0.79, 1.20, 0.40, 0.81, 1.19]),
}
PULL = {"loads": LOADS, "instruments": {"extension": {"resolution": "0.01 mm"}}}


def swing(table: object) -> metrology.Results:
    return metrology.identify("decay", readings=[table], **SWING)


def numbers(results: metrology.Results) -> dict[str, tuple[object, ...]]:
    return {name: (one.value, one.u, one.dof, one.interval) for name, one in results.items()}


@pytest.fixture(scope="module")
def of_arrays() -> dict[str, tuple[object, ...]]:
    return numbers(swing({"time / s": TIME, "displacement / m": MOTION}))


def structured() -> np.ndarray:
    table = np.zeros(TIME.size, dtype=[("time / s", float), ("displacement / m", float)])
    table["time / s"], table["displacement / m"] = TIME, MOTION
    return table


CONTAINERS = {
    "lists": {"time / s": TIME.tolist(), "displacement / m": MOTION.tolist()},
    "structured": structured(),
    "pandas": pd.DataFrame({"time / s": TIME, "displacement / m": MOTION}),
    "index": pd.DataFrame({"displacement / m": MOTION}, index=pd.Index(TIME, name="time / s")),
    "nullable": pd.DataFrame({"time / s": TIME, "displacement / m": pd.array(MOTION, dtype="Float64")}),
    "xarray": xr.Dataset({"displacement": ("time", MOTION, {"units": "m"})}, {"time": ("time", TIME, {"units": "s"})}),
    "series": {"time / s": pd.Series(TIME), "displacement / m": xr.DataArray(MOTION, dims="n")},
}


@pytest.mark.long
@pytest.mark.parametrize("container", CONTAINERS)
def test_twice_every_container_gives_the_same_numbers(container, of_arrays):
    assert numbers(swing(CONTAINERS[container])) == of_arrays


@pytest.mark.long
def test_twice_files_give_what_arrays_give(tmp_path):
    """A loaded campaign of CSV files, written by NumPy and pandas, against the dictionary with arrays."""
    stated = {
        "format": "metrology-campaign/1",
        "id": "both",
        "title": "Both",
        "monte_carlo": {"max_trials": 20000},
        "instruments": {"gauge": {"kind": "gauge", "resolution": "0.01 mm"}, "laser": {"kind": "vibrometer"}},
        "samples": {"line": {"length": "2.000(1) m"}},
        "tests": {
            "pull": {"method": "elongation", "sample": "line", "instruments": {"extension": "gauge"}, "loads": LOADS},
            "swing": {"method": "decay", "sample": "line", "instruments": {"displacement": "laser"}},
        },
    }  # fmt: skip
    motion = {"time / s": TIME, "displacement / m": MOTION}
    pd.DataFrame(READ).to_csv(tmp_path / "read.csv", index=False)
    np.savetxt(tmp_path / "motion.csv", np.c_[TIME, MOTION], "%.17g", ",", header=",".join(motion), comments="")

    def evaluated(read: object, swung: object) -> metrology.Results:
        pull, swing = ({**one} for one in stated["tests"].values())
        pull["readings"], swing["readings"], swing["mass"] = read, [swung], "1.2(1) kg"
        return metrology.run({**stated, "tests": {"pull": pull, "swing": swing}}, folder=tmp_path)

    first, second = evaluated("read.csv", "motion.csv"), evaluated(READ, motion)
    assert numbers(first) == numbers(second)
    assert [one.sentence for one in first.diagnosis] == [one.sentence for one in second.diagnosis]


def test_twice_the_files_of_a_report_evaluate_to_the_same_results(tmp_path):
    """What is attached to the report of arrays is a campaign of its own."""
    from metrology.campaign.sources import read_sources

    results = metrology.identify("elongation", readings=READ, **PULL)
    for name, content in read_sources(results.campaign).items():
        (tmp_path / name).write_bytes(content)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["campaign.yaml", "elongation.csv"]
    assert metrology.run(tmp_path, coverage=False).to_json() == results.to_json()


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20))
def test_law_no_digit_of_a_double_is_lost(values):
    _, handed = taken_out({"tests": {"a": {"readings": {"x / m": np.array(values)}}}})
    heading, *cells = handed.contents["a.csv"].decode().splitlines()
    assert heading == "x / m"
    assert [float(cell) for cell in cells] == values


def test_law_draws_and_curves_are_tables_of_pandas_and_xarray():
    found = swing({"time / s": TIME, "displacement / m": MOTION})
    draws = xr.Dataset({name: ("trial", row) for name, row in found.draws.items()})
    assert float(draws["decay.k"].std(ddof=1)) == pytest.approx(found.k.result.monte_carlo.u, rel=1e-6)
    ((name, columns),) = found.curves.items()
    assert name == "decay/decay/decay-1.csv"
    frame = pd.DataFrame(columns)
    # Stamps count from the release, which is the first reading but for less than one of them.
    assert np.ptp(frame["time"] - TIME[: len(frame)]) < 1e-9
    assert (frame["displacement"] - frame["fit"]).std() == pytest.approx(2e-7, rel=0.1)


@pytest.mark.long
def test_law_a_gap_is_nan_masked_or_missing():
    gaps = MOTION.copy()
    gaps[[100, 700]] = np.nan
    masked = np.ma.masked_array(MOTION, np.isnan(gaps))
    missing = pd.array(MOTION, dtype="Float64")
    missing[[100, 700]] = pd.NA
    objects = [None if one != one else one for one in gaps.tolist()]
    every = (gaps, masked, missing, objects, pd.Series(objects, dtype=object), missing.astype(object))
    first, *others = [numbers(swing({"time / s": TIME, "displacement / m": one})) for one in every]
    assert all(other == first for other in others)


def test_law_a_name_of_a_file_of_the_dictionary_is_not_taken():
    stated = {"tests": {"a": {"readings": {"x / m": np.ones(2)}}, "b": {"readings": "a.csv"}}}
    plain, _ = taken_out(stated)
    assert plain["tests"] == {"a": {"readings": "a-1.csv"}, "b": {"readings": "a.csv"}}


def test_law_every_table_has_a_file_of_its_own():
    """Runs with several files, specimens, a sweep beside them: wherever a file may be named."""
    one = {"x / m": np.ones(2)}
    runs = {"a": {"readings": [one, one]}, "b": {"readings": [one]}}
    stated = {"swing": {"runs": runs}, "hold": {"specimens": {"s1": {"readings": one}}, "dma": one}}
    _, handed = taken_out({"tests": stated, "fits": {"cal": {"readings": one}}})
    runs_of = ["swing-runs-a-1.csv", "swing-runs-a-2.csv", "swing-runs-b-1.csv"]
    assert list(handed.contents) == [*runs_of, "hold-specimens-s1.csv", "hold-dma.csv", "fits-cal.csv"]


def test_twice_columns_of_other_names_are_stated_as_for_a_file(of_arrays):
    names = {"time": {"column": "t", "unit": "s"}, "displacement": {"column": "signal", "unit": "m"}}
    frame = pd.DataFrame({"t": TIME, "signal": MOTION, "other": np.nan})
    assert numbers(swing({"file": frame, "columns": names})) == of_arrays


@pytest.mark.long
def test_planted_k_and_c_of_runs_under_thrust():
    """A module on a line that is slack at first, by SciPy: position and tension on clocks of their own."""
    from scipy.integrate import solve_ivp

    mass, k, c, taut = 25.0, 150.0, 5.0, 1.5
    rng = np.random.default_rng(4)

    def tension(x, v):
        return np.where(x > taut, np.maximum(0, k * (x - taut) + c * v), 0.0)

    def run(force: float, stop: float) -> dict[str, object]:
        def law(t, s):
            return s[1], ((force if 1 <= t < stop else 0.0) - tension(*s)) / mass

        stamps = np.arange(0, 20, 0.01)
        x, v = solve_ivp(law, (0, 20), (1.4, 0), t_eval=stamps, max_step=0.01, rtol=1e-9, atol=1e-11).y
        read = {"time / s": stamps, "x / mm": 1e3 * (x + rng.normal(0, 2e-4, x.size))}
        pulled = {"time / s": stamps[::2], "T / N": (tension(x, v) + rng.normal(0, 4e-3, x.size))[::2]}
        thrust = [{"from": "1 s", "to": f"{stop} s", "force": f"{force} N"}]
        return {"readings": [read, pulled], "thrust": thrust, "start": {"position": "1.400 m"}}

    found = metrology.identify(
        "response",
        runs={"gentle": run(0.38, 8.0), "hard": run(0.8, 6.0)},
        rig={"mass": "25.00(1) kg", "taut": "1.500(1) m"},
        identification={"free": ["k", "c"], "start": {"k": "120 N/m"}},
        instruments={},
    )
    assert abs(found.k.value - k) < 3 * found.k.u < 0.5
    assert abs(found.c.value - c) < 3 * found.c.u < 0.05


def test_law_times_of_day_are_stamps():
    clock = np.datetime64("2026-10-05T10:00:00") + (TIME * 1e6).astype("timedelta64[us]")
    found = swing({"time": clock, "displacement / m": MOTION})
    assert found.omega_n.value == pytest.approx(100.02, rel=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("zone", ["UTC", "Europe/Rome"])
def test_twice_stamps_of_a_time_zone_are_those_of_utc(zone: str):
    """The clock of Rome is set back an hour in the midst of the record: one hour comes twice there."""
    plain = pd.Series(pd.Timestamp("2026-10-25T00:59:59") + pd.to_timedelta(TIME, unit="s"))
    stamps = plain.dt.tz_localize("UTC").dt.tz_convert(zone)
    of_utc, aware, objects = (
        numbers(swing({"time": one, "displacement / m": MOTION}))
        for one in (plain, stamps, [one.to_pydatetime() for one in stamps])
    )
    assert aware == objects == of_utc


def replaced(array: np.ndarray, at: int, value: object) -> np.ndarray:
    made = array.copy()
    made[at] = value
    return made


REFUSED = {
    "two dimensions": ({"displacement / m": MOTION.reshape(2, -1)}, "got an array of shape (2, 500)"),
    "lengths": ({"time / s": TIME[:-1]}, ": got columns of several lengths, 'time / s': 999, 'displacement / m': 1000"),
    "infinity": ({"displacement / m": replaced(MOTION, 7, np.inf)}, "['displacement / m'][7]: got inf"),
    "a gap among stamps": ({"time / s": replaced(TIME, 7, np.nan)}, "[7] time / s: got an empty cell"),
    "stamps": ({"time / s": replaced(TIME, 5, TIME[3])}, "[5] time / s: got 0.006 after 0.008; expected time stamps"),
    "objects": ({"displacement / m": MOTION.astype(object)}, "['displacement / m'][0]: got "),
    "complex": ({"displacement / m": MOTION + 0j}, "['displacement / m']: got an array of type complex128"),
    "spans": ({"time / s": (TIME * 1e9).astype("timedelta64[ns]")}, "Fix: divide a time span"),
    "a unit of its own": ({"time / s": pint.UnitRegistry().Quantity(TIME, "ms")}, "got an array with a unit"),
    "another unit": ({"displacement / s": MOTION}, "'displacement / s', a time; expected a length"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refusal_names_the_column_and_the_index(case):
    changed, told = REFUSED[case]
    table = {"time / s": TIME, "displacement / m": MOTION} | changed
    if case == "another unit":
        del table["displacement / m"]
    with pytest.raises(metrology.MetrologyError, match=re.escape(told)) as caught:
        swing(table)
    assert str(caught.value).startswith("tests.decay.readings[0]")


def test_refusal_of_a_column_without_a_unit():
    with pytest.raises(metrology.MetrologyError, match="got 'displacement', without a unit; expected a length"):
        swing({"time / s": TIME, "displacement": MOTION})
    with pytest.raises(metrology.MetrologyError, match="which has no unit; expected a time, such as 'time / s'"):
        swing({"time": TIME, "displacement / m": MOTION})


def test_refusal_of_a_heading_twice_and_of_no_rows():
    frame = pd.DataFrame(np.c_[TIME, MOTION, MOTION], columns=["time / s", "displacement / m", "displacement / m"])
    with pytest.raises(
        metrology.MetrologyError, match=r"readings\[0\]: got the heading 'displacement / m' a second time"
    ):
        swing(frame)
    with pytest.raises(metrology.MetrologyError, match=r"readings\[0\]: got no readings below the heading"):
        swing(frame.iloc[:0, :2])


def test_refusal_of_what_is_no_table():
    with pytest.raises(metrology.MetrologyError, match=r"got an array of shape \(1000,\) alone; expected a table"):
        swing(MOTION)
    with pytest.raises(metrology.MetrologyError, match="got one table; expected a list"):
        metrology.identify("decay", readings={"time / s": TIME, "displacement / m": MOTION}, **SWING)
    with pytest.raises(
        metrology.MetrologyError, match=r"readings\['reading / mm'\]\[1\]: got nan in an array of type object"
    ):
        metrology.identify("elongation", readings=pd.DataFrame(READ | {"reading / mm": ["1", None, *"3456"]}), **PULL)


def test_refusal_of_another_method_and_of_a_key_that_it_does_not_have():
    with pytest.raises(metrology.MetrologyError, match="got 'bending'; expected one of "):
        metrology.identify("bending")
    with pytest.raises(metrology.MetrologyError, match="Fix: did you mean 'mass'"):
        metrology.identify("decay", readings=[{"time / s": TIME, "displacement / m": MOTION}], **SWING, masse="1 kg")


@pytest.mark.long
def test_planted_hardening_is_found_and_named():
    """m·x″ + c·x′ + k·(x + ε·x³) = 0, solved to 1e-10: `diagnose` names the stiffness."""
    from scipy.integrate import solve_ivp

    mass, k, c, cubic = 1.2, 12000.0, 4.8, 2e4

    def law(_t, s):
        return (s[1], -(c * s[1] + k * (s[0] + cubic * s[0] ** 3)) / mass)

    motion = solve_ivp(law, (0, 4), (1e-3, 0), t_eval=np.arange(0, 4, 1 / 1000), rtol=1e-10, atol=1e-13)
    read = motion.y[0] + 2e-7 * np.random.default_rng(2).standard_normal(motion.t.size)
    table = {"time / s": motion.t, "displacement / m": read}
    stated = {"readings": [table], "mass": "1.2000(1) kg", "instruments": {"displacement": {"resolution": "0.1 um"}}}
    found = metrology.diagnose("decay", **stated)
    assert "hardening" in found.diagnosis[0].sentence
    assert found.k.value == pytest.approx(k, rel=1e-3)
    assert metrology.identify("decay", **stated).diagnosis == ()
