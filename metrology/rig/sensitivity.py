"""Exact derivatives of what the channels read by the parameters of a rig."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.rig import added_readings, hooks
from metrology.rig.collocation import rule
from metrology.rig.kernel import layout
from metrology.rig.model import Rig
from metrology.rig.motion import CHANNELS
from metrology.rig.packing import effective, outcome, pack, tableau
from metrology.rig.parameters import EFFECTS, INDEX
from metrology.rig.run import Array, Force, Run, frozen
from metrology.rig.simulate import march_rows, require_known, simulate, simulate_many
from metrology.rig.tangent.differences import STAMPS
from metrology.rig.tangent.trace import trace as differentiate

NO_PUSHES = frozen(np.empty((0, 0)))
RAMP = 1e-6
"""Part of a step of force in which it changes to the next, where motions are compared."""
BARELY = 1e-200
"""In place of a size at its null: every event that it makes is there, and nothing else changes."""
_SIZES = {one.name for effect in EFFECTS for one in effect.parameters[: effect.sizes] if one.null == 0.0}
_SHIFTED = {"T": "cell_lag.time"}
_SAME = {"mass.factor": "m", "free_length.shift": "taut"}


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Derivatives of the channels by parameters.

    Parameters
    ----------
    names : tuple of str, length p
        The parameters.
    x, v, T : ndarray or None
        Shape (samples, p), in unit of the channel per unit of the parameter; None for a channel without stamps.
    valid : bool
        Whether the motion reached its end; else the derivatives are NaN from there on.
    message : str
        Why it did not.
    """

    names: tuple[str, ...]
    x: Array | None
    v: Array | None
    T: Array | None
    valid: bool
    message: str = ""


def sensitivities(rig: Rig, run: Run, names: Sequence[str], *, engine: str = "auto") -> Sensitivities:
    """Derivatives of every channel by these parameters, exact through contacts.

    Forward sensitivities S′ = f_y·S + f_p between the events and the saltation matrix at each of them (Leine &
    Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004, 7.2); gain, zero, drift,
    scale and tonal interference of the readings by closed form, the delay of a channel by its rate of change.

    At the null of an effect, and at the edge of a range, they are one-sided; a sample that stands at a contact has the
    derivative of the side on which it stands. For effects of the laboratory's own, given as Python functions, and where
    there is no compiler, differences take their place.

    Parameters
    ----------
    rig, run : Rig, Run
        As for `simulate`.
    names : sequence of str, length p
        Any of `rig.parameters`.
    engine : {'auto', 'compiled', 'interpreted'}
        How to integrate; 'interpreted' is slow and needs no compiler.

    Returns
    -------
    Sensitivities
        Columns in the order of `names`; not valid, with a message, where the motion cannot be followed to its end.

    Raises
    ------
    MetrologyError
        For a name that the rig does not have.

    Examples
    --------
    A free mass: dx/dv₀ = t and dx/dx₀ = 1.

    >>> found = sensitivities(Rig(1.0, 0.0, attachment="none"), Run.sampled([0.0, 2.0], 0.0), ["start.v", "start.x"])
    >>> found.x.round(9).tolist()
    [[0.0, 1.0], [2.0, 1.0]]
    """
    require_known(rig, names)
    own = {one.name for entry in rig.own for one in entry.effect.parameters}
    programs = _programs(engine)
    if programs is None or any(entry.acts(rig.effects) for entry in rig.own) or own & {*names}:
        return _differences(rig, run, names, engine)
    return follow(rig.without_own(), run, tuple(names), programs)


def pushed(rig: Rig, run: Run, edges: Array, forces: Array, *, engine: str = "auto") -> Sensitivities:
    """What small forces on the module change in every channel, to first order and exact through contacts.

    Where there is no compiler, and for effects of the laboratory's own, half the difference of two motions takes its
    place: the forces have to be so small that the motion is straight in them.

    Parameters
    ----------
    rig, run : Rig, Run
        As for `simulate`.
    edges : ndarray, shape (n,)
        Times / s, increasing, from which on each force lasts to the next; the last to the end of the run.
    forces : ndarray, shape (n, q)
        Forces / N, each column one.
    engine : {'auto', 'compiled', 'interpreted'}
        As for `sensitivities`.

    Returns
    -------
    Sensitivities
        Without names; changes of shape (samples, q) in the unit of each channel.
    """
    known = run.added
    times = np.union1d(edges, [run.t0, run.end] if known is None else known.t)
    still = np.zeros(len(times)) if known is None else np.interp(times, known.t, known.values)
    lasting = np.searchsorted(edges, times, side="right") - 1
    steps = np.where(lasting[:, None] >= 0, forces[np.maximum(lasting, 0)], 0.0)
    programs = _programs(engine)
    if programs is None or any(entry.acts(rig.effects) for entry in rig.own):
        return _apart(rig, run, times, still, steps, engine)
    stepped = replace(run, added=Force(times, still, "linear"))
    return follow(rig.without_own(), stepped, (), programs, np.ascontiguousarray(steps))


March = Callable[..., None]


def _programs(engine: str) -> tuple[March, March] | None:
    """March and trace; None without a compiler, since plain Python takes minutes where differences take seconds."""
    from metrology.rig import engines

    if engine == "interpreted":
        return engines.interpreted(), differentiate
    march, trace = engines.loaded("kernel"), engines.loaded("tangent")
    return None if march is None or trace is None else (march, trace)


def follow(
    rig: Rig, run: Run, names: tuple[str, ...], programs: tuple[March, March], pushes: Array = NO_PUSHES
) -> Sensitivities:
    """Derivatives by a march along the events and a trace along its legs, both of them compiled or plain Python.

    After the columns of the names those by `pushes`, small forces from each edge of the run's added force on.
    """
    plan = [_moved_by(rig, name) for name in names]
    values = np.array(rig.vector(), ndmin=2)
    for name in names:
        if name in _SIZES and rig.value(name) == 0.0 and name not in ("thrust.lag", "cell_lag.time", "sag.weight"):
            values[0, INDEX[name]] = BARELY
    packed = pack(rig, run, values)
    if "sag.weight" in names and packed.linear:
        packed = packed._replace(pair=tableau())  # nonlinear steps, which the motion itself does not need
    legs = np.empty((packed.most_events + 2, layout.LEG))
    outs, states, _, _ = march_rows(programs[0], packed, values, False, legs)
    status, _, reached, _ = states[0].tolist()
    message = outcome(int(status), reached)
    true = [channel[0] for channel in outs]
    own = {STAMPS - 1 - at: len(names) + at for at in range(pushes.shape[1])}
    found = tuple(np.zeros((len(names) + len(own) + 1, channel.size)) for channel in true)
    which = [*(one for one in dict.fromkeys(at for at, _ in plan) if one is not None), *own]
    if which and not message:
        rows = {at: [one for one, _ in plan].index(at) for at in which if at >= 0}
        first = {**rows, **own, STAMPS: len(names) + len(own)}
        parameters = [rig.parameters[list(INDEX)[max(at, 0)]] for at in which]
        programs[1](
            legs, effective(values, packed.sags)[0], np.array(which),
            np.array([1e-3 * one.scale for one in parameters]), np.array([one.low for one in parameters]),
            packed.kind, packed.at, packed.pair, rule(), packed.start, packed.edges, packed.forces, packed.slopes,
            packed.added, pushes, packed.grids, packed.spans, packed.spacings, found,
            np.array([first[at] for at in which]),
        )  # fmt: skip
        _spread(names, plan, first, found)
    if message:
        for channel in found:
            channel[:] = np.nan
    _read((rig, run, packed.reads), names, true, found)
    x, v, T = (
        None if t is None else channel[:-1].T for t, channel in zip((run.t_x, run.t_v, run.t_T), found, strict=True)
    )
    return Sensitivities(names, x, v, T, not message, message)


def _moved_by(rig: Rig, name: str) -> tuple[int | None, float]:
    """Position in the kernel's vector of the parameter by which `name` acts on the motion, and the factor; or None."""
    # A short lag of the cell shifts the tension like a clock.
    if name.startswith("clock.") or (name == "cell_lag.time" and rig.value(name) == 0.0):
        return STAMPS, 1.0
    if name in hooks.READ:
        return None, 0.0
    if name == "thrust.lag" and rig.value(name) == 0.0:  # a short lag shifts the thrust like a delay
        return layout.DELAY, 1.0
    if name == "weight" and rig.line_weight == "elastic catenary":
        return layout.SAG, 1.0
    factor = {"m": rig.value("mass.factor"), "mass.factor": rig.m}.get(name, 1.0)
    return INDEX[_SAME.get(name, name)], factor


def _spread(
    names: tuple[str, ...], plan: list[tuple[int | None, float]], first: dict[int, int], found: tuple[Array, ...]
) -> None:
    """Give each name its row, where several act as one, by a factor, or on one channel alone."""
    for row in reversed(range(len(names))):
        at, factor = plan[row]
        if at is None:
            continue
        for name, channel in zip(CHANNELS, found, strict=True):
            if at == STAMPS:
                if names[row] in (f"clock.{name}", _SHIFTED.get(name)):
                    channel[row] = channel[-1]
            elif first[at] != row or factor != 1.0:
                np.multiply(channel[first[at]], factor, out=channel[row])


def _read(
    model: tuple[Rig, Run, tuple[added_readings.Added, ...]], names: tuple[str, ...], true: Sequence[Array],
    found: tuple[Array, ...],
) -> None:  # fmt: skip
    """Put in what the instruments make of the motion, and the derivatives by what they add to it."""
    rig, run, acting = model
    vector = rig.vector()
    stamps = {name: t for name in CHANNELS if (t := getattr(run, f"t_{name}")) is not None}
    motion = {name: one for name, one in zip(CHANNELS, true, strict=True) if name in stamps}
    for name, rows in zip(CHANNELS, found, strict=True):
        rate = (
            added_readings.rate(name, motion[name], (stamps[name], run.t0), vector, acting) if name in motion else None
        )
        if rate is not None:
            rows *= rate
    for row, wanted in enumerate(names):
        if wanted in hooks.READ:
            by = added_readings.slope(wanted, motion, stamps, run.t0, vector)
            for name, rows in zip(CHANNELS, found, strict=True):
                if name in by:
                    rows[row] = by[name]


# ---- effects of the laboratory's own --------------------------------------------------------------------------------
def _apart(rig: Rig, run: Run, times: Array, still: Array, steps: Array, engine: str) -> Sensitivities:
    """Half the difference of the motions with each force and with its opposite; a step is a steep ramp."""
    ends = times[1:] - RAMP * np.diff(times)
    edges = np.sort(np.concatenate([times, ends]))
    from_, known = np.searchsorted(times, edges, side="right") - 1, np.interp(edges, times, still)
    pairs = []
    for column in steps.T:
        both = (Force(edges, known + sign * column[from_], "linear") for sign in (1, -1))
        pairs.append([simulate(rig, replace(run, added=one), engine=engine) for one in both])
    x, v, T = (
        None if getattr(pairs[0][0], name) is None
        else np.column_stack([0.5 * (getattr(one, name) - getattr(other, name)) for one, other in pairs])
        for name in CHANNELS
    )  # fmt: skip
    failed = [one.message for pair in pairs for one in pair if one.status != "ok"]
    return Sensitivities((), x, v, T, not failed, next(iter(failed), ""))


def _differences(rig: Rig, run: Run, names: Sequence[str], engine: str) -> Sensitivities:
    """Central differences of second order, one-sided at the edge of a parameter's range."""
    centre = np.array([rig.value(name) for name in names])
    plans = [_stencil(rig, name, value) for name, value in zip(names, centre.tolist(), strict=True)]
    rows = [centre + shift * np.eye(len(names))[at] for at, (shifts, _) in enumerate(plans) for shift in shifts]
    moved = simulate_many(rig, run, names, np.array([*rows, centre]), engine=engine)
    weights = np.zeros((len(names), len(rows)))
    for at, (_, factors) in enumerate(plans):
        weights[at, 2 * at : 2 * at + 2] = factors
    # Subtracted first: where a parameter moves nothing, the derivative is then exactly zero on every processor.
    x, v, T = (
        None if channel is None else (weights @ (channel[:-1] - channel[-1])).T
        for channel in (moved.x, moved.v, moved.T)
    )
    return Sensitivities(tuple(names), x, v, T, bool(moved.valid.all()), next(filter(None, moved.messages), ""))


def _stencil(rig: Rig, name: str, value: float) -> tuple[Array, Array]:
    entry = rig.parameters[name]
    h = 1e-5 * abs(value) if name in ("m", "k", "c") and value else 2e-3 * entry.scale
    if entry.low <= value - h and value + h <= entry.high:
        return np.array([-h, h]), np.array([-0.5, 0.5]) / h
    h = h if value + 2 * h <= entry.high else -h
    return np.array([h, 2 * h]), np.array([2.0, -0.5]) / h
