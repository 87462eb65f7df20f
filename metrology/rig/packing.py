"""Between the rig's values and the kernel's arrays: what goes in, and what comes out in words."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from metrology.message import said
from metrology.rig import added_readings, hooks
from metrology.rig.kernel import layout
from metrology.rig.kernel.steps import LEG_STEPS
from metrology.rig.model import ATTACHMENTS, Rig
from metrology.rig.motion import CHANNELS, Event
from metrology.rig.parameters import BASE, EFFECTS, INDEX, PARAMETERS, SILENT
from metrology.rig.run import Array, Run, frozen

Whole = NDArray[np.int64]
NONE = math.nan
_NULLS = np.array([NONE if one.null is None else one.null for one in PARAMETERS.values()])
_CLOCKS = [layout.CLOCK_X, layout.CLOCK_V, layout.CLOCK_T]
_CURVED = [INDEX[name] for effect in EFFECTS for name in hooks.sizes(effect, curved=True)]
_STATES = [*([place] for place in (layout.FRAME, layout.FRAME, layout.ARM, layout.ARM, layout.APPENDAGE,
                                   layout.APPENDAGE, layout.ZENER, layout.SECOND, layout.HYSTERESIS, layout.LAG,
                                   layout.CELL_LAG)),
           [INDEX[name] for name in hooks.timed()]]  # fmt: skip
"""For each inner state the parameters that call for it, in the order of `layout.FRAME_U` and so on."""
_READS = [INDEX[name] for name in SILENT]
_CLOSED = [*range(len(BASE)), *_READS, *_CLOCKS, layout.MASS_FACTOR, layout.LENGTH_SHIFT, layout.GAIN, layout.DELAY,
           layout.START_X, layout.START_V]  # fmt: skip
"""What the closed form of the base model carries."""
_SHAPES = [at for effect in EFFECTS for at in (INDEX[one.name] for one in effect.parameters[effect.sizes :])]
_OTHERS = np.array(sorted({*range(len(PARAMETERS))} - {*_CLOSED, *_SHAPES}))
SLOWEST = 1e-6
"""Least k/m, 1/s², of a line in closed form; below it the equilibrium is too far off for the digits."""
HAIR = 1e-12
"""Part of its length, or of 1 s, by which a run with shifted clocks is followed further: rounding of its last stamp."""
EMPTY = frozen(np.empty(0))
NO_SPAN = (frozen(np.empty(0, np.int64)), EMPTY)
NO_FORCE = (EMPTY, EMPTY, EMPTY)
NO_ADDED = frozen(np.empty((3, 0)))


class Packed(NamedTuple):
    """A run as the kernel takes it (see `kernel.march.march_many`)."""

    kind: Whole
    at: Whole
    pair: tuple[Array, ...]
    start: Array
    edges: Array
    forces: Array
    slopes: Array
    added: Array
    grids: tuple[Array, ...]
    spans: tuple[Whole, ...]
    spacings: tuple[Array, ...]
    on: NDArray[np.bool_]
    sags: bool
    linear: bool
    base: bool
    reads: tuple[added_readings.Added, ...]
    clocks: bool
    most_events: int


def pack(rig: Rig, run: Run, vectors: Array) -> Packed:
    """Arrays for the motions of `rig` with these rows of parameters in `run`."""
    on = vectors[0] != _NULLS if len(vectors) == 1 else (vectors != _NULLS).any(axis=0)
    known = _of_runs.get(run)
    if known is None:
        known = _of_runs[run] = {}
    key = (rig.attachment, rig.line_weight, on.tobytes())
    packed = known.get(key)
    if packed is None:
        packed = known[key] = _pack(rig, run, on)
    if packed.base and rig.attachment != "none" and not _is_fast_enough(vectors):
        packed = packed._replace(base=False)
    if packed.clocks:
        start = packed.start.copy()
        # A hair longer: else rounding decides whether the last sample, which a clock shifts, still belongs to the run.
        end = run.end + HAIR * max(1.0, abs(run.end))
        start[4] = max(end - min(float(vectors[:, _CLOCKS].min()), 0.0), start[3])
        packed = packed._replace(start=start)
    return packed


_of_runs: WeakKeyDictionary[Run, dict[tuple[str, str, bytes], Packed]] = WeakKeyDictionary()
"""What was packed for a run, by the kind of rig on it: made once, for the sake of short motions."""


def _pack(rig: Rig, run: Run, on: NDArray[np.bool_]) -> Packed:
    together = run.t_x is not None and run.t_x is run.t_v is run.t_T
    kind, at, sags, linear, base, reads = _kind(rig.attachment, rig.line_weight, on.tobytes(), together)
    edges, forces, slopes = NO_FORCE if run.force is None else run.force.pieces
    added = NO_ADDED if run.added is None else frozen(np.array(run.added.pieces))
    grids = tuple(EMPTY if t is None else t for t in (run.t_x, run.t_v, run.t_T))
    evenness = [run.evenness.get(name, NO_SPAN) for name in CHANNELS]
    release = run.t0 if run.held_until is None else run.held_until
    return Packed(
        kind, at, no_tableau() if linear else tableau(),
        np.array([run.x0, run.v0, run.t0, release, max(run.end, release)]),
        edges, forces, slopes, added, grids, tuple(one[0] for one in evenness), tuple(one[1] for one in evenness),
        on, sags, linear, base and not (slopes.any() or added.size), reads, bool(on[_CLOCKS].any()),
        layout.MAX_EVENTS + edges.size,
    )  # fmt: skip


def _is_fast_enough(vectors: Array) -> bool:
    if len(vectors) == 1:  # plain numbers, for the sake of short motions
        value = vectors.item
        return value(layout.K) >= SLOWEST * value(layout.M) * value(layout.MASS_FACTOR)
    return bool((vectors[:, layout.K] >= SLOWEST * vectors[:, layout.M] * vectors[:, layout.MASS_FACTOR]).all())


@lru_cache(maxsize=256)
def _kind(
    attachment: str, line_weight: str, on_bytes: bytes, together: bool
) -> tuple[Whole, Whole, bool, bool, bool, tuple[added_readings.Added, ...]]:
    on = np.frombuffer(on_bytes, dtype=bool)
    at, n = np.full(len(_STATES), layout.NOTHING), 2
    for state, places in enumerate(_STATES):
        if on[places].any():
            at[state], n = n, n + 1
    sags = line_weight == "elastic catenary" or bool(on[layout.SAG])
    weighs = line_weight == "catenary" and not sags
    linear = not (sags or weighs or on[_CURVED].any())
    kind = np.array([ATTACHMENTS.index(attachment), int(weighs), n, int(together)])
    base = linear and not on[_OTHERS].any()
    return kind, at, line_weight == "elastic catenary", linear, base, added_readings.added(on)


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
    p[:, layout.M] *= p[:, layout.MASS_FACTOR]
    p[:, layout.TAUT] += p[:, layout.LENGTH_SHIFT]
    if sags:
        p[:, layout.SAG] += p[:, layout.WEIGHT]
    return p


def read_channels(run: Run, packed: Packed, vectors: Array, outs: tuple[Array, ...]) -> tuple[Array | None, ...]:
    """What the instruments make of the motion; None for a channel that was not asked for."""
    stamps = (run.t_x, run.t_v, run.t_T)
    if packed.reads:
        outs = added_readings.read(outs, stamps, run.t0, vectors, packed.reads)
    elif packed.kind[layout.TOGETHER]:
        return outs
    return tuple(None if t is None else out for t, out in zip(stamps, outs, strict=True))


_SENTENCES = {
    layout.TOO_MANY_STEPS: "at {reached:.6g} s the motion took more than {steps} steps; a rate of the rig may be far "
    "too fast for the length of the run: look at frame.frequency, zener.time, thrust.lag and cubic.stiffness.",
    layout.TOO_MANY_EVENTS: "at {reached:.6g} s the motion had more than {events} changes of contact or sliding; the "
    "line may bounce without damping: look at c and the length of the run.",
    layout.CHATTER: "at {reached:.6g} s the motion changed its regime again and again without time passing; two "
    "effects may contradict each other there: leave one out.",
    layout.NOT_FINITE: "at {reached:.6g} s the motion left all bounds; a line that softens may have lost its "
    "stiffness: look at cubic.stiffness.",
    layout.LINE_TOO_SHORT: "at {reached:.6g} s the motion went so far that both ends of the line met: look at the "
    "start position and `length`.",
}


def outcome(status: int, reached: float) -> str:
    """Sentence for a motion that did not reach its end; empty for one that did."""
    if status == layout.OK:
        return ""
    limits = {"steps": LEG_STEPS, "events": layout.MAX_EVENTS}
    return said(_SENTENCES[status], reached=float(reached), **limits)


_PLAIN = {layout.CLAMP: "clamp slip", layout.W_TOE: "toe", layout.W_TOE_BACK: "toe", layout.FORCE: "force",
          layout.RELEASE: "release"}  # fmt: skip


def story(times: Array, codes: Whole) -> tuple[Event, ...]:
    """Events in words, from the kernel's record."""
    events: list[Event] = []
    contact, slide = 0, 1
    for t, code in zip(times.tolist(), codes.tolist(), strict=True):
        what, was_contact, was_slide = code // 100, contact, slide
        contact, slide = code // 10 % 10, code % 10 - 1
        if what == layout.START:
            continue
        kinds = [_PLAIN[what]] if what in _PLAIN else []
        if (contact == layout.STRETCHED) != (was_contact == layout.STRETCHED):
            kinds.append("taut" if contact == layout.STRETCHED else "slack")
        if (slide == 0) != (was_slide == 0) and what != layout.RELEASE:
            kinds.append("stick" if slide == 0 else "slip")
        elif what == layout.W_SPEED:
            kinds.append("turn")
        events += [Event(t, kind) for kind in kinds]
    return tuple(events)
