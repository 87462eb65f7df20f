"""A fit as inputs and measurands, so that k, c, ζ, ω_n and E get budget rows like every other result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Measurand
from metrology.gum.functions import sqrt
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.identify.identification import Identification

KNOWN = 1e6
"""Degrees of freedom of an ensemble whose covariance is stated, not estimated: as good as infinite."""


@dataclass(frozen=True)
class Knowns:
    """Inputs, ensembles and measurands that a fit adds to the measurement model of a campaign."""

    inputs: tuple[Input, ...]
    ensembles: tuple[Ensemble, ...]
    measurands: tuple[Measurand, ...]


def knowns(found: Identification, test: str, *, mass: str | None = None) -> Knowns:
    """What a fit contributes: measurands ``{test}.k``, ``{test}.c`` …, linear in the causes of their uncertainty.

    θ̂ = θ̂₀ + Σ_s δ_s + Σ_j S_j·(X_j − μ_j), S_j = H⁻¹[:, j]/u_j²: the readings and every cause that varies from run to
    run as one ensemble δ_s each, jointly for all parameters; every common known X_j as an input of its own. The parts
    add up to the covariance of the fit exactly (JCGM 102, 6.2). Then ω_n = √(k/m), ζ = c/(2·√(k·m)), the mass fitted.

    Parameters
    ----------
    found : Identification
        With status 'ok'.
    test : str
        First part of every name.
    mass : str, optional
        Name of an input with the stated mass / kg; the mass of the rig as a constant unless given. Where the fit has
        a prior on ``mass.factor``, this input must carry no uncertainty of its own beside it.

    Raises
    ------
    ValueError
        For a fit that failed.
    """
    if found.status != "ok":
        message = "a fit that failed has no results"
        raise ValueError(message)
    names = tuple(entry.name for entry in found.layout.unknowns[: found.layout.common])
    inputs: list[Input] = []
    ensembles: list[Ensemble] = []
    terms: dict[str, list[tuple[str, float, float]]] = {name: [] for name in names}
    for source in found.sources:
        rows = source.columns[: len(names)]
        if source.kind == "common":
            key = f"{test}.{source.name}.stated"
            known = Component("stated", Normal(source.u), kind="B", source=_source(found, source.name))
            inputs.append(Input(key, source.mean, (known,), source.unit, found.rig.parameters[source.name].meaning))
            for at, name in enumerate(names):
                terms[name].append((key, float(rows[at, 0] / source.u), source.mean))
            continue
        label = "readings" if source.kind == "readings" else f"{source.name} from run to run"
        keys = tuple(f"{test}.{name}.{label}" for name in names)
        values = [found.value(name) if source.kind == "readings" else 0.0 for name in names]
        units = [found.parameter(name).unit for name in names]
        inputs += [Input(key, value, (), unit, label) for key, value, unit in zip(keys, values, units, strict=True)]
        dof = _independent(found) if source.kind == "readings" else KNOWN
        ensembles.append(Ensemble(label, keys, rows @ rows.T, dof, "joint fit to the runs"))
        for key, name in zip(keys, names, strict=True):
            terms[name].append((key, 1.0, 0.0))
    measurands = [_linear(f"{test}.{name}", found.parameter(name).unit, tuple(terms[name])) for name in names]
    inert = found.rig.parameters["m"]
    constants = [] if mass else [Input(f"{test}.m", found.rig.m, (), inert.unit, f"{inert.meaning}, as stated")]
    return Knowns((*inputs, *constants), tuple(ensembles), (*measurands, *_derived(found, test, mass or f"{test}.m")))


def _independent(found: Identification) -> float:
    """Degrees of freedom of the readings, counted in independent ones."""
    scatter = found.covariance.scatter if found.covariance else ()
    return max(1.0, sum(one.count / one.correlation_length for one in scatter) - len(found.layout.unknowns))


def _source(found: Identification, name: str) -> str:
    return next((prior.source for prior in found.priors if prior.name == name), "")


def _linear(name: str, unit: str, terms: tuple[tuple[str, float, float], ...]) -> Measurand:
    def function(known: Mapping[str, Any]) -> Any:
        return sum((slope * (known[key] - mean) for key, slope, mean in terms[1:]), start=known[terms[0][0]])

    return Measurand(name, function, unit, "θ̂ = θ̂₀ + Σ δ_s + Σ S_j·(X_j − μ_j)")


def _derived(found: Identification, test: str, mass: str) -> list[Measurand]:
    common = [entry.name for entry in found.layout.unknowns[: found.layout.common]]
    if "k" not in common:
        return []
    factor = f"{test}.mass.factor" if "mass.factor" in common else None

    def inertia(known: Mapping[str, Any]) -> Any:
        return known[mass] if factor is None else known[mass] * known[factor]

    derived = [
        Measurand(f"{test}.omega_n", lambda known: sqrt(known[f"{test}.k"] / inertia(known)), "rad/s", "ω_n = √(k/m)")
    ]
    if "c" in common:
        derived.append(
            Measurand(
                f"{test}.zeta",
                lambda known: known[f"{test}.c"] / (2 * sqrt(known[f"{test}.k"] * inertia(known))),
                "1",
                "ζ = c/(2·√(k·m))",
            )
        )
    return derived


def shares(found: Identification, name: str) -> dict[str, float]:
    """Share of each cause in the variance of one estimate; they add up to one."""
    at = found.layout.index(name)
    parts: dict[str, float] = {}
    for source in found.sources:
        label = source.name if source.kind != "per run" else f"{source.name} from run to run"
        parts[label] = float(np.sum(source.columns[at] ** 2))
    total = sum(parts.values())
    return {label: part / total for label, part in parts.items()}
