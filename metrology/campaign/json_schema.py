"""The JSON Schema of campaign files."""

from __future__ import annotations

from typing import Any

from metrology.campaign.schema import Campaign

TITLE = "Campaign file of the metrology package"


def schema() -> dict[str, Any]:
    """Return the JSON Schema of campaign files."""
    body = Campaign.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **body, "title": TITLE}


def schema_json() -> str:
    """Return the JSON Schema of campaign files as text: `docs/campaign.schema.json`."""
    import json

    return json.dumps(schema(), indent=1, ensure_ascii=False, sort_keys=False) + "\n"
