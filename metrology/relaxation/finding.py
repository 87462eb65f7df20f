"""What the report shows of a relaxation or creep test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from metrology.check import Check
from metrology.doc import Doc

Floats = tuple[float, ...]


@dataclass(frozen=True)
class Weighed:
    """A form of the relaxation with its probability."""

    name: Annotated[str, Doc("What it is called.")]
    drift: Annotated[bool, Doc("Whether a drift of the readings is added.")]
    probability: Annotated[float, Doc("Probability, all forms being as probable as one another beforehand.")]
    allowed: Annotated[bool, Doc("Whether its sizes have the sign that they must have in every specimen.")]


@dataclass(frozen=True)
class Branch:
    """A branch of the most probable form: its part of the initial stiffness (or compliance), its time and 95 % ends."""

    part: Annotated[float, Doc("Size over r_0.")]
    part_u: Annotated[float, Doc("Standard uncertainty of the part.")]
    time: Annotated[float, Doc("Relaxation or retardation time / s.")]
    low: Annotated[float, Doc("Lower end of its 95 % interval / s.")]
    high: Annotated[float, Doc("Upper end of its 95 % interval / s.")]
    left: Annotated[float, Doc("Part that it takes of what faster branches leave of the stiffness.")]
    left_u: Annotated[float, Doc("Standard uncertainty of that.")]


@dataclass(frozen=True)
class Record:
    """A record as means over its blocks, with the most probable form."""

    time: Annotated[Floats, Doc("Time since the first reading / s.")]
    input: Annotated[Floats, Doc("What was imposed: elongation / m or strain, or load / N.")]
    answer: Annotated[Floats, Doc("What answered: force / N, or elongation / m or strain.")]
    model: Annotated[Floats, Doc("The most probable form.")]


@dataclass(frozen=True)
class Specimen:
    """What the record of one specimen says, in SI; results without an uncertainty here, None where there is none."""

    name: Annotated[str, Doc("Specimen, by its name in the campaign file.")]
    count: Annotated[int, Doc("Readings.")]
    levels: Annotated[Floats, Doc("Levels at which the input was held.")]
    holds: Annotated[Floats, Doc("How long each was held / s.")]
    ramp: Annotated[float, Doc("Longest ramp / s.")]
    memory: Annotated[float, Doc("Correlation time of the noise / s.")]
    level: Annotated[float, Doc("Standard deviation of the block means about the most probable form.")]
    branches: Annotated[tuple[Branch, ...], Doc("Branches of the most probable form.")]
    alpha: Annotated[float | None, Doc("Exponent of the power law, where that is the most probable form.")]
    alpha_u: Annotated[float | None, Doc("Its standard uncertainty.")]
    k_0: Annotated[float | None, Doc("Instantaneous stiffness / (N/m).")]
    k_inf: Annotated[float | None, Doc("Equilibrium stiffness / (N/m).")]
    E_0: Annotated[float | None, Doc("Instantaneous modulus / Pa.")]
    E_inf: Annotated[float | None, Doc("Equilibrium modulus / Pa.")]
    record: Annotated[Record, Doc("The record.")]


@dataclass(frozen=True)
class Moduli:
    """Storage and loss over frequency, mean over the specimens, with the ends of their 95 % intervals."""

    quantity: Annotated[str, Doc("E (Pa), or k (N/m) where no section is known, EA (N) where no length is.")]
    frequency: Annotated[Floats, Doc("Hz.")]
    storage: Annotated[Floats, Doc("Storage part.")]
    storage_low: Annotated[Floats, Doc("Lower end.")]
    storage_high: Annotated[Floats, Doc("Upper end.")]
    loss: Annotated[Floats, Doc("Loss part.")]
    loss_low: Annotated[Floats, Doc("Lower end.")]
    loss_high: Annotated[Floats, Doc("Upper end.")]


@dataclass(frozen=True)
class Compared:
    """One frequency of a DMA sweep: read, predicted, and E_n = (read − predicted)/√(U² + U²); None beyond the range."""

    frequency: Annotated[float, Doc("Hz.")]
    storage: Annotated[float, Doc("E′ that the sweep read / Pa.")]
    storage_u: Annotated[float | None, Doc("Its standard uncertainty / Pa; null where none is stated.")]
    loss: Annotated[float, Doc("E″ that the sweep read / Pa.")]
    loss_u: Annotated[float | None, Doc("Its standard uncertainty / Pa; null where none is stated.")]
    storage_predicted: Annotated[float | None, Doc("E′ predicted / Pa.")]
    loss_predicted: Annotated[float | None, Doc("E″ predicted / Pa.")]
    storage_en: Annotated[float | None, Doc("E_n of E′.")]
    loss_en: Annotated[float | None, Doc("E_n of E″.")]


@dataclass(frozen=True)
class RelaxationFinding:
    """Everything that the report shows of a relaxation or creep test, in SI."""

    held: Annotated[str, Doc("What was held: elongation or load.")]
    by_strain: Annotated[bool, Doc("Whether the stretch is a strain, else an elongation / m.")]
    verdict: Annotated[str, Doc("What the evidence says, in words.")]
    forms: Annotated[tuple[Weighed, ...], Doc("The forms that were weighed, most probable first.")]
    specimens: Annotated[tuple[Specimen, ...], Doc("Each specimen.")]
    moduli: Annotated[Moduli, Doc("Predicted storage and loss.")]
    dma: Annotated[tuple[Compared, ...], Doc("The DMA sweep, where there is one.")]
    checks: Annotated[tuple[Check, ...], Doc("Checks of the data against what the model supposes.")]
    equations: Annotated[tuple[str, ...], Doc("Equations of the method, as text.")]
    at: Annotated[float | None, Doc("Time / s at which the stiffness was asked for.")] = None
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")] = ()
    significance: Annotated[float | None, Doc("Rate at which all checks together may fail by chance.")] = None
