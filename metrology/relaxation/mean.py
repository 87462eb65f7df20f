"""Branches of a relaxation test as means over its specimens."""

from __future__ import annotations

import numpy as np

from metrology.relaxation.finding import RelaxationFinding

FASTEST = 20.0
"""A branch is looked for down to a ramp over this."""
NORMAL = 2.0
"""Coverage factor of what is compared: u is half of the expanded uncertainty."""


def resolved(finding: RelaxationFinding) -> tuple[float, float]:
    """Shortest and longest relaxation time / s that the records of all specimens resolve."""
    ramp = max(one.ramp for one in finding.specimens)
    return ramp / FASTEST, min(max(one.holds, default=0.0) for one in finding.specimens)


def mean(finding: RelaxationFinding) -> list[tuple[float, float, float, float]]:
    """Time / s and part of what faster branches leave, each with half of its expanded uncertainty, fastest first.

    Means of ln τ and of the parts over the specimens; the larger of what the records say and of the scatter between
    specimens, by Student's distribution with their number less one.
    """
    from scipy.special import stdtrit

    m = len(finding.specimens)
    found = []
    for each in zip(*(one.branches for one in finding.specimens), strict=False):
        logs = np.log([[one.low, one.time, one.high] for one in each])
        halves = np.array([(logs[:, 2] - logs[:, 0]) / 2, [NORMAL * one.left_u for one in each]])
        values = np.array([logs[:, 1], [one.left for one in each]])
        u2 = (halves**2).sum(axis=1) / m**2
        if m > 1:
            reach = float(stdtrit(m - 1, 0.975))
            u2 = np.maximum(u2, values.var(axis=1, ddof=1) / m * reach**2)
        (log, left), (log_u, left_u) = values.mean(axis=1).tolist(), (np.sqrt(u2) / NORMAL).tolist()
        time = float(np.exp(log))
        found.append((time, time * log_u, left, left_u))
    return found
