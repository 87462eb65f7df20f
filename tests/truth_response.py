"""What truly happens on a rig, for tests: own equations, SciPy at tight tolerance, realistic measurement of it.

Shares no code with `metrology`. A `Truth` holds the physics, a `Test` what the lab commands, `motion` integrates one
test, `measure` adds what the instruments do to it, and `campaign` repeats tests with scatter from run to run::

    truth = Truth(m=25.0, k=167.64, c=8.0, taut=0.2)
    tests = [Test("step", ((1.0, 0.62),), 30.0), Test("impulse", ((1.0, 0.62), (4.0, 0.0)), 30.0)]
    records = campaign(truth, tests, Instruments(), Scatter(thrust_run=0.003), np.random.default_rng(1))

Everything is SI. Positions grow away from the load cell; a taut line pulls with a positive tension.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Truth:
    """The physics: a module on a line that only pulls, and what may disturb it.

    `friction` / N with `static_ratio`; `viscous` / (N·s/m) and `quadratic` / (N·s²/m²) drag on the module;
    `tilt` / rad; `cubic` / (N/m³) of the line; `compliance` / (m/N) of the mount, a spring in series with the line,
    which needs c > 0 (seconds a run where 1/(compliance·c) is large, as for PEEK); `amplitude` / (N·s/m²): line damping
    c + amplitude·|e|. In nobody's table: `magnet` / N under the table halfway to the line's end, 8 mm wide, which draws
    the module to itself; `ripple` / N, a force that goes with sin(2π·x/11 mm).
    """

    m: float
    k: float
    c: float
    taut: float
    friction: float = 0.0
    static_ratio: float = 1.0
    viscous: float = 0.0
    quadratic: float = 0.0
    tilt: float = 0.0
    cubic: float = 0.0
    compliance: float = 0.0
    amplitude: float = 0.0
    magnet: float = 0.0
    ripple: float = 0.0


@dataclass(frozen=True)
class Test:
    """What the lab commands: `thrust` as pairs (time, force from then on), length of the record, start state."""

    name: str
    thrust: tuple[tuple[float, float], ...]
    duration: float = 60.0
    x0: float = 0.0
    v0: float = 0.0
    t0: float = 0.0

    __test__ = False


@dataclass(frozen=True)
class Instruments:
    """Rates / Hz, standard deviations of the noise, and rounding steps (0: none) of position, velocity and tension.

    A rate of 0 leaves a channel out. `offset` shifts the stamps of a channel against the clock of position, in s:
    a stamp t belongs to the true time t − offset. `gain`, `zero` are the load cell's, `scale` the motion capture's;
    `drift` / (N/s) and `hum` / N at `hum_frequency` / Hz act on the load cell, `hum_x` / m and `hum_v` / (m/s) on the
    others; `curve` / (1/N): the cell reads T·(1 + curve·T), in nobody's table. `outliers` and `gaps`: parts of all
    readings that are far off, or missing.
    """

    rates: tuple[float, float, float] = (100.0, 100.0, 200.0)
    noise: tuple[float, float, float] = (2e-4, 2e-3, 5e-3)
    rounding: tuple[float, float, float] = (1e-5, 1e-5, 1e-3)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gain: float = 1.0
    zero: float = 0.0
    scale: float = 1.0
    saturation: float = np.inf
    drift: float = 0.0
    hum: float = 0.0
    hum_frequency: float = 17.3
    hum_x: float = 0.0
    hum_v: float = 0.0
    curve: float = 0.0
    outliers: float = 0.0
    gaps: float = 0.0


@dataclass(frozen=True)
class Scatter:
    """Standard deviations of what differs from the stated values: common to all runs, and from run to run.

    `mass`, `thrust`, `gain`, `scale` are relative; `length`, `start` in m; `speed` in m/s; `zero` in N; `clock` in s
    (of the load cell against the motion capture). Every run starts off its stated state by `start_run`, `speed_run`.
    """

    mass: float = 0.0
    mass_run: float = 0.0
    thrust: float = 0.0
    thrust_run: float = 0.0
    length: float = 0.0
    length_run: float = 0.0
    gain: float = 0.0
    scale: float = 0.0
    zero_run: float = 0.0
    clock: float = 0.0
    start_run: float = 0.0
    speed_run: float = 0.0


@dataclass(frozen=True)
class Record:
    """One measured run: what the lab states (`test`), its readings by channel, and what was true."""

    test: Test
    t: dict[str, np.ndarray]
    readings: dict[str, np.ndarray]
    clean: dict[str, np.ndarray]
    truth: Truth
    true_test: Test
    true_instruments: Instruments
    events: tuple[tuple[float, str], ...] = field(default=())


def motion(truth: Truth, test: Test, stamps: dict[str, np.ndarray], *, rtol: float = 1e-11):
    """Position, velocity and tension at `stamps` ({'x': …, 'v': …, 'T': …}), and the events as pairs (time, kind).

    DOP853 (LSODA where the mount makes it stiff), one piece of the motion at a time: thrust changes, contact, loss of
    tension, sticking and slipping are located by SciPy's root finder, and each piece starts exactly there.
    """
    readings = {name: np.full(len(t), np.nan) for name, t in stamps.items()}
    line_strain = test.x0 - truth.taut if truth.compliance else 0.0
    state = np.array([test.x0, test.v0, max(line_strain, 0.0)])
    now, events = test.t0, []
    last = max([test.t0, *(float(t[-1]) for t in stamps.values() if len(t))]) + 1e-9
    changes = [(t, f) for t, f in sorted(test.thrust) if t < last]
    before = [f for t, f in changes if t <= now]
    force = before[-1] if before else 0.0
    pending = [(t, f) for t, f in changes if t > now]
    line = _line_at(truth, state)
    slide = _slide_at(truth, state, line, force)
    for name, t in stamps.items():
        early = t < now
        readings[name][early] = _channel(name, truth, state[:, None], line)[0]
    while now < last:
        stop = pending[0][0] if pending else last
        solution, happened = _piece(truth, state, (now, stop), (line, slide, force), rtol)
        end = solution.t[-1]
        for name, t in stamps.items():
            inside = (t >= now) & (t < end)
            if inside.any():
                readings[name][inside] = _channel(name, truth, solution.sol(t[inside]), line)
        state, now = solution.y[:, -1].copy(), end
        if happened is None:
            if pending:
                _, force = pending.pop(0)
                events.append((now, "force"))
                slide = _slide_at(truth, state, line, force) if slide == 0 or state[1] == 0 else slide
            continue
        line, slide, kind = _after(truth, state, (line, slide, force), happened)
        if happened == "stop":
            state[1] = 0.0
        events.append((now, kind))
    return readings, tuple(events)


def _elongation(truth, y):
    return y[0] - truth.taut


def _pull(truth, y):
    """Tension of a taut line, before it is cut at zero."""
    e = _elongation(truth, y)
    if truth.compliance:
        return (e - y[2]) / truth.compliance
    return truth.k * e + truth.cubic * e**3 + (truth.c + truth.amplitude * abs(e)) * y[1]


def _line_at(truth, y):
    e = _elongation(truth, y)
    if e < 0 or (e == 0 and y[1] <= 0):
        return "slack"
    return "taut" if _pull(truth, y) > 0 or truth.compliance else "clipped"


def _channel(name, truth, y, line):
    if name == "x":
        return y[0]
    if name == "v":
        return y[1]
    return np.maximum(_pull(truth, y), 0.0) if line == "taut" else np.zeros_like(y[0])


def _drive(truth, y, line, force):
    drag = truth.viscous * y[1] + truth.quadratic * y[1] * abs(y[1])
    tension = max(_pull(truth, y), 0.0) if line == "taut" else 0.0
    away = (y[0] - 0.5 * truth.taut) / 8e-3
    stray = truth.ripple * np.sin(2 * np.pi * y[0] / 11e-3) - truth.magnet * away * np.exp(0.5 - 0.5 * away**2)
    return force - tension - drag + truth.m * 9.8 * np.sin(truth.tilt) + stray


def _slide_at(truth, y, line, force):
    """Direction in which the module slides, 0 where friction holds it."""
    if truth.friction == 0:
        return 1
    if y[1] != 0:
        return int(np.sign(y[1]))
    net = _drive(truth, y, line, force)
    return 0 if abs(net) <= truth.friction * truth.static_ratio else int(np.sign(net))


def _piece(truth, state, span, regime, rtol):
    line, slide, force = regime

    def rate(_t, y):
        acceleration = 0.0
        if slide != 0:
            acceleration = (_drive(truth, y, line, force) - truth.friction * slide) / truth.m
        strain = 0.0
        if truth.compliance:
            pull = _pull(truth, y) if line == "taut" else 0.0
            strain = (pull - truth.k * y[2] - truth.cubic * y[2] ** 3) / truth.c
        return [y[1] if slide != 0 else 0.0, acceleration, strain]

    watch = _watch(truth, regime)
    for _, event in watch:
        event.terminal = True
    method = "LSODA" if truth.compliance and line == "taut" else "DOP853"
    solution = solve_ivp(
        rate,
        span,
        state,
        method=method,
        rtol=max(rtol, 1e-11) if method == "LSODA" else rtol,
        atol=1e-14,
        # A line that lets go for a moment crosses zero twice, which SciPy does not see within one step.
        max_step=0.02 if line == "clipped" else 0.25,
        dense_output=True,
        events=[event for _, event in watch] or None,
    )
    assert solution.success, solution.message
    if solution.status == 1:
        index = next(i for i, found in enumerate(solution.t_events) if len(found))
        return solution, watch[index][0]
    return solution, None


def _watch(truth, regime):
    """What can end a piece: pairs (name, event function)."""
    line, slide, force = regime
    watch = []

    def add(name, function, direction):
        function.direction = direction
        watch.append((name, function))

    if truth.compliance:
        # The line keeps its own strain while it hangs loose: it pulls again when the mount meets its end.
        if line == "taut":
            add("lost", lambda _t, y: y[0] - truth.taut - y[2], -1)
        else:
            add("met", lambda _t, y: y[0] - truth.taut - y[2], +1)
    elif line == "slack":
        add("met", lambda _t, y: y[0] - truth.taut, +1)
    elif line == "taut":
        add("lost", lambda _t, y: _pull(truth, y), -1)
    else:
        add("loose", lambda _t, y: y[0] - truth.taut, -1)
        add("met", lambda _t, y: _pull(truth, y), +1)
    if truth.friction and slide != 0:
        add("stop", lambda _t, y: slide * y[1], -1)
    if truth.friction and slide == 0:
        limit = truth.friction * truth.static_ratio
        add("break", lambda _t, y: abs(_drive(truth, y, line, force)) - limit, +1)
    return watch


def _after(truth, y, regime, happened):
    line, slide, force = regime
    if happened == "met":
        return "taut", slide, "taut"
    if happened == "lost":
        return ("clipped" if _elongation(truth, y) > 1e-12 and not truth.compliance else "slack"), slide, "slack"
    if happened == "loose":
        return "slack", slide, "loose"
    still = y.copy()
    still[1] = 0.0
    if happened == "stop":
        turned = _slide_at(truth, still, line, force)
        return line, turned, "stick" if turned == 0 else "turn"
    return line, int(np.sign(_drive(truth, still, line, force))), "slip"


def measure(
    truth: Truth, test: Test, instruments: Instruments, rng: np.random.Generator, *, stated: Test | None = None,
    follow=motion,
):  # fmt: skip
    """One `Record` of a test as the instruments see it; `stated` is what the lab believes that it commanded."""
    stamps, seen_at = {}, {}
    for name, rate, offset in zip("xvT", instruments.rates, instruments.offset, strict=True):
        if rate > 0:
            stamps[name] = test.t0 + np.arange(int(test.duration * rate) + 1) / rate
            seen_at[name] = stamps[name] - offset
    clean, events = follow(truth, test, seen_at)
    readings = {}
    for name, noise, step in zip("xvT", instruments.noise, instruments.rounding, strict=True):
        if name not in clean:
            continue
        gain = instruments.gain if name == "T" else instruments.scale
        zero = instruments.zero if name == "T" else 0.0
        t = stamps[name]
        amplitude = {"x": instruments.hum_x, "v": instruments.hum_v, "T": instruments.hum}[name]
        stray = amplitude * np.sin(2 * np.pi * instruments.hum_frequency * t)
        if name == "T":
            stray = stray + instruments.drift * (t - test.t0) + instruments.curve * clean[name] ** 2
        value = gain * clean[name] + zero + stray + noise * rng.standard_normal(len(clean[name]))
        if name == "T":
            value = np.minimum(value, instruments.saturation)
        readings[name] = np.round(value / step) * step if step > 0 else value
        if instruments.outliers or instruments.gaps:
            chance = rng.random(len(value))
            far = chance < instruments.outliers
            readings[name][far] += 50 * noise * rng.standard_normal(int(far.sum()))
            readings[name][chance > 1 - instruments.gaps] = np.nan
    return Record(stated or test, stamps, readings, clean, truth, test, instruments, events)


def common_part(scatter: Scatter, rng: np.random.Generator) -> dict[str, float]:
    """What all runs of a campaign share: factors of mass, thrust, gain and scale, shifts of length and clock."""
    draw = rng.standard_normal
    return {
        "mass": 1 + scatter.mass * draw(), "thrust": 1 + scatter.thrust * draw(),
        "length": scatter.length * draw(), "clock": scatter.clock * draw(),
        "gain": 1 + scatter.gain * draw(), "scale": 1 + scatter.scale * draw(),
    }  # fmt: skip


def campaign(
    truth: Truth, tests, instruments: Instruments, scatter: Scatter, rng: np.random.Generator, *, follow=motion
) -> list[Record]:
    """Records of several tests, with the inputs drawn anew: a common part, and a part for each run.

    `follow` integrates: `motion`, or `truth_full.follow`.
    """
    common = common_part(scatter, rng)
    records = []
    for test in tests:
        push = common["thrust"] + scatter.thrust_run * rng.standard_normal()
        true_truth = replace(
            truth,
            m=truth.m * (common["mass"] + scatter.mass_run * rng.standard_normal()),
            taut=truth.taut + common["length"] + scatter.length_run * rng.standard_normal(),
        )
        true_test = replace(
            test,
            thrust=tuple((t, f * push) for t, f in test.thrust),
            x0=test.x0 + scatter.start_run * rng.standard_normal(),
            v0=test.v0 + scatter.speed_run * rng.standard_normal(),
        )
        true_instruments = replace(
            instruments,
            gain=instruments.gain * common["gain"],
            scale=instruments.scale * common["scale"],
            zero=instruments.zero + scatter.zero_run * rng.standard_normal(),
            offset=(instruments.offset[0], instruments.offset[1], instruments.offset[2] + common["clock"]),
        )
        records.append(measure(true_truth, true_test, true_instruments, rng, stated=test, follow=follow))
    return records
