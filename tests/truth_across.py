"""A wire that several tests of a campaign measure, and what differs between them; no code of the package's.

Dead loads: x = F/k read on an indicator. Testing machine: a record of force and strain. Free decay: the swing of
m·x″ + c·x′ + k·x = 0. Each test may have a k of its own: what is planted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

GRAVITY = 9.80665
LENGTH = 2.0
MASS, HEAVY = 2.0, 200.0
"""Of a free decay / kg; the second of a test whose name ends so."""
ACCEPTED = ", ".join(
    f"{{check: {name}, reason: nothing is wrong, by: A. Smith}}"
    for name in ("linearity", "zero shift between repeats", "stiffness between repeats", "outlier")
)
ACCEPTED = f"accepted: [{ACCEPTED}]"


def campaign(folder: Path, tests: Mapping[str, tuple[str, str, float]], seed: int, *, accepted: bool = False) -> Path:
    """Write a campaign with `tests`: name → (method, sample, the k / (N/m) that the test meets).

    Weights and cell are off within their certificates, alike in all tests. `accepted`: checks of dead loads that fail
    one healthy test in twenty are accepted.
    """
    rng = np.random.default_rng(seed)
    off = {"elongation": 1 + 0.002 * rng.standard_normal(), "tension": 1 + 0.003 * rng.standard_normal(), "decay": 1.0}
    made = [
        _MAKE[method](folder, name, sample, k * off[method], rng) for name, (method, sample, k) in tests.items()
    ]  # fmt: skip
    if accepted:
        made = [text.replace("method: elongation,", f"method: elongation, {ACCEPTED},") for text in made]
    samples = ", ".join(
        f"{one}: {{section: {{shape: round, diameter: 0.500(2) mm}}, length: {LENGTH:.3f}(1) m}}"
        for one in dict.fromkeys(sample for _, sample, _ in tests.values())
    )
    text = f"""\
format: metrology-campaign/1
id: across
title: One wire by several methods
diagnosis: {{off: true}}
samples: {{{samples}}}
instruments:
  indicator: {{kind: indicator, resolution: 1 um}}
  weights: {{kind: weights, certificate: {{number: W, date: 2026-01-01, expanded_uncertainty: 0.4 %, k: 2}}}}
  cell: {{kind: load cell, certificate: {{number: F, date: 2026-01-01, expanded_uncertainty: 0.6 %, k: 2}}}}
  extensometer: {{kind: extensometer, certificate: {{number: X, date: 2026-01-01, expanded_uncertainty: 0.2 %, k: 2}}}}
  vibrometer: {{kind: vibrometer}}
tests:
{"".join(made)}"""
    path = folder / "campaign.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def _elongation(folder: Path, name: str, sample: str, k: float, rng: np.random.Generator) -> str:
    rows = [
        f"m{load},{repeat},loading,{1e3 * load * GRAVITY / k + 1e-3 * rng.standard_normal():.3f}"
        for repeat in range(1, 6) for load in (1, 2, 3, 4)
    ]  # fmt: skip
    (folder / f"{name}.csv").write_text("\n".join(["load,repeat,direction,reading / mm", *rows, ""]))
    loads = ", ".join(f"m{load}: {{mass: {load}.0 kg}}" for load in (1, 2, 3, 4))
    return f"""\
  {name}:
    {{method: elongation, sample: {sample}, instruments: {{extension: indicator, load: weights}},
     air_density: 1e-6 kg/m^3, gravity: {GRAVITY} m/s^2, loads: {{{loads}}}, readings: {name}.csv}}
"""


def _tension(folder: Path, name: str, sample: str, k: float, rng: np.random.Generator) -> str:
    t = np.arange(0.0, 30.0, 0.1)
    x = 1e-5 * t / 3
    force = k * x + 2e-4 * rng.standard_normal(t.size)
    rows = [f"{a:.1f},{b:.6f},{100 * c / LENGTH:.9f}" for a, b, c in zip(t, force, x, strict=True)]
    (folder / f"{name}.csv").write_text("\n".join(["time / s,force / N,strain / %", *rows, ""]))
    return f"""\
  {name}:
    {{method: tension, sample: {sample}, instruments: {{force: cell, strain: extensometer}},
     specimens: {{s: {{readings: {name}.csv}}}}}}
"""


def _decay(folder: Path, name: str, sample: str, k: float, rng: np.random.Generator) -> str:
    stated = HEAVY if name.endswith("heavy") else MASS
    mass = stated * (1 + 0.002 * rng.standard_normal())
    omega, zeta = math.sqrt(k / mass), 0.01
    files = []
    for at in range(3):
        t = np.arange(0.0, 60 / omega, 0.05 / omega)
        x = np.exp(-zeta * omega * t) * np.cos(omega * math.sqrt(1 - zeta**2) * t)
        x = 1e3 * x + 2.0 * rng.standard_normal(t.size)
        files.append(f"{name}-{at}.csv")
        rows = [f"{a:.7f},{b:.3f}" for a, b in zip(t, x, strict=True)]
        (folder / files[-1]).write_text("\n".join(["time / s,displacement / um", *rows, ""]))
    return f"""\
  {name}:
    {{method: decay, sample: {sample}, instruments: {{displacement: vibrometer}}, mass: {stated} ± {stated / 500} kg,
     readings: [{", ".join(files)}]}}
"""


_MAKE = {"elongation": _elongation, "tension": _tension, "decay": _decay}
