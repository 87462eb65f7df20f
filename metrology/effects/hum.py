"""A line of the mains, or a vibration, in a channel: found in the spectrum of the residuals."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Size


def in_x(t, x, frequency, phase):
    """a_x·sin(2π·f·t + ψ)."""
    return x * np.sin(2.0 * np.pi * frequency * t + phase)


def in_v(t, v, frequency, phase):
    """a_v·sin(2π·f·t + ψ)."""
    return v * np.sin(2.0 * np.pi * frequency * t + phase)


def in_T(t, T, frequency, phase):  # noqa: N802 - the channel's letter
    """a_T·sin(2π·f·t + ψ)."""
    return T * np.sin(2.0 * np.pi * frequency * t + phase)


PHASE = Size("hum.phase", "rad", 0.0, -INF, INF, 0.01, shape=True, own=True)
"""No run begins in step with what hums."""
FILTER = "find the source, or filter at its frequency"
EFFECT = Effect(
    name="hum",
    title="Mains or line vibration in a channel",
    equation="y_read = y + a·sin(2π·f·t + ψ)",
    parameters=(
        Parameter("hum.x", "a_x", "m", 0.0, -INF, INF, (0.0, 0.01), 1e-5, "amplitude in position"),
        Parameter("hum.v", "a_v", "m/s", 0.0, -INF, INF, (0.0, 0.1), 1e-5, "amplitude in velocity"),
        Parameter("hum.T", "a_T", "N", 0.0, -INF, INF, (0.0, 1.0), 1e-4, "amplitude in tension"),
        Parameter("hum.frequency", "f", "Hz", 50.0, 1e-6, INF, (0.1, 1e3), 0.01, "frequency"),
        Parameter("hum.phase", "ψ", "rad", 0.0, -INF, INF, (-3.2, 3.2), 0.01, "phase at t = 0"),
    ),
    sign="a line in the spectrum of the residual",
    source="JCGM 100:2008, F.2.4.2",
    sizes=3, acts="reading", readings={"x": in_x, "v": in_v, "T": in_T},
    causes=tuple(
        Cause(
            "response", f"hum {channel}", (f"hum.{channel}", "hum.frequency", PHASE),
            consequence=f"adds to the noise of {word} only",
            advice=advice,
            separate="a record at rest, with and without suspected sources",
            pictures=("spectrum",), needs=(channel,), amount=0.0,
            # half the highest rate, in Hz
            limits=lambda known: {"hum.frequency": (0.1, known["highest"] / (1.6 * np.pi))}, spectral=channel,
        )
        for channel, word, advice in (
            ("x", "position", FILTER), ("v", "velocity", FILTER),
            ("T", "tension", "part the supply and earth of the cell, or filter at its frequency"),
        )
    ),
)  # fmt: skip
