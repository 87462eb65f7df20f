"""Read a campaign file and everything that it names: `load` returns a campaign without faults, or tells all of them at once."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from metrology.campaign.document import Document, Place
from metrology.campaign.document import read as read_document
from metrology.campaign.entry import refusals
from metrology.campaign.schema import Campaign
from metrology.errors import Fault, MetrologyError


def load(path: Path | str) -> Campaign:
    """Return the campaign that the file `path` declares.

    Raises
    ------
    MetrologyError
        Every fault of the file and of the readings that it names, in the order of the file.
    """
    document = read_document(Path(path))
    try:
        campaign = Campaign.model_validate(document.data)
    except ValidationError as error:
        faults = [
            (document.order(r.loc), _fault(document, r.loc, r.got, r.expected, r.mend))
            for r in refusals(error)
            if not document.is_spoiled(r.loc)
        ]
        faults.sort(key=lambda pair: pair[0])
        raise MetrologyError(*document.faults, *(fault for _, fault in faults)) from None
    if document.faults:
        raise MetrologyError(*document.faults)
    campaign._document = document
    return campaign


def _fault(document: Document, place: Place, got: str, expected: str, mend: str) -> Fault:
    return Fault(document.at(*place), got, expected, mend)
