"""The motion that comes out of a simulation: what the channels read, and the events."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from metrology.rig.run import Array

CHANNELS = ("x", "v", "T")


@dataclass(frozen=True)
class Event:
    """A change of regime at time `t` / s.

    `kind` is one of 'taut', 'slack', 'stick', 'slip' (the module starts to slide), 'turn' (its velocity changes sign),
    'clamp slip', 'toe', 'force', 'release'.
    """

    t: float
    kind: str


@dataclass(frozen=True, eq=False)
class Motion:
    """What the channels read.

    Parameters
    ----------
    x, v, T : ndarray or None
        Position / m, velocity / (m/s) and tension / N at exactly the requested stamps; None where not asked for.
        From the time of a failure on they are NaN.
    record : callable
        Gives the events; `events` calls it once, when it is asked for.
    status : {'ok', 'invalid'}
        Whether the integration reached the end.
    message : str
        Where invalid: what happened, what it may mean, what to try.
    engine : str
        'compiled', 'numpy' or 'interpreted'.
    steps : int
        Of regimes that are not linear.
    states : int
        Unknowns of the equation of motion; with `steps` what the motion costs, counted, alike on every machine.
    """

    x: Array | None
    v: Array | None
    T: Array | None
    record: Callable[[], tuple[Event, ...]] = field(repr=False)
    status: Literal["ok", "invalid"]
    message: str
    engine: str
    steps: int = 0
    states: int = 2

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Changes of regime in order of time."""
        return self.record()
