"""What truly happens on a rig with anything at all the matter: own equations, small fixed steps, events located.

Shares no code with `metrology`. A `Full` is a `Truth` with inner states as well (frame, Zener branch, loop, yaw, lag of
the thrust), and with causes that stand in nobody's table. Fourth-order Runge–Kutta steps of at most 0.5 ms, shorter for
a quick mode; a step in which the regime changes is halved down to 1e-10 s. `follow` serves `truth_response.campaign`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numba
import numpy as np
from truth_response import Test, Truth


@dataclass(frozen=True)
class Full(Truth):
    """The physics, SI.

    In tables: `frame` / (m/N) with `frame_omega`, `frame_zeta`; `toe` (part of the stiffness that it lacks) up to
    `toe_end` / m; `branch` / (N/m) relaxing in `branch_time` / s; `loop` / (N/m) yielding at `loop_end` / m; `weight` /
    (N/m) of a sagging line of length `taut`; `slip` / m at the first turn of a taut line; `arm` / m with `inertia`,
    `yaw_omega`; `thrust_gain`, `lag`, `delay`, `heavier` (relative), `longer` / m; `tank` / kg of the mass, which
    swings with `tank_omega` and a damping ratio of 0.03; `by_rate` / (N·s²/m²), line damping in proportion to ė·|ė|.

    In nobody's table: `leak` / (1/s) of the thrust's force; `warming` / (1/s), by which k falls; `sway` / N at
    `sway_rate` / Hz; `knock` / N for 0.3 s at `knock_time`; `patch` / N of friction on a third of the way only;
    `cable` / (N/m), a spring that acts beyond half the way; `tow` / N constant from `knock_time` on; `guide`, a
    friction of that part of the tension.
    """

    frame: float = 0.0
    frame_omega: float = 200.0
    frame_zeta: float = 0.03
    toe: float = 0.0
    toe_end: float = 1e-3
    branch: float = 0.0
    branch_time: float = 1.0
    loop: float = 0.0
    loop_end: float = 1e-3
    weight: float = 0.0
    slip: float = 0.0
    arm: float = 0.0
    inertia: float = 1.0
    yaw_omega: float = 1.0
    thrust_gain: float = 1.0
    lag: float = 0.0
    delay: float = 0.0
    heavier: float = 0.0
    longer: float = 0.0
    leak: float = 0.0
    warming: float = 0.0
    sway: float = 0.0
    sway_rate: float = 0.37
    knock: float = 0.0
    knock_time: float = 6.3
    patch: float = 0.0
    cable: float = 0.0
    tow: float = 0.0
    guide: float = 0.0
    tank: float = 0.0
    tank_omega: float = 1.0
    by_rate: float = 0.0


NAMES = [entry.name for entry in fields(Full)]
AT = {name: at for at, name in enumerate(NAMES)}
(M, K, C, TAUT, FRICTION, STATIC, VISCOUS, QUADRATIC, TILT, CUBIC, _COMPLIANCE, AMPLITUDE, MAGNET, RIPPLE) = range(14)
assert NAMES[RIPPLE] == "ripple"
(FRAME, FRAME_W, FRAME_Z, TOE, TOE_END, BRANCH, BRANCH_T, LOOP, LOOP_END, WEIGHT, SLIP, ARM, INERTIA) = range(14, 27)
(YAW_W, GAIN, LAG, DELAY, HEAVIER, LONGER, LEAK, WARMING, SWAY, SWAY_RATE, KNOCK, KNOCK_T) = range(27, 39)
(PATCH, CABLE, TOW, GUIDE, TANK, TANK_W, BY_RATE) = range(39, 46)
assert NAMES[BY_RATE] == "by_rate"
SLACK, PULLING, CLIPPED = 0, 1, 2
X, V, Z, H, U, DU, PHI, DPHI, PUSH, S, DS = range(11)
jit = numba.njit(cache=True)


@jit
def _elongation(p, y, slipped):
    e = y[X] - p[TAUT] - p[LONGER] - y[U] - p[ARM] * y[PHI]
    return e - p[SLIP] if slipped else e


@jit
def _elastic(p, t, strain):
    k = p[K] * (1.0 - p[WARMING] * t)
    if p[TOE] > 0.0:
        soft = (1.0 - p[TOE]) * k
        return soft * strain if strain < p[TOE_END] else soft * p[TOE_END] + k * (strain - p[TOE_END])
    return k * strain + p[CUBIC] * strain**3


@jit
def _pull(p, t, y, slipped):
    """Tension of a stretched line before it is cut at zero."""
    e = _elongation(p, y, slipped)
    rate = y[V] - y[DU] - p[ARM] * y[DPHI]
    if p[WEIGHT] > 0.0:
        # Chord of an elastic catenary: T³/k − e·T² − w²·s³/24 = 0. Its damping acts on the strain of the line, a part
        # of the elongation, and takes no more energy than the module gives: c·ε′² = (T − T_s)·e′.
        hang = p[WEIGHT] ** 2 * p[TAUT] ** 3 / 24.0
        tension = max(p[K] * e, 0.0) + (hang * p[K]) ** (1.0 / 3.0)
        for _ in range(40):
            step = (tension**3 / p[K] - e * tension**2 - hang) / (3 * tension**2 / p[K] - 2 * e * tension)
            tension -= step
            if abs(step) < 1e-13 * tension:
                break
        part = 1.0 / (1.0 + 2 * hang * p[K] / tension**3)
        return tension + p[C] * part**2 * rate
    found = _elastic(p, t, e) + (p[C] + p[AMPLITUDE] * abs(e) + p[BY_RATE] * abs(rate)) * rate
    return found + p[BRANCH] * (e - y[Z]) + p[LOOP] * y[H]


@jit
def _tension(p, t, y, line, slipped):
    return _pull(p, t, y, slipped) if line == PULLING else 0.0


@jit
def _command(p, t, edges, forces):
    force = 0.0
    for at in range(len(edges)):
        if t >= edges[at] + p[DELAY]:
            force = forces[at]
    return force * p[GAIN] * (1.0 - p[LEAK] * max(t, 0.0))


@jit
def _drive(p, t, y, regime, command):
    """All forces on the module but its friction."""
    line, _, slipped = regime
    force = y[PUSH] if p[LAG] > 0.0 else command
    m = p[M] * (1.0 + p[HEAVIER])
    pull = _tension(p, t, y, line, slipped)
    force -= pull + p[VISCOUS] * y[V] + p[QUADRATIC] * y[V] * abs(y[V]) - m * 9.8 * np.sin(p[TILT])
    away = (y[X] - 0.5 * p[TAUT]) / 8e-3
    force += p[RIPPLE] * np.sin(2 * np.pi * y[X] / 11e-3) - p[MAGNET] * away * np.exp(0.5 - 0.5 * away**2)
    force += p[SWAY] * np.sin(2 * np.pi * p[SWAY_RATE] * t)
    if p[KNOCK_T] <= t:
        force += p[TOW] + (p[KNOCK] if t < p[KNOCK_T] + 0.3 else 0.0)
    if p[PATCH] > 0.0 and 0.4 * p[TAUT] < y[X] < 0.7 * p[TAUT]:
        force -= p[PATCH] * np.tanh(y[V] / 2e-4)
    if p[GUIDE] > 0.0:
        force -= p[GUIDE] * pull * np.tanh(y[V] / 2e-4)
    if p[TANK] > 0.0:
        force += p[TANK] * (p[TANK_W] ** 2 * (y[S] - y[X]) + 0.06 * p[TANK_W] * (y[DS] - y[V]))
    return force - p[CABLE] * max(y[X] - 0.5 * p[TAUT], 0.0)


@jit
def _rate(p, t, y, regime, command):
    line, slide, slipped = regime
    m = p[M] * (1.0 + p[HEAVIER])
    found = np.zeros(11)
    e = _elongation(p, y, slipped)
    rate = y[V] - y[DU] - p[ARM] * y[DPHI]
    pull = _tension(p, t, y, line, slipped)
    if slide != 0:
        found[X] = y[V]
        found[V] = (_drive(p, t, y, regime, command) - p[FRICTION] * slide) / (m - p[TANK])
    # A slack line is not strained: its branch relaxes towards zero, its loop stays as it is.
    stretched = e if line != SLACK else 0.0
    if p[BRANCH] > 0.0:
        found[Z] = (stretched - y[Z]) / p[BRANCH_T]
    if p[LOOP] > 0.0 and line != SLACK:
        same = 0.5 * (1.0 + np.sign(rate * y[H]))
        found[H] = rate * (1.0 - same * abs(y[H] / p[LOOP_END]))
    if p[FRAME] > 0.0:
        found[U] = y[DU]
        found[DU] = p[FRAME_W] ** 2 * (p[FRAME] * pull - y[U]) - 2 * p[FRAME_Z] * p[FRAME_W] * y[DU]
    if p[ARM] > 0.0:
        found[PHI] = y[DPHI]
        found[DPHI] = p[ARM] * pull / p[INERTIA] - p[YAW_W] ** 2 * y[PHI] - 0.04 * p[YAW_W] * y[DPHI]
    if p[TANK] > 0.0:  # where it is in space, from where it hung at the start
        found[S] = y[DS]
        found[DS] = -(p[TANK_W] ** 2) * (y[S] - y[X]) - 0.06 * p[TANK_W] * (y[DS] - y[V])
    if p[LAG] > 0.0:
        found[PUSH] = (command - y[PUSH]) / p[LAG]
    return found


@jit
def _advanced(p, t, y, h, regime, command):
    a = _rate(p, t, y, regime, command)
    b = _rate(p, t + h / 2, y + h / 2 * a, regime, command)
    c = _rate(p, t + h / 2, y + h / 2 * b, regime, command)
    d = _rate(p, t + h, y + h * c, regime, command)
    return y + h / 6 * (a + 2 * b + 2 * c + d)


@jit
def _over(p, t, y, regime, command):
    """Whether a regime has ended: contact, pull, sliding, sticking, first turn."""
    line, slide, slipped = regime
    e, raw = _elongation(p, y, slipped), _pull(p, t, y, slipped)
    hangs = p[WEIGHT] > 0.0
    if line == SLACK and e > 0.0:
        return True
    if line == PULLING and (raw < 0.0 or (e < 0.0 and not hangs)):
        return True
    if line == CLIPPED and ((e < 0.0 and not hangs) or raw > 0.0):
        return True
    if p[FRICTION] > 0.0:
        if slide != 0 and slide * y[V] < 0.0:
            return True
        if slide == 0 and abs(_drive(p, t, y, regime, command)) > p[FRICTION] * p[STATIC]:
            return True
    return p[SLIP] > 0.0 and not slipped and line == PULLING and y[V] < 0.0


@jit
def _settled(p, t, y, regime, command):
    """Regime that holds from here on."""
    line, slide, slipped = regime
    if p[SLIP] > 0.0 and not slipped and line == PULLING and y[V] < 0.0:
        slipped = True
    e = _elongation(p, y, slipped)
    loose = e < 0.0 and p[WEIGHT] == 0.0
    line = SLACK if loose else (PULLING if _pull(p, t, y, slipped) > 0.0 else CLIPPED)
    if p[FRICTION] > 0.0:
        if slide * y[V] < 0.0 or slide == 0 or y[V] == 0.0:
            y[V] = 0.0
            net = _drive(p, t, y, (line, 0, slipped), command)
            slide = 0 if abs(net) <= p[FRICTION] * p[STATIC] else int(np.sign(net))
    else:
        slide = 1
    return line, slide, slipped


@jit
def _march(p, y, t, stops, edges, forces, largest):
    found = np.empty((len(stops), 3))
    command = _command(p, t, edges, forces)
    y[PUSH] = command
    regime = _settled(p, t, y, (SLACK, 0 if y[V] == 0.0 else int(np.sign(y[V])), False), command)
    for at in range(len(stops)):
        while t < stops[at] - 1e-12:
            h = min(largest, stops[at] - t)
            after = _advanced(p, t, y, h, regime, command)
            if _over(p, t + h, after, regime, command):
                low, high = 0.0, h
                while high - low > 1e-10:
                    middle = 0.5 * (low + high)
                    after = _advanced(p, t, y, middle, regime, command)
                    if _over(p, t + middle, after, regime, command):
                        high = middle
                    else:
                        low = middle
                h = high
                after = _advanced(p, t, y, h, regime, command)
                y, t = after, t + h
                regime = _settled(p, t, y, regime, command)
                continue
            y, t = after, t + h
        before = command
        command = _command(p, t + 1e-12, edges, forces)
        if command != before:
            regime = _settled(p, t, y, regime, command)
        found[at, 0], found[at, 1] = y[X], y[V]
        found[at, 2] = max(_tension(p, t, y, regime[0], regime[2]), 0.0)
    return found


def follow(truth: Full, test: Test, stamps: dict[str, np.ndarray]):
    """Position, velocity and tension at `stamps`, as `truth_response.motion` gives them."""
    p = np.array([getattr(truth, name) for name in NAMES], dtype=float)
    edges = np.array([t for t, _ in sorted(test.thrust)], dtype=float)
    forces = np.array([force for _, force in sorted(test.thrust)], dtype=float)
    wanted = np.concatenate([*stamps.values(), edges + truth.delay, [truth.knock_time, truth.knock_time + 0.3]])
    stops = np.unique(wanted[wanted > test.t0])
    y = np.zeros(11)
    y[X], y[V] = y[S], y[DS] = test.x0, test.v0
    largest = 5e-4 if truth.frame == 0 else min(5e-4, 0.1 / truth.frame_omega)
    if truth.weight > 0:
        # From hanging to straight within this elongation, which a module at 0.05 m/s crosses in no time.
        soon = (truth.weight**2 * truth.taut**3 / 24 / truth.k**2) ** (1 / 3)
        largest = min(largest, max(6 * soon, 1e-5))
    rows = _march(p, y, float(test.t0), stops, edges, forces, largest)
    begun = np.array([[test.x0, test.v0, max(rows[0, 2], 0.0) if test.x0 > truth.taut else 0.0]])
    rows, places = np.vstack([begun, rows]), np.concatenate([[test.t0], stops])
    at = {name: np.searchsorted(places, np.maximum(t, test.t0)) for name, t in stamps.items()}
    return {name: rows[at[name], "xvT".index(name)] for name in stamps}, ()
