"""A test as the report shows it: how it was carried out, and what it showed by its method."""

from __future__ import annotations

from dataclasses import dataclass, make_dataclass, replace
from typing import Annotated, Any

from metrology.doc import Doc
from metrology.method import Finding
from metrology.methods import METHODS


@dataclass(frozen=True)
class _CarriedOut:
    """How a test was carried out."""

    id: Annotated[str, Doc("Name in the campaign file.")]
    method: Annotated[str, Doc("Method, by its word in the campaign file.")]
    title: Annotated[str, Doc("Title as the report prints it.")]
    standard: Annotated[str, Doc("What the method follows, with edition.")]
    sample: Annotated[str, Doc("Sample, by its name in the campaign file.")]
    date: Annotated[str, Doc("Date of the test.")]
    operator: Annotated[str, Doc("Who carried it out.")]
    environment: Annotated[tuple[str, ...], Doc("Conditions, each with value and uncertainty as text.")]
    instruments: Annotated[tuple[str, ...], Doc("Instruments used, by name.")]
    deviations: Annotated[tuple[str, ...], Doc("Deviations from the method, each in words.")]
    exclusions: Annotated[tuple[str, ...], Doc("Readings not used, each with its reason.")]


@dataclass(frozen=True)
class _Documented:
    """What a test was carried out by."""

    procedure: Annotated[str, Doc("Procedure that was followed, with edition.")] = ""
    specification: Annotated[str, Doc("Test specification, with issue.")] = ""
    as_run: Annotated[str, Doc("The procedure as it was run.")] = ""
    setup: Annotated[str, Doc("Configuration of the set-up.")] = ""
    deviations_stated: Annotated[bool, Doc("Whether the test states its deviations, also that there are none.")] = False


_SHOWN = [(name, Annotated[method.finding | None, Doc(method.shown)], None) for name, method in METHODS.items()]
_Shown: Any = make_dataclass("_Shown", _SHOWN, frozen=True)
"""A field for each method: what a test by it showed."""


@dataclass(frozen=True)
class TestItem(_Documented, _Shown, _CarriedOut):  # type: ignore[misc]
    """A test as carried out: what, when, by whom, with what, under which conditions, and what it showed."""

    __test__ = False

    @property
    def by(self) -> str:
        """Word of the method that showed something, one that there is whatever a file says; empty where none did."""
        return next((name for name in METHODS if getattr(self, name) is not None), "")

    @property
    def finding(self) -> Finding | None:
        """What the test showed."""
        return getattr(self, self.by) if self.by else None

    def showing(self, finding: Finding) -> TestItem:
        """Return the test with what it showed."""
        shown: dict[str, Any] = {self.method: finding}
        return replace(self, **shown)
