import numpy as np
import pytest
from scipy import integrate, stats

from metrology.errors import MetrologyError
from metrology.gum.bounded import Arcsine, CurvilinearTrapezoid, Rectangular, Trapezoidal, Triangular
from metrology.gum.distributions import DISTRIBUTIONS, Normal, Student


def curvilinear_density(x, a=1.0, d=0.4):
    return np.log((a + d) / np.maximum(abs(x), a - d)) / (4 * d) if abs(x) < a + d else 0.0


CASES = [
    (Normal(2.0), stats.norm(scale=2.0)),
    (Student(2.0, 5.0), stats.t(5.0, scale=2.0)),
    (Rectangular(2.0), stats.uniform(-2.0, 4.0)),
    (Triangular(2.0), stats.triang(0.5, -2.0, 4.0)),
    (Trapezoidal(2.0, 0.4), stats.trapezoid(0.3, 0.7, -2.0, 4.0)),
    (Arcsine(2.0), stats.arcsine(-2.0, 4.0)),
]


@pytest.mark.parametrize(("ours", "independent"), CASES, ids=lambda case: getattr(case, "name", ""))
def test_twice_quantiles_and_deviation_agree_with_scipy(ours, independent):
    p = np.linspace(0.001, 0.999, 31)
    np.testing.assert_allclose(ours.quantile(p), independent.ppf(p), rtol=1e-9, atol=1e-12)
    assert ours.deviation == pytest.approx(independent.std(), rel=1e-12)


@pytest.mark.parametrize(("ours", "independent"), CASES, ids=lambda case: getattr(case, "name", ""))
def test_twice_draws_follow_the_distribution(ours, independent):
    draws = ours.draw(np.random.Generator(np.random.SFC64(7)), 40_000)
    assert stats.kstest(draws, independent.cdf).pvalue > 1e-3


@pytest.mark.parametrize("p", [0.02, 0.1, 0.2, 0.45, 0.7, 0.99])
def test_twice_curvilinear_trapezoid_quantile_inverts_the_integral_of_its_density(p):
    x = float(CurvilinearTrapezoid(1.0, 0.4).quantile(p))
    below = integrate.quad(curvilinear_density, -1.4, x, points=[-0.6, 0.6], epsabs=1e-12)[0]
    assert below == pytest.approx(p, abs=1e-9)


def test_closed_form_curvilinear_trapezoid_variance_and_draws():
    shape = CurvilinearTrapezoid(1.0, 0.4)
    variance = integrate.quad(lambda x: x**2 * curvilinear_density(x), -1.4, 1.4, points=[-0.6, 0.6])[0]
    assert shape.u**2 == pytest.approx(variance, rel=1e-9)
    draws = shape.draw(np.random.Generator(np.random.SFC64(3)), 200_000)
    np.testing.assert_allclose(np.quantile(draws, [0.1, 0.5, 0.9]), shape.quantile([0.1, 0.5, 0.9]), atol=0.01)


@pytest.mark.parametrize(
    ("shape", "limit"),
    [
        (Trapezoidal(1.0, 0.0), Triangular(1.0)),
        (Trapezoidal(1.0, 1.0), Rectangular(1.0)),
        (CurvilinearTrapezoid(1.0, 0.0), Rectangular(1.0)),
        (Student(1.0, 1e9), Normal(1.0)),
    ],
)
def test_limit_of_a_shape_is_its_simpler_neighbour(shape, limit):
    p = np.linspace(0.01, 0.99, 9)
    np.testing.assert_allclose(shape.quantile(p), limit.quantile(p), atol=1e-7)
    assert shape.u == pytest.approx(limit.u)


def test_limit_half_width_known_only_to_its_own_size_has_an_integrable_peak():
    shape = CurvilinearTrapezoid(1.0, 1.0)
    assert float(shape.quantile(0.5)) == pytest.approx(0.0, abs=1e-12)
    assert float(shape.quantile(1.0)) == pytest.approx(2.0)


@pytest.mark.parametrize("kind", DISTRIBUTIONS.values())
def test_limit_of_no_width_is_no_influence(kind):
    arguments = {
        "student": (0.0, 4.0),
        "trapezoidal": (0.0, 0.5),
        "curvilinear-trapezoid": (0.0, 0.0),
    }.get(kind.name, (0.0,))
    null = kind(*arguments)
    assert null.u == null.deviation == 0
    assert not null.draw(np.random.default_rng(1), 5).any()


def test_closed_form_student_by_its_standard_deviation_keeps_it():
    shape = Student.by_deviation(3.0, 5.0)
    assert shape.u == 3.0
    assert shape.deviation == pytest.approx(3.0)
    assert shape.scale == pytest.approx(3.0 * (3 / 5) ** 0.5)


def test_limit_student_with_two_degrees_of_freedom_has_no_deviation():
    assert Student(1.0, 2.0).deviation == float("inf")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Normal(-1.0), "normal.standard: got -1.0; expected a finite number, zero or more"),
        (lambda: Rectangular(float("nan")), "rectangular.half_width: got nan; expected a finite number, zero or more"),
        (lambda: Trapezoidal(1.0, 1.5), "trapezoidal.beta: got 1.5; expected a number from 0 to 1"),
        (lambda: Student(1.0, 0.0), "student.dof: got 0.0; expected a finite number above zero"),
        (
            lambda: Student.by_deviation(1.0, 2.0),
            "student.dof: got 2.0; expected more than 2: the standard deviation does not exist below",
        ),
        (
            lambda: CurvilinearTrapezoid(1.0, 2.0),
            "curvilinear-trapezoid.limit_half_width: got 2.0; expected at most the half-width 1.0",
        ),
    ],
)
def test_refusal_of_impossible_widths(make, message):
    with pytest.raises(MetrologyError) as error:
        make()
    assert str(error.value) == message
