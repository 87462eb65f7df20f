"""What goes into the evaluation of a response test: rig and runs, what is sought, and what is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from metrology import estimation
from metrology.estimation import MeasuredRun, Prior
from metrology.gum.inputs import Input
from metrology.rig import Rig


@dataclass(frozen=True)
class Given:
    """A value from elsewhere: the name of the quantity in the campaign's measurement model, estimate, u, and source.

    `known` is the input itself where the measurement model does not hold it yet.
    """

    quantity: str
    value: float
    u: float
    source: str
    known: Input | None = None


@dataclass(frozen=True)
class ResponseTest:
    """A response test.

    Parameters
    ----------
    name, sample : str
        Of the test, and of what was tested.
    rig : Rig
        As stated; where k and c are sought, the start of the search.
    runs : tuple of MeasuredRun
        With their purposes.
    free : tuple of str
        Parameters that are sought.
    priors : tuple of Prior
        What is known of the inputs only within an uncertainty.
    given : mapping of str to Given
        ``'k'``, ``'c'``: values that are simulated with.
    settings : estimation.Settings
        Bounds and starts of the search.
    certificates : mapping of str to float
        Standard uncertainty by channel that the instrument's certificate leaves.
    """

    name: str
    sample: str
    rig: Rig
    runs: tuple[MeasuredRun, ...]
    free: tuple[str, ...] = ("k", "c")
    priors: tuple[Prior, ...] = ()
    given: Mapping[str, Given] = field(default_factory=dict)
    settings: estimation.Settings = field(default_factory=estimation.Settings)
    certificates: Mapping[str, float] = field(default_factory=dict)

    __test__ = False

    def of(self, purpose: str) -> tuple[MeasuredRun, ...]:
        """Runs with this purpose."""
        return tuple(run for run in self.runs if run.purpose == purpose)
