"""What no method can tell apart in the tension tests of `diagnosis_tension`: distances in the generator's own noise.

``python studies/limits_tension.py [EFFECT …]`` prints for every planted effect of d = 10 how far the nearest other
causes stay from it, whatever their sizes and shapes, beside zeros, stiffness and set-up of every mounting. The noise is
that by which the generator draws, its covariance in closed form. Of two causes that are δ standard deviations apart,
equally probable beforehand, the likelihood ratio ln Λ is normal with mean δ²/2 and variance δ²: the right one is the
more probable in Φ(δ/2) of tests, and 20 times as probable in Φ(δ/2 − 3/δ), by the best of all methods.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
import tension_cases as cases
from scipy.stats import norm
from truth_tension import Machine, pull

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.tension import Tension
from metrology.gum.inputs import Input
from metrology.tension.lines import lines
from metrology.tension.test import Mounting, Range, TensionTest

D, SHOWN, PLACES = 10.0, 4, 12
SILENT = dict.fromkeys(("force_noise", "strain_noise", "crosshead_noise", "strain_division", "crosshead_division"), 0.0)


def covariance(one: Machine, means: np.ndarray) -> np.ndarray:
    """Covariance of means of the crosshead, then of the strain over the length, at the force as read."""
    apart = np.abs(np.subtract.outer(np.arange(one.count), np.arange(one.count)))
    coloured = (1 - one.white) * one.memory**apart + one.white * np.eye(one.count)
    own = [
        coloured * one.crosshead_noise**2 + np.eye(one.count) * one.crosshead_division**2 / 12,
        one.length**2 * (coloured * one.strain_noise**2 + np.eye(one.count) * one.strain_division**2 / 12),
    ]
    by_force = one.force_noise * np.array([one.length / one.EA + one.compliance, one.length / one.EA])
    shared = means @ means.T
    return np.block([[(means @ own[a] @ means.T) * (a == b) + by_force[a] * by_force[b] * shared for b in (0, 1)]
                     for a in (0, 1)])  # fmt: skip


def prepared(machines: list[Machine], rng: np.random.Generator) -> Tension:
    """The test as the package sees it, with a tenth of the noise: its columns are wanted, not its readings."""
    quiet = {"strain_division": 0.0, "crosshead_division": 0.0, "force_noise": 0.0}
    mountings = []
    for name, one in zip("abc", machines, strict=True):
        faint = {"strain_noise": 0.1 * one.strain_noise, "crosshead_noise": 0.1 * one.crosshead_noise}
        read = pull(replace(one, **quiet, **faint), rng)
        length = Input("length", one.length, (), "m")
        mountings.append(Mounting(name, read["force"], read["time"], read["crosshead"], (read["strain"],), length))
    test = TensionTest("pull", tuple(mountings), Range("share", *cases.RANGE))
    return Tension(test, lines(test))


class Known:
    """A test whose noise and nuisances are known."""

    def __init__(self, machines: list[Machine], seen: Tension) -> None:
        self.seen, self.means, self.weights = seen, [], []
        for one, record in zip(machines, seen.records, strict=True):
            times = record.seen.time[: record.count] * one.rate
            each = round(float(np.median(np.diff(times))))
            first = np.rint(times - (each - 1) / 2).astype(int)
            means = np.zeros((record.count, one.count))
            for row, at in enumerate(first):
                means[row, at : at + each] = 1 / each
            self.means.append(means)
            self.weights.append(np.linalg.inv(np.linalg.cholesky(covariance(one, means))))
        heads = [(record.seen.crosshead > 0).astype(float) for record in seen.records]
        forces = [record.seen.force / seen.seen.most for record in seen.records]
        nuisances = [
            self.alone(at, column)
            for at, (head, force) in enumerate(zip(heads, forces, strict=True))
            for column in (head, 1 - head, force, force * head)
        ]
        columns = np.column_stack(nuisances)
        self.basis = np.linalg.qr(columns / np.linalg.norm(columns, axis=0))[0]

    def alone(self, number: int, column: np.ndarray) -> np.ndarray:
        """A column of one mounting in the metric of the noise."""
        return np.concatenate(
            [weight @ column if at == number else np.zeros(len(weight)) for at, weight in enumerate(self.weights)]
        )

    def beside(self, columns: np.ndarray) -> np.ndarray:
        """What the nuisances leave."""
        return columns - self.basis @ (self.basis.T @ columns)

    def distance(self, name: str, planted: np.ndarray) -> float:
        """How far a cause stays from what is planted, in its best size and shape."""
        candidate, found = self.seen.candidates[name], np.inf
        for shape in shapes(candidate, self.seen):
            parts = [self.alone(at, self.seen.column(name, at, shape)) for at in range(len(self.weights))]
            columns = self.beside(np.column_stack(parts if candidate.size.own else [np.sum(parts, axis=0)]))
            size = np.linalg.norm(columns, axis=0)
            if not size.any():
                continue
            amounts, *_ = np.linalg.lstsq(columns[:, size > 0] / size[size > 0], planted)
            if candidate.size.own or candidate.signed or amounts[0] > 0:
                left = planted - columns[:, size > 0] / size[size > 0] @ amounts
                found = min(found, float(np.linalg.norm(left)))
        return found


def shapes(one: Candidate, seen: Tension) -> list[dict[str, float]]:
    """Shapes of a cause: of one that is sought a dozen over its range, else every place."""
    shape = next((size for size in one.parameters if size.shape), None)
    if shape is None:
        return [{}]
    if not shape.held:
        return [{shape.name: float(value)} for value in np.geomspace(shape.low, shape.high, PLACES)]
    places = seen.seen.places if shape.name.endswith("place") else shape.places
    return [{shape.name: float(place)} for place in places][:: 4 if len(places) > PLACES else 1]


def main() -> None:
    """Print the table."""
    print("| planted, d = 10 | nearest other causes, δ | more probable | 20 to 1 |\n|---|---|---|---|")
    for name in sys.argv[1:] or cases.EFFECTS:
        given, alone, right = cases.EFFECTS[name]
        rng, size = np.random.default_rng(1), next(iter(given))
        base = cases.machine(name, 0)
        machines = [replace(base, EA=2e6 * (1 + 0.004 * rng.normal())) for _ in range(3)]
        known = Known(machines, prepared(machines, rng))
        planted = {**given, size: given[size] * D * cases.factor(name, 0)}
        changes = []
        for at, (one, means) in enumerate(zip(machines, known.means, strict=True)):
            other = replace(one, **planted) if not alone or at == 1 else one
            here, there = (pull(replace(machine, **SILENT), rng) for machine in (one, other))
            lost = there["force"] - here["force"]
            moved = there["crosshead"] - here["crosshead"] - lost * (one.length / one.EA + one.compliance)
            stretched = one.length * (there["strain"] - here["strain"] - lost / one.EA)
            changes.append(known.alone(at, np.concatenate([means @ moved, means @ stretched])))
        change = known.beside(np.sum(changes, axis=0))
        untestable = {*known.seen.reasons(), "setup", "constant setup", "extensometer scale", right}
        untestable |= {"uneven curvature"} if right == "curvature" else set()
        found = {one: known.distance(one, change) for one in known.seen.candidates if one not in untestable}
        nearest = sorted(found.items(), key=lambda one: one[1])[:SHOWN]
        least = max(nearest[0][1], 1e-9)
        words = ", ".join(f"{one} {away:.1f}" for one, away in nearest)
        print(f"| {name} | {words} | {norm.cdf(least / 2):.0%} | {norm.cdf(least / 2 - 3 / least):.0%} |", flush=True)


if __name__ == "__main__":
    main()
