"""What is taken as exact: numbers of which nobody stated an uncertainty, and how large it may be before it matters."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from math import inf, sqrt
from typing import TYPE_CHECKING

from metrology import ties
from metrology.findings import TakenAsExact
from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component
from metrology.gum.linear import linearise
from metrology.gum.rounding import readable
from metrology.language.display import symbol
from metrology.message import said

if TYPE_CHECKING:
    from collections.abc import Mapping

    from metrology.chain.plan import Plan
    from metrology.gum.evaluation import Evaluation
    from metrology.gum.inputs import Input

TENTH = 1.1
"""Ratio of two standard uncertainties that differ in the digits reported (JCGM 100, 7.2.6: two digits of u)."""
SHARE = sqrt(TENTH**2 - 1)
"""An uncertainty of this share of u(y), added in quadrature, makes u(y) a tenth larger: the digits that are reported
show it (JCGM 100, 7.2.6: two digits of u)."""

MOST = 4
"""Loads of a test that a sentence names one by one; more are one entry, by the load that matters most."""
LEAST = 0.5
"""Part of a load from which on its uncertainty is no plausible one."""
_LOAD = re.compile(r"load \S+$")

STATED_IN = said(
    "State it with an uncertainty: under 'known', or 'model' for what has no entry there "
    "(model: {{setup.compliance: 2(1) um/N}})."
)
"""Where the rig of a response test takes an uncertainty."""


def taken_as_exact(plan: Plan, evaluation: Evaluation) -> tuple[TakenAsExact, ...]:
    """Return every number without an uncertainty that could matter, with the u of it that makes u(y) a tenth larger.

    It could matter where that u is smaller than what may be wrong at all: half of the range in which a laboratory meets
    such a number, or the number itself.
    """
    headline = {
        name: estimate.reported[1]
        for name, estimate in evaluation.estimates.items()
        if plan.identities[name].headline and 0 < estimate.reported[1] < inf
    }
    found = [*_inputs(plan, headline), *_of_fits(plan, headline)]
    return tuple(sorted(found, key=lambda one: one.name))


def _inputs(plan: Plan, headline: Mapping[str, float]) -> Iterator[TakenAsExact]:
    knowledge = plan.knowledge
    members = {name for ensemble in knowledge.ensembles for name in ensemble.members}
    exact = {
        name: one
        for name, one in knowledge.inputs.items()
        if one.is_stated and one.u == 0 and name not in members and not _is_definition(one)
    }
    varied = {
        name: replace(one, components=(Component("varied", Normal(1.0)),)) if name in exact else one
        for name, one in knowledge.inputs.items()
    }
    linear = linearise(plan.measurands, replace(knowledge, inputs=varied))
    slopes = {line.measurand.name: line.sensitivities for line in linear}
    for name, one in exact.items():
        reach = (LEAST if _LOAD.match(one.description) else 1.0) * abs(one.value) or 1.0
        yield from _judged(name, one.description, one.unit, one.value, reach, headline, {
            result: slopes[result].get(name, 0.0) for result in headline
        })  # fmt: skip


def _is_definition(one: Input) -> bool:
    """Whether a number is a count or a factor, not something measured; the share of an indication is measured."""
    return one.unit == "1" and one.value != 0


def _of_fits(plan: Plan, headline: Mapping[str, float]) -> Iterator[TakenAsExact]:
    explained = {parameter.name for found in plan.diagnosis for cause in found.causes for parameter in cause.parameters
                 if cause.effect in found.named}  # fmt: skip
    for one in plan.held:
        if one.name not in explained:
            yield from _judged(
                f"{one.test}.{one.name}", one.description, one.unit, one.value, one.reach, headline, one.slopes
            )


def _judged(
    name: str,
    description: str,
    unit: str,
    value: float,
    reach: float,
    headline: Mapping[str, float],
    slopes: Mapping[str, float],
) -> Iterator[TakenAsExact]:
    most = {
        result: SHARE * headline[result] / abs(slope)
        for result, slope in slopes.items()
        if slope and result in headline
    }
    if most and most[result := min(most, key=lambda key: ties.level(most[key]))] < reach:
        yield TakenAsExact(name, description, value, unit, result, most[result])


def sentences(found: tuple[TakenAsExact, ...], plan: Plan) -> Iterator[str]:
    """One sentence for each test or sample that owns such numbers."""
    owners: dict[str, list[TakenAsExact]] = {}
    for one in found:
        owners.setdefault(one.name.partition(".")[0], []).append(one)
    for owner, items in owners.items():
        loads = [one for one in items if _LOAD.match(one.description)]
        alone = items if len(loads) <= MOST else [one for one in items if one not in loads]
        parts = tuple(
            said(
                "{what} (u = {size:figures} makes u({quantity}) a tenth larger)",
                what=one.description or one.name,
                size=readable(one.u, one.unit),
                quantity=symbol(plan.identities[one.result].quantity),
            )
            for one in alone
        )
        if len(loads) > MOST:
            least = min(loads, key=lambda one: ties.level(one.u))
            together = said(
                "{count} loads, of which {first} matters most (u = {size:figures} makes u({quantity}) a tenth larger)",
                count=len(loads),
                first=least.description,
                size=readable(least.u, least.unit),
                quantity=symbol(plan.identities[least.result].quantity),
            )
            parts = (together, *parts)
        text = "{owner}: no uncertainty is stated of what follows, so it is taken as exact: {parts}."
        sentence = said(text, owner=owner, parts=parts)
        advice = next((one.advice or STATED_IN for one in plan.held if one.test == owner), "")
        yield said("{sentence} {advice}", sentence=sentence, advice=advice) if advice else sentence
