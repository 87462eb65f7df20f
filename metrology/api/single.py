"""One test on arrays: what it gives, and what its model lacks, without a campaign around it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    from metrology.api.results import Results

Progress = Callable[[str], None]
Stated = Mapping[str, Any]


def identify(
    method: str,
    *,
    sample: Stated | None = None,
    instruments: Stated | None = None,
    progress: Progress | None = None,
    **test: Any,
) -> Results:
    """Estimate what one test gives by its model as stated, such as k and c with their standard uncertainties.

    Parameters
    ----------
    method : str
        ``decay``, ``elongation``, ``relaxation``, ``response`` or ``tension``.
    sample : mapping, optional
        What the campaign file says of a sample: ``{"length": "2.000(1) m", "section": {...}}``.
    instruments : mapping, optional
        What reads what, by the names of ``instruments`` of the test: ``{"extension": {"resolution": "0.01 mm"}}``.
    progress : callable, optional
        Takes what is being done, in a few words.
    **test
        What the campaign file says of a test of this method (``docs/campaign.md``): quantities are texts with unit and
        uncertainty, readings are tables: a DataFrame of pandas, a Dataset of xarray, or a mapping of columns of shape
        (n,), each by its heading with its unit, ``{"time / s": t, "displacement / mm": x}``; NaN is a gap.

    Returns
    -------
    Results
        With the quantities of the test alone: ``results.k``. The model is not diagnosed: `diagnose` does that.

    Raises
    ------
    MetrologyError
        With every fault of what is stated and of the arrays, each by its name and index.

    Examples
    --------
    >>> import numpy as np
    >>> readings = np.array([0.41, 0.79, 1.20, 0.40, 0.81, 1.19])
    >>> read = {"load": [*"ABCABC"], "repeat": [1, 1, 1, 2, 2, 2], "reading / mm": readings}
    >>> loads = {"A": {"force": "10.0(1) N"}, "B": {"force": "20.0(1) N"}, "C": {"force": "30.0(1) N"}}
    >>> gauge = {"extension": {"resolution": "0.01 mm"}}
    >>> print(identify("elongation", loads=loads, readings=read, instruments=gauge).k)
    25330 ± 650 N/m
    """
    return _run(method, test, (sample, instruments), progress=progress, diagnosis={"off": True})


def diagnose(
    method: str,
    *,
    sample: Stated | None = None,
    instruments: Stated | None = None,
    progress: Progress | None = None,
    **test: Any,
) -> Results:
    """Find what the model of one test lacks, and estimate what it gives by the model that the data support.

    Parameters, errors and results as for `identify`; ``results.diagnosis[0]`` is the diagnosis: its ``verdict`` and
    ``sentence``, and ``causes``, each with verdict, probability and size. Where an effect is supported by the data, the
    results are those of the extended model, and ``results.k.result.stated`` those of the model as stated.

    Parameters
    ----------
    method : str
        As for `identify`.
    sample, instruments : mapping, optional
        As for `identify`.
    progress : callable, optional
        Takes what is being done, in a few words; a diagnosis of response runs takes minutes.
    **test
        As for `identify`.

    Returns
    -------
    Results
        By the model that the data support.

    Raises
    ------
    MetrologyError
        As for `identify`.
    """
    return _run(method, test, (sample, instruments), progress=progress, diagnosis={})


def _run(
    method: str, test: Stated, of: tuple[Stated | None, Stated | None], *, progress: Progress | None, diagnosis: Stated
) -> Results:
    """Evaluate a campaign of one test, which is called as its method."""
    from metrology.api.running import run
    from metrology.methods import METHODS

    if method not in METHODS:
        raise MetrologyError(Fault("method", repr(method), f"one of {', '.join(METHODS)}"))
    faults = [
        Fault(f"{method}.{name}", f"{value!r:.60}", "a dictionary, as a campaign file has it")
        for name, value in zip(("sample", "instruments"), of, strict=True)
        if value is not None and not isinstance(value, Mapping)
    ]
    if faults:
        raise MetrologyError(*faults)
    sample, instruments = of
    stated = {
        "format": "metrology-campaign/1",
        "id": method,
        "title": METHODS[method].title,
        "instruments": {role: {"kind": role, **entry} for role, entry in (instruments or {}).items()},
        "samples": {"sample": dict(sample or {})},
        "tests": {
            method: {
                "method": method,
                "sample": "sample",
                "instruments": {role: role for role in instruments or {}},
                **test,
            }
        },
        "diagnosis": diagnosis,
    }
    return run(stated, progress=progress, coverage=False)
