"""Results of one quantity by several tests that disagree: which single effect would explain all of them at once.

Each candidate adds one parameter to "all results of a sample are one value, within their joint covariance". Its
probability is the evidence with the parameter integrated over its prior, exactly but for a quadrature in one variable
(MacKay 2003, ch. 28).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, sqrt

import numpy as np

from metrology.consensus import Candidate, Disagreement, Verdict
from metrology.diagnostics.single import SHARE, Effect, Floats, Rows, effects
from metrology.gum.rounding import significant
from metrology.message import said

NAMED = 0.95
"""Probability from which on a candidate is named."""
LEFT = 0.05
"""Probability up to which a candidate is not mentioned as possible."""
MISFIT = 0.01
"""p of the χ² that a candidate leaves, below which it does not explain all results at once."""
FINE = 201
"""Values of a parameter over its prior, and as many over its peak."""


def explain(rows: Rows, quantity: str) -> Disagreement:
    """Which single effect explains why the results of one or more samples disagree.

    Kinds of candidates are as probable as one another beforehand, and so are those of one kind: chance, a scatter
    between the tests, the compliance of a set-up that several tests share, an instrument that they share, a dependence
    on time, one result that is off, and a sample that changed between two days. What acts on one result alone (its own
    set-up, a slip in its units, a sample that was damaged before the last test) is "one result off": these results do
    not distinguish it.

    Parameters
    ----------
    rows : Rows
    quantity : str
        Its symbol.
    """
    found = [_chance(rows), _scatter(rows), *(_judged(rows, one) for one in effects(rows))]
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


def _verdict(rows: Rows, candidates: list[Candidate]) -> tuple[Verdict, str]:
    freedom = len(rows.tests) - len(set(rows.samples))
    causes = [one for one in candidates if one.kind not in ("chance", "scatter")]
    none = sum(one.probability for one in candidates if one.kind in ("chance", "scatter"))
    fitting = [one for one in causes if one.p_value is None or one.p_value >= MISFIT]
    if freedom < 2:
        text = (
            "Two results of one sample differ, and any cause that acts on one of them more than on the other fits: "
            "these results cannot decide. Possible by size and sign: {titles}. A third test would distinguish them."
        )
        return "ambiguous", said(text, titles=_listed(causes))
    if fitting and fitting[0].probability >= NAMED:
        best = fitting[0]
        text = "One effect explains all results at once: {title} ({size:figures})."
        return "explained", said(text, title=best.title, size=_size(best))
    if none >= NAMED or not fitting or sum(one.probability for one in fitting) < LEFT:
        return "not explained", said(
            "No single effect of those that were tried explains all results at once; the consensus takes their "
            "difference as scatter between the methods."
        )
    if none < LEFT:
        return "ambiguous", said("These results do not decide between: {titles}.", titles=_listed(fitting))
    text = "These results do not decide between: {titles}; that no single effect does has the probability {none:.2g}."
    return "ambiguous", said(text, titles=_listed(fitting), none=float(none))


def _listed(candidates: list[Candidate]) -> tuple[str, ...]:
    titles = tuple(one.title for one in candidates if one.probability > LEFT)
    return titles or (said("none of those that were tried"),)


def _size(one: Candidate) -> str:
    assert one.value is not None
    assert one.u is not None
    factor, unit = (1e6, " µm/N") if one.unit == "m/N" else (1.0, "")
    value, u = significant(factor * one.value, factor * one.u)
    return f"{one.parameter} = {value} ± {u}{unit}"


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
    return _Found("chance", said("chance alone"), p_value=float(chdtrc(rows.seen.size, statistic))), -0.5 * statistic


def _scatter(rows: Rows) -> tuple[_Found, float]:
    """Each result by itself off by a normal deviation of standard deviation τ."""
    seen, W = rows.seen, rows.whitened
    sizes = np.geomspace(*SHARE, FINE)
    axes = np.linalg.eigh(W @ W.T)
    along = (axes.eigenvectors.T @ seen) ** 2
    spread = 1 + sizes[:, None] ** 2 * axes.eigenvalues
    logs = -0.5 * (along / spread + np.log(spread)).sum(axis=1)
    evidence, mean, u = _integrated(np.log(sizes), logs, sizes)
    return _Found("scatter", said("scatter between the tests, of no single cause"), "τ", mean, u), evidence


@dataclass(frozen=True, eq=False)
class _Left:
    """What an effect of a size leaves of the whitened results."""

    seen: Floats
    W: Floats
    effect: Effect
    sign: int

    def __call__(self, size: float) -> Floats:
        return self.seen - self.W @ self.effect.add(self.sign * size)


def _judged(rows: Rows, effect: Effect) -> tuple[_Found, float]:
    """Evidence, size and what is left; of either sign both are integrated, each as probable as the other."""
    from scipy.special import chdtrc

    seen, W = rows.seen, rows.whitened
    parts = []
    for sign in effect.signs:
        left = _Left(seen, W, effect, sign)
        sizes = _grid(left, effect.limits)
        squares = np.array([float(left(size) @ left(size)) for size in sizes])
        parts.append((*_integrated(np.log(sizes), -0.5 * squares, sign * sizes), float(squares.min())))
    logs = np.array([part[0] for part in parts])
    best = parts[int(logs.argmax())]
    evidence = float(np.logaddexp.reduce(logs)) - log(len(parts))
    freedom = seen.size - 1
    p_value = float(chdtrc(freedom, best[3])) if freedom else None
    value, u = best[1] * effect.scale, best[2] * effect.scale
    return _Found(effect.kind, effect.title, effect.parameter, value, u, effect.unit, p_value), evidence


def _grid(left: _Left, limits: tuple[float, float]) -> Floats:
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
    """Ln of the mean likelihood over a prior that is even in `at`; mean and standard deviation of the size."""
    top = float(logs.max())
    weights = np.exp(logs - top)
    total = float(np.trapezoid(weights, at))
    mean = float(np.trapezoid(weights * sizes, at)) / total
    variance = float(np.trapezoid(weights * (sizes - mean) ** 2, at)) / total
    return top + log(total / float(at[-1] - at[0])), mean, sqrt(variance)
