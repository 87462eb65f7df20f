"""A pendulum: its restoring force goes with the sine."""

from dataclasses import replace

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Size


def tension(e, k, rate):
    """k·(sin(κ·ε)/κ − ε)."""
    return k * (np.sin(rate * e) / rate - e)


def slope(e, k, rate):
    """k·(cos(κ·ε) − 1)."""
    return k * (np.cos(rate * e) - 1.0)


CAUSE = Cause(
    "response", "pendulum", (Size("sine.rate", "1/m", 0.0, 0.0, INF, 0.01, power=2),),
    consequence="k is that of a mean amplitude A, too small by k·κ²·A²/8",
    advice="keep κ in the model: 1/rad for an angle, one over the length for a position",
    separate="releases from several amplitudes; the length of the pendulum",
    pictures=("frequency", "force-elongation"), needs=("both ways",), amount=lambda known: 0.3 / known["e"],
)  # fmt: skip
EFFECT = Effect(
    name="sine",
    title="Restoring force of a pendulum",
    equation="T = k·sin(κ·ε)/κ",
    parameters=(
        Parameter("sine.rate", "κ", "1/m", 0.0, 0.0, INF, (0.0, 10.0), 0.01, "one over the length", linear=False),
    ),
    sign="the frequency falls with the square of the amplitude",
    source="Nayfeh & Mook, Nonlinear Oscillations (1979), 2.1",
    acts="line", tension=tension, slope=slope,
    causes=(CAUSE, replace(
            CAUSE, method="decay", needs=(), amount=lambda known: 0.1 / known["e"], law="hardening or softening",
            # A swing that went over the top would not come back, and by its speed at the bottom it may seem to be four
            # times as large as it is. Without an end, each step of a motion is as short as κ is large.
            limits=lambda known: {"sine.rate": (0.0, 4.0 * np.pi / known["e"])},
        )),
)  # fmt: skip
