"""The decimal sign of the annex: in what its templates format as a number, and in the cells of its tables."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any

from metrology.language.display import Shown

if TYPE_CHECKING:
    from jinja2 import Environment

    from metrology.language.catalogue import Language

FORMATS = ("chance", "difference", "format", "normalised", "number", "p_value", "percent", "signed")
"""Filters that make a text of a number."""
_CELL = re.compile(r'(<td class="number[^>]*>)(.*?)(?=</td>)', re.DOTALL)


def install(environment: Environment, language: Language) -> None:
    """Let the filters of an environment that format numbers print these as the language does."""
    if language.comma:
        filters = environment.filters
        filters |= {name: localised(filters[name], language) for name in FORMATS}


def localised(function: Callable[..., Any], language: Language) -> Callable[..., Any]:
    """The function with the decimal sign of a language in the texts that it gives."""

    @wraps(function)
    def printed(*arguments: Any, **named: Any) -> Any:
        return shown(function(*arguments, **named), language)

    return printed


def shown(value: Any, language: Language) -> Any:
    """A text, or several, or a value with its u, with the decimal sign of a language."""
    if isinstance(value, str):
        return language.figures(value)
    if isinstance(value, tuple):
        return tuple(shown(one, language) for one in value)
    if isinstance(value, Shown):
        ends = {name: language.figures(getattr(value, name)) for name in ("value", "u", "low", "high")}
        return replace(value, **ends)
    return value


def cells(page: str, language: Language) -> str:
    """A section whose cells with numbers have the decimal sign of a language."""
    return _CELL.sub(lambda found: found[1] + language.figures(found[2]), page) if language.comma else page
