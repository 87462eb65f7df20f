"""JSON from outside, within limits: refused before it is taken apart where that would need too much memory or time."""

from __future__ import annotations

import errno
import json
from pathlib import Path
from typing import Any

MAX_BYTES = 64 * 1024 * 1024
MAX_ENTRIES = 4_000_000
MAX_OBJECTS = 600_000
MAX_KEYS = 10_000


def read(path: Path) -> bytes:
    """Return the content of a file, or so much of it that `check` refuses it.

    Raises
    ------
    OSError
        Where it cannot be read.
    """
    if not path.is_file() and path.exists():
        raise OSError(errno.EINVAL, "no plain file", str(path))
    with path.open("rb") as file:
        return file.read(MAX_BYTES + 1)


def check(data: bytes) -> None:
    """Refuse a text that no `results.json` of ours comes near: 800 results have 320 000 correlations, an object each.

    Raises
    ------
    ValueError
        With what is too large or too deep, or that it is no JSON.
    """
    if len(data) > MAX_BYTES:
        raise ValueError(f"a file of more than {MAX_BYTES >> 20} MiB")
    if sum(map(data.count, (b",", b"[", b"{"))) > MAX_ENTRIES:
        raise ValueError(f"a file of more than {MAX_ENTRIES} entries")
    if data.count(b"{") > MAX_OBJECTS:
        raise ValueError(f"a file of more than {MAX_OBJECTS} objects")
    try:
        json.loads(data, object_pairs_hook=_limited)
    except RecursionError:
        raise ValueError("a file that is nested too deep") from None
    except json.JSONDecodeError as error:
        raise ValueError(f"line {error.lineno}, which is no JSON ({error.msg})") from None
    except UnicodeDecodeError:
        raise ValueError("bytes that are no UTF-8") from None


def _limited(pairs: list[tuple[str, Any]]) -> None:
    """Refuse an object of too many keys; each that is not known would be told as an error of its own."""
    if len(pairs) > MAX_KEYS:
        raise ValueError(f"an object of more than {MAX_KEYS} keys")


def validator(schema: Any) -> Any:
    """Return a validator by a schema of pydantic's core that stops at the first wrong item of a sequence.

    Told one by one, what is missing in 1 MB of empty objects fills 2 GB.
    """
    from pydantic_core import SchemaValidator

    return SchemaValidator(_hasty(schema))


def validated(data: bytes, by: Any) -> Any:
    """Return what a validator makes of a text.

    Raises
    ------
    ValueError
        In one line: what `check` refuses, and the first place that is not as it should be.
    """
    from pydantic_core import ValidationError

    check(data)
    try:
        return by.validate_json(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}"[:300]) from None


def _hasty(schema: Any) -> Any:
    if isinstance(schema, dict):
        stop = {"fail_fast": True} if schema.get("type") in ("list", "tuple") else {}
        return {key: _hasty(value) for key, value in schema.items()} | stop
    if isinstance(schema, list):
        return [_hasty(entry) for entry in schema]
    return schema
