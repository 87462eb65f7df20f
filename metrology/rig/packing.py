"""Between the rig's values and the kernel's arrays: what goes in, and what comes out in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrology.rig import kernel
from metrology.rig.effects import PARAMETERS
from metrology.rig.model import ATTACHMENTS, CHANNELS, Array, Event, Rig, Run, frozen

Whole = NDArray[np.int64]
NONE = math.nan
_NULLS = np.array([NONE if one.null is None else one.null for one in PARAMETERS.values()])
_CLOCKS = [kernel.CLOCK_X, kernel.CLOCK_V, kernel.CLOCK_T]
_CURVED = [kernel.QUADRATIC, kernel.CUBIC, kernel.AMPLITUDE, kernel.HYSTERESIS]
_STATES = [kernel.FRAME, kernel.FRAME, kernel.ARM, kernel.ARM, kernel.ZENER, kernel.HYSTERESIS, kernel.LAG]
"""For each inner state the parameter that calls for it, in the order of `kernel.FRAME_U` and so on."""
_HUMS = (kernel.HUM_X, kernel.HUM_V, kernel.HUM_T)
EMPTY = frozen(np.empty(0))
NO_SPAN = (frozen(np.empty(0, np.int64)), EMPTY)
NO_FORCE = (EMPTY, EMPTY, EMPTY)


@dataclass(frozen=True)
class Packed:
    """A run as the kernel takes it (see `kernel.march`)."""

    kind: Whole
    at: Whole
    pair: tuple[Array, ...]
    start: Array
    edges: Array
    forces: Array
    slopes: Array
    grids: tuple[Array, ...]
    spans: tuple[Whole, ...]
    spacings: tuple[Array, ...]
    on: NDArray[np.bool_]
    sags: bool
    linear: bool
    most_events: int


def pack(rig: Rig, run: Run, vectors: Array) -> Packed:
    """Arrays for the motions of `rig` with these rows of parameters in `run`."""
    on = (vectors != _NULLS).any(axis=0)
    kind, at, linear = _kind(rig, run, on)
    edges, forces, slopes = NO_FORCE if run.force is None else run.force.pieces
    release = run.t0 if run.held_until is None else run.held_until
    grids = [EMPTY if t is None else t for t in (run.t_x, run.t_v, run.t_T)]
    evenness = [run.evenness.get(name, NO_SPAN) for name in CHANNELS]
    early = vectors[:, _CLOCKS].min() if on[_CLOCKS].any() else 0.0
    return Packed(
        kind, at, no_tableau() if linear else tableau(),
        np.array([run.x0, run.v0, run.t0, release, max(run.end - min(float(early), 0.0), release)]),
        edges, forces, slopes, tuple(grids), tuple(one[0] for one in evenness), tuple(one[1] for one in evenness), on,
        rig.line_weight == "elastic catenary", linear, kernel.MAX_EVENTS + edges.size,
    )  # fmt: skip


def _kind(rig: Rig, run: Run, on: NDArray[np.bool_]) -> tuple[Whole, Whole, bool]:
    at, n = np.full(7, kernel.NOTHING), 2
    for state, is_on in enumerate(on[_STATES].tolist()):
        if is_on:
            at[state], n = n, n + 1
    sags = rig.line_weight == "elastic catenary" or bool(on[kernel.SAG])
    weighs = rig.line_weight == "catenary" and not sags
    linear = not (sags or weighs or on[_CURVED].any())
    together = run.t_x is not None and run.t_x is run.t_v is run.t_T
    return np.array([ATTACHMENTS.index(rig.attachment), int(weighs), n, int(together)]), at, linear


@lru_cache(maxsize=1)
def tableau() -> tuple[Array, ...]:
    """Dormand and Prince's 8(5,3) pair with its 7th-order interpolant (Hairer, Nørsett, Wanner, II.5)."""
    from scipy.integrate import DOP853

    pair: Any = DOP853
    tables = (pair.A, pair.B, pair.C, pair.E3, pair.E5, pair.D, pair.A_EXTRA, pair.C_EXTRA)
    return tuple(frozen(np.array(table, dtype=float, order="C")) for table in tables)


@lru_cache(maxsize=1)
def no_tableau() -> tuple[Array, ...]:
    """Return arrays of the same kind for a motion that needs none, so that SciPy is not imported for it."""
    return tuple(frozen(np.zeros(shape)) for shape in ((1, 1), 1, 1, 1, 1, (1, 1), (1, 1), 1))


def effective(vectors: Array, sags: bool) -> Array:
    """Fold stated values and what they are off by into the numbers of the equation."""
    p = vectors.copy()
    p[:, kernel.M] *= p[:, kernel.MASS_FACTOR]
    p[:, kernel.TAUT] += p[:, kernel.LENGTH_SHIFT]
    if sags:
        p[:, kernel.SAG] += p[:, kernel.WEIGHT]
    return p


def read_channels(run: Run, packed: Packed, vectors: Array, outs: tuple[Array, ...]) -> tuple[Array | None, ...]:
    """What the instruments make of the motion: x_read = κ·x, T_read = γ·T + T₀ + T₁·(t − t₀), each with its hum."""
    x, v, T = outs
    column = vectors.T[:, :, np.newaxis]
    if packed.on[kernel.SCALE]:
        x, v = column[kernel.SCALE] * x, column[kernel.SCALE] * v
    if run.t_T is not None and packed.on[[kernel.CELL_GAIN, kernel.CELL_ZERO, kernel.CELL_DRIFT]].any():
        T = column[kernel.CELL_GAIN] * T + column[kernel.CELL_ZERO] + column[kernel.CELL_DRIFT] * (run.t_T - run.t0)
    read: list[Array | None] = []
    for size, t, channel in zip(_HUMS, (run.t_x, run.t_v, run.t_T), (x, v, T), strict=True):
        if t is not None and packed.on[size]:
            phase = 2.0 * np.pi * column[kernel.HUM_FREQUENCY] * t + column[kernel.HUM_PHASE]
            channel = channel + column[size] * np.sin(phase)
        read.append(None if t is None else channel)
    return tuple(read)


_SENTENCES = {
    kernel.TOO_MANY_STEPS: "took more than {steps} steps; a rate of the rig may be far too fast for the length of the "
    "run: look at frame.frequency, zener.time, thrust.lag and cubic.stiffness",
    kernel.TOO_MANY_EVENTS: "had more than {events} changes of contact or sliding; the line may bounce without "
    "damping: look at c and the length of the run",
    kernel.CHATTER: "changed its regime again and again without time passing; two effects may contradict each other "
    "there: leave one out",
    kernel.NOT_FINITE: "left all bounds; a line that softens may have lost its stiffness: look at cubic.stiffness",
    kernel.LINE_TOO_SHORT: "went so far that both ends of the line met: look at the start position and `length`",
}


def outcome(status: int, reached: float) -> str:
    """Sentence for a motion that did not reach its end; empty for one that did."""
    if status == kernel.OK:
        return ""
    sentence = _SENTENCES[status].format(steps=kernel.MAX_STEPS, events=kernel.MAX_EVENTS)
    return f"at {reached:.6g} s the motion {sentence}."


_PLAIN = {kernel.CLAMP: "clamp slip", kernel.W_TOE: "toe", kernel.W_TOE_BACK: "toe", kernel.FORCE: "force",
          kernel.RELEASE: "release"}  # fmt: skip


def story(times: Array, codes: Whole) -> tuple[Event, ...]:
    """Events in words, from the kernel's record."""
    events: list[Event] = []
    contact, slide = 0, 1
    for t, code in zip(times.tolist(), codes.tolist(), strict=True):
        what, was_contact, was_slide = code // 100, contact, slide
        contact, slide = code // 10 % 10, code % 10 - 1
        if what == kernel.START:
            continue
        kinds = [_PLAIN[what]] if what in _PLAIN else []
        if (contact == kernel.STRETCHED) != (was_contact == kernel.STRETCHED):
            kinds.append("taut" if contact == kernel.STRETCHED else "slack")
        if (slide == 0) != (was_slide == 0) and what != kernel.RELEASE:
            kinds.append("stick" if slide == 0 else "slip")
        elif what == kernel.W_SPEED:
            kinds.append("turn")
        events += [Event(t, kind) for kind in kinds]
    return tuple(events)
