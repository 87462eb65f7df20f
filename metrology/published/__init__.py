"""The JSON Schema of `results.json`, as it is published: `docs/results.schema.json`; every field says what it is."""

from __future__ import annotations

import re
from typing import Any

from metrology.findings import SCHEMA, json_schema
from metrology.published.words import WORDS

__all__ = ["WORDS", "described", "schema", "schema_json"]

TITLE = "Results of a campaign"
_NO_NUMBER = {"enum": ["NaN", "Infinity", "-Infinity"]}
"""What `to_json` writes where JSON has no word for a number."""


def schema() -> dict[str, Any]:
    """Return the JSON Schema of `results.json`."""
    from pydantic import TypeAdapter

    from metrology.verify.finding import VerificationFinding

    body = json_schema()
    entry = TypeAdapter(VerificationFinding).json_schema(mode="serialization")
    body["$defs"] |= entry.pop("$defs") | {"VerificationFinding": entry}
    body["properties"]["verification"]["items"] = {"$ref": "#/$defs/VerificationFinding"}
    body["properties"]["schema"] = {"const": SCHEMA}
    for name, definition in {**body["$defs"], "Findings": body}.items():
        _describe(name, definition)
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": TITLE}
    whole: dict[str, Any] = _with_all_numbers({**head, **{key: body[key] for key in body if key != "title"}})
    return whole


def schema_json() -> str:
    """Return the JSON Schema of `results.json` as text: `docs/results.schema.json`."""
    import json

    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def described(of: str, about: str, field: str) -> str:
    """Return what a field is: as its class says, else by the table of words; empty where neither does.

    Parameters
    ----------
    of, about : str
        Name and docstring of the class.
    field : str
        Such as ``u``.
    """
    if own := WORDS.get(f"{of}.{field}"):
        return own
    clauses = re.split(r"(?<=[.;])\s+", " ".join(about.split()))
    return next((clause for clause in clauses if f"`{field}`" in clause), "") or WORDS.get(field, "")


def _describe(of: str, definition: dict[str, Any]) -> None:
    about = definition.get("description", "")
    for field, body in definition.get("properties", {}).items():
        body.pop("title", None)
        if text := described(of, about, field):
            body["description"] = text


def _with_all_numbers(body: Any) -> Any:
    """Allow the words for a number that does not exist wherever a number stands."""
    if isinstance(body, list):
        return [_with_all_numbers(entry) for entry in body]
    if not isinstance(body, dict):
        return body
    whole = {key: _with_all_numbers(entry) for key, entry in body.items()}
    if whole.get("type") != "number":
        return whole
    kept = {key: whole.pop(key) for key in ("description", "default") if key in whole}
    return {**kept, "anyOf": [whole, _NO_NUMBER]}
