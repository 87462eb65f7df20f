"""`metrology new NAME --method relaxation`: what the starter campaign of a held elongation consists of."""

from __future__ import annotations

from math import exp

CAMPAIGN = """\
# A campaign: what was measured, with what, and what is to be made of it. Every key is explained in docs/campaign.md,
# this method in docs/methods/relaxation.md.
# Check it with:   metrology check {path}
# Its report:      metrology report {path}
format: metrology-campaign/1
id: {name}
title: Relaxation of a polymer line
reconstructed: Example readings, not measured.   # remove this line when the readings are yours
seed: 1                                          # the same seed gives the same report, to the byte

report: {{number: EX-1, issued: 2026-11-20, authorised_by: "J. Doe, head of laboratory"}}
laboratory: {{name: Example Laboratory, address: "1 Station Road, Exampletown"}}
customer: {{name: Example Customer, contact: A. Customer}}

instruments:
  cell: {{kind: load cell, class: "0.5", resolution: 0.01 N}}
  machine: {{kind: testing machine, class: "0.5", resolution: 0.001 mm}}

samples:
  line:
    material: polymer
    condition: as received
    section: {{shape: round, diameter: 1.000(3) mm}}
    length: 400.0(5) mm

tests:
  hold:
    method: relaxation
    sample: line
    date: 2026-10-05
    operator: A. Smith
    procedure: SP-15, edition 1
    environment: {{temperature: 21.3(5) degC, humidity: 45(5) %}}
    # crosshead, extension (with gauge_length) or strain
    instruments: {{force: cell, crosshead: machine}}
    setup_compliance: 0.050(5) um/N     # of grips, cell and frame; not with an extensometer
    # held: load                        # makes it a creep test
    at: 100 s                           # stiffness k_t and its fall alpha at this time after a step
    specimens:                          # one record each: time / s, force / N, crosshead / mm
      a: {{readings: a.csv}}

requirements:
  - id: R1
    text: The line shall keep at least 10 kN/m for 100 s.
    source: specification TS-02, 3.1
    quantity: hold.k_t
    limits: {{lower: 10 kN/m}}
    decision: {{rule: guard band, agreed: 2026-09-15}}
"""
READINGS = "a.csv"

_STIFF, _PARTS, _TIMES = 2.0e4, (0.10, 0.08), (4.0, 60.0)
_BEFORE, _RAMP, _STRETCH = 10.0, 0.5, 4.0e-3
_NOISE = 0.02


def readings() -> str:
    """Half a second of ramp to 4 mm and ten minutes of hold: two branches and noise of the cell, two readings a second.

    The grips give way by 0.05 µm/N, which the crosshead shows beside the line.
    """
    import numpy as np

    noise = np.random.default_rng(1).normal(scale=_NOISE, size=round(2 * (_BEFORE + _RAMP + 600)))
    lines = ["time / s,force / N,crosshead / mm"]
    for at, off in enumerate(noise.tolist()):
        t = at / 2
        ramp = min(max(t - _BEFORE, 0.0), _RAMP)
        since, rate = max(t - _BEFORE - _RAMP, 0.0), _STRETCH / _RAMP
        # Of each branch: its part times ∫ (1 − exp(−(t − s)/τ))·u′ ds over the ramp.
        relaxed = sum(part * rate * (ramp - tau * (exp(-since / tau) - exp(-(since + ramp) / tau)))
                      for part, tau in zip(_PARTS, _TIMES, strict=True))  # fmt: skip
        force = _STIFF * (rate * ramp - relaxed)
        lines.append(f"{t:.1f},{force + off:.2f},{1e3 * (rate * ramp + 0.05e-6 * force):.3f}")
    return "\n".join(lines) + "\n"
