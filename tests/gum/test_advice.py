import numpy as np
import pytest
from gum_models import knowledge, model, quantity

from metrology import gum, ties
from metrology.gum import Normal, Rectangular, regression


def estimate(expression, inputs, name="E", unit="Pa"):
    return gum.evaluate([model(expression, name, unit)], inputs, seed=1, max_trials=1000).estimates[name]


def test_closed_form_dominating_input_and_what_it_needs():
    inputs = knowledge(
        quantity("k", 24734.25, Normal(335.52), unit="N/m"),
        quantity("thickness", 5e-5, Normal(2.7e-6), unit="m"),
    )
    advice = estimate("k*2.99/(0.025*thickness)", inputs).advice
    assert advice == (
        "thickness has the largest part in u(E), 94% of u²; for u(E) to halve to 1.6 GPa,"
        " its u would have to fall from 2.7 µm to 1.2 µm."
    )


def test_law_following_the_advice_halves_u():
    def state(u):
        return knowledge(quantity("a", 1.0, Normal(u)), quantity("b", 1.0, Normal(0.2)), correlations={("a", "b"): 0.3})

    before = estimate("a + b", state(1.0), "y", "1")
    needed = float(before.advice.split()[-1].rstrip("."))
    assert estimate("a + b", state(needed), "y", "1").u == pytest.approx(before.u / 2, rel=0.02)


def test_limit_where_one_input_alone_cannot_halve_u():
    inputs = knowledge(quantity("a", 1.0, Normal(1.0), Rectangular(0.5)), quantity("b", 1.0, Normal(1.0)))
    assert estimate("a + b", inputs, "y", "m").advice == (
        "a has the largest part in u(y), 52% of u² (mainly by its component 'c0'), but improving it alone cannot halve"
        " u(y): even without it u(y) would only fall from 1.4 m to 1.0 m; next comes b with 48%."
    )


def test_limit_strong_correlation_that_helps_is_no_lever():
    inputs = knowledge(
        quantity("a", 1.0, Normal(1.0)), quantity("b", 1.0, Normal(0.98)), correlations={("a", "b"): 0.99}
    )
    assert "cannot halve u(y)" in estimate("a - b", inputs, "y").advice


def test_closed_form_readings_of_an_ensemble_improve_together():
    ensemble = gum.Ensemble("bridge", ("V", "I"), np.array([[0.01, 0.0], [0.0, 0.01]]), 4.0)
    inputs = knowledge(quantity("V", 1.0, Normal(0.01)), gum.Input("I", 1.0), ensembles=[ensemble])
    assert estimate("V + I", inputs, "y", "1").advice == (
        "The scatter of the readings bridge (V, I) has the largest part in u(y), 100% of u²; for u(y) to halve"
        " to 0.071, it would have to fall to 50% of what it is, as by 4.1 times as many readings."
    )


def test_limit_single_input_needs_half_its_u():
    assert estimate("3*a", knowledge(quantity("a", 1.0, Normal(0.4), unit="mol")), "y", "mol").advice.endswith(
        "its u would have to fall from 0.40 mol to 0.20 mol."
    )


def test_closed_form_parameters_of_one_fit_improve_together():
    known = regression.knowledge(regression.line([0.0, 1.0, 2.0, 3.0], [1.0, 3.0, 5.0, 7.0], u_y=0.1), "cal")
    predicted = gum.Measurand("y", lambda q: q["cal.a"] + 4 * q["cal.b"])
    assert gum.evaluate([predicted], known, seed=1, max_trials=1000).estimates["y"].advice == (
        "The uncertainty of the points of fit cal, y = a + b·x (cal.a, cal.b) has the largest part in"
        " u(y), 100% of u²; for u(y) to halve to 0.061, it would have to fall to 50% of what it is."
    )


def test_law_causes_that_are_equal_but_for_rounding_keep_their_order():
    """Another processor rounds otherwise: a report would name another cause there, and not verify."""
    inputs = knowledge(*(quantity(name, 1.0, Normal(1.0)) for name in "abc"))
    for expression in ("a + b + 0.1*3/0.3*c", "a + 0.1*3/0.3*b + c"):
        advice = estimate(expression, inputs, "y", "1").advice
        assert advice.startswith("a has the largest part"), advice
        assert "next comes b with" in advice


def test_limit_a_tie_ends_at_the_ninth_digit():
    assert ties.largest(np.array([1.0, np.nextafter(1.0, 2.0), 0.5])) == 0
    assert ties.largest([-1.0, 3.0, 3.0000001]) == 2
