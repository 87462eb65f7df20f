"""Measurement models as text: a small safe language of arithmetic, powers and elementary functions.

The syntax is in `metrology.expression.syntax`, the functions in `metrology.expression.elementary`. Nothing is ever
executed as Python: text becomes a list of steps for a stack, which takes floats, arrays, complex numbers, variables of
`uncertainties`, and dimensions.

A dash is always a minus. A quantity whose name has one (``al-1100.length``) is given a name of its own by whoever
supplies the mapping (``where: {L: al-1100.length}``).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from typing import Any

import numpy as np

from metrology.expression.elementary import FUNCTIONS, power
from metrology.expression.syntax import CONSTANTS, RESERVED, ExpressionError, Step, read
from metrology.units.dimensions import Dimension, quoted

__all__ = ["CONSTANTS", "FUNCTIONS", "RESERVED", "Expression", "ExpressionError"]

MAX_POWER = 100
_OPERATIONS: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": power,
    "negate": operator.neg,
    **FUNCTIONS,
}


@dataclass(frozen=True)
class Expression:
    """A model equation, read once and evaluated many times.

    Parameters
    ----------
    text : str
        As the user wrote it.
    steps : tuple of Step
        What the stack machine does.

    Examples
    --------
    >>> modulus = Expression.parse("k * L / (w * t)")
    >>> sorted(modulus.names)
    ['L', 'k', 't', 'w']
    >>> round(modulus.evaluate({"k": 24734.25, "L": 2.99, "w": 0.025, "t": 5e-5}) / 1e9, 2)
    59.16
    """

    text: str
    steps: tuple[Step, ...]

    @classmethod
    def parse(cls, text: str) -> Expression:
        """Read an expression.

        Raises
        ------
        ExpressionError
            A ValueError that names the column.
        """
        return cls(text, read(text))

    @property
    def names(self) -> frozenset[str]:
        """Names of the quantities that the expression needs; constants and functions are none."""
        return frozenset(step.word for step in self.steps if step.kind == "name")

    def evaluate(self, values: Mapping[str, Any]) -> Any:
        """Value of the expression.

        Parameters
        ----------
        values : mapping of str to float, complex, ndarray, or variable of `uncertainties`
            All arrays of one shape. Where the expression is not defined they become nan or inf, without a warning.

        Raises
        ------
        ExpressionError
            For a name that is missing, and where floats or uncertain variables give no finite real number.
        """
        with np.errstate(all="ignore"):
            result = self._run(lambda step: _plain(self._lookup(step, values)), _apply)
        if isinstance(result, float) and not math.isfinite(result):
            raise ExpressionError(f"{result:g} from {quoted(self.text)}", "a finite number")
        return result

    def dimension(self, dimensions: Mapping[str, Dimension]) -> Dimension:
        """Dimension of the expression from those of its names.

        Raises
        ------
        ExpressionError
            Where metres are added to newtons, or a function is given anything but a number.
        """

        def push(step: Step) -> _Term:
            if step.kind == "number":
                return _Term(Dimension(), step.number)
            return _Term(self._lookup(step, dimensions))

        term: _Term = self._run(push, _combine)
        return term.dimension

    def _run(self, push: Callable[[Step], Any], apply: Callable[[Step, list[Any]], Any]) -> Any:
        stack: list[Any] = []
        for step in self.steps:
            if not step.arity:
                stack.append(push(step))
                continue
            arguments = stack[-step.arity :]
            del stack[-step.arity :]
            stack.append(apply(step, arguments))
        return stack.pop()

    def _lookup(self, step: Step, mapping: Mapping[str, Any]) -> Any:
        if step.kind == "number":
            if step.word in mapping:
                raise ExpressionError(
                    f"{step.word!r} in {quoted(self.text)}, a constant and a quantity as well",
                    "another name for the quantity",
                    column=step.column,
                )
            return step.number
        try:
            return mapping[step.word]
        except KeyError:
            near = get_close_matches(step.word, list(mapping), 1)
            fix = f"did you mean {near[0]!r}?" if near else ""
            known = ", ".join(sorted(mapping)[:12]) or "none is known here"
            raise ExpressionError(
                f"{step.word!r} in {quoted(self.text)}", f"the name of a quantity: {known}", fix, column=step.column
            ) from None


def _plain(value: Any) -> Any:
    return float(value) if isinstance(value, int | np.floating | np.integer) else value


def _apply(step: Step, arguments: list[Any]) -> Any:
    try:
        return _OPERATIONS[step.word](*arguments)
    except ZeroDivisionError:
        what = "division by zero"
    except OverflowError:
        what = "a number beyond 1e308"
    except ValueError:
        what = f"{_text(step)} of {', '.join(format(getattr(a, 'nominal_value', a), 'g') for a in arguments)}"
    raise ExpressionError(what, "numbers for which the expression is defined", column=step.column)


def _text(step: Step) -> str:
    return {"negate": "-"}.get(step.word, step.word)


@dataclass(frozen=True)
class _Term:
    """A dimension, with the number where the term is made of numbers alone: an exponent must be one."""

    dimension: Dimension
    number: float | None = None


def _combine(step: Step, terms: list[_Term]) -> _Term:
    dimension = _RULES.get(step.word, _of_numbers)(step, terms)
    numbers = [term.number for term in terms if term.number is not None]
    return _Term(dimension, _apply(step, numbers) if len(numbers) == len(terms) else None)


def _same(step: Step, terms: list[_Term]) -> Dimension:
    """Sums, least and greatest: one dimension for all; a plain zero goes with any."""
    due = [term.dimension for term in terms if term.number != 0] or [terms[0].dimension]
    for other in due[1:]:
        if other != due[0]:
            got = f"{due[0].name} and {other.name} in one {'sum' if step.word in '+-' else repr(step.word)}"
            raise ExpressionError(got, "terms of one dimension", column=step.column)
    return due[0]


def _of_numbers(step: Step, terms: list[_Term]) -> Dimension:
    for term in terms:
        if not term.dimension.dimensionless:
            got, fix = f"{_text(step)} of {term.dimension.name}", "divide by a reference of the same dimension"
            raise ExpressionError(got, f"{_text(step)} of a number", fix, column=step.column)
    return Dimension()


def _to_power(step: Step, terms: list[_Term]) -> Dimension:
    base, exponent = terms
    if not exponent.dimension.dimensionless:
        raise ExpressionError(f"{exponent.dimension.name} as an exponent", "a number", column=step.column)
    if base.dimension.dimensionless:
        return Dimension()
    if exponent.number is None:
        got = f"{base.dimension.name} to a power that is a quantity"
        raise ExpressionError(got, "a power written as a number, such as 2 or (1/2)", column=step.column)
    small = abs(exponent.number) <= MAX_POWER
    ratio = Fraction(exponent.number).limit_denominator(12) if small else Fraction(0)
    if not small or abs(exponent.number - ratio) > 1e-12:
        got = f"{base.dimension.name} to the power {exponent.number:g}"
        raise ExpressionError(got, "a small whole or broken power", column=step.column)
    return base.dimension**ratio


_RULES: dict[str, Callable[[Step, list[_Term]], Dimension]] = {
    "+": _same,
    "-": _same,
    "min": _same,
    "max": _same,
    "negate": _same,
    "abs": _same,
    "*": lambda step, terms: terms[0].dimension * terms[1].dimension,  # noqa: ARG005
    "/": lambda step, terms: terms[0].dimension / terms[1].dimension,  # noqa: ARG005
    "**": _to_power,
    "sqrt": lambda step, terms: terms[0].dimension ** Fraction(1, 2),  # noqa: ARG005
    "atan2": lambda step, terms: _same(step, terms) ** 0,
}
