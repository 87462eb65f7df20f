"""Method `decay`: free decay of a mass on the sample. How a campaign file declares it, and what goes into the model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, model_validator

from metrology import decay
from metrology.coordinate import TURNED
from metrology.declaration.columns import Column, Table
from metrology.declaration.conduct import Test
from metrology.declaration.entry import Entry, Refusal, one_of, refuse, unknown
from metrology.declaration.quantity import Frequency, Inertia, Mass, Ratio, Stated, ValueOnly
from metrology.declaration.readings import Readings
from metrology.declaration.scalars import Id
from metrology.errors import Fault, MetrologyError
from metrology.message import said
from metrology.method import Analysed, Files, Method, Output, Task, clock, instruments
from metrology.units import si_unit
from metrology.units.dimensions import quoted

STATED_IN = said("State it with an uncertainty: clock_rate: 0(50) ppm.")
"""Where a decay takes the uncertainty of its clock."""

if TYPE_CHECKING:
    import numpy as np

    from metrology.diagnosis import Diagnosis
    from metrology.gum.evaluation import Contribution
    from metrology.method.declared import Declared
    from metrology.timeseries import Channel

MIN_SAMPLES = 20
TIME = Column("time", "s", increasing=True)


class DecayInstruments(Entry):
    """The instrument of a free-decay test, one, by what it shows: a displacement or an angle, or how that changes."""

    displacement: Id | None = Field(
        None, description="The instrument that reads the displacement, or the angle.", examples=["vibrometer"]
    )
    velocity: Id | None = Field(
        None, description="The instrument that reads the velocity, or the angular velocity.", examples=["gyroscope"]
    )
    acceleration: Id | None = Field(
        None, description="The instrument that reads the acceleration, or the angular one.", examples=["accelerometer"]
    )

    @model_validator(mode="after")
    def _one(self) -> DecayInstruments:
        if len(self.stated) != 1:
            got = " and ".join(f"'{name}'" for name in self.stated) or "none"
            expected = "one of 'displacement', 'velocity' and 'acceleration', such as '{displacement: vibrometer}'"
            raise refuse(Refusal((), got, expected))
        return self

    @property
    def stated(self) -> dict[str, str]:
        """Instruments by what they show."""
        return {name: value for name in type(self).model_fields if (value := getattr(self, name)) is not None}


class DecayTest(Test):
    """Free decay of a mass on the sample: ω_n, ζ, and c = 2·ζ·√(k·m)."""

    method: Literal["decay"] = Field(description="Method.", examples=["decay"])
    instruments: DecayInstruments = Field(
        description="Names of the instruments used.", examples=["{displacement: vibrometer}"]
    )
    mass: Mass | None = Field(None, description="Mass that swings, or a sum of `masses`.", examples=["1.196(1) kg"])
    inertia: Inertia | None = Field(
        None,
        description="Moment of inertia, in place of a mass: a body that turns, whose readings are angles; k is then in "
        "N·m/rad and c in N·m·s/rad.",
        examples=["0.0200(1) kg*m^2"],
    )
    stiffness: Id | None = Field(
        None,
        description="Elongation test whose k goes into c = 2·ζ·√(k·m); the oscillation's own k where nothing is said.",
        examples=["al-1100-elongation"],
    )
    clock_rate: Ratio | None = Field(
        None,
        description="What a second of the clock that stamps the readings lasts beyond a second, relative, and how well "
        "that is known.",
        examples=["0(50) ppm"],
    )
    mains: Annotated[Frequency, ValueOnly()] = Field(
        Stated.model_validate({"value": "50 Hz"}),
        description="Frequency of the mains, which is taken out of the records.",
        examples=["60 Hz"],
    )
    expected: Annotated[Frequency | None, ValueOnly()] = Field(
        None,
        description="About where the longitudinal mode lies, where it is not the strongest that decays.",
        examples=["23 Hz"],
    )
    readings: tuple[Readings, ...] = Field(
        description="Files, names or mappings (`Readings`), one a release, with the columns `time / s` and "
        "`displacement / um`, `velocity / mm/s` or `acceleration / m/s^2` by the instrument; where an inertia is "
        "stated `angle / deg`, `velocity / deg/s` or `acceleration / rad/s^2`. Stamps need not be even, cells may be "
        "empty.",
        examples=["[decay-1.csv, decay-2.csv]"],
    )

    @model_validator(mode="after")
    def _one(self) -> DecayTest:
        one_of(self, "mass", "inertia", "a mass, 'mass: 1.196(1) kg', or a moment of inertia, 'inertia: 0.02 kg*m^2'")
        return self

    @property
    def inert(self) -> Stated:
        """Mass, or moment of inertia."""
        stated = self.mass or self.inertia
        assert stated is not None
        return stated

    @property
    def sensor(self) -> tuple[str, str]:
        """What is read, and the name of the instrument that reads it."""
        return next(iter(self.instruments.stated.items()))

    @property
    def column(self) -> tuple[str, str]:
        """Heading of the readings without its unit, and their SI unit."""
        quantity, _ = self.sensor
        length = "m" if self.inertia is None else "rad"
        heading = "angle" if quantity == "displacement" and self.inertia is not None else quantity
        return heading, {"displacement": length, "velocity": f"{length}/s", "acceleration": f"{length}/s²"}[quantity]


def readings(name: str, test: DecayTest) -> Iterator[Files]:
    """A file for each release."""
    place = ("tests", name, "readings")
    many = len(test.readings) > 1
    files = [((*place, index) if many else place, file) for index, file in enumerate(test.readings)]
    reading = Column(*test.column, gaps=True, varies=True)
    stretch = test.column[0] if test.column[1] == "m" else ""
    yield Files(files, (TIME, reading), _faults, {test.column[0]: test.sensor[1]}, stretch)


def _faults(tables: Sequence[Table]) -> Iterator[Fault]:
    for table in tables:
        if len(table) < MIN_SAMPLES:
            yield Fault(str(table.path), f"{len(table)} samples", f"at least {MIN_SAMPLES}")


def check(campaign: Declared, name: str, test: DecayTest) -> Iterator[Refusal]:
    """Releases that are there and used, and a stiffness of the same sample."""
    place = ("tests", name)
    names = [stated.name for stated in test.readings]
    for index, release in enumerate(names):
        if release in names[:index]:
            yield Refusal((*place, "readings", index), f"{quoted(release)} a second time", "every release once")
    if not test.readings:
        yield Refusal((*place, "readings"), "an empty list", "at least one file")
    if test.readings and {exclusion.file for exclusion in test.exclusions} >= set(names):
        yield Refusal((*place, "exclusions"), "every release", "at least one release that is used")
    if test.stiffness is None:
        return
    if test.inertia is not None:
        yield Refusal((*place, "stiffness"), f"'{test.stiffness}' with 'inertia'", "none: k in N·m/rad is its own")
        return
    choices = [other for other, stated in campaign.tests.items() if stated.method == "elongation"]
    yield from unknown(test.stiffness, choices, "elongation test", *place, "stiffness")
    known = test.stiffness in choices and test.sample in campaign.samples
    if known and campaign.tests[test.stiffness].sample != test.sample:
        other = campaign.tests[test.stiffness].sample
        yield Refusal(
            (*place, "stiffness"),
            f"'{test.stiffness}', a test of sample '{other}'",
            f"an elongation test of '{test.sample}'",
        )


def analyse(task: Task[DecayTest]) -> Analysed[decay.DecayTest]:
    """Put ω_n, ζ, c and k into the model.

    Raises
    ------
    MetrologyError
        For releases at a frequency that is off by more than a factor of two from what is known of it.
    """
    from metrology.decay import frequency
    from metrology.decay.separated import left_out

    prepared = task.model.once(_separated, _prepared(task))
    wrong = tuple(frequency.faults(prepared, instruments.known_stiffness(task) if task.test.mass else {}))
    if wrong:
        where = task.campaign.at("tests", task.name, "readings")
        raise MetrologyError(*(replace(one, where=f"{where}, {one.where}") for one in wrong))
    analysis = decay.analyse(prepared)
    task.model.add(analysis.contribution)
    for measurand in analysis.measurands:
        task.add(measurand)
    if task.test.clock_rate is None and analysis.measurands:
        task.model.held.append(clock.held(task.name, decay.by_clock(prepared, analysis), STATED_IN))
    failures = analysis.finding.failures
    task.model.failures.extend(said("{name}: {sentence:quoted}", name=task.name, sentence=one) for one in failures)
    task.model.warnings.extend(left_out(prepared))
    task.model.traces.update({f"decay/{task.name}/{record}": trace for record, trace in analysis.traces.items()})
    return Analysed(analysis.finding, prepared, analysis.contribution)


def _separated(test: decay.DecayTest) -> decay.DecayTest:
    """Return the test with its records taken apart, which takes most of the time."""
    _ = test.separated
    return test


def _prepared(task: Task[DecayTest]) -> decay.DecayTest:
    name, test = task.name, task.test
    sensor = test.sensor[1]
    smallest = task.campaign.instruments[sensor].resolution
    left_out = {exclusion.file for exclusion in test.exclusions}
    return decay.DecayTest(
        name=name,
        records=tuple(
            _record(table, *test.column) for table in task.campaign.tables["tests", name] if table.name not in left_out
        ),
        mass=test.inert.input(f"{name}.mass", said("mass that oscillates") if test.mass else said("moment of inertia")),
        stiffness=f"{test.stiffness}.k" if test.stiffness else f"{name}.k",
        scale=instruments.of_all_indications(sensor, task.campaign.instruments[sensor]),
        clock=test.clock_rate.input(f"{name}.clock rate", clock.RATE) if test.clock_rate else None,
        mains=test.mains.si,
        expected=2 * pi * test.expected.si if test.expected else None,
        resolution=smallest.si if smallest is not None and smallest.si_unit == si_unit(test.column[1]) else 0.0,
    )


def _record(table: Table, column: str, unit: str) -> Channel:
    """Return a release as it was read: a line without a reading is none."""
    import numpy as np

    from metrology.timeseries import Channel

    time, value = table.numbers["time"], table.numbers[column]
    read = np.isfinite(value)
    return Channel(table.name, time[read], value[read], unit)


def diagnose(task: Task[DecayTest], ready: decay.DecayTest, rng: np.random.Generator) -> Diagnosis:
    """What a linear oscillator lacks."""
    from metrology.diagnostics import decay as diagnosed

    return task.model.once(diagnosed, ready, rng=rng, sample=task.test.sample)


def corrected(_task: Task[DecayTest], ready: decay.DecayTest, stated: Contribution, found: Diagnosis) -> Contribution:
    """ζ, ω_n, c and k by the oscillator that the data support."""
    from metrology.decay.correction import corrected

    return corrected(ready, stated, found)


def yields(_campaign: Declared, test: DecayTest) -> dict[str, str]:
    """Return all that there is, of a body that turns in units of torque and angle."""
    turned = {} if test.inertia is None else TURNED
    return {name: turned.get(output.unit, output.unit) for name, output in OUTPUTS.items()}


OUTPUTS = {
    "zeta": Output("1", "%", "damping ratio"),
    "omega_n": Output("rad/s", "rad/s", "natural angular frequency"),
    "c": Output("N·s/m", "N·s/m", "damping coefficient"),
    "k": Output("N/m", "N/m", "stiffness"),
}
METHOD = Method(
    title="Free decay",
    standard="Laboratory method, docs/methods/decay.md; JCGM 100:2008",
    shown="What a free-decay test showed.",
    columns="`time / s` (increasing), and one of `displacement / um`, `angle / deg`, `velocity / mm/s` and "
    "`acceleration / m/s^2`; one file a release",
    remark="",
    references=("paper", "decrement"),
    test=DecayTest,
    entries=(DecayInstruments,),
    outputs=OUTPUTS,
    yields=yields,
    takes=("elongation",),
    whole="release",
    readings=readings,
    check=check,
    analyse=analyse,
    finding=decay.DecayFinding,
    diagnose=diagnose,
    corrected=corrected,
    explain=None,
    loading=None,
    carried=None,
)
