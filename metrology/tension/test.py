"""What goes into the evaluation of a tension test: records of mounted specimens, and what is known of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from metrology.gum.inputs import Input

Array = NDArray[np.float64]
By = Literal["strain", "force", "share", "longest"]


@dataclass(frozen=True)
class Range:
    """Part of a loading over which the line is drawn.

    `by`: from `low` to `high` of the strain, of the force / N, of the largest force of the record; or the longest range
    that is straight. `passage`: which loading through the range, from 1.
    """

    by: By = "longest"
    low: float = 0.0
    high: float = 1.0
    passage: int = 1


@dataclass(frozen=True)
class Mounting:
    """One specimen in the grips, with its record.

    Parameters
    ----------
    name : str
        Of the specimen.
    force : ndarray, shape (n,)
        N.
    time, crosshead : ndarray, shape (n,), optional
        s, m.
    strains : tuple of ndarray, shape (n,)
        Readings of one or two extensometers, each over its gauge length; NaN where it was taken off.
    length : Input, optional
        Free length / m, of which the record tells the stiffness.
    area : str
        Name of the area of its section in the model; empty where it is not known.
    area_value, area_u : float
        Its value / m², and the standard uncertainty of it that no other specimen shares.
    """

    name: str
    force: Array
    time: Array | None = None
    crosshead: Array | None = None
    strains: tuple[Array, ...] = ()
    length: Input | None = None
    area: str = ""
    area_value: float = float("nan")
    area_u: float = 0.0

    @property
    def strain(self) -> Array | None:
        """Mean of the extensometers: on opposite sides of a specimen they take bending out."""
        return np.asarray(np.mean(self.strains, axis=0)) if self.strains else None

    @property
    def nominal(self) -> Array | None:
        """Strain by which a range is chosen: that of the extensometer, else crosshead by free length."""
        if self.strains:
            return self.strain
        return None if self.crosshead is None or self.length is None else self.crosshead / self.length.value


@dataclass(frozen=True)
class TensionTest:
    """A tension test as carried out, ready for `analyse`.

    Parameters
    ----------
    name : str
        Id of the test.
    mountings : tuple of Mounting
        One a specimen.
    range : Range
        Over which the line is drawn.
    secant, tangent : Range, optional
        Two points between which a secant is drawn, and one, as both ends, at which a tangent is.
    force_scale, strain_scale, crosshead_scale : Input, optional
        Relative corrections of all readings of an instrument, alike in all specimens.
    gauge : Input, optional
        Gauge length / m by which extensions became strains; None where the strain was read.
    setup : Input, optional
        Compliance of the set-up / (m/N) by a calibration, which is taken from the crosshead.
    sample_length : str
        Name of the sample's length in the model; empty where it is not known.
    linear_density : str
        Name of the sample's mass per length in the model; empty where it is not known.
    to_break : bool
        Whether the specimens were pulled until they broke.
    tolerance : float
        Deviation from a line, over the range of the strain, that the classes of the instruments allow.
    fall : float
        Part of the largest force by which it has to fall before it counts as the strength: what the cell may err.
    divisions : tuple of (str, float)
        Column, and the smallest difference that its instrument shows, in SI.
    significance : float
        Rate at which each check may fail on data with nothing wrong in them.
    """

    name: str
    mountings: tuple[Mounting, ...]
    range: Range
    secant: Range | None = None
    tangent: Range | None = None
    force_scale: Input | None = None
    strain_scale: Input | None = None
    crosshead_scale: Input | None = None
    gauge: Input | None = None
    setup: Input | None = None
    sample_length: str = ""
    linear_density: str = ""
    to_break: bool = False
    tolerance: float = 0.0
    fall: float = 0.01
    divisions: tuple[tuple[str, float], ...] = ()
    significance: float = 0.05

    @property
    def has_strain(self) -> bool:
        """Whether an extensometer was there."""
        return all(one.strains for one in self.mountings)

    @property
    def has_lengths(self) -> bool:
        """Whether the free length of every specimen is known."""
        return all(one.length is not None for one in self.mountings)

    @property
    def division(self) -> dict[str, float]:
        """Smallest difference that is shown, by column: force / N, crosshead / m, strain."""
        return dict(self.divisions)
