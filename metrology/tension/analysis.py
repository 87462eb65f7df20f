"""Evaluation of a tension test: from records to inputs, measurement model and finding."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from metrology.gum.evaluation import Contribution
from metrology.message import said
from metrology.tension import checks
from metrology.tension.cycles import loadings
from metrology.tension.finding import Curve, Scatter, Specimen, TensionFinding
from metrology.tension.lines import End, Lines, end, lines
from metrology.tension.model import Builder, Built
from metrology.tension.results import BY_CROSSHEAD, BY_LENGTHS, EQUATIONS, UNITS, Facts
from metrology.tension.slope import Array
from metrology.tension.test import TensionTest

POINTS = 400
"""Columns of a thinned record, each with its extremes."""
WORDS = {
    "strain": "strain from {low:.4g} % to {high:.4g} %, as stated",
    "force": "force from {low:.5g} N to {high:.5g} N, as stated",
    "share": "{low:.3g} % to {high:.3g} % of the largest force, as stated",
    "longest": "the longest range of force that is straight within noise and {tolerance:.2g} % of the reading's range",
}


@dataclass(frozen=True)
class TensionAnalysis:
    """What a tension test hands to the evaluation of the campaign, and what it shows.

    Parameters
    ----------
    contribution : Contribution
        Inputs, ensembles and measurands ``{test}.k``, ``{test}.{specimen}.k`` and so on.
    drawn : tuple of Lines
        The line of every specimen.
    finding : TensionFinding
        What the report shows.
    failures : tuple of str
        Why a result that was asked for is not there.
    """

    contribution: Contribution
    drawn: tuple[Lines, ...]
    finding: TensionFinding
    failures: tuple[str, ...]


def analyse(test: TensionTest, facts: Facts, namespace: Mapping[str, float]) -> TensionAnalysis:
    """Stiffness, modulus, set-up and strength of the specimens and their means.

    The slope of strain (or crosshead) by force over the range of each record is fitted with the memory of its own noise
    (`slope`). Results of specimens follow from it by the equations of the finding; scales of the instruments and the
    gauge length are inputs that all specimens share, slopes and sections are each one's own. The mean over the
    specimens carries the scatter between them (JCGM 100 4.2.3), less what the records themselves explain.

    Parameters
    ----------
    test : TensionTest
        Records and what is known of the instruments.
    facts : Facts
        What the test declares.
    namespace : mapping of str to float
        Values that the model holds already: lengths, areas.

    Raises
    ------
    MetrologyError
        Where a record does not pass its range, or has too few readings in it.
    """
    drawn = lines(test)
    ends = tuple(end(one, test.fall) for one in test.mountings)
    built = Builder(test, drawn, ends, facts).built(namespace)
    finding = _finding(test, (drawn, ends), built, facts)
    contribution = Contribution(built.inputs, built.ensembles, {}, built.measurands)
    return TensionAnalysis(contribution, drawn, finding, tuple(_failures(test, ends, built, facts)))


def _failures(test: TensionTest, ends: tuple[End, ...], built: Built, facts: Facts) -> list[str]:
    """One sentence for each strength that no record reaches."""
    given = {one.name for one in built.measurands}
    lacking = [name for name in facts.results if f"{test.name}.{name}" not in given]
    if not lacking:
        return []
    short = ", ".join(one.name for one, reached in zip(test.mountings, ends, strict=True) if not reached.broken)
    text = "{test} has no {lacking:comma}: the records of {specimens} end before the break."
    return [said(text, test=test.name, lacking=tuple(lacking), specimens=short or said("all specimens"))]


def _finding(
    test: TensionTest, done: tuple[tuple[Lines, ...], tuple[End, ...]], built: Built, facts: Facts
) -> TensionFinding:
    drawn, ends = done
    off = checks.outliers(test, drawn, built)
    chosen = test.range
    factor = 1.0 if chosen.by == "force" else 100.0
    text, tolerance = WORDS[chosen.by], 100 * test.tolerance
    by = said(text, low=factor * chosen.low, high=factor * chosen.high, tolerance=tolerance)
    if chosen.passage > 1:
        by = said("{range}; loading {number}", range=by, number=chosen.passage)
    basis = "extensometer" if facts.strain else "crosshead"
    return TensionFinding(
        by=by,
        basis=basis,
        specimens=tuple(
            _specimen(test, one, reached, built, off) for one, reached in zip(drawn, ends, strict=True)
        ),
        scatter=tuple(_scatter(built)),
        checks=checks.run(test, drawn, built, facts),
        equations=tuple(_equations(facts)),
        notes=tuple(checks.notes(test, drawn, facts)),
        significance=test.significance,
        loadings=tuple(row for one in drawn for row in loadings(one)),
    )  # fmt: skip


def _equations(facts: Facts) -> list[str]:
    found = [EQUATIONS[name] for name in facts.results]
    if facts.by_lengths:
        return [BY_LENGTHS, *(one for one in found if one not in (EQUATIONS["EA"], EQUATIONS["C"]))]
    return found if facts.strain else [BY_CROSSHEAD, *(one for one in found if one != EQUATIONS["EA"])]


def _scatter(built: Built) -> list[Scatter]:
    found = []
    for name in UNITS:
        values = [own[name] for own in built.values.values() if name in own]
        if len(values) > 1:
            within = [own[name] for own in built.within.values() if name in own]
            found.append(Scatter(name, UNITS[name], float(np.mean(values)), float(np.std(values, ddof=1)),
                                 float(np.sqrt(np.mean(np.square(within))))))  # fmt: skip
    return found


def _specimen(test: TensionTest, one: Lines, reached: End, built: Built, off: Mapping[str, str]) -> Specimen:
    name, line, span = one.mounting.name, one.main, one.passage.force
    values, within = built.values.get(name, {}), built.within.get(name, {})
    size = abs(line.value) * (span[1] - span[0]) or 1.0
    low, high = (end if isfinite(end) else None for end in one.passage.strain)
    return Specimen(
        name, line.count, *span, low, high, line.intercept, line.value, line.u, line.dof, line.memory,
        line.bow / size, line.bow_u / size,
        values.get("k"), values.get("EA"), values.get("E"), values.get("C"), within.get("C"), reached.most,
        reached.reached if test.to_break else None, reached.strain if isfinite(reached.strain) else None,
        off.get(name, ""), _curve(one),
    )  # fmt: skip


def _curve(one: Lines) -> Curve:
    """The record, thinned to its extremes: a spike stays."""
    mounting = one.mounting
    force = mounting.force
    keep = _extremes([channel for channel in (force, mounting.strain, mounting.crosshead) if channel is not None])
    strain, crosshead = mounting.strain, mounting.crosshead
    seen = () if strain is None else tuple(value if isfinite(value) else None for value in strain[keep].tolist())
    return Curve(tuple(force[keep].tolist()), seen, () if crosshead is None else tuple(crosshead[keep].tolist()))


def _extremes(channels: list[Array]) -> NDArray[np.intp]:
    """Places of the least and the largest value of every channel in each of `POINTS` columns, and both ends."""
    count = len(channels[0])
    if count <= 2 * POINTS:
        return np.arange(count)
    each = -(-count // POINTS)
    whole = count // each * each
    found = [np.array([0, count - 1])]
    first = np.arange(0, whole, each)
    for channel in channels:
        rows = np.nan_to_num(channel[:whole], nan=0.0).reshape(-1, each)
        found += [first + rows.argmin(axis=1), first + rows.argmax(axis=1)]
    return np.unique(np.concatenate(found))
