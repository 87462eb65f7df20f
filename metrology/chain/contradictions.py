"""Results that contradict another test of the sample, or what is known from elsewhere."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import combinations
from math import inf, sqrt
from typing import TYPE_CHECKING

from metrology.chain.doubt import Doubt, with_acceptance
from metrology.gum.comparison import en
from metrology.language.display import normalised
from metrology.message import said
from metrology.slip import likely

if TYPE_CHECKING:
    from collections.abc import Sequence

    from metrology.campaign.judgement import Comparison as StatedComparison
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Identity, Plan
    from metrology.findings import Comparison

CERTAIN = 2.0
"""|E_n| beyond which two results of one sample contradict each other: one in 16 000 by chance (4 u, U = 2·u)."""
CLASS = sqrt(3.0)
"""Ratio of a result and what is known of it from elsewhere, beyond which one of them is wrong: midway between 1.5, by
which honest moduli of one class of material differ, and two, which half of a section or of a gauge length makes."""
MATERIAL = re.compile(r"(E|G|nu|rho)(_0|_inf|_t|_sec|_tan)?")
"""Quantities of a material: what a handbook says of them is of another specimen, and holds within its class (`CLASS`).
A value known from elsewhere of any other quantity is of this very one."""
DAMPING = ("c", "zeta")
"""Results of a test that say nothing of its other ones."""
ELSEWHERE = "value known from elsewhere"
"""Failed check of a result and what is known of it from elsewhere."""
BETWEEN = "another test of the sample"
"""Failed check of two tests whose results contradict each other."""


def contradictions(
    campaign: Campaign, plan: Plan, compared: Sequence[Comparison]
) -> tuple[dict[str, tuple[Doubt, ...]], dict[str, tuple[Doubt, ...]]]:
    """Tests, and quantities by name, that contradict another test of the sample or what is known from elsewhere."""
    of_tests: dict[str, tuple[Doubt, ...]] = {}
    of_names: dict[str, tuple[Doubt, ...]] = {}
    exchanged = _exchanged(campaign, plan, compared)
    for one in compared:
        names = [name for name in dict.fromkeys((one.a, one.b)) if name in plan.names]
        sides = [each for name in names if (each := plan.identities.get(name)) and each.test]
        doubt = (
            _between(plan, one, sides) if len(names) > 1 else _elsewhere(plan, one, names[0], exchanged) if names
            else None
        )  # fmt: skip
        if doubt is None:
            continue
        entry = next((each for each in campaign.comparisons if _is_of(each, one)), None)
        doubt = with_acceptance(doubt, entry.accepted if entry is not None else None)
        for each in sides:
            of_tests[each.test] = (*of_tests.get(each.test, ()), doubt)
        for name in names if not sides else ():
            of_names[name] = (*of_names.get(name, ()), doubt)
    return of_tests, of_names


def _is_of(stated: StatedComparison, one: Comparison) -> bool:
    """Whether a comparison is the one that the file states."""
    sides = [side.quantity or (side.value and (side.value.source or side.value.description)) for side in stated.between]
    own = f"{one.a} against {one.b}"
    return (stated.title or own) == one.title and all(side in (one.a, one.b) for side in sides if side)


def _off(one: Comparison) -> tuple[bool, float]:
    """Whether two values are further apart than honest ones of one class, and their ratio."""
    ratio = one.value_a / one.value_b if one.value_b else inf
    return ratio <= 0 or max(ratio, 1 / ratio) > CLASS, ratio


def _between(plan: Plan, one: Comparison, sides: Sequence[Identity]) -> Doubt | None:
    """Results of two tests, or of one and a quantity that the campaign states."""
    alike = len({(each.sample, each.quantity) for each in sides}) == 1
    off, _ = _off(one)
    if one.agrees is not False or not alike or not (off or (len(sides) > 1 and abs(one.en or 0.0) > CERTAIN)):
        return None
    return Doubt(BETWEEN if len(sides) > 1 else ELSEWHERE, _contradiction(plan, one, sides))


def _elsewhere(plan: Plan, one: Comparison, name: str, exchanged: Mapping[str, str]) -> Doubt | None:
    """A quantity and what is known of it from elsewhere: of a material its class, of anything else this very one."""
    identity = plan.identities.get(name)
    sides = [identity] if identity is not None and identity.test else []
    off, _ = _off(one)
    if one.agrees or one.difference == 0:
        return None
    if off:
        return Doubt(ELSEWHERE, _contradiction(plan, one, sides))
    if identity is not None and MATERIAL.fullmatch(identity.quantity):
        return None
    sentence = (
        said("{a} and {b} contradict each other: no uncertainty covers their difference.", a=one.a, b=one.b)
        if one.en is None
        else said(
            "{a} and {b} contradict each other: |E_n| = {en:figures}.", a=one.a, b=one.b, en=normalised(abs(one.en))
        )
    )
    if name in exchanged:
        sentence = said("{texts:space}", texts=(sentence, exchanged[name]))
    concerns = DAMPING if sides and sides[0].quantity in DAMPING else ()
    return Doubt(ELSEWHERE, sentence, covered=True, concerns=concerns)


def _contradiction(plan: Plan, one: Comparison, sides: Sequence[Identity]) -> str:
    off, ratio = _off(one)
    sentence = said("{a} and {b} contradict each other: their ratio is {ratio:.3g}.", a=one.a, b=one.b, ratio=ratio)
    if not off or ratio <= 0:
        return sentence
    slip = likely(ratio, dynamic=_is_dynamic(plan, sides))
    return said("{sentence} Likely: {slip}.", sentence=sentence, slip=slip)


def _exchanged(campaign: Campaign, plan: Plan, compared: Sequence[Comparison]) -> dict[str, str]:
    """Results of two samples of which each fits the other's reference and not its own: what that means, by result."""
    found: dict[str, str] = {}
    refuted = [
        (one, identity) for one in compared
        if one.agrees is False and (identity := plan.identities.get(one.a)) is not None and identity.test
        and one.b not in plan.names and identity.quantity in campaign.samples[identity.sample].references
    ]  # fmt: skip
    for (one, own), (other, others) in combinations(refuted, 2):
        if own.sample == others.sample or (own.quantity, one.unit) != (others.quantity, other.unit):
            continue
        crossed = (en(a.value_a, a.u_a, b.value_b, b.u_b).agrees for a, b in ((one, other), (other, one)))
        if all(crossed):
            text = "{a} fits the reference of {second} and {b} that of {first}: the samples may be exchanged."
            sentence = said(text, a=one.a, b=other.a, first=own.sample, second=others.sample)
            found |= {one.a: sentence, other.a: sentence}
            plan.warnings.append(sentence)
    return found


def _is_dynamic(plan: Plan, sides: Sequence[Identity]) -> bool:
    """Whether one of some results follows from a frequency, as those of a mass that moves do."""
    methods = {test.id: test.method for test in plan.tests}
    return any(methods[each.test] in ("decay", "response") for each in sides)
