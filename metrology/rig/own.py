"""Effects of the laboratory's own: a force on the module, or a share of a reading, as a Python function."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrology.effect import Cause, Effect, Parameter, Size
from metrology.errors import Fault, MetrologyError
from metrology.rig.parameters import EFFECTS, PARAMETERS
from metrology.units.dimensions import TextError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Own:
    """A force on the module that the equation of motion of `metrology.rig` does not have (``docs/extend.md``).

    Parameters
    ----------
    effect : Effect
        Its entry, like those of `EFFECTS`: name, title, equation, parameters ``'<name>.<parameter>'`` with unit, null
        and range. The first `sizes` parameters are its sizes; with those at their nulls it is not called.
    force : callable
        ``force(t, x, v, e, T, **parameters)`` → force / N on the module towards growing x, shape (n,). `t` / s, `x` /
        m, `v` / (m/s), `e` = x − x_t / m (negative while slack) and `T` / N are arrays of shape (n,); parameters come
        as numbers by the second half of their names. Smooth between the events of the motion.

    Raises
    ------
    MetrologyError
        For an entry whose names clash with the rig's or do not fit together, or a null out of range.

    Examples
    --------
    >>> from metrology.rig import Effect, Parameter
    >>> size = Parameter("air.cubic", "b₃", "N·s³/m³", 0.0, 0.0, math.inf, (0.0, 1e3), 1.0, "cubic drag", linear=False)
    >>> entry = Effect("air", "Cubic drag", "F = −b₃·v³", (size,), "decay grows with v²", "ours")
    >>> air = Own(entry, lambda t, x, v, e, T, cubic: -cubic * v**3)
    """

    effect: Effect
    force: Callable[..., Array]

    def __post_init__(self) -> None:
        faults = [*_misnamed(self.effect), *_impossible(self.effect)]
        if faults:
            raise MetrologyError(*faults)

    def values(self, given: Mapping[str, float]) -> dict[str, float]:
        """Arguments of `force`: each parameter's value, its null where not given, by the second half of its name."""
        return {one.name.partition(".")[2]: given.get(one.name, one.null or 0.0) for one in self.effect.parameters}

    def acts(self, given: Mapping[str, float]) -> bool:
        """Whether any of its sizes is off its null."""
        sizes = self.effect.parameters[: self.effect.sizes]
        return any(given.get(one.name, one.null) != one.null for one in sizes)


def placed(function: Callable[..., Array], name: str, error: BaseException | None = None) -> str:
    """File and line of a function, then its name: where it begins, or where it failed with an error.

    Parameters
    ----------
    function : callable
        Of a laboratory's file.
    name : str
        Of the function, for the message.
    error : BaseException, optional
        What it raised.

    Returns
    -------
    str
        ``file:line name``.
    """
    code = getattr(function, "__code__", None)
    if code is None:
        return name
    line, trace = code.co_firstlineno, error.__traceback__ if error else None
    while trace is not None:
        line = trace.tb_lineno if trace.tb_frame.f_code.co_filename == code.co_filename else line
        trace = trace.tb_next
    return f"{code.co_filename}:{line} {name}"


def _misnamed(effect: Effect) -> list[Fault]:
    faults = []
    if effect.name in {one.name for one in EFFECTS} or effect.name in PARAMETERS or not effect.name.isidentifier():
        faults.append(Fault("own.name", f"'{effect.name}'", "a name that no effect of the rig has, of letters"))
    if not effect.parameters:
        faults.append(Fault(f"own.{effect.name}.parameters", "none", "at least one parameter, the effect's size"))
    for one in effect.parameters:
        first, _, second = one.name.partition(".")
        if first != effect.name or not second.isidentifier() or second in ("t", "x", "v", "e", "T"):
            expected = f"'{effect.name}.' and a name other than t, x, v, e and T"
            faults.append(Fault(f"own.{effect.name}.parameters", f"'{one.name}'", expected))
    return faults


def _impossible(effect: Effect) -> list[Fault]:
    return [
        Fault(f"own.{one.name}.null", f"{one.null}", f"a number from {one.low:g} to {one.high:g} {one.unit}")
        for one in effect.parameters
        if one.null is None or not (math.isfinite(one.null) and one.low <= one.null <= one.high)
    ]


# ---- as a file of a laboratory declares it --------------------------------------------------------------------------
@dataclass(frozen=True)
class OwnParameter:
    """One parameter of an `OwnEffect`: the first one is its size, the others say how it acts.

    Parameters
    ----------
    name : str
        Argument of the function.
    unit : str
        SI unit, ``'1'`` for a mere number.
    null, low, high : float
        Of a size: where the effect vanishes; of another: the customary value. Closed physical range.
    scale : float
        A change of this size is neither tiny nor huge.
    meaning : str
        In one line.
    tried : sequence of float
        Of a parameter that is no size: values at which a diagnosis tries the effect; its null where nothing is said.
    """

    name: str
    unit: str
    null: float
    low: float
    high: float
    scale: float
    meaning: str
    tried: Sequence[float] = ()


@dataclass(frozen=True)
class OwnEffect:
    """An effect that a laboratory declares in a file of its own, which a campaign names (``docs/extend.md``).

    Parameters
    ----------
    name, title, equation : str
        As in the table of the rig's effects.
    parameters : tuple of OwnParameter
        The first one is the size.
    sign, consequence, advice, separate : str
        How one sees it; what leaving it out does to k, E and c; what the laboratory should do; the measurement that
        tells it from other causes.
    force : callable, optional
        For response tests: ``force(t, x, v, e, T, **parameters)`` as in `Own`.
    reading : callable, optional
        For elongation tests: ``reading(F, order, back, **shapes)`` → what one unit of the size adds to each reading,
        shape (n,), in m for each unit of the size; `F` / N, `order`: number of the reading within its repeat, `back`:
        1 when unloading, else 0. Parameters that are no size come by their names.

    Raises
    ------
    MetrologyError
        Names that clash with the rig's, no unit or one that is none, a null out of range, no function.
    """

    name: str
    title: str
    equation: str
    parameters: tuple[OwnParameter, ...]
    sign: str
    consequence: str
    advice: str
    separate: str
    force: Callable[..., Array] | None = None
    reading: Callable[..., Array] | None = None

    def __post_init__(self) -> None:
        faults = [fault for one in self.parameters for fault in _undimensioned(self.name, one)]
        if self.force is None and self.reading is None:
            faults.append(Fault(f"own.{self.name}", "no function", "'force' or 'reading'"))
        if not faults:
            faults += [*_misnamed(self.entry), *_impossible(self.entry)]
        if faults:
            raise MetrologyError(*faults)

    @property
    def entry(self) -> Effect:
        """Its entry, like those of `EFFECTS`."""
        parameters = tuple(
            Parameter(
                f"{self.name}.{one.name}", one.name, one.unit, one.null, one.low, one.high, (one.low, one.high),
                one.scale, one.meaning, linear=False,
            )
            for one in self.parameters
        )  # fmt: skip
        sizes = tuple(
            Size(one.name, one.unit, one.null or 0.0, one.low, one.high, one.scale, shape=at > 0)
            for at, one in enumerate(parameters)
        )
        cause = Cause(
            "response", self.name, sizes, self.consequence, self.advice, self.separate, ("time",),
            amount=self.parameters[0].scale, shapes=lambda *_: self.shapes(),
        )  # fmt: skip
        return Effect(self.name, self.title, self.equation, parameters, self.sign, "the laboratory", causes=(cause,))

    @property
    def own(self) -> Own:
        """As a rig takes it.

        Raises
        ------
        ValueError
            For an effect without a force.
        """
        if self.force is None:
            message = f"'{self.name}' has no force"
            raise ValueError(message)
        return Own(self.entry, self.force)

    def shapes(self) -> list[dict[str, float]]:
        """Values of the parameters that are no size, by their full names, in every combination to be tried."""
        found: list[dict[str, float]] = [{}]
        for one in self.parameters[1:]:
            values = one.tried or (one.null,)
            found = [{**before, f"{self.name}.{one.name}": float(value)} for before in found for value in values]
        return found


def _undimensioned(name: str, one: OwnParameter) -> list[Fault]:
    from metrology import units

    where, numbers = f"own.{name}.{one.name}", (one.null, one.low, one.high, one.scale, *one.tried)
    if not all(isinstance(number, int | float) for number in numbers):
        return [Fault(where, f"{numbers}", "numbers for null, low, high, scale and what is tried")]
    try:
        if not one.unit:
            raise TextError("no unit", "an SI unit, or '1' for a mere number")
        if one.unit != "1" and units.parse(f"1 {one.unit}").factor != 1:
            raise TextError(f"'{one.unit}'", "an SI unit without a prefix, such as 'N'")
    except TextError as error:
        return [Fault(f"{where}.unit", error.got, error.expected)]
    outside = [value for value in one.tried if not one.low <= value <= one.high]
    if outside or not (math.isfinite(one.scale) and one.scale > 0):
        got = f"scale {one.scale:g}, tried {list(one.tried)}"
        return [Fault(where, got, f"a positive scale, and values from {one.low:g} to {one.high:g}")]
    return []
