"""Sizes, evidence and gains of a diagnosis as they are printed."""

from __future__ import annotations

from math import isfinite

from metrology.diagnosis import Cause, Detectable, Gain, Value
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import number, rounded, scale

VAGUE = 100.0
"""Standard uncertainty over the value from which on a parameter is called not determined."""
SURE = 100.0
"""Ln of a Bayes factor beyond which a larger one says no more."""


def smallest(one: Detectable, language: Language = ENGLISH) -> str:
    """Smallest detectable size on the scale that reads well; a dash where there is none."""
    if one.size is None:
        return "–"
    size, unit = scale(one.size, one.unit)
    return language.figures(f"{number(one.size / size, 2)} {unit}".rstrip())


def evidence(cause: Cause, language: Language = ENGLISH) -> str:
    """Ln of the Bayes factor; beyond `SURE` no more than that, and a dash where the cause was not fitted."""
    if cause.log_bayes is None:
        return "–"
    if abs(cause.log_bayes) > SURE:
        return f"> {SURE:.0f}" if cause.log_bayes > 0 else f"< −{SURE:.0f}"
    return language.figures(number(cause.log_bayes, 2))


def parameter(one: Value, language: Language = ENGLISH) -> str:
    """Name, value ± u and the 95 % interval."""
    name, scatters, _ = one.name.rpartition(".")[2].partition(" (standard deviation)")
    if scatters:
        name = language.say("{name} (standard deviation)", name=name)
    if one.u > VAGUE * max(abs(one.value), 1e-300):
        return language.say("{name}: not determined", name=name)
    size, unit = scale(one.value, one.unit)
    if not isfinite(one.u):
        return language.figures(f"{name} = {number(one.value / size)} {unit}".rstrip())
    value, u = rounded(one.value / size, one.u / size)
    low, high = (None if end is None else rounded(end / size, one.u / size)[0] for end in (one.low, one.high))
    known = {"value": language.figures(f"{name} = {value} ± {u} {unit}".rstrip())}
    match low, high:
        case None, None:
            return language.say("{value}, 95 % interval open at both ends", **known)
        case None, str():
            return language.say("{value}, 95 % up to {high:figures}", high=high, **known)
        case str(), None:
            return language.say("{value}, 95 % from {low:figures}", low=low, **known)
        case _:
            return language.say("{value}, 95 % {low:figures} … {high:figures}", low=str(low), high=str(high), **known)


def ratio(one: Gain, language: Language = ENGLISH) -> str:
    """Ratio of residuals before and after with its interval."""
    shown = {key: number(value, 4) for key, value in (("ratio", one.ratio), ("low", one.low), ("high", one.high))}
    return language.say("{ratio:figures}, 95 % {low:figures} … {high:figures}", **shown)
