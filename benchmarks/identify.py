"""Time of a joint fit against `solve_ivp` and `least_squares` as a user writes them.

    python benchmarks/identify.py

Six runs of 12 000 samples (60 s at 200 Hz: position, velocity, tension), four parameters (k, c, taut position, thrust
gain). The user's residuals integrate every run with `solve_ivp`, contact located by events, and difference forward. His
fit is not run to its end: one evaluation of all residuals is timed, and multiplied by the evaluations that
`least_squares` takes on the same problem when our own simulation serves it (four differences and one value a step).
Times are those of the processor, so that other work on the machine does not count.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from response_cases import measured
from truth_response import Instruments, Scatter, Test, Truth, campaign

from metrology.estimation import Settings, fit
from metrology.rig import Rig, simulate

FREE = ("k", "c", "free_length.shift", "thrust.gain")
MATERIALS = {"nylon": (167.64, 8.0), "al-1100": (24734.25, 48.81)}


def user_run(values, test, t):
    """One run as a user writes it: RK45 between contacts, relative tolerance 1e-8."""
    k, c, shift, gain = values
    taut, state, now = 0.2 + shift, np.array([test.x0, test.v0]), 0.0
    x, v, pull = np.empty_like(t), np.empty_like(t), np.empty_like(t)
    edges = [*(edge for edge, _ in test.thrust if edge > 0), t[-1] + 1e-9]
    force = 0.0

    def tension(y):
        e = y[0] - taut
        return np.where(e > 0, np.maximum(k * e + c * y[1], 0.0), 0.0)

    def contact(_t, y):
        return y[0] - taut

    contact.terminal = True
    for edge in edges:
        while now < edge - 1e-12:
            solved = solve_ivp(
                lambda _t, y, push=force: [y[1], (push - float(tension(y))) / 25.0],
                (now, edge), state, rtol=1e-8, atol=1e-10, max_step=0.5, dense_output=True, events=contact,
            )  # fmt: skip
            inside = (t >= now) & (t <= solved.t[-1])
            if inside.any():
                y = solved.sol(t[inside])
                x[inside], v[inside], pull[inside] = y[0], y[1], tension(y)
            state, now = solved.y[:, -1] + np.array([1e-13 * np.sign(solved.y[1, -1]), 0.0]), solved.t[-1]
        force = next((f * gain for at, f in test.thrust if at == edge), force)
    return x, v, pull


def main():
    for material, (k, c) in MATERIALS.items():
        truth = Truth(m=25.0, k=k, c=c, taut=0.2)
        tests = [Test(f"step {i}", ((1.0, f),), 59.995) for i, f in enumerate((0.38, 0.5, 0.62))]
        tests += [Test(f"impulse {i}", ((1.0, 0.62), (3.0 + 0.5 * i, 0.0)), 59.995) for i in range(3)]
        instruments = Instruments(rates=(200.0, 200.0, 200.0))
        records = campaign(truth, tests, instruments, Scatter(), np.random.default_rng(1))
        runs = [measured(record) for record in records]
        rig = Rig(m=25.0, k=1.05 * k, c=0.9 * c, taut=0.2)
        fit(rig, runs[:1], free=FREE)
        quick, whole = [], []
        for _ in range(3):
            begun = time.process_time()
            found = fit(rig, runs, free=FREE, settings=Settings(profile=False))
            quick.append(time.process_time() - begun)
            begun = time.process_time()
            fit(rig, runs, free=FREE)
            whole.append(time.process_time() - begun)
        begun = time.process_time()
        for record in records:
            user_run((1.05 * k, 0.9 * c, 0.0, 1.0), record.test, record.t["x"])
        once = time.process_time() - begun
        distance, evaluations = reference(rig, runs, found)
        user = once * evaluations
        print(f"{material}: {found.sentence}; χ²/ν = {found.reduced_chi_squared:.4f}")
        print(f"  fit {min(quick):.2f} s, with profiles {min(whole):.2f} s")
        print(f"  user: {once:.2f} s an evaluation × {evaluations} evaluations = {user:.0f} s (extrapolated)")
        print(f"  ratio {user / min(quick):.0f}, with profiles {user / min(whole):.0f}")
        print(f"  distance from the optimum of least_squares: {distance:.1e} u")


def reference(rig, runs, found):
    """Optimum of `least_squares` on the same weights, from the user's start, and the evaluations that it took.

    Its derivatives are taken over a thousandth of u, its tolerances are at the limit of the digits: it ends where the
    gradient vanishes to 1e-6 u.
    """
    weight = {(one.run, one.channel): one.used for one in found.residuals}
    use = [{name: weight[run.name, name] for name in run.channels} for run in runs]
    scale = np.sqrt(np.diag(found.total))

    def residuals(values):
        parts = []
        for at, run in enumerate(runs):
            moved = simulate(rig.with_values(found.layout.values(at, values)), run.run)
            for name in run.channels:
                parts += [np.where(use[at][name], run.readings(name) - getattr(moved, name), 0) / run.noise[name]]
        return np.concatenate(parts)

    def slopes(values):
        # Steps of a thousandth of u: wider ones carry late contacts past a reading.
        moves = 1e-3 * np.diag(scale)
        columns = [(residuals(values + move) - residuals(values - move)) / (2 * move.sum()) for move in moves]
        return np.column_stack(columns)

    calls = [0]

    def counted(values):
        calls[0] += 1
        return residuals(values)

    start = np.array([rig.value(name) for name in FREE])
    least_squares(counted, start, x_scale=np.maximum(np.abs(start), 1e-3), xtol=1e-10, ftol=1e-10)
    near = least_squares(
        residuals, found.theta + 0.05 * scale, jac=slopes, x_scale=scale, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    return float(np.abs((near.x - found.theta) / scale).max()), calls[0]


if __name__ == "__main__":
    main()
