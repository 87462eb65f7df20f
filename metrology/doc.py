"""What a field is, said where the field stands: ``u: Annotated[float, Doc("Standard uncertainty, in SI.")]``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Doc:
    """One or two sentences on a field; pydantic takes them over as its description in a JSON Schema.

    Parameters
    ----------
    text : str
        Plain text, numbers with their unit.
    """

    text: str

    def __get_pydantic_json_schema__(self, core: Any, handler: Callable[[Any], dict[str, Any]]) -> dict[str, Any]:
        """Add the text to the schema of the field, without an import of pydantic here."""
        return {**handler(core), "description": self.text}
