"""The declarative campaign file and its data: schema, strict loading, checks.

`load.load(path)` returns a `Campaign` (attributes: see `schema`), `schema.schema_json()` its JSON Schema,
`documentation.reference()` the documentation of the file, and `starter.create(name, folder)` writes a starter campaign.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign

__all__ = ["Campaign"]


def __getattr__(name: str) -> Any:
    """Import the class when it is asked for, so that the package itself costs nothing."""
    if name == "Campaign":
        from metrology.campaign.schema import Campaign

        return Campaign
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
