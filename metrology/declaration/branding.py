"""How a laboratory's reports look: logo, colour, letterhead, accreditation, footer."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field, field_validator

from metrology.declaration.entry import Entry, Refusal, refuse
from metrology.declaration.scalars import Filled, Text, matching

LEAST_CONTRAST = 4.5
"""Of words on white paper (WCAG 2.2, 1.4.3)."""
SUFFIXES = (".svg", ".png")
Colour = Annotated[str, AfterValidator(matching(r"#[0-9a-fA-F]{6}", "a colour as '#0b4f8a'"))]
LONGEST = 160


class Accreditation(Entry):
    """The accreditation under which a report is issued (ISO/IEC 17025:2017, 7.8)."""

    mark: Filled | None = Field(
        None, description="Mark of the accreditation body, .svg or .png, as `logo`.", examples=["mark.svg"]
    )
    body: Filled = Field(description="Who accredited.", examples=["Accreditation Body"])
    number: Filled = Field(description="Number of the accreditation.", examples=["L-1234-01"])


class Branding(Entry):
    """How the reports of a laboratory look."""

    file: Filled | None = Field(
        None,
        description="File, .yaml, with these same keys, which many campaigns share; what the campaign states goes "
        "before. This file and those that it names lie in the campaign's folder or in the one above.",
        examples=["laboratory.yaml"],
    )
    logo: Filled | None = Field(
        None,
        description="Logo at the head of page 1: .svg of plain shapes without text or style sheet, or .png; 256 KiB at "
        "most.",
        examples=["logo.svg"],
    )
    colour: Colour | None = Field(
        None, description="Colour of headings and rules, dark enough to be read on white.", examples=["#0b4f8a"]
    )
    letterhead: Text = Field("", description="Lines at the head of page 1.", examples=["Mechanics of long structures"])
    accreditation: Accreditation | None = Field(
        None, description="Accreditation.", examples=["{body: Accreditation Body, number: L-1234-01}"]
    )
    footer: Text = Field("", description="Words at the foot of every page.", examples=["www.example.org"])

    @field_validator("colour")
    @classmethod
    def _readable(cls, given: str | None) -> str | None:
        """Refuse a colour that words on white paper could not be read in."""
        if given is not None and (ratio := contrast(given)) < LEAST_CONTRAST:
            got = f"'{given}', whose contrast with white is {ratio:.1f} : 1"
            raise refuse(Refusal((), got, f"a colour with a contrast of {LEAST_CONTRAST} : 1 at least", "darken it"))
        return given

    @field_validator("letterhead", "footer")
    @classmethod
    def _short(cls, given: str) -> str:
        if len(given) > LONGEST:
            raise refuse(Refusal((), f"{len(given)} characters", f"{LONGEST} characters at most", "shorten it"))
        return given


def contrast(colour: str) -> float:
    """Contrast ratio of a colour, ``#rrggbb``, with white (WCAG 2.2)."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    r, g, b = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 1.05 / (0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05)
