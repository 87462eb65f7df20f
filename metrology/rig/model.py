"""The rig, a run on it, and the motion that comes out: what the simulation takes and gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from metrology.errors import Fault, MetrologyError
from metrology.rig.effects import NAMES, PARAMETERS
from metrology.rig.own import Own
from metrology.rig.parameters import BASE, Parameter

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
CHANNELS = ("x", "v", "T")
ATTACHMENTS = ("tether", "both ways", "none")
LINE_WEIGHTS = ("none", "catenary", "elastic catenary")
_OWN = tuple(entry.name for entry in BASE)
_Any = TypeVar("_Any", bound=NDArray[Any])


def frozen(array: _Any) -> _Any:
    """Return the array, from now on read-only."""
    array.setflags(write=False)
    return array


@dataclass(frozen=True)
class Rig:
    """Module, line and set-up: the numbers of the equation of motion (``docs/model.md``).

    m·x″ = F_thrusters(t) + F_tilt − F_drag − F_friction − T,  T = k·e + c·e′ ≥ 0 for e = x − x_t > 0, else 0 or the
    weight of the slack line.

    Parameters
    ----------
    m, k, c : float
        Mass / kg, stiffness / (N/m) and damping / (N·s/m) of the line. With an angle for x and a torque for F they are
        kg·m², N·m/rad and N·m·s/rad.
    taut : float
        Position x at which the line is just taut, m.
    length, weight : float
        Free length / m of the line and its weight per length / (N/m).
    line_weight : {'none', 'catenary', 'elastic catenary'}
        How the weight of the line acts: not, by eq. 3 of the paper when slack, or by an elastic catenary throughout.
    cap : float
        Distance from taut / m below which eq. 3 is held at its value.
    attachment : {'tether', 'both ways', 'none'}
        A line that only pulls, one that pushes as well (a spring, a pendulum), or none.
    gravity : float
        Acceleration of free fall, m/s².
    effects : mapping of str to float
        Values of effect parameters by name (``{'friction.force': 2e-3}``); those left out are at their null.
    own : tuple of Own
        Effects of the laboratory's own; their parameters stand in `effects` like all others.

    Raises
    ------
    MetrologyError
        With one fault for each number that is impossible.

    Examples
    --------
    >>> Rig(m=25.0, k=167.64, c=8.0, taut=1.5).value("k")
    167.64
    """

    m: float
    k: float
    c: float = 0.0
    taut: float = 0.0
    length: float = 0.0
    weight: float = 0.0
    line_weight: Literal["none", "catenary", "elastic catenary"] = "none"
    cap: float = 0.005
    attachment: Literal["tether", "both ways", "none"] = "tether"
    gravity: float = 9.8
    effects: Mapping[str, float] = field(default_factory=dict)
    own: tuple[Own, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", MappingProxyType(dict(self.effects)))
        faults = [*_unknown_effects(self), *_impossible_values(self), *_impossible_choices(self)]
        if faults:
            raise MetrologyError(*faults)

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """`PARAMETERS`, and those of the rig's own effects after them."""
        if not self.own:
            return PARAMETERS
        return {**PARAMETERS, **{one.name: one for own in self.own for one in own.effect.parameters}}

    def without_own(self) -> Rig:
        """Return the same rig without effects of its own."""
        kept = {name: value for name, value in self.effects.items() if name in PARAMETERS}
        return replace(self, own=(), effects=kept) if self.own else self

    def value(self, name: str) -> float:
        """Value of one parameter, its null where the rig does not give it."""
        if name in _OWN:
            return float(getattr(self, name))
        null = self.parameters[name].null
        assert null is not None
        return float(self.effects.get(name, null))

    def vector(self) -> Array:
        """Return every parameter's value, read-only, shape (len(NAMES),), in the order of `NAMES`."""
        return self._vector

    @cached_property
    def _vector(self) -> Array:
        return frozen(np.array([self.value(name) for name in NAMES]))

    def with_values(self, values: Mapping[str, float]) -> Rig:
        """Return the same rig with these parameters set, any of `NAMES`, several at once."""
        own = {name: value for name, value in values.items() if name in _OWN}
        others = {name: value for name, value in values.items() if name not in _OWN}
        return replace(self, **own, effects={**self.effects, **others})  # type: ignore[arg-type]

    def __reduce__(self) -> tuple[object, ...]:
        # A read-only mapping cannot be pickled, and workers in other processes need rigs.
        return _rig_again, tuple(
            dict(self.effects) if entry.name == "effects" else getattr(self, entry.name) for entry in fields(self)
        )


def _rig_again(*values: object) -> Rig:
    return Rig(*values)  # type: ignore[arg-type]


def _unknown_effects(rig: Rig) -> list[Fault]:
    expected = "the name of an effect's parameter, such as 'friction.force'"
    return [
        Fault(f"rig.effects.{name}", f"'{name}'", expected)
        for name in rig.effects
        if name not in rig.parameters or name in _OWN
    ]


def _impossible_values(rig: Rig) -> list[Fault]:
    given = [entry for entry in rig.parameters.values() if entry.name in _OWN or entry.name in rig.effects]
    faults = []
    for entry in given:
        value = rig.value(entry.name)
        if not (math.isfinite(value) and entry.low <= value <= entry.high):
            where = entry.name if entry.name in _OWN else f"effects.{entry.name}"
            faults.append(Fault(f"rig.{where}", f"{value:g} {entry.unit}", _range(entry)))
    return faults


def _range(entry: Parameter) -> str:
    if math.isinf(entry.low):
        return f"a finite number for the {entry.meaning}"
    bounds = f"at least {entry.low:g}" if math.isinf(entry.high) else f"from {entry.low:g} to {entry.high:g}"
    return f"{bounds} {entry.unit} for the {entry.meaning}"


def _impossible_choices(rig: Rig) -> list[Fault]:
    names = [own.effect.name for own in rig.own]
    faults = [
        Fault(f"rig.own.{name}", "two of that name", "one effect of each name")
        for name in sorted(set(names))
        if names.count(name) > 1
    ]
    for name, choices in (("attachment", ATTACHMENTS), ("line_weight", LINE_WEIGHTS)):
        if getattr(rig, name) not in choices:
            faults.append(Fault(f"rig.{name}", repr(getattr(rig, name)), "one of " + ", ".join(map(repr, choices))))
    sags = rig.line_weight != "none" or rig.effects.get("sag.weight", 0.0) > 0
    if sags and rig.attachment != "tether":
        faults.append(Fault("rig.line_weight", f"a sagging line attached '{rig.attachment}'", "a line that only pulls"))
    if sags and not rig.length > 0:
        faults.append(Fault("rig.length", f"{rig.length:g} m", "the free length of the line, which its weight needs"))
    return faults


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
    added : Force or None
        A force on the module beside the thrust, as a table (kind 'linear') that covers the run; None for none. The
        thrusters' gain, lag and delay do not touch it.
    t_x, t_v, t_T : array_like or None, shape (n,)
        Time stamps / s of position, velocity and tension, increasing, gaps allowed; None where not measured.

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
    first = 0
    for last in [*uneven.tolist(), t.size - 1]:
        even = np.linspace(t[first], t[last], last - first + 1)
        if last > first + 1 and np.abs(even - t[first : last + 1]).max() <= allowed:
            ends[first:last], spacings[first:last] = last, (t[last] - t[first]) / (last - first)
        first = last
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
    wrong = np.flatnonzero(np.diff(times) <= 0)
    if wrong.size == 0:
        return []
    at = int(wrong[0]) + 1
    return [Fault(f"{where}[{at}]", f"{times[at]:g} s after {times[at - 1]:g} s", "times that increase")]


def _impossible_start(run: Run) -> list[Fault]:
    expected = "a finite number for the start state"
    faults = [
        Fault(f"run.{name}", f"{getattr(run, name)}", expected)
        for name in ("x0", "v0", "t0")
        if not math.isfinite(getattr(run, name))
    ]
    if run.held_until is None:
        return faults
    if not math.isfinite(run.held_until) or run.held_until < run.t0:
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


@dataclass(frozen=True)
class Event:
    """A change of regime at time `t` / s.

    `kind` is one of 'taut', 'slack', 'stick', 'slip' (the module starts to slide), 'turn' (its velocity changes sign),
    'clamp slip', 'toe', 'force', 'release'.
    """

    t: float
    kind: str


@dataclass(frozen=True, eq=False)
class Motion:
    """What the channels read.

    Parameters
    ----------
    x, v, T : ndarray or None
        Position / m, velocity / (m/s) and tension / N at exactly the requested stamps; None where not asked for.
        From the time of a failure on they are NaN.
    record : callable
        Gives the events; `events` calls it once, when it is asked for.
    status : {'ok', 'invalid'}
        Whether the integration reached the end.
    message : str
        Where invalid: what happened, what it may mean, what to try.
    engine : str
        'compiled', 'numpy' or 'interpreted'.
    """

    x: Array | None
    v: Array | None
    T: Array | None
    record: Callable[[], tuple[Event, ...]] = field(repr=False)
    status: Literal["ok", "invalid"]
    message: str
    engine: str

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Changes of regime in order of time."""
        return self.record()
