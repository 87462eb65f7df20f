"""How alike two causes are: what is left of one where the other takes its place, as a share of its distance.

Linear, at small sizes, at the middle of the ranges of each specimen. The other cause may take any of several shapes and
places; where its size has one sign only, it may not take the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from . import decay, elongation, tether
from .noise import Sensor
from .plan import rounded
from .sizing import remainder

ONE_SIGN = {
    "response": ("friction", "drag", "quadratic drag", "damping", "zener", "hysteresis", "toe", "slip", "thrust lag",
    "frame", "yaw"),
    "decay": ("friction", "quadratic drag", "pendulum"),
    "elongation": ("creep", "slip", "toe"),
}  # fmt: skip
KEPT = 0.4
"""Shares above are not written: such causes are told apart at any distance that is planted."""


def table() -> dict[str, dict[str, dict[str, float]]]:
    """By test and specimen: cause with the sign of its size → other name → share."""
    found = {}
    for method, misfits in (("response", _response), ("decay", _decay), ("elongation", _elongation)):
        for specimen in {"response": tether, "decay": decay, "elongation": elongation}[method].SPECIMENS:
            found[f"{method} {specimen}"] = _compared(list(misfits(specimen)), ONE_SIGN[method])
    return found


def _compared(misfits: list[tuple[str, np.ndarray]], one_sign: tuple[str, ...]) -> dict[str, dict[str, float]]:
    """Each misfit against all others of other names. The first of a name is the one that is planted."""
    found: dict[str, dict[str, float]] = {}
    for name, r in dict(reversed(misfits)).items():
        for sign in (1, -1) if name not in one_sign else (1,):
            shares = found.setdefault(f"{name} {'+' if sign > 0 else '-'}", {})
            for other, s in misfits:
                share = _left(sign * r, s, other in one_sign)
                if other != name and share < KEPT:
                    shares[other] = min(rounded(share, 3), shares.get(other, 1.0))
    return found


def _left(r: np.ndarray, s: np.ndarray, one_sign: bool) -> float:
    both = np.isfinite(r) & np.isfinite(s)
    r, s = r[both], s[both]
    size = (r @ s) / (s @ s)
    if one_sign and size < 0:
        return 1.0
    return float(np.sqrt(max(1 - size * (r @ s) / (r @ r), 0.0)))


def _response(specimen: str) -> Iterator[tuple[str, np.ndarray]]:
    m, ks, cs = tether.SPECIMENS[specimen]
    rig = tether.Rig(m, sum(ks) / 2, sum(cs) / 2, -tether.GAP)
    sensors = {channel: Sensor("white", tether.SIGMA[channel], tether.DIGIT[channel]) for channel in tether.SIGMA}
    middle = tether.shapes(rig, _Middle(0.5))
    refit = tether.Refit(tether.Rest(rig, shape=middle), sensors)
    for name in tether.PARAMETERS:
        several = name in ("zener", "hysteresis", "toe", "frame", "yaw")
        for at in (0.5, 0.0, 0.25, 0.75, 1.0) if several else (0.5,):
            shape = {
                **middle,
                **{key: v for key, v in tether.shapes(rig, _Middle(at)).items() if key.startswith(name)},
            }
            size = 1e-3 * tether.first_size(name, rig)
            moved = refit.moved(tether.plant(tether.Rest(rig, shape=shape), name, size))
            yield name, _left_by_refit(moved, refit.jacobian, refit.priors)


class _Middle:
    """In place of random numbers: one place within every range."""

    def __init__(self, at: float) -> None:
        self.at = at

    def uniform(self, low: float, high: float) -> float:
        return low + self.at * (high - low)


def _left_by_refit(moved: np.ndarray, jacobian: np.ndarray, priors: np.ndarray) -> np.ndarray:
    used = np.isfinite(moved) & np.isfinite(jacobian).all(axis=1)
    found = np.full(len(moved) + len(priors), np.nan)
    found[np.append(used, np.ones(len(priors), dtype=bool))] = remainder(moved[used], jacobian[used], priors)
    return found


def _decay(specimen: str) -> Iterator[tuple[str, np.ndarray]]:
    one = decay.SPECIMENS[specimen]
    body = decay.Body(sum(one.m) / 2, sum(one.k) / 2, sum(one.c) / 2)
    natural = float(np.sqrt(body.k / body.m) / (2 * np.pi))
    stamps = np.arange(0, one.length, 1 / one.rate)
    for name in decay.PARAMETERS:
        if (name == "mains" and natural > 10) or name in ("drift", "other"):
            continue
        shape = {"mains": 50.01, "other.frequency": 1.9 * natural, "other.rate": 1 / one.length}
        size = 0.1 * decay.first_size(name, body, one.amplitude)
        rest = decay.plant(decay.Rest(body, one.amplitude, shape=shape), name, size)
        yield name, decay.refitted(stamps, decay.truth_of(rest, one.amplitude, stamps, 1.0), body)


def _elongation(specimen: str) -> Iterator[tuple[str, np.ndarray]]:
    b = elongation.bench(specimen, np.random.default_rng(0))
    refit = elongation.Refit(b, 3e-6)
    for name in elongation.PARAMETERS:
        for place in _places(name, b):
            changed = elongation.plant(replace(b, place={**b.place, **place}), name, elongation.first_size(name, b))
            moved = (elongation.truth_of(changed) - refit.plain) / refit.u
            left = remainder(moved, refit.jacobian, refit.priors)
            if np.linalg.norm(left) > 1e-6 * np.linalg.norm(moved):
                yield name, left


def _places(name: str, b: elongation.Bench) -> list[dict[str, float]]:
    return {
        "load": [{}, *({"load": float(one)} for one in np.unique(b.mass))],
        "misread": [{}, *({"reading": float(i)} for i in range(len(b.mass)))],
        "slip": [{}, *({"slip": float(i)} for i in range(len(b.mass) - 1))],
        "toe": [{"toe": one} for one in (0.15, 0.06, 0.1, 0.25, 0.4)],
    }.get(name, [{}])
