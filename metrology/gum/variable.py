"""The variables that carry derivatives through a measurand; apart, since few commands need `uncertainties`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from uncertainties.core import AffineScalarFunc
from uncertainties.ops import ops_with_reflection


def _of_two(name: str) -> Callable[[Any, Any], Any]:
    """The library's operator, with fewer steps between two of its numbers: nothing else needs to be told apart."""
    by_first, by_second = ops_with_reflection[name]
    of_floats, general = getattr(float, f"__{name}__"), getattr(AffineScalarFunc, f"__{name}__")

    def operator(self: Any, other: Any) -> Any:
        if not isinstance(other, AffineScalarFunc):
            return general(self, other)
        x, y = self.nominal_value, other.nominal_value
        value = of_floats(x, y)
        return Number(value, [(by_first(x, y), self._linear_part), (by_second(x, y), other._linear_part)])

    return operator


class Number(AffineScalarFunc):  # type: ignore[misc]  # the library states no types
    """A number of `uncertainties`, quick where two of them are added, subtracted, multiplied or divided."""

    __slots__ = ()
    __add__ = _of_two("add")
    __sub__ = _of_two("sub")
    __mul__ = _of_two("mul")
    __truediv__ = _of_two("truediv")


class Variable(Number):
    """An input at its estimate, with the derivative 1 by itself; its name is the tag."""

    __slots__ = ("tag",)
    _std_dev = 1.0  # asked for where numbers are compared for equality; any but zero serves

    def __init__(self, value: float, tag: str) -> None:
        super().__init__(value, {self: 1.0})
        self.tag = tag
