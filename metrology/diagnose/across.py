"""Results of one quantity by several tests that disagree: which single effect would explain all of them at once.

Each candidate adds one parameter to "all results of a sample are one value, within their joint covariance". Its
probability is the evidence with the parameter integrated over its prior, exactly but for a quadrature in one variable
(MacKay 2003, ch. 28).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from math import exp, log, sqrt

import numpy as np

from metrology.consensus import Candidate, Disagreement

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

SHARE = (1e-3, 0.5)
"""Relative size of a scatter between the tests, and C·k of the stiffest sample on a set-up: from what no laboratory test
of a line sees to what would halve a result. ln of the size is even between the two, as nobody knows its order."""
OFF = (1e-3, 1.0)
"""Size of ln of the ratio of a wrong result and the right one, of what an instrument shows and should, and of a sample
before and after, of either sign."""
RELAXING = (1e-3, 0.1)
"""−d ln k/d ln t: tan δ ≈ π/2 times that (Ferry 1980, ch. 3), 0.0016 of metals to 0.16 of polymers."""
HYSTERETIC = (0.05, 1.0)
"""d ln c/d ln t: 1 where the loss of energy in a cycle does not depend on frequency (structural damping)."""
NAMED = 0.95
"""Probability from which on a candidate is named."""
LEFT = 0.05
"""Probability up to which a candidate is not mentioned as possible."""
MISFIT = 0.01
"""p of the χ² that a candidate leaves, below which it does not explain all results at once."""
FINE = 201
"""Values of a parameter over its prior, and as many over its peak."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Results of one quantity, of samples of which each has two or more.

    Parameters
    ----------
    tests, samples : sequence of str, length n
        Where each comes from.
    values : ndarray, shape (n,)
        Above zero, in SI.
    covariance : ndarray, shape (n, n)
        Of ln of the values.
    seconds : ndarray, shape (n,)
        Time in which the sample answers in each test; NaN where it is not known.
    rigs : sequence of str, length n
        What bears the sample, alike where tests share it; empty where its compliance does not act on the result.
    instruments : sequence of sequence of str, length n
        Instruments of each test.
    days : sequence of int, length n
        Day of each test; 0 where it is not known.
    stiffness : ndarray, shape (n,)
        k / (N/m) of the sample in each test; NaN where it is not known.
    damping : bool
        Whether the quantity is c.
    """

    tests: tuple[str, ...]
    samples: tuple[str, ...]
    values: Floats
    covariance: Floats
    seconds: Floats
    rigs: tuple[str, ...]
    instruments: tuple[tuple[str, ...], ...]
    days: tuple[int, ...]
    stiffness: Floats
    damping: bool = False

    @cached_property
    def contrasts(self) -> Floats:
        """Orthonormal contrasts within the samples, shape (n, n − samples): blind to the value of each sample."""
        of = np.array([[one == sample for sample in dict.fromkeys(self.samples)] for one in self.samples], float)
        return np.asarray(np.linalg.svd(of)[0][:, of.shape[1] :])

    @cached_property
    def whitened(self) -> Floats:
        """W with W·ln y white and of unit variance where nothing is wrong, shape (n − samples, n)."""
        factor = np.linalg.cholesky(self.contrasts.T @ self.covariance @ self.contrasts)
        return np.asarray(np.linalg.solve(factor, self.contrasts.T))

    @property
    def seen(self) -> Floats:
        """W·ln y."""
        return self.whitened @ np.log(self.values)


@dataclass(frozen=True, eq=False)
class Effect:
    """A candidate: what it adds to ln of each result, shape (n,), as a function of its size; `signs`: −1, 1 or both."""

    kind: str
    title: str
    parameter: str
    unit: str
    add: Callable[[float], Floats]
    limits: tuple[float, float]
    signs: tuple[int, ...] = (1,)
    scale: float = 1.0


def explain(rows: Rows, quantity: str) -> Disagreement:
    """Which single effect explains why the results of one or more samples disagree.

    Kinds of candidates are as probable as one another beforehand, and so are those of one kind: chance, a scatter
    between the tests, the compliance of a set-up that several tests share, an instrument that they share, a dependence on
    time, one result that is off, and a sample that changed between two days. What acts on one result alone (its own set-up, a slip in its units, a
    sample that was damaged before the last test) is "one result off": these results do not distinguish it.

    Parameters
    ----------
    rows : Rows
    quantity : str
        Its symbol.
    """
    effects = [*_setups(rows), *_instruments(rows), *_rates(rows), *_tests(rows), *_changes(rows)]
    found = [_chance(rows), _scatter(rows), *(_judged(rows, one) for one in effects)]
    kinds = [one.kind for one, _ in found]
    logs = np.array([evidence - log(kinds.count(one.kind)) for one, evidence in found])
    posterior = np.exp(logs - logs.max())
    posterior /= posterior.sum()
    against = found[1][1]
    candidates = sorted(
        (
            Candidate(one.kind, one.title, float(p), evidence - against, one.parameter, one.value, one.u, one.unit,
                      one.p_value)
            for (one, evidence), p in zip(found, posterior, strict=True)
        ),
        key=lambda one: -one.probability,
    )  # fmt: skip
    verdict, sentence = _verdict(rows, candidates)
    return Disagreement(quantity, tuple(dict.fromkeys(rows.samples)), verdict, sentence, tuple(candidates))


def _verdict(rows: Rows, candidates: list[Candidate]) -> tuple[str, str]:
    freedom = len(rows.tests) - len(set(rows.samples))
    causes = [one for one in candidates if one.kind not in ("chance", "scatter")]
    none = sum(one.probability for one in candidates if one.kind in ("chance", "scatter"))
    fitting = [one for one in causes if one.p_value is None or one.p_value >= MISFIT]
    if freedom < 2:
        titles = _listed([one.title for one in causes if one.probability > LEFT])
        return "ambiguous", (
            "Two results of one sample differ, and any cause that acts on one of them more than on the other fits: these "
            f"results cannot decide. Possible by size and sign: {titles}. A third test would distinguish them."
        )
    if fitting and fitting[0].probability >= NAMED:
        best = fitting[0]
        return "explained", f"One effect explains all results at once: {best.title} ({_size(best)})."
    if none >= NAMED or not fitting or sum(one.probability for one in fitting) < LEFT:
        return "not explained", (
            "No single effect of those that were tried explains all results at once; the consensus takes their "
            "difference as scatter between the methods."
        )
    titles = _listed([one.title for one in fitting if one.probability > LEFT])
    also = "" if none < LEFT else f"; that no single effect does has the probability {none:.2g}"
    return "ambiguous", f"These results do not decide between: {titles}{also}."


def _listed(titles: list[str]) -> str:
    return "; ".join(titles) or "none of those that were tried"


def _size(one: Candidate) -> str:
    unit = "" if one.unit == "1" else f" {one.unit}"
    assert one.value is not None
    assert one.u is not None
    return f"{one.parameter} = {one.value:.2g} ± {one.u:.1g}{unit}"


@dataclass(frozen=True)
class _Found:
    kind: str
    title: str
    parameter: str = ""
    value: float | None = None
    u: float | None = None
    unit: str = "1"
    p_value: float | None = None


def _chance(rows: Rows) -> tuple[_Found, float]:
    from scipy.special import chdtrc

    statistic = float(rows.seen @ rows.seen)
    return _Found("chance", "chance alone", p_value=float(chdtrc(rows.seen.size, statistic))), -0.5 * statistic


def _scatter(rows: Rows) -> tuple[_Found, float]:
    """Each result by itself off by a normal deviation of standard deviation τ."""
    seen, W = rows.seen, rows.whitened
    sizes = np.geomspace(*SHARE, FINE)
    axes = np.linalg.eigh(W @ W.T)
    along = (axes.eigenvectors.T @ seen) ** 2
    spread = 1 + sizes[:, None] ** 2 * axes.eigenvalues
    logs = -0.5 * (along / spread + np.log(spread)).sum(axis=1)
    evidence, mean, u = _integrated(np.log(sizes), logs, sizes)
    return _Found("scatter", "scatter between the tests, of no single cause", "τ", mean, u), evidence


def _judged(rows: Rows, effect: Effect) -> tuple[_Found, float]:
    """Evidence, size and what is left; of either sign both are integrated, each as probable as the other."""
    from scipy.special import chdtrc

    seen, W = rows.seen, rows.whitened
    parts = []
    for sign in effect.signs:
        sizes = _grid(lambda size, sign=sign: seen - W @ effect.add(sign * size), effect.limits)
        left = np.array([float(((seen - W @ effect.add(sign * size)) ** 2).sum()) for size in sizes])
        parts.append((*_integrated(np.log(sizes), -0.5 * left, sign * sizes), float(left.min())))
    logs = np.array([part[0] for part in parts])
    best = parts[int(logs.argmax())]
    evidence = float(np.logaddexp.reduce(logs)) - log(len(parts))
    freedom = seen.size - 1
    p_value = float(chdtrc(freedom, best[3])) if freedom else None
    value, u = best[1] * effect.scale, best[2] * effect.scale
    return _Found(effect.kind, effect.title, effect.parameter, value, u, effect.unit, p_value), evidence


def _grid(left: Callable[[float], Floats], limits: tuple[float, float]) -> Floats:
    """Sizes over the prior, dense about the least of |left|²: within ten standard deviations of its parabola."""
    coarse = np.geomspace(*limits, FINE)
    at = coarse[int(np.argmin([float(left(size) @ left(size)) for size in coarse]))]
    for _ in range(20):
        here, step = left(at), 1e-4 * at
        slope = (left(at + step) - here) / step
        at = float(np.clip(at - (slope @ here) / (slope @ slope), *limits))
    sd = 1 / sqrt(float(slope @ slope))
    fine = at + sd * np.linspace(-10, 10, FINE)
    return np.unique(np.concatenate([coarse, fine[(fine > limits[0]) & (fine < limits[1])]]))


def _integrated(at: Floats, logs: Floats, sizes: Floats) -> tuple[float, float, float]:
    """ln of the mean likelihood over a prior that is even in `at`; mean and standard deviation of the size."""
    top = float(logs.max())
    weights = np.exp(logs - top)
    total = float(np.trapezoid(weights, at))
    mean = float(np.trapezoid(weights * sizes, at)) / total
    variance = float(np.trapezoid(weights * (sizes - mean) ** 2, at)) / total
    return top + log(total / float(at[-1] - at[0])), mean, sqrt(variance)


# ---- the candidates -----------------------------------------------------------------------------------------------
def _setups(rows: Rows) -> Iterator[Effect]:
    """k/(1 + C·k), and c/(1 + C·k)², by each set-up that two tests or more share (ASTM E111-17, 9)."""
    power = 2 if rows.damping else 1
    for rig in dict.fromkeys(filter(None, rows.rigs)):
        on = np.array([one == rig for one in rows.rigs])
        k = _stiffness(rows, on)
        if not _acts(rows, on) or not np.isfinite(k[on]).all():
            continue
        most = float(k[on].max())
        share = np.where(on, k / most, 0.0)
        title = f"compliance of the set-up that {_those(rows, on)} share"
        yield Effect(
            "set-up", title, "C", "m/N", lambda size, share=share: -power * np.log1p(size * share), SHARE,
            scale=1 / most,
        )  # fmt: skip


def _acts(rows: Rows, on: Mask) -> bool:
    """Whether what acts on these results alike is seen, and is more than one of them alone."""
    return bool(on.sum() > 1 and np.abs(rows.contrasts.T @ on.astype(float)).max() > 1e-9)


def _those(rows: Rows, on: Mask) -> str:
    return ", ".join(test for test, here in zip(rows.tests, on, strict=True) if here)


def _instruments(rows: Rows) -> Iterator[Effect]:
    """A scale that is off by more than is stated of it; instruments that the same tests used are one candidate."""
    used: dict[tuple[bool, ...], list[str]] = {}
    for name in dict.fromkeys(name for those in rows.instruments for name in those):
        used.setdefault(tuple(name in those for those in rows.instruments), []).append(name)
    for here, names in used.items():
        on = np.array(here)
        if _acts(rows, on):
            title = f"{' or '.join(names)} off in {_those(rows, on)}"
            yield Effect("instrument", title, "ln ratio", "1", lambda size, on=on: size * on, OFF, (-1, 1))


def _stiffness(rows: Rows, on: Mask) -> Floats:
    """k of the sample of each result: the mean over its tests on other set-ups, where there are any."""
    found = rows.stiffness.copy()
    for sample in set(rows.samples):
        of = np.array([one == sample for one in rows.samples])
        others = rows.stiffness[of & ~on & np.isfinite(rows.stiffness)]
        if others.size:
            found[of] = exp(float(np.log(others).mean()))
    return found


def _rates(rows: Rows) -> Iterator[Effect]:
    """k ∝ t^(−α), and c ∝ t^α: of one sample, and where there are several of all alike."""
    names = list(dict.fromkeys(rows.samples))
    for chosen in [[name] for name in names] + ([names] if len(names) > 1 else []):
        of = np.array([one in chosen for one in rows.samples])
        times = np.where(of, np.log(rows.seconds), 0.0)
        if not np.isfinite(times).all() or not np.abs(rows.contrasts.T @ times).max() > 1e-9:
            continue
        whom = "all samples alike" if len(chosen) > 1 else chosen[0]
        word = "damping that falls with frequency" if rows.damping else "stiffness that grows with the rate"
        sign, limits = (1, HYSTERETIC) if rows.damping else (-1, RELAXING)
        yield Effect(
            "rate", f"{word}, of {whom}", "α", "1", lambda size, times=times, sign=sign: sign * size * times, limits
        )


def _tests(rows: Rows) -> Iterator[Effect]:
    """One result off by itself."""
    for at, test in enumerate(rows.tests):
        alone = np.eye(len(rows.tests))[at]
        yield Effect(
            "one test", f"{test} alone is off", "ln ratio", "1", lambda size, alone=alone: size * alone, OFF, (-1, 1)
        )


def _changes(rows: Rows) -> Iterator[Effect]:
    """A sample that changed between two days, with two results or more before and after."""
    for sample in dict.fromkeys(rows.samples):
        of = np.array([one == sample for one in rows.samples])
        days = np.array(rows.days)
        if (days[of] == 0).any():
            continue
        for day in np.unique(days[of])[1:]:
            after = of & (days >= day)
            if after.sum() < 2 or (of & ~after).sum() < 2:
                continue
            yield Effect(
                "sample changed", f"{sample} changed before {_those(rows, after)}", "ln ratio", "1",
                lambda size, after=after: size * after, OFF, (-1, 1),
            )  # fmt: skip
