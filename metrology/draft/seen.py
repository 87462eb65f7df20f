"""A column of an unknown file: what it looks like, its cells as numbers and as words, and its last digit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from metrology.declaration.columns import Floats
from metrology.raw import coarse

MOST_PLACES = 6
"""Decimal places of a number as an instrument writes it; one with more has all digits of a double."""
_DECIMAL = re.compile(r"[+-]?\d*(?:\.(?P<places>\d*))?(?:[eE](?P<exponent>[+-]?\d{1,3}))?", re.ASCII)


@dataclass(frozen=True)
class Seen:
    """A column: its number from 1, heading, unit and role, its cells as numbers and as words, with a decimal point.

    `written`: the cells as the file has them; `with_unit`: whether its reader finds the unit there.
    """

    number: int
    heading: str
    name: str
    unit: str
    role: str
    values: Floats | None
    words: tuple[str, ...]
    written: tuple[str, ...]
    with_unit: bool

    @property
    def constant(self) -> bool:
        """Whether it has one value, on one row or on all."""
        return self.values is not None and len(set(self.values[np.isfinite(self.values)])) == 1

    @property
    def resolution(self) -> float:
        """Step of the readings in the unit of the column: of the last digit, or of more where all are multiples of it.

        A ruler that is read to its half divisions, or a camera to half a pixel, writes 438.0 and 437.5. 0 where there
        is no last digit.
        """
        digit = self.digit
        return (coarse(self.values[np.isfinite(self.values)], digit) if self.values is not None else 0.0) or digit

    @property
    def digit(self) -> float:
        """Unit of the last decimal place that the cells have, in the unit of the column; 0 where it is not plain.

        Where every number has an exponent, the place moves with it: that of the largest numbers is taken.
        """
        matches = [match for word in self.words if (match := _DECIMAL.fullmatch(word))]
        found = [match for match in matches if not match["exponent"] or _is_more_than_zero(match[0])]
        if any(len(match["places"] or "") > MOST_PLACES for match in found):
            return 0.0
        if found and all(match["exponent"] for match in found):
            places = max(len(match["places"] or "") for match in found)
            return float(f"1e{max(int(match['exponent']) for match in found) - places}")
        ends = [int(match["exponent"] or 0) - len(match["places"] or "") for match in found]
        return float(f"1e{min([*ends, 0])}")


def _is_more_than_zero(number: str) -> bool:
    """Whether a number is none of zero, which has no exponent of its own: ``0.00e+00``."""
    return any(digit in "123456789" for digit in re.split("[eE]", number)[0])


def as_words(cells: Sequence[Any]) -> tuple[str, ...]:
    """Cells as texts; numbers with the digits that they have, which are fewer where a file stores single precision."""
    if any(isinstance(cell, str) for cell in cells):
        return tuple(cell.strip() if isinstance(cell, str) else f"{cell:.15g}" for cell in cells)
    stored = np.asarray(cells, dtype=np.float64)
    with np.errstate(over="ignore"):
        single = stored.astype(np.float32)
    if np.array_equal(single, stored, equal_nan=True):
        return tuple(f"{cell:.15g}" if float(cell).is_integer() else str(cell) for cell in single)
    return tuple(f"{cell:.15g}" for cell in cells)


def as_numbers(words: Sequence[str]) -> Floats | None:
    """Words as numbers, where each of them is one or empty."""
    try:
        values = np.array([float(word) if word else np.nan for word in words])
    except ValueError:
        return None
    return None if np.isnan(values).all() else values
