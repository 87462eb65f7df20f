"""What a response test knows of its inputs only within an uncertainty: a common part, and one that varies by run."""

from __future__ import annotations

from pydantic import Field, model_validator

from metrology import units
from metrology.declaration.entry import Entry, Refusal, from_text, refuse
from metrology.declaration.scalars import Text
from metrology.units.dimensions import TextError, quoted


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
    "inertia": ("mass.factor", "kg*m^2"),
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


INERT = ("mass", "inertia")
"""Inputs of which a share may be stated."""
TURNED = {"m": "rad", "m/s": "rad/s", "N": "N*m"}
"""Units of a rig that turns in place of those of one on a straight path."""


def _is_turned(text: str, unit: str) -> bool:
    try:
        amount(text, TURNED.get(unit, unit))
    except TextError:
        return False
    return True


class Known(Entry):
    """What the laboratory knows of the inputs only within an uncertainty; what is left out is taken as exact."""

    mass: Spread | None = Field(None, description="Mass.", examples=["{common: 25 g, source: balance}"])
    inertia: Spread | None = Field(
        None, description="Moment of inertia, for a rig that turns.", examples=["{common: 0.1 %, source: pendulum}"]
    )
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
    clock_rate: Spread | None = Field(
        None,
        description="Rate of the clock that stamps all records and the thrust: what a second of it lasts beyond a "
        "second, relative. `common` alone.",
        examples=["{common: 50 ppm, source: data sheet}"],
    )
    start_position: Spread | None = Field(None, description="Start position.", examples=["{per_run: 0.2 mm}"])
    start_velocity: Spread | None = Field(None, description="Start velocity.", examples=["{per_run: 1 mm/s}"])
    tilt: Spread | None = Field(None, description="Slope of the table.", examples=["{common: 0.05 mrad}"])

    @model_validator(mode="after")
    def _amounts(self) -> Known:
        found = []
        if self.clock_rate and self.clock_rate.per_run is not None:
            found.append(Refusal(("clock_rate", "per_run"), "a part that differs from run to run", "'common' alone"))
        for key, (_, unit) in {**KNOWN, "clock_rate": ("", "1")}.items():
            spread = getattr(self, key)
            for part, text in spread.amounts().items() if spread else ():
                try:
                    amount(text, unit, 1.0 if key in INERT else None)
                except TextError as error:
                    if _is_turned(text, unit):
                        continue  # which of the two is due is said by the rig
                    found.append(from_text(error, key, part))
        if found:
            raise refuse(*found)
        return self
