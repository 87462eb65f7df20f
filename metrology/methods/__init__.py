"""The methods of the laboratory: a module each, whose METHOD is its record; there is no list of them by hand."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from metrology.method.discovery import discover
from metrology.method.record import Method

METHODS: Mapping[str, Method[Any, Any]] = MappingProxyType(discover(__path__, __name__))
"""Every method by its word in campaign files, each after those whose results it takes."""
