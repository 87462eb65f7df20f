"""Method `response` of a campaign file: a module on a table, tied by the sample; what drives it, and what reads it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology import units
from metrology.campaign.conduct import Test
from metrology.campaign.entry import Entry, Refusal, from_text, refuse
from metrology.campaign.quantity import Acceleration, Length, Mass, Stated, of
from metrology.campaign.scalars import Filled, Id, Reference, Table, Text
from metrology.units.dimensions import TextError, quoted

T = TypeVar("T")
Position = Annotated[Stated, *of("m", positive=False)]
Speed = Annotated[Stated, *of("m/s", positive=False)]
Time = Annotated[Stated, *of("s", positive=False)]
Thrust = Annotated[Stated, *of("N", positive=False)]
Stiffness = Annotated[Stated, *of("N/m")]
Damping = Annotated[Stated, *of("N*s/m", positive=False)]
TensionNoise = Annotated[Stated, *of("N")]
SpeedNoise = Annotated[Stated, *of("m/s")]
ReferenceTable = Annotated[Mapping[Reference, T], AfterValidator(MappingProxyType)]


class ResponseInstruments(Entry):
    """Instruments of a response test."""

    position: Id | None = Field(None, description="What reads the position.", examples=["mocap"])
    velocity: Id | None = Field(None, description="What reads the velocity.", examples=["mocap"])
    tension: Id | None = Field(None, description="What reads the tension.", examples=["load-cell"])
    thrust: Id | None = Field(None, description="What pushes the module.", examples=["thrusters"])


class StatedRig(Entry):
    """The rig as the laboratory states it."""

    mass: Mass = Field(
        description="Mass of everything that floats; its uncertainty goes under `known`.", examples=["25.00 kg"]
    )
    taut: Position = Field(description="Position x at which the line is just taut.", examples=["1.500 m"])
    attachment: Literal["tether", "both ways", "none"] = Field(
        "tether",
        description="A line that only pulls, one that pushes as well (a spring), or no line (a coast run).",
        examples=["tether"],
    )
    line_weight: Literal["none", "catenary", "elastic catenary"] = Field(
        "none",
        description="How the weight of the line acts: not at all; by eq. 3 of the paper while it is slack; or as an "
        "elastic catenary throughout. Needs `length` and `linear_density` of the sample.",
        examples=["catenary"],
    )
    cap: Length = Field(
        default_factory=lambda: Stated.model_validate("5 mm"),
        description="`catenary`: distance from taut below which eq. 3, which has no limit there, is held at its value; "
        "5 mm where nothing is said.",
        examples=["5 mm"],
    )
    gravity: Acceleration = Field(
        default_factory=lambda: Stated.model_validate("9.8 m/s^2"),
        description="Acceleration of free fall, for the weight of the line; 9.8 m/s^2, as the paper has it, where "
        "nothing is said.",
        examples=["9.806 m/s^2"],
    )
    effects: ReferenceTable[Stated] = Field(
        {},
        description="Further parameters of the equation of motion that are known, by their names in `docs/model.md`.",
        examples=["{friction.force: 2 mN}"],
    )


class Spread(Entry):
    """An input known only within an uncertainty: one part that all runs share, one that differs from run to run."""

    common: Text | None = Field(
        None, description="Standard uncertainty of the part that all runs share.", examples=["1 %", "1 mm"]
    )
    per_run: Text | None = Field(
        None, description="Standard deviation of the part that differs from run to run.", examples=["0.3 %"]
    )
    source: Text = Field("", description="Where the figures come from.", examples=["calibration of the thrusters"])

    @model_validator(mode="after")
    def _some(self) -> Spread:
        if self.common is None and self.per_run is None:
            raise refuse(Refusal((), "neither 'common' nor 'per_run'", "one of them, or both, such as 'common: 1 %'"))
        return self

    def amounts(self) -> dict[str, str]:
        """Texts of the parts that are stated."""
        return {key: text for key in ("common", "per_run") if (text := getattr(self, key)) is not None}


def amount(text: str, unit: str, whole: float | None = None) -> float:
    """Return a standard uncertainty in SI; a share, such as ``2 %``, of `whole` where that is given.

    Raises
    ------
    TextError
        For another dimension, for zero and less, and for an uncertainty that has one itself.
    """
    found = units.parse(text, difference=True)
    share = whole is not None and found.dimension.dimensionless
    if not share:
        found = units.parse(text, expected=unit, difference=True)
    if found.u is not None or found.value <= 0:
        raise units.UnitError(quoted(text), "one amount greater than zero, such as '1 %' or '0.5 mm'")
    return found.value * (whole if share and whole is not None else 1.0)


#: Inputs that may be uncertain: parameter of the rig and its unit. Of the mass, a share of the stated one is sought.
KNOWN = {
    "mass": ("mass.factor", "kg"),
    "free_length": ("free_length.shift", "m"),
    "thrust_gain": ("thrust.gain", "1"),
    "thrust_delay": ("thrust.delay", "s"),
    "cell_gain": ("cell.gain", "1"),
    "cell_zero": ("cell.zero", "N"),
    "scale": ("motion.scale", "1"),
    "clock": ("clock.T", "s"),
    "start_position": ("start.x", "m"),
    "start_velocity": ("start.v", "m/s"),
    "tilt": ("tilt.angle", "rad"),
}


class Known(Entry):
    """What the laboratory knows of the inputs only within an uncertainty; what is left out is taken as exact."""

    mass: Spread | None = Field(None, description="Mass.", examples=["{common: 25 g, source: balance}"])
    free_length: Spread | None = Field(None, description="Taut position.", examples=["{common: 1 mm, per_run: 0.1 mm}"])
    thrust_gain: Spread | None = Field(
        None, description="True over commanded thrust.", examples=["{common: 1 %, per_run: 0.3 %}"]
    )
    thrust_delay: Spread | None = Field(None, description="Dead time of the thrusters.", examples=["{common: 5 ms}"])
    cell_gain: Spread | None = Field(
        None, description="Reading of the load cell over force.", examples=["{common: 0.3 %}"]
    )
    cell_zero: Spread | None = Field(
        None, description="Reading of the load cell without force.", examples=["{per_run: 5 mN}"]
    )
    scale: Spread | None = Field(None, description="Scale of the motion capture.", examples=["{common: 0.05 %}"])
    clock: Spread | None = Field(
        None, description="Clock of the load cell against that of the motion capture.", examples=["{common: 1 ms}"]
    )
    start_position: Spread | None = Field(None, description="Start position.", examples=["{per_run: 0.2 mm}"])
    start_velocity: Spread | None = Field(None, description="Start velocity.", examples=["{per_run: 1 mm/s}"])
    tilt: Spread | None = Field(None, description="Slope of the table.", examples=["{common: 0.05 mrad}"])

    @model_validator(mode="after")
    def _amounts(self) -> Known:
        found = []
        for key, (_, unit) in KNOWN.items():
            spread = getattr(self, key)
            for part, text in spread.amounts().items() if spread else ():
                try:
                    amount(text, unit, 1.0 if key == "mass" else None)
                except TextError as error:
                    found.append(from_text(error, key, part))
        if found:
            raise refuse(*found)
        return self


class Given(Entry):
    """A value that is not sought in the runs: the result of another test, or a quantity from elsewhere."""

    test: Id | None = Field(
        None,
        description="Test of this campaign that gives it; a plain text means this too.",
        examples=["al-1100-elongation"],
    )
    value: Stated | None = Field(
        None,
        description="A value known from elsewhere.",
        examples=["{value: 1810.91 ± 7.53 N/m, source: campaign tapes}"],
    )

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, data: Any) -> Any:
        if isinstance(data, str):
            return {"test": data}
        if isinstance(data, dict) and "test" not in data:
            return {"value": data}
        return data

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Show the two forms in which it is written."""
        properties = handler.resolve_ref_schema(handler(schema))["properties"]
        return {"anyOf": [properties["test"]["anyOf"][0], properties["value"]["anyOf"][0]]}


class StartValues(Entry):
    """Where the search for stiffness and damping begins."""

    k: Stiffness | None = Field(None, description="Stiffness.", examples=["150 N/m"])
    c: Damping | None = Field(
        None, description="Damping; a tenth of the critical one where nothing is said.", examples=["5 N*s/m"]
    )


class Identify(Entry):
    """What is sought in the runs."""

    free: tuple[Reference, ...] = Field(
        ("k", "c"),
        description="Parameters of the equation of motion that are sought, by their names in `docs/model.md`.",
        examples=["[k, c]", "[friction.force]"],
    )
    start: StartValues = Field(
        default_factory=lambda: StartValues.model_validate({}),
        description="Where the search begins; needed for `k`.",
        examples=["{k: 150 N/m, c: 5 N*s/m}"],
    )
    bounds: ReferenceTable[tuple[Stated, Stated]] = Field(
        {}, description="Lowest and highest value, by parameter.", examples=["{k: [50 N/m, 500 N/m]}"]
    )


class StatedNoise(Entry):
    """Standard uncertainty of one reading, where the laboratory states it."""

    x: Length | None = Field(None, description="Of the position.", examples=["0.2 mm"])
    v: SpeedNoise | None = Field(None, description="Of the velocity.", examples=["2 mm/s"])
    T: TensionNoise | None = Field(None, description="Of the tension.", examples=["4 mN"])


class Thrusting(Entry):
    """A stretch of constant thrust."""

    from_: Time = Field(alias="from", description="Beginning, on the clock of the readings.", examples=["1.0 s"])
    to: Time | None = Field(None, description="End; that of the record where nothing is said.", examples=["4.0 s"])
    force: Thrust = Field(description="Force, positive away from the load cell.", examples=["0.38 N"])


class Start(Entry):
    """State of the module at the beginning."""

    position: Position = Field(description="Position x.", examples=["1.400 m"])
    velocity: Speed = Field(
        default_factory=lambda: Stated.model_validate("0 m/s"), description="Velocity v.", examples=["0 m/s"]
    )


class StatedRun(Entry):
    """One run: its readings, what drove the module, and how it began."""

    purpose: Literal["identification", "verification"] = Field(
        "identification",
        description="Whether the run goes into the fit (that of the inputs under `known`, where stiffness and damping "
        "are given), or judges the model.",
        examples=["verification"],
    )
    readings: tuple[Filled, ...] = Field(
        description="CSV files with `time / s` and any of the columns `x / m`, `v / m/s`, `T / N` and `F / N` (the "
        "thrust, where it was measured); each file has time stamps of its own. An empty cell is a gap.",
        examples=["[step-1-motion.csv.gz, step-1-cell.csv.gz]"],
    )
    thrust: tuple[Thrusting, ...] | None = Field(
        None,
        description="Thrust as commanded, stretch by stretch; none between them. Not where a column `F / N` has it.",
        examples=["[{from: 1 s, to: 4 s, force: 0.38 N}]"],
    )
    held_until: Time | None = Field(None, description="Time until which the module is held.", examples=["1.0 s"])
    start: Start = Field(description="Start state.", examples=["{position: 1.400 m}"])


class ResponseTest(Test):
    """Response of a module on the line to thrust: k and c from the motion, and the model judged by other runs."""

    method: Literal["response"] = Field(description="Method.", examples=["response"])
    instruments: ResponseInstruments = Field(
        description="Names of the instruments used.",
        examples=["{position: mocap, tension: load-cell, thrust: thrusters}"],
    )
    rig: StatedRig = Field(
        description="Module, line and table, as the laboratory states them.",
        examples=["{mass: 25.00 kg, taut: 1.500 m, line_weight: catenary}"],
    )
    known: Known = Field(
        default_factory=lambda: Known.model_validate({}),
        description="What is known of the inputs only within an uncertainty.",
        examples=["{thrust_gain: {common: 1 %, per_run: 0.3 %, source: calibration}}"],
    )
    stiffness: Given | None = Field(
        None,
        description="Stiffness to simulate with, in place of one from the runs: an elongation test, or a quantity.",
        examples=["al-1100-elongation"],
    )
    damping: Given | None = Field(
        None,
        description="Damping to simulate with, in place of one from the runs: a decay test, or a quantity.",
        examples=["al-1100-decay"],
    )
    identification: Identify | None = Field(
        None, description="What is sought in the runs.", examples=["{free: [k, c], start: {k: 150 N/m}}"]
    )
    noise: StatedNoise = Field(
        default_factory=lambda: StatedNoise.model_validate({}),
        description="Standard uncertainty of one reading; estimated from the readings where nothing is said.",
        examples=["{x: 0.2 mm, T: 4 mN}"],
    )
    runs: Table[StatedRun] = Field(
        description="The runs by name.",
        examples=[
            "{step-1: {readings: [step-1.csv], thrust: [{from: 1 s, force: 0.38 N}], start: {position: 1.400 m}}}"
        ],
    )

    @property
    def free(self) -> tuple[str, ...]:
        """Parameters that are sought."""
        return self.identification.free if self.identification else ()

    def yields(self, result: str) -> bool:
        """Whether the test gives a result of `names.RESULTS`: k and c where they are sought, the others from them."""
        if self.rig.attachment == "none":
            return False
        return result in ("zeta", "omega_n") or {"E": "k"}.get(result, result) in self.free
