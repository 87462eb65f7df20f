"""Reconstruct the readings of the two free-decay tests: `python campaigns/tapes/reconstruct_decay.py`.

The readings behind the published damping coefficients were never published. This script makes records that a
vibrometer would have given, from equations of motion with more in them than the evaluation supposes, and writes one
CSV file a release. It is seeded: the same files come out each time.

Published: c = 48.16 N·s/m (ζ = 14 %) for the tape of aluminium 1100, c = 0.37 N·s/m for the tape of PEEK, each the
mean over the tests, found from the log decrement of a plate that hangs on three metres of tape and is let go by a
magnet.

Assumed, since not published:

- the mass that oscillates, 1.196 kg with the aluminium tape: with k = 24734.25 N/m it is the one that gives 14 % for
  48.16 N·s/m. The PEEK tape is lighter (a third of its mass counts), otherwise the plate and its load are the same:
  1.194 kg;
- five releases a tape, the plate held 0.42 mm (aluminium) and 1.6 mm (PEEK) above its rest position before;
- damping that differs by about 1.2 % from release to release (aluminium), 3 % (PEEK), frequency by 0.1 %.

In the equations, with z downwards from rest:

- plate on the tape: m·z″ + c·z′ + k·z + b·|z′|·z′ = −k·z₀·h(t); b the drag of the air on the plate; h = 1 before the
  release, exp(−t/τ) after it: the pull of the magnet dies away in about τ = 1.5 ms;
- first transverse mode of the tape, whose tension the oscillation changes: y″ + 2·ζ_y·ω_y·y′ + ω_y²·(1 +
  k·z/(m·g))·y = 0;
- rocking of the plate: p″ + 2·ζ_p·ω_p·p′ + ω_p²·p = 0; pendulum swing: s″ + 2·ζ_s·ω_s·s′ + ω_s²·s = 0, ω_s² = g/L.

The vibrometer sees z, a part of y and p (its spot is not in the middle of the plate), s by its slant and s²/(2·L), an
offset and a drift, mains at 50 Hz and 150 Hz, noise of 0.3 µm, and rounds to 0.1 µm.

One number of each tape is adjusted: the mean c of the equations, so that the evaluation of the rounded records gives
the published one. Before that it differs from it in the fourth digit.
"""

from __future__ import annotations

import gzip
import io
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from metrology.decay import DecayTest, analyse
from metrology.gum.inputs import Input
from metrology.timeseries import Channel

GRAVITY, LENGTH = 9.806, 2.99
RELEASES = 5
MAINS = 50.01  # Hz, as it was that day


@dataclass(frozen=True)
class Tape:
    """One test: what hangs on the tape, how it is let go, how it is sampled, and what was published. SI."""

    name: str
    seed: int
    mass: float
    static: float
    dynamic: float
    published: float
    lift: float
    scatter: float
    transverse: float
    rate: float
    duration: float
    suffix: str


TAPES = (
    Tape("al-1100", 48160, 1.196, 24734.25, 24610.0, 48.16, 0.42e-3, 0.012, 9.8, 2000.0, 1.2, ".csv"),
    Tape("peek", 370, 1.194, 1810.91, 1815.5, 0.37, 1.6e-3, 0.03, 14.1, 1000.0, 10.0, ".csv.gz"),
)


def release(tape: Tape, damping: float, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return time (s) and displacement (m, rounded to 0.1 µm) of one release."""
    normal, uniform = generator.standard_normal, generator.uniform
    c = damping * (1 + tape.scatter * normal())
    k = tape.dynamic * (1 + 2e-3 * normal())
    lift = tape.lift * (1 + 0.02 * normal())
    w_y, w_p, w_s = 2 * pi * tape.transverse, 2 * pi * 3.4, sqrt(GRAVITY / LENGTH)
    start = [
        -lift, 0.0,
        4e-5 * normal(), 4e-5 * w_y * normal(),
        3e-6 * normal(), 6e-6 * w_p * normal(),
        2e-3 * normal(), 2e-3 * w_s * normal(),
    ]  # fmt: skip

    def motion(t: float, state: np.ndarray) -> list[float]:
        z, dz, y, dy, p, dp, s, ds = state
        magnet = -k * lift * np.exp(-t / 1.5e-3)
        tension = 1 + k * z / (tape.mass * GRAVITY)
        return [
            dz, (magnet - c * dz - k * z - 7e-3 * abs(dz) * dz) / tape.mass,
            dy, -2 * 0.01 * w_y * dy - w_y**2 * tension * y,
            dp, -2 * 0.008 * w_p * dp - w_p**2 * p,
            ds, -2 * 0.002 * w_s * ds - w_s**2 * s,
        ]  # fmt: skip

    time = np.arange(-round(0.05 * tape.rate), round(tape.duration * tape.rate)) / tape.rate
    free = time[time >= 0]
    solution = solve_ivp(motion, (0.0, free[-1]), start, "DOP853", free, rtol=1e-10, atol=1e-14)
    held = np.tile(np.array(start)[:, None], (1, time.size - free.size))
    z, _, y, _, p, _, s, _ = np.hstack([held, solution.y])
    slant, phase = 4e-3 * normal(), uniform(0, 2 * pi, 2)
    value = z + 0.05 * y + p + slant * s + s**2 / (2 * LENGTH)
    value += 1e-6 * (30 + 5 * normal() + 1.5 * normal() * time)
    value += 1.2e-6 * np.cos(2 * pi * MAINS * time + phase[0]) + 0.4e-6 * np.cos(2 * pi * 3 * MAINS * time + phase[1])
    value += 0.3e-6 * normal(time.size)
    return time, np.round(value * 1e7) / 1e7


def records(tape: Tape, damping: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return all releases of a tape, with draws that do not depend on the damping."""
    return [release(tape, damping, np.random.default_rng([tape.seed, i])) for i in range(RELEASES)]


def evaluated(tape: Tape, made: list[tuple[np.ndarray, np.ndarray]]) -> float:
    """Return c as the evaluation gives it, with the published k."""
    channels = tuple(Channel(f"{tape.name} {i}", time, value, "m") for i, (time, value) in enumerate(made))
    analysis = analyse(DecayTest(tape.name, channels, Input("m", tape.mass, unit="kg"), "k"))
    values = {given.name: given.value for given in analysis.inputs} | {"k": tape.static}
    for measurand in analysis.measurands:
        values[measurand.name] = measurand.function(values)
    return values[f"{tape.name}.c"]


def adjusted(tape: Tape) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return records whose evaluation gives the published c to 2 in 100 000; rounding to 0.1 µm allows no more."""
    damping = tape.published
    for _ in range(8):
        made = records(tape, damping)
        got = evaluated(tape, made)
        if abs(got / tape.published - 1) < 2e-5:
            return made
        damping *= tape.published / got
    raise RuntimeError(f"{tape.name}: c = {got} N·s/m instead of {tape.published} N·s/m")


def written(tape: Tape, time: np.ndarray, value: np.ndarray) -> bytes:
    """Return the CSV file of one record, compressed where the tape's files are."""
    digits = 4 if tape.rate > 1000 else 3
    text = io.StringIO()
    text.write("time / s,displacement / um\n")
    text.writelines(f"{t:.{digits}f},{1e6 * x + 0.0:.1f}\n" for t, x in zip(time, value, strict=True))
    data = text.getvalue().replace(",-0.0\n", ",0.0\n").replace("-0.0000,", "0.0000,").encode()
    return gzip.compress(data, compresslevel=9, mtime=0) if tape.suffix.endswith(".gz") else data


def main(folder: Path = Path(__file__).parent, tapes: tuple[Tape, ...] = TAPES) -> None:
    """Write every record of every tape."""
    for tape in tapes:
        for i, (time, value) in enumerate(adjusted(tape), start=1):
            (folder / f"{tape.name}-decay-{i}{tape.suffix}").write_bytes(written(tape, time, value))


if __name__ == "__main__":
    main()
