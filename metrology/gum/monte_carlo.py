"""Monte Carlo propagation of distributions with the adaptive procedure (JCGM 101:2008, 7.9).

Trials run in blocks. Block number i draws from a generator of its own, made from the seed and i, so that results are
the same bits whatever the number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import ceil, inf
from typing import Any

import numpy as np

from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Floats
from metrology.gum.intervals import intervals
from metrology.gum.sampling import Sampler

BLOCK = 10_000
FIRST_BLOCKS = 10
MEAN, DEVIATION, LOW, HIGH, SHORTEST_LOW, SHORTEST_HIGH = range(6)


@dataclass(frozen=True)
class Plan:
    """How to run the trials.

    Parameters
    ----------
    probability : float
        Coverage probability p of the intervals.
    seed : int
        Determines every draw.
    digits : int
        Significant digits of u that the results are to carry (7.9.2).
    max_trials : int
        Trials after which the adaptive procedure gives up.
    threads : int, optional
        Number of threads; as many as there are processors, up to four, when left out.
    adaptive : bool
        Stop as soon as there are trials enough (7.9); otherwise make all `max_trials`.
    least_trials : int
        Trials to make in any case, as far as `max_trials` allows.
    """

    probability: float
    seed: int
    digits: int = 2
    max_trials: int = 1_000_000
    threads: int | None = None
    adaptive: bool = True
    least_trials: int = 0

    @property
    def block(self) -> int:
        """Trials in a block, max(J, 10⁴) with J ≥ 100/(1 − p), or a tenth of the trials allowed (7.9.4 b)."""
        wanted = max(ceil(100 / (1 - self.probability) - 1e-9), BLOCK)
        return min(wanted, max(self.max_trials // FIRST_BLOCKS, 1))

    @property
    def most_blocks(self) -> int:
        """Blocks that the trials allowed make."""
        return self.max_trials // self.block

    @property
    def first_blocks(self) -> int:
        """Blocks to begin with."""
        if not self.adaptive:
            return self.most_blocks
        return min(max(FIRST_BLOCKS, ceil(self.least_trials / self.block)), self.most_blocks)


def sufficient(probability: float) -> int:
    """Trials that give a 100p % interval to one or two digits, 10⁴/(1 − p): the most where each trial is a fit.

    Parameters
    ----------
    probability : float
        Coverage probability p, below 1.

    Returns
    -------
    int
        Number of trials.

    Notes
    -----
    JCGM 101:2008 7.2.2.

    Examples
    --------
    >>> sufficient(0.95)
    200000
    """
    return ceil(1e4 / (1 - probability) - 1e-6)


@dataclass
class Trials:
    """Outputs of the trials made so far.

    `outputs` has shape (measurands, trials); `batches` (blocks, measurands, 6) holds mean, standard deviation and both
    ends of the symmetric and of the shortest interval of each block; `invalid` counts the trials without a finite
    number, by measurand.
    """

    outputs: Floats
    batches: Floats
    invalid: list[int]

    @property
    def number(self) -> int:
        """Trials made."""
        return int(self.outputs.shape[1])


def run(measurands: Sequence[Measurand], sampler: Sampler, plan: Plan, enough: Callable[[Trials], float]) -> Trials:
    """Make trials until there are enough of them for every output, or as many as are allowed.

    Parameters
    ----------
    measurands : sequence of Measurand
        In order of use.
    sampler : Sampler
        Draws of the inputs.
    plan : Plan
        Seed, probability, digits, most trials.
    enough : callable
        Takes the trials made so far and returns the factor by which their number falls short, at most 1 when done.

    Returns
    -------
    Trials
        Draws of every measurand, shape (measurands, trials), in SI, and their batches.

    Notes
    -----
    JCGM 101:2008 7.9.4.
    """
    shape = len(measurands)
    trials = Trials(np.empty((shape, 0)), np.empty((0, shape, 6)), [0] * shape)
    blocks = plan.first_blocks
    threads = plan.threads or min(os.cpu_count() or 1, 4)
    with ThreadPoolExecutor(threads) as pool:
        while True:
            _extend(trials, measurands, sampler, plan, blocks, pool, threads)
            if blocks >= plan.most_blocks:
                return trials
            short = enough(trials) if plan.adaptive else inf
            if short <= 1.0:
                return trials
            blocks = int(min(max(ceil(blocks * min(short, 1e6) * 1.05), blocks + 2), plan.most_blocks))


def _extend(
    trials: Trials,
    measurands: Sequence[Measurand],
    sampler: Sampler,
    plan: Plan,
    blocks: int,
    pool: ThreadPoolExecutor,
    threads: int,
) -> None:
    done, size = trials.batches.shape[0], plan.block
    outputs = np.empty((len(measurands), blocks * size))
    outputs[:, : trials.number] = trials.outputs
    batches = np.empty((blocks, len(measurands), 6))
    batches[:done] = trials.batches

    def work(first: int) -> Floats:
        invalid = np.zeros(len(measurands))
        for index in range(first, blocks, threads):
            generator = np.random.Generator(np.random.SFC64(np.random.SeedSequence(plan.seed, spawn_key=(index,))))
            own = outputs[:, index * size : (index + 1) * size]
            with np.errstate(all="ignore"):
                _evaluate(measurands, sampler.draw(generator, size), own)
                invalid += [_summarise(row, plan.probability, batches[index, i]) for i, row in enumerate(own)]
        return invalid

    # One task for each thread: handing over block by block took a quarter of the time.
    counts = list(pool.map(work, range(done, done + threads)))
    invalid = [before + int(more) for before, more in zip(trials.invalid, np.sum(counts, axis=0), strict=True)]
    trials.outputs, trials.batches, trials.invalid = outputs, batches, invalid


def _evaluate(measurands: Sequence[Measurand], quantities: dict[str, Any], outputs: Floats) -> None:
    """Evaluate the measurands for one block of draws, each reading those before it; NaN where one has no value."""
    for row, measurand in enumerate(measurands):
        try:
            outputs[row] = measurand.function(quantities)
        except (ArithmeticError, ValueError):
            outputs[row] = np.nan
        quantities[measurand.name] = outputs[row]


def _summarise(values: Floats, probability: float, batch: Floats) -> int:
    """Enter mean, deviation and intervals of a block's draws into `batch`; the number of draws that are no number."""
    batch[MEAN] = values.mean()
    if not np.isfinite(batch[MEAN]):
        batch[:] = np.nan
        return int(values.size - np.isfinite(values).sum())
    centred = values - batch[MEAN]
    batch[DEVIATION] = np.sqrt(centred @ centred / (values.size - 1))
    np.copyto(centred, values)
    found = intervals(centred, probability)
    batch[LOW:] = found.low, found.high, found.shortest_low, found.shortest_high
    return 0


def moments(batches: Floats, size: int) -> tuple[float, float]:
    """Mean and standard deviation of all draws of one output, from those of its blocks (7.6)."""
    means, deviations = batches[:, MEAN], batches[:, DEVIATION]
    mean = float(means[0] + (means - means[0]).mean())
    squares = (size - 1) * float((deviations**2).sum()) + size * float(((means - mean) ** 2).sum())
    return mean, float(np.sqrt(squares / (size * len(batches) - 1)))


def scatter(batches: Floats) -> Floats:
    """Twice the standard deviations of the averages over the blocks, one a column: 2s of 7.9.4 g to j."""
    return np.asarray(2 * batches.std(axis=0, ddof=1) / np.sqrt(len(batches)))


def histogram(values: Floats, probability: float, bins: int = 100) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Edges and probability density of up to 10⁵ draws, without the outermost tails; no bins when all are equal."""
    sample = np.sort(values[:100_000])
    cut = int(min(0.001, (1 - probability) / 10) * sample.size)
    low, high = float(sample[cut]), float(sample[-1 - cut])
    edges = np.linspace(low, high, bins + 1)
    if not (np.diff(edges) > 0).all():
        return (low,), ()
    counts = np.diff(np.searchsorted(sample, edges))
    density = counts / (sample.size * np.diff(edges))
    return tuple(edges.tolist()), tuple(density.tolist())
