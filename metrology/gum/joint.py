"""The joint state of knowledge as a flat list of terms, one for each component of each input, and their correlation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from metrology.gum.distributions import Student
from metrology.gum.inputs import Component, Ensemble, Floats, Input, Knowledge

_LEAST = 1e-12
"""Correlation that is rounding of the sums."""


class Term(NamedTuple):
    """One component of one input; `ensemble` names the simultaneous readings that it belongs to, if any."""

    input: Input
    component: Component
    ensemble: str = ""


class Joint:
    """Terms of the inputs that matter, with the correlation between the terms.

    Components of one input are independent, so a correlation r stated between two inputs falls on each pair of their
    components as r·w_a·w_b with w_a = u_a/u(x): Σ_ab u_a u_b r w_a w_b = r u(x_i) u(x_j), exactly what was stated.
    With W the matrix of the w this is W R Wᵀ + (I − W Wᵀ), positive semidefinite for every valid R. Components that
    share a cause are one variable in different units: r = 1, or −1 where it moves them in opposite directions.

    Attributes
    ----------
    u : list of float
        Standard uncertainties of the terms.
    causes : dict of str to list of int
        Indices of the terms of each cause that several of them share.
    related : list of int
        Indices of the m terms that can be correlated with others; each of the rest is independent of all.
    scatters : list of (list of int, float)
        Terms whose one scatter is estimated with finite ν, and ν: those of an ensemble, those of a cause, or one alone.
    """

    def __init__(
        self, terms: Sequence[Term], ensembles: Sequence[Ensemble], stated: Mapping[tuple[str, str], float]
    ) -> None:
        self.terms = terms
        self.ensembles = ensembles
        self.stated = stated
        self.u: list[float] = []
        self.scatters: list[tuple[list[int], float]] = []
        named: dict[str, list[int]] = {}
        for row, (_, component, ensemble) in enumerate(terms):
            self.u.append(component.u)
            rows = named.setdefault(component.cause, []) if component.cause else []
            rows.append(row)
            if component.dof < inf and not ensemble and rows[0] == row:
                self.scatters.append((rows, component.dof))
        for one in ensembles:
            self.scatters.append((self.rows(one.name), one.dof))
        self.causes = {cause: rows for cause, rows in named.items() if len(rows) > 1}
        self.related: list[int] = []
        if ensembles or stated or self.causes:
            self.related = [
                row
                for row, term in enumerate(terms)
                if term.ensemble or row in self.shared or term.input.name in self.correlated
            ]

    @cached_property
    def shared(self) -> dict[int, list[int]]:
        """By the index of a term that shares its cause: the indices of all that do."""
        return {row: rows for rows in self.causes.values() for row in rows}

    @cached_property
    def correlated(self) -> set[str]:
        """Names of the inputs in a stated correlation."""
        return {name for pair in self.stated for name in pair}

    @cached_property
    def place(self) -> dict[int, int]:
        """By the index of a related term: its row in `correlation`."""
        return {row: place for place, row in enumerate(self.related)}

    @cached_property
    def correlation(self) -> Floats:
        """Correlation matrix of the related terms, shape (m, m)."""
        matrix = self.spread(self.u)
        for ensemble in self.ensembles:
            rows = self.rows(ensemble.name)
            members = [ensemble.members.index(self.terms[row].input.name) for row in rows]
            scale = [self.u[row] or 1.0 for row in rows]
            block = np.asarray(ensemble.covariance)[np.ix_(members, members)] / np.outer(scale, scale)
            np.fill_diagonal(block, 1.0)
            matrix[self._block(rows, rows)] = block
        return matrix

    def spread(self, sizes: list[float]) -> Floats:
        """Correlation matrix of the related terms by the stated coefficients, with weights in proportion to `sizes`."""
        matrix = np.eye(len(self.related))
        for (a, b), r in self.stated.items():
            rows, columns = self.of_input(a), self.of_input(b)
            block = r * np.outer(_weights(sizes, rows), _weights(sizes, columns))
            matrix[self._block(rows, columns)] = block
            matrix[self._block(columns, rows)] = block.T
        for rows in self.causes.values():
            signs = [self.terms[row].component.sign for row in rows]
            matrix[self._block(rows, rows)] = np.outer(signs, signs)
        return matrix

    def _block(self, rows: list[int], columns: list[int]) -> tuple[Any, ...]:
        return np.ix_([self.place[row] for row in rows], [self.place[column] for column in columns])

    def among(self, rows: Sequence[int]) -> Floats:
        """Correlation matrix of some terms."""
        matrix = np.eye(len(rows))
        where = [at for at, row in enumerate(rows) if row in self.place]
        own = [rows[at] for at in where]
        matrix[np.ix_(where, where)] = self.correlation[self._block(own, own)]
        return matrix

    def times(self, parts: list[list[float]]) -> list[list[float]]:
        """Products of each of `parts`, which have a number for each term, with the correlation matrix of all terms."""
        if not (self.related and parts):
            return parts
        product = np.array(parts)
        product[:, self.related] = product[:, self.related] @ self.correlation
        products: list[list[float]] = product.tolist()
        return products

    def coefficients(self) -> Iterator[tuple[str, str, float]]:
        """Correlation coefficient of each pair of inputs that are correlated: Σ u_a·r_ab·u_b / (u(x_i)·u(x_j))."""
        inputs = [self.terms[row].input.name for row in self.related]
        names = list(dict.fromkeys(inputs))
        at = {name: i for i, name in enumerate(names)}
        weighted = np.zeros((len(names), len(inputs)))
        weighted[[at[name] for name in inputs], range(len(inputs))] = [self.u[row] for row in self.related]
        covariance = weighted @ self.correlation @ weighted.T
        rest = [sum(self.u[row] ** 2 for row in self.of_input(name) if row not in self.place) for name in names]
        u = np.sqrt(np.diag(covariance) + rest)
        for i, name in enumerate(names):
            for j in np.flatnonzero(np.abs(covariance[i, :i]) > _LEAST * u[i] * u[:i]):
                yield names[j], name, float(covariance[i, j] / (u[i] * u[j]))

    @property
    def inputs(self) -> Iterable[str]:
        """Names of the inputs that have terms."""
        return self._of_inputs

    @cached_property
    def _of_inputs(self) -> dict[str, list[int]]:
        return self._grouped(lambda term: term.input.name)

    @cached_property
    def _of_ensembles(self) -> dict[str, list[int]]:
        return self._grouped(lambda term: term.ensemble)

    def _grouped(self, key: Callable[[Term], str]) -> dict[str, list[int]]:
        """Indices of the terms by a name that each has."""
        found: dict[str, list[int]] = {}
        for row, term in enumerate(self.terms):
            found.setdefault(key(term), []).append(row)
        return found

    def rows(self, ensemble: str) -> list[int]:
        """Indices of the terms of an ensemble."""
        return self._of_ensembles.get(ensemble, [])

    def of_input(self, name: str) -> list[int]:
        """Indices of the terms of an input."""
        return self._of_inputs.get(name, [])


def _weights(sizes: list[float], rows: list[int]) -> Floats:
    chosen = np.array([sizes[row] for row in rows])
    return np.asarray(chosen / sqrt(float(chosen @ chosen)))


def joint(knowledge: Knowledge, names: Iterable[str]) -> Joint:
    """Terms of the inputs `names`, in the order of `knowledge`, with the ensembles and correlations among them."""
    wanted = set(names)
    terms = list(_terms(knowledge, wanted))
    stated = {pair: r for pair, r in knowledge.correlations.items() if r != 0 and wanted.issuperset(pair)}
    ensembles = [ensemble for ensemble in knowledge.ensembles if wanted.intersection(ensemble.members)]
    return Joint(terms, ensembles, stated)


def _terms(knowledge: Knowledge, wanted: set[str]) -> Iterator[Term]:
    members = {member: ensemble for ensemble in knowledge.ensembles for member in ensemble.members}
    for name, item in knowledge.inputs.items():
        if name in wanted:
            if name in members:
                yield _scatter(item, members[name])
            for component in item.components:
                yield Term(item, component)


def _scatter(item: Input, ensemble: Ensemble) -> Term:
    """The part of an input's uncertainty that an ensemble describes."""
    row = ensemble.members.index(item.name)
    scale = sqrt(max(float(ensemble.covariance[row, row]), 0.0))
    component = Component(ensemble.name, Student(scale, ensemble.dof), ensemble.dof, "A", ensemble.source)
    return Term(item, component, ensemble.name)
