"""Published examples, to the digits that their sources print."""

from math import inf, sqrt

import pytest
from gum_models import knowledge, model, quantity

from metrology import gum
from metrology.gum import Arcsine, CurvilinearTrapezoid, Normal, Rectangular, Student, Triangular

ROOT3 = sqrt(3)
SEED = 20261120


def evaluate(models, inputs, **options):
    return gum.evaluate(models, inputs, seed=SEED, **options).estimates


def fixed(name, value):
    return gum.Input(name, value)


END_GAUGE = knowledge(
    quantity("ls", 50000623, Normal(25), dof=(18,)),
    quantity("d0", 215, Normal(5.8), dof=(24,)),
    quantity("d1", 0, Normal(3.9), dof=(5,)),
    quantity("d2", 0, Normal(6.7), dof=(8,)),
    quantity("theta0", -0.1, Normal(0.2)),
    quantity("Delta", 0, Arcsine(0.5)),
    quantity("alpha_s", 1.15e-5, Rectangular(2e-6)),
    quantity("dalpha", 0, Rectangular(1e-6), dof=(50,)),
    quantity("dtheta", 0, Rectangular(0.05), dof=(2,)),
)
END_GAUGE_MODEL = model("ls + d0 + d1 + d2 - ls*(dalpha*(theta0 + Delta) + alpha_s*dtheta)")


def test_reference_gum_h1_end_gauge():
    y = evaluate([END_GAUGE_MODEL], END_GAUGE, probability=0.99)["y"]
    assert round(y.value) == 50000838
    assert round(y.u) == 32
    assert int(y.dof) == 16  # the guide truncates 16.75
    parts = {row.input: abs(row.contribution) for row in y.budget}
    assert (round(parts["ls"]), round(parts["dalpha"], 1), round(parts["dtheta"], 1)) == (25, 2.9, 16.6)
    assert round(sqrt(parts["d0"] ** 2 + parts["d1"] ** 2 + parts["d2"] ** 2), 1) == 9.7
    assert round(gum.coverage_factor(0.99, 16), 2) == 2.92
    assert y.coverage.high - y.value == pytest.approx(93, abs=1.5)


def test_reference_gum_h2_simultaneous_resistance_and_reactance():
    means, ensemble = gum.simultaneous(
        "readings",
        {
            "V": [5.007, 4.994, 5.005, 4.990, 4.999],
            "I": [19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3],
            "phi": [1.0456, 1.0438, 1.0468, 1.0428, 1.0433],
        },
    )
    inputs = knowledge(*(fixed(name, value) for name, value in means.items()), ensembles=[ensemble])
    models = [model("V/I*cos(phi)", "R"), model("V/I*sin(phi)", "X"), model("V/I", "Z")]
    evaluation = gum.evaluate(models, inputs, seed=SEED)
    y = evaluation.estimates
    assert [round(y[name].value, 3) for name in "RXZ"] == [127.732, 219.847, 254.260]
    assert (round(y["R"].u, 3), round(y["Z"].u, 3)) == (0.071, 0.236)
    assert y["X"].u == pytest.approx(0.295, abs=0.001)  # 0.2956; the guide's 0.295 comes from rounded inputs
    assert [estimate.dof for estimate in y.values()] == pytest.approx([4, 4, 4])
    r = evaluation.correlation
    assert (round(r[0][1], 3), round(r[0][2], 3), round(r[1][2], 3)) == (-0.588, -0.485, 0.993)
    # With ν = 4 the interval of 10⁶ trials scatters by as much as δ: the exact law must not fail by chance.
    assert all(estimate.monte_carlo.law_valid for estimate in y.values())


def four(*distributions):
    return knowledge(*(quantity(f"X{i}", 0, d) for i, d in enumerate(distributions, 1)))


@pytest.mark.parametrize(
    ("distributions", "u", "digits", "end", "exact", "valid"),
    [
        ([Normal(1)] * 4, 2.0, 1, 3.92, 3.9199, True),
        ([Rectangular(ROOT3)] * 4, 2.0, 1, 3.88, 3.8794, True),
        ([*[Rectangular(ROOT3)] * 3, Rectangular(10 * ROOT3)], 10.1, 1, 17.0, 17.0158, False),
    ],
    ids=["9.2.2", "9.2.3", "9.2.4"],
)
def test_reference_jcgm101_9_2_additive_models(distributions, u, digits, end, exact, valid):
    y = evaluate([model("X1+X2+X3+X4")], four(*distributions))["y"]
    assert y.value == 0
    assert round(y.u, digits) == u
    assert y.monte_carlo.u == pytest.approx(y.u, rel=0.01)
    assert (y.monte_carlo.low, y.monte_carlo.high) == pytest.approx((-exact, exact), abs=y.monte_carlo.tolerance)
    assert (y.monte_carlo.shortest_low, y.monte_carlo.shortest_high) == pytest.approx((-end, end), abs=0.02 * end)
    assert y.monte_carlo.law_valid is valid


def test_reference_jcgm101_9_3_mass_calibration():
    inputs = knowledge(
        quantity("mRc", 100000, Normal(0.05)),
        quantity("dmRc", 1.234, Normal(0.02)),
        quantity("rho_a", 1.2, Rectangular(0.1)),
        quantity("rho_W", 8000, Rectangular(1000)),
        quantity("rho_R", 8000, Rectangular(50)),
    )
    equation = model("(mRc + dmRc)*(1 + (rho_a - 1.2)*(1/rho_W - 1/rho_R)) - 100000.0")
    y = evaluate([equation], inputs)["y"]
    assert round(y.value, 4) == 1.2340
    assert round(y.u, 4) == 0.0539
    assert (y.coverage.low, y.coverage.high) == pytest.approx((1.1285, 1.3395), abs=1e-4)
    mc = y.monte_carlo
    assert mc.mean == pytest.approx(1.2341, abs=2e-4)
    assert mc.u == pytest.approx(0.0754, abs=2e-4)
    assert (mc.shortest_low, mc.shortest_high) == pytest.approx((1.0834, 1.3825), abs=2.5e-3)
    assert mc.shortest_high - mc.shortest_low == pytest.approx(0.2991, abs=1e-3)
    assert not mc.law_valid


@pytest.mark.parametrize(
    ("x", "r", "law", "mean", "u", "low", "high", "slack"),
    [
        (0.0, 0.0, (0, 0), 50, 50, 0, 150, 1.0),
        (0.010, 0.0, (100, 100), 150, 112, 0, 367, 2.0),
        (0.050, 0.9, (2500, 500), 2551, 505, 1628, 3555, 12.0),
    ],
)
def test_reference_jcgm101_9_4_comparison_loss(x, r, law, mean, u, low, high, slack):
    inputs = knowledge(
        quantity("X1", x, Normal(0.005)), quantity("X2", 0, Normal(0.005)), correlations={("X1", "X2"): r}
    )
    y = evaluate([model("1e6*(X1*X1 + X2*X2)")], inputs)["y"]
    assert (round(y.value), round(y.u)) == law
    mc = y.monte_carlo
    # The published figures come from 10⁶ trials, these from as many as the adaptive procedure takes: 4 standard errors.
    assert (mc.mean, mc.u) == pytest.approx((mean, u), abs=4 * u / sqrt(mc.trials) + 0.5)
    assert (mc.shortest_low, mc.shortest_high) == pytest.approx((low, high), abs=slack)
    assert not mc.law_valid
    assert ("not valid here" in mc.verdict) is (x == 0)


def test_reference_jcgm101_9_5_gauge_block():
    inputs = knowledge(
        quantity("Ls", 50000623, Student(25, 18)),
        quantity("D", 215, Student(6, 24)),
        quantity("d1", 0, Student(4, 5)),
        quantity("d2", 0, Student(7, 8)),
        quantity("alpha_s", 1.15e-5, Rectangular(2e-6)),
        quantity("theta0", -0.1, Normal(0.2)),
        quantity("Delta", 0, Arcsine(0.5)),
        quantity("dalpha", 0, CurvilinearTrapezoid(1e-6, 1e-7)),
        quantity("dtheta", 0, CurvilinearTrapezoid(0.05, 0.025)),
        fixed("L_nom", 50000000),
    )
    equation = model("Ls + D + d1 + d2 - Ls*(dalpha*(theta0 + Delta) + alpha_s*dtheta) - L_nom")
    y = evaluate([equation], inputs, probability=0.99)["y"]
    assert (round(y.value), round(y.u)) == (838, 32)
    mc = y.monte_carlo
    assert (round(mc.mean), round(mc.u)) == (838, 36)
    assert (mc.shortest_low, mc.shortest_high) == pytest.approx((745, 932), abs=1)


def test_reference_jcgm102_9_3_polar_coordinates():
    inputs = knowledge(
        quantity("re", 0.001, Normal(0.01)), quantity("im", 0, Normal(0.01)), correlations={("re", "im"): 0.9}
    )
    evaluation = gum.evaluate([model("sqrt(re*re + im*im)", "mag"), model("atan2(im, re)", "ph")], inputs, seed=SEED)
    mag, ph = evaluation.estimates["mag"], evaluation.estimates["ph"]
    assert (mag.value, round(mag.u, 3), ph.value, round(ph.u, 3)) == (0.001, 0.010, 0.0, 10.0)
    assert evaluation.correlation[0][1] == pytest.approx(0.9)
    assert (round(mag.monte_carlo.mean, 3), round(mag.monte_carlo.u, 3)) == (0.012, 0.008)
    assert (ph.monte_carlo.mean, ph.monte_carlo.u) == pytest.approx((-0.556, 1.599), abs=0.005)


def test_reference_quam_a1_cadmium_standard():
    inputs = knowledge(
        quantity("m", 100.28, Normal(0.05)),
        quantity("P", 0.9999, Rectangular(0.0001)),
        quantity("Vf", 100, Triangular(0.1)),
        quantity("Vr", 0, Normal(0.02)),
        quantity("Vt", 0, Rectangular(0.084)),
    )
    y = evaluate([model("1000*m*P/(Vf + Vr + Vt)")], inputs)["y"]
    assert (round(y.value, 1), round(y.u, 6)) == (1002.7, 0.835199)
    parts = {row.input: abs(row.contribution) for row in y.budget}
    expected = {"m": 0.49995, "Vt": 0.486284, "Vf": 0.40935, "Vr": 0.20054, "P": 0.0578967}
    assert parts == pytest.approx(expected, rel=2e-6)


def test_reference_quam_a3_hydrochloric_acid():
    inputs = knowledge(
        quantity("mt", 0, Rectangular(0.00015)),
        quantity("mg", 0.3888, Rectangular(0.00015)),
        quantity("P", 1, Rectangular(0.0005)),
        quantity("MC", 12.0107, Rectangular(0.0008)),
        quantity("MH", 1.00794, Rectangular(7e-5)),
        quantity("MO", 15.9994, Rectangular(3e-4)),
        quantity("MK", 39.0983, Rectangular(1e-4)),
        quantity("V2", 14.89, Triangular(0.03), Rectangular(0.0126)),
        quantity("V1", 18.64, Triangular(0.03), Rectangular(0.01596)),
        quantity("VH", 15, Triangular(0.02), Rectangular(0.0126)),
        quantity("R", 1, Normal(0.001)),
    )
    y = evaluate([model("R*1000*(mg - mt)*P*V2/((8*MC + 5*MH + 4*MO + MK)*V1*VH)")], inputs)["y"]
    assert (round(y.value, 5), round(y.u, 7)) == (0.10139, 0.0001843)
    assert len(y.budget) == 14


def test_reference_ea_4_02_s2_weight():
    inputs = knowledge(
        quantity("mS", 10000.005, Normal(0.0225)),
        quantity("dmD", 0, Rectangular(0.015)),
        quantity("dm", 0.02, Normal(0.025 / ROOT3)),
        quantity("dmC", 0, Rectangular(0.01)),
        quantity("dB", 0, Rectangular(0.01)),
    )
    y = evaluate([model("mS + dmD + dm + dmC + dB")], inputs)["y"]
    assert (round(y.value, 3), round(y.u, 4), round(2 * y.u, 3)) == (10000.025, 0.0293, 0.059)
    assert y.dof is None
    assert y.dof_note.startswith("infinite")


def test_reference_nist_tn1900_e13_thermal_expansion():
    inputs = knowledge(
        quantity("L0", 1.4999, Student.by_deviation(0.0001, 3)),
        quantity("L1", 1.5021, Student.by_deviation(0.0002, 3)),
        quantity("T0", 288.15, Student.by_deviation(0.02, 3)),
        quantity("T1", 373.1, Student.by_deviation(0.05, 3)),
    )
    y = evaluate([model("(L1 - L0)/(L0*(T1 - T0))")], inputs)["y"]
    assert (round(y.value, 9), round(y.u, 8)) == (1.7266e-5, 1.76e-6)
    assert y.dof == pytest.approx(4.41576294368731)
    assert y.monte_carlo.mean == pytest.approx(1.7268e-5, abs=1e-8)
    assert y.monte_carlo.u == pytest.approx(1.74e-6, abs=4e-8)


@pytest.mark.parametrize(("p", "low", "high"), [(0.99, 5.67032e-8, 5.67043e-8), (0.68, 5.67035e-8, 5.67039e-8)])
def test_reference_nist_uncertainty_machine_stefan_boltzmann(p, low, high):
    inputs = knowledge(
        quantity("h", 6.62606957e-34, Normal(2.9e-41)),
        quantity("R", 8.3144621, Normal(7.5e-6)),
        quantity("Rinf", 10973731.568539, Normal(5.5e-5)),
        quantity("Ar", 5.4857990946e-4, Normal(2.2e-13)),
        quantity("al", 7.2973525698e-3, Normal(2.4e-12)),
    )
    equation = model("32*pi**5*h*R**4*Rinf**4/(15*Ar**4*0.001**4*299792458.0**6*al**8)")
    y = evaluate([equation], inputs, probability=p)["y"]
    assert (round(y.value, 13), round(y.u, 15)) == (5.67037e-8, 2.05e-13)
    assert (y.monte_carlo.low, y.monte_carlo.high) == pytest.approx((low, high), abs=0.6e-13)
    assert y.monte_carlo.law_valid


@pytest.mark.parametrize(
    ("p", "dof", "k"), [(0.95, inf, 1.96), (0.9545, inf, 2.0), (0.99, 16, 2.92), (0.95, 1, 12.71), (0.95, 10, 2.23)]
)
def test_reference_gum_table_g2_coverage_factors(p, dof, k):
    assert round(gum.coverage_factor(p, dof), 2) == k
