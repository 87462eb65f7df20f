"""From a campaign file of a mechanical test laboratory to a signed-off test report.

    import metrology
    results = metrology.run("campaigns/tapes/campaign.yaml")
    results["al-1100-elongation.k"]  # 24740 ± 350 N/m

The public names are those of `__all__`; `docs/python.md` describes them. Importing this package loads neither NumPy nor
SciPy: what a name needs is loaded when it is first used.
"""

from importlib import import_module

__version__ = "0.2.0"
_HOMES = {
    "Budget": "metrology.api",
    "Force": "metrology.rig",
    "MetrologyError": "metrology.errors",
    "Plot": "metrology.api",
    "Plots": "metrology.api",
    "Quantity": "metrology.api",
    "Results": "metrology.api",
    "Rig": "metrology.rig",
    "Run": "metrology.rig",
    "diagnose": "metrology.api",
    "identify": "metrology.api",
    "load": "metrology.api",
    "run": "metrology.api",
    "simulate": "metrology.rig",
}
__all__ = [
    "Budget",
    "Force",
    "MetrologyError",
    "Plot",
    "Plots",
    "Quantity",
    "Results",
    "Rig",
    "Run",
    "__version__",
    "diagnose",
    "identify",
    "load",
    "run",
    "simulate",
]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'metrology' has no attribute '{name}'")
    found = getattr(import_module(_HOMES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
