"""Method `response` of a campaign file: a module on a table, tied by the sample; what drives it, and what reads it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from metrology.coordinate import Coordinate
from metrology.declaration.conduct import Test
from metrology.declaration.entry import Entry, one_of
from metrology.declaration.quantity import Acceleration, Inertia, Length, Mass, Stated, ValueOnly, of
from metrology.declaration.readings import Readings
from metrology.declaration.scalars import Id, Reference, Table
from metrology.methods.response.known import Known

T = TypeVar("T")
Position = Annotated[Stated, *of("m", positive=False, other="rad")]
Speed = Annotated[Stated, *of("m/s", positive=False, other="rad/s")]
Time = Annotated[Stated, *of("s", positive=False)]
Thrust = Annotated[Stated, *of("N", positive=False)]
Torque = Annotated[Stated, *of("N*m", positive=False)]
Stiffness = Annotated[Stated, *of("N/m", other="N*m/rad")]
Damping = Annotated[Stated, *of("N*s/m", positive=False, other="N*m*s/rad")]
PositionNoise = Annotated[Stated, *of("m", other="rad")]
TensionNoise = Annotated[Stated, *of("N", other="N*m")]
SpeedNoise = Annotated[Stated, *of("m/s", other="rad/s")]
ReferenceTable = Annotated[Mapping[Reference, T], AfterValidator(MappingProxyType)]


class ResponseInstruments(Entry):
    """Instruments of a response test."""

    position: Id | None = Field(None, description="What reads the position.", examples=["mocap"])
    velocity: Id | None = Field(None, description="What reads the velocity.", examples=["mocap"])
    tension: Id | None = Field(None, description="What reads the tension.", examples=["load-cell"])
    thrust: Id | None = Field(None, description="What pushes the module.", examples=["thrusters"])


class StatedRig(Entry):
    """The rig as the laboratory states it."""

    mass: Mass | None = Field(
        None,
        description="Mass of everything that floats; its uncertainty here or under `known`.",
        examples=["25.00 kg"],
    )
    inertia: Inertia | None = Field(
        None,
        description="Moment of inertia, in place of a mass: the rig turns, x is an angle and the thrust a torque.",
        examples=["0.120 kg*m^2"],
    )
    taut: Position = Field(
        description="Position x, or angle, at which the line is just taut.", examples=["1.500 m", "0 rad"]
    )
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
    cap: Annotated[Length, ValueOnly()] = Field(
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

    @model_validator(mode="after")
    def _one(self) -> StatedRig:
        one_of(self, "mass", "inertia", "a mass, 'mass: 25 kg', or a moment of inertia, 'inertia: 0.12 kg*m^2'")
        return self

    @property
    def coordinate(self) -> Coordinate:
        """What x is."""
        return "position" if self.inertia is None else "angle"

    @property
    def inert(self) -> Stated:
        """Mass, or moment of inertia."""
        stated = self.mass or self.inertia
        assert stated is not None
        return stated


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

    k: Annotated[Stiffness | None, ValueOnly()] = Field(None, description="Stiffness.", examples=["150 N/m"])
    c: Annotated[Damping | None, ValueOnly()] = Field(
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
    bounds: Annotated[ReferenceTable[tuple[Stated, Stated]], ValueOnly()] = Field(
        {}, description="Lowest and highest value, by parameter.", examples=["{k: [50 N/m, 500 N/m]}"]
    )


class StatedNoise(Entry):
    """Standard uncertainty of one reading, where the laboratory states it."""

    x: Annotated[PositionNoise | None, ValueOnly()] = Field(None, description="Of the position.", examples=["0.2 mm"])
    v: Annotated[SpeedNoise | None, ValueOnly()] = Field(None, description="Of the velocity.", examples=["2 mm/s"])
    T: Annotated[TensionNoise | None, ValueOnly()] = Field(None, description="Of the tension.", examples=["4 mN"])


class Thrusting(Entry):
    """A stretch of constant thrust."""

    from_: Annotated[Time, ValueOnly("'known: thrust_delay'")] = Field(
        alias="from", description="Beginning, on the clock of the readings.", examples=["1.0 s"]
    )
    to: Annotated[Time | None, ValueOnly("'known: thrust_delay'")] = Field(
        None, description="End; that of the record where nothing is said.", examples=["4.0 s"]
    )
    force: Annotated[Thrust | None, ValueOnly("'known: thrust_gain'")] = Field(
        None, description="Force, positive away from the load cell.", examples=["0.38 N"]
    )
    torque: Annotated[Torque | None, ValueOnly("'known: thrust_gain'")] = Field(
        None, description="Torque, for a rig that turns.", examples=["0.02 N*m"]
    )

    @model_validator(mode="after")
    def _one(self) -> Thrusting:
        one_of(self, "force", "torque", "either a force, 'force: 0.38 N', or a torque, 'torque: 0.02 N*m'")
        return self

    @property
    def size(self) -> Stated:
        """Force, or torque."""
        stated = self.force or self.torque
        assert stated is not None
        return stated


class Start(Entry):
    """State of the module at the beginning."""

    position: Annotated[Position, ValueOnly("'known: start_position'")] = Field(
        description="Position x, or angle.", examples=["1.400 m"]
    )
    velocity: Annotated[Speed, ValueOnly("'known: start_velocity'")] = Field(
        default_factory=lambda: Stated.model_validate("0 m/s"), description="Velocity v.", examples=["0 m/s"]
    )


class StatedRun(Entry):
    """One run: its readings, what drove the module, and how it began."""

    purpose: Literal["identification", "verification"] = Field(
        "identification",
        description="Whether the run goes into the fit, or judges the model. Where stiffness and damping are given and "
        "nothing is sought, every run judges.",
        examples=["verification"],
    )
    readings: tuple[Readings, ...] = Field(
        description="Files, names or mappings (`Readings`), with `time / s` and any of the columns `x / m`, "
        "`v / m/s`, `T / N` and `F / N` (the thrust, where it was measured), or `angle / rad`, `rate / rad/s`, "
        "`torque / N*m` and `drive / N*m` for a rig that turns; each file has time stamps of its own. An empty "
        "cell is a gap.",
        examples=["[step-1-motion.csv.gz, step-1-cell.csv.gz]"],
    )
    thrust: tuple[Thrusting, ...] | None = Field(
        None,
        description="Thrust as commanded, stretch by stretch; none between them. Not where a column `F / N` (`drive "
        "/ N*m`) has it.",
        examples=["[{from: 1 s, to: 4 s, force: 0.38 N}]"],
    )
    held_until: Annotated[Time | None, ValueOnly()] = Field(
        None, description="Time until which the module is held.", examples=["1.0 s"]
    )
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
    model: ReferenceTable[Stated] = Field(
        {},
        description="Effects that the model carries beyond the base model, by the names of their parameters in "
        "`docs/model.md`. A value with an uncertainty is estimated within it, one without is taken as exact.",
        examples=["{friction.force: 1.0(1) mN}"],
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
        """Whether the test gives a result of the method: k and c where they are sought, the others from them."""
        if self.rig.attachment == "none" or (result == "E" and self.rig.coordinate == "angle"):
            return False
        return result in ("zeta", "omega_n") or {"E": "k"}.get(result, result) in self.free
