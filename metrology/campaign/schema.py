"""The campaign file as a whole.

Attributes of a loaded `Campaign` (all frozen; mappings keep the order of the file)::

    format id title reconstructed seed coverage_probability monte_carlo (digits, max_trials) purpose place sampling
    provided deviations opinions anomalies assumptions documents: each a tuple, empty for `none`; None where not stated
    report        Report: number issued authorised_by remarks checklists parts replaces (number date reason)
                  signatures: author reviewer approver, each with name function; .in_order()
    laboratory    Party | None: name address contact country    customer: the same
    instruments   {id: Instrument}: kind manufacturer model serial class_ range resolution certificate correction
                  certificate: number laboratory date due expanded_uncertainty k dof; .u = U/k in SI
                  correction: fit | value
    samples       {id: Sample}: name material batch condition received section length linear_density references;
                  .properties {name: Stated}; section, with its .shape: Round(diameter) | Ellipse(width, height)
                  | Tape(width, thickness) | GivenArea(area)
    tests         {id: Test of its method}: method sample title date operator environment exclusions deviations
                  instruments, and each method's own (metrology/methods)
    quantities    {name: Stated}    masses: {id: Stated}, entered into the tests as they are read
    ensembles     {id: Ensemble}: readings columns {name: heading} uncertainty {name: components} descriptions source
    causes        {id: StatedCause}: sizes as of a component, description source
    correlations  (Correlation: between coefficient source, …)
    fits          {id: Fit}: readings x y u_x u_y correlation model origin predict source; .parameters
    derived       (Derived: quantity sample expression where unit description; .name, …)
    comparisons   (Comparison: title between (Side: quantity | value), …)
    requirements  (Requirement: id text quantity limits decision prior, …)
    audit         (Audit: figure quantity expression where published source remark, …)
    diagnosis     Diagnose: off without effects
    extends       text | None: the campaign file in whose folder the readings lie
    path          of the file; folder: where its readings lie
    files         (SourceFile: path sha256 bytes, …), the campaign file first
    names         Names: dimensions {full name: Dimension}, order (derived, each after what it needs),
                  meanings {("derived", i) or ("audit", i): {name in the expression: full name}}
    tables        {(section, name): (Table, …)} of tests, ensembles and fits; a Table has numbers {column: SI array}
                  texts units lines source at(); columns of an elongation test: load repeat direction reading; of a
                  decay test: time displacement;
                  of ensembles and fits: the heading as the campaign file has it
    at(*place)    "campaign.yaml:14:9 tests.a.loads.A"

A `Stated` has .si (float, SI) .unit (as written) .si_unit .dimension .quantity (units.Quantity) .components .u
.input(name) -> gum.Input .description .source; .value is the text of the file.
"""

from __future__ import annotations

from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, PrivateAttr

from metrology.campaign.diagnosis import Diagnose
from metrology.campaign.judgement import Audit, Comparison, Derived, Requirement
from metrology.declaration.branding import Branding
from metrology.declaration.component import StatedCause
from metrology.declaration.declared import Anomaly, Assumption, Listed, Opinion, Provided, StatedDocument
from metrology.declaration.ensembles import Ensemble
from metrology.declaration.entry import Entry
from metrology.declaration.fits import Correlation, Fit
from metrology.declaration.identity import Instrument, Party, Report
from metrology.declaration.monte_carlo import MonteCarlo
from metrology.declaration.quantity import Mass, Stated
from metrology.declaration.samples import Sample
from metrology.declaration.scalars import Filled, Id, Integer, Probability, SymbolTable, Table, Text
from metrology.methods import METHODS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from metrology.campaign.imported import Imported, Together
    from metrology.campaign.names import Names
    from metrology.declaration.columns import SourceFile
    from metrology.declaration.columns import Table as Readings
    from metrology.declaration.conduct import Test as AnyTest
    from metrology.declaration.document import Document, Key
    from metrology.rig.own import OwnEffect

if not TYPE_CHECKING:
    AnyTest = Annotated[reduce(or_, (method.test for method in METHODS.values())), Field(discriminator="method")]
    """A test by any of the methods, which its key `method` names."""

FORMAT = "metrology-campaign/1"


class Campaign(Entry):
    """A campaign: what was measured on what, with what, and what is to be made of it."""

    format: Literal["metrology-campaign/1"] = Field(description="Version of the file format.", examples=[FORMAT])
    id: Id = Field(
        description="Name of the campaign, of at most 64 characters; its report goes to `reports/<id>`.",
        examples=["tapes"],
    )
    title: Filled = Field(description="Title of the report.", examples=["Stiffness and damping of two tape tethers"])
    report: Report = Field(
        default_factory=lambda: Report.model_validate({}),
        description="Identification of the report.",
        examples=["{number: TR-2026-001, issued: 2026-11-20}"],
    )
    laboratory: Party | None = Field(None, description="The laboratory.", examples=["{name: Tether Laboratory}"])
    customer: Party | None = Field(None, description="The customer.", examples=["{name: Space Systems}"])
    branding: Branding | None = Field(
        None,
        description="How the report looks: logo, colour, letterhead, accreditation, footer.",
        examples=["{logo: logo.svg, colour: '#0b4f8a'}"],
    )
    reconstructed: Text = Field(
        "",
        description="Where the readings are not measured, what they are; printed wherever they show.",
        examples=["Readings reconstructed from published results; not measured."],
    )
    seed: Integer = Field(
        1,
        description="Seed of the Monte Carlo draws, from 0 to 999999999999999999; the same seed gives the same report.",
        examples=["20261120"],
    )
    coverage_probability: Probability = Field(
        0.95, description="Probability of the coverage intervals.", examples=["0.95"]
    )
    monte_carlo: MonteCarlo = Field(
        MonteCarlo(),
        description="How far the Monte Carlo evaluation goes.",
        examples=["{digits: 3, max_trials: 10000000}"],
    )
    purpose: Text = Field(
        "",
        description="Purpose and objective of the tests, and the reason for them.",
        examples=["Acceptance of spool 3 before integration"],
    )
    place: Text = Field(
        "",
        description="Where the tests were made: `laboratory` for its own address, else the place.",
        examples=["laboratory"],
    )
    sampling: Text = Field(
        "",
        description="Sampling plan and method, and who sampled; `none` where the laboratory tested what it was given.",
        examples=["none"],
    )
    provided: Listed[Provided] = Field(
        None,
        description="Data of the customer and results of external providers; or `none`.",
        examples=["[{what: length of the tape, by: Space Systems, role: customer}]"],
    )
    deviations: Listed[Filled] = Field(
        None,
        description="Deviations that concern the whole campaign; or `none`.",
        examples=["[Room 2 instead of room 1]"],
    )
    opinions: Listed[Opinion] = Field(
        None,
        description="Opinions and interpretations, in a section of their own; or `none`.",
        examples=["[{text: Fit for use., by: J. Doe, basis: modulus}]"],
    )
    anomalies: Listed[Anomaly] = Field(
        None,
        description="Nonconformances, failures and problems; or `none`. Open ones stand on page 1.",
        examples=["[{id: NCR-17, text: clamp slipped, state: open}]"],
    )
    assumptions: Listed[Assumption] = Field(
        None,
        description="Assumptions and constraints; or `none`. A plain text is one that excludes no effect.",
        examples=["[{text: The clamps do not slip, excludes: [slip]}]"],
    )
    documents: Listed[StatedDocument] = Field(
        None,
        description="Applicable and reference documents; or `none`.",
        examples=["[{number: SP-12, title: Elongation, edition: 3, role: applicable}]"],
    )
    instruments: Table[Instrument] = Field(
        {}, description="Instruments by name.", examples=["{indicator: {kind: dial indicator}}"]
    )
    samples: Table[Sample] = Field(
        {}, description="Samples by name.", examples=["{al-1100: {material: aluminium 1100}}"]
    )
    tests: Table[AnyTest] = Field(
        {}, description="Tests by name.", examples=["{al-1100-elongation: {method: elongation}}"]
    )
    quantities: SymbolTable[Stated] = Field(
        {}, description="Free input quantities by name.", examples=["{alpha: 1.15(12)e-5 1/K}"]
    )
    masses: Table[Mass] = Field(
        {},
        description="Masses by name, for tests whose mass is a sum of them: `mass: m1 + m2`.",
        examples=["{m1: 1.00000(2) kg, m2: 2.00000(4) kg}"],
    )
    ensembles: Table[Ensemble] = Field(
        {},
        description="Quantities read simultaneously, by the name of the set.",
        examples=['{bridge: {readings: bridge.csv, columns: {V: "V / V", I: "I / mA"}}}'],
    )
    causes: Table[StatedCause] = Field(
        {},
        description="Causes of uncertainty that several quantities share, by name; components refer to them.",
        examples=["{micrometer: {standard: 1 um, source: certificate M-1}}"],
    )
    correlations: tuple[Correlation, ...] = Field(
        (), description="Stated correlation coefficients.", examples=["[{between: [a, b], coefficient: 0.9}]"]
    )
    fits: Table[Fit] = Field(
        {}, description="Lines and curves by name.", examples=['{cal: {readings: cal.csv, x: "x / mm", y: "y / um"}}']
    )
    derived: tuple[Derived, ...] = Field(
        (), description="Derived quantities.", examples=["[{quantity: R, expression: V/I, unit: ohm}]"]
    )
    comparisons: tuple[Comparison, ...] = Field(
        (), description="Comparisons by E_n.", examples=["[{between: [a.k, b.k]}]"]
    )
    requirements: tuple[Requirement, ...] = Field(
        (),
        description="Requirements with their decision rules.",
        examples=["[{id: R1, quantity: R, limits: {lower: 100 ohm}, decision: {rule: simple acceptance}}]"],
    )
    audit: tuple[Audit, ...] = Field(
        (),
        description="Published or expected figures, to be recomputed.",
        examples=["[{figure: R, quantity: R, published: 127.73 ohm}]"],
    )
    diagnosis: Diagnose = Field(
        default_factory=lambda: Diagnose.model_validate({}),
        description="How the tests are diagnosed.",
        examples=["{off: true}"],
    )
    extends: Filled | None = Field(
        None,
        description="Campaign file that this one extends: readings are taken from its folder, not from that of this "
        "file. `metrology diagnose` writes it into `extended.yaml`.",
        examples=["../../campaigns/nylon/campaign.yaml"],
    )
    _document: Document | None = PrivateAttr(None)
    _names: Names | None = PrivateAttr(None)
    _tables: Mapping[tuple[str, str], tuple[Readings, ...]] = PrivateAttr(default_factory=dict)
    _files: tuple[SourceFile, ...] = PrivateAttr(())
    _look: Mapping[str, bytes] = PrivateAttr(default_factory=dict)
    _own: tuple[OwnEffect, ...] = PrivateAttr(())
    _notices: tuple[str, ...] = PrivateAttr(())
    _imported: tuple[Imported, ...] = PrivateAttr(())
    _together: tuple[Together, ...] = PrivateAttr(())

    @property
    def path(self) -> Path:
        """The file, as it was given."""
        return self._document.path if self._document else Path()

    @property
    def folder(self) -> Path:
        """The folder in which readings lie: that of the file, or of the campaign that it extends."""
        return (self.path.parent / self.extends).parent if self.extends else self.path.parent

    @property
    def attached(self) -> Mapping[str, bytes]:
        """Files of readings that came with the campaign and lie nowhere, by name."""
        return self._document.attached if self._document else {}

    @property
    def look(self) -> Mapping[str, bytes]:
        """Files that `branding` names, by name."""
        return self._look

    @property
    def names(self) -> Names:
        """Every name with its dimension, what names in expressions mean, and the order of derived quantities."""
        if self._names is None:
            raise AttributeError("names: only a campaign that was loaded has them")
        return self._names

    @property
    def files(self) -> tuple[SourceFile, ...]:
        """Every file that went in, with its hash; the campaign file first."""
        return self._files

    @property
    def notices(self) -> tuple[str, ...]:
        """What was read although it is not as documented, a sentence a file."""
        return self._notices

    @property
    def imported(self) -> tuple[Imported, ...]:
        """Results of other campaigns that are quantities of this one, with what must be known of them."""
        return self._imported

    @property
    def together(self) -> tuple[Together, ...]:
        """Components that several of them have jointly, with their covariance."""
        return self._together

    @property
    def own(self) -> tuple[OwnEffect, ...]:
        """Effects of the laboratory's own; empty where their code was not run."""
        return self._own

    @property
    def tables(self) -> Mapping[tuple[str, str], tuple[Readings, ...]]:
        """Readings of every entry that names files, a table a file, by section and name: ``tables["tests", "a"]``."""
        return self._tables

    def at(self, *place: Key) -> str:
        """Where an entry stands: ``campaign.yaml:14:9 tests.a.loads.A``."""
        return self._document.at(*place) if self._document else ""
