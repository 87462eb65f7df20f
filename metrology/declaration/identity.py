"""Who, and with what: report, laboratory, customer and instruments of a campaign file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, GetJsonSchemaHandler, PrivateAttr, field_validator, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology import units
from metrology.declaration.component import StatedComponent
from metrology.declaration.declared import Replaces
from metrology.declaration.entry import Entry, Refusal, from_text, refuse
from metrology.declaration.quantity import Stated, ValueOnly
from metrology.declaration.scalars import Country, Day, Filled, Id, Integer, Positive, Text, ranged
from metrology.declaration.signatures import Signatures
from metrology.declaration.sized import Sized, size_alone
from metrology.message import Code
from metrology.units.dimensions import TextError

if TYPE_CHECKING:
    from metrology.gum.inputs import Component

Checklist = Literal["17025", "ecss"]
Mebibytes = Annotated[Integer, ranged(1, 64, "1 to 64 MiB", closed=True)]
Part = Literal["certificate", "annex", "quality"]
PARTS: tuple[Part, ...] = ("certificate", "annex", "quality")


class Report(Entry):
    """Identification of the report (ISO/IEC 17025:2017, 7.8.2.1)."""

    number: Text = Field("", description="Unique number of the report.", examples=["TR-2026-001"])
    issued: Day | None = Field(None, description="Date of issue.", examples=["2026-11-20"])
    authorised_by: Text = Field(
        "", description="Who authorises the report, with function.", examples=["J. Doe, head of laboratory"]
    )
    remarks: Text = Field("", description="Remarks, printed on page 1.", examples=["Requested after the review."])
    checklists: tuple[Checklist, ...] = Field(
        ("17025",),
        description="Standards whose checklist the report carries as an annex; it is a draft until all that they ask "
        "is there. `17025`: ISO/IEC 17025:2017, 7.8; `ecss`: ECSS-E-ST-10-02, Annex C.",
        examples=["[17025, ecss]"],
    )
    parts: tuple[Part, ...] = Field(
        PARTS,
        description="Parts of the report: `certificate`, two pages that stand alone, which every report has; `annex`, "
        "with methods, tests, budgets and diagnosis; `quality`, the records of quality assurance. `all` for all three.",
        examples=["[certificate, annex]"],
    )
    language: tuple[Code, ...] = Field(
        ("en",),
        min_length=1,
        max_length=2,
        description="Language of the report: `en`, `de`, `fr`, `it` or `es`; or two of them, the second one beneath "
        "the first in grey on the certificate, and the annex in the first. Numbers are the same in each.",
        examples=["de", "[de, en]"],
    )
    decimal_sign: Literal["point", "comma"] = Field(
        "point",
        description="Decimal sign of the report (ISO 80000-1 has both); the data files have points.",
        examples=["comma"],
    )
    attach_up_to: Mebibytes | None = Field(
        None,
        description="Size in MiB up to which a file of readings is attached to the report; of a larger one it has the "
        "hash alone, and `metrology verify` cannot evaluate it again. All are attached where nothing is said.",
        examples=["10"],
    )
    signatures: Signatures | None = Field(
        None,
        description="Who signs the report with `metrology sign`; without it nobody can.",
        examples=["{author: {name: J. Doe, function: test engineer}, approver: {name: M. Major, function: head}}"],
    )
    replaces: Replaces | None = Field(
        None,
        description="The report that this one amends; shown on page 1.",
        examples=["{number: TR-2026-001, date: 2026-11-20, reason: mass of the plate corrected}"],
    )

    @field_validator("parts", mode="before")
    @classmethod
    def _all(cls, given: object) -> object:
        """Every part for the word `all`."""
        return PARTS if given == "all" else given

    @field_validator("language", mode="before")
    @classmethod
    def _one(cls, given: object) -> object:
        """A single language as a list of one."""
        return (given,) if isinstance(given, str) else given

    @field_validator("language")
    @classmethod
    def _each_once(cls, given: tuple[Code, ...]) -> tuple[Code, ...]:
        """Languages, each once."""
        return tuple(dict.fromkeys(given))

    @field_validator("parts")
    @classmethod
    def _with_certificate(cls, given: tuple[Part, ...]) -> tuple[Part, ...]:
        """Parts in their order, each once, the certificate always among them."""
        return tuple(part for part in PARTS if part == "certificate" or part in given)


class Party(Entry):
    """The laboratory or the customer."""

    name: Filled = Field(description="Name.", examples=["Tether Laboratory"])
    address: Text = Field("", description="Address.", examples=["1 Station Road, Exampletown"])
    contact: Text = Field("", description="Person, telephone or mail.", examples=["J. Doe"])
    country: Country = Field(
        "",
        description="Country, two letters of ISO 3166-1; needed for a digital calibration certificate.",
        examples=["IT"],
    )


class Certificate(Entry):
    """What the calibration certificate of an instrument says."""

    dcc: Filled | None = Field(
        None,
        description="Digital calibration certificate (DCC 3.x, XML) in the campaign's folder, from which all else but "
        "`due` is read; what is stated as well has to agree with it. An error of indication beyond its U is "
        "noted on page 1 where the instrument has no `correction`.",
        examples=["C-123.xml"],
    )
    quantity: Text = Field(
        "",
        description="Quantity of the certificate whose expanded uncertainty is used, by its name, `id` or `refType`; "
        "needed where it has several.",
        examples=["error of indication"],
    )
    number: Filled = Field(description="Number of the certificate.", examples=["C-123"])
    laboratory: Text = Field("", description="Who calibrated.", examples=["Calibration House, accredited"])
    date: Day = Field(description="Date of calibration.", examples=["2026-03-01"])
    due: Day | None = Field(None, description="Date by which the next one is due.", examples=["2027-03-01"])
    expanded_uncertainty: Stated | None = Field(
        None,
        description="Expanded uncertainty U of a reading, with unit: an amount (`4 um`) is independent between loads, "
        "a share of the reading (`0.2 %`) acts on all readings alike.",
        examples=["4 um"],
    )
    k: Positive = Field(2.0, description="Coverage factor of U: u = U/k.", examples=["2"])
    dof: Positive | None = Field(
        None, description="Degrees of freedom of u; infinite where nothing is said.", examples=["50"]
    )

    valid: Annotated[tuple[Stated, Stated] | None, ValueOnly()] = Field(
        None,
        description="Lowest and highest reading that was calibrated; a reading beyond them is refused, unless it is "
        "excluded.",
        examples=["[0 mm, 20 mm]"],
    )
    conditions: Text = Field("", description="Conditions of the calibration.", examples=["temperature 20.0 °C"])
    cause: Text = Field(
        "",
        description="Name under `causes`, where certificates or quantities share what they are traced to. The errors "
        "at two places of a scale remain two.",
        examples=["mass standard"],
    )

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Number and date may stand in a digital certificate."""
        shown = handler.resolve_ref_schema(handler(schema))
        shown["anyOf"] = [{"required": shown.pop("required")}, {"required": ["dcc"]}]
        return shown

    @model_validator(mode="after")
    def _in_order(self) -> Certificate:
        if self.due is not None and self.due <= self.date:
            raise refuse(Refusal(("due",), f"'{self.due}', not after the calibration of {self.date}", "a later date"))
        stated = self.expanded_uncertainty
        if stated is not None and (stated.si <= 0 or stated.quantity.u is not None or stated.uncertainty):
            raise refuse(
                Refusal(("expanded_uncertainty",), f"'{stated.value}'", "one amount greater than zero, such as '4 um'")
            )
        return self

    @property
    def u(self) -> float:
        """Standard uncertainty U/k, in SI; zero where the certificate states none."""
        return 0.0 if self.expanded_uncertainty is None else self.expanded_uncertainty.si / self.k


class Correction(Entry):
    """What is added to a reading of the instrument: a quantity, or the value of a fitted line at the reading."""

    fit: Id | None = Field(
        None, description="Name of a fit that gives the correction y at the indication x.", examples=["indicator-line"]
    )
    value: Stated | None = Field(
        None, description="A correction that is the same for all readings.", examples=["-0.002(1) mm"]
    )

    @model_validator(mode="after")
    def _one(self) -> Correction:
        if (self.fit is None) == (self.value is None):
            raise refuse(
                Refusal((), "'fit' and 'value' together" if self.fit else "neither", "either 'fit' or 'value'")
            )
        return self


class Instrument(Entry):
    """An instrument, with the state of its calibration."""

    kind: Filled = Field(description="What it is.", examples=["dial indicator"])
    manufacturer: Text = Field("", description="Manufacturer.", examples=["Acme"])
    model: Text = Field("", description="Model.", examples=["DI-25"])
    serial: Text = Field("", description="Serial number, as written on the instrument.", examples=["0123"])
    class_: Text = Field(
        "", alias="class", description="Accuracy class, such as that of a set of weights.", examples=["M1"]
    )
    range: Annotated[tuple[Stated, Stated] | None, ValueOnly()] = Field(
        None,
        description="Lowest and highest reading; a reading beyond them is refused, unless it is excluded.",
        examples=["[0 mm, 25 mm]"],
    )
    resolution: Annotated[Stated | None, ValueOnly()] = Field(
        None, description="Smallest difference that can be read.", examples=["0.01 mm"]
    )
    certificate: Certificate | None = Field(
        None,
        description="Certificate of calibration.",
        examples=["{number: C-123, date: 2026-03-01, due: 2027-03-01, expanded_uncertainty: 4 um, k: 2}"],
    )
    uncertainty: tuple[StatedComponent, ...] = Field(
        (),
        description="What else makes a reading uncertain (drift since the calibration, temperature, hysteresis, "
        "linearity), as components: an amount (`2 um`) or a share of the reading (`0.1 %`), as with the certificate.",
        examples=["[{name: drift, half_width: 2 um, distribution: rectangular, source: two calibrations}]"],
    )
    correction: Correction | None = Field(
        None, description="Correction of its readings; elongation takes one.", examples=["{fit: indicator-line}"]
    )
    _sized: tuple[tuple[str, Sized], ...] = PrivateAttr(())

    @model_validator(mode="after")
    def _plausible(self) -> Instrument:
        found = []
        if self.resolution is not None and self.resolution.si <= 0:
            found.append(Refusal(("resolution",), f"'{self.resolution.value}'", "a resolution greater than zero"))
        if self.range is not None and self.range[0].dimension != self.range[1].dimension:
            found.append(
                Refusal(("range", 1), f"'{self.range[1].value}'", f"{self.range[0].dimension.name}, as the other end")
            )
        elif self.range is not None and self.range[0].si >= self.range[1].si:
            found.append(Refusal(("range",), "a range whose end is not above its beginning", "'[lowest, highest]'"))
        if (
            self.resolution is not None
            and self.range is not None
            and self.range[0].dimension != self.resolution.dimension
        ):
            got = f"'{self.resolution.value}', {self.resolution.dimension.name}"
            found.append(Refusal(("resolution",), got, f"{self.range[0].dimension.name}, as the range"))
        self._sized = tuple(_sizes(self.uncertainty, found))
        if found:
            raise refuse(*found)
        return self

    @property
    def is_exact(self) -> bool:
        """Whether nothing is stated of the uncertainty of its readings but their resolution."""
        return not self.uncertainty and (self.certificate is None or self.certificate.expanded_uncertainty is None)

    def components(self, unit: str) -> tuple[Component, ...]:
        """Return what else is stated of one indication in the SI unit `unit`, ``"1"`` for a share of it."""
        return tuple(sized.component("stated") for own, sized in self._sized if own == unit)


def _sizes(components: tuple[StatedComponent, ...], found: list[Refusal]) -> Iterator[tuple[str, Sized]]:
    """Return each component with its SI unit; what cannot be read joins `found`."""
    for index, component in enumerate(components):
        try:
            amount = size_alone(getattr(component, component.amount))
            limit = units.parse(component.limit_half_width or f"0 {amount.unit}", expected=amount.unit)
        except TextError as error:
            found.append(from_text(error, "uncertainty", index, component.amount))
            continue
        yield units.si_unit(amount.unit), Sized(component, amount.value, limit.value)
