"""One release of a free decay as the diagnosis takes it: cut, averaged in blocks, and followed by the rig."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from metrology.coordinate import Sensed
from metrology.decay.hop import Hop
from metrology.decay.oscillation import DEGREE
from metrology.decay.separation import HOPS
from metrology.diagnostics.candidate import DECAY
from metrology.diagnostics.subject import Array
from metrology.rig import Motions, Rig, Run, Sensitivities, sensitivities, simulate_many
from metrology.timeseries.spectra import on_grid

FORCES = {size.name: size.null for one in DECAY.values() if one.acts in ("module", "line") and not one.cause.alone
          for size in one.parameters}  # fmt: skip
"""Sizes and shapes of the forces, besides those of spring and damper, that a decay can show, and their null values."""
BENDS = tuple(one.size.name for one in DECAY.values()
              if one.acts == "reading" and not (one.is_line or one.cause.alone))  # fmt: skip
"""What bends the reading of a motion: factors of its square and of its cube."""
MOTION = ("k", "c", "x0", "v0", *FORCES, *BENDS)
"""What the reading of a motion depends on."""
BENT = len(MOTION) - len(BENDS)
"""Place in `MOTION` from which on it is the reading alone."""
LEVELS = tuple(f"level{order}" for order in range(DEGREE + 3))
"""Slow motion under the decay: coefficients of Legendre's polynomials, and of what they do not follow of a zero that
settles and of a change of its rate."""
STEPS = tuple(f"hop{order}" for order in range(HOPS))
"""What the steps of the reading differ by from what was taken out."""
_OF_RIG = ("k", "c", "start.x", "start.v", *FORCES)
LINES = ("other", "mains")
"""Oscillations that may overlie a decay."""
HARMONICS = 5
"""Multiples of the decay's own frequency at which a bent restoring force makes lines of its own."""
PER_PERIOD = 20
"""Samples kept per period: means over whole blocks."""
LONGEST = 300
"""Periods of a record that are looked at, from the release on."""
FINE = 40
"""Steps per period of an integral over a motion."""
DIFFERENCE = 1e-3
"""Part of 1/ω between two velocities whose difference is an acceleration: right to its square over six, 2e-7."""
ACCELERATION = 2
STEP = 1e-3
"""Part of the first swing by which a start is changed for a derivative."""
FADED = 1e-8
"""Part of its first value below which W, which falls as the square of the motion, is rounding."""


@dataclass(frozen=True, eq=False)
class Path:
    """Where a release goes: times, positions and velocities, and what forces do there (`Record.pushed`).

    `kernels`: −y₂/(m·W) and y₁/(m·W), shape (2, steps); `ways`: y₁ and y₂ at the stamps of the run. `scale`: change of
    a reading at the nodes for one of what is read; None where it is 1.
    """

    t: Array
    x: Array
    v: Array
    kernels: Array
    ways: Array
    scale: Array | None


@dataclass(frozen=True)
class Line:
    """An oscillation that was taken out of a release: frequency / Hz, amplitude, whether it is of the mains.

    `noise`: standard deviation of white noise of as much power as the residuals have beside the line. `turns`: how
    often it turns in the record, or before it has faded to 1/e. `lasts`: mean square of its envelope over the record.
    """

    frequency: float
    amplitude: float
    is_mains: bool
    noise: float
    turns: float = math.inf
    lasts: float = 1.0


@dataclass(frozen=True, eq=False)
class Record:
    """One release, cut and averaged in blocks: mean times, mean readings, and the linear decay that fits it.

    `nodes`, `weights`: three times in each block and their weights, shape (3, n), by which the mean of a motion over
    the samples of the block is formed (a rule of Gauss for the block's own time stamps, exact up to the fourth power).
    Time zero is the first node. `u`: standard uncertainty of every reading. `lines`: what was taken out before.
    `noise`: standard deviation of the readings before they were averaged, so many `per_block`; `rounding`: by what
    rounding alone their mean is off, however many they are; `is_known`: `u` is what rounded readings say
    (`decay.rounding`), and the noise no less.
    """

    name: str
    sensed: Sensed
    t: Array
    y: Array
    u: Array
    nodes: Array
    weights: Array
    omega: float
    rate: float
    x0: float
    v0: float
    level: float
    lines: tuple[Line, ...]
    noise: float = math.nan
    per_block: float = 1.0
    rounding: float = 0.0
    is_known: bool = False
    steps: tuple[tuple[Hop, Array], ...] = ()
    """Steps of the reading that were taken out, each with the part of every block after it; sizes are fitted again."""
    settles: tuple[float, float] = (0.0, 0.0)
    """By how much the zero settles from time zero on, and at which rate / (1/s)."""

    @cached_property
    def _stencil(self) -> tuple[Array, Array]:
        """Times of the motion of which a reading is a sum, and their weights, shape (q, n).

        An acceleration is the difference of two velocities, `before` and after each node.
        """
        if self.sensed.order < ACCELERATION:
            return self.nodes, self.weights
        before = node_gap(self.sensed, self.omega)
        slopes = 0.5 * self.weights / before
        return np.concatenate([self.nodes - before, self.nodes + before]), np.concatenate([-slopes, slopes])

    @cached_property
    def _places(self) -> tuple[Array, NDArray[np.intp]]:
        times, _ = self._stencil
        stamps, places = np.unique(times, return_inverse=True)
        return stamps, np.reshape(places, times.shape)

    @cached_property
    def slow(self) -> Array:
        """Legendre's polynomials over the record, and what they do not follow of a settling, a row for each level.

        The rate of the settling is that of the direct fit, which another law of the motion may change: what a small
        change of it does has a row as well. What the polynomials follow to within the noise has none.
        """
        rows = np.polynomial.legendre.legvander(2 * self.t / self.t[-1] - 1, DEGREE)
        size, rate = self.settles
        fall = rate * self.t
        for shape in (np.exp(-fall), fall * np.exp(-fall)) if rate else ():
            beside = shape - rows @ np.linalg.lstsq(rows, shape, rcond=None)[0]
            if float(np.linalg.norm(size * beside / self.u)) > 1.0:
                rows = np.column_stack([rows, beside / np.abs(beside).max()])
        return np.ascontiguousarray(rows.T)

    def beginning(self, part: float) -> Record:
        """Return a first part of the record, three periods at least, with the same slow motion."""
        some = slice(max(math.ceil(part * len(self.t)), 3 * PER_PERIOD))
        found = replace(
            self, t=self.t[some], y=self.y[some], u=self.u[some], nodes=self.nodes[:, some],
            weights=self.weights[:, some], steps=tuple((hop, later[some]) for hop, later in self.steps),
        )  # fmt: skip
        vars(found)["slow"] = self.slow[:, some]
        return found

    @property
    def levels(self) -> tuple[str, ...]:
        """Names of the coefficients of `slow`."""
        return LEVELS[: len(self.slow)]

    @cached_property
    def run(self) -> Run:
        """Run on the rig from rest at zero, which starts are added to."""
        stamps = self._places[0]
        return Run(x0=0.0, t0=0.0, t_v=stamps) if self.sensed.order else Run(x0=0.0, t0=0.0, t_x=stamps)

    def _read(self, motion: Motions | Sensitivities) -> Array:
        """Of what was followed, what the sensor shows or what its readings are differences of."""
        found = motion.v if self.sensed.order else motion.x
        assert found is not None
        return found

    @property
    def step(self) -> float:
        """Usual time between two readings / s."""
        return float(np.median(np.diff(self.t)))

    def even(self, values: Array) -> Array:
        """Values on even steps, zero in gaps, for a spectrum."""
        return on_grid(self.t, values, self.step)

    def means(self, values: Array) -> Array:
        """Readings, as means over the blocks, of values at the stamps of the run, shape (…, stamps) → (…, n)."""
        found: Array = np.einsum("...jn,jn->...n", values[..., self._places[1]], self._stencil[1])
        return found

    def _noded(self, values: Array) -> Array:
        """What is read at the nodes of the blocks, of values at the stamps of the run, (…, stamps) → (…, 3, n)."""
        found = values[..., self._places[1]]
        if self.sensed.order < ACCELERATION:
            return np.asarray(found)
        half = found.shape[-2] // 2
        return np.asarray((found[..., half:, :] - found[..., :half, :]) / (2 * node_gap(self.sensed, self.omega)))

    def _weighed(self, nodes: Array) -> Array:
        """Means over the blocks, shape (…, 3, n) → (…, n)."""
        return np.asarray(np.einsum("...jn,jn->...n", nodes, self.weights))

    def _scale(self, values: Array, bends: Sequence[float]) -> Array | None:
        """Change of the reading at the nodes for one of what is read there; None where it is 1."""
        square, cube = bends
        y = self._noded(values)
        return 1.0 + y * (2.0 * square + 3.0 * cube * y) if square or cube else None

    def follow(self, rig: Rig, many: Sequence[tuple[float, ...]]) -> Array:
        """Readings of many motions, each with the values of `MOTION`; NaN where one cannot be followed."""
        values, found = np.array(many), np.empty((len(many), len(self.t)))
        values[:, 0], values[:, 1] = np.maximum(values[:, 0], 1e-12), np.maximum(values[:, 1], 0.0)
        acting, bends = values[:, 4:BENT] != list(FORCES.values()), values[:, BENT:]
        # Motions with the same forces go together: the linear ones have a closed form.
        for kind in np.unique(acting, axis=0):
            rows = (acting == kind).all(axis=1)
            columns = np.concatenate([np.ones(4, dtype=bool), kind])
            names = [name for name, used in zip(_OF_RIG, columns, strict=True) if used]
            here = values[:, :BENT][np.ix_(rows, columns)]
            motions = simulate_many(rig, self.run, names, here, engine="compiled")
            with np.errstate(invalid="ignore", over="ignore"):  # what ran away is not finite, which says so
                read = self._read(motions)
                found[rows] = self.means(read)
                if bends[rows].any():
                    y = self._noded(read)
                    square, cube = bends[rows].T[:, :, None, None]
                    found[rows] += self._weighed(y**2 * (square + cube * y))
        return found

    def slopes(self, rig: Rig, values: tuple[float, ...], places: Sequence[int]) -> Array:
        """Derivatives of the readings of one motion by some of the values of `MOTION`, shape (p, n)."""
        here = self._valued(rig, values).with_values({"start.x": values[2], "start.v": values[3]})
        moving = [place for place in places if place < BENT]
        found = sensitivities(here, self.run, [_OF_RIG[place] for place in moving])
        rows = np.ascontiguousarray(self._read(found).T)
        if len(moving) == len(places) and not any(values[BENT:]):
            return self.means(rows)
        read = self._read(simulate_many(here, self.run, ("start.x", "start.v"), np.array([values[2:4]])))[0]
        y, scale = self._noded(read), self._scale(read, values[BENT:])
        moved = iter(self.means(rows) if scale is None else self._weighed(scale * self._noded(rows)))
        return np.array([next(moved) if place < BENT else self._weighed(y ** (2 + place - BENT)) for place in places])

    def path(self, rig: Rig, values: tuple[float, ...]) -> Path:
        """Where a motion goes, and what a little of its start changes in it, by central differences."""
        here, steps = self._valued(rig, values), math.ceil(FINE * float(self.nodes.max()) * self.omega / (2 * math.pi))
        t = np.linspace(0.0, float(self.nodes.max()), steps + 1)
        size = STEP * math.hypot(values[2], values[3] / self.omega)
        starts = np.array(values[2:4]) + size * np.array([(0, 0), (1, 0), (-1, 0), (0, self.omega), (0, -self.omega)])
        names = ("start.x", "start.v")
        fine = simulate_many(here, replace(self.run, t_x=t, t_v=t), names, starts)
        read = simulate_many(here, self.run, names, starts)
        assert fine.x is not None
        assert fine.v is not None
        (first, second), (first_v, second_v), ways = (
            (rows[1::2] - rows[2::2]) / (2 * size) for rows in (fine.x, fine.v, self._read(read))
        )
        W = first * second_v - second * first_v
        kernels = np.where(np.abs(W) > FADED * np.abs(W[0]), np.array([-second, first]) / np.where(W == 0, 1.0, W), 0.0)
        scale = self._scale(self._read(read)[0], values[BENT:])
        return Path(t, fine.x[0], fine.v[0], kernels / here.m, ways, scale)

    def pushed(self, path: Path, forces: Array) -> Array:
        """Change of the readings by small forces along a motion, shape (steps, q) → (n, q), by variation of constants.

        With y₁ and y₂ what a change of the start does, and W = y₁·y₂′ − y₂·y₁′,
        δx(t) = y₂(t)·∫ y₁·f/(m·W) − y₁(t)·∫ y₂·f/(m·W), exact to first order in f; the velocity has the derivatives
        of y₁ and y₂ before the integrals.
        """
        from scipy.integrate import cumulative_simpson
        from scipy.interpolate import CubicHermiteSpline

        stamps, total = self._places[0], 0.0
        for kernel, way in zip(path.kernels, path.ways, strict=True):
            rate = kernel[:, None] * forces
            whole = cumulative_simpson(rate, x=path.t, axis=0, initial=0.0)
            total = total + CubicHermiteSpline(path.t, whole, rate)(stamps) * way[:, None]
        rows = np.asarray(total).T
        return (self.means(rows) if path.scale is None else self._weighed(path.scale * self._noded(rows))).T

    def _valued(self, rig: Rig, values: tuple[float, ...]) -> Rig:
        spring = max(values[0], 1e-12), max(values[1], 0.0)
        return rig.with_values(dict(zip(("k", "c", *FORCES), (*spring, *values[4:BENT]), strict=True)))


def node_gap(sensed: Sensed, omega: float) -> float:
    """Time / s by which the velocities lie apart from a node whose difference an acceleration is."""
    return DIFFERENCE / omega if sensed.order == ACCELERATION else 0.0
