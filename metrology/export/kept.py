"""Results that a report left in a file, as it wrote them."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

from metrology import audit_trail, jsontext
from metrology.errors import Fault, MetrologyError, own_text
from metrology.findings import Findings, from_json


def findings(path: Path) -> Findings:
    """Read a `results.json` that is what the last command that wrote it left, as far as an audit trail tells.

    Parameters
    ----------
    path : Path
        Of the file; the audit trail is in its folder.

    Returns
    -------
    Findings
        What the report shows.

    Raises
    ------
    MetrologyError
        For a file that was changed since, and for one that cannot be read.
    """
    try:
        content = jsontext.read(path)
        if not _is_as_written(path, content):
            got = f"content that {audit_trail.NAME} of its folder does not know"
            raise MetrologyError(Fault(str(path), got, "the file as it was written", "make the report anew"))
        return from_json(content)
    except (OSError, ValueError) as error:
        raise MetrologyError(Fault(str(path), own_text(error), "a results.json of this program")) from None


def _is_as_written(path: Path, content: bytes) -> bool:
    """Whether a file is what the last command that wrote it left; true where no audit trail tells."""
    try:
        trail = audit_trail.read(path.parent / audit_trail.NAME)
    except MetrologyError:
        return False
    except OSError:
        return True
    known = [entry.files[path.name] for entry in trail if path.name in entry.files]
    return not known or known[-1] == sha256(content).hexdigest()
