import numpy as np
import pytest
from uncertainties import ufloat

from metrology.gum.functions import FUNCTIONS, absolute, maximum, minimum

TWO = {"atan2", "min", "max"}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("x", [0.3, 0.7])
def test_twice_floats_arrays_and_variables_agree(name, x):
    function = FUNCTIONS[name]
    rest = (0.5,) if name in TWO else ()
    plain = function(x, *rest)
    assert function(np.array([x]), *rest)[0] == pytest.approx(plain, rel=1e-15)
    variable = ufloat(x, 1.0)
    result = function(variable, *rest)
    step = 1e-6
    slope = (function(x + step, *rest) - function(x - step, *rest)) / (2 * step)
    assert getattr(result, "nominal_value", result) == pytest.approx(plain, rel=1e-15)
    assert getattr(result, "derivatives", {}).get(variable, 0.0) == pytest.approx(slope, rel=1e-8)


def test_closed_form_absolute_value_turns_the_sign_of_the_derivative():
    x = ufloat(-2.0, 1.0)
    assert absolute(x).derivatives[x] == -1.0
    assert absolute(-2.0) == 2.0


def test_closed_form_extremes_of_arrays_are_taken_draw_by_draw():
    x, y = np.array([1.0, 4.0]), np.array([2.0, 3.0])
    assert minimum(x, y).tolist() == [1.0, 3.0]
    assert maximum(x, 2.5).tolist() == [2.5, 4.0]


def test_refusal_outside_the_domain():
    with pytest.raises(ValueError, match="math domain error"):
        FUNCTIONS["sqrt"](-1.0)
