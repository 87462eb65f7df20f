"""Effects of the laboratory's own: a force on the module, written as a Python function, with its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrology.errors import Fault, MetrologyError
from metrology.rig.effects import EFFECTS, PARAMETERS, Effect

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
    >>> size = Parameter("air.cubic", "b₃", "N·s³/m³", 0.0, 0.0, math.inf, (0.0, 1e3), 1.0, "cubic drag")
    >>> entry = Effect("air", "Cubic drag", "F = −b₃·v³", (size,), "decay grows with v²", "ours", linear=False)
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
