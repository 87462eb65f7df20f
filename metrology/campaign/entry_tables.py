"""Tables of the keys of a campaign file's entries, as Markdown."""

from __future__ import annotations

from collections.abc import Iterator
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from metrology.declaration import quantity
from metrology.declaration.entry import Entry

_NO_DEFAULT: tuple[Any, ...] = (None, "", (), {})
_SIMPLE = {str: "text", float: "number", int: "whole number", bool: "true or false"}


def tables(entries: tuple[type[Entry], ...]) -> Iterator[str]:
    """Table of the keys of each entry, below what the entry is."""
    for entry in entries:
        about = (entry.__doc__ or "").strip().partition("\n")[0]
        rows = [_row(field.alias or name, field) for name, field in entry.model_fields.items()]
        yield "\n".join(
            [f"**{about}**", "", "| key | meaning | value | default | example |", "|---|---|---|---|---|", *rows]
        )


def _row(name: str, field: FieldInfo) -> str:
    default = "**required**" if field.is_required() else _default(field.get_default(call_default_factory=True))
    example = f"`{field.examples[0]}`" if field.examples else ""
    cells = (f"`{name}`", field.description or "", _value(field), default, example)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _default(value: Any) -> str:
    if value is PydanticUndefined or value in _NO_DEFAULT:
        return ""
    written = _written(value)
    return f"`{written}`" if written not in ("", "{}") else ""


def _written(value: Any) -> str:
    """A default as a user would write it."""
    if isinstance(value, quantity.Stated):
        return value.value
    if isinstance(value, Entry):
        entries = ((key, getattr(value, key)) for key in type(value).model_fields)
        return f"{{{', '.join(f'{key}: {_written(entry)}' for key, entry in entries if entry not in _NO_DEFAULT)}}}"
    if isinstance(value, tuple):
        return f"[{', '.join(map(_written, value))}]"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _value(field: FieldInfo) -> str:
    """The kind of value in words, with the unit of the dimension that is due."""
    unit = (field.json_schema_extra or {}).get("x-unit") if isinstance(field.json_schema_extra, dict) else None
    kind = _kind(field.annotation)
    return f"{kind} in `{unit}`" if unit else kind


def _kind(annotation: Any) -> str:
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        units = [extra.json_schema_extra["x-unit"] for extra in arguments[1:] if _has_unit(extra)]
        return _kind(arguments[0]) + (f" in `{units[0]}`" if units else "")
    if origin in (Union, UnionType):
        kinds = dict.fromkeys(_kind(argument) for argument in arguments if argument is not type(None))
        return " or ".join(kinds)
    if origin is tuple:
        return f"list of {_kind(arguments[0])}"
    if origin is not None and hasattr(origin, "keys"):
        return f"{_kind(arguments[1])} by name"
    if origin is not None:
        return ", ".join(f"`{argument}`" for argument in arguments)
    if isinstance(annotation, type) and issubclass(annotation, quantity.Stated):
        return "quantity"
    if isinstance(annotation, type) and issubclass(annotation, Entry):
        return "mapping"
    return _SIMPLE.get(annotation, "date")


def _has_unit(extra: Any) -> bool:
    return (
        isinstance(extra, FieldInfo)
        and isinstance(extra.json_schema_extra, dict)
        and "x-unit" in extra.json_schema_extra
    )
