"""Records that are copies of one another, by whatever name, shift or test."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from metrology.campaign.copies import check_copies, of_one_record

RNG = np.random.default_rng(11)


def record(path, **numbers):
    source = SimpleNamespace(path=path, sha256=path)
    return SimpleNamespace(name=path, source=source, numbers={"time": np.arange(400.0), **numbers})


def pull():
    """Force of a pull with noise of some steps of its last digit, and the crosshead as it was commanded."""
    force = np.round(np.linspace(0.0, 4000.0, 400) + RNG.normal(0.0, 0.4, 400), 1)
    return {"force": force, "crosshead": np.linspace(0.0, 5e-3, 400)}


def campaign(tests, samples):
    return SimpleNamespace(
        tables={("tests", name): tables for name, tables in tests.items()},
        tests={name: SimpleNamespace(sample=sample) for name, sample in samples.items()},
    )


def faults(tests, samples):
    return [(one.where, one.got) for one in check_copies(campaign(tests, samples))]


def test_records_of_their_own_pass_though_the_crosshead_moves_alike_in_all():
    assert faults({"a": [record(f"{i}.csv", **pull()) for i in range(30)]}, {"a": "line"}) == []


@pytest.mark.parametrize("shift", [0.0, 0.01, -37.5])
def test_a_copy_is_found_whatever_constant_was_added(shift):
    first = pull()
    other = {**first, "force": first["force"] + shift}
    tables = [record(f"{i}.csv", **pull()) for i in range(5)]
    found = faults({"a": [record("first.csv", **first), *tables, record("copy.csv", **other)]}, {"a": "line"})
    assert found == [("copy.csv", "readings 'crosshead, force' of 'first.csv' a second time")]


@pytest.mark.parametrize("part", [slice(0, 140), slice(260, 400)])
def test_a_third_of_a_record_in_another_one_is_found(part):
    first, other = pull(), pull()
    other["force"][part] = first["force"][part]
    found = faults({"a": [record("first.csv", **first), record("mixed.csv", **other)]}, {"a": "line"})
    assert found == [("mixed.csv", "readings 'crosshead, force' of 'first.csv' a second time")]


def test_a_copy_is_found_beside_empty_cells():
    first = pull()
    first["force"][[7, 390]] = np.nan
    other = {**first, "force": first["force"] + 2.5}
    found = faults({"a": [record("first.csv", **first), record("copy.csv", **other)]}, {"a": "line"})
    assert found == [("copy.csv", "readings 'crosshead, force' of 'first.csv' a second time")]


def test_motions_that_have_died_away_are_no_copies():
    t = np.arange(4000.0) / 100
    tables = [record(f"{a}.csv", x=a * np.exp(-t) * np.cos(6 * t + a)) for a in (1.0, 1.1, 1.2)]
    assert faults({"a": tables}, {"a": "line"}) == []


def test_a_record_of_one_sample_is_none_of_another_but_two_tests_may_evaluate_it():
    one = pull()
    tests = {"a": [record("a.csv", **one)], "b": [record("b.csv", **one)]}
    assert len(faults(tests, {"a": "first", "b": "second"})) == 1
    assert faults(tests, {"a": "first", "b": "first"}) == []


def test_a_file_that_two_samples_name_is_found_unless_they_read_other_parts_of_it():
    one, other = pull(), pull()
    samples = {"a": "first", "b": "second"}
    assert len(faults({"a": [record("a.csv", **one)], "b": [record("a.csv", **one)]}, samples)) == 1
    assert faults({"a": [record("a.csv", **one)], "b": [record("a.csv", **other)]}, samples) == []


def test_limit_a_file_of_which_two_samples_read_other_columns_is_no_copy():
    force, crosshead = pull().values()
    tests = {"a": [record("a.csv", force=force)], "b": [record("a.csv", crosshead=crosshead)]}
    assert faults(tests, {"a": "first", "b": "second"}) == []


@pytest.mark.long
def test_of_a_thousand_records_the_one_copy_is_found():
    records = [record(f"{i}.csv", **pull()) for i in range(1000)]
    found = faults({"a": [*records, record("copy.csv", **records[700].numbers)]}, {"a": "line"})
    assert [where for where, _ in found] == ["copy.csv"]


def test_two_tests_evaluate_one_record_where_they_select_the_same_of_a_file():
    """Two dials beside each other in one file are two measurements."""
    first, other = RNG.normal(0.0, 1e-3, 20), RNG.normal(0.0, 1e-3, 20)
    tables = {"a": [record("f.csv", reading=first)], "b": [record("f.csv", reading=other)],
              "c": [record("g.csv", reading=first[::-1])]}  # fmt: skip
    assert of_one_record(campaign(tables, dict.fromkeys("abc", "line"))) == {frozenset("ac")}
    assert of_one_record(campaign(tables, {"a": "line", "b": "line", "c": "cord"})) == set()


def swing():
    t = np.arange(400.0) / 50
    return np.round(0.05 * np.exp(-0.2 * t) * np.cos(6 * t) + RNG.normal(0.0, 2e-5, 400), 7)


def test_a_decay_and_a_response_evaluate_one_record_though_each_names_it_otherwise():
    """The cell stands beside the position in the one; another release, or the same thrust, is no copy."""
    motion, force, thrust = swing(), RNG.normal(1.0, 0.01, 400), np.repeat([0.0, 0.6, 0.0, 0.3], 100)
    tables = {"swing": [record("s.csv", displacement=motion)], "ride": [record("r.csv", x=motion, T=force)],
              "other": [record("o.csv", x=swing(), F=thrust)], "again": [record("a.csv", x=swing(), F=thrust)],
              "part": [record("p.csv", x=np.concatenate([swing()[:100], motion[150:]]))]}  # fmt: skip
    same = {frozenset(pair) for pair in (("swing", "ride"), ("swing", "part"), ("ride", "part"))}
    assert of_one_record(campaign(tables, dict.fromkeys(tables, "line"))) == same


def test_limit_of_two_channels_in_each_record_one_alike_makes_no_copy():
    """A crosshead that is driven by one waveform in two tests."""
    waveform = np.round(np.cumsum(RNG.normal(0.0, 1e-4, 400)), 7)
    tables = {"pull": [record("p.csv", crosshead=waveform, force=pull()["force"])],
              "creep": [record("c.csv", elongation=waveform, load=pull()["force"])]}  # fmt: skip
    assert of_one_record(campaign(tables, dict.fromkeys(tables, "line"))) == set()
