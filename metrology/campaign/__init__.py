"""The declarative campaign file and its data: schema, strict loading, checks.

`load(path)` returns a `Campaign` (attributes: see `metrology.campaign.schema`), `schema_json()` its JSON Schema,
`reference()` the documentation of the file, and `create(name, folder)` writes a starter campaign.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from metrology.campaign.documentation import reference
    from metrology.campaign.loader import load
    from metrology.campaign.schema import Campaign, schema_json
    from metrology.campaign.starter import create

__all__ = ["Campaign", "create", "load", "reference", "schema_json"]
_HOMES = {
    "Campaign": "schema",
    "create": "starter",
    "load": "loader",
    "reference": "documentation",
    "schema_json": "schema",
}


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is asked for."""
    if name not in _HOMES:
        raise AttributeError(name)
    from importlib import import_module

    return getattr(import_module(f"metrology.campaign.{_HOMES[name]}"), name)
