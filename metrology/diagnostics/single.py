"""Results of one quantity by several tests, and the single effects that could make them disagree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import exp

import numpy as np

from metrology.message import said

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

SHARE = (1e-3, 0.5)
"""Relative size of a scatter between the tests, and C·k of the stiffest sample on a set-up: from what no test of a line
sees to what would halve a result. ln of the size is even between the two, as nobody knows its order."""
OFF = (1e-3, 1.0)
"""Size of ln of the ratio of a wrong result and the right one, of what an instrument shows and should, and of a sample
before and after, of either sign."""
RELAXING = (1e-3, 0.1)
"""−d ln k/d ln t: tan δ ≈ π/2 times that (Ferry 1980, ch. 3), 0.0016 of metals to 0.16 of polymers."""
HYSTERETIC = (0.05, 1.0)
"""d ln c/d ln t: 1 where the loss of energy in a cycle does not depend on frequency (structural damping)."""


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
        """W with W·ln y white and of unit variance where nothing is wrong, shape (at most n − samples, n).

        Differences that have no uncertainty, since all of it is shared, are left out.
        """
        variances, axes = np.linalg.eigh(self.contrasts.T @ self.covariance @ self.contrasts)
        known = variances > 1e-12 * variances[-1]
        return np.asarray((axes[:, known] / np.sqrt(variances[known])).T @ self.contrasts.T)

    @property
    def seen(self) -> Floats:
        """W·ln y."""
        return self.whitened @ np.log(self.values)


@dataclass(frozen=True, eq=False)
class Effect:
    """A candidate: what it adds to ln of each result, by its one size.

    Parameters
    ----------
    kind, title, parameter, unit : str
        Kind, in words, symbol of the size that is reported, and its SI unit.
    direction : ndarray, shape (n,)
        What a size of 1 adds; of a compliance, C·k of each result over that of the stiffest.
    limits : tuple of float
        Of |size|.
    signs : tuple of int
        −1, 1 or both.
    power : int
        Power of 1/(1 + C·k) in the result; 0: not a compliance.
    scale : float
        Reported size for a size of 1.
    """

    kind: str
    title: str
    parameter: str
    unit: str
    direction: Floats
    limits: tuple[float, float]
    signs: tuple[int, ...] = (1,)
    power: int = 0
    scale: float = 1.0

    def add(self, size: float) -> Floats:
        """What it adds to ln of each result, shape (n,)."""
        return -self.power * np.log1p(size * self.direction) if self.power else size * self.direction


def effects(rows: Rows) -> Iterator[Effect]:
    """Every candidate that acts on these results; what acts on one alone is `one test`."""
    yield from _setups(rows)
    yield from _instruments(rows)
    yield from _rates(rows)
    yield from _tests(rows)
    yield from _changes(rows)


def _setups(rows: Rows) -> Iterator[Effect]:
    """k/(1 + C·k), and c/(1 + C·k)², by each set-up that two tests or more share (ASTM E111-17, 9)."""
    for rig in dict.fromkeys(filter(None, rows.rigs)):
        on = np.array([one == rig for one in rows.rigs])
        k = _stiffness(rows, on)
        if not _acts(rows, on) or not np.isfinite(k[on]).all():
            continue
        most = float(k[on].max())
        share = np.where(on, k / most, 0.0)
        title = said("compliance of the set-up that {tests:comma} share", tests=_those(rows, on))
        power = 2 if rows.damping else 1
        yield Effect("set-up", title, "C", "m/N", share, SHARE, power=power, scale=1 / most)


def _acts(rows: Rows, on: Mask) -> bool:
    """Whether what acts on these results alike is seen, and is more than one of them alone."""
    return bool(on.sum() > 1 and np.abs(rows.contrasts.T @ on.astype(float)).max() > 1e-9)


def _those(rows: Rows, on: Mask) -> tuple[str, ...]:
    return tuple(test for test, here in zip(rows.tests, on, strict=True) if here)


def _instruments(rows: Rows) -> Iterator[Effect]:
    """A scale that is off by more than is stated of it; instruments that the same tests used are one candidate."""
    used: dict[tuple[bool, ...], list[str]] = {}
    for name in dict.fromkeys(name for those in rows.instruments for name in those):
        used.setdefault(tuple(name in those for those in rows.instruments), []).append(name)
    for here, names in used.items():
        on = np.array(here)
        if _acts(rows, on):
            title = said("{names:or} off in {tests:comma}", names=tuple(names), tests=_those(rows, on))
            yield Effect("instrument", title, "ln ratio", "1", on.astype(float), OFF, (-1, 1))


def _stiffness(rows: Rows, on: Mask) -> Floats:
    """K of the sample of each result: the mean over its tests on other set-ups, where there are any."""
    found = rows.stiffness.copy()
    for sample in set(rows.samples):
        of = np.array([one == sample for one in rows.samples])
        others = rows.stiffness[of & ~on & np.isfinite(rows.stiffness)]
        if others.size:
            found[of] = exp(float(np.log(others).mean()))
    return found


def _rates(rows: Rows) -> Iterator[Effect]:
    """K ∝ t^(−α), and c ∝ t^α: of one sample, and where there are several of all alike."""
    names = list(dict.fromkeys(rows.samples))
    for chosen in [[name] for name in names] + ([names] if len(names) > 1 else []):
        of = np.array([one in chosen for one in rows.samples])
        times = np.where(of, np.log(rows.seconds), 0.0)
        if not np.isfinite(times).all() or not np.abs(rows.contrasts.T @ times).max() > 1e-9:
            continue
        whom = said("all samples alike") if len(chosen) > 1 else chosen[0]
        damping, stiffness = (
            "damping that falls with frequency, of {whom}",
            "stiffness that grows with the rate, of {whom}",
        )
        sign, limits = (1, HYSTERETIC) if rows.damping else (-1, RELAXING)
        yield Effect("rate", said(damping if rows.damping else stiffness, whom=whom), "α", "1", sign * times, limits)


def _tests(rows: Rows) -> Iterator[Effect]:
    """One result off by itself."""
    for at, test in enumerate(rows.tests):
        alone = np.eye(len(rows.tests))[at]
        yield Effect("one test", said("{test} alone is off", test=test), "ln ratio", "1", alone, OFF, (-1, 1))


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
            title = said("{sample} changed before {tests:comma}", sample=sample, tests=_those(rows, after))
            yield Effect("sample changed", title, "ln ratio", "1", after.astype(float), OFF, (-1, 1))
