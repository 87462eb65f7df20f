"""What goes into the evaluation of an elongation test: loads, readings, instruments and surroundings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

from metrology.elongation.line import LEAST_DOF
from metrology.errors import Fault, MetrologyError
from metrology.gum.inputs import Component, Input

DIRECTIONS = ("loading", "unloading")
LEAST_LOADS = 3


@dataclass(frozen=True)
class Load:
    """A dead load: its name in the readings, and its mass (unit ``"kg"``) or force (unit ``"N"``).

    A load of zero is allowed. What hangs on the sample at every load alike (a hook, a plate) may be left out: it moves
    the line, not its slope.
    """

    name: str
    quantity: Input


@dataclass(frozen=True)
class Reading:
    """One reading of the indicator.

    Parameters
    ----------
    load, repeat : str
        Name of the load, and of the repeat (one hanging-up or one cycle) in which it was read.
    direction : {"loading", "unloading"}
        Whether the load was reached from below or from above.
    value : float
        Indication in m, growing with extension.
    line : int
        Line of the readings file, to name the reading in messages; 0 where there is none.
    excluded : str
        Why the reading is shown but not used; empty where it is used.
    """

    load: str
    repeat: str
    direction: str
    value: float
    line: int = 0
    excluded: str = ""


@dataclass(frozen=True)
class Correction:
    """Correction of the indicator's readings by a calibration line or curve.

    Parameters
    ----------
    function : callable
        Takes the namespace and an indication in m, and returns the corrected reading in m; it must serve floats,
        arrays of draws and ``uncertainties`` variables, as a `Measurand` does.
    inputs : tuple of Input
        The inputs of the namespace that it uses, such as the parameters of a fit. They belong to the fit, which hands
        them to the evaluation: here they serve for their values only.
    """

    function: Callable[[Mapping[str, Any], Any], Any]
    inputs: tuple[Input, ...] = ()


def too_few(where: str, count: int, repeats: int) -> Fault | None:
    """Fault of readings that leave a line with a zero for each repeat too little scatter; None for enough.

    Parameters
    ----------
    where : str
        What the fault names.
    count : int
        Of the readings.
    repeats : int
        Of the loading.

    Returns
    -------
    Fault or None
        With the least number of readings.
    """
    least = 1 + repeats + LEAST_DOF
    if count >= least:
        return None
    got = f"{count} reading{'' if count == 1 else 's'} in {repeats} repeat{'' if repeats == 1 else 's'}"
    expected = f"at least {least}: fewer have no scatter about a line from which an uncertainty follows"
    return Fault(where, got, expected, "read the loads again, or more loads")


@dataclass(frozen=True)
class ElongationTest:
    """An elongation test as carried out, ready for `analyse`.

    Parameters
    ----------
    name : str
        Id of the test; its stiffness is the output ``{name}.k``.
    loads : tuple of Load
        At least three different ones.
    readings : tuple of Reading
        At least one used one a load, and in all enough for a scatter: `LEAST_DOF` more than a line with a zero for each
        repeat has unknowns.
    resolution : Component
        Rounding of *one* reading, in m: for a division d a rectangular distribution of half-width d/2.
    gravity, air_density, weight_density : Input
        Local acceleration of free fall m/s², densities kg/m³ of the air and of the weights. Inputs of the same name in
        several tests are one input, and correlate their results.
    weights : Input, optional
        What is common to all masses: a relative correction (unit ``"1"``, value mostly 0) with the uncertainty of the
        certificate of the set or of the balance. It acts on all masses with the same sign (JCGM 100 F.1.2.3).
    indicator : tuple of Component
        Uncertainty in m of *one* indication according to the indicator's certificate. The error is taken as the same in
        all readings at one load, since they lie within a few divisions, and as independent between loads.
    scale : Input, optional
        Relative correction of all extensions (unit ``"1"``), such as an error of the indicator's scale.
    correction : Correction, optional
        Correction of the readings by a calibration line or curve.
    significance : float
        Rate at which each check may fail on data with nothing wrong in them.
    places : mapping of str to str
        For each load, what stands for the place on the indicator's scale that is read there: the error of indication at
        one place is the same in every test (JCGM 100 F.1.2.3). Without any, that of this test is another one.

    Raises
    ------
    MetrologyError
        All faults at once: too few loads or readings, unknown loads or directions, values that are no numbers.
    """

    name: str
    loads: tuple[Load, ...]
    readings: tuple[Reading, ...]
    resolution: Component
    gravity: Input
    air_density: Input
    weight_density: Input
    weights: Input | None = None
    indicator: tuple[Component, ...] = ()
    scale: Input | None = None
    correction: Correction | None = None
    significance: float = 0.05
    places: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        faults = [*self._faults_of_loads(), *self._faults_of_readings()] or list(self._faults_of_counts())
        if faults:
            raise MetrologyError(*faults)

    @property
    def used(self) -> tuple[Reading, ...]:
        """Readings that are not excluded, in the order in which they were taken."""
        return tuple(reading for reading in self.readings if not reading.excluded)

    def _faults_of_loads(self) -> Iterator[Fault]:
        where = f"{self.name}.loads"
        names = Counter(load.name for load in self.loads)
        for name in (name for name, count in names.items() if count > 1):
            yield Fault(f"{where}.{name}", f"{names[name]} loads of this name", "each name once")
        for load in self.loads:
            value, unit = load.quantity.value, load.quantity.unit
            if unit not in ("kg", "N"):
                yield Fault(
                    f"{where}.{load.name}", f"a quantity in {unit}", "a mass or a force, such as '2.000 kg' or '19.6 N'"
                )
            elif not (isfinite(value) and value >= 0):
                yield Fault(f"{where}.{load.name}", f"{value!r} {unit}", "a finite load of zero or more")

    def _faults_of_readings(self) -> Iterator[Fault]:
        names = {load.name for load in self.loads}
        for index, reading in enumerate(self.readings):
            where = f"{self.name}.readings " + (f"line {reading.line}" if reading.line else f"[{index}]")
            if reading.load not in names:
                yield Fault(where, f"load {reading.load!r}", f"one of {', '.join(sorted(names))}")
            if reading.direction not in DIRECTIONS:
                yield Fault(where, f"direction {reading.direction!r}", "'loading' or 'unloading'")
            if not isfinite(reading.value):
                yield Fault(
                    where,
                    f"reading {reading.value!r}",
                    "a number",
                    "give an 'exclusions' entry with a reason, or remove the line",
                )

    def _faults_of_counts(self) -> Iterator[Fault]:
        counts = Counter(reading.load for reading in self.used)
        for load in self.loads:
            if not counts[load.name]:
                fix = "read the load, or leave it out of 'loads'"
                yield Fault(f"{self.name}.readings", f"no reading in use at load {load.name}", "at least one", fix)
        fault = too_few(f"{self.name}.readings", len(self.used), len({reading.repeat for reading in self.used}))
        if fault is not None:
            yield fault
        different = len({(load.quantity.value, load.quantity.unit) for load in self.loads})
        if different < LEAST_LOADS:
            got = f"{different} different load{'' if different == 1 else 's'}"
            yield Fault(f"{self.name}.loads", got, f"at least {LEAST_LOADS}, without which linearity cannot be checked")
