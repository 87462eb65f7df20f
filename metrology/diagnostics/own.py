"""Effects of the laboratory's own as candidates, and what they add to readings under dead loads."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from metrology.diagnostics.candidate import Candidate, candidate
from metrology.diagnostics.subject import Array
from metrology.errors import Fault, MetrologyError
from metrology.rig import Rig, Run, simulate
from metrology.rig.own import OwnEffect, placed


class OwnError(MetrologyError):
    """Code of the laboratory's own that fails: no result of its campaign can be trusted before it is fixed."""


def declared(effect: OwnEffect) -> Candidate:
    """Return the candidate that a laboratory's file declares."""
    return candidate(effect.entry, effect.entry.causes[0])


def added(effect: OwnEffect, readings: tuple[Array, Array, Array], values: Mapping[str, float]) -> Array:
    """What one unit of the size of an effect adds to every reading.

    Parameters
    ----------
    effect : OwnEffect
        With a `reading`.
    readings : tuple of array
        Force / N, number within its repeat, and 1 when unloading, of every reading, shape (n,).
    values : mapping of str to float
        Shapes by their full names; their nulls where not given.

    Raises
    ------
    OwnError
        With file and line: a function that fails, another number of values, a value that is not finite.
    """
    assert effect.reading is not None
    shapes = {one.name: values.get(f"{effect.name}.{one.name}", one.null) for one in effect.parameters[1:]}
    expected = "metres for one unit of the size, for each reading"
    return called(effect.reading, f"own.{effect.name}.reading", readings, shapes, expected=expected)


def called(
    function: Callable[..., Array], name: str, arrays: tuple[Array, ...], values: Mapping[str, float], *, expected: str
) -> Array:
    """Return what a function of the laboratory's own gives for arrays, one finite number for each of their elements.

    Raises
    ------
    OwnError
        With file and line: a function that fails, another number of values, a value that is not finite.
    """
    try:
        with np.errstate(all="ignore"):
            found = np.asarray(function(*(one.copy() for one in arrays), **values), dtype=float)
    except Exception as error:
        got = f"{type(error).__name__}: {error}"
        raise OwnError(Fault(placed(function, name, error), got, expected)) from error
    if found.shape not in ((), arrays[0].shape):
        got = f"shape {found.shape}"
        raise OwnError(Fault(placed(function, name), got, f"{arrays[0].shape}, {expected}"))
    if not np.isfinite(found).all():
        at = int(np.flatnonzero(~np.isfinite(np.broadcast_to(found, arrays[0].shape)))[0])
        got = f"{np.broadcast_to(found, arrays[0].shape)[at]} where its arguments are " + ", ".join(
            f"{one[at]:.4g}" for one in arrays
        )
        raise OwnError(Fault(placed(function, name), got, expected))
    return np.broadcast_to(found, arrays[0].shape)


LOOKED_AT = 400
"""Moments of a motion at which a force is tried before anything is fitted."""


def check_forces(effects: Iterable[OwnEffect], rig: Rig, run: Run) -> None:
    """Try every force along the motion of the model without it, so that a wrong one is told before anything is fitted.

    Raises
    ------
    OwnError
        With file and line.
    """
    forces = [effect for effect in effects if effect.force]
    t = np.linspace(run.t0, run.end, LOOKED_AT)
    motion = simulate(rig.without_own(), replace(run, t_x=t, t_v=t, t_T=t)) if forces else None
    if motion is None or motion.status != "ok":
        return
    x, v, T = (np.asarray(one, dtype=float) for one in (motion.x, motion.v, motion.T))
    for effect in forces:
        assert effect.force is not None
        values = {one.name: one.null for one in effect.parameters} | {effect.parameters[0].name: _small(effect)}
        state = (t, x, v, x - rig.taut, T)
        called(effect.force, f"own.{effect.name}.force", state, values, expected="a force in N for each time")


def _small(effect: OwnEffect) -> float:
    size = effect.parameters[0]
    return size.null + size.scale if size.null + size.scale <= size.high else size.null - size.scale
