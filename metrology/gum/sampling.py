"""Joint draws of the inputs, each component by its own distribution (JCGM 101:2008, 6.4; JCGM 102:2011, 5.3)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, isfinite
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.copula import latent, transform
from metrology.gum.distributions import Normal
from metrology.gum.influence import Distribution
from metrology.gum.inputs import Ensemble, Floats, Knowledge, Redrawn
from metrology.gum.joint import Joint
from metrology.gum.matrix import root

Generator = np.random.Generator
Offsets = dict[str, Floats]
Source = Callable[[Generator, int], Mapping[str, Floats]]


@dataclass(frozen=True)
class Sampler:
    """Draws of all inputs of a state of knowledge at once.

    Draws of the inputs come in a fixed order from the generator, so that a seed determines them.
    """

    constants: Mapping[str, float]
    values: Mapping[str, float]
    sources: tuple[Source, ...]

    def draw(self, generator: Generator, size: int) -> dict[str, Any]:
        """Draws by name of the input, each of shape (size,); inputs without uncertainty stay plain numbers."""
        drawn: dict[str, Any] = dict(self.constants)
        for source in self.sources:
            for name, offsets in source(generator, size).items():
                if name in drawn:
                    drawn[name] += offsets
                else:
                    offsets += self.values[name]
                    drawn[name] = offsets
        return drawn


def sampler(knowledge: Knowledge, joint: Joint) -> Sampler:
    """Prepare draws of the inputs in `joint`; other inputs of `knowledge` stay at their estimates.

    Parameters
    ----------
    knowledge : Knowledge
        The inputs, in SI.
    joint : Joint
        What is uncertain together.

    Returns
    -------
    Sampler
        Draws blocks of trials by name of the input.

    Raises
    ------
    MetrologyError
        A stated correlation that the components cannot have (see `metrology.gum.copula`).
    """
    uncertain = {term.input.name: term.input.value for term in joint.terms if term.component.u > 0}
    constants = {name: float(item.value) for name, item in knowledge.inputs.items() if name not in uncertain}
    redrawn = [one for one in knowledge.redrawn if uncertain.keys() & set(one.members)]
    joint = _without(joint, {name for one in redrawn for name in one.members})
    free = [
        row
        for row, t in enumerate(joint.terms)
        if not t.ensemble and t.input.name not in joint.correlated and row not in joint.shared
    ]
    sources = [
        *(_redrawn(one, uncertain.keys()) for one in redrawn),
        *(_ensemble(ensemble, joint) for ensemble in joint.ensembles),
        *_correlated(joint),
        *(_shared(joint, rows) for rows in joint.causes.values()),
        *_free(joint, free),
    ]
    return Sampler(constants, uncertain, tuple(sources))


def _without(joint: Joint, names: Collection[str]) -> Joint:
    """Return what is left of the joint state without some inputs, which are drawn together in another way."""
    if not names:
        return joint
    return Joint(
        tuple(term for term in joint.terms if term.input.name not in names),
        tuple(one for one in joint.ensembles if not set(one.members) & set(names)),
        {pair: r for pair, r in joint.stated.items() if not set(pair) & set(names)},
    )


def _redrawn(one: Redrawn, wanted: Collection[str]) -> Source:
    """Members that an algorithm makes from drawn data; those without uncertainty stay what they are."""

    def draw(generator: Generator, size: int) -> Mapping[str, Floats]:
        values = one.draw(generator, size)
        return {name: row for name, row in zip(one.members, values, strict=True) if name in wanted}

    return draw


def _free(joint: Joint, rows: Sequence[int]) -> list[Source]:
    """Independent components, one source each; normal ones of the same input are drawn as one, which is the same."""
    normal: dict[str, float] = {}
    others: list[tuple[str, Distribution]] = []
    for row in rows:
        name, distribution = joint.terms[row].input.name, joint.terms[row].component.drawn
        if isinstance(distribution, Normal):
            normal[name] = hypot(normal.get(name, 0.0), distribution.u)
        else:
            others.append((name, distribution))
    pairs = [*((name, Normal(u)) for name, u in normal.items()), *others]
    return [_single(name, distribution) for name, distribution in pairs if distribution.u > 0]


def _single(name: str, distribution: Distribution) -> Source:
    return lambda generator, size: {name: distribution.draw(generator, size)}


def _ensemble(ensemble: Ensemble, joint: Joint) -> Source:
    """Multivariate t with scale matrix S/n and ν: normal draws over one common √(χ²/ν) (JCGM 102:2011 5.3.2.4)."""
    wanted = [joint.terms[row].input.name for row in joint.rows(ensemble.name) if joint.u[row] > 0]
    members = [ensemble.members.index(name) for name in wanted]
    covariance = np.asarray(ensemble.covariance)[np.ix_(members, members)]
    factor = root(covariance) if ensemble.columns is None else ensemble.columns[members]

    def draw(generator: Generator, size: int) -> Mapping[str, Floats]:
        values = factor @ generator.standard_normal((factor.shape[1], size))
        values /= np.sqrt(generator.chisquare(ensemble.dof, size) / ensemble.dof)
        return dict(zip(wanted, values, strict=True))

    return draw


def _shared(joint: Joint, rows: Sequence[int]) -> Source:
    """One draw of a cause that components of several inputs share, in the size that each has of it."""
    terms = [joint.terms[row] for row in rows]
    drawn = terms[0].component.drawn
    sizes = {term.input.name: term.component.sign * term.component.u / drawn.u for term in terms}

    def draw(generator: Generator, size: int) -> Mapping[str, Floats]:
        values = drawn.draw(generator, size)
        return {name: values * share for name, share in sizes.items()}

    return draw


def _correlated(joint: Joint) -> list[Source]:
    """One source for all inputs in stated correlations, by a Gaussian copula of their components."""
    if not joint.stated:
        return []
    rows = [r for r, t in enumerate(joint.terms) if t.input.name in joint.correlated and t.component.u > 0]
    names = [joint.terms[row].input.name for row in rows]
    distributions = [joint.terms[row].component.drawn for row in rows]
    factor = root(_latent(joint, rows))

    def draw(generator: Generator, size: int) -> Mapping[str, Floats]:
        values = factor @ generator.standard_normal((len(rows), size))
        drawn: Offsets = {}
        for name, distribution, z in zip(names, distributions, values, strict=True):
            part = transform(distribution, z)
            drawn[name] = drawn[name] + part if name in drawn else part
        return drawn

    return [draw]


def _latent(joint: Joint, rows: Sequence[int]) -> Floats:
    """Latent correlation matrix of the components in `rows`."""
    sizes = [term.component.drawn.deviation for term in joint.terms]
    endless = [joint.terms[row].input.name for row in rows if not isfinite(sizes[row])]
    if endless:
        got = (
            f"a correlation stated for {', '.join(dict.fromkeys(endless))}, known with two degrees of freedom or fewer"
        )
        fix = "give the simultaneous readings as an ensemble"
        raise MetrologyError(Fault("correlations", got, "inputs whose draws have a standard deviation", fix))
    target = joint.spread(sizes)
    matrix = np.eye(len(rows))
    for i, row in enumerate(rows):
        for j, column in enumerate(rows[:i]):
            matrix[i, j] = matrix[j, i] = _pair(
                joint, column, row, float(target[joint.place[row], joint.place[column]])
            )
    if np.linalg.eigvalsh(matrix)[0] < -1e-9:
        names = ", ".join(dict.fromkeys(joint.terms[row].input.name for row in rows))
        raise MetrologyError(_unreachable(f"coefficients for {names} that their distributions cannot have together"))
    return matrix


def _pair(joint: Joint, row: int, column: int, r: float) -> float:
    a, b = joint.terms[row], joint.terms[column]
    found = latent(a.component.drawn, b.component.drawn, r)
    if found is None:
        raise MetrologyError(
            _unreachable(
                f"r = {r:.4g} between {a.input.name}.{a.component.name} ({a.component.drawn.name})"
                f" and {b.input.name}.{b.component.name} ({b.component.drawn.name})"
            )
        )
    return found


def _unreachable(got: str) -> Fault:
    fix = "where inputs share a cause, make that cause an input of its own"
    return Fault("correlations", got, "a correlation that variables of these distributions can have", fix)
