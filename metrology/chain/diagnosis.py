"""Diagnosis of every test with a model and data, after its evaluation; where there can be none, a sentence why."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.errors import MetrologyError

if TYPE_CHECKING:
    import numpy as np

    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.decay import DecayTest
    from metrology.diagnosis import Diagnosis
    from metrology.elongation import ElongationTest
    from metrology.findings import Findings
    from metrology.identify import Identification
    from metrology.response.analysis import ResponseTest

Progress = Callable[[str], None]
OFF = "No test was diagnosed, as the campaign says."


def add_elongation(plan: Plan, campaign: Campaign, test: ElongationTest, sample: str, progress: Progress) -> None:
    """Diagnose an elongation test."""
    from metrology.diagnose import elongation

    _add(
        plan,
        campaign,
        test.name,
        progress,
        lambda rng, _say: elongation(test, rng=rng, sample=sample, own=campaign.own),
    )


def add_decay(plan: Plan, campaign: Campaign, test: DecayTest, sample: str, progress: Progress) -> None:
    """Diagnose a free-decay test."""
    from metrology.diagnose import decay

    _add(plan, campaign, test.name, progress, lambda rng, _say: decay(test, rng=rng, sample=sample))


def add_response(
    plan: Plan, campaign: Campaign, test: ResponseTest, found: Identification | None, progress: Progress
) -> None:
    """Diagnose a response test by all its runs, beginning at what was identified."""
    from metrology.diagnose import Settings, response
    from metrology.response.analysis import given_priors

    priors = (*test.priors, *given_priors(test))
    start: dict[str, float] = {}
    if found is not None and found.status == "ok":
        # Runs that were not fitted begin at what is stated: near enough that the optimum need not be searched again.
        start = {f"{prior.name}@{run.name}": 0.0 for prior in priors if prior.per_run > 0 for run in test.runs}
        start |= {entry.name: entry.value for entry in found.parameters}

    def diagnosed(rng: np.random.Generator, say: Progress) -> Diagnosis:
        settings = Settings(test.sample, test.name, start, campaign.diagnosis.without, own=campaign.own, progress=say)
        return response(test.rig, test.runs, rng=rng, free=test.free, priors=priors, settings=settings)

    _add(plan, campaign, test.name, progress, diagnosed)


def _add(
    plan: Plan,
    campaign: Campaign,
    name: str,
    progress: Progress,
    diagnosed: Callable[[np.random.Generator, Progress], Diagnosis],
) -> None:
    """Add one diagnosis, or the sentence why there is none: a report is made all the same."""
    import numpy as np

    from metrology.diagnose.own import OwnError

    if campaign.diagnosis.off:
        if OFF not in plan.warnings:
            plan.warnings.append(OFF)
        return
    progress(f"{name}: diagnosis")
    rng = np.random.default_rng([campaign.seed, *f"{name}.diagnosis".encode()])
    try:
        plan.diagnosis.append(diagnosed(rng, lambda text: progress(f"{name}: {text}")))
    except OwnError:
        raise
    except MetrologyError as error:
        faults = "; ".join(f"{fault.where}: got {fault.got}; expected {fault.expected}" for fault in error.faults)
        plan.warnings.append(f"{name} was not diagnosed. {faults}.")
    except (ArithmeticError, ValueError) as error:
        # Linear algebra that does not converge, a number out of range: the results stand without a diagnosis.
        plan.warnings.append(
            f"{name} was not diagnosed: its numbers failed ({error}). The model may be far from the readings: look at "
            "them beside the stated model."
        )


def extended(campaign: Campaign, findings: Findings, folder: Path) -> dict[str, bytes]:
    """Return `extended.yaml` for `folder`: the campaign with every response model that a diagnosis extends."""
    from metrology.campaign import extension

    models = {found.test: _sizes(found) for found in findings.diagnosis if found.method == "response"}
    models = {name: model for name, model in models.items() if model}
    return {"extended.yaml": extension.extended(campaign, models, folder)} if models else {}


def _sizes(found: Diagnosis) -> dict[str, tuple[float, float | None]]:
    """Parameters of the extended model with what is known of their uncertainty."""
    u = {value.name: value.u for cause in found.causes for value in cause.parameters if isfinite(value.u)}
    return {name: (value, u.get(name)) for name, value in found.extended_model.items()}
