"""Specimens of one test that do not fit with the others."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import sqrt

import numpy as np

from metrology.check import Check
from metrology.message import said

Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Estimates = Mapping[str, Mapping[str, float]]
"""By specimen and quantity."""

OUTLIER = "outlying specimen"


def outlier(
    names: Sequence[str],
    built: tuple[Estimates, Estimates],
    quantities: Collection[str],
    significance: float,
    effects: tuple[str, ...] | None = None,
) -> Check:
    """Check whether every specimen fits with the others.

    Parameters
    ----------
    names : sequence of str
        The specimens.
    built : tuple of mapping
        Their estimates, and standard uncertainties of these by the record alone.
    quantities : collection of str
        What is compared.
    significance : float
        Probability to find one where all are alike, for each quantity.
    effects : tuple of str, optional
        Effects that would explain it.

    Returns
    -------
    Check
        Not made for fewer than three specimens.
    """
    if len(names) < 3:
        sentence = said("Not made: {count} specimens; it takes three.", count=len(names))
        return Check(OUTLIER, None, None, None, sentence)
    named = off(names, built, quantities, significance)
    if not named:
        return Check(OUTLIER, None, None, True, said("No specimen lies off the others beyond their scatter."))
    sentence = said(
        "{found}. Look at its record and its section; leave it out by 'exclusions' where there is a reason.",
        found=tuple(said("{name}: {fault}", name=name, fault=why) for name, why in named.items()),
    )
    return Check(OUTLIER, None, None, False, sentence, effects=effects)


def off(
    names: Sequence[str], built: tuple[Estimates, Estimates], quantities: Collection[str], significance: float
) -> dict[str, str]:
    """Each specimen that does not fit, with what does not.

    Parameters
    ----------
    names, built, quantities, significance
        As for `outlier`.

    Returns
    -------
    dict of str to str
        Empty where all fit.
    """
    found: dict[str, str] = {}
    estimates, within = built
    for quantity in quantities:
        rows = [one for one in names if quantity in estimates.get(one, {})]
        values = np.array([estimates[one][quantity] for one in rows])
        u = np.array([within[one][quantity] for one in rows])
        for at, t, p in outlying(values, u, significance):
            name, others = rows[at], float(np.delete(values, at).mean())
            above = "{quantity} is {off:.2g} % above the others (p = {p:.2g})"
            text = above if t > 0 else "{quantity} is {off:.2g} % below the others (p = {p:.2g})"
            words = said(text, quantity=quantity, off=abs(100 * (float(values[at]) / others - 1)), p=float(p))
            found[name] = said("{texts:comma}", texts=(found[name], words)) if name in found else words
    return found


def outlying(values: Array, u: Array, significance: float) -> Iterator[tuple[int, float, float]]:
    """Values that do not fit with the others.

    Parameters
    ----------
    values, u : ndarray, shape (m,)
        In one unit; u of each by itself.
    significance : float
        Probability to find one where all are alike, for each quantity.

    Yields
    ------
    tuple of int, float and float
        Number, statistic and p.

    Notes
    -----
    t = (x − mean of the others)/√(s²·(1 + 1/(m − 1)) + u²), s the scatter of the others and u of the value itself;
    Student's with m − 2 degrees of freedom, all values looked at (Grubbs, Technometrics 11 (1969) 1).
    """
    from scipy.special import stdtr

    m = len(values)
    if m < 3:
        return
    for at in range(m):
        others = np.delete(values, at)
        within = np.delete(u, at)
        s2 = max(float(others.var(ddof=1)), float(np.mean(within**2)))
        t = float((values[at] - others.mean()) / max(sqrt(s2 * (1 + 1 / (m - 1)) + u[at] ** 2), 1e-300))
        p = min(1.0, 2 * m * float(stdtr(m - 2, -abs(t))))
        if p < significance:
            yield at, t, p
