"""What goes into the evaluation of a relaxation or creep test: records of held specimens, and what is known of them."""

from __future__ import annotations

from dataclasses import dataclass

from metrology.gum.inputs import Input
from metrology.relaxation.blocks import Array
from metrology.relaxation.forms import Held

BRANCHES = 4
"""Branches that are looked for at most where nothing is said."""

STATISTICS = 6
"""Statistics of one record that bar results by chance: readings at rest, slow residuals, a slip, unlike levels or a
ramp that is not proportional, the stiffness at a time and in equilibrium against what was read."""


@dataclass(frozen=True)
class Mounting:
    """One specimen with its record.

    Parameters
    ----------
    name : str
        Of the specimen.
    time, force : ndarray, shape (n,)
        s, increasing; N.
    shown : ndarray, shape (n,)
        Elongation / m, or strain, the mean of the extensometers, as it was read.
    length : Input, optional
        Free length / m.
    area : str
        Name of the area of its section in the model; empty where it is not known.
    area_value : float
        Its value / m².
    setup : float
        Compliance of the set-up / (m/N) that is in what was read; 0 where there is none.
    """

    name: str
    time: Array
    force: Array
    shown: Array
    length: Input | None = None
    area: str = ""
    area_value: float = float("nan")
    setup: float = 0.0

    @property
    def stretch(self) -> Array:
        """Elongation / m, or strain, of the specimen: what the set-up gives way is taken off."""
        return self.shown - self.setup * self.force


@dataclass(frozen=True)
class Sweep:
    """A DMA sweep: frequencies / Hz, E′ and E″ / Pa, and their standard uncertainties where they are stated."""

    frequency: Array
    storage: Array
    loss: Array
    storage_u: Array | None = None
    loss_u: Array | None = None


@dataclass(frozen=True)
class RelaxationTest:
    """A relaxation or creep test as carried out, ready for `analyse`.

    Parameters
    ----------
    name : str
        Id of the test.
    mountings : tuple of Mounting
        One a specimen.
    held : {"elongation", "load"}
        What was held.
    by_strain : bool
        Whether the stretch is a strain, else an elongation / m.
    at : float, optional
        Time after a step / s at which the stiffness is asked for.
    branches : int
        Branches at most.
    force_scale, stretch_scale : Input, optional
        Relative corrections of all readings of an instrument, alike in all specimens.
    gauge : Input, optional
        Gauge length / m by which extensions became strains; None where the strain was read.
    setup : Input, optional
        Compliance of the set-up / (m/N), taken from the crosshead at its value.
    force_division, stretch_division : float
        Smallest differences that are shown / N, and / m or 1; 0 where they are not known.
    dma : Sweep, optional
        With which the predicted moduli are compared.
    significance : float
        Rate at which any check at all that has a p-value may fail on a test with nothing wrong in it.
    """

    name: str
    mountings: tuple[Mounting, ...]
    held: Held = "elongation"
    by_strain: bool = False
    at: float | None = None
    branches: int = BRANCHES
    force_scale: Input | None = None
    stretch_scale: Input | None = None
    gauge: Input | None = None
    setup: Input | None = None
    force_division: float = 0.0
    stretch_division: float = 0.0
    dma: Sweep | None = None
    significance: float = 0.01

    def channels(self, one: Mounting) -> tuple[Array, Array]:
        """What was imposed and what answered in a specimen."""
        return (one.stretch, one.force) if self.held == "elongation" else (one.force, one.stretch)

    def shown(self, one: Mounting) -> tuple[Array, Array]:
        """What the instruments showed of both, set-up and all: divisions and equal readings are seen in these alone."""
        return (one.shown, one.force) if self.held == "elongation" else (one.force, one.shown)

    def adjusted(self, p: float, count: int = 1) -> float:
        """Adjusted p of the least of `count` values, one a specimen, among all statistics of a test (Bonferroni)."""
        return min(1.0, STATISTICS * max(count, 1) * p)
