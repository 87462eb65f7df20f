"""What the report shows of a relaxation or creep test: its finding, from what the fits say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from metrology import message
from metrology.relaxation import checks, moduli
from metrology.relaxation.checks import Done, Seen
from metrology.relaxation.evidence import Supported
from metrology.relaxation.finding import Branch, Compared, Record, RelaxationFinding, Specimen, Weighed
from metrology.relaxation.model import Built, Facts
from metrology.relaxation.test import Mounting, RelaxationTest

CERTAIN = 0.999
"""Probability from which on the next form is not named."""
RELAXATION = "F = b + k_0·x − Σ k_i·∫(1 − exp(−(t−s)/τ_i))·x'(s)ds"
CREEP = "x = b + J_0·F + Σ J_i·∫(1 − exp(−(t−s)/τ_i))·F'(s)ds"


def presented(
    test: RelaxationTest, facts: Facts, done: tuple[Seen, Supported, Built], shared: float
) -> RelaxationFinding:
    """The finding of a test: its verdict, forms, specimens, moduli and checks."""
    seen, found, built = done
    specimens = seen.done
    quantity = "E" if "E_0" in facts.results else "k" if "k_0" in facts.results else "EA"
    ends = moduli.supported_range([one.levels for one in specimens])
    factors = [_factor(test, one.mounting, quantity) for one in specimens]
    scenes = [one.scene for one in specimens]
    grid = np.geomspace(*ends, moduli.POINTS)
    curve = moduli.predicted(found, scenes, factors, grid, shared)
    dma: tuple[Compared, ...] = ()
    if test.dma is not None:
        at = moduli.predicted(found, scenes, factors, test.dma.frequency, shared)
        dma = moduli.compared(test.dma, at, ends)
    return RelaxationFinding(
        held=test.held,
        by_strain=test.by_strain,
        verdict=_verdict(found),
        forms=_weighed(found),
        specimens=tuple(
            _specimen(one, first, built.values[one.mounting.name])
            for one, first in zip(specimens, seen.whole, strict=True)
        ),
        moduli=moduli.shown(quantity, curve),
        dma=dma,
        checks=checks.run(test, seen, found, built, dma),
        equations=(RELAXATION if test.held == "elongation" else CREEP, *_equations(built)),
        at=test.at,
        notes=tuple(checks.notes(specimens, found, np.array(ends))),
        significance=test.significance,
    )


def _factor(test: RelaxationTest, one: Mounting, quantity: str) -> float:
    """From force by stretch to the quantity that is shown."""
    length = one.length.value if one.length is not None else float("nan")
    by = {"E": 1 / one.area_value if test.by_strain else length / one.area_value,
          "k": 1 / length if test.by_strain else 1.0, "EA": 1.0}  # fmt: skip
    return float(by[quantity])


def _equations(built: Built) -> list[str]:
    return list(dict.fromkeys(one.equation for one in built.measurands))


def _verdict(found: Supported) -> str:
    """The most probable form with its probability, and the next one."""
    rows = _weighed(found)
    if rows[0].probability > CERTAIN or len(rows) < 2:
        return message.said("{form} (probability above {limit})", form=_words(rows[0]), limit=CERTAIN)
    return message.said(
        "{form} (probability {probability:.3g}); next {other} ({rest:.2g})",
        form=_words(rows[0]),
        probability=rows[0].probability,
        other=_words(rows[1]),
        rest=rows[1].probability,
    )


def _words(one: Weighed) -> str:
    return message.said("{form} with a drift of the readings", form=one.name) if one.drift else one.name


def _weighed(found: Supported) -> tuple[Weighed, ...]:
    rows = [
        Weighed(form.name, form.drift, float(p), all(fits[at].allowed for fits in found.fits))
        for at, (form, p) in enumerate(zip(found.forms, found.probability, strict=True))
    ]
    return tuple(sorted(rows, key=lambda one: -one.probability))


def _specimen(one: Done, first: Done, values: Mapping[str, float]) -> Specimen:
    """`first` is its whole record, which is shown, with the ramp that may have been left out."""
    best, of = one.best, first.scene.answer.of
    model = best.model
    if one is not first:
        shapes = len(best.values) - best.form.shapes
        columns = replace(one.scene, answer=first.scene.answer).columns(best.form, best.values[shapes:])
        model = columns @ best.values[:shapes]
    alpha, alpha_u = None, None
    if best.form.power:
        alpha, alpha_u = float(best.values[-1]), float(np.sqrt(best.covariance[-1, -1]))
    return Specimen(
        name=one.mounting.name,
        count=len(first.mounting.time),
        levels=tuple(each.value for each in one.levels.held),
        holds=tuple(each.duration for each in one.levels.held),
        ramp=one.levels.ramp,
        memory=best.memory,
        level=float(np.std(one.scene.answer.of.y - best.model)),
        branches=tuple(_branches(one)),
        alpha=alpha,
        alpha_u=alpha_u,
        k_0=values.get("k_0"),
        k_inf=values.get("k_inf"),
        E_0=values.get("E_0"),
        E_inf=values.get("E_inf"),
        record=Record(*(tuple(row.tolist()) for row in (of.time, of.u, of.y, model))),
    )


def _branches(one: Done) -> list[Branch]:
    """Parts and times of the branches with their intervals, fastest first."""
    m, known = len(one.times), one.branches
    rows = np.column_stack([known.values[m : 2 * m], known.u[m : 2 * m], known.values[2 * m :], known.u[2 * m :]])
    return [
        Branch(part, part_u, time, low, high, left, left_u)
        for (part, part_u, left, left_u), (low, time, high) in zip(rows.tolist(), one.times.tolist(), strict=True)
    ]
