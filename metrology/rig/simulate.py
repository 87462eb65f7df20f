"""Motions from a rig and a run: one, or thousands."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrology.errors import Fault, MetrologyError
from metrology.rig.closed import LEG
from metrology.rig.kernel import layout
from metrology.rig.model import Rig
from metrology.rig.motion import CHANNELS, Motion
from metrology.rig.packing import Packed, effective, outcome, pack, read_channels, story
from metrology.rig.parameters import INDEX
from metrology.rig.run import Array, Run

NO_LEGS = np.empty((0, layout.LEG))
MANY = 32
"""Motions in one call from which on loading the compiled kernel pays, where NumPy would do."""

FASTEST = 1e20
"""Rate of a line, c/m or √(k/m), from which on it is not followed / (1/s): the steps that a motion may take last for
minutes there, and a fit that is lost goes there (a mass in grams for kilograms: c = 10²⁴ N·s/m)."""


@dataclass(frozen=True)
class Motions:
    """Many motions of one run.

    Parameters
    ----------
    x, v, T : ndarray or None
        Shape (n, samples), one row for each set of values; NaN from a failure on; None where not asked for.
    valid : ndarray of bool, shape (n,)
        Which of them reached the end.
    messages : tuple of str, length n
        Empty where valid.
    """

    x: Array | None
    v: Array | None
    T: Array | None
    valid: NDArray[np.bool_]
    messages: tuple[str, ...]


def simulate(rig: Rig, run: Run, *, engine: str = "auto") -> Motion:
    """Motion of the rig in one run, exact between events where the equation is linear.

    Parameters
    ----------
    rig : Rig
        Numbers of the equation.
    run : Run
        Start, thrust and time stamps.
    engine : {'auto', 'compiled', 'numpy', 'interpreted'}
        How to integrate. 'auto' takes the compiled kernel, except for a linear rig while that is not loaded yet, for
        which NumPy does and nothing has to be compiled. The two differ by about 1e-9 of the largest value: name one
        where the last digits have to repeat.

    Returns
    -------
    Motion
        With status 'invalid' and a sentence, and NaN from then on, where it cannot be followed to its end.

    Raises
    ------
    MetrologyError
        Where `rig` or `run` is something else.

    Examples
    --------
    A module of 1 kg on a spring of 4 N/m that also pushes, let go at 0.1 m, is there again after a period of π s:

    >>> import numpy as np
    >>> motion = simulate(Rig(1.0, 4.0, attachment="both ways"), Run.sampled([0.0, np.pi / 2, np.pi], 0.1))
    >>> motion.x.round(12).tolist()
    [0.1, -0.1, 0.1]
    """
    for got, kind in ((rig, Rig), (run, Run)):
        if not isinstance(got, kind):
            raise MetrologyError(Fault("simulate", f"{got!r:.60}", f"a {kind.__name__}: simulate(rig, run)"))
    if rig.own:
        return _simulate_own(rig, run, engine)
    values = np.array(rig.vector(), ndmin=2)
    packed = pack(rig, run, values)
    name, march = engine_for(engine, packed, 1)
    outs, states, times, codes = march_rows(march, packed, values, packed.base and name != "interpreted")
    x, v, T = read_channels(run, packed, values, outs)
    status, count, reached, steps = states[0].tolist()
    message, events = outcome(int(status), reached), int(count)
    return Motion(
        x=_row(x), v=_row(v), T=_row(T), record=partial(story, times[:events].copy(), codes[:events].copy()),
        status="invalid" if message else "ok", message=message, engine=name,
        steps=int(steps), states=int(packed.kind[layout.N]),
    )  # fmt: skip


def _simulate_own(rig: Rig, run: Run, engine: str) -> Motion:
    if not any(own.acts(rig.effects) for own in rig.own):
        return simulate(rig.without_own(), run, engine=engine)
    from metrology.rig.picard import follow

    # Their tables have thousands of pieces, which NumPy alone is slow at.
    taken = "compiled" if engine == "auto" else engine
    return follow(rig, run, lambda rig, run: simulate(rig, run, engine=taken))


def simulate_many(
    rig: Rig, run: Run, names: Sequence[str], values: Array, *, threads: int = 1, engine: str = "auto"
) -> Motions:
    """Motions for many sets of values at once (Monte Carlo bands, derivatives).

    Parameters
    ----------
    rig, run : Rig, Run
        As for `simulate`.
    names : sequence of str, length p
        Parameters that vary, any of `NAMES`.
    values : array_like, shape (n, p)
        Their values.
    threads : int
        Threads to share the work (the compiled kernel does not hold the interpreter's lock).
    engine : str
        As for `simulate`.

    Returns
    -------
    Motions
        x, v and T, each of shape (n, stamps), in SI; `valid` tells which rows could be followed.

    Raises
    ------
    MetrologyError
        For an unknown name, or a value that the equation does not allow.
    """
    rows = np.atleast_2d(np.asarray(values, dtype=float))
    if rig.own:
        return _one_by_one(rig, run, names, rows, engine)
    vectors = _vectors(rig, names, rows)
    packed = pack(rig, run, vectors)
    name, march = engine_for(engine, packed, len(vectors))
    base = packed.base and name != "interpreted"
    shares = np.array_split(vectors, max(1, min(threads, len(vectors))))
    if len(shares) == 1:
        parts = [march_rows(march, packed, vectors, base)]
    else:
        with ThreadPoolExecutor(len(shares)) as pool:
            parts = list(pool.map(lambda share: march_rows(march, packed, share, base), shares))
    outs, states = parts[0][:2]
    if len(parts) > 1:
        outs = tuple(np.concatenate([part[0][channel] for part in parts]) for channel in range(3))
        states = np.concatenate([part[1] for part in parts])
    x, v, T = read_channels(run, packed, vectors, outs)
    messages = tuple(outcome(int(status), float(reached)) for status, _, reached, _ in states)
    return Motions(x=x, v=v, T=T, valid=states[:, 0] == 0, messages=messages)


def _one_by_one(rig: Rig, run: Run, names: Sequence[str], values: Array, engine: str) -> Motions:
    _require_possible(rig, names, values)
    rigs = [rig.with_values(dict(zip(names, row, strict=True))) for row in values.tolist()]
    motions = [simulate(one, run, engine=engine) for one in rigs]
    x, v, T = (
        None if getattr(motions[0], name) is None else np.array([getattr(one, name) for one in motions])
        for name in CHANNELS
    )
    valid = np.array([one.status == "ok" for one in motions])
    return Motions(x=x, v=v, T=T, valid=valid, messages=tuple(one.message for one in motions))


def require_known(rig: Rig, names: Sequence[str]) -> None:
    """Raise where the rig has no parameter of such a name."""
    unknown = [name for name in names if name not in rig.parameters]
    if unknown:
        expected = "the name of a parameter, such as 'k' or 'friction.force'"
        raise MetrologyError(*(Fault(f"rig.{name}", f"'{name}'", expected) for name in unknown))


def _require_possible(rig: Rig, names: Sequence[str], values: Array) -> None:
    require_known(rig, names)
    if values.shape[1:] != (len(names),):
        raise MetrologyError(Fault("rig.values", f"shape {values.shape}", f"(n, {len(names)}), a column for each name"))
    for column, name in enumerate(names):
        entry = rig.parameters[name]
        inside = np.isfinite(values[:, column]) & (values[:, column] >= entry.low) & (values[:, column] <= entry.high)
        if not inside.all():
            # The rig's own check has the words for it.
            rig.with_values({name: float(values[np.flatnonzero(~inside)[0], column])})


def _vectors(rig: Rig, names: Sequence[str], values: Array) -> Array:
    _require_possible(rig, names, values)
    vectors = np.tile(rig.vector(), (len(values), 1))
    vectors[:, [INDEX[name] for name in names]] = values
    return vectors


def _row(channel: Array | None) -> Array | None:
    return None if channel is None else channel[0]


March = Callable[..., None]


def engine_for(engine: str, packed: Packed, rows: int) -> tuple[str, March]:
    """Name and function of the engine that follows this many motions."""
    from metrology.rig import engines

    if engine not in ("auto", "compiled", "numpy", "interpreted"):
        raise MetrologyError(Fault("rig.engine", repr(engine), "'auto', 'compiled', 'numpy' or 'interpreted'"))
    if engine == "interpreted":
        return engine, engines.interpreted()
    base = packed.base
    pieces = rows * max(len(packed.edges), 1)
    alone = engine == "auto" and packed.linear and pieces < MANY and not engines.is_loaded(base)
    march = None if engine == "numpy" or alone else engines.compiled(base)
    return ("numpy", engines.numpy(base)) if march is None else ("compiled", march)


def march_rows(
    march: March, packed: Packed, vectors: Array, base: bool, legs: Array = NO_LEGS
) -> tuple[Any, Array, Array, NDArray[np.int64]]:
    """Motions of these rows of parameters: channels, outcomes, and the last one's events and, in `legs`, its legs."""
    if (fast := _too_fast(vectors)).any():
        vectors = vectors.copy()
        for name in ("k", "c"):
            vectors[fast, INDEX[name]] = 1.0
        found = march_rows(march, packed, vectors, base, legs)
        found[1][fast] = layout.TOO_MANY_STEPS, 0, packed.start[2], 0
        for channel in found[0]:
            channel[fast] = np.nan
        return found
    # One block for all channels: memory of that size is handed back and forth without being cleared page by page.
    rows, (x, v, T) = len(vectors), packed.grids
    if x is v is T:
        outs = tuple(np.empty((3, rows, x.size)))
    else:
        x, v, T = np.split(np.empty(rows * (x.size + v.size + T.size)), (rows * x.size, rows * (x.size + v.size)))
        outs = (x.reshape(rows, -1), v.reshape(rows, -1), T.reshape(rows, -1))
    states = np.empty((rows, 4))
    times, codes, closed_legs = _record(packed.most_events)
    if base:
        march(
            vectors, packed.kind, packed.start, packed.edges, packed.forces, packed.grids, packed.spans,
            packed.spacings, outs, times, codes, states, closed_legs,
        )  # fmt: skip
        return outs, states, times, codes
    march(
        effective(vectors, packed.sags), packed.kind, packed.at, packed.pair, packed.start, packed.edges,
        packed.forces, packed.slopes, packed.added, packed.grids, packed.spans, packed.spacings, outs,
        times, codes, states, legs,
    )  # fmt: skip
    return outs, states, times, codes


def _too_fast(vectors: Array) -> NDArray[np.bool_]:
    """Rows whose line is faster than `FASTEST`."""
    mass = vectors[:, INDEX["m"]] * vectors[:, INDEX["mass.factor"]]
    return np.asarray((vectors[:, INDEX["c"]] > FASTEST * mass) | (vectors[:, INDEX["k"]] > FASTEST**2 * mass))


_kept = threading.local()


def _record(length: int) -> tuple[Array, NDArray[np.int64], Array]:
    # Kept from call to call: fresh memory of this size costs more than a whole motion.
    if getattr(_kept, "length", 0) < length:
        _kept.length, _kept.times, _kept.codes = length, np.empty(length), np.empty(length, np.int64)
        _kept.legs = np.empty((length + 1, LEG))
    return _kept.times, _kept.codes, _kept.legs
