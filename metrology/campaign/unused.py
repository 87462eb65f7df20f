"""Uncertainties, and corrections, that a campaign file states where they act on nothing: none is dropped silently."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from metrology.declaration.document import Place
from metrology.declaration.quantity import Stated, ValueOnly
from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign


def unused(campaign: BaseModel) -> Iterator[tuple[Place, str]]:
    """Place of every quantity with an uncertainty that acts on no result, and a sentence on it."""
    for place, stated, marked in _quantities(campaign, (), None):
        if marked is not None and not stated.is_exact:
            text = (
                "of '{value}' the value alone is used; its uncertainty acts on no result. State it as {instead}."
                if marked.instead
                else "of '{value}' the value alone is used; its uncertainty acts on no result."
            )
            yield place, said(text, value=stated.value, instead=marked.instead)


def idle(campaign: Campaign) -> Iterator[tuple[Place, str]]:
    """Place of every correction of an instrument whose readings a test takes as they are, and a sentence on it."""
    for name, test in campaign.tests.items():
        for role, instrument in test.instruments:
            declared = campaign.instruments.get(instrument) if instrument else None
            stated = declared.correction if declared else None
            if stated is None or role in getattr(test.instruments, "CORRECTED", ()):
                continue
            if stated.value is None or stated.value.si:
                text = (
                    "the readings of test '{name}' are not corrected by it, as its method takes none. Correct them "
                    "before, and state 0 here."
                )
                yield ("instruments", instrument, "correction"), said(text, name=name)


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
