"""The bytes of every file that went into a campaign, for the report that carries them."""

from __future__ import annotations

from hashlib import sha256
from typing import TYPE_CHECKING

from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign


def read_sources(campaign: Campaign) -> dict[str, bytes]:
    """Return the content of the campaign file and of its readings, by their path in `Campaign.files`.

    Raises
    ------
    MetrologyError
        For a file that is no longer the one that was loaded.
    """
    own, *readings = campaign.files
    assert campaign._document is not None
    contents = {own.path: campaign._document.raw}
    faults = []
    for file in readings:
        carried = campaign.attached if file.path in campaign.attached else campaign.look
        if file.path in carried:
            contents[file.path] = carried[file.path]
            continue
        path = campaign.folder / file.path
        try:
            contents[file.path] = path.read_bytes()
        except OSError as error:
            faults.append(Fault(str(path), f"a file that cannot be read ({error.strerror})", "the file evaluated"))
            continue
        if sha256(contents[file.path]).hexdigest() != file.sha256:
            got = "a file that changed while it was evaluated"
            faults.append(Fault(str(path), got, "readings that stay as they are", "make the report anew"))
    if faults:
        raise MetrologyError(*faults)
    return contents
