"""A run on the rig: how it starts, what drives it, when it is sampled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from metrology.errors import Fault, MetrologyError

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
_Any = TypeVar("_Any", bound=NDArray[Any])

STRETCH = 16
"""Fewest steps of an even stretch: those of fewer, as of the three nodes of a mean, take 7 to 40 times as long with a
table of their own as between even nodes. A linear motion gains from some 250 steps on."""


def frozen(array: _Any) -> _Any:
    """Return the array, from now on read-only."""
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Force:
    """The thrust over time.

    Parameters
    ----------
    t : array_like, shape (n,)
        Times in s, increasing.
    values : array_like, shape (n,)
        Force in N (torque in N·m for an angle). Constant: the value from that time on, zero before the first. Linear:
        the measured force at that time, straight lines between; it has to cover the run.
    kind : {'constant', 'linear'}
        A commanded profile or a measured column.

    Examples
    --------
    >>> Force.impulse(0.38, start=1.0, stop=4.0).values.tolist()
    [0.38, 0.0]
    """

    t: Array
    values: Array
    kind: Literal["constant", "linear"] = "constant"

    def __post_init__(self) -> None:
        faults = _freeze(self, "force", ("t", "values"))
        if self.kind not in ("constant", "linear"):
            faults.append(Fault("force.kind", repr(self.kind), "'constant' or 'linear'"))
        if len(self.t) != len(self.values):
            faults.append(Fault("force.values", f"{len(self.values)} values", f"{len(self.t)}, one for each time"))
        faults += _unordered("force.t", self.t)
        if faults:
            raise MetrologyError(*faults)

    @classmethod
    def step(cls, value: float, start: float = 0.0) -> Force:
        """Thrust of `value` N from `start` s on."""
        return cls(np.array([start]), np.array([value]))

    @classmethod
    def impulse(cls, value: float, *, start: float = 0.0, stop: float) -> Force:
        """Thrust of `value` N from `start` to `stop` s."""
        return cls(np.array([start, stop]), np.array([value, 0.0]))

    @cached_property
    def pieces(self) -> tuple[Array, Array, Array]:
        """Edges / s, force / N at each and slope / (N/s) after it."""
        slopes = np.zeros(len(self.t))
        if self.kind == "linear":
            slopes[:-1] = np.diff(self.values) / np.diff(self.t)
        return self.t, self.values, frozen(slopes)


@dataclass(frozen=True, eq=False)
class Run:
    """One test on the rig: how it starts, what drives it, and when its channels are sampled.

    Parameters
    ----------
    x0, v0 : float
        Position / m and velocity / (m/s) at `t0` (at `held_until`, where that is given; then v0 is 0).
    t0 : float
        Start in s. Samples before it see the module in its start state.
    held_until : float or None
        Time in s before which the module is held at x0.
    force : Force or None
        The thrust, commanded or measured; None for no thrust.
    t_x, t_v, t_T : array_like or None, shape (n,)
        Time stamps / s of position, velocity and tension, increasing, gaps allowed; None where not measured.
    added : Force or None
        A force on the module beside the thrust, as a table (kind 'linear') that covers the run; None for none. The
        thrusters' gain, lag and delay do not touch it.

    Raises
    ------
    MetrologyError
        Unordered or non-finite times, impossible start state, a measured force that does not cover the run.
    """

    x0: float
    v0: float = 0.0
    t0: float = 0.0
    held_until: float | None = None
    force: Force | None = None
    t_x: Array | None = None
    t_v: Array | None = None
    t_T: Array | None = None  # noqa: N815 - the channel's own symbol
    added: Force | None = None

    def __post_init__(self) -> None:
        stamps = tuple(name for name in ("t_x", "t_v", "t_T") if getattr(self, name) is not None)
        faults = _freeze(self, "run", stamps) + _impossible_start(self)
        for name in stamps:
            faults += _unordered(f"run.{name}", getattr(self, name))
        if not stamps:
            faults.append(Fault("run", "no channel", "time stamps of at least one of x, v, T"))
        faults = faults or _uncovered(self)
        if faults:
            raise MetrologyError(*faults)

    @classmethod
    def sampled(cls, t: ArrayLike, x0: float, v0: float = 0.0, **options: object) -> Run:
        """Return a run with x, v and T all sampled at `t`; `options` are the other fields of `Run`."""
        stamps = frozen(np.array(t, dtype=float))
        return cls(x0=x0, v0=v0, t_x=stamps, t_v=stamps, t_T=stamps, **options)  # type: ignore[arg-type]

    @property
    def end(self) -> float:
        """Last time of any channel, s."""
        return max(float(t[-1]) for t in (self.t_x, self.t_v, self.t_T) if t is not None)

    @cached_property
    def evenness(self) -> dict[str, tuple[Whole, Array]]:
        """For each channel and stamp: the last stamp of its evenly spaced stretch, and the spacing there / s."""
        stamps = {"x": self.t_x, "v": self.t_v, "T": self.t_T}
        found: dict[int, tuple[Whole, Array]] = {}
        for t in stamps.values():
            if t is not None and id(t) not in found:
                found[id(t)] = even_stretches(t)
        return {name: found[id(t)] for name, t in stamps.items() if t is not None}


def even_stretches(t: Array) -> tuple[Whole, Array]:
    """For each stamp the index of the last one of its evenly spaced stretch, and the spacing there / s."""
    ends, spacings = np.arange(t.size), np.zeros(t.size)
    # Rounding of the stamps themselves makes steps differ in their last digits.
    allowed = 8.0 * np.spacing(np.abs(t).max())
    uneven = np.flatnonzero(np.abs(np.diff(t, 2)) > allowed) + 1
    bounds = np.concatenate([[0], uneven, [t.size - 1]])
    longer = np.flatnonzero(np.diff(bounds) >= STRETCH)
    for first, last in zip(bounds[longer].tolist(), bounds[longer + 1].tolist(), strict=True):
        even = np.linspace(t[first], t[last], last - first + 1)
        if np.abs(even - t[first : last + 1]).max() <= allowed:
            ends[first:last], spacings[first:last] = last, (t[last] - t[first]) / (last - first)
    return frozen(ends), frozen(spacings)


def _freeze(owner: object, label: str, names: tuple[str, ...]) -> list[Fault]:
    faults = []
    for name in names:
        given = getattr(owner, name)
        array = given
        if (
            not (isinstance(given, np.ndarray) and given.dtype == float and given.flags.c_contiguous)
            or given.flags.writeable
        ):
            array = frozen(np.array(given, dtype=float, ndmin=1))
        object.__setattr__(owner, name, array)
        if array.ndim != 1 or array.size == 0:
            faults.append(Fault(f"{label}.{name}", f"shape {array.shape}", "at least one value, in one dimension"))
        elif not np.isfinite(array).all():
            at = int(np.flatnonzero(~np.isfinite(array))[0])
            faults.append(Fault(f"{label}.{name}[{at}]", f"{array[at]}", "a finite number", "leave the gap out"))
    return faults


def _unordered(where: str, times: Array) -> list[Fault]:
    if times.ndim != 1:
        return []
    wrong = np.flatnonzero(np.diff(times) <= 0)
    if wrong.size == 0:
        return []
    at = int(wrong[0]) + 1
    return [Fault(f"{where}[{at}]", f"{times[at]:g} s after {times[at - 1]:g} s", "times that increase")]


def _impossible_start(run: Run) -> list[Fault]:
    expected = "a finite number for the start state"
    names = ("x0", "v0", "t0") if run.held_until is None else ("x0", "v0", "t0", "held_until")
    given = {name: getattr(run, name) for name in names}
    faults = [
        Fault(f"run.{name}", f"{value!r:.60}", expected)
        for name, value in given.items()
        if not (isinstance(value, Real) and math.isfinite(value))
    ]
    faults += [
        Fault(f"run.{name}", f"{value!r:.60}", "a Force, such as metrology.Force.step(0.38, start=1.0)")
        for name in ("force", "added")
        if not isinstance(value := getattr(run, name), Force | None)
    ]
    if faults or run.held_until is None:
        return faults
    if run.held_until < run.t0:
        faults.append(Fault("run.held_until", f"{run.held_until} s", f"a time from t0 = {run.t0:g} s on"))
    if run.v0 != 0:
        faults.append(Fault("run.v0", f"{run.v0:g} m/s", "0 m/s for a module that is held at first"))
    return faults


def _uncovered(run: Run) -> list[Fault]:
    start = run.t0 if run.held_until is None else run.held_until
    faults = []
    for name in ("force", "added"):
        force = getattr(run, name)
        if force is not None and force.kind == "linear" and not (force.t[0] <= start and run.end <= force.t[-1]):
            got = f"{force.t[0]:g} s to {force.t[-1]:g} s"
            faults.append(Fault(f"run.{name}.t", got, f"a column that covers {start:g} s to {run.end:g} s"))
    if run.added is not None and run.added.kind != "linear":
        faults.append(Fault("run.added.kind", f"'{run.added.kind}'", "'linear', a table over time"))
    return faults
