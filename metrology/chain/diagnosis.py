"""Diagnosis of every test with a model and data, after its evaluation; where there can be none, a sentence why."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.errors import MetrologyError
from metrology.message import said
from metrology.methods import METHODS

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.diagnosis import Diagnosis
    from metrology.findings import Findings
    from metrology.method import Task

OFF = said("No test was diagnosed, as the campaign says.")


def add(task: Task[Any], ready: Any, *, off: bool) -> Diagnosis | None:
    """Add the diagnosis of a test, or the sentence why there is none: a report is made all the same."""
    import numpy as np

    from metrology.diagnostics.own import OwnError

    name, warnings, diagnose = task.name, task.model.warnings, task.method.diagnose
    if off or diagnose is None:
        why = OFF if off else said("{name} was not diagnosed: its method has no diagnosis.", name=name)
        warnings.extend([why] if why not in warnings else [])
        return None
    task.progress(f"{name}: diagnosis")
    named = replace(task, progress=lambda text: task.progress(f"{name}: {text}"))
    rng = np.random.default_rng([task.campaign.seed, *f"{name}.diagnosis".encode()])
    try:
        found = diagnose(named, ready, rng)
        task.model.diagnosis.append(found)
    except OwnError:
        raise
    except MetrologyError as error:
        faults = "; ".join(f"{fault.where}: got {fault.got}; expected {fault.expected}" for fault in error.faults)
        warnings.append(said("{name} was not diagnosed. {faults:quoted}.", name=name, faults=faults))
    except (ArithmeticError, ValueError) as error:
        # Linear algebra that does not converge, a number out of range: nothing is judged by the results.
        text = (
            "{name} was not diagnosed: its numbers failed ({error:quoted}). The model may be far from the readings: "
            "compare them with it."
        )
        task.model.undiagnosed[name] = said(text, name=name, error=str(error))
        warnings.append(task.model.undiagnosed[name])
    else:
        return found
    return None


def extended(campaign: Campaign, findings: Findings, folder: Path) -> dict[str, bytes]:
    """Return `extended.yaml` for `folder`: the campaign with every model that a diagnosis extends."""
    from metrology.campaign import extension

    models = {found.test: _sizes(found) for found in findings.diagnosis if METHODS[found.method].carried is not None}
    models = {name: model for name, model in models.items() if model}
    return {"extended.yaml": extension.extended(campaign, models, folder)} if models else {}


def _sizes(found: Diagnosis) -> dict[str, tuple[float, float | None]]:
    """Parameters of the extended model with what is known of their uncertainty."""
    u = {value.name: value.u for cause in found.causes for value in cause.parameters if isfinite(value.u)}
    return {name: (value, u.get(name)) for name, value in found.extended_model.items()}
