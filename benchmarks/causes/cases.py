"""The table of cases: the frozen one of 60, and fresh ones by seed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from . import decay, elongation, response
from .plan import Case, Plan

MAKERS = {"response": response, "decay": decay, "elongation": elongation}
MEDIUM, LARGE = (8.0, 15.0), (40.0, 200.0)
PLANTED = {
    "response": ("friction", "drag", "quadratic drag", "cubic", "damping", "zener", "hysteresis", "toe", "slip", "tilt",
                 "thrust lag", "frame", "thrust gain", "mass", "free length", "cell gain", "cell zero", "cell drift",
                 "gain drift", "clock x", "clock v", "clock T", "motion scale", "hum x", "hum v", "hum T"),
    "decay": ("friction", "quadratic drag", "cubic", "even stiffness", "damping", "pendulum", "other", "mains"),
    "elongation": ("backlash", "creep", "curvature", "drift", "load", "misread", "mounting", "slip", "toe"),
}  # fmt: skip
"""Causes that are planted. A drift of a decay's sensor is part of every fit of a record, so that it has no answer."""
PAIRS = {
    "response": (("friction", "clock T"), ("drag", "cubic"), ("zener", "mass"), ("toe", "friction"), ("hum T", "tilt"),
                 ("quadratic drag", "thrust lag"), ("slip", "cell drift"), ("damping", "free length")),
    "decay": (("friction", "cubic"), ("quadratic drag", "cubic"), ("friction", "other"), ("damping", "even stiffness"),
              ("friction", "pendulum"), ("quadratic drag", "other")),
    "elongation": (("creep", "load"), ("backlash", "curvature"), ("drift", "misread"), ("toe", "backlash"), ("slip",
    "curvature")),
}  # fmt: skip
LARGER = dict.fromkeys(("thrust gain", "mass", "free length", "cell gain", "cell zero", "clock T"), (20.0, 30.0))
LARGER |= dict.fromkeys(("gain drift", "clock x", "clock v"), (25.0, 60.0))
"""Large distances of some: an input thirty standard uncertainties off is as wrong as a laboratory can be."""
NOISES = ("white", "ar1", "dithered", "heavy", "narrow", "bare")
KINDS = ("nothing", "one medium", "one large", "pair", "unlisted", "remainder")
SHARES = (0.001, 0.003, 0.01, 0.03, 0.1)
FROZEN = {
    "response": {"nothing": 4, "one medium": 6, "one large": 6, "pair": 3, "unlisted": 3, "remainder": 3},
    "decay": {"nothing": 4, "one medium": 4, "one large": 4, "pair": 3, "unlisted": 3, "remainder": 2},
    "elongation": {"nothing": 3, "one medium": 3, "one large": 4, "pair": 2, "unlisted": 2, "remainder": 2},
}
"""How many of each kind the frozen table has: 61."""
FROZEN_SEED = 0
RECORD = Path(__file__).parent / "frozen.sha256"


def plans(seed: int, counts: dict[str, dict[str, int]]) -> Iterator[Plan]:
    """Plans of a table. One seed gives the same ones, whatever else the table holds."""
    for m, method in enumerate(MAKERS):
        for j, kind in enumerate(KINDS):
            for i in range(counts.get(method, {}).get(kind, 0)):
                rng = np.random.default_rng([seed, m, j, i])
                number = ((seed * 3 + m) * 10 + j) * 1000 + i
                yield _plan(method, kind, i, number, rng, f"s{seed}" if seed else "")


def _plan(method: str, kind: str, i: int, number: int, rng: np.random.Generator, mark: str) -> Plan:
    maker = MAKERS[method]
    specimen = str(rng.choice(list(maker.SPECIMENS)))
    causes, distances, unlisted, share = (), (), None, 0.0
    if kind.startswith("one") or kind == "remainder":
        causes = (str(rng.choice(PLANTED[method])),)
    if kind == "pair":
        causes = PAIRS[method][int(rng.integers(len(PAIRS[method])))]
    if "mains" in causes:  # the rate of the others lies at twice its frequency or below
        specimen = "tape" if rng.uniform() < 0.5 else "spring"
    if "medium" in kind:
        distances = (float(rng.uniform(*MEDIUM)),)
    elif causes:
        distances = tuple(_far(rng, LARGER.get(cause, LARGE)) for cause in causes)
    if kind == "pair":
        distances = tuple(_far(rng, (12.0, min(LARGER.get(cause, LARGE)[1], 60.0))) for cause in causes)
    if kind in ("unlisted", "remainder"):
        unlisted = str(rng.choice(maker.UNLISTED))
        share = SHARES[i % len(SHARES)] if kind == "remainder" else float(rng.uniform(30, 150))
    noise = NOISES[i % len(NOISES)] if kind == "nothing" else str(rng.choice(NOISES))
    name = "-".join([method, *([mark] if mark else []), kind.replace(" ", "-"), str(i + 1)])
    return Plan(name, method, specimen, number, causes, distances, unlisted, share, noise, _traits(method, rng))


def _far(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(limits))))


def _traits(method: str, rng: np.random.Generator) -> tuple[str, ...]:
    every = {"response": ("spikes", "gaps", "irregular", "wrong noise", "wrong input"),
             "decay": ("spikes", "gaps", "irregular"),
             "elongation": ("wrong noise",)}[method]  # fmt: skip
    return tuple(trait for trait in every if rng.uniform() < 0.15)


def make(plan: Plan) -> Case:
    """Files of a case."""
    return MAKERS[plan.method].make(plan)


def write(plan: Plan, place: Path) -> None:
    """Write the folder of a case; `plan.txt` is not among its files, so that a method sees nothing but a campaign."""
    folder = place / plan.name
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in make(plan).files.items():
        (folder / name).write_text(text, encoding="utf-8")


def digest(folder: Path) -> str:
    """SHA-256 of a case: of its files' names and contents."""
    found = hashlib.sha256()
    for file in sorted(folder.iterdir()):
        found.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return found.hexdigest()
