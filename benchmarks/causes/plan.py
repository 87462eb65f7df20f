"""What a case of the benchmark plants, and what the right answer to it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import yaml

from .names import NAMES

FORMAT = "metrology-causes/1"


@dataclass(frozen=True)
class Plan:
    """One case: its causes with their distances, what is in nobody's table, and the noise.

    `distances`: root of what χ² loses, in noise units, where the model without the cause is refitted. `share`: part of
    the misfit that the unlisted law carries, 1 where it is alone. `traits` from: spikes, gaps, irregular, wrong noise,
    wrong input.
    """

    name: str
    method: str
    specimen: str
    seed: int
    causes: tuple[str, ...] = ()
    distances: tuple[float, ...] = ()
    unlisted: str | None = None
    share: float = 0.0
    noise: str = "white"
    traits: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """Which rule of the score card applies."""
        if self.unlisted:
            return "remainder" if self.causes else "unlisted"
        return {0: "nothing", 1: "one", 2: "pair"}[len(self.causes)]

    def rng(self) -> np.random.Generator:
        """Random numbers of this case alone."""
        return np.random.default_rng([20261122, self.seed])

    def unlisted_distance(self) -> float:
        """Distance of the unlisted law: share = d²/(d² + Σ d_i²)."""
        listed = float(np.hypot.reduce(self.distances)) if self.distances else 0.0
        return listed * float(np.sqrt(self.share / (1 - self.share))) if listed else self.share


@dataclass(frozen=True)
class Truth:
    """What is true of a case, for its answer: sizes by parameter with unit, groups of like names, k and c."""

    sizes: dict[str, tuple[str, float, str]]
    distances: dict[str, float]
    groups: tuple[tuple[str, ...], ...]
    k: tuple[float, str]
    c: tuple[float, str] | None = None


@dataclass(frozen=True)
class Case:
    """Files of a case by name: campaign, readings, and the right answer."""

    files: dict[str, str] = field(default_factory=dict)


VERDICTS = {
    "nothing": ["nothing missing"],
    "one": ["explained", "explained in the main", "ambiguous"],
    "pair": ["explained", "explained in the main", "ambiguous"],
    "unlisted": ["unexplained"],
    "remainder": ["explained", "explained in the main", "ambiguous"],
}


def answer(plan: Plan, truth: Truth) -> str:
    """The right answer, `expected.yaml`.

    A group with one name that is given is an answer of its own: *ambiguous* is right there alone, and *explained*
    needs a cause that no other one resembles.
    """
    allowed = list(VERDICTS[plan.kind])
    grouped = {name for group in truth.groups for name in group}
    if plan.causes and not grouped:
        allowed.remove("ambiguous")
    if plan.kind == "remainder" and plan.share >= 0.02:
        allowed.remove("explained")
    right = set(plan.causes) | grouped
    found: dict[str, Any] = {
        "format": FORMAT,
        "case": plan.name,
        "method": plan.method,
        "kind": plan.kind,
        "causes": list(plan.causes),
        "group": [list(group) for group in truth.groups],
        "size": {cause: {"parameter": p, "value": rounded(v), "unit": u} for cause, (p, v, u) in truth.sizes.items()},
        "distance": {cause: rounded(d, 3) for cause, d in truth.distances.items()},
        "unlisted": plan.unlisted,
        "remainder": {"share": rounded(plan.share, 3) if plan.causes else (1.0 if plan.unlisted else 0.0)},
        "k": {"value": rounded(truth.k[0]), "unit": truth.k[1]},
        "c": {"value": rounded(truth.c[0]), "unit": truth.c[1]} if truth.c else None,
        "must_not": [name for name in NAMES[plan.method] if name not in right],
        "verdict": allowed,
        "noise": plan.noise,
        "traits": list(plan.traits),
        "seed": plan.seed,
    }
    return dump(found)


def dump(found: dict[str, Any]) -> str:
    """YAML of plain values, without anchors."""
    return str(yaml.dump(found, Dumper=_Plain, sort_keys=False, allow_unicode=True, width=200))


class _Plain(yaml.SafeDumper):
    def ignore_aliases(self, _data: Any) -> bool:
        return True


def rounded(value: float, digits: int = 8) -> float:
    """A float of so many digits: the last ones differ between machines."""
    return float(f"{value:.{digits}g}")


def laboratory(plan: Plan, title: str) -> dict[str, Any]:
    """Head of a campaign."""
    return {
        "format": "metrology-campaign/1",
        "id": plan.name,
        "title": title,
        "reconstructed": "Readings made by a generator of the benchmark; not measured.",
        "seed": plan.seed % 1_000_000,
    }


def table(head: str, columns: Iterable[np.ndarray], digits: Iterable[int]) -> str:
    """CSV; NaN is an empty cell."""
    forms = [f"%.{d}f" for d in digits]
    rows = [
        ",".join("" if np.isnan(v) else form % (v + 0.0) for form, v in zip(forms, row, strict=True))
        for row in zip(*columns, strict=True)
    ]
    return "\n".join([head, *rows]) + "\n"


def places(step: float) -> int:
    """Decimal places that hold readings of that step."""
    return max(0, int(np.ceil(-np.log10(step) - 1e-9)) + (0 if np.isclose(10 ** round(np.log10(step)), step) else 2))
