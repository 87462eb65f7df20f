"""What truly happens to a plate let go on a tape, for tests: own equations, SciPy, and what a vibrometer makes of it.

Shares no code with `metrology`. A `Decaying` holds the physics, a `Vibrometer` the instrument, `releases` repeats one
test with scatter from release to release. SI throughout::

    truth = MATERIALS["peek"]
    records = releases(replace(truth, friction=2e-4), Vibrometer(), 5, np.random.default_rng(1))

`EFFECTS` plants one effect by name and size; `distance` tells by how many standard deviations it moves the records,
whatever mass, stiffness, damping, start and zero may be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Decaying:
    """The physics: m·x″ + c·x′ + k·x and what may be beside it.

    `friction` / N; `quadratic` / (N·s²/m²); `cubic` / (N/m³); `rise` / (N·s/m²): c + rise·|x|; `compliance` / (m/N) of
    the frame in series. In nobody's table: `stop` / (N/m) of a stop that the plate touches beyond 60 % of its
    first swing, on one side only; `second` / (N/m), a spring to a second, equal plate that swings along;
    `pawl` / N that acts on the way up only, below half of the first swing.
    """

    m: float
    k: float
    c: float
    amplitude: float
    duration: float
    friction: float = 0.0
    quadratic: float = 0.0
    cubic: float = 0.0
    rise: float = 0.0
    compliance: float = 0.0
    stop: float = 0.0
    second: float = 0.0
    pawl: float = 0.0


@dataclass(frozen=True)
class Vibrometer:
    """The instrument, and what reaches it beside the longitudinal motion; amplitudes in m.

    `drift` / m over the record, `bend` / m of its curved part; `transverse` / m at 9.6 Hz with a slow decay;
    `pendulum` / m at 0.43 Hz; `mains` / m at 50.02 Hz; `gain` / 1: relative step of the scale after a third of the
    record; `hop` / m: fringes lost at one moment.
    """

    noise: float = 4e-7
    rounding: float = 1e-7
    rate: float = 1000.0
    offset: float = 2e-5
    drift: float = 0.0
    bend: float = 0.0
    transverse: float = 0.0
    pendulum: float = 0.0
    mains: float = 0.0
    gain: float = 0.0
    hop: float = 0.0


@dataclass(frozen=True)
class Scatter:
    """From release to release: relative standard deviations of the first amplitude, of k and of c."""

    amplitude: float = 0.05
    k: float = 2e-5
    c: float = 1e-3


MATERIALS = {
    "al-1100": Decaying(1.196, 24734.25, 48.16, 4e-4, 0.8),
    "peek": Decaying(1.194, 1810.91, 0.37, 1.5e-3, 8.0),
    "nylon": Decaying(0.2, 167.64, 0.35, 2e-3, 6.0),
    "spectra": Decaying(1.2, 753.33, 2.4, 2e-3, 6.0),
}
"""Four samples with the plate of the test on them; the first amplitude keeps the line taut."""


def swing(truth: Decaying, t: np.ndarray) -> np.ndarray:
    """Displacement at times t ≥ 0 after a release from rest, every stretch of one direction of motion by itself."""
    if truth.second:
        return _beside(truth, t)
    if not (truth.friction or truth.quadratic or truth.cubic or truth.rise or truth.stop or truth.pawl):
        return _linear(truth, t)
    x, out, start = truth.amplitude, np.zeros(t.size), 0.0
    k = truth.k / (1 + truth.compliance * truth.k)
    c = truth.c / (1 + truth.compliance * truth.k) ** 2
    omega = np.sqrt(k / truth.m)
    edge = 0.6 * truth.amplitude

    def turn(_t, state):
        return state[1]

    turn.terminal = True
    for _ in range(4000):
        pull = abs(k * x + truth.cubic * x**3)
        if start >= t[-1] or pull <= truth.friction or abs(x) < 1e-7 * truth.amplitude:
            out[t >= start] = x
            break
        way = -np.sign(x)

        def rate(_t, state, way=way):
            y, v = state
            force = k * y + truth.cubic * y**3 + (c + truth.rise * abs(y)) * v
            force += way * truth.friction + truth.quadratic * abs(v) * v + truth.stop * max(y - edge, 0.0)
            force += truth.pawl * (way > 0 and abs(y) < 0.5 * truth.amplitude)
            return [v, -force / truth.m]

        turn.direction = -way
        first = [x, way * 1e-9 * omega * abs(x)]
        end = min(t[-1], start + 3.5 / omega * np.pi)
        part = solve_ivp(
            rate, (start, end), first, "DOP853", rtol=1e-10, atol=1e-15, events=turn, dense_output=True,
            max_step=0.1 / omega if truth.stop or truth.pawl else np.inf,
        )  # fmt: skip
        inside = (t >= start) & (t <= part.t[-1])
        out[inside] = part.sol(t[inside])[0]
        start, x = float(part.t[-1]), float(part.y[0, -1])
        if start >= t[-1]:
            break
    return out


def held_at_last(
    start: float, t: np.ndarray, push: Callable[[Sequence[float], float], float], is_held: Callable[[float], bool], *,
    begun: float, longest: float, atol: float,
) -> np.ndarray:  # fmt: skip
    """Motion from rest, each way by itself, until it is held at a turn.

    `push`: acceleration by position and velocity, and by the way, 1 or −1. A way begins by the time `begun`, along a
    parabola, and lasts no longer than `longest`.
    """
    x, now, at, done = np.empty(len(t)), 0.0, start, 0

    def turns(_t: float, state: np.ndarray) -> float:
        return float(state[1])

    turns.terminal = True  # type: ignore[attr-defined]
    while done < len(t):
        if is_held(at):
            x[done:] = at
            break
        way = -math.copysign(1.0, at)
        turns.direction = -way  # type: ignore[attr-defined]

        def motion(_t: float, state: np.ndarray, way: float = way) -> list[float]:
            return [state[1], push(state, way)]

        pull = push((at, 0.0), way)
        path = solve_ivp(motion, (now + begun, now + longest), (at + 0.5 * pull * begun**2, pull * begun), "DOP853",
                         rtol=1e-10, atol=atol, events=turns, dense_output=True)  # fmt: skip
        last = int(np.searchsorted(t, path.t[-1], side="right"))
        x[done:last] = path.sol(np.maximum(t[done:last], now + begun))[0]
        now, at, done = float(path.t[-1]), float(path.y[0, -1]), last
    return x


def _linear(truth: Decaying, t: np.ndarray) -> np.ndarray:
    """Closed form of the linear decay from rest, with the set-up compliance as a massless spring in series."""
    soft = 1 + truth.compliance * truth.k
    rate = truth.c / soft**2 / (2 * truth.m)
    turn = np.sqrt(truth.k / soft / truth.m - rate**2)
    return truth.amplitude * np.exp(-rate * t) * (np.cos(turn * t) + rate / turn * np.sin(turn * t))


def _beside(truth: Decaying, t: np.ndarray) -> np.ndarray:
    """Two equal plates on equal samples, coupled by a weak spring: the second starts at rest and takes the energy."""
    k, c, s, m = truth.k, truth.c, truth.second, truth.m

    def rate(_t, state):
        x, v, y, w = state
        return [v, -(k * x + c * v + s * (x - y)) / m, w, -(k * y + c * w + s * (y - x)) / m]

    found = solve_ivp(rate, (0, t[-1]), [truth.amplitude, 0, 0, 0], "DOP853", rtol=1e-10, atol=1e-15, dense_output=True)
    return np.asarray(found.sol(t)[0])


def record(
    truth: Decaying, eye: Vibrometer, rng: np.random.Generator, *, quiet: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Time and reading of one release, 50 ms before it included; `quiet`: without noise and rounding."""
    t = np.arange(-round(0.05 * eye.rate), round(truth.duration * eye.rate)) / eye.rate
    free = np.maximum(t, 0.0)
    x = np.full(t.size, truth.amplitude)
    x[t >= 0] = swing(truth, t[t >= 0])
    phase = rng.uniform(0, 2 * np.pi, 4)
    part = t / truth.duration
    if eye.gain:
        x = np.where(part > 1 / 3, (1 + eye.gain) * x, x)
    x = x + eye.offset + eye.drift * part + eye.bend * (part**2 - part)
    x += eye.transverse * np.exp(-0.8 * free) * np.sin(2 * np.pi * 9.6 * t + phase[0])
    x += eye.pendulum * np.exp(-0.05 * free) * np.sin(2 * np.pi * 0.43 * t + phase[1])
    x += eye.mains * (np.sin(2 * np.pi * 50.02 * t + phase[2]) + 0.3 * np.sin(2 * np.pi * 150.06 * t + phase[3]))
    x += eye.hop * (part > 0.25)
    if not quiet:
        x += eye.noise * rng.standard_normal(t.size)
        x = np.round(x / eye.rounding) * eye.rounding
    return t, x


def releases(
    truth: Decaying, eye: Vibrometer, count: int, rng: np.random.Generator, scatter: Scatter | None = None,
    *, quiet: bool = False,
) -> list[tuple[np.ndarray, np.ndarray]]:  # fmt: skip
    """Several releases, each with its own amplitude, k and c."""
    by = scatter or Scatter()
    found = []
    for _ in range(count):
        a, k, c = 1 + rng.standard_normal(3) * (by.amplitude, by.k, by.c)
        own = replace(truth, amplitude=truth.amplitude * a, k=truth.k * k, c=truth.c * c)
        found.append(record(own, eye, rng, quiet=quiet))
    return found


EFFECTS = {
    "friction": ("truth", "friction"),
    "quadratic drag": ("truth", "quadratic"),
    "cubic": ("truth", "cubic"),
    "damping": ("truth", "rise"),
    "drift": ("eye", "drift"),
    "transverse": ("eye", "transverse"),
    "pendulum": ("eye", "pendulum"),
    "mains": ("eye", "mains"),
    "hop": ("eye", "hop"),
}
"""Effects of the table: where this generator carries each."""
UNKNOWN = {"stop": ("truth", "stop"), "second": ("truth", "second"), "gain": ("eye", "gain")}
"""Effects of nobody's table."""


def planted(truth: Decaying, eye: Vibrometer, sizes: dict[str, float]) -> tuple[Decaying, Vibrometer]:
    """Truth and instrument with effects of these sizes."""
    for name, size in sizes.items():
        where, key = (EFFECTS | UNKNOWN)[name]
        if where == "truth":
            truth = replace(truth, **{key: size})
        else:
            eye = replace(eye, **{key: size})
    return truth, eye


def distance(name: str, truth: Decaying, eye: Vibrometer, count: int, size: float) -> float:
    """Standard deviations by which an effect of this size moves the records, all that a laboratory fits taken out.

    Taken out of each record, from a tenth of a period after the release on: a change of amplitude, phase, frequency
    and decay rate, and a constant; of drifts and lines nothing more.
    """
    steady = Scatter(0.0, 0.0, 0.0)
    plain = releases(truth, eye, 1, np.random.default_rng(0), steady, quiet=True)[0]
    more = releases(*planted(truth, eye, {name: size}), 1, np.random.default_rng(0), steady, quiet=True)[0]
    t = plain[0]
    inside = t > 0.55 * np.pi / np.sqrt(truth.k / truth.m)
    moved = (more[1] - plain[1])[inside]
    columns = [np.ones(inside.sum())]
    for key, step in (("k", 1e-5), ("c", 1e-4), ("amplitude", 1e-3)):
        shifted = replace(truth, **{key: getattr(truth, key) * (1 + step)})
        columns.append(
            (releases(shifted, eye, 1, np.random.default_rng(0), steady, quiet=True)[0][1] - plain[1])[inside]
        )
    columns.append(np.gradient(plain[1], t)[inside])
    basis = np.linalg.qr(np.column_stack(columns))[0]
    left = moved - basis @ (basis.T @ moved)
    sigma = np.hypot(eye.noise, eye.rounding / np.sqrt(12))
    return float(np.sqrt(count) * np.linalg.norm(left) / sigma)
