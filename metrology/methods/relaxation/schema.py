"""How a campaign file declares a test by method `relaxation`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from metrology.declaration.conduct import Test
from metrology.declaration.entry import Entry, Refusal, refuse
from metrology.declaration.quantity import Compliance, Length, Stated, ValueOnly, of
from metrology.declaration.readings import Readings
from metrology.declaration.samples import Section
from metrology.declaration.scalars import Id, Integer, Text
from metrology.declaration.scalars import Table as Named

Duration = Annotated[Stated, *of("s")]
MOST = 6
"""Branches that may be asked for: more than six in a record were never distinguished."""


class RelaxationInstruments(Entry):
    """Instruments of a relaxation or creep test: `force`, and one that reads the stretch."""

    force: Id = Field(
        description="The load cell; its `class` to ISO 7500-1 (0.5, 1, 2, 3) or its certificate is used.",
        examples=["cell"],
    )
    crosshead: Id | None = Field(
        None,
        description="What reads, or commands, the displacement of the crosshead; the set-up's compliance acts.",
        examples=["encoder"],
    )
    extension: Id | None = Field(
        None,
        description="Extensometer that reads a displacement over `gauge_length`; its `class` to ISO 9513 (0.2, 0.5, 1, "
        "2) or its certificate is used.",
        examples=["extensometer"],
    )
    strain: Id | None = Field(None, description="Instrument that reads a strain, likewise.", examples=["video"])

    @model_validator(mode="after")
    def _one(self) -> RelaxationInstruments:
        stated = [key for key in ("crosshead", "extension", "strain") if getattr(self, key) is not None]
        if len(stated) != 1:
            got = " and ".join(f"'{key}'" for key in stated) or "a force alone"
            raise refuse(Refusal((), got, "one of 'crosshead', 'extension' and 'strain', which reads the stretch"))
        return self

    @property
    def reader(self) -> tuple[Literal["crosshead", "extension", "strain"], str]:
        """Column of the stretch, and the instrument that reads it."""
        if self.crosshead is not None:
            return "crosshead", self.crosshead
        if self.extension is not None:
            return "extension", self.extension
        assert self.strain is not None
        return "strain", self.strain


class RelaxationSpecimen(Entry):
    """A specimen in the grips, with its record."""

    readings: Readings = Field(
        description="File, a name or a mapping (`Readings`), with the columns `time / s`, `force / N`, and that of the "
        "stretch: `crosshead / mm`, `extension / um` or `strain / %`. Stamps need not be even.",
        examples=["hold-1.csv"],
    )
    section: Section | None = Field(
        None,
        description="Its section, where it differs from that of the sample.",
        examples=["{shape: round, diameter: 7.13(1) mm}"],
    )
    length: Length | None = Field(
        None, description="Its free length, where it differs from that of the sample.", examples=["60.0(2) mm"]
    )
    remark: Text = Field("", description="What is particular of it.", examples=["second loading"])


class RelaxationTest(Test):
    """Elongation or load that is held at one or several levels: k and E at once and in equilibrium, E′ and E″."""

    method: Literal["relaxation"] = Field(description="Method.", examples=["relaxation"])
    instruments: RelaxationInstruments = Field(
        description="Names of the instruments used.", examples=["{force: cell, strain: video}"]
    )
    held: Literal["elongation", "load"] = Field(
        "elongation",
        description="What was held: the elongation (relaxation of the force) or the load (creep).",
        examples=["load"],
    )
    specimens: Named[RelaxationSpecimen] = Field(
        description="The specimens by name, one for each mounting.",
        examples=["{s1: {readings: s1.csv}, s2: {readings: s2.csv}}"],
    )
    at: Annotated[Duration | None, ValueOnly()] = Field(
        None,
        description="Time after a step at which stiffness and modulus are asked for, `k_t` and `E_t`.",
        examples=["1000 s"],
    )
    branches: Integer = Field(4, description="Branches of the Prony series at most, from 0 to 6.", examples=["3"])
    gauge_length: Length | None = Field(
        None, description="Gauge length of the extensometer that reads `extension`.", examples=["25.4(1) mm"]
    )
    setup_compliance: Compliance | None = Field(
        None,
        description="Compliance of grips, cell and frame by a calibration, where the crosshead was read.",
        examples=["0.12(2) um/N"],
    )
    dma: Readings | None = Field(
        None,
        description="DMA sweep with which the predicted moduli are compared: a file with `frequency / Hz`, "
        "`storage / GPa`, `loss / MPa`, and where they are known the standard uncertainties `u storage / MPa` and "
        "`u loss / MPa`.",
        examples=["dma.csv"],
    )

    @property
    def kind(self) -> str:
        """`creep` of a load that is held."""
        return "creep" if self.held == "load" else ""

    @model_validator(mode="after")
    def _possible(self) -> RelaxationTest:
        if not 0 <= self.branches <= MOST:
            raise refuse(Refusal(("branches",), f"'{self.branches}'", f"a number from 0 to {MOST}"))
        return self
