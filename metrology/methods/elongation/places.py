"""Places on the scale of an instrument that several tests read: its error at one of them is one and the same."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from metrology.methods.elongation.schema import ElongationTest

if TYPE_CHECKING:
    from metrology.declaration.columns import Table
    from metrology.declaration.identity import Instrument
    from metrology.method.declared import Declared


def places(campaign: Declared, name: str) -> dict[str, str]:
    """For each load of a test, what stands for the place at which its indicator is read.

    Two tests read it at one place where their mean readings differ by less than half of the distance to the next load.
    Which error a certificate leaves at two places that are farther apart is not known to be the same: they are
    independent (JCGM 100:2008 F.1.2.3).

    Parameters
    ----------
    campaign : Declared
        With the readings of its tests.
    name : str
        The test.

    Returns
    -------
    dict of str to str
        By name of the load; the same text in every test that reads the indicator there.
    """
    own = campaign.tests[name]
    assert isinstance(own, ElongationTest)
    indicator = own.instruments.extension
    known: dict[str, float] = {}
    found: dict[str, str] = {}
    for other, test in campaign.tests.items():
        if not isinstance(test, ElongationTest) or test.instruments.extension != indicator:
            continue
        (table,) = campaign.tables["tests", other]
        means = _means(table)
        reach = 0.5 * float(np.diff(np.sort(list(means.values()))).min(initial=np.inf))
        found, free = {}, dict(known)
        for load, mean in means.items():
            near = min(free, key=lambda place: abs(known[place] - mean), default=None)
            if near is None or abs(known[near] - mean) >= reach:
                near = at(indicator, campaign.instruments[indicator], f"{mean:.6g} m")
                known[near] = mean
            free.pop(near, None)
            found[load] = near
        if other == name:
            return found
    return found


def at(name: str, instrument: Instrument, place: str) -> str:
    """Words for an instrument, by its certificate where it has one, at a place of its scale."""
    certificate = instrument.certificate.number if instrument.certificate else ""
    return f"{name}{f' ({certificate})' if certificate else ''} at {place}"


def _means(table: Table) -> dict[str, float]:
    readings: dict[str, list[float]] = {}
    for load, value in zip(table.texts["load"], table.numbers["reading"].tolist(), strict=True):
        readings.setdefault(load, []).append(value)
    return {load: float(np.mean(values)) for load, values in readings.items()}
