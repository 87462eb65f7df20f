"""What effects add to the readings of a motion, its derivative by their parameters, and its change with the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrology.effect import ARGUMENTS, Array, Effect, Term
from metrology.rig.hooks import asked
from metrology.rig.parameters import EFFECTS, INDEX, PARAMETERS

Stamps = Sequence[Array | None]
Arguments = tuple[tuple[bool, int], ...]
Added = tuple[int, list[int], Term, Arguments]


def read(
    outs: tuple[Array, ...], stamps: Stamps, t0: float, vectors: Array, acting: tuple[Added, ...]
) -> tuple[Array, ...]:
    """Readings (rows, n) of three channels: to each true value is added what every effect adds to it.

    Parameters
    ----------
    outs : tuple of ndarray, shape (rows, n)
        True position, velocity and tension.
    stamps : sequence of ndarray or None
        Their stamps / s; None for a channel without readings.
    t0 : float
        Start of the run / s.
    vectors : ndarray, shape (rows, len(NAMES))
        Parameters.
    acting : tuple
        What is added, as `added` has it.
    """
    values = vectors.T[:, :, np.newaxis]
    found = list(outs)
    with np.errstate(over="ignore", invalid="ignore"):  # A motion that ran away is infinite, and reported as that.
        for at, _, term, arguments in acting:
            t = stamps[at]
            if t is not None:
                found[at] = found[at] + _value(term, arguments, (outs[at], t, t - t0), values)
    return tuple(found)


def added(on: NDArray[np.bool_]) -> tuple[Added, ...]:
    """What is added to readings where these parameters are off their null."""
    return tuple(one for one in _ADDED if on[one[1]].any())


def _arguments(effect: Effect, term: Term) -> Arguments:
    """For each argument of a term: whether it is one of what is read (else a parameter), and its place there."""
    given = ARGUMENTS["readings"]
    names = {one.short: one.name for one in effect.parameters}
    return tuple(
        (True, given.index(one)) if one in given else (False, INDEX[names.get(one, one)]) for one in asked(term)
    )


def _value(term: Term, arguments: Arguments, seen: tuple[Array, Array, Array], values: Any) -> Any:
    return term(*(seen[at] if is_read else values[at] for is_read, at in arguments))


_ADDED: tuple[Added, ...] = tuple(
    (
        "xvT".index(channel),
        [INDEX[one.name] for one in effect.parameters[: effect.sizes] if one.short in asked(term)],
        term,
        _arguments(effect, term),
    )
    for effect in EFFECTS
    for channel, term in effect.readings.items()
)
"""Channel, places of the sizes, term and arguments of all that is added to readings."""


def slope(name: str, true: dict[str, Array], stamps: dict[str, Array], t0: float, vector: Array) -> dict[str, Array]:
    """Derivative of every channel's readings by one of `READ`, at the true motion.

    By central differences of fourth order of the term itself, which costs no motion.
    """
    entry = PARAMETERS[name]
    effect = next(one for one in EFFECTS if entry in one.parameters)
    h = 1e-3 * entry.scale
    found = {channel: np.zeros_like(part) for channel, part in true.items()}
    for channel, part in true.items():
        term = effect.readings.get(channel)
        if term is None or entry.short not in asked(term):
            continue
        t, arguments = stamps[channel], _arguments(effect, term)
        for shift, weight in ((-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)):
            values = vector.copy()
            values[INDEX[name]] += shift * h
            found[channel] = found[channel] + weight / (12.0 * h) * _value(term, arguments, (part, t, t - t0), values)
    return found


def rate(
    channel: str, true: Array, stamps: tuple[Array, float], vector: Array, acting: tuple[Added, ...]
) -> Array | None:
    """Change of a channel's reading with the true value, shape (n,), by a central difference of what is added to it.

    `stamps`: of the readings, and start of the run / s. `acting`: what is added, as `added` has it; None where nothing
    is, and the reading is the true value.
    """
    own = [one for one in acting if "xvT"[one[0]] == channel]
    if not own:
        return None
    t, t0 = stamps
    h = max(1e-3 * float(np.abs(true).max(initial=0.0)), 1e-6)
    found = np.ones(true.size)
    for _, _, term, arguments in own:
        low, high = (_value(term, arguments, (true + shift, t, t - t0), vector) for shift in (-h, h))
        found = found + (high - low) / (2.0 * h)
    return found
