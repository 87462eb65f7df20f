"""Free decay of a mass on the sample: natural frequency ω_n, damping ratio ζ and damping coefficient c."""

from typing import TYPE_CHECKING, Any

from metrology.decay.finding import DampingShape, DecayFinding, DecayRecord

if TYPE_CHECKING:
    from metrology.decay.analysis import DecayAnalysis, analyse, by_clock
    from metrology.decay.test import DecayTest

__all__ = ["DampingShape", "DecayAnalysis", "DecayFinding", "DecayRecord", "DecayTest", "analyse", "by_clock"]


def __getattr__(name: str) -> Any:
    """Import the analysis when it is asked for: to read a campaign file, or findings, needs none of it."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from metrology.decay import analysis

    return getattr(analysis, name)
