"""Every number of the rig under one name: the base model's own, and those of each effect."""

from __future__ import annotations

from dataclasses import replace

from metrology import effects
from metrology.coordinate import QUANTITIES
from metrology.effect import INF, Parameter
from metrology.rig.motion import CHANNELS

CHANNEL_UNITS = {what: {name: quantities[name].unit for name in CHANNELS} for what, quantities in QUANTITIES.items()}
"""What x is → SI unit of each channel."""
_TURNED = {
    "m": "rad", "m/s": "rad/s", "N": "N·m", "N/s": "N·m/s", "kg": "kg·m²", "N/m": "N·m/rad", "m/N": "rad/(N·m)",
    "N·s/m": "N·m·s/rad", "N·s²/m²": "N·m·s²/rad²", "N/m³": "N·m/rad³", "N/m²": "N·m/rad²",
    "1/m": "1/rad", "N·s/m²": "N·m·s/rad²",
}  # fmt: skip

_MEANT = {
    "m": "moment of inertia of the body",
    "k": "torsional stiffness",
    "c": "torsional damping",
    "taut": "angle of no torque",
    "mass.factor": "moment of inertia over the stated one",
    "free_length.shift": "angle of no torque off its stated value",
}


BASE = (
    Parameter("m", "m", "kg", None, 1e-9, INF, (1e-3, 1e3), 1.0, "mass of the module"),
    Parameter("k", "k", "N/m", None, 0.0, INF, (1.0, 1e6), 1.0, "stiffness of the line"),
    Parameter("c", "c", "N·s/m", None, 0.0, INF, (0.0, 1e3), 0.1, "damping of the line"),
    Parameter("taut", "x_t", "m", None, -INF, INF, (-10.0, 100.0), 1e-3, "position at which the line is just taut"),
    Parameter("length", "s", "m", 0.0, 0.0, INF, (0.1, 100.0), 0.1, "free length of the line, needed for its weight"),
    Parameter("weight", "q", "N/m", 0.0, 0.0, INF, (0.0, 1.0), 1e-3, "weight of the line per length"),
    Parameter("gravity", "g", "m/s²", 9.8, 0.0, INF, (9.7, 9.9), 0.1, "acceleration of free fall, for the tilt"),
    Parameter("cap", "d", "m", 0.005, 1e-9, INF, (1e-4, 0.05), 1e-3, "distance from taut at which eq. 3 is capped"),
)
"""The numbers of the base model, in the order in which the kernel takes them."""


EFFECTS = tuple(one for one in effects.EFFECTS if one.parameters)
"""Every effect that the motion or its readings carry."""
PARAMETERS: dict[str, Parameter] = {
    entry.name: entry for entry in (*BASE, *(one for effect in EFFECTS for one in effect.parameters))
}
"""Every parameter by its name, in the order of the kernel's vector."""
NAMES: tuple[str, ...] = tuple(PARAMETERS)
INDEX: dict[str, int] = {name: at for at, name in enumerate(NAMES)}
UNREAD: dict[str, float] = {
    one.name: one.null
    for effect in EFFECTS
    if effect.acts == "reading"
    for one in effect.parameters
    if one.null is not None
}
"""Values at which the instruments read the motion itself, on which all forces act."""
SILENT: dict[str, float] = {
    one.name: one.null
    for effect in EFFECTS
    if effect.readings
    for one in effect.parameters[: effect.sizes]
    if one.null is not None
}
"""Values at which nothing is added to the readings; clocks apart stay apart."""


def turned_unit(unit: str) -> str:
    """Return the unit of the same quantity where x is an angle.

    Parameters
    ----------
    unit : str
        SI unit of a rig that moves along a line.

    Returns
    -------
    str
        SI unit, written out.
    """
    return _TURNED.get(unit, unit)


def turned(entry: Parameter) -> Parameter:
    """Return the same number where x is an angle, F a torque and m a moment of inertia.

    >>> turned(BASE[1]).unit
    'N·m/rad'
    >>> turned(BASE[0]).meaning
    'moment of inertia of the body'

    Parameters
    ----------
    entry : Parameter
        Of a rig that moves along a line.

    Returns
    -------
    Parameter
        With unit and meaning of a rig that turns.
    """
    meaning = _MEANT.get(entry.name, entry.meaning)
    return replace(entry, unit=turned_unit(entry.unit), meaning=meaning)
