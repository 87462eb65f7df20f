"""What every entry of a campaign file has in common: strict keys, frozen values, and faults that say how to fix."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from metrology.units.dimensions import TextError, quoted

Loc = tuple[int | str, ...]


@dataclass(frozen=True)
class Refusal:
    """A fault before its place in the file is known: `loc` is relative to the entry that refuses.

    `missing` is the name that was not found, where that is the fault; `of_key` says that the key is at fault, not its
    value. `swap` is the part of what is written that is wrong, and what it has to be, where nothing else can be meant.
    """

    loc: Loc
    got: str
    expected: str
    fix: str = ""
    missing: str = ""
    of_key: bool = False
    swap: tuple[str, str] | None = None


def refuse(*refusals: Refusal) -> ValidationError:
    """One exception for several refusals."""
    return ValidationError.from_exception_data("entry", [_detail(refusal) for refusal in refusals])


def one_of(entry: BaseModel, first: str, second: str, expected: str) -> None:
    """Refuse an entry that has both of two keys, or neither."""
    given = getattr(entry, first) is not None
    if given == (getattr(entry, second) is not None):
        got = f"'{first}' and '{second}' together" if given else f"neither '{first}' nor '{second}'"
        raise refuse(Refusal((), got, expected))


def _detail(refusal: Refusal) -> InitErrorDetails:
    facts = {name: getattr(refusal, name) for name in ("got", "expected", "fix", "of_key", "swap")}
    return InitErrorDetails(
        type=PydanticCustomError("fault", "{got}; {expected}; {fix}", facts), loc=refusal.loc, input=None
    )


def refusals(error: ValidationError, fields: Mapping[str, Any] | None = None) -> list[Refusal]:
    """Refusals of a validation error; `fields` are those of the entry whose own keys it judges."""
    rows: list[dict[str, Any]] = [dict(row) for row in error.errors(include_url=False)]
    # An entry that is refused is missing in its list, which is then too short for that reason alone.
    within = {row["loc"][: len(row["loc"]) - 1] for row in rows}
    return [_refusal(row, fields or {}) for row in rows if row["type"] != "too_short" or row["loc"] not in within]


def _refusal(row: dict[str, Any], fields: Mapping[str, Any]) -> Refusal:
    loc, facts, found = row["loc"], row.get("ctx", {}), row["input"]
    match row["type"]:
        case "fault":
            return Refusal(loc, facts["got"], facts["expected"], facts["fix"], "", facts["of_key"], facts["swap"])
        case "extra_forbidden":
            return _unknown_key(loc, fields)
        case "missing":
            return Refusal(loc, f"no '{loc[-1]}'", _describe(str(loc[-1]), fields.get(str(loc[-1]))))
        case "union_tag_not_found":
            key = facts["discriminator"].strip("'")
            near = close_to(key, [str(one) for one in found]) if isinstance(found, Mapping) else []
            fix = f"did you mean '{key}' by '{near[0]}'?" if near else ""
            return Refusal((*loc, key), f"no '{key}'", f"'{key}', which says what the entry is", fix)
        case "union_tag_invalid":
            return _no_choice((*loc, facts["discriminator"].strip("'")), facts["tag"], facts["expected_tags"])
        case "literal_error":
            return _no_choice(loc, found, facts["expected"].replace(" or ", ", "))
    return Refusal(loc, show(found), _KINDS.get(row["type"], row["msg"]))


def _no_choice(loc: Loc, found: Any, choices: str) -> Refusal:
    """Refusal of a word that is none of `choices`, which pydantic writes as ``'a', 'b'``."""
    words = choices.replace("'", "").split(", ")
    if len(words) == 1:
        return Refusal(loc, show(found), choices)
    return Refusal(loc, show(found), f"one of {choices}", mean(found, words) if isinstance(found, str) else "")


_KINDS = {
    "dict_type": "a mapping of 'key: value' entries",
    "mapping_type": "a mapping of 'key: value' entries",
    "model_type": "a mapping of 'key: value' entries",
    "model_attributes_type": "a mapping of 'key: value' entries",
    "tuple_type": "a list: '[first, second]', or lines that begin with '- '",
    "too_long": "two entries",
    "too_short": "one entry at least",
    "string_type": "a text",
}


def _unknown_key(loc: Loc, fields: Mapping[str, Any]) -> Refusal:
    key, known = str(loc[-1]), list(fields)
    close = close_to(key, known)
    swap = (key, close[0]) if len(close) == 1 else None
    got, expected = f"'{key}', an unknown key", f"one of {', '.join(known)}"
    return Refusal(loc, got, expected, mean(key, known), of_key=True, swap=swap)


def mean(word: str, choices: list[str]) -> str:
    """``did you mean 'length'?`` where one of `choices` is close to `word`, else nothing."""
    near = close_to(word, choices)
    return f"did you mean '{near[0]}'?" if near else ""


def close_to(word: str, choices: list[str]) -> list[str]:
    """Return the `choices` that `word` may be a slip for, the closest first."""
    from difflib import get_close_matches

    folded = {choice.casefold(): choice for choice in choices}
    return [folded[near] for near in get_close_matches(word.casefold(), list(folded))]


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

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True)

    @model_validator(mode="wrap")
    @classmethod
    def _judge(cls, data: Any, handler: ModelWrapValidatorHandler[Any]) -> Any:
        try:
            return handler(data)
        except ValidationError as error:
            fields = {field.alias or name: field for name, field in cls.model_fields.items()}
            raise refuse(*refusals(error, fields)) from None


def from_text(error: TextError, *loc: int | str) -> Refusal:
    """Refusal of a text that could not be read."""
    return Refusal(loc, error.got, error.expected, error.fix, swap=error.swap)


def unknown(word: str, choices: list[str], what: str, *place: str | int) -> Iterator[Refusal]:
    """Refuse a name that stands for nothing, with the one that is probably meant."""
    if word not in choices:
        near = mean(word, choices) or (f"known are {', '.join(choices[:12])}" if choices else f"no {what} is declared")
        yield Refusal(
            place,
            f"'{word}', an unknown {what}",
            f"the name of {'an' if what[0] in 'aeiou' else 'a'} {what} of this campaign",
            near,
            word,
        )
