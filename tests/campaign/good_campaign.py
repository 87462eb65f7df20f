"""A campaign as a laboratory writes it, about everything that a file can hold, with its readings."""

from __future__ import annotations

import math

CAMPAIGN = """\
# yaml-language-server: $schema=../../docs/campaign.schema.json
format: metrology-campaign/1
id: two-tapes
title: Stiffness and damping of two tapes
reconstructed: >-
  Readings made up for a test.
seed: 20261120
coverage_probability: 0.95
deviations: [Room 2 instead of room 1]

report:
  number: TR-2026-001
  issued: 2026-11-20
  authorised_by: "J. Doe, head of laboratory"
laboratory:
  name: Tether Laboratory
  address: "1 Station Road, Exampletown"
  contact: J. Doe
customer:
  name: Space Systems

instruments:
  indicator:
    kind: dial indicator
    manufacturer: Acme
    model: DI-25
    serial: 0123
    range: [0 mm, 25 mm]
    resolution: 0.01 mm
    certificate:
      number: C-123
      laboratory: Calibration House
      date: 2026-03-01
      due: 2027-03-01
      expanded_uncertainty: 4 um
      k: 2
    correction: {fit: indicator-line}
  weights:
    kind: set of weights
    class: M1
  vibrometer:
    kind: laser vibrometer
    serial: no
    correction: {value: 0.0(1) um}

samples:
  al:
    name: Al-1100 tape
    material: aluminium 1100
    batch: 1e3
    condition: as received
    received: 2026-10-01
    section:
      shape: tape
      width: 25.00(5) mm
      thickness:
        value: 0.0500 mm
        uncertainty:
          - standard: 0.0020 mm
            dof: 9
            type: A
            source: micrometer, ten readings
          - {half_width: 1 um, distribution: rectangular, source: resolution}
          - {expanded: 1 um, k: 2, source: certificate}
          - {expanded: 1 um, p: 0.95, dof: 20}
          - {half_width: 1 um, distribution: trapezoidal, beta: 0.5}
          - {half_width: 1 um, distribution: curvilinear-trapezoid, limit_half_width: 0.2 um}
          - {half_width: 1 um, distribution: triangular}
          - {half_width: 2 %, distribution: arcsine}
          - {scale: 1 um, distribution: student, dof: 4}
    length: 2.990 ± 0.001 m
    linear_density: 3.4 g/m
    references:
      E: {value: 69.0(10) GPa, source: handbook}
  peek:
    section: {shape: tape, width: 25.00(5) mm, thickness: 0.0500(27) mm}
    length: 3.00(1) m

tests:
  al-elongation:
    method: elongation
    sample: al
    date: 2026-10-05
    operator: A. Smith
    environment: {temperature: 21.3(5) degC, humidity: 45(5) %, pressure: 1013(3) hPa}
    instruments: {extension: indicator, load: weights}
    gravity: 9.8060(5) m/s^2
    air_density: 1.20(5) kg/m^3
    weight_density: 8000(100) kg/m^3
    loads:
      A: {mass: 1.0000(2) kg}
      B: {mass: 2.0000(3) kg}
      C: {force: 29.42(1) N}
    readings: elongation.csv
    exclusions:
      - {line: 4, reason: indicator knocked}
  al-decay:
    method: decay
    sample: al
    instruments: {displacement: vibrometer}
    mass: 1.196(1) kg
    stiffness: al-elongation
    readings: [decay-1.csv, decay-2.csv]

quantities:
  F_max: {value: 150 N, uncertainty: [{expanded: 2 N, k: 2, source: specification}]}
  a: 10.0(1) mm
  b: 12.0(1) mm
  α: 2.3(1)e-5 1/K

ensembles:
  bridge:
    readings: bridge.csv
    columns: {V: V / V, I: I / mA}
    uncertainty: {V: [{half_width: 1 mV, distribution: rectangular, source: voltmeter}]}

correlations:
  - {between: [a, b], coefficient: 0.9, source: same caliper}

fits:
  indicator-line:
    readings: calibration.csv
    x: indication / mm
    y: error / um
    u_y: {value: 0.5 um}
    predict: [{name: at_10, x: 10 mm}]
  curve:
    x: [77.6, 114.9, 141.1, 190.8]
    y: [10.07, 14.73, 17.94, 23.93]
    model:
      expression: b1*(1 - exp(-b2*x))
      start: {b1: 500, b2: 0.0001}
  thermometer:
    x: {values: [21.5, 22.0, 22.5, 23.0], unit: degC}
    y: {values: [-0.17, -0.17, -0.16, -0.16], unit: K}
    origin: 20 degC

derived:
  - quantity: E
    sample: al
    expression: k_1 * length / (width * t)
    where: {k_1: al-elongation.k, t: al.thickness}
    unit: GPa
  - quantity: half
    sample: al
    expression: E / 2
    where: {E: al.E}
    unit: MPa
  - {quantity: R, expression: V / I, unit: ohm}
  - {quantity: x_max, expression: F_max / k, where: {k: al-elongation.k}, unit: mm}
  - {quantity: s, expression: sqrt(a**2 + b**2) * (1 + α * dT), where: {dT: ΔT}, unit: mm}

comparisons:
  - {title: static against dynamic, between: [al-elongation.k, al-decay.k]}
  - {between: [al.E, {value: 69.0(10) GPa, source: handbook}]}

requirements:
  - id: R1
    text: The stiffness shall be at least 20 kN/m.
    quantity: al-elongation.k
    limits: {lower: 20 kN/m}
    decision: {rule: guard band, factor: 1.0}
  - id: R2
    quantity: a
    limits: {lower: 9 mm, upper: 11 mm}
    decision: {rule: global risk, risk: 0.001}
    prior: {distribution: normal, mean: 10 mm, standard: 0.5 mm}

audit:
  - {figure: k, quantity: al-elongation.k, published: 24734.25 ± 335.52 N/m, source: Table II}
  - {figure: difference, expression: "1 - 59.16/69.0", published: 14 %, source: text}
"""
CAMPAIGN = CAMPAIGN.replace("  α: 2.3(1)e-5 1/K\n", "  α: 2.3(1)e-5 1/K\n  ΔT: 2.0(1) K\n")


def _elongation() -> str:
    rows = [
        f"{load},{repeat},{direction},{0.40 * step + 0.01 * (repeat % 2):.2f}"
        for repeat in (1, 2, 3)
        for direction in ("loading", "unloading")
        for step, load in enumerate("ABC", start=1)
    ]
    return "\n".join(["load,repeat,direction,reading / mm", *rows]) + "\n"


def _decay(phase: float) -> str:
    rows = [f"{i / 1000:.3f},{50 * math.exp(-3 * i / 1000) * math.cos(0.14 * i + phase):.3f}" for i in range(200)]
    return "\n".join(["time / s,displacement / um", *rows]) + "\n"


FILES = {
    "elongation.csv": _elongation(),
    "decay-1.csv": _decay(0.0),
    "decay-2.csv": _decay(0.1),
    "bridge.csv": "V / V,I / mA\n5.007,19.663\n4.994,19.639\n5.005,19.640\n",
    "calibration.csv": "indication / mm,error / um\n0,0.1\n5,0.9\n10,2.2\n15,2.8\n",
}
