"""What a diagnosis yields, as values that JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from metrology.coordinate import Coordinate
from metrology.diagnosis.discrepancy import Discrepancy, Explanation, Judgement
from metrology.diagnosis.supported import Floats, Source, Supported
from metrology.doc import Doc

__all__ = [
    "Cause",
    "Curve",
    "Detectable",
    "Diagnosis",
    "Discrepancy",
    "Explanation",
    "Floats",
    "Gain",
    "Judgement",
    "Missing",
    "Part",
    "Picture",
    "Remainder",
    "Role",
    "Separation",
    "Shift",
    "Source",
    "Support",
    "Supported",
    "Test",
    "Value",
    "Verdict",
]

Verdict = Literal[
    "nothing missing", "explained", "explained in the main", "ambiguous", "unexplained", "not testable", "not finished"
]
Role = Literal["measured", "before", "after", "limit"]
Support = Literal["supported", "indistinguishable", "not supported", "not testable"]


@dataclass(frozen=True)
class Test:
    """A test whether anything is wrong: its statistic, the limit at the stated false-alarm rate, and the verdict."""

    __test__ = False

    name: Annotated[str, Doc("Name.")]
    statistic: Annotated[float, Doc("Test statistic; null where the check could not be made.")]
    limit: Annotated[float, Doc("Limit of the statistic.")]
    p_value: Annotated[float, Doc("Probability of a statistic at least as large by chance; null where there is none.")]
    false_alarm: Annotated[float, Doc("Probability of a false alarm at that limit.")]
    passed: Annotated[bool, Doc("Whether it passed; null where it was not made.")]
    sentence: Annotated[str, Doc("The same in words.")]


@dataclass(frozen=True)
class Value:
    """One parameter of a named effect, with its 95 % interval (None: open)."""

    name: Annotated[str, Doc("Name.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    low: Annotated[float | None, Doc("Lower end of the interval.")]
    high: Annotated[float | None, Doc("Upper end of the interval.")]


@dataclass(frozen=True)
class Gain:
    """Held-out root mean square over noise before and after, their ratio, and its 95 % interval."""

    before: Annotated[float, Doc("Before the extension or the fit.")]
    after: Annotated[float, Doc("After the extension or the fit.")]
    ratio: Annotated[float, Doc("Before over after.")]
    low: Annotated[float, Doc("Lower end of the interval.")]
    high: Annotated[float, Doc("Upper end of the interval.")]


@dataclass(frozen=True)
class Cause:
    """One candidate, judged.

    `log_bayes`: ln of the evidence against the model without it; `score`: its score in standard deviations before
    anything was fitted; `negligible`: real, yet of no use. `consequence`, `advice`: what it does, what to do.
    """

    effect: Annotated[str, Doc("Effect, by its name in the table.")]
    title: Annotated[str, Doc("Title as the report prints it.")]
    equation: Annotated[str, Doc("Equation of the measurement model, as text.")]
    verdict: Annotated[Support, Doc("The verdict.")]
    probability: Annotated[float, Doc("Probability of the cause.")]
    parameters: Annotated[tuple[Value, ...], Doc("Parameters, by name.")]
    gain: Annotated[Mapping[str, Gain], Doc("What the extension gains on held-out data, by channel.")]
    log_bayes: float | None
    score: float | None
    negligible: bool
    consequence: str
    advice: str
    sentence: Annotated[str, Doc("The same in words.")]

    def __repr__(self) -> str:
        return f"{self.title}: {self.verdict}. {self.sentence}"


@dataclass(frozen=True)
class Detectable:
    """Smallest size of an effect that these runs show, `size` in `unit`; None where they do not show it at any size."""

    effect: Annotated[str, Doc("Effect, by its name in the table.")]
    title: Annotated[str, Doc("Title as the report prints it.")]
    parameter: Annotated[str, Doc("Parameter of the effect.")]
    size: float | None
    unit: str
    sentence: Annotated[str, Doc("The same in words.")]


@dataclass(frozen=True)
class Part:
    """Residuals of one channel of one run in one phase, over their noise: before and after the extension."""

    run: Annotated[str, Doc("Run, by its name in the campaign file.")]
    channel: Annotated[str, Doc("Channel: x, v or T.")]
    phase: Annotated[str, Doc("Phase of the run.")]
    count: Annotated[int, Doc("Number of readings.")]
    before: Annotated[float, Doc("Before the extension or the fit.")]
    after: Annotated[float, Doc("After the extension or the fit.")]


@dataclass(frozen=True)
class Shift:
    """What the extension does to a parameter: values and uncertainties, and the shift in `u_before`."""

    name: Annotated[str, Doc("Name.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    before: Annotated[float, Doc("Before the extension or the fit.")]
    u_before: float
    after: Annotated[float, Doc("After the extension or the fit.")]
    u_after: Annotated[float, Doc("Standard uncertainty with the extension.")]
    shift: Annotated[float, Doc("Shift of the value.")]


@dataclass(frozen=True)
class Separation:
    """The measurement that tells apart what these data cannot, and for which effects."""

    effects: Annotated[tuple[str, ...], Doc("Effects that the measurement distinguishes.")]
    measurement: Annotated[str, Doc("The measurement, in words.")]
    power: Annotated[str, Doc("What it would resolve.")]


@dataclass(frozen=True)
class Missing:
    """What is missing, without a model: binned against what it depends on most.

    `share`: part of its variance that each dependence explains.
    """

    quantity: Annotated[str, Doc("Symbol: k, E, c, zeta, omega_n, or the name that the campaign gives.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    against: Annotated[str, Doc("What it depends on most.")]
    against_unit: Annotated[str, Doc("Unit of that.")]
    at: Annotated[Floats, Doc("Centres of the bins.")]
    value: Annotated[Floats, Doc("Value, in SI.")]
    u: Annotated[Floats, Doc("Standard uncertainty, in SI.")]
    share: Mapping[str, float]
    sentence: Annotated[str, Doc("The same in words.")]

    @property
    def what(self) -> str:
        """Of what there is too little."""
        return self.quantity.removeprefix("missing ")


@dataclass(frozen=True)
class Remainder:
    """What no listed effect explains: its part of the misfit, and the size of the unlisted law that describes it."""

    share: Annotated[float, Doc("Part of the misfit of the stated model that remains.")]
    size: Annotated[float | None, Doc("Root mean square of the unlisted law, in SI; null where none describes it.")]
    unit: Annotated[str, Doc("SI unit of the size.")]
    law: Annotated[str, Doc("The law: a force or a reading, and of what it is a function.")]


@dataclass(frozen=True)
class Curve:
    """Points of a picture, with the standard uncertainty of each where they are means.

    `role`: whether it shows what was measured, residuals of the model before or after the extension, or a limit.
    """

    name: Annotated[str, Doc("Name.")]
    role: Role
    x: Annotated[Floats, Doc("Values along the abscissa.")]
    y: Annotated[Floats, Doc("Values along the ordinate.")]
    u: Annotated[Floats, Doc("Standard uncertainty, in SI.")] = ()


@dataclass(frozen=True)
class Picture:
    """What makes a cause visible: a few curves over one quantity.

    `key`: what is drawn, one word to a kind of picture; `joined`: lines rather than points; `logarithmic`: which
    axes; `sentence`: how to read it.
    """

    key: str
    title: Annotated[str, Doc("Title as the report prints it.")]
    x: Annotated[str, Doc("Values along the abscissa.")]
    x_unit: Annotated[str, Doc("Unit of x.")]
    y: Annotated[str, Doc("Values along the ordinate.")]
    y_unit: Annotated[str, Doc("Unit of y.")]
    curves: Annotated[tuple[Curve, ...], Doc("The curves of the picture.")]
    sentence: str
    joined: bool = False
    logarithmic: Literal["no", "x", "both"] = "no"


@dataclass(frozen=True)
class Diagnosis:
    """Where a model is wrong, why, and what an extension gains: an entry of `diagnosis` in `results.json`.

    `chi_squared`: χ² for each reading before and after. `failures`: what could not be computed, each a sentence.
    `coordinate`: what x of a response test is.
    """

    sample: Annotated[str, Doc("Sample, by its name in the campaign file.")]
    method: Annotated[str, Doc("Method of the test, by its word in the campaign file.")]
    test: Annotated[str, Doc("Test, by its name in the campaign file.")]
    verdict: Annotated[Verdict, Doc("The verdict.")]
    sentence: Annotated[str, Doc("The same in words.")]
    tests: Annotated[tuple[Test, ...], Doc("Tests whether anything is wrong.")]
    causes: Annotated[tuple[Cause, ...], Doc("The candidates, each judged.")]
    gain: Annotated[Mapping[str, Gain], Doc("What the extension gains on held-out data, by channel.")]
    residuals: Annotated[tuple[Part, ...], Doc("Residuals by run, channel and phase.")]
    groups: Annotated[
        tuple[tuple[str, ...], ...],
        Doc("Effects that these data cannot distinguish; alone, one on which they do not decide."),
    ]
    discriminating_tests: Annotated[tuple[Separation, ...], Doc("Measurements that would.")]
    extended_model: Annotated[Mapping[str, float], Doc("Parameters of the extended model, by name.")]
    detectable: Annotated[tuple[Detectable, ...], Doc("Smallest sizes that would show.")] = ()
    shifts: Annotated[tuple[Shift, ...], Doc("What the extension does to the parameters.")] = ()
    missing: Annotated[Missing | None, Doc("What is missing, without a model.")] = None
    remainder: Annotated[Remainder | None, Doc("What no listed effect explains.")] = None
    supported: Annotated[Supported | None, Doc("Where the results come from; null: the model as stated.")] = None
    discrepancy: Annotated[
        Discrepancy | None, Doc("A result and its reference, and what could explain the difference.")
    ] = None
    pictures: Annotated[tuple[Picture, ...], Doc("What makes a cause visible.")] = ()
    chi_squared: tuple[float, float] | None = None
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")] = ()
    failures: tuple[str, ...] = ()
    extra: Annotated[Mapping[str, Any], Doc("Further values that this version has no field for.")] = field(
        default_factory=dict
    )
    coordinate: Coordinate = "position"
    ranges: Annotated[
        Mapping[str, tuple[float | None, float | None]],
        Doc("Range in which a parameter of the extended model was sought, by name; null: no limit."),
    ] = field(default_factory=dict)
    refuted: Annotated[
        tuple[str, ...],
        Doc("Stated inputs that the extended model moves by more than 4 of their standard uncertainties."),
    ] = ()

    def __repr__(self) -> str:
        """What it says; a page of fields helps nobody at a prompt."""
        return f"{self.test}: {self.verdict}. {self.sentence}"

    @property
    def named(self) -> tuple[str, ...]:
        """Effects that are given as causes, the most probable first."""
        return tuple(cause.effect for cause in self.causes if cause.verdict == "supported")

    @property
    def undecided(self) -> tuple[str, ...]:
        """Effects of which these data do not decide whether they are there: groups of one."""
        return tuple(name for name, *others in self.groups if not others)

    @property
    def is_decided(self) -> bool:
        """Whether an effect, or one of a group, is given as a cause, beside what is not decided."""
        return bool(set(self.possible) - set(self.undecided))

    @property
    def possible(self) -> tuple[str, ...]:
        """Effects that are given as causes or as members of a group."""
        return tuple(cause.effect for cause in self.causes if cause.verdict in ("supported", "indistinguishable"))
