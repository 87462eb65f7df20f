"""Faults of the knowledge that is to be propagated, all of them at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from math import isclose, isfinite, isnan

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.distributions import Student
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Component, Ensemble, Floats, Input, Knowledge

_SINGULAR = 1e-12


def check(measurands: Sequence[Measurand], knowledge: Knowledge) -> None:
    """Refuse what cannot be propagated.

    Raises
    ------
    MetrologyError
        With a fault for every input, ensemble, correlation and measurand concerned, named after it.
    """
    faults = [
        *(fault for key, item in knowledge.inputs.items() for fault in _input(key, item)),
        *(fault for item in knowledge.ensembles for fault in _ensemble(item, knowledge)),
        *_memberships(knowledge.ensembles),
        *_correlations(knowledge),
        *_causes(knowledge),
        *_measurands(measurands, knowledge),
    ]
    if faults:
        raise MetrologyError(*faults)


def _input(key: str, item: Input) -> Iterator[Fault]:
    if key != item.name:
        yield Fault(f"inputs[{key!r}]", f"an input named {item.name!r}", "the name under which it is listed")
    if not isfinite(item.value):
        yield Fault(item.name, repr(item.value), "a finite value")
    for component, times in Counter(component.name for component in item.components).items():
        if times > 1:
            yield Fault(f"{item.name}.{component}", f"{times} components of that name", "one name for each component")
    for component_ in item.components:
        yield from _component(item.name, component_)


def _component(owner: str, component: Component) -> Iterator[Fault]:
    where = f"{owner}.{component.name}"
    if not (isfinite(component.u) and component.u >= 0):
        yield Fault(where, f"u = {component.u!r}", "a finite standard uncertainty, zero or more")
    if isinstance(component.distribution, Student) and component.dof != component.distribution.dof:
        expected = f"those of its Student distribution, {component.distribution.dof!r}"
        yield Fault(f"{where}.dof", repr(component.dof), expected)
    if isnan(component.dof) or component.dof <= 0:
        yield Fault(f"{where}.dof", repr(component.dof), "degrees of freedom above zero")


def _ensemble(ensemble: Ensemble, knowledge: Knowledge) -> Iterator[Fault]:
    size = len(ensemble.members)
    for member in ensemble.members:
        if member not in knowledge.inputs:
            yield Fault(f"{ensemble.name}.members", repr(member), "the name of an input", _known(knowledge))
    if not (isfinite(ensemble.dof) and ensemble.dof > 0):
        yield Fault(f"{ensemble.name}.dof", repr(ensemble.dof), "finite degrees of freedom above zero")
    if np.shape(ensemble.covariance) != (size, size):
        got = f"shape {np.shape(ensemble.covariance)}"
        yield Fault(f"{ensemble.name}.covariance", got, f"shape {(size, size)}, a row for each member")
        return
    if sentence := _covariance(np.asarray(ensemble.covariance, float)):
        yield Fault(f"{ensemble.name}.covariance", sentence, "a symmetric matrix without negative eigenvalues")


def _covariance(covariance: Floats) -> str:
    if not np.isfinite(covariance).all():
        return "an element that is not finite"
    if not np.allclose(covariance, covariance.T, rtol=1e-9, atol=0):
        return "a matrix that is not symmetric"
    spread = np.sqrt(np.abs(np.diag(covariance)))
    spread = np.where(spread > 0, spread, 1.0)
    smallest = float(np.linalg.eigvalsh(covariance / np.outer(spread, spread))[0])
    return "" if smallest > -1e-9 else f"a matrix with a negative eigenvalue ({smallest:.2g} relative to the variances)"


def _memberships(ensembles: Sequence[Ensemble]) -> Iterator[Fault]:
    for name, times in Counter(ensemble.name for ensemble in ensembles).items():
        if times > 1:
            yield Fault(f"ensembles[{name!r}]", f"{times} ensembles of that name", "one name for each ensemble")
    for member, times in Counter(member for ensemble in ensembles for member in ensemble.members).items():
        if times > 1:
            yield Fault(member, f"{times} places in ensembles", "one place in one ensemble")


def _correlations(knowledge: Knowledge) -> Iterator[Fault]:
    faults = [fault for pair, r in knowledge.correlations.items() for fault in _pair(pair, r, knowledge)]
    yield from faults
    if not faults and knowledge.correlations:
        yield from _matrix(knowledge)


def _pair(pair: tuple[str, str], r: float, knowledge: Knowledge) -> Iterator[Fault]:
    where = f"correlations[{pair[0]!r}, {pair[1]!r}]"
    members = {member: ensemble.name for ensemble in knowledge.ensembles for member in ensemble.members}
    if pair[0] == pair[1]:
        yield Fault(where, "an input with itself", "two different inputs")
    elif pair[::-1] in knowledge.correlations:
        yield Fault(where, "the same pair twice", "each pair once")
    if not -1 <= r <= 1:
        yield Fault(where, repr(r), "a correlation coefficient from -1 to 1")
    for name in dict.fromkeys(pair):
        if name not in knowledge.inputs:
            yield Fault(where, repr(name), "the name of an input", _known(knowledge))
        elif name in members:
            got = f"{name!r}, whose correlation follows from the readings of {members[name]!r}"
            yield Fault(where, got, "an input that is in no ensemble")
        elif r != 0 and knowledge.inputs[name].u == 0:
            yield Fault(where, f"{name!r}, whose u is 0", "an input with an uncertainty")


def _matrix(knowledge: Knowledge) -> Iterator[Fault]:
    names, matrix = correlation_matrix(knowledge)
    values, vectors = np.linalg.eigh(matrix)
    if values[0] > _SINGULAR:
        return
    word = "a singular" if values[0] > -_SINGULAR * 100 else "an indefinite"
    involved = [name for name, weight in zip(names, vectors[:, 0], strict=True) if abs(weight) > 1e-6]
    yield Fault(
        "correlations",
        f"{word} matrix for {', '.join(involved)} (smallest eigenvalue {values[0]:.2g})",
        "coefficients that can hold together",
        "correct a coefficient; where inputs share their whole uncertainty, state one input and use it in both places",
    )


def correlation_matrix(knowledge: Knowledge) -> tuple[tuple[str, ...], Floats]:
    """Names of the inputs in stated correlations, in the order of first mention, and their correlation matrix."""
    names = tuple(dict.fromkeys(name for pair in knowledge.correlations for name in pair))
    matrix = np.eye(len(names))
    for (a, b), r in knowledge.correlations.items():
        i, j = names.index(a), names.index(b)
        matrix[i, j] = matrix[j, i] = r
    return names, matrix


def _causes(knowledge: Knowledge) -> Iterator[Fault]:
    """Components that share a cause are one variable in different units."""
    stated = {name for pair in knowledge.correlations for name in pair}
    first: dict[str, Component] = {}
    for item in knowledge.inputs.values():
        for component in item.components:
            if not component.cause:
                continue
            where = f"{item.name}.{component.name}"
            known = first.setdefault(component.cause, component)
            if not alike(known, component):
                got = f"{component.drawn.name}, where the cause {component.cause!r} is {known.drawn.name} elsewhere"
                yield Fault(where, got, "one distribution and one number of degrees of freedom for each cause")
            if item.name in stated:
                got = f"{item.name!r}, which shares the cause {component.cause!r} with other inputs"
                yield Fault("correlations", got, "inputs without a shared cause", "state the cause or the coefficient")
        for cause, times in Counter(component.cause for component in item.components if component.cause).items():
            if times > 1:
                yield Fault(item.name, f"{times} components of the cause {cause!r}", "one component of each cause")


def alike(a: Component, b: Component) -> bool:
    """Whether two components are the same variable but for their sizes."""
    return a.dof == b.dof and all(
        isclose(float(a.drawn.quantile(p)) * b.u, float(b.drawn.quantile(p)) * a.u, rel_tol=1e-9) for p in (0.7, 0.99)
    )


def _measurands(measurands: Sequence[Measurand], knowledge: Knowledge) -> Iterator[Fault]:
    for name, times in Counter(measurand.name for measurand in measurands).items():
        if times > 1:
            yield Fault(name, f"{times} measurands of that name", "one name for each measurand")
        if name in knowledge.inputs:
            yield Fault(name, "a measurand with the name of an input", "a name of its own")


def _known(knowledge: Knowledge) -> str:
    names = list(knowledge.inputs)
    return f"inputs are {', '.join(names[:8])}{', …' if len(names) > 8 else ''}"
