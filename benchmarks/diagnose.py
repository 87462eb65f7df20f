"""Diagnosis of six runs of 12 000 samples, against the same search with `solve_ivp` and `least_squares`.

``python benchmarks/diagnose.py`` prints CPU times. The other way is extrapolated: two
simulations of one run are timed, and multiplied by the runs, the candidates, and the simulations that such a fit takes.
"""

from __future__ import annotations

import argparse
import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np

from metrology.diagnostics import Settings, response
from metrology.diagnostics.candidate import RESPONSE as TABLE
from metrology.estimation import MeasuredRun, Prior
from metrology.rig import Force, Rig, Run, simulate

RIG = Rig(m=25.0, k=167.64, c=8.0, taut=0.1)
NOISE = {"x": 2e-4, "v": 2e-3, "T": 5e-3}
STEPS = 10
"""Steps of a fit by `least_squares`, each with derivatives by forward differences."""


def runs(friction: float) -> list[MeasuredRun]:
    """Six runs of 60 s at 200 Hz with noise."""
    rng, t, found = np.random.default_rng(1), np.arange(12_000) / 200.0, []
    for at in range(6):
        push = 0.4 + 0.05 * at
        force = Force.step(push, 1.0) if at % 2 else Force.impulse(push, start=1.0, stop=4.0)
        run = Run.sampled(t, 0.0, force=force)
        moved = simulate(RIG.with_values({"friction.force": friction}), run)
        seen = {name: getattr(moved, name) + u * rng.standard_normal(len(t)) for name, u in NOISE.items()}
        found.append(MeasuredRun(f"run-{at}", run, noise=NOISE, **seen))
    return found


def ours(measured: list[MeasuredRun]) -> tuple[float, str]:
    """CPU time of a diagnosis and its verdict."""
    priors = (Prior("mass.factor", 0.002), Prior("thrust.gain", 0.005, 0.003), Prior("free_length.shift", 1e-3, 2e-4))
    begun = time.process_time()
    found = response(RIG, measured, rng=np.random.default_rng(1), priors=priors, settings=Settings(workers=2))
    return time.process_time() - begun, found.sentence


def other(measured: MeasuredRun) -> float:
    """CPU time of one simulation of one run as a user writes it: smooth friction, no events."""
    from scipy.integrate import solve_ivp

    force = measured.run.force
    assert force is not None

    def rate(t: float, y: np.ndarray) -> list[float]:
        push = force.values[np.searchsorted(force.t, t, side="right") - 1] if t >= force.t[0] else 0.0
        e = y[0] - RIG.taut
        pull = max(RIG.k * e + RIG.c * y[1], 0.0) if e > 0 else 0.0
        return [y[1], (push - pull - 1e-3 * np.tanh(y[1] / 1e-4)) / RIG.m]

    begun = time.process_time()
    for _ in range(2):
        solve_ivp(rate, (0.0, 60.0), [0.0, 0.0], t_eval=measured.stamps("x"), rtol=1e-6, atol=1e-9)
    return (time.process_time() - begun) / 2


def main() -> None:
    """Print the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peer-python", help="not needed here: both ways run in this environment")
    parser.parse_args()
    ours(runs(0.0))
    for words, friction in (("nothing missing", 0.0), ("friction of 1 mN", 1e-3)):
        spent, verdict = ours(runs(friction))
        print(f"{words}: {spent:.1f} s of CPU. {verdict}")
    # k, c, the candidate, three known inputs, and two more for every run.
    simulations = 6 * (len(TABLE) + 1) * STEPS * (1 + 6 + 2)
    spent = other(runs(1e-3)[0]) * simulations
    print(f"solve_ivp + least_squares, extrapolated from two simulations: {spent:.0f} s of CPU")


if __name__ == "__main__":
    main()
