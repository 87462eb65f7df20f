"""Scalars of a campaign file: every text is read by the field that receives it, and by nothing else."""

from __future__ import annotations

import copyreg
import re
from collections.abc import Callable, Mapping
from datetime import date
from math import inf
from types import MappingProxyType
from typing import Annotated, Any, TypeVar
from unicodedata import normalize

from pydantic import AfterValidator, BeforeValidator, ValidatorFunctionWrapHandler, WithJsonSchema, WrapValidator

from metrology.declaration.entry import Refusal, refuse, show
from metrology.expression.syntax import LETTERS
from metrology.units import LARGEST
from metrology.units.dimensions import quoted

T = TypeVar("T")
MAX_TEXT = 10_000
MAX_NAME = 64
MAX_DIGITS = 18


def _is_text(value: Any) -> str:
    if not isinstance(value, str):
        raise refuse(Refusal((), show(value), "a text"))
    if len(value) > MAX_TEXT:
        raise refuse(Refusal((), f"a text of {len(value)} characters", f"at most {MAX_TEXT}"))
    return normalize("NFC", value.strip())


def _filled(value: str) -> str:
    if not value:
        raise refuse(Refusal((), "an empty text", "a text that says something"))
    return value


def _short(value: str) -> str:
    """Refuse a name that is too long for the files which are named after it."""
    if len(value) > MAX_NAME:
        raise refuse(Refusal((), f"a name of {len(value)} characters", f"a name of at most {MAX_NAME}"))
    return value


def matching(pattern: str, expected: str) -> Callable[[str], str]:
    """Make a validator: the whole text matches `pattern`."""
    compiled = re.compile(pattern, re.ASCII)

    def check(value: str) -> str:
        if not compiled.fullmatch(value):
            raise refuse(Refusal((), quoted(value), expected))
        return value

    return check


def _number(value: Any) -> Any:
    if isinstance(value, str):
        _check_number(value)
        value = float(value)
        if abs(value) > LARGEST:
            raise refuse(Refusal((), "a number that is too large", f"a number up to {LARGEST:g}"))
        return value
    raise refuse(Refusal((), show(value), "a number, such as '2.5'"))


_check_number = matching(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?", "a number with a decimal point, such as '2.5'")


def _integer(value: Any) -> Any:
    if not isinstance(value, str):
        raise refuse(Refusal((), show(value), "a whole number, such as '3'"))
    _check_integer(value)
    if len(value) > MAX_DIGITS:
        raise refuse(Refusal((), quoted(value), f"a whole number from 0 to {10**MAX_DIGITS - 1}"))
    return int(value)


_check_integer = matching(r"0|[1-9]\d*", "a whole number without leading zeros, such as '20261120'")


def _flag(value: Any) -> Any:
    if value not in ("true", "false"):
        raise refuse(Refusal((), show(value), "true or false"))
    return value == "true"


def _date(value: Any) -> Any:
    text = _is_text(value)
    expected = "a date as year-month-day, such as '2026-10-05'"
    if not re.fullmatch(r"\d{4}-\d{2}-\d{2}", text, re.ASCII):
        raise refuse(Refusal((), quoted(text), expected))
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise refuse(Refusal((), f"{quoted(text)}, a day that no calendar has", expected)) from None


def ranged(low: float, high: float, expected: str, *, closed: bool = False) -> WrapValidator:
    """Make a validator: low < number < high, or with the ends where `closed`; a refusal quotes what is written."""

    def check(written: Any, read: ValidatorFunctionWrapHandler) -> Any:
        value = read(written)
        if not (low <= value <= high if closed else low < value < high):
            raise refuse(Refusal((), quoted(written), expected))
        return value

    return WrapValidator(check)


_TEXT_SCHEMA = {"type": ["string", "number"]}
_WORD = rf"^[{LETTERS}][{LETTERS}0-9_-]{{0,{MAX_NAME - 1}}}$"
_SYMBOL = f"^[{LETTERS}][{LETTERS}0-9_]{{0,{MAX_NAME - 1}}}$"
_REFERENCE = rf"^[{LETTERS}][{LETTERS}0-9_-]*(\.[{LETTERS}0-9_-]+)*$"

Text = Annotated[str, BeforeValidator(_is_text), WithJsonSchema(_TEXT_SCHEMA)]
Filled = Annotated[Text, AfterValidator(_filled)]
Id = Annotated[
    str,
    BeforeValidator(_is_text),
    AfterValidator(_short),
    AfterValidator(matching(_WORD[1:-1], "a name of letters, digits, '-' and '_' that begins with a letter")),
    WithJsonSchema({"type": "string", "pattern": _WORD}),
]
"""Name of a sample, test, instrument: ``al-1100``."""
Symbol = Annotated[
    str,
    BeforeValidator(_is_text),
    AfterValidator(_short),
    AfterValidator(matching(_SYMBOL[1:-1], "a name of letters, digits and '_' that begins with a letter")),
    WithJsonSchema({"type": "string", "pattern": _SYMBOL}),
]
"""Name that can stand in an expression: ``k_static``."""
Reference = Annotated[
    str,
    BeforeValidator(_is_text),
    AfterValidator(
        matching(_REFERENCE[1:-1], "the name of a quantity, such as 'al-1100.length' or 'al-1100-elongation.k'")
    ),
    WithJsonSchema({"type": "string", "pattern": _REFERENCE}),
]
"""Full name of a quantity: ``al-1100-elongation.k``."""
Country = Annotated[
    str,
    BeforeValidator(_is_text),
    AfterValidator(matching("|[A-Z]{2}", "two capital letters of ISO 3166-1, such as 'IT'")),
    WithJsonSchema({"type": "string", "pattern": "^([A-Z]{2})?$"}),
]
Number = Annotated[float, BeforeValidator(_number)]
Integer = Annotated[int, BeforeValidator(_integer)]
Day = Annotated[date, BeforeValidator(_date), WithJsonSchema({"type": "string", "format": "date"})]
Probability = Annotated[Number, ranged(0, 1, "a probability between 0 and 1, such as '0.95'")]
Flag = Annotated[bool, BeforeValidator(_flag)]
Positive = Annotated[Number, ranged(0, inf, "a number greater than zero")]
Coefficient = Annotated[Number, ranged(-1, 1, "a correlation coefficient between -1 and 1, such as '0.9'")]
"""Of two quantities; at −1 or 1 they would be one quantity."""


def _table(content: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(content)


# Python pickles and copies none of them by itself, and so no campaign, nor its results.
copyreg.pickle(MappingProxyType, lambda table: (_table, (dict(table),)))
Table = Annotated[Mapping[Id, T], AfterValidator(MappingProxyType)]
SymbolTable = Annotated[Mapping[Symbol, T], AfterValidator(MappingProxyType)]
