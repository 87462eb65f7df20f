"""Who tested what for whom, with what, and what is said beside the results: the identification of a report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.doc import Doc
from metrology.message import Code

Part = Literal["certificate", "annex", "quality"]
"""A part of the report."""


@dataclass(frozen=True)
class Party:
    """The laboratory or the customer."""

    name: Annotated[str, Doc("Name.")]
    address: Annotated[str, Doc("Postal address.")] = ""
    contact: Annotated[str, Doc("Person, telephone or mail.")] = ""
    country: Annotated[str, Doc("Country, two letters of ISO 3166-1.")] = ""


@dataclass(frozen=True)
class Replaced:
    """The report that this one amends (ISO/IEC 17025:2017, 7.8.8)."""

    number: Annotated[str, Doc("Number of the document.")]
    date: Annotated[str, Doc("Its date of issue, year-month-day.")]
    reason: Annotated[str, Doc("What was changed, and why.")]


@dataclass(frozen=True)
class Signatory:
    """Who signs the report as what: `role` is ``author``, ``reviewer`` or ``approver``."""

    role: str
    name: Annotated[str, Doc("Name.")]
    function: Annotated[str, Doc("Function in the laboratory.")]


@dataclass(frozen=True)
class Provided:
    """What a customer or an external provider contributed (ISO/IEC 17025:2017, 7.8.2.1 p, 7.8.2.2)."""

    what: Annotated[str, Doc("What was provided.")]
    by: Annotated[str, Doc("Whose it is.")]
    role: Annotated[Literal["customer", "external provider"], Doc("As what it came.")]


@dataclass(frozen=True)
class Opinion:
    """An opinion or interpretation, told apart from the results (ISO/IEC 17025:2017, 7.8.7)."""

    text: Annotated[str, Doc("The opinion.")]
    by: Annotated[str, Doc("Whose it is.")]
    basis: Annotated[str, Doc("What the opinion rests on.")]


@dataclass(frozen=True)
class Anomaly:
    """A nonconformance, failure or problem (ECSS-E-ST-10-02, Annex C)."""

    id: Annotated[str, Doc("Number of the nonconformance report.")]
    text: Annotated[str, Doc("What happened.")]
    state: Annotated[Literal["open", "closed"], Doc("Whether it is closed.")]
    disposition: Annotated[str, Doc("What was decided.")] = ""


@dataclass(frozen=True)
class Document:
    """A document that the tests follow, or that the report refers to."""

    number: Annotated[str, Doc("Number of the document.")]
    title: Annotated[str, Doc("Title as the report prints it.")]
    edition: Annotated[str, Doc("Edition or issue.")]
    role: Annotated[Literal["applicable", "reference"], Doc("Whether it is binding.")]


@dataclass(frozen=True)
class InputFile:
    """A file that went in, with its hash."""

    path: Annotated[str, Doc("Path, seen from the campaign's folder.")]
    sha256: Annotated[str, Doc("SHA-256 of the content, hexadecimal.")]
    bytes: Annotated[int, Doc("Length.")]
    attached: Annotated[bool, Doc("Whether the report carries it, and not its hash alone.")] = True


@dataclass(frozen=True)
class Assumption:
    """An assumption or a constraint."""

    text: Annotated[str, Doc("The assumption.")]
    refuted: Annotated[str, Doc("The finding that refutes it; empty where none does.")] = ""


@dataclass(frozen=True)
class Image:
    """A logo or mark, whole: the report is made from the findings alone."""

    name: Annotated[str, Doc("Path, seen from the campaign's folder.")]
    base64: Annotated[str, Doc("Its content, in base64.")]

    @property
    def address(self) -> str:
        """The image as an address that holds it."""
        kind = "svg+xml" if self.name.endswith(".svg") else "png"
        return f"data:image/{kind};base64,{self.base64}"


@dataclass(frozen=True)
class Brand:
    """How the report looks."""

    logo: Annotated[Image | None, Doc("Logo; null where there is none.")] = None
    colour: Annotated[str, Doc("Colour of headings and rules, #rrggbb; empty for that of the templates.")] = ""
    letterhead: Annotated[str, Doc("Words at the head of page 1.")] = ""
    mark: Annotated[Image | None, Doc("Mark of the accreditation body.")] = None
    body: Annotated[str, Doc("Accreditation body.")] = ""
    number: Annotated[str, Doc("Number of the accreditation.")] = ""
    footer: Annotated[str, Doc("Words at the foot of every page.")] = ""


@dataclass(frozen=True)
class CampaignItem:
    """Identification of the campaign and of its report (ISO/IEC 17025:2017, 7.8.2.1).

    `stated` names the lists that the campaign states, also as "none": of the others nobody said that they are empty.
    """

    id: Annotated[str, Doc("Name in the campaign file.")]
    title: Annotated[str, Doc("Title as the report prints it.")]
    report_number: Annotated[str, Doc("Number of the report.")]
    issued: Annotated[str, Doc("Date of issue, year-month-day; empty where not stated, as all dates.")]
    laboratory: Annotated[Party, Doc("The laboratory.")]
    customer: Annotated[Party, Doc("The customer.")]
    reconstructed: Annotated[str, Doc("What the readings are where they were not measured; empty where they were.")]
    remarks: Annotated[str, Doc("Remarks on page 1.")]
    authorised_by: Annotated[str, Doc("Who authorises the report, with function.")]
    probability: Annotated[float, Doc("Coverage probability of all intervals.")]
    deviations: Annotated[tuple[str, ...], Doc("Deviations from the method, each in words.")] = ()
    checklists: Annotated[
        tuple[Literal["17025", "ecss"], ...], Doc("Standards whose checklist the report carries.")
    ] = ("17025",)
    replaces: Annotated[Replaced | None, Doc("The report that this one amends; null for a first issue.")] = None
    purpose: Annotated[str, Doc("Purpose of the tests, and the reason for them.")] = ""
    place: Annotated[str, Doc("Where the tests were made; 'laboratory' for its own address.")] = ""
    sampling: Annotated[str, Doc("Sampling plan and method; 'none' where the laboratory did not sample.")] = ""
    provided: Annotated[tuple[Provided, ...], Doc("Data of the customer and results of external providers.")] = ()
    opinions: Annotated[tuple[Opinion, ...], Doc("Opinions and interpretations, which are no results.")] = ()
    anomalies: Annotated[tuple[Anomaly, ...], Doc("Nonconformances, failures and problems.")] = ()
    assumptions: Annotated[tuple[Assumption, ...], Doc("Assumptions and constraints.")] = ()
    documents: Annotated[tuple[Document, ...], Doc("Applicable and reference documents.")] = ()
    stated: tuple[str, ...] = ()
    signatures: Annotated[tuple[Signatory, ...], Doc("Who signs the report, in which role.")] = ()
    parts: Annotated[
        tuple[Part, ...], Doc("Parts of the report that was released: certificate, annex, quality records.")
    ] = ("certificate", "annex", "quality")
    languages: Annotated[tuple[Code, ...], Doc("Languages of the certificate, the first one first.")] = ("en",)
    decimal_sign: Annotated[Literal["point", "comma"], Doc("Decimal sign of the certificate.")] = "point"
    brand: Annotated[Brand | None, Doc("How the report looks; null for the templates alone.")] = None


@dataclass(frozen=True)
class InstrumentState:
    """An instrument with its calibration state on the date of each test that used it."""

    id: Annotated[str, Doc("Name in the campaign file.")]
    kind: Annotated[str, Doc("What it is.")]
    model: Annotated[str, Doc("Manufacturer, model and class.")]
    serial: Annotated[str, Doc("Serial number.")]
    range: Annotated[str, Doc("Lowest and highest reading, as text.")]
    resolution: Annotated[str, Doc("Smallest difference that can be read, as text.")]
    certificate: Annotated[str, Doc("Number of the certificate, and who calibrated.")]
    calibrated: Annotated[str, Doc("Date of calibration.")]
    due: Annotated[str, Doc("Date by which the next calibration was due.")]
    uncertainty: Annotated[str, Doc("Expanded uncertainty of a reading with its coverage factor, as text.")]
    state: Annotated[
        Literal["valid", "overdue", "not calibrated", "not judged"],
        Doc("Calibration on the dates of the tests that used it."),
    ]
    used_by: Annotated[tuple[str, ...], Doc("Tests that used it.")]
    sentence: Annotated[str, Doc("The same in words.")] = ""


@dataclass(frozen=True)
class SampleItem:
    """A sample as the report identifies it; every property as text with unit and uncertainty."""

    id: Annotated[str, Doc("Name in the campaign file.")]
    name: Annotated[str, Doc("Name.")]
    material: Annotated[str, Doc("Material.")]
    batch: Annotated[str, Doc("Batch or heat.")]
    condition: Annotated[str, Doc("Condition on receipt.")]
    received: Annotated[str, Doc("Date of receipt.")]
    section: Annotated[str, Doc("Shape and dimensions of the section, as text.")]
    length: Annotated[str, Doc("Length, as text.")]
    linear_density: Annotated[str, Doc("Mass per length, as text.")]
    references: Annotated[tuple[str, ...], Doc("Reference values, as text.")] = ()
    configuration: Annotated[str, Doc("Configuration of the test article.")] = ""
