"""Between the rig's values and the kernel's arrays: what goes in, and what comes out in words."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrology.rig import kernel
from metrology.rig.effects import INDEX
from metrology.rig.model import ATTACHMENTS, Array, Event, Rig, Run

Whole = NDArray[np.int64]
NONE = np.empty(0)


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
    grids: tuple[Array, Array, Array]
    spans: tuple[Whole, Whole, Whole]
    sags: bool
    linear: bool
    most_events: int


def pack(rig: Rig, run: Run, vectors: Array) -> Packed:
    """Arrays for the motions of `rig` with these rows of parameters in `run`."""
    kind, at, linear = _kind(rig, vectors)
    edges, forces, slopes = _pieces(run)
    release = run.t0 if run.held_until is None else run.held_until
    grids = tuple(NONE if t is None else t for t in (run.t_x, run.t_v, run.t_T))
    return Packed(
        kind, at, tableau() if not linear else no_tableau(),
        np.array([run.x0, run.v0, run.t0, release, _end(run, vectors)]), edges, forces, slopes,
        grids, tuple(spans(grid) for grid in grids),
        rig.line_weight == "elastic catenary", linear, kernel.MAX_EVENTS + edges.size,
    )  # type: ignore[arg-type]  # fmt: skip


def _end(run: Run, vectors: Array) -> float:
    early = vectors[:, [INDEX["clock.x"], INDEX["clock.v"], INDEX["clock.T"]]].min()
    release = run.t0 if run.held_until is None else run.held_until
    return max(run.end - min(float(early), 0.0), release)


def _kind(rig: Rig, vectors: Array) -> tuple[Whole, Whole, bool]:
    def on(name: str) -> bool:
        return bool((vectors[:, INDEX[name]] != 0).any())

    active = {
        kernel.FRAME_U: on("frame.compliance"), kernel.FRAME_V: on("frame.compliance"),
        kernel.YAW_U: on("yaw.arm"), kernel.YAW_V: on("yaw.arm"),
        kernel.RELAXED: on("zener.stiffness"), kernel.LOOP: on("hysteresis.stiffness"), kernel.THRUST: on("thrust.lag"),
    }  # fmt: skip
    at, n = np.full(7, kernel.NOTHING), 2
    for state, is_on in active.items():
        if is_on:
            at[state], n = n, n + 1
    sags = rig.line_weight == "elastic catenary" or on("sag.weight")
    weighs = rig.line_weight == "catenary" and not sags
    curved = ("drag.quadratic", "cubic.stiffness", "damping.amplitude", "hysteresis.stiffness")
    linear = not (sags or weighs or any(on(name) for name in curved))
    return np.array([ATTACHMENTS.index(rig.attachment), int(weighs), n]), at, linear


def _pieces(run: Run) -> tuple[Array, Array, Array]:
    if run.force is None:
        return NONE, NONE, NONE
    t, values = run.force.t, run.force.values
    if run.force.kind == "constant":
        return t, values, np.zeros(len(t))
    slopes = np.append(np.diff(values) / np.diff(t), 0.0)
    return t, values, slopes


@lru_cache(maxsize=64)
def _spans(stamps: bytes) -> Whole:
    t = np.frombuffer(stamps)
    ends = np.arange(t.size)
    if t.size < 3:
        return ends
    # Rounding of the stamps themselves makes steps differ in their last digits.
    allowed = 4.0 * np.spacing(np.abs(t).max())
    uneven = np.flatnonzero(np.abs(np.diff(t, 2)) > 2.0 * allowed) + 1
    first = 0
    for last in [*uneven.tolist(), t.size - 1]:
        even = np.linspace(t[first], t[last], last - first + 1)
        if last > first + 1 and np.abs(even - t[first : last + 1]).max() <= 2.0 * allowed:
            ends[first:last] = last
        first = last
    ends.setflags(write=False)
    return ends


def spans(grid: Array) -> Whole:
    """For each stamp the last one of the evenly spaced stretch that it stands in."""
    return _spans(grid.tobytes())


@lru_cache(maxsize=1)
def tableau() -> tuple[Array, ...]:
    """Coefficients of Dormand and Prince's 8(5,3) pair with its 7th-order interpolant (Hairer, Nørsett, Wanner, II.5)."""
    from scipy.integrate import DOP853

    pair: Any = DOP853
    tables = (pair.A, pair.B, pair.C, pair.E3, pair.E5, pair.D, pair.A_EXTRA, pair.C_EXTRA)
    return tuple(np.ascontiguousarray(table, dtype=float) for table in tables)


@lru_cache(maxsize=1)
def no_tableau() -> tuple[Array, ...]:
    """Return arrays of the same kind for a motion that needs none, so that SciPy is not imported for it."""
    return tuple(np.zeros(shape) for shape in ((1, 1), 1, 1, 1, 1, (1, 1), (1, 1), 1))


def effective(vectors: Array, sags: bool) -> Array:
    """Fold stated values and what they are off by into the numbers of the equation."""
    p = vectors.copy()
    p[:, kernel.M] *= p[:, kernel.MASS_FACTOR]
    p[:, kernel.TAUT] += p[:, kernel.LENGTH_SHIFT]
    if sags:
        p[:, kernel.SAG] += p[:, kernel.WEIGHT]
    return p


def read_channels(run: Run, vectors: Array, outs: tuple[Array, ...]) -> tuple[Array | None, ...]:
    """What the instruments make of the motion: x_read = κ·x, T_read = γ·T + T₀ + T₁·(t − t₀), each with its hum."""
    x, v, T = outs
    cell = [vectors[:, [INDEX[name]]] for name in ("cell.gain", "cell.zero", "cell.drift")]
    scale = vectors[:, [INDEX["motion.scale"]]]
    if (scale != 1.0).any():
        x, v = scale * x, scale * v
    if run.t_T is not None and ((cell[0] != 1.0) | (cell[1] != 0.0) | (cell[2] != 0.0)).any():
        T = cell[0] * T + cell[1] + cell[2] * (run.t_T - run.t0)
    return tuple(
        None if t is None else _hum(vectors, f"hum.{name}", t, channel)
        for name, t, channel in zip("xvT", (run.t_x, run.t_v, run.t_T), (x, v, T), strict=True)
    )


def _hum(vectors: Array, name: str, t: Array, channel: Array) -> Array:
    size, frequency, phase = (vectors[:, [INDEX[one]]] for one in (name, "hum.frequency", "hum.phase"))
    if not (size != 0).any():
        return channel
    hum: Array = channel + size * np.sin(2.0 * np.pi * frequency * t + phase)
    return hum


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
