"""What an effect that was found in a tension test does to the results of the test."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis
    from metrology.diagnostics.subject import Array
    from metrology.diagnostics.tension import Tension

PROPORTIONAL = 1e-6
"""Part of what an effect does up to which it is in proportion to the force: what is more is no rounding."""


def concerns_stiffness(subject: Tension, found: Diagnosis) -> bool:
    """Whether an effect that was found acts on the readings from which the stiffness follows.

    Parameters
    ----------
    subject : Tension
        The test.
    found : Diagnosis
        Of it.

    Returns
    -------
    bool
        True where the stated lines are to be corrected.
    """
    kind = 0.0 if subject.strain else 1.0
    return any(np.any(one[subject.records[at].seen.crosshead == kind]) for at, one in _acting(subject, found))


def concerns_compliance(subject: Tension, found: Diagnosis) -> bool:
    """Whether one that was found parts crosshead and extensometer otherwise than a compliance of the set-up does.

    Parameters
    ----------
    subject : Tension
        The test.
    found : Diagnosis
        Of it.

    Returns
    -------
    bool
        True where the line of their difference over the force is not that of a compliance.
    """
    for at, one in _acting(subject, found) if subject.strain and subject.crosshead else ():
        seen = subject.records[at].seen
        moved, stretched = (seen.crosshead == kind for kind in (1.0, 0.0))
        apart = one[moved] - one[stretched]
        line = np.column_stack([np.ones(len(apart)), seen.force[moved]])
        left = apart - line @ np.linalg.lstsq(line, apart)[0]
        if np.abs(left).max() > PROPORTIONAL * np.abs(apart).max():
            return True
    return False


def _acting(subject: Tension, found: Diagnosis) -> Iterator[tuple[int, Array]]:
    """Record, and what one unit of an effect that was found does to its readings."""
    named = [one.effect for one in found.causes if one.verdict in ("supported", "indistinguishable")]
    shapes = {size.name: size.null for name in named for size in subject.candidates[name].parameters}
    for name in named:
        for at in range(len(subject.records)):
            yield at, subject.column(name, at, {**shapes, **found.extended_model})
