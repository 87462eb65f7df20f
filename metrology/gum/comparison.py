"""Comparison of two results, or of a result and a reference value, by the normalised error E_n."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

from metrology.errors import Fault, MetrologyError
from metrology.message import said


@dataclass(frozen=True)
class Agreement:
    """Two values with uncertainties, set against each other.

    Parameters
    ----------
    difference, u_difference : float
        a − b with its standard uncertainty.
    en : float
        E_n; None where neither value carries an uncertainty that the other does not share.
    agrees : bool
        |E_n| ≤ 1; None where E_n is undefined.
    sentence : str
    """

    difference: float
    u_difference: float
    en: float | None
    agrees: bool | None
    sentence: str


def en(
    value_a: float,
    u_a: float,
    value_b: float,
    u_b: float,
    *,
    correlation: float = 0.0,
    k: float | tuple[float, float] = 2.0,
) -> Agreement:
    """Normalised error E_n = (a − b) / √(U_a² + U_b² − 2·r·U_a·U_b) with U = k·u; the two agree where |E_n| ≤ 1.

    Parameters
    ----------
    value_a, u_a, value_b, u_b : float
        Values with standard uncertainties.
    correlation : float
        Correlation coefficient r between the two values.
    k : float or tuple of float
        Coverage factor of the expanded uncertainties: one for both (2 by convention), or that of each at the stated
        coverage probability.

    Returns
    -------
    Agreement
        Difference, its u and E_n, with whether they agree.

    Raises
    ------
    MetrologyError
        For numbers that are not finite, u < 0, |r| > 1, k ≤ 0.

    Notes
    -----
    ISO/IEC 17043:2010 B.3.1.3 e); ISO 13528:2015 9.7; with the covariance, JCGM 100:2008 5.2.2.

    Examples
    --------
    >>> en(24734.25, 335.52, 24400.0, 200.0).agrees
    True
    """
    k_a, k_b = k if isinstance(k, tuple) else (k, k)
    _check({"value_a": value_a, "value_b": value_b}, {"u_a": u_a, "u_b": u_b}, correlation, (k_a, k_b))
    difference = value_a - value_b
    u = _combined(u_a, u_b, correlation)
    expanded = _combined(k_a * u_a, k_b * u_b, correlation)
    if expanded == 0:
        equal = "E_n is undefined: no uncertainty stands against the difference; the values are equal."
        apart = "E_n is undefined: no uncertainty stands against the difference; the values are {apart:.6g} apart."
        sentence = said(equal if difference == 0 else apart, apart=float(abs(difference)))
        return Agreement(difference, u, None, None, sentence)
    ratio = difference / expanded
    agrees = abs(ratio) <= 1
    basis = said("k = {a:g}" if k_a == k_b else "k = {a:.3g} and {b:.3g}", a=float(k_a), b=float(k_b))
    if correlation:
        text = "{basis}, correlation {correlation:.2f} taken into account"
        basis = said(text, basis=basis, correlation=float(correlation))
    places = 2 if abs(ratio) < 10 else 0
    agree = "The two agree within their expanded uncertainties: E_n = {ratio:figures} ({basis})."
    differ = "The two differ by more than their expanded uncertainties: E_n = {ratio:figures} ({basis})."
    sentence = said(agree if agrees else differ, ratio=f"{ratio:.{places}f}", basis=basis)
    return Agreement(difference, u, ratio, agrees, sentence)


def _combined(a: float, b: float, r: float) -> float:
    """√(a² + b² − 2·r·a·b), without cancellation where r is near one."""
    scale = max(a, b)
    if scale == 0:
        return 0.0
    p, q = a / scale, b / scale
    return scale * sqrt((p - q) ** 2 + 2 * (1 - r) * p * q)


def _check(values: dict[str, float], u: dict[str, float], correlation: float, k: tuple[float, float]) -> None:
    faults = [Fault(name, f"{value}", "a finite number") for name, value in values.items() if not isfinite(value)]
    faults += [
        Fault(name, f"{value}", "a standard uncertainty, finite and not below zero")
        for name, value in u.items()
        if not (isfinite(value) and value >= 0)
    ]
    if not -1 <= correlation <= 1:
        faults.append(Fault("correlation", f"{correlation}", "a coefficient from −1 to 1"))
    faults += [
        Fault("k", f"{factor}", "a coverage factor above zero") for factor in k if not (isfinite(factor) and factor > 0)
    ]
    if faults:
        raise MetrologyError(*faults)
