"""The equation of motion of module, line and set-up, with every effect that it can carry, and its exact integration.

Knows numbers, not uncertainties. `Rig` and `Run` say what is simulated, `simulate` gives the `Motion`,
`simulate_many` serves bands, `sensitivities` fits and `pushed` unlisted forces; `PARAMETERS` and `EFFECTS` name every
number.
"""

from metrology.effect import Effect, Parameter
from metrology.rig.model import Rig
from metrology.rig.motion import CHANNELS, Event, Motion
from metrology.rig.own import Own
from metrology.rig.parameters import EFFECTS, NAMES, PARAMETERS, UNREAD
from metrology.rig.run import Force, Run
from metrology.rig.sensitivity import Sensitivities, pushed, sensitivities
from metrology.rig.simulate import Motions, simulate, simulate_many

__all__ = [
    "CHANNELS",
    "EFFECTS",
    "NAMES",
    "PARAMETERS",
    "UNREAD",
    "Effect",
    "Event",
    "Force",
    "Motion",
    "Motions",
    "Own",
    "Parameter",
    "Rig",
    "Run",
    "Sensitivities",
    "pushed",
    "sensitivities",
    "simulate",
    "simulate_many",
]
