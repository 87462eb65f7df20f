"""What must be known before a number of the findings is used, said in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING

from metrology.chain import attained, items
from metrology.chain.doubt import Doubt
from metrology.chain.failed_checks import UNDETERMINED
from metrology.findings import Result
from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.gum.evaluation import Evaluation


def without_value(evaluation: Evaluation) -> Iterator[str]:
    """Say of every quantity without a value, or without an uncertainty by either way, why that is."""
    for name, estimate in evaluation.estimates.items():
        reason = estimate.dof_note.removeprefix("undefined: ")
        if not isfinite(estimate.value):
            yield said("{name} has no value. {reason:quoted}", name=name, reason=reason)
        elif not isfinite(estimate.u):
            yield said(
                "{name} has no uncertainty by the GUM uncertainty framework. {reason:quoted} {verdict:quoted}",
                name=name,
                reason=reason,
                verdict=estimate.monte_carlo.verdict,
            )


def of_results(campaign: Campaign, results: tuple[Result, ...]) -> list[str]:
    """Return what must be known before a number is used."""
    found: list[str] = [
        said("Instrument {name}: {state}.", name=state.id, state=state.sentence)
        for state in items.instrument_states(campaign)
        if state.state != "valid" and state.used_by
    ]
    # What has no value has no interval either, and failures say why.
    known = [result for result in results if result.headline and isfinite(result.value)]
    with_u = [one for one in known if isfinite(one.u)]
    doubtful = [one.name for one in with_u if not one.monte_carlo.law_valid and isfinite(one.monte_carlo.low)]
    if doubtful:
        text = (
            "The GUM uncertainty framework is not confirmed for {names:comma} (JCGM 101, clause 8): the Monte Carlo "
            "interval is reported."
        )
        found.append(said(text, names=tuple(doubtful)))
    for result in (one for one in with_u if not isfinite(one.monte_carlo.low)):
        text = "{name} has no interval, and no verdict rests on it. {verdict:quoted}"
        found.append(said(text, name=result.name, verdict=result.monte_carlo.verdict))
    found += _without_moments(results, campaign.coverage_probability)
    found += attained.too_narrow(results, campaign.coverage_probability)
    for result in (one for one in known if one.u == 0):
        text = "{name} has u = 0: nothing that it depends on carries an uncertainty, or its readings do not scatter."
        if any(row.u for row in result.budget):
            text = "{name} has u = 0: the uncertainties that it depends on cancel, as they are one."
        found.append(said(text, name=result.name))
    return found


def undetermined(results: tuple[Result, ...], against: Mapping[str, Sequence[Doubt]]) -> tuple[str, ...]:
    """Say of results that may be zero, which by their nature they cannot, that they do: also where none is judged."""
    names = [one.name for one in results if one.headline]
    return tuple(one.sentence for name in names for one in against.get(name, ()) if one.check == UNDETERMINED)


def _without_moments(results: tuple[Result, ...], probability: float) -> list[str]:
    """Say of results whose draws have no standard deviation what value and u are then."""
    from scipy.special import ndtri

    names = [
        result.name
        for result in results
        if result.headline and result.monte_carlo.has_no_moments and not result.monte_carlo.law_valid
    ]
    if not names:
        return []
    text = (
        "The draws of {names:comma} have no standard deviation: the value is their median, and u is half the width of "
        "the {percent:g} % interval over {factor:.2f}."
    )
    factor = float(ndtri((1 + probability) / 2))
    return [said(text, names=tuple(names), percent=100 * probability, factor=factor)]


def empty(results: tuple[Result, ...], failures: list[str]) -> tuple[str, ...]:
    """Say that there was nothing to do, where that is why there are no results."""
    return () if results or failures else (said("The campaign declares nothing to evaluate."),)
