import numpy as np
import pytest

from metrology import gum
from metrology.errors import MetrologyError
from metrology.gum.readings import mean, standard_deviation

NUMACC = {
    "NumAcc1": ([10000001, 10000003, 10000002], 10000002, 1.0, 1e-15),
    "NumAcc2": ([1.2, *[1.1, 1.3] * 500], 1.2, 0.1, 1e-14),
    # The decimals of the last two sets are not floats: their own rounding leaves 9.5 and 8.3 digits of s.
    "NumAcc3": ([1000000.2, *[1000000.1, 1000000.3] * 500], 1000000.2, 0.1, 10**-9.4),
    "NumAcc4": ([10000000.2, *[10000000.1, 10000000.3] * 500], 10000000.2, 0.1, 10**-8.2),
}


@pytest.mark.parametrize("name", NUMACC)
def test_reference_nist_univariate_sets_with_large_offsets(name):
    readings, certified_mean, certified_s, tolerance = NUMACC[name]
    assert mean(readings) == pytest.approx(certified_mean, rel=1e-15)
    assert standard_deviation(readings) == pytest.approx(certified_s, rel=tolerance)


def test_reference_gum_h2_means_and_correlations():
    means, ensemble = gum.simultaneous(
        "readings",
        {
            "V": [5.007, 4.994, 5.005, 4.990, 4.999],
            "I": [19.663, 19.639, 19.640, 19.685, 19.678],
            "phi": [1.0456, 1.0438, 1.0468, 1.0428, 1.0433],
        },
    )
    s = np.sqrt(np.diag(ensemble.covariance))
    r = ensemble.covariance / np.outer(s, s)
    assert {key: round(value, 5) for key, value in means.items()} == {"V": 4.999, "I": 19.661, "phi": 1.04446}
    assert [round(v, d) for v, d in zip(s, (4, 4, 5), strict=True)] == [0.0032, 0.0095, 0.00075]
    assert [round(r[0, 1], 2), round(r[0, 2], 2), round(r[1, 2], 2)] == [-0.36, 0.86, -0.65]
    assert ensemble.dof == 4
    assert not ensemble.covariance.flags.writeable


def test_closed_form_observed_input_keeps_its_other_components():
    other = gum.Component("resolution", gum.Rectangular(0.005))
    item = gum.observed("x", [1.0, 2.0, 3.0], components=[other], unit="m", source="x.csv")
    assert item.value == 2.0
    assert item.components[0].dof == 2
    assert item.components[0].kind == "A"
    assert item.u**2 == pytest.approx(1 / 3 + 0.005**2 / 3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gum.type_a("x", [1.0]), "x: got 1 reading; expected at least two readings"),
        (lambda: gum.type_a("x", []), "x: got 0 readings; expected at least two readings"),
        (
            lambda: gum.type_a("x", [1.0, float("nan"), float("inf")]),
            "x[1]: got nan; expected a finite number\nx[2]: got inf; expected a finite number",
        ),
        (
            lambda: gum.simultaneous("set", {"a": [1.0, 2.0], "b": [1.0, 2.0, 3.0]}),
            "set: got series of different length {'a': 2, 'b': 3}; expected one reading of each for every occasion",
        ),
    ],
)
def test_refusal_of_readings(call, message):
    with pytest.raises(MetrologyError) as error:
        call()
    assert str(error.value) == message
