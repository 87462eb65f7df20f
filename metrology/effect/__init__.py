"""What one effect declares: parameters, what it adds to the motion or to a reading, what it means for a test."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from metrology.effect.readings import Array, Pulled, Readings
from metrology.effect.size import Size, choice

__all__ = [
    "ARGUMENTS",
    "BASE",
    "INF",
    "METHODS",
    "NEEDS",
    "PICTURES",
    "Array",
    "Cause",
    "Effect",
    "Parameter",
    "Pulled",
    "Readings",
    "Scales",
    "Size",
    "Term",
    "choice",
]

INF = math.inf
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
