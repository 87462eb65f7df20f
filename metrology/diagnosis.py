"""What a diagnosis yields, as values that JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from metrology.coordinate import Coordinate

Floats = tuple[float, ...]
Verdict = Literal["nothing missing", "explained", "ambiguous", "unexplained"]
Role = Literal["measured", "before", "after", "limit"]
Judgement = Literal["allowed", "against what is stated", "against these data"]
Support = Literal["supported", "indistinguishable", "not supported", "not testable"]


@dataclass(frozen=True)
class Test:
    """A test whether anything is wrong: its statistic, the limit at the stated false-alarm rate, and the verdict."""

    __test__ = False

    name: str
    statistic: float
    limit: float
    p_value: float
    false_alarm: float
    passed: bool
    sentence: str


@dataclass(frozen=True)
class Value:
    """One parameter of a named effect, with its 95 % interval (None: open)."""

    name: str
    value: float
    u: float
    unit: str
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Gain:
    """Held-out root mean square over noise before and after, their ratio, and its 95 % interval."""

    before: float
    after: float
    ratio: float
    low: float
    high: float


@dataclass(frozen=True)
class Cause:
    """One candidate, judged.

    `log_bayes`: ln of the evidence against the model without it; `score`: its score in standard deviations before
    anything was fitted; `negligible`: real, yet of no use. `consequence`, `advice`: what it does, what to do.
    """

    effect: str
    title: str
    equation: str
    verdict: Support
    probability: float
    parameters: tuple[Value, ...]
    gain: Mapping[str, Gain]
    log_bayes: float | None
    score: float | None
    negligible: bool
    consequence: str
    advice: str
    sentence: str


@dataclass(frozen=True)
class Detectable:
    """Smallest size of an effect that these runs show, `size` in `unit`; None where they do not show it at any size."""

    effect: str
    title: str
    parameter: str
    size: float | None
    unit: str
    sentence: str


@dataclass(frozen=True)
class Part:
    """Residuals of one channel of one run in one phase, over their noise: before and after the extension."""

    run: str
    channel: str
    phase: str
    count: int
    before: float
    after: float


@dataclass(frozen=True)
class Shift:
    """What the extension does to a parameter: values and uncertainties, and the shift in `u_before`."""

    name: str
    unit: str
    before: float
    u_before: float
    after: float
    u_after: float
    shift: float


@dataclass(frozen=True)
class Separation:
    """The measurement that tells apart what these data cannot, and for which effects."""

    effects: tuple[str, ...]
    measurement: str
    power: str


@dataclass(frozen=True)
class Missing:
    """What is missing, without a model: binned against what it depends on most.

    `share`: part of its variance that each dependence explains.
    """

    quantity: str
    unit: str
    against: str
    against_unit: str
    at: Floats
    value: Floats
    u: Floats
    share: Mapping[str, float]
    sentence: str


@dataclass(frozen=True)
class Curve:
    """Points of a picture, with the standard uncertainty of each where they are means.

    `role`: whether it shows what was measured, residuals of the model before or after the extension, or a limit.
    """

    name: str
    role: Role
    x: Floats
    y: Floats
    u: Floats = ()


@dataclass(frozen=True)
class Picture:
    """What makes a cause visible: a few curves over one quantity.

    `key`: what is drawn, one word to a kind of picture; `joined`: lines rather than points; `logarithmic`: which
    axes; `sentence`: how to read it.
    """

    key: str
    title: str
    x: str
    x_unit: str
    y: str
    y_unit: str
    curves: tuple[Curve, ...]
    sentence: str
    joined: bool = False
    logarithmic: Literal["no", "x", "both"] = "no"


@dataclass(frozen=True)
class Explanation:
    """One cause that could part a result from its reference: what it would have to be, and whether that can be.

    `needed` in `unit`, with its standard uncertainty; `tension`: that over what is known, in standard uncertainties,
    None where nothing is known; `measurement`, `power`: what would decide, and how far it would show the needed size.
    """

    cause: str
    title: str
    needed: float
    needed_u: float
    unit: str
    judgement: Judgement
    tension: float | None
    evidence: tuple[str, ...]
    measurement: str
    power: str
    sentence: str


@dataclass(frozen=True)
class Discrepancy:
    """A result beside its reference, and every cause that could part them, those that can be first.

    `ratio`: result over reference, with its standard uncertainty; `normalised`: E_n of ISO 13528, with U = 2u, None
    where nothing was stated of either.
    """

    quantity: str
    value: float
    u: float
    reference: float
    reference_u: float | None
    source: str
    ratio: float
    ratio_u: float
    normalised: float | None
    explanations: tuple[Explanation, ...]
    sentence: str


@dataclass(frozen=True)
class Diagnosis:
    """Where a model is wrong, why, and what an extension gains: an entry of `diagnosis` in `results.json`.

    `chi_squared`: χ² for each reading before and after. `failures`: what could not be computed, each a sentence.
    `coordinate`: what x of a response test is.
    """

    sample: str
    method: str
    test: str
    verdict: Verdict
    sentence: str
    tests: tuple[Test, ...]
    causes: tuple[Cause, ...]
    gain: Mapping[str, Gain]
    residuals: tuple[Part, ...]
    groups: tuple[tuple[str, ...], ...]
    discriminating_tests: tuple[Separation, ...]
    extended_model: Mapping[str, float]
    detectable: tuple[Detectable, ...] = ()
    shifts: tuple[Shift, ...] = ()
    missing: Missing | None = None
    discrepancy: Discrepancy | None = None
    pictures: tuple[Picture, ...] = ()
    chi_squared: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()
    failures: tuple[str, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict)
    coordinate: Coordinate = "position"

    @property
    def named(self) -> tuple[str, ...]:
        """Effects that are given as causes, the most probable first."""
        return tuple(cause.effect for cause in self.causes if cause.verdict == "supported")

    @property
    def possible(self) -> tuple[str, ...]:
        """Effects that are given as causes or as members of a group."""
        return tuple(cause.effect for cause in self.causes if cause.verdict in ("supported", "indistinguishable"))
