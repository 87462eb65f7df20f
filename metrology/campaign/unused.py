"""Uncertainties that a campaign file states where the value alone is used: none is dropped without a word."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from metrology.declaration.document import Place
from metrology.declaration.quantity import Stated, ValueOnly


def unused(campaign: BaseModel) -> Iterator[tuple[Place, str]]:
    """Place of every quantity with an uncertainty that acts on no result, and a sentence on it."""
    for place, stated, marked in _quantities(campaign, (), None):
        if marked is not None and not stated.is_exact:
            instead = f" State it as {marked.instead}." if marked.instead else ""
            yield place, f"of '{stated.value}' the value alone is used; its uncertainty acts on no result.{instead}"


def _quantities(found: Any, place: Place, marked: ValueOnly | None) -> Iterator[tuple[Place, Stated, ValueOnly | None]]:
    """Every quantity below an entry, with the mark of its field."""
    if isinstance(found, Stated):
        yield place, found, marked
    elif isinstance(found, BaseModel):
        for name, field in type(found).model_fields.items():
            yield from _quantities(getattr(found, name), (*place, field.alias or name), _mark(field))
    elif isinstance(found, Mapping):
        for key, one in found.items():
            yield from _quantities(one, (*place, key), marked)
    elif isinstance(found, tuple):
        for at, one in enumerate(found):
            yield from _quantities(one, (*place, at), marked)


def _mark(field: FieldInfo) -> ValueOnly | None:
    return next((one for one in field.metadata if isinstance(one, ValueOnly)), None)
