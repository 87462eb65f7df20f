"""Type A evaluation of readings of one quantity, and of several quantities read together (JCGM 100:2008, 4.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import fsum, sqrt

import numpy as np
from numpy.typing import ArrayLike

from metrology.errors import Fault, MetrologyError
from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component, Ensemble, Floats, Input
from metrology.message import said


def mean(readings: ArrayLike) -> float:
    """Arithmetic mean, exact to the last digit also for readings with a large common offset.

    Parameters
    ----------
    readings : array_like, shape (n,)
        At least one, in any unit.

    Returns
    -------
    float
        In the unit of the readings.

    Examples
    --------
    >>> mean([10000001, 10000003, 10000002])
    10000002.0
    """
    values = np.asarray(readings, float)
    return float(values[0]) + fsum(values - values[0]) / values.size


def standard_deviation(readings: ArrayLike) -> float:
    """Experimental standard deviation s with n − 1, of readings centred before their squares are summed.

    Source: JCGM 100:2008 4.2.2; NIST StRD, univariate summary statistics, NumAcc1 to NumAcc4.

    Examples
    --------
    >>> standard_deviation([10000001, 10000003, 10000002])
    1.0
    """
    values = np.asarray(readings, float)
    values = values - values[0]
    values = values - fsum(values) / values.size
    return sqrt(fsum(values**2) / (values.size - 1))


def type_a(name: str, readings: ArrayLike, *, source: str = "") -> Component:
    """Repeatability of the mean of `readings`: u = s/√n with ν = n − 1.

    Parameters
    ----------
    name : str
        Name of the component, such as ``"repeatability"``; it names the entry in an error.
    readings : array_like, shape (n,)
        Independent readings under repeatability conditions, in SI; n ≥ 2.
    source : str
        Where the readings stand.

    Returns
    -------
    Component
        Normal, of type A.

    Raises
    ------
    MetrologyError
        Fewer than two readings, or one that is not a finite number.

    Notes
    -----
    JCGM 100:2008 4.2.3.

    Examples
    --------
    >>> round(type_a("repeatability", [5.007, 4.994, 5.005, 4.990, 4.999]).u, 4)
    0.0032
    """
    values = _checked(name, readings)
    return Component(name, Normal(standard_deviation(values) / sqrt(values.size)), values.size - 1.0, "A", source)


def observed(
    name: str,
    readings: ArrayLike,
    *,
    components: Sequence[Component] = (),
    unit: str = "1",
    description: str = "",
    source: str = "",
) -> Input:
    """Input whose estimate is the mean of readings: their repeatability comes first, then further `components`.

    Parameters
    ----------
    name : str
        Name of the input.
    readings : array_like, shape (n,)
        In SI; n ≥ 2.

    Raises
    ------
    MetrologyError
        As `type_a`.

    Source: JCGM 100:2008 4.2.1, 4.2.3.
    """
    repeatability = type_a(said("repeatability"), _checked(name, readings), source=source)
    return Input(name, mean(readings), (repeatability, *components), unit, description)


def simultaneous(
    name: str, readings: Mapping[str, ArrayLike], *, source: str = ""
) -> tuple[dict[str, float], Ensemble]:
    """Means of several quantities read together, and the ensemble of their common scatter, S/n with ν = n − 1.

    Any linear combination of the means has u and ν as if it had been evaluated from its own n values. (The posterior
    of JCGM 102:2011 5.3.2 has n − m degrees of freedom for m quantities; the ensemble keeps n − 1, as JCGM 100 does.)

    Parameters
    ----------
    name : str
        Name of the set of readings.
    readings : mapping of str to array_like, shape (n,)
        By name of the input, one value for each of the n ≥ 2 occasions, in SI.
    source : str
        Where the readings stand.

    Returns
    -------
    tuple of dict and Ensemble
        Means by name, in SI, and their common scatter.

    Raises
    ------
    MetrologyError
        Series of different length, fewer than two readings, or one that is not a finite number.

    Notes
    -----
    JCGM 100:2008 5.2.3, H.2.

    Examples
    --------
    >>> means, ensemble = simultaneous("ring", {"V": [5.007, 4.994, 5.005], "I": [19.663, 19.639, 19.640]})
    >>> round(means["V"], 3), ensemble.dof
    (5.002, 2.0)
    """
    series = {member: _checked(f"{name}.{member}", values) for member, values in readings.items()}
    lengths = {member: values.size for member, values in series.items()}
    if len(set(lengths.values())) != 1:
        got = f"series of different length {lengths}"
        raise MetrologyError(Fault(name, got, "one reading of each for every occasion"))
    centred = np.array([values - mean(values) for values in series.values()])
    n = centred.shape[1]
    covariance = centred @ centred.T / (n * (n - 1))
    covariance.flags.writeable = False
    return {member: mean(values) for member, values in series.items()}, Ensemble(
        name, tuple(series), covariance, n - 1.0, source
    )


def _checked(name: str, readings: ArrayLike) -> Floats:
    values = np.asarray(readings, float)
    if values.ndim != 1 or values.size < 2:
        raise MetrologyError(
            Fault(name, f"{values.size} reading{'' if values.size == 1 else 's'}", "at least two readings")
        )
    faults = [
        Fault(f"{name}[{index}]", repr(float(values[index])), "a finite number")
        for index in np.flatnonzero(~np.isfinite(values))
    ]
    if faults:
        raise MetrologyError(*faults)
    return values
