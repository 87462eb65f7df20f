"""The JSON Schema of campaign files."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from metrology.methods import METHODS

if TYPE_CHECKING:
    from metrology.declaration.conduct import Test as AnyTest
if not TYPE_CHECKING:
    AnyTest = Annotated[reduce(or_, (method.test for method in METHODS.values())), Field(discriminator="method")]
    """A test by any of the methods, which its key `method` names."""
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
