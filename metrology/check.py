"""One check of data against what their model supposes, as a value; every method reports its checks so."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One check of the data against what the model supposes: statistic, its p-value, verdict and a sentence."""

    name: str
    statistic: float | None
    p_value: float | None
    passed: bool | None
    sentence: str
