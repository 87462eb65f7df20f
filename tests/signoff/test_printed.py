"""Whether a page prints a result: its value and u side by side, as they round."""

from __future__ import annotations

from typing import Any

import pytest

from metrology.signoff.printed import Number, _numbers, absent


def number(text: str) -> Number:
    return next(_numbers(text))


def result(value: float, u: float) -> dict[str, Any]:
    return {"name": "A", "value": value, "u": u, "display_unit": "mm^2", "headline": False}


@pytest.mark.parametrize(
    ("value", "u", "printed", "missing"),
    [
        (1.25e-6, 0.0, "1.25 0", False),  # a section without uncertainty, printed in full
        (1.2504e-6, 0.0, "1.25 0", True),  # rounded, to fewer digits than say anything
        (2.3561944901923448e-6, 0.0, "2.35619 0", False),
        (5.0004e-6, 0.0, "5 0", True),
        (1.2504e-6, 3e-9, "1.250 0.003", False),
        (1.2504e-6, 3e-9, "1.3 0.003", True),
        (1.2504e-6, 3e-9, "0.003 1.250", True),
        (2.0012e-3, 2.14e-4, "2000 210", False),  # zeros that are digits, as those of u show
        (2.0512e-3, 2.14e-4, "2000 210", True),
        (2.0012e-3, 2.14e-4, "2000 1000", True),
    ],
)
def test_a_result_stands_where_it_is_printed_to_the_digits_that_it_has(
    value: float, u: float, printed: str, missing: bool
) -> None:
    page = [number(text) for text in printed.split()]
    assert absent([result(value, u)], [page]) == (["A"] if missing else [])
