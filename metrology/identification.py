"""Who tested what for whom, with what, and what is said beside the results: the identification of a report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Party:
    """The laboratory or the customer."""

    name: str
    address: str = ""
    contact: str = ""
    country: str = ""


@dataclass(frozen=True)
class Replaced:
    """The report that this one amends (ISO/IEC 17025:2017, 7.8.8)."""

    number: str
    date: str
    reason: str


@dataclass(frozen=True)
class Signatory:
    """Who signs the report as what: `role` is ``author``, ``reviewer`` or ``approver``."""

    role: str
    name: str
    function: str


@dataclass(frozen=True)
class Provided:
    """What a customer or an external provider contributed (ISO/IEC 17025:2017, 7.8.2.1 p, 7.8.2.2)."""

    what: str
    by: str
    role: Literal["customer", "external provider"]


@dataclass(frozen=True)
class Opinion:
    """An opinion or interpretation, told apart from the results (ISO/IEC 17025:2017, 7.8.7)."""

    text: str
    by: str
    basis: str


@dataclass(frozen=True)
class Anomaly:
    """A nonconformance, failure or problem (ECSS-E-ST-10-02, Annex C)."""

    id: str
    text: str
    state: Literal["open", "closed"]
    disposition: str = ""


@dataclass(frozen=True)
class Document:
    """A document that the tests follow, or that the report refers to."""

    number: str
    title: str
    edition: str
    role: Literal["applicable", "reference"]


@dataclass(frozen=True)
class CampaignItem:
    """Identification of the campaign and of its report (ISO/IEC 17025:2017, 7.8.2.1).

    `stated` names the lists that the campaign states, also as "none": of the others nobody said that they are empty.
    """

    id: str
    title: str
    report_number: str
    issued: str
    laboratory: Party
    customer: Party
    reconstructed: str
    remarks: str
    authorised_by: str
    probability: float
    deviations: tuple[str, ...] = ()
    checklists: tuple[Literal["17025", "ecss"], ...] = ("17025",)
    replaces: Replaced | None = None
    purpose: str = ""
    place: str = ""
    sampling: str = ""
    provided: tuple[Provided, ...] = ()
    opinions: tuple[Opinion, ...] = ()
    anomalies: tuple[Anomaly, ...] = ()
    assumptions: tuple[str, ...] = ()
    documents: tuple[Document, ...] = ()
    stated: tuple[str, ...] = ()
    signatures: tuple[Signatory, ...] = ()


@dataclass(frozen=True)
class InstrumentState:
    """An instrument with its calibration state on the date of each test that used it."""

    id: str
    kind: str
    model: str
    serial: str
    range: str
    resolution: str
    certificate: str
    calibrated: str
    due: str
    uncertainty: str
    state: Literal["valid", "overdue", "not calibrated", "not judged"]
    used_by: tuple[str, ...]
    sentence: str = ""


@dataclass(frozen=True)
class SampleItem:
    """A sample as the report identifies it; every property as text with unit and uncertainty."""

    id: str
    name: str
    material: str
    batch: str
    condition: str
    received: str
    section: str
    length: str
    linear_density: str
    references: tuple[str, ...] = ()
    configuration: str = ""
