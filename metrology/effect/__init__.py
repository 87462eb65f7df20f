"""What one effect declares: parameters, what it adds to the motion or to a reading, what it means for a test."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

INF = math.inf
Array = NDArray[np.float64]
Scales = Mapping[str, float]
Term = Callable[..., Any]
METHODS = ("response", "decay", "elongation", "tension")
PICTURES = ("force-velocity", "force-elongation", "loop", "delay", "spectrum", "rate", "frequency", "order", "load",
            "time")  # fmt: skip
"""What a cause may be plotted against; 'time': it has no picture of its own but residuals over time."""
NEEDS = ("x", "v", "T", "motion", "thrust", "tether", "both ways", "length", "unloading", "repeats", "order", "loads",
         "time", "rates")  # fmt: skip
"""What a test has to have for a cause."""
BASE = ("m", "k", "c", "taut", "length", "weight", "gravity")
ARGUMENTS = {
    "force": ("t", "x", "v", "e", "T", "way"),
    "tension": ("e",),
    "slope": ("e",),
    "damping": ("e", "rate", "side", "way"),
    "readings": ("y", "t", "since"),
}
"""Term → what it may ask for by name, besides the numbers of the base model and the effect's own parameters."""


@dataclass(frozen=True)
class Parameter:
    """One number of the equation of motion.

    Parameters
    ----------
    name : str
        The name by which every package addresses it: ``'k'``, ``'friction.force'``.
    symbol : str
        As it stands in the equations of ``docs/model.md``.
    unit : str
        SI unit, written out.
    null : float or None
        Value at which an effect vanishes exactly; for a shape parameter of an effect, its customary value; None for a
        number that only the rig itself can give.
    low, high : float
        Closed range of values that the equation allows; the tighter *plausible* range is `plausible`.
    plausible : tuple of float
        Range in which such a value is met in a laboratory: the prior of what nobody has stated.
    scale : float
        A change of this size is neither tiny nor huge: unit of numerical derivatives and of starts.
    meaning : str
        In one line.
    linear : bool
        True where the equation of motion stays linear between events with it, so that its solution is exact.
    """

    name: str = ""
    symbol: str = ""
    unit: str = ""
    null: float | None = None
    low: float = -INF
    high: float = INF
    plausible: tuple[float, float] = (0.0, 0.0)
    scale: float = 0.0
    meaning: str = ""
    linear: bool = True

    @property
    def short(self) -> str:
        """Second half of the name: the argument of the effect's terms."""
        return self.name.partition(".")[2]


@dataclass(frozen=True)
class Size:
    """One parameter of a cause, as a diagnosis seeks it.

    Parameters
    ----------
    name, unit : str
        As a result prints it.
    null : float
        Value at which the effect vanishes.
    low, high : float
        Physical range.
    scale : float
        A change of this size is neither tiny nor huge.
    shape : bool
        True for a parameter that says how the effect acts, not how much of it there is.
    own : bool
        True for a parameter that each block of readings has for itself.
    power : int
        Power of the size with which its effect grows.
    extrapolated : bool
        True for a shape whose places differ most where there is no reading: what each of them says there counts alike.
    apart : int
        Values of a shape within its range that readings tell apart of an effect of ten standard deviations: it costs as
        a choice among so many. 0: as many as it may be.
    """

    name: str
    unit: str
    null: float
    low: float
    high: float
    scale: float
    shape: bool = False
    own: bool = False
    power: int = 1
    extrapolated: bool = False
    apart: int = 0

    @property
    def held(self) -> bool:
        """Whether it is a shape that is tried place by place, and held there: never sought between them."""
        return self.shape and self.scale == 0

    @property
    def places(self) -> range:
        """Places of a shape that is held: its range goes half a step beyond the first and the last."""
        return range(round(self.high + 0.5))

    def amount(self, first: float, factor: float) -> float:
        """Return the size whose effect is so many times that of a first one, which vanishes at zero."""
        return math.copysign(abs(factor) ** (1 / self.power), factor) * first


def choice(name: str, count: int, *, extrapolated: bool = False) -> Size:
    """Which of several shapes: tried one by one, and paid for by the logarithm of their number.

    Parameters
    ----------
    name : str
        Of the size.
    count : int
        Of the shapes; they are numbered from 0.
    extrapolated : bool
        Whether they differ most where there is no reading.

    Returns
    -------
    Size
        Without a unit, from −0.5 to count − 0.5.
    """
    return Size(name, "1", 0.0, -0.5, count - 0.5, 0.0, True, extrapolated=extrapolated)


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings under dead loads, in the order in which they were taken.

    Parameters
    ----------
    force : ndarray, shape (n,)
        N.
    order : ndarray, shape (n,)
        Number of the reading within its repeat.
    back : ndarray, shape (n,)
        1 when unloading, else 0.
    repeat : ndarray of int, shape (n,)
        Number of its repeat.
    u : float
        Scatter of one reading / m.
    """

    force: Array
    order: Array
    back: Array
    repeat: NDArray[np.intp]
    u: float = 1.0

    @property
    def most(self) -> float:
        """Largest force / N."""
        return float(np.abs(self.force).max())


@dataclass(frozen=True, eq=False)
class Pulled:
    """Readings of one specimen in a testing machine, first those of the crosshead, then those of the extensometer.

    Both are displacements over the free length: a strain is multiplied by it.

    Parameters
    ----------
    force, time : ndarray, shape (n,)
        N, s.
    crosshead : ndarray, shape (n,)
        1 for a reading of the crosshead, 0 for one of the extensometer.
    number : int
        Number of the mounting.
    many : int
        Mountings of the test.
    most : float
        Largest force of the test / N.
    middle : float
        Middle of its forces / N.
    slope : float
        Stretch of the free length by force / (m/N).
    u : float
        Scatter of one reading / m.
    steps : int
        Places of each record at which a step is tried.
    halves : int
        Records of each mounting, one after the other: what is lost in one is lost in the next.
    rate : float
        Logarithm of the rate of its force over the geometric mean of those of the test.
    history : tuple of ndarray, shape (h,)
        Force / N and time / s of the whole record up to its last reading, with what lies outside the range of the line.
    kept : dict
        What an effect computes once for these readings, by its name; a copy with other readings begins anew.
    """

    force: Array
    time: Array
    crosshead: Array
    number: int = 0
    many: int = 1
    most: float = 1.0
    middle: float = 0.0
    slope: float = 1.0
    u: float = 1.0
    steps: int = 8
    halves: int = 1
    rate: float = 0.0
    history: tuple[Array, Array] = (np.zeros(1), np.zeros(1))
    kept: dict[str, Array] = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def highest(self) -> Array:
        """Highest force so far at each reading / N."""
        force, time = self.history
        return np.maximum(np.interp(self.time, time, np.maximum.accumulate(force)), self.force)

    @property
    def duration(self) -> float:
        """Time of the whole record up to its last reading / s."""
        return float(np.ptp(self.history[1])) or 1.0

    @property
    def falling(self) -> Array:
        """1 while the force falls, 0 while it rises: over five values of the record, whose noise falls as often."""
        force, time = self.history
        if len(force) < 6:
            return np.zeros(len(self.force))
        later, sooner = np.arange(len(force)) + 2, np.arange(len(force)) - 2
        change = force[np.minimum(later, len(force) - 1)] - force[np.maximum(sooner, 0)]
        nearest = np.searchsorted(0.5 * (time[1:] + time[:-1]), self.time)
        return np.asarray(change[nearest] < 0, dtype=float)

    def after(self, place: float) -> Array:
        """1 for what was read of one mounting beyond the n-th place, which lies in record n // `steps`."""
        number, part = divmod(round(place), self.steps)
        if number < self.number and number // self.halves == self.number // self.halves:
            return np.ones(len(self.force))
        late = self.time > self.time.min() + (part + 0.5) / self.steps * float(np.ptp(self.time))
        return np.asarray(late & (number == self.number), dtype=float)

    @property
    def places(self) -> range:
        """Every place at which a step is tried."""
        return range(self.steps * self.many)


@dataclass(frozen=True)
class Cause:
    """An effect as a candidate of one method.

    Parameters
    ----------
    method : {'response', 'decay', 'elongation', 'tension'}
        Where it is tried.
    name : str
        As results name it.
    sizes : tuple of str or Size
        The first says how much of it there is, the others how it acts; a name takes unit, null and range from the
        effect's parameter.
    consequence, advice, separate : str
        What leaving it out does to k, E and c; what the laboratory should do; the measurement that tells it from
        others.
    pictures : tuple of str
        `PICTURES` that show it.
    title, equation, sign : str
        Where they differ from the effect's.
    kind : {'physics', 'input'}
        'input': something that the laboratory states with an uncertainty, and that would be wrong beyond it.
    needs : tuple of str
        `NEEDS` without which it cannot be tested.
    amount : float or callable
        First size to be tried, or how it follows from the scales of the motion (`metrology.diagnostics.scale`) or from
        `Readings`.
    shapes : callable, optional
        Values of the shapes to be tried, from the same and all candidates' names; else every place of a `choice`.
    limits : callable, optional
        Parameter → range that makes sense for a motion of these scales.
    reading : callable, optional
        Of an elongation or tension test: ``reading(readings, **shapes)``, what one unit of the size adds to each
        reading (`Readings`, `Pulled`).
    alone : str
        Why the method's own readings cannot test it.
    law : str
        What it is one law of, such as softening: of several laws of one thing a model carries one.
    beside : str
        Cause without which it is not tried, since it would be the same by itself: a second one of a kind.
    equivalent : tuple of str and callable, optional
        Cause with the same equations, and the values of its sizes from those of this one and the scales.
    spectral : str
        Channel in the spectrum of whose residuals it is found, in place of trials: amplitude, frequency, phase.
    exact : bool
        Of a response test: whether the exact derivative is taken for what a little of it does, since the unknowns of
        every model do nearly the same, and what they do not is less than what a difference of motions leaves out.
    defined : bool
        Whether it is what its equation says and nothing besides, such as the part of a reading that is in proportion to
        the load: no misfit is put down to its form.
    """

    method: str = ""
    name: str = ""
    sizes: tuple[str | Size, ...] = ()
    consequence: str = ""
    advice: str = ""
    separate: str = ""
    pictures: tuple[str, ...] = ()
    title: str = ""
    equation: str = ""
    sign: str = ""
    kind: Literal["physics", "input"] = "physics"
    needs: tuple[str, ...] = ()
    amount: Callable[[Any], float] | float | None = None
    shapes: Callable[[Any, Container[str]], Sequence[Mapping[str, float]]] | None = None
    limits: Callable[[Any], Mapping[str, tuple[float, float]]] | None = None
    reading: Callable[..., Array] | None = None
    alone: str = ""
    law: str = ""
    beside: str = ""
    equivalent: tuple[str, Callable[[Scales, Scales], Mapping[str, float]]] | None = None
    spectral: str = ""
    exact: bool = False
    defined: bool = False


@dataclass(frozen=True)
class Effect:
    """One way in which a real rig departs from the base model.

    Parameters
    ----------
    name : str
        First half of the names of its parameters; name of its file.
    title : str
        As a report prints it.
    equation : str
        Its term, in the symbols of ``docs/model.md``.
    parameters : tuple of Parameter
        The first one is its size: at its null the effect vanishes, whatever the others are. Where `sizes` is above 1,
        as many of the first parameters are sizes, each of which acts by itself.
    sign : str
        How one sees it in a measurement.
    source : str
        Where the equation stands.
    sizes : int
        Number of sizes.
    acts : {'module', 'line', 'thrust', 'reading'}
        On what: 'reading' leaves the motion itself as it is.
    straight : bool
        True for what only a module on a straight path knows.
    force : callable, optional
        Force / N on the module towards growing x. Terms take what they need by the names of their arguments: time `t`,
        position `x`, velocity `v`, distance beyond taut `e`, tension `T`, and the direction of motion `way` (±1, which
        has the turn of the motion located), numbers of the base model, the effect's parameters by their short names.
        Arithmetic and NumPy functions alone: they are compiled.
    tension, slope : callable, optional
        Static tension / N that is added at the elongation `e` of the line, and its derivative by `e`.
    damping : callable, optional
        Force / N that is added to the line's damping, at its elongation `e` and the `rate` of that; `side` is the sign
        of e, `way` that of the rate (their changes are located).
    readings : mapping of str to callable
        Channel → what is added to its reading: of the true value `y`, the time `t` and the time `since` the start; by
        arrays.
    built_in : bool
        True where its terms stand in the equation of motion itself: what switches or has a state of its own.
    causes : tuple of Cause
        The methods that try it.
    never : str
        Why no method tries it, where none does.
    """

    name: str = ""
    title: str = ""
    equation: str = ""
    parameters: tuple[Parameter, ...] = ()
    sign: str = ""
    source: str = ""
    sizes: int = 1
    acts: Literal["module", "line", "thrust", "reading"] = "module"
    straight: bool = False
    force: Term | None = None
    tension: Term | None = None
    slope: Term | None = None
    damping: Term | None = None
    readings: Mapping[str, Term] = field(default_factory=dict)
    built_in: bool = False
    causes: tuple[Cause, ...] = ()
    never: str = ""

    @property
    def linear(self) -> bool:
        """Whether the equation of motion stays linear between events, whichever of its parameters acts."""
        return all(one.linear for one in self.parameters)

    @property
    def terms(self) -> dict[str, Term]:
        """Its terms by what they add to; those of readings by their channel."""
        single = {name: getattr(self, name) for name in ("force", "tension", "slope", "damping")}
        readings = {f"readings[{channel!r}]": term for channel, term in self.readings.items()}
        return {name: term for name, term in {**single, **readings}.items() if term is not None}

    def cause(self, method: str, name: str = "") -> Cause | None:
        """How a method tries it, by the name of the cause where there are several."""
        return next((one for one in self.causes if one.method == method and name in ("", one.name)), None)
