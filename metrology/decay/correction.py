"""Decrement and frequency by the oscillator that the data support, in place of those by the stated one."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import KNOWN, Ensemble, Input
from metrology.message import said

if TYPE_CHECKING:
    from metrology.decay.test import DecayTest
    from metrology.diagnosis import Diagnosis

OF_RELEASES = {"dk": said("k from release to release"), "dc": said("c from release to release")}


def corrected(test: DecayTest, stated: Contribution, found: Diagnosis) -> Contribution:
    """δ and ω_d of the linear oscillator within the model that the data support, and the results as they follow.

    ω_d = √(k/m − (c/2m)²), δ = 2π·(c/2m)/ω_d, with k and c for the mass as stated: its uncertainty enters after them.

    Parameters
    ----------
    test : DecayTest
        As for `decay.analyse`.
    stated : Contribution
        By the stated oscillator.
    found : Diagnosis
        With k and c by the model that the data support.

    Returns
    -------
    Contribution
        δ and ω_d as inputs with their joint covariance, and the measurands of the test that follow from them.
    """
    supported = found.supported
    assert supported is not None
    mass, rows = test.mass.value, [supported.names.index(name) for name in ("k", "c")]
    k, c = (supported.values[at] for at in rows)
    rate = c / (2 * mass)
    omega = sqrt(k / mass - rate**2)
    slopes = np.array([[0.5 / (mass * omega), -0.5 * rate / (mass * omega)], [0.0, 0.0]])
    slopes[1] = -2 * pi * rate / omega**2 * slopes[0] + (0.0, pi / (mass * omega))
    names = (f"{test.name}.omega_d", f"{test.name}.log_decrement")
    values, units = (omega, 2 * pi * rate / omega), ("rad/s", "1")
    inputs: list[Input] = []
    ensembles: list[Ensemble] = []
    terms: tuple[list[str], list[str]] = ([], [])
    for source in supported.sources:
        columns = slopes @ np.array([source.columns[at] for at in rows])
        if not columns.any() and source.kind != "readings":
            continue
        label = OF_RELEASES.get(source.name, source.name)
        keys = tuple(f"{name}.{label}" for name in names)
        start = values if source.kind == "readings" else (0.0, 0.0)
        inputs += [Input(key, value, (), unit, label) for key, value, unit in zip(keys, start, units, strict=True)]
        dof = len(test.records) - 1 if source.name in OF_RELEASES and len(test.records) > 1 else source.dof
        ensembles.append(
            Ensemble(
                said("{label} of {test}", label=label, test=test.name),
                keys,
                columns @ columns.T,
                float(dof or KNOWN),
                said("joint fit to the releases"),
                columns,
            )
        )
        for own, key in zip(terms, keys, strict=True):
            own.append(key)
    others = tuple(one for one in stated.inputs if one.name not in names)
    sums = [_sum(name, unit, own) for name, unit, own in zip(names, units, terms, strict=True)]
    return Contribution((*inputs, *others), tuple(ensembles), {}, (*sums, *stated.measurands))


def _sum(name: str, unit: str, terms: list[str]) -> Measurand:
    def function(known: Mapping[str, Any]) -> Any:
        return sum((known[one] for one in terms[1:]), start=known[terms[0]])

    return Measurand(name, function, unit, "θ̂ = θ̂₀ + Σ δ_s")
