"""How fast and how exact the rig is against SciPy, both measured in this run: `python benchmarks/rig.py`.

Bars: base model at least 500 times `solve_ivp`, every single effect 50 times, a sagging line 3 ms for 20 s at 200 Hz,
derivatives by 20 parameters 5 runs of the nonlinear integrator, cold compile 30 s. `--all` adds errors over 60 s.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "rig"))

from independent_rig import Reference

from metrology.rig import Force, Rig, Run, sensitivities, simulate, simulate_many

T = np.arange(12001) / 200.0
STEP = [(1.0, 0.38)]
MATERIALS = {"nylon": (167.64, 8.0), "spectra": (753.33, 35.0), "peek": (1810.91, 0.37), "al-1100": (24734.25, 48.81)}
EFFECTS = {
    "friction": {"friction.force": 2e-3},
    "viscous drag": {"drag.viscous": 0.05},
    "quadratic drag": {"drag.quadratic": 1.0},
    "tilt": {"tilt.angle": 1e-4},
    "set-up compliance": {"setup.compliance": 8e-6},
    "frame": {"frame.compliance": 8e-6},
    "cubic": {"cubic.stiffness": 1e5},
    "toe": {"toe.extent": 1e-3},
    "zener": {"zener.stiffness": 50.0, "zener.time": 0.2},
    "amplitude damping": {"damping.amplitude": 300.0},
    "hysteresis": {"hysteresis.stiffness": 50.0, "hysteresis.yield": 1e-3},
    "sag": {"sag.weight": 0.016},
    "thrust lag": {"thrust.lag": 0.02},
    "clamp slip": {"slip.set": 2e-4},
    "yaw": {"yaw.arm": 0.05},
    "load cell": {"cell.gain": 1.02, "cell.drift": 1e-4},
    "clocks": {"clock.T": 4e-3},
}


def seconds(function: Callable[[], object], repeats: int) -> float:
    """Least processor time of one call, of several rounds."""
    function()
    rounds = []
    for _ in range(5):
        start = time.process_time()
        for _ in range(repeats):
            function()
        rounds.append((time.process_time() - start) / repeats)
    return min(rounds)


def as_a_user(k: float, c: float) -> Callable[[], object]:
    """solve_ivp as it is commonly written: RK45 at 1e-6, friction smoothed by tanh."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        x, v = y
        e = x - 1.5
        tension = max(0.0, k * e + c * v) if e > 0 else 0.0
        return [v, ((0.38 if t >= 1.0 else 0.0) - 2e-3 * np.tanh(v / 1e-4) - tension) / 25.0]

    return lambda: solve_ivp(rates, (0.0, 60.0), [1.45, 0.0], t_eval=T, rtol=1e-6)


def once(function: Callable[[], object]) -> float:
    """Processor time of one call."""
    start = time.process_time()
    function()
    return time.process_time() - start


def worst(motion: object, truth: object) -> float:
    """Largest error of x, v and T over each one's largest value."""
    pairs = [(getattr(motion, name)[2:], getattr(truth, name)[2:]) for name in "xvT"]
    return max(np.abs(ours - theirs).max() / np.abs(theirs).max() for ours, theirs in pairs)


TWENTY = (
    "m", "k", "c", "free_length.shift", "friction.force", "drag.viscous", "tilt.angle", "setup.compliance",
    "thrust.gain", "thrust.delay", "start.x", "start.v", "cell.gain", "cell.zero", "cell.drift", "motion.scale",
    "clock.x", "clock.v", "clock.T",
)  # fmt: skip
"""Parameters of a usual diagnosis; the effect's own one is the twentieth."""


def print_sensitivities(run: Run, stamps: str) -> None:
    """Print the time of a sagging line and that of derivatives by 20 parameters against one run, all for 20 s."""
    print(f"\n{f'20 s at 200 Hz, {stamps}':28}{'run':>10}{'20 derivatives':>16}{'ratio':>7}")
    for material in MATERIALS:
        for name in ("sag", "quadratic drag", "cubic", "frame", "base model"):
            effects = EFFECTS.get(name, {})
            rig = Rig(25.0, *MATERIALS[material], 1.5, length=3.0, effects=effects)
            names = (*TWENTY, next(iter(effects), "mass.factor"))
            one = seconds(lambda rig=rig: simulate(rig, run, engine="compiled"), 5)
            all_of_them = seconds(lambda rig=rig, names=names: sensitivities(rig, run, names), 3)
            print(f"{material + ', ' + name:28}{1e3 * one:7.2f} ms{1e3 * all_of_them:13.2f} ms{all_of_them / one:7.1f}")


def print_compile() -> None:
    """Print the processor time of a cold compile of everything, in a process and a folder of its own."""
    code = "from metrology.rig import engines; [engines.loaded(name) for name in engines.PROGRAMS]"
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        environment = {**os.environ, "METROLOGY_CACHE": folder}
        subprocess.run([sys.executable, "-c", code], check=True, env=environment, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"\ncold compile: {after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime:.1f} s")


def print_errors(run: Run) -> None:
    """Print the errors of every effect and material over 60 s, compiled and with NumPy alone: some minutes."""
    print(f"\n{'error, 60 s: compiled/numpy':28}" + "".join(f"{name:>20}" for name in MATERIALS))
    for name, effects in EFFECTS.items():
        print(f"{name:28}", end="", flush=True)
        for k, c in MATERIALS.values():
            # Of a frame's two oscillations the reference has to follow the fast one: soft enough for that in minutes.
            given = effects if name != "frame" else {"frame.compliance": 8e-5, "frame.frequency": 100.0}
            reference = Reference(25.0, k, c, 1.5, **{key.replace(".", "__"): value for key, value in given.items()})
            rig = Rig(25.0, k, c, 1.5, length=3.0, effects=given)
            try:  # with longer steps SciPy's events miss contacts that last for milliseconds
                truth = reference.solve(T, 1.45, 0.0, STEP, longest=0.004)
            except AssertionError:
                print(f"{'no reference':>20}", end="", flush=True)
                continue
            found = [f"{worst(simulate(rig, run, engine=engine), truth):.0e}" for engine in ("compiled", "numpy")]
            print(f"{' / '.join(found):>20}", end="", flush=True)
        print()


def main() -> None:
    """Print the tables."""
    run = Run.sampled(T, 1.45, force=Force(*map(np.array, zip(*STEP, strict=True))))
    print(f"{'base model, 60 s at 200 Hz':28}{'solve_ivp':>11}{'rig':>10}{'ratio':>7}{'batch':>10}{'ratio':>7}", end="")
    print(f"{'numpy':>10}{'ratio':>7}{'error':>9}")
    for name, (k, c) in MATERIALS.items():
        rig = Rig(25.0, k, c, 1.5)
        theirs = seconds(as_a_user(k, c), 1)
        ours = seconds(lambda rig=rig: simulate(rig, run, engine="compiled"), 50)
        many = (
            seconds(lambda rig=rig, k=k: simulate_many(rig, run, ["k"], np.full((20, 1), k), engine="compiled"), 3) / 20
        )
        plain = seconds(lambda rig=rig: simulate(rig, run, engine="numpy"), 5)
        error = worst(simulate(rig, run), Reference(25.0, k, c, 1.5).solve(T, 1.45, 0.0, STEP))
        print(f"{name:28}{1e3 * theirs:8.1f} ms{1e6 * ours:7.0f} µs{theirs / ours:7.0f}", end="")
        print(f"{1e6 * many:7.0f} µs{theirs / many:7.0f}{1e6 * plain:7.0f} µs{theirs / plain:7.0f}{error:9.0e}")
    t, peek = T[:4001], (25.0, *MATERIALS["peek"], 1.5)
    short = Run.sampled(t, 1.45, force=Force(*map(np.array, zip(*STEP, strict=True))))
    print(
        f"\n{'single effect, 20 s, peek':28}{'solve_ivp':>11}{'rig':>10}{'ratio':>7}{'error':>9}   (DOP853 with events)"
    )
    for name, effects in EFFECTS.items():
        named = {key.replace(".", "__"): value for key, value in effects.items()}
        rig = Rig(*peek, length=3.0, effects=effects)
        ours = seconds(lambda rig=rig: simulate(rig, short, engine="compiled"), 10)
        reference = Reference(*peek, **named)
        theirs = once(lambda one=reference: one.solve(t, 1.45, 0.0, STEP, rtol=1e-10, longest=np.inf))
        truth = Reference(*peek, **named).solve(t, 1.45, 0.0, STEP)
        error = worst(simulate(rig, short), truth)
        print(f"{name:28}{1e3 * theirs:8.1f} ms{1e6 * ours:7.0f} µs{theirs / ours:7.0f}{error:9.0e}", flush=True)
    print_sensitivities(short, "even")
    jittered = np.sort(t + np.random.default_rng(0).uniform(0.0, 5e-3, t.size))
    print_sensitivities(replace(short, t_x=jittered, t_v=jittered, t_T=jittered), "uneven")
    print_compile()
    if "--all" in sys.argv:
        print_errors(run)


if __name__ == "__main__":
    main()
