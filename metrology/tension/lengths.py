"""Stiffness and set-up compliance by specimens of several lengths, where the crosshead alone was read."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component
from metrology.message import said
from metrology.tension.results import BY_LENGTHS, EQUATIONS

if TYPE_CHECKING:
    from metrology.tension.model import Builder


def by_lengths(of: Builder, namespace: Mapping[str, float]) -> tuple[str, ...]:
    """dx/dF against free length: the intercept is the set-up, the slope 1/EA; scatter by mounting from the fit."""
    moved = [of.moved(one, f"{of.test.name}.{one.mounting.name}") for one in of.drawn]
    lengths = [of.know(one.mounting.length) for one in of.drawn]
    _scatter_about(of, namespace, moved, [of.inputs[name].value for name in lengths])
    test, area = of.test.name, of.drawn[0].mounting.area

    def fitted(n: Mapping[str, Any]) -> tuple[Any, Any]:
        X, Y = [n[name] for name in lengths], [one(n) for one in moved]
        mean_x, mean_y = sum(X) / len(X), sum(Y) / len(Y)
        b = sum((p - mean_x) * (q - mean_y) for p, q in zip(X, Y, strict=True)) / sum((p - mean_x) ** 2 for p in X)
        return mean_y - b * mean_x, b

    functions: dict[str, Callable[[Mapping[str, Any]], Any]] = {
        "EA": lambda n: 1 / fitted(n)[1],
        "k": lambda n: n[f"{test}.EA"] / n[of.test.sample_length],
        "E": lambda n: n[f"{test}.EA"] / n[area],
        "C": lambda n: fitted(n)[0],
    }
    found = tuple(name for name in functions if name in of.facts.results)
    for name in found:
        of.add(f"{test}.{name}", functions[name], name, BY_LENGTHS if name in ("EA", "C") else EQUATIONS[name])
    return found


def _scatter_about(
    of: Builder, namespace: Mapping[str, float], moved: Sequence[Callable[[Mapping[str, Any]], Any]], x: Sequence[float]
) -> None:
    """Add to each slope of the crosshead how the mountings scatter about the line over the free lengths."""
    known = {**namespace, **{name: one.value for name, one in of.inputs.items()}}
    c, X = np.array([float(one(known)) for one in moved]), np.column_stack([np.ones(len(x)), x])
    rest, dof = c - X @ np.linalg.lstsq(X, c, rcond=None)[0], len(x) - 2
    s2 = float(rest @ rest) / dof - float(np.mean([one.main.u**2 for one in of.drawn]))
    if s2 <= 0:
        return
    source = said("scatter of the mountings about the line over the free lengths")
    scatter = Component("mounting", Normal(float(np.sqrt(s2))), float(dof), "A", source)
    for one in of.drawn:
        name = f"{of.test.name}.{one.mounting.name}.crosshead slope"
        of.inputs[name] = replace(of.inputs[name], components=(*of.inputs[name].components, scatter))
