"""Records of the truth handed to the code under test, and the campaigns that several tests share."""

from __future__ import annotations

import numpy as np
from truth_response import Instruments, Record, Scatter, Test, Truth, campaign

from metrology.estimation import MeasuredRun, Prior
from metrology.rig import Force, Rig, Run

MATERIALS = {
    "nylon": (167.64, 8.0),
    "spectra": (753.33, 35.0),
    "peek": (1810.91, 0.37),
    "al-1100": (24734.25, 48.81),
}
SCATTER = Scatter(mass=0.002, thrust=0.005, thrust_run=0.003, length=1e-3, length_run=2e-4, start_run=2e-4)
PRIORS = (
    Prior("mass.factor", 0.002),
    Prior("thrust.gain", 0.005, 0.003),
    Prior("free_length.shift", 1e-3, 2e-4),
    Prior("start.x", 0.0, 2e-4),
)
SHORT = (Test("step-a", ((1.0, 0.62),), 14.0), Test("impulse-a", ((1.0, 0.62), (4.0, 0.0)), 9.0))
HELD_OUT = (Test("step-b", ((1.0, 0.5),), 14.0), Test("impulse-b", ((1.0, 0.5), (4.0, 0.0)), 9.0))


def measured(record: Record, purpose: str = "identification", **changes) -> MeasuredRun:
    """A record as the lab hands it in: stated start and thrust, readings with their stamps."""
    test = record.test
    force = Force([t for t, _ in test.thrust], [f for _, f in test.thrust]) if test.thrust else None
    stamps = {f"t_{name}": t for name, t in record.t.items()}
    run = Run(x0=test.x0, v0=test.v0, t0=test.t0, force=force, **stamps)
    return MeasuredRun(test.name, run, **{**record.readings, "purpose": purpose, **changes})


def runs_of(truth: Truth, seed: int, *, tests=SHORT, scatter=SCATTER, instruments=None, purpose="identification"):
    """Measured runs of a campaign drawn with a seed."""
    records = campaign(truth, tests, instruments or Instruments(), scatter, np.random.default_rng(seed))
    return [measured(record, purpose) for record in records]


def truth_of(material: str, **extra: float) -> Truth:
    k, c = MATERIALS[material]
    return Truth(m=25.0, k=k, c=c, taut=0.1, **extra)


def stated(material: str, *, on_k: float = 1.1, on_c: float = 0.8) -> Rig:
    """The rig as the lab states it before the fit: stiffness and damping off."""
    k, c = MATERIALS[material]
    return Rig(m=25.0, k=on_k * k, c=on_c * c, taut=0.1)
