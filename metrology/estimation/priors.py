"""What the lab knows only within an uncertainty, and how it and the free parameters become the unknowns of a fit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.estimation.problem import Array, Unknown
from metrology.message import said
from metrology.rig import Rig

WIDER = 15.0
"""How many of its own standard uncertainties a stated input may be off where that is tried as a cause."""


def input_of(name: str, run: str) -> str:
    """Words for a stated input.

    Parameters
    ----------
    name : str
        Parameter of the rig.
    run : str
        Run of which it is the part of its own; empty for that of all runs.

    Returns
    -------
    str
        Such as "thrust.gain of a1".
    """
    return said("{name} of {run}", name=name, run=run) if run else name


@dataclass(frozen=True)
class Prior:
    """State of knowledge about one parameter of the rig, normal, before the readings are looked at.

    Parameters
    ----------
    name : str
        A parameter of the rig, such as ``'thrust.gain'``, ``'free_length.shift'``, ``'start.x'``.
    common : float
        Standard uncertainty of the part that all runs share, in the unit of the parameter; 0 for none.
    per_run : float
        Standard deviation of the part that differs from run to run; 0 for none.
    mean : float or None
        Best estimate beforehand; the value of the rig unless given.
    source : str
        Where the figures come from.
    """

    name: str
    common: float = 0.0
    per_run: float = 0.0
    mean: float | None = None
    source: str = ""


@dataclass(frozen=True)
class Layout:
    """Which unknown stands for which parameter of which run.

    Parameters
    ----------
    unknowns : tuple of Unknown
        Common ones first, then those of single runs, named ``'thrust.gain@run'``.
    runs : tuple of str
        Names of the runs.
    uses : tuple of tuple of int
        For each run, the unknowns that act on it.
    targets : tuple of tuple of int
        For each of those, the index in `names` of the parameter that it moves; the common ones come first.
    names : tuple of str
        Parameters of the rig that vary.
    offsets : tuple of float
        For each of `names`, what the unknowns add to: 0 where a common unknown is the value itself.
    common : int
        Number of common unknowns.
    factors : tuple of float
        For each of `names` that is a factor, such as a gain, what is stated of it: a run differs from the others by a
        part of that. Were it an amount, all factors that scale the forces would fall together, and take what sets the
        runs apart with them. 0 for any other: what a run has of its own adds to it.
    """

    unknowns: tuple[Unknown, ...]
    runs: tuple[str, ...]
    uses: tuple[tuple[int, ...], ...]
    targets: tuple[tuple[int, ...], ...]
    names: tuple[str, ...]
    offsets: tuple[float, ...]
    common: int
    factors: tuple[float, ...]

    def values(self, at: int, local: Array) -> dict[str, float]:
        """Values of the rig's parameters in run number `at` from the values of its unknowns, shape (len(uses[at]),)."""
        total = self._shared(at, local)
        for target, own in self._own(at, local):
            factor = self.factors[target]
            total[target] = total[target] * (1.0 + own / factor) if factor else total[target] + own
        return {name: float(value) for name, value in zip(self.names, total, strict=True)}

    def moved(self, at: int, local: Array) -> Array:
        """Derivative of the parameter that each of those unknowns moves by it, shape (len(uses[at]),)."""
        shared, found = self._shared(at, local), np.ones(len(local))
        for column, (target, own) in enumerate(self._own(at, local), self.common):
            if factor := self.factors[target]:
                found[column] = shared[target] / factor
                found[: self.common][np.array(self.targets[at][: self.common]) == target] = 1.0 + own / factor
        return found

    def _shared(self, at: int, local: Array) -> Array:
        """Values of the parameters without what the run has of its own."""
        total = np.array(self.offsets)
        np.add.at(total, np.array(self.targets[at][: self.common], dtype=int), local[: self.common])
        return total

    def _own(self, at: int, local: Array) -> Iterator[tuple[int, float]]:
        """Parameters of which the run has a part of its own, by index, and those parts."""
        return zip(self.targets[at][self.common :], local[self.common :].tolist(), strict=True)

    def index(self, name: str) -> int:
        """Place of an unknown."""
        return next(at for at, entry in enumerate(self.unknowns) if entry.name == name)


def lay_out(
    rig: Rig,
    runs: Sequence[str],
    free: Sequence[str],
    priors: Sequence[Prior],
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> Layout:
    """Unknowns of a joint fit: the free parameters, and for every prior a common part and a part per run.

    Parameters
    ----------
    rig : Rig
        As stated: the start of the search.
    runs : sequence of str
        Names of the runs, in order.
    free : sequence of str
        Parameters about which nothing is known but their range.
    priors : sequence of Prior
        Standard uncertainties, common and per run, in the unit of the parameter.
    bounds : mapping of str to (float, float), optional
        Lowest and highest value by parameter, in its unit.

    Returns
    -------
    Layout
        Which unknown moves which parameter in which run.

    Raises
    ------
    MetrologyError
        Unknown or repeated names, uncertainties that are negative or not finite, bounds that exclude the start.
    """
    known = {prior.name: prior for prior in priors}
    bounds = bounds or {}
    _refuse(rig, (runs, free, priors), bounds)
    common = [name for name in dict.fromkeys((*free, *known)) if name in free or known[name].common > 0]
    unknowns = [_common(rig, name, known.get(name), bounds.get(name)) for name in common]
    names = tuple(dict.fromkeys((*common, *(prior.name for prior in priors if prior.per_run > 0))))
    offsets = tuple(0.0 if name in common else _mean(rig, known[name]) for name in names)
    uses, targets = [], []
    for run in runs:
        own = [prior for prior in priors if prior.per_run > 0]
        uses.append((*range(len(common)), *range(len(unknowns), len(unknowns) + len(own))))
        targets.append((*(names.index(name) for name in common), *(names.index(prior.name) for prior in own)))
        unknowns += [_deviation(rig, prior, run) for prior in own]
    factors = tuple(
        _mean(rig, known[name]) if name in known and rig.parameters[name].unit == "1" else 0.0 for name in names
    )
    return Layout(tuple(unknowns), tuple(runs), tuple(uses), tuple(targets), names, offsets, len(common), factors)


def _mean(rig: Rig, prior: Prior) -> float:
    return rig.value(prior.name) if prior.mean is None else prior.mean


def _common(rig: Rig, name: str, prior: Prior | None, bounds: tuple[float, float] | None) -> Unknown:
    entry = rig.parameters[name]
    low, high = bounds or (entry.low, entry.high)
    start = rig.value(name)
    scale = abs(start) if name in ("m", "k") and start else entry.scale
    if prior is None or prior.common <= 0:
        return Unknown(name, start, scale, low, high, unit=entry.unit)
    mean = _mean(rig, prior)
    return Unknown(name, float(np.clip(mean, low, high)), prior.common, low, high, mean, prior.common, entry.unit)


def _deviation(rig: Rig, prior: Prior, run: str) -> Unknown:
    unit = rig.parameters[prior.name].unit
    return Unknown(f"{prior.name}@{run}", 0.0, prior.per_run, mean=0.0, u=prior.per_run, unit=unit)


def _refuse(
    rig: Rig,
    given: tuple[Sequence[str], Sequence[str], Sequence[Prior]],
    bounds: Mapping[str, tuple[float, float]],
) -> None:
    runs, free, priors = given
    names = [*free, *(prior.name for prior in priors), *bounds]
    expected = "the name of a parameter of the rig, such as 'k' or 'thrust.gain'"
    faults = [Fault("identify", f"'{name}'", expected) for name in dict.fromkeys(names) if name not in rig.parameters]
    for label, entries in (("runs", runs), ("free", free), ("priors", [prior.name for prior in priors])):
        twice = sorted({name for name in entries if list(entries).count(name) > 1})
        faults += [Fault(f"identify.{label}", f"'{name}' twice", "every name once") for name in twice]
    for prior in priors:
        numbers = (prior.common, prior.per_run)
        if not all(math.isfinite(u) and u >= 0 for u in numbers) or not any(numbers):
            faults.append(Fault(f"prior '{prior.name}'", f"u = {numbers}", "a positive common or per-run uncertainty"))
    if faults:
        raise MetrologyError(*faults)
    for name, (low, high) in bounds.items():
        if not low <= rig.value(name) <= high:
            faults.append(Fault(f"bounds '{name}'", f"{low:g} to {high:g}", f"the start {rig.value(name):g} inside"))
    if faults:
        raise MetrologyError(*faults)
