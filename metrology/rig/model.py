"""The rig: the numbers of the equation of motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from numbers import Real
from types import MappingProxyType
from typing import Literal

import numpy as np

from metrology.coordinate import Coordinate
from metrology.effect import Parameter
from metrology.errors import Fault, MetrologyError
from metrology.rig.own import Own
from metrology.rig.parameters import BASE, CHANNEL_UNITS, EFFECTS, INDEX, PARAMETERS, turned
from metrology.rig.run import Array, frozen

ATTACHMENTS = ("tether", "both ways", "none")
LINE_WEIGHTS = ("none", "catenary", "elastic catenary")
_OWN = tuple(entry.name for entry in BASE)
_NULLS = np.array([math.nan if entry.null is None else entry.null for entry in PARAMETERS.values()])
_ANGULAR = {name: turned(entry) for name, entry in PARAMETERS.items()}
STRAIGHT = tuple(effect.name for effect in EFFECTS if effect.straight)
"""Effects that only a module on a straight path knows."""


@dataclass(frozen=True)
class Rig:
    """Module, line and set-up: the numbers of the equation of motion (``docs/model.md``).

    m·x″ = F_thrusters(t) + F_tilt − F_drag − F_friction − T,  T = k·e + c·e′ ≥ 0 for e = x − x_t > 0, else 0 or the
    weight of the slack line.

    Parameters
    ----------
    m, k, c : float
        Mass / kg, stiffness / (N/m) and damping / (N·s/m) of the line. With an angle for x and a torque for F they are
        kg·m², N·m/rad and N·m·s/rad.
    taut : float
        Position x at which the line is just taut, m.
    length, weight : float
        Free length / m of the line and its weight per length / (N/m).
    line_weight : {'none', 'catenary', 'elastic catenary'}
        How the weight of the line acts: not, by eq. 3 of the paper when slack, or by an elastic catenary throughout.
    cap : float
        Distance from taut / m below which eq. 3 is held at its value.
    attachment : {'tether', 'both ways', 'none'}
        A line that only pulls, one that pushes as well (a spring, a pendulum), or none.
    gravity : float
        Acceleration of free fall, m/s².
    effects : mapping of str to float
        Values of effect parameters by name (``{'friction.force': 2e-3}``); those left out are at their null.
    own : tuple of Own
        Effects of the laboratory's own; their parameters stand in `effects` like all others.
    coordinate : {'position', 'angle'}
        What x is; the same equation holds for an angle, in units of torque and moment of inertia.

    Raises
    ------
    MetrologyError
        With one fault for each number that is impossible.

    Examples
    --------
    >>> Rig(m=25.0, k=167.64, c=8.0, taut=1.5).value("k")
    167.64
    """

    m: float
    k: float
    c: float = 0.0
    taut: float = 0.0
    length: float = 0.0
    weight: float = 0.0
    line_weight: Literal["none", "catenary", "elastic catenary"] = "none"
    cap: float = 0.005
    attachment: Literal["tether", "both ways", "none"] = "tether"
    gravity: float = 9.8
    effects: Mapping[str, float] = field(default_factory=dict)
    own: tuple[Own, ...] = ()
    coordinate: Coordinate = "position"

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", MappingProxyType(dict(self.effects)))
        faults = [*_unknown_effects(self), *_no_numbers(self)]
        faults = faults or [*_impossible_values(self), *_impossible_choices(self)]
        if faults:
            raise MetrologyError(*faults)

    @property
    def sags(self) -> bool:
        """Whether the line hangs as an elastic catenary, which never ceases to pull."""
        return self.line_weight == "elastic catenary" or self.effects.get("sag.weight", 0.0) > 0

    @property
    def sag_weight(self) -> float:
        """Weight per length of the elastic catenary / (N/m): that of the line as stated, and the effect's."""
        stated = self.weight if self.line_weight == "elastic catenary" else 0.0
        return stated + self.value("sag.weight")

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """`PARAMETERS` in the units of the coordinate, and those of the rig's own effects after them."""
        known = _ANGULAR if self.coordinate == "angle" else PARAMETERS
        if not self.own:
            return known
        return {**known, **{one.name: one for own in self.own for one in own.effect.parameters}}

    @property
    def channel_units(self) -> Mapping[str, str]:
        """SI unit of each channel."""
        return CHANNEL_UNITS[self.coordinate]

    def without_own(self) -> Rig:
        """Return the same rig without effects of its own.

        Returns
        -------
        Rig
            With the effects of the package alone.
        """
        kept = {name: value for name, value in self.effects.items() if name in PARAMETERS}
        return replace(self, own=(), effects=kept) if self.own else self

    def value(self, name: str) -> float:
        """Value of one parameter, its null where the rig does not give it.

        Parameters
        ----------
        name : str
            Any of `parameters`.

        Returns
        -------
        float
            In the unit of the parameter.
        """
        if name in _OWN:
            return float(getattr(self, name))
        null = self.parameters[name].null
        assert null is not None
        return float(self.effects.get(name, null))

    def vector(self) -> Array:
        """Return every parameter's value.

        Returns
        -------
        ndarray, shape (len(NAMES),)
            Read-only, in the order of `NAMES` and their units.
        """
        return self._vector

    @cached_property
    def _vector(self) -> Array:
        found = _NULLS.copy()
        for name in _OWN:
            found[INDEX[name]] = getattr(self, name)
        for name, value in self.effects.items():
            if name in INDEX:
                found[INDEX[name]] = value
        return frozen(found)

    def with_values(self, values: Mapping[str, float]) -> Rig:
        """Return the same rig with these parameters set, several at once.

        Parameters
        ----------
        values : mapping of str to float
            By name, any of `NAMES`, in the unit of the parameter.

        Returns
        -------
        Rig
            Checked like any other.

        Raises
        ------
        MetrologyError
            With one fault for each number that is impossible.
        """
        own = {name: value for name, value in values.items() if name in _OWN}
        others = {name: value for name, value in values.items() if name not in _OWN}
        return replace(self, **own, effects={**self.effects, **others})  # type: ignore[arg-type]

    def __reduce__(self) -> tuple[object, ...]:
        # A read-only mapping cannot be pickled, and workers in other processes need rigs.
        return _rig_again, tuple(
            dict(self.effects) if entry.name == "effects" else getattr(self, entry.name) for entry in fields(self)
        )


_NUMBERS = tuple(entry.name for entry in fields(Rig) if entry.type == "float")


def _rig_again(*values: object) -> Rig:
    return Rig(*values)  # type: ignore[arg-type]


def _unknown_effects(rig: Rig) -> list[Fault]:
    expected = "the name of an effect's parameter, such as 'friction.force'"
    return [
        Fault(f"rig.effects.{name}", f"'{name}'", expected)
        for name in rig.effects
        if name not in rig.parameters or name in _OWN
    ]


def _no_numbers(rig: Rig) -> list[Fault]:
    """Texts, arrays and None where a number stands; units are those of the parameter."""
    given = {name: getattr(rig, name) for name in _NUMBERS}
    given |= {f"effects.{name}": value for name, value in rig.effects.items()}
    return [
        Fault(f"rig.{name}", f"{value!r:.60}", "a number, in the SI unit of the parameter")
        for name, value in given.items()
        if not isinstance(value, (float, Real))
    ]


def _impossible_values(rig: Rig) -> list[Fault]:
    faults, parameters = [], rig.parameters
    for name in (*_OWN, *rig.effects):
        entry, value = parameters[name], rig.value(name)
        if not (math.isfinite(value) and entry.low <= value <= entry.high):
            where = entry.name if entry.name in _OWN else f"effects.{entry.name}"
            faults.append(Fault(f"rig.{where}", f"{value:g} {entry.unit}", _range(entry)))
    return faults


def _range(entry: Parameter) -> str:
    if math.isinf(entry.low):
        return f"a finite number for the {entry.meaning}"
    bounds = f"at least {entry.low:g}" if math.isinf(entry.high) else f"from {entry.low:g} to {entry.high:g}"
    return f"{bounds} {entry.unit} for the {entry.meaning}"


def _impossible_choices(rig: Rig) -> list[Fault]:
    names = [own.effect.name for own in rig.own]
    faults = [
        Fault(f"rig.own.{name}", "two of that name", "one effect of each name")
        for name in sorted(set(names))
        if names.count(name) > 1
    ]
    for name, choices in (("attachment", ATTACHMENTS), ("line_weight", LINE_WEIGHTS)):
        if getattr(rig, name) not in choices:
            faults.append(Fault(f"rig.{name}", repr(getattr(rig, name)), "one of " + ", ".join(map(repr, choices))))
    if rig.coordinate not in CHANNEL_UNITS:
        faults.append(Fault("rig.coordinate", repr(rig.coordinate), "'position' or 'angle'"))
    if rig.coordinate == "angle":
        faults += _straight(rig)
    sags = rig.line_weight == "catenary" or rig.sags
    if sags and rig.attachment != "tether":
        faults.append(Fault("rig.line_weight", f"a sagging line attached '{rig.attachment}'", "a line that only pulls"))
    if sags and not rig.length > 0:
        faults.append(Fault("rig.length", f"{rig.length:g} m", "the free length of the line, which its weight needs"))
    return faults


def _straight(rig: Rig) -> list[Fault]:
    """What a rig that turns cannot have."""
    expected = "no effect of a straight path where x is an angle"
    names = [name for name in rig.effects if name.split(".")[0] in STRAIGHT]
    faults = [Fault(f"rig.effects.{name}", f"'{name}'", expected) for name in names]
    if rig.line_weight != "none":
        faults.append(Fault("rig.line_weight", f"'{rig.line_weight}' where x is an angle", "'none'"))
    return faults
