"""Whether a campaign that names no data of others holds some all the same (ISO/IEC 17025:2017, 7.8.2.1 p)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign


def contradictions(campaign: Campaign) -> Iterator[str]:
    """What the file itself takes from others, where it says ``provided: none``."""
    found = tuple(_from_others(campaign)) if campaign.provided == () else ()
    if found:
        text = "provided: 'none', but the file states {found:comma}. Name who provided them, and as what."
        yield said(text, found=found)


def _from_others(campaign: Campaign) -> Iterator[str]:
    for name, sample in campaign.samples.items():
        text = "a reference value of {quantity} for {name}"
        yield from (said(text, quantity=quantity, name=name) for quantity in sample.references)
    own = campaign.laboratory.name if campaign.laboratory else ""
    for name, instrument in campaign.instruments.items():
        certificate = instrument.certificate
        if certificate is not None and certificate.laboratory and certificate.laboratory != own:
            text = "the calibration of {name} by {laboratory}"
            yield said(text, name=name, laboratory=certificate.laboratory)
    if campaign.reconstructed:
        yield said("reconstructed readings")
