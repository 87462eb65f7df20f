"""A fit as inputs and measurands, so that k, c, ζ, ω_n and E get budget rows like every other result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.estimation.identification import Identification, Joint, Source
from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.functions import sqrt
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.message import said

if TYPE_CHECKING:
    from metrology.rig import Rig


def knowns(
    joint: Joint, rig: Rig, test: str, *, origins: Mapping[str, str] | None = None, mass: str | None = None
) -> Contribution:
    """What a fit contributes: measurands ``{test}.k``, ``{test}.c`` …, linear in the causes of their uncertainty.

    θ̂ = θ̂₀ + Σ_s δ_s + Σ_j S_j·(X_j − μ_j), S_j = H⁻¹[:, j]/u_j²: the readings and every cause that varies from run to
    run as one ensemble δ_s each, jointly for all parameters; every common known X_j as an input of its own. The parts
    add up to the covariance of the fit exactly (JCGM 102, 6.2). Then ω_n = √(k/m), ζ = c/(2·√(k·m)), the mass fitted.

    Parameters
    ----------
    joint : Joint
        Values and covariance of what all runs share.
    rig : Rig
        As stated.
    test : str
        First part of every name.
    origins : mapping of str to str, optional
        Where each known comes from.
    mass : str, optional
        Name of an input with the stated mass / kg; the mass of the rig as a constant unless given. Where the fit has
        a prior on ``mass.factor``, this input must carry no uncertainty of its own beside it.

    Returns
    -------
    Contribution
        Inputs, ensembles and measurands, to be added to the measurement model.
    """
    inputs: list[Input] = []
    ensembles: list[Ensemble] = []
    terms: dict[str, list[tuple[str, float, float]]] = {name: [] for name in joint.names}
    for source in joint.sources:
        if source.kind == "common":
            key = f"{test}.{source.name}.stated"
            known = Component(said("stated"), Normal(source.u), kind="B", source=(origins or {}).get(source.name, ""))
            inputs.append(Input(key, source.mean, (known,), source.unit, rig.parameters[source.name].meaning))
            for at, name in enumerate(joint.names):
                terms[name].append((key, float(source.columns[at, 0] / source.u), source.mean))
            continue
        label = _label(source)
        keys = tuple(f"{test}.{name}.{label}" for name in joint.names)
        start = joint.values.tolist() if source.kind == "readings" else [0.0] * len(keys)
        inputs += [
            Input(key, value, (), unit, label) for key, value, unit in zip(keys, start, joint.units, strict=True)
        ]
        ensembles.append(
            Ensemble(
                said("{label} of {test}", label=label, test=test),
                keys,
                source.columns @ source.columns.T,
                source.dof,
                said("joint fit to the runs"),
                source.columns,
            )
        )
        for key, name in zip(keys, joint.names, strict=True):
            terms[name].append((key, 1.0, 0.0))
    measurands = [
        _linear(f"{test}.{name}", unit, tuple(terms[name])) for name, unit in zip(joint.names, joint.units, strict=True)
    ]
    inert = rig.parameters["m"]
    meaning = said("{meaning}, as stated", meaning=inert.meaning)
    constants = [] if mass else [Input(f"{test}.m", rig.m, (), inert.unit, meaning)]
    derived = _derived(joint.names, test, mass or f"{test}.m")
    return Contribution((*inputs, *constants), tuple(ensembles), {}, (*measurands, *derived))


def _label(source: Source) -> str:
    """What a cause is called."""
    if source.kind != "per run":
        return source.name
    return said("{name} from run to run", name=source.name)


def _linear(name: str, unit: str, terms: tuple[tuple[str, float, float], ...]) -> Measurand:
    def function(known: Mapping[str, Any]) -> Any:
        return sum((slope * (known[key] - mean) for key, slope, mean in terms[1:]), start=known[terms[0][0]])

    return Measurand(name, function, unit, "θ̂ = θ̂₀ + Σ δ_s + Σ S_j·(X_j − μ_j)")


def _derived(common: tuple[str, ...], test: str, mass: str) -> list[Measurand]:
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
    """Share of each cause in the variance of one estimate; they add up to one. None where a bound holds it.

    Parameters
    ----------
    found : Identification
        A fit with results.
    name : str
        Of an unknown of the fit.

    Returns
    -------
    dict of str to float
        Share of u² by name of the cause.
    """
    at = found.layout.index(name)
    parts: dict[str, float] = {}
    for source in found.sources:
        parts[_label(source)] = float(np.sum(source.columns[at] ** 2))
    total = sum(parts.values())
    return {label: part / total for label, part in parts.items()} if total > 0.0 else {}
