"""A mass that hangs on a line and swings so far that the line goes slack: own equations by SciPy, coloured noise."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from metrology.decay import DecayTest
from metrology.diagnostics import decay
from metrology.errors import MetrologyError
from metrology.gum.inputs import Input
from metrology.rig import Rig
from metrology.timeseries import Channel

GRAVITY = 9.81


def hung(m: float, k: float, line: float, air: float, starts: list[float], seed: int) -> DecayTest:
    """Releases of 40 periods from where the mass rests; `line`, `air`: damping / (N·s/m); noise of 0.3 % of a start."""
    rng, rest, omega = np.random.default_rng(seed), m * GRAVITY / k, math.sqrt(k / m)
    t, records = np.linspace(0.0, 80 * math.pi / omega, 1600), []
    for at, start in enumerate(starts):

        def moved(_t, y):
            pull = max(0.0, k * (y[0] + rest) + line * y[1]) - m * GRAVITY
            return [y[1], -(pull + air * y[1]) / m]

        motion = solve_ivp(moved, (0.0, t[-1]), [start, 0.0], method="DOP853", rtol=1e-10, atol=1e-13, t_eval=t,
                           max_step=t[-1] / 4000)  # fmt: skip
        noise = rng.standard_normal(len(t))
        for one in range(1, len(t)):
            noise[one] = 0.3 * noise[one - 1] + math.sqrt(1 - 0.3**2) * noise[one]
        records.append(Channel(f"record-{at}", t, motion.y[0] + 0.003 * abs(start) * noise, "m"))
    return DecayTest("d", tuple(records), Input("d.mass", m, unit="kg"), "k")


@pytest.mark.long
@pytest.mark.parametrize(
    ("m", "k", "line", "air", "starts"),
    [(5.0, 400.0, 0.6, 0.1, [0.15, -0.16, 0.14]), (2.0, 2000.0, 1.5, 0.2, [0.011, -0.0105, 0.012])],
    ids=["far", "just"],
)
def test_planted_slack_line_is_named_with_its_place_and_its_damping(m, k, line, air, starts):
    """It was an even stiffness, or a step and a line that hardens; k and c are those of the taut line."""
    found = decay(hung(m, k, line, air, starts, 1), rng=np.random.default_rng(1))
    assert (found.verdict, found.named) == ("explained", ("slack",))
    assert found.supported is not None
    planted = {"k": k, "c": line + air, "slack.share": 1.0, "slack.place": -m * GRAVITY / k,
               "slack.damping": line / (line + air)}  # fmt: skip
    for name, value, u in zip(found.supported.names, found.supported.values, found.supported.u, strict=True):
        assert abs(value - planted[name]) < 3 * u, name
    assert found.supported.u[found.supported.names.index("slack.place")] < 0.01 * m * GRAVITY / k


@pytest.mark.long
def test_planted_taut_line_is_not_slack():
    found = decay(hung(5.0, 400.0, 0.6, 0.1, [0.11, -0.12, 0.1], 2), rng=np.random.default_rng(2))
    assert (found.verdict, found.named) == ("nothing missing", ())


def test_limit_no_more_than_all_of_a_line_goes_slack():
    """A fit went to a share of 2e7, a line that pushes with 1.7 GN/m, and one motion took seconds."""
    Rig(2.0, 400.0, 1.0, attachment="both ways", effects={"slack.share": 1.0})
    with pytest.raises(MetrologyError, match=r"slack\.share"):
        Rig(2.0, 400.0, 1.0, attachment="both ways", effects={"slack.share": 1.01})
