"""The JSON Schema of `results.json`, as it is published: `docs/results.schema.json`; every field says what it is."""

from __future__ import annotations

import re
from typing import Any

from metrology.findings import SCHEMA, json_schema

__all__ = ["schema", "schema_json"]

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
    body["properties"]["schema"] = {"const": SCHEMA, "description": body["properties"]["schema"]["description"]}
    for definition in (*body["$defs"].values(), body):
        _describe(definition)
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": TITLE}
    whole: dict[str, Any] = _with_all_numbers({**head, **{key: body[key] for key in body if key != "title"}})
    return whole


def schema_json() -> str:
    """Return the JSON Schema of `results.json` as text: `docs/results.schema.json`."""
    import json

    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def _describe(definition: dict[str, Any]) -> None:
    """Say what every field is: as the field does, else as the docstring of its class does."""
    clauses = re.split(r"(?<=[.;])\s+", " ".join(definition.get("description", "").split()))
    for field, body in definition.get("properties", {}).items():
        body.pop("title", None)
        stated = next((clause for clause in clauses if f"`{field}`" in clause), "")
        if text := body.pop("description", stated):
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
