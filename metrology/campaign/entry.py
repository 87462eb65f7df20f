"""What every entry of a campaign file has in common: strict keys, texts read by the field that receives them, faults that mend."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date
from math import isfinite
from types import MappingProxyType
from typing import Annotated, Any, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from metrology.dimensions import TextError, quoted

T = TypeVar("T")
Loc = tuple[int | str, ...]
MAX_TEXT = 10_000


@dataclass(frozen=True)
class Refusal:
    """A fault before its place in the file is known: `loc` is relative to the entry that refuses."""

    loc: Loc
    got: str
    expected: str
    mend: str = ""


def refuse(*refusals: Refusal) -> ValidationError:
    """One exception for several refusals."""
    return ValidationError.from_exception_data("entry", [_detail(refusal) for refusal in refusals])


def _detail(refusal: Refusal) -> InitErrorDetails:
    facts = {"got": refusal.got, "expected": refusal.expected, "mend": refusal.mend}
    return InitErrorDetails(
        type=PydanticCustomError("fault", "{got}; {expected}; {mend}", facts), loc=refusal.loc, input=None
    )


def refusals(error: ValidationError, fields: Mapping[str, Any] | None = None) -> list[Refusal]:
    """Refusals of a validation error; `fields` are those of the entry whose own keys it judges."""
    return [_refusal(dict(row), fields or {}) for row in error.errors(include_url=False)]


def _refusal(row: dict[str, Any], fields: Mapping[str, Any]) -> Refusal:
    loc, facts = row["loc"], row.get("ctx", {})
    if row["type"] == "fault":
        return Refusal(loc, facts["got"], facts["expected"], facts["mend"])
    if row["type"] == "extra_forbidden":
        return _unknown_key(loc, fields)
    if row["type"] == "missing":
        about = fields.get(str(loc[-1]))
        return Refusal(loc, f"no '{loc[-1]}'", _describe(str(loc[-1]), about))
    if row["type"] == "union_tag_not_found":
        key = facts["discriminator"].strip("'")
        return Refusal((*loc, key), f"no '{key}'", f"'{key}': one of the documented ones")
    if row["type"] == "union_tag_invalid":
        near = mean(facts["tag"], facts["expected_tags"].replace("'", "").split(", "))
        return Refusal(
            (*loc, facts["discriminator"].strip("'")), quoted(facts["tag"]), f"one of {facts['expected_tags']}", near
        )
    if row["type"] == "literal_error":
        choices = facts["expected"].replace("'", "").replace(" or ", ", ").split(", ")
        return Refusal(loc, show(row["input"]), facts["expected"], mean(str(row["input"]), choices))
    expected = _KINDS.get(row["type"]) or row["msg"][0].lower() + row["msg"][1:]
    return Refusal(loc, show(row["input"]), expected)


_KINDS = {
    "dict_type": "a mapping of 'key: value' entries",
    "model_type": "a mapping of 'key: value' entries",
    "model_attributes_type": "a mapping of 'key: value' entries",
    "tuple_type": "a list: '[first, second]', or lines that begin with '- '",
    "string_type": "a text",
}


def _unknown_key(loc: Loc, fields: Mapping[str, Any]) -> Refusal:
    near = mean(str(loc[-1]), list(fields))
    return Refusal(
        loc, f"'{loc[-1]}', an unknown key", f"one of {', '.join(fields)}" if fields else "a known key", near
    )


def mean(word: str, choices: list[str]) -> str:
    """``did you mean 'length'?`` where one of `choices` is close to `word`, else nothing."""
    from difflib import get_close_matches

    folded = {choice.casefold(): choice for choice in choices}
    near = get_close_matches(word.casefold(), list(folded), n=1)
    return f"did you mean '{folded[near[0]]}'?" if near else ""


def _describe(name: str, field: Any) -> str:
    if field is None:
        return f"'{name}'"
    example = f", such as '{field.examples[0]}'" if field.examples and isinstance(field.examples[0], str) else ""
    return f"'{name}': {field.description or 'a value'}".rstrip(".") + example


def show(value: Any) -> str:
    """What was found, as a message quotes it."""
    if isinstance(value, Mapping):
        return "a mapping" if value else "an empty mapping"
    if isinstance(value, list | tuple):
        return "a list" if value else "an empty list"
    return quoted(value)


class Entry(BaseModel):
    """A mapping of the file: unknown keys are faults, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    @model_validator(mode="wrap")
    @classmethod
    def _judge(cls, data: Any, handler: ModelWrapValidatorHandler[Any]) -> Any:
        try:
            return handler(data)
        except ValidationError as error:
            raise refuse(*refusals(error, cls.model_fields)) from None


def _is_text(value: Any) -> str:
    if not isinstance(value, str):
        raise refuse(Refusal((), show(value), "a text"))
    if len(value) > MAX_TEXT:
        raise refuse(Refusal((), f"a text of {len(value)} characters", f"at most {MAX_TEXT}"))
    return value.strip()


def _filled(value: str) -> str:
    if not value:
        raise refuse(Refusal((), "an empty text", "a text that says something"))
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
        if not isfinite(value):
            raise refuse(Refusal((), "a number that is too large", "a finite number"))
        return value
    raise refuse(Refusal((), show(value), "a number, such as '2.5'"))


_check_number = matching(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?", "a number with a decimal point, such as '2.5'")


def _integer(value: Any) -> Any:
    if not isinstance(value, str):
        raise refuse(Refusal((), show(value), "a whole number, such as '3'"))
    _check_integer(value)
    return int(value)


_check_integer = matching(r"0|[1-9]\d{0,17}", "a whole number without leading zeros, such as '20261120'")


def _date(value: Any) -> Any:
    text = _is_text(value)
    expected = "a date as year-month-day, such as '2026-10-05'"
    if not re.fullmatch(r"\d{4}-\d{2}-\d{2}", text, re.ASCII):
        raise refuse(Refusal((), quoted(text), expected))
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise refuse(Refusal((), f"{quoted(text)}, a day that no calendar has", expected)) from None


def ranged(low: float, high: float, expected: str, *, closed: bool = False) -> Callable[[float], float]:
    """Make a validator: low < number < high, or with the ends where `closed`."""

    def check(value: float) -> float:
        if not (low <= value <= high if closed else low < value < high):
            raise refuse(Refusal((), quoted(f"{value:g}"), expected))
        return value

    return check


_TEXT_SCHEMA = {"type": ["string", "number"]}
_WORD = r"^[A-Za-z][A-Za-z0-9_-]*$"
_SYMBOL = r"^[A-Za-z][A-Za-z0-9_]*$"
_REFERENCE = r"^[A-Za-z][A-Za-z0-9_-]*(\.[A-Za-z][A-Za-z0-9_-]*)*$"

Text = Annotated[str, BeforeValidator(_is_text), WithJsonSchema(_TEXT_SCHEMA)]
Filled = Annotated[Text, AfterValidator(_filled)]
Id = Annotated[
    str,
    BeforeValidator(_is_text),
    AfterValidator(matching(_WORD[1:-1], "a name of letters, digits, '-' and '_' that begins with a letter")),
    WithJsonSchema({"type": "string", "pattern": _WORD}),
]
"""Name of a sample, test, instrument: ``al-1100``."""
Symbol = Annotated[
    str,
    BeforeValidator(_is_text),
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
Number = Annotated[float, BeforeValidator(_number)]
Integer = Annotated[int, BeforeValidator(_integer)]
Day = Annotated[date, BeforeValidator(_date), WithJsonSchema({"type": "string", "format": "date"})]
Probability = Annotated[Number, AfterValidator(ranged(0, 1, "a probability between 0 and 1, such as '0.95'"))]
Positive = Annotated[Number, AfterValidator(ranged(0, float("inf"), "a number greater than zero"))]
Coefficient = Annotated[
    Number, AfterValidator(ranged(-1, 1, "a correlation coefficient from -1 to 1, such as '0.9'", closed=True))
]
Table = Annotated[Mapping[Id, T], AfterValidator(MappingProxyType)]
SymbolTable = Annotated[Mapping[Symbol, T], AfterValidator(MappingProxyType)]


def from_text(error: TextError, *loc: int | str) -> Refusal:
    """Refusal of a text that could not be read."""
    return Refusal(loc, error.got, error.expected, error.mend)
