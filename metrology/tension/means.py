"""Means of results over the specimens of a test, and the scatter between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.gum.inputs import Ensemble, Input
from metrology.message import said
from metrology.tension.lines import Lines

if TYPE_CHECKING:
    from metrology.tension.model import Builder


def means(
    of: Builder, values: Mapping[str, Mapping[str, float]], within: Mapping[str, Mapping[str, float]]
) -> Iterator[Ensemble]:
    """Add the mean of every result over the specimens to a model, and return the scatter between them.

    The scatter of the specimens holds that within them: what is left of s² beside it is the scatter between.
    """
    names = [name for name in of.facts.results if any(name in own for own in values.values())]
    held = {name: [one for one in of.drawn if name in values[one.mounting.name]] for name in names}
    scattered = []
    for name in names:
        members, scatter = held[name], f"{of.test.name}.scatter of {name}"
        s2 = float(np.var([values[one.mounting.name][name] for one in members], ddof=1)) if len(members) > 1 else 0
        own2 = float(np.mean([within[one.mounting.name][name] ** 2 for one in members]))
        part = max(0.0, 1.0 - own2 / s2) if s2 > 0 else 0.0
        if part > 0:
            what = said("relative scatter of {name} between the specimens", name=name)
            of.know(Input(scatter, 0.0, (), "1", what))
            scattered.append((name, part))
        full = [of.name(one, name) for one in members]
        added = scatter if part > 0 else ""
        size = float(np.sqrt(np.mean([values[one.mounting.name][name] ** 2 for one in members])))
        equation = said("{name} = mean over {count} specimens", name=name, count=len(full))
        of.add(f"{of.test.name}.{name}", _mean(full, added, size), name, equation)
    yield from _scattered(of, values, scattered, held)


def _scattered(
    of: Builder,
    values: Mapping[str, Mapping[str, float]],
    scattered: list[tuple[str, float]],
    held: Mapping[str, list[Lines]],
) -> Iterator[Ensemble]:
    """One ensemble of all results that every specimen has, and one for each other."""
    whole = [(name, part) for name, part in scattered if len(held[name]) == len(of.drawn)]
    rest = [[one] for one in scattered if one not in whole]
    for group in [whole, *rest]:
        if not group:
            continue
        members = held[group[0][0]]
        rows = np.array([[values[one.mounting.name][name] for one in members] for name, _ in group])
        rows = rows / np.sqrt(np.mean(rows**2, axis=1, keepdims=True))
        kept = np.sqrt([part for _, part in group])
        covariance = np.atleast_2d(np.cov(rows, ddof=1)) * np.outer(kept, kept) / len(members)
        names = tuple(f"{of.test.name}.scatter of {name}" for name, _ in group)
        text = "standard deviation of the mean of {count} specimens, less what each one's record explains"
        source = said(text, count=len(members))
        text = "scatter between specimens, {test}" if group is whole else "scatter between specimens, {name}, {test}"
        label = said(text, name=group[0][0], test=of.test.name)
        yield Ensemble(label, names, covariance, len(members) - 1.0, source)


def _mean(names: list[str], scatter: str, size: float) -> Callable[[Mapping[str, Any]], Any]:
    """Mean of results, with the scatter between them over their size.

    The size, a root mean square, is a number and no result: a mean near zero, as of a compliance, leaves it large.
    """
    return lambda n: sum(n[name] for name in names) / len(names) + (size * n[scatter] if scatter else 0.0)
