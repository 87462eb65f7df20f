"""Whether two `results.json` agree: rounding, and whatever is more than that."""

from __future__ import annotations

import json

import pytest

from metrology.signoff.agreement import compare

ONE = {
    "software": {"numpy": "1"},
    "results": [{"value": 12.5, "u": 0.1, "unit": "N/m"}],
    "list": [1.0, 1e-12],
    "r": 1e-17,
}


def pair(**changed):
    return json.dumps(ONE).encode(), json.dumps({**ONE, **changed}).encode()


def result(**changed):
    return {"results": [{**ONE["results"][0], **changed}]}


@pytest.mark.parametrize(
    "changed",
    [{}, {"software": {"numpy": "2"}}],
)
def test_law_the_same_results_agree_to_the_last_bit_whatever_made_them(changed):
    found = compare(*pair(**changed))
    assert found.exact
    assert found.sentence == "to the last bit"


@pytest.mark.parametrize(
    "changed",
    [
        result(value=12.5 * (1 + 5e-10)),  # rounding of the value itself
        {"list": [1.0, 1e-12 + 5e-10]},  # of the list that it stands in
        {"r": -3e-17},  # of what is zero
    ],
)
def test_limit_rounding_agrees_and_says_so(changed):
    found = compare(*pair(**changed))
    assert found.agrees
    assert not found.exact
    assert found.sentence == "within 1e-09, or 1e-07 u, all texts the same"
    assert 0 < found.largest <= 1e-9


@pytest.mark.parametrize(
    ("changed", "place"),
    [
        (result(value=12.5 * (1 + 2e-9)), "results[0].value"),
        (result(unit="kN/m"), "results[0].unit"),
        ({"list": [1.0]}, "list"),
        ({"list": [1.0, 1e-12 + 2e-9]}, "list[1]"),
        ({"r": 2e-15}, "r"),
        ({"r": True}, "r"),
        (result(value=None), "results[0].value"),
        (result(value=float("nan")), "results[0].value"),
    ],
)
def test_refusal_more_than_rounding_is_named(changed, place):
    found = compare(*pair(**changed))
    assert not found.agrees
    assert found.sentence.startswith(f"1 entry differs, the first: {place}: ")


def test_law_a_small_value_is_judged_by_its_uncertainty():
    near = [{"results": [{"value": value, "u": 1.0}]} for value in (1e-12, 4e-10)]
    assert compare(*(json.dumps(one).encode() for one in near)).agrees


def test_refusal_what_has_another_unit_is_not_excused_by_a_large_uncertainty():
    """A modulus in pascal has u of 10⁹: its degrees of freedom are still compared by themselves."""
    pair_of = [{"results": [{"value": 6e10, "u": 3e9, "dof": dof, "share": 0.5}]} for dof in (7.0, 9.0)]
    found = compare(*(json.dumps(one).encode() for one in pair_of))
    assert [text.partition(":")[0] for text in found.differences] == ["results[0].dof"]


def test_law_differences_of_ends_are_as_exact_as_the_ends():
    ends = [{"low": 2.4e4, "high": 2.5e4, "u": 1.0, "d_low": 12.5 + more} for more in (0.0, 2e-6, 1e-4)]
    texts = [json.dumps(one).encode() for one in ends]
    assert compare(texts[0], texts[1]).agrees
    assert not compare(texts[0], texts[2]).agrees


@pytest.mark.parametrize(("y", "agrees"), [(1.23458, True), (1.23459, False)])
def test_limit_points_of_pictures_have_six_digits(y, agrees):
    one, other = ({"series": [{"y": [value, 1e-12], "u": 0.1}]} for value in (1.23457, y))
    assert compare(json.dumps(one).encode(), json.dumps(other).encode()).agrees is agrees


@pytest.mark.parametrize(("by", "agrees"), [(2e-4, True), (2e-3, False)])
def test_limit_points_with_bars_are_known_to_their_bars(by, agrees):
    one, other = ({"curves": [{"y": [-0.00388871 + more, 1e3], "u": [0.05, 1.0]}]} for more in (0.0, by))
    assert compare(json.dumps(one).encode(), json.dumps(other).encode()).agrees is agrees


@pytest.mark.parametrize(
    ("place", "near", "far"),
    [
        (("probability",), 5e-8, 2e-7),  # of a whole
        (("budget", 1, "contribution"), 5e-8, 5e-7),  # of the combined u of 1
        (("budget", 1, "u"), 1e-8, 1e-7),  # which is five times as large there
        (("sources", 0, "columns", 0, 1), 5e-8, 5e-7),  # of √(1² + 0.001²)
        (("budget", 1, "effective"), 1e-13, 1e-11),  # relative to itself
    ],
)
def test_limit_parts_are_compared_with_their_whole(place, near, far):
    def changed(by):
        one = {
            "probability": 1e-4,
            "framework": {"u": 1.0},
            "budget": [
                {"u": 1.0, "contribution": 1.0, "effective": 1.0},
                {"u": 2e-4, "contribution": 1e-3, "effective": 1e-3},
            ],
            "sources": [{"columns": [[1.0, 1e-3]]}],
        }
        node = one
        for key in place[:-1]:
            node = node[key]
        node[place[-1]] += by
        return json.dumps(one).encode()

    assert compare(changed(0.0), changed(near)).agrees
    assert not compare(changed(0.0), changed(far)).agrees


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"names": ["k", "E"], "values": [48.0, 4e8]}, {"names": ["k", "E"], "values": [48.3, 4e8]}),
        ({"value": 4.00e-12, "u": 5e-14}, {"value": 4.09e-12, "u": 5e-14}),
        ({"seed": 12345678901}, {"seed": 12345678902}),
        (
            {"framework": {"u": 1.0}, "budget": [{"u": 2e-3, "contribution": 1e-8}]},
            {"framework": {"u": 1.0}, "budget": [{"u": 2e-2, "contribution": 1e-8}]},
        ),
    ],
    ids=["units of their own", "small in SI", "counts", "rows that change little"],
)
def test_refusal_a_change_is_not_hidden_beside_large_numbers(one, other):
    found = compare(json.dumps(one).encode(), json.dumps(other).encode())
    assert len(found.differences) == 1


@pytest.mark.parametrize(
    ("one", "near", "far"),
    [
        ({"low": 2.97, "high": 3.02}, 4e-9, 4e-8),  # of an interval of 0.05
        ({"level": 1e-3}, 5e-11, 5e-10),  # of itself: a standard deviation
        ({"rule_risk": 0.5, "resolution": 3e-6}, 1e-6, 1e-5),  # of so many draws
        ({"rule_risk": 0.5}, 4e-10, 1e-6),  # of none
    ],
)
def test_limit_numbers_are_compared_with_what_is_known_of_them(one, near, far):
    key = next(iter(one))
    texts = [json.dumps({**one, key: one[key] + by}).encode() for by in (0.0, near, far)]
    assert compare(texts[0], texts[1]).agrees
    assert not compare(texts[0], texts[2]).agrees


def test_limit_the_density_of_draws_is_a_picture():
    one, other = ({"density": [1722.98976 + more, 3000.0]} for more in (0.0, 1e-3))
    assert compare(json.dumps(one).encode(), json.dumps(other).encode()).agrees
